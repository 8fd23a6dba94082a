"""Lists with their origin: the items that a condition filtered, and the name that `append` renews."""

from typing import Self

from cortex_dsl.semantics.model.values import Value


class Kept(tuple[Value, ...]):
    """Items that a condition selected of `among`; `among` is empty for a list without a condition."""

    among: tuple[Value, ...] = ()

    def of(self, among: tuple[Value, ...]) -> Self:
        self.among = among
        return self


class Items(Kept):
    """A list of the file. Unlike tuples, lists with equal items are distinct, so that `append` finds its list."""
