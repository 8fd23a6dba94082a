"""The scenario as far as it has been entered, and what it was before."""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import accumulate


@dataclass(frozen=True)
class Draft:
    """Entries, each a stretch of whole lines; joined by line breaks they are the scenario."""

    entries: tuple[str, ...] = ()

    @cached_property
    def text(self) -> str:
        return "".join(entry + "\n" for entry in self.entries)

    @cached_property
    def first_lines(self) -> tuple[int, ...]:
        """Line of the text, from 1, that each entry begins in; at last the line after the end."""
        return tuple(accumulate((entry.count("\n") + 1 for entry in self.entries), initial=1))

    def with_entry(self, entry: str, at: int | None = None) -> "Draft":
        """One entry more, by default at the end."""
        place = len(self.entries) if at is None else at
        return Draft((*self.entries[:place], entry, *self.entries[place:]))

    def replaced(self, index: int, entry: str) -> "Draft":
        return Draft((*self.entries[:index], entry, *self.entries[index + 1 :]))

    def without(self, index: int) -> "Draft":
        return Draft((*self.entries[:index], *self.entries[index + 1 :]))


@dataclass(frozen=True)
class History:
    """The draft, those before it and those that were taken back."""

    present: Draft = Draft()
    past: tuple[Draft, ...] = ()
    future: tuple[Draft, ...] = ()

    def step(self, draft: Draft) -> "History":
        """The draft becomes another one; what had been taken back is gone."""
        return self if draft == self.present else History(draft, (*self.past, self.present))

    def undone(self) -> "History | None":
        if not self.past:
            return None
        return replace(self, present=self.past[-1], past=self.past[:-1], future=(self.present, *self.future))

    def redone(self) -> "History | None":
        if not self.future:
            return None
        return replace(self, present=self.future[0], past=(*self.past, self.present), future=self.future[1:])
