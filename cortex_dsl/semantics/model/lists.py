"""Lists that remember how they came about: what a condition chose them from, and which name `append` renews."""

from typing import Self

from cortex_dsl.semantics.model.values import Value


class Kept(tuple[Value, ...]):
    """What a condition kept of a list, which is `among`; empty for a list that no condition chose."""

    among: tuple[Value, ...] = ()

    def of(self, among: tuple[Value, ...]) -> Self:
        self.among = among
        return self


class Items(Kept):
    """A list of the file: unlike a tuple it is told from another of the same items, so that `append` finds it."""
