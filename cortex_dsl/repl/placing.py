"""Where an entry goes: into the place of what it defines anew, else to the end."""

from dataclasses import dataclass

from cortex_dsl.repl.draft import Draft
from cortex_dsl.repl.splitting import Key, called, comments_above, keys


@dataclass(frozen=True)
class Placed:
    """A draft with an entry in it."""

    draft: Draft
    index: int
    """Where the entry is."""
    replaced: str = ""
    """What it stands for from now on, as people call it."""


def place(draft: Draft, entry: str) -> Placed:
    """Put an entry where it belongs."""
    found = _same(draft, keys(entry))
    if found is None:
        return place_new(draft, entry)
    index, key = found
    old = draft.entries[index]
    above = "" if comments_above(entry).strip() else comments_above(old)
    return Placed(draft.replaced(index, above + entry.lstrip("\n")), index, called(key))


def place_new(draft: Draft, entry: str) -> Placed:
    """Put an entry that replaces nothing at the end; a docstring at the beginning."""
    at = 0 if ("docstring", "") in keys(entry) else len(draft.entries)
    return Placed(draft.with_entry(entry, at), at)


def place_last(draft: Draft, entry: str) -> Placed | None:
    """The same at the end, since it may use what is defined only below its old place; None if it replaces nothing."""
    found = _same(draft, keys(entry))
    if found is None:
        return None
    index, key = found
    return Placed(draft.without(index).with_entry(entry), len(draft.entries) - 1, called(key))


def _same(draft: Draft, new: frozenset[Key]) -> tuple[int, Key] | None:
    """The first entry that defines nothing but what the new one does."""
    for index, entry in enumerate(draft.entries):
        old = keys(entry)
        if old and old <= new:
            return index, min(old)
    return None
