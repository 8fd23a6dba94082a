"""The entered scenario, and its history.

It is a sequence of entries, one for each statement of the top level with the comments above it. A new entry replaces
the entry with the same definition, else it goes to the end.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import accumulate, pairwise

from cortex_dsl.diagnostics import CompileError
from cortex_dsl.semantics.names.tree import everything_in
from cortex_dsl.source import Source
from cortex_dsl.syntax import nodes, parse


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
        """Return the history with another draft; undone drafts are discarded."""
        return self if draft == self.present else History(draft, (*self.past, self.present))

    def undone(self) -> "History | None":
        if not self.past:
            return None
        return replace(self, present=self.past[-1], past=self.past[:-1], future=(self.present, *self.future))

    def redone(self) -> "History | None":
        if not self.future:
            return None
        return replace(self, present=self.future[0], past=(*self.past, self.present), future=self.future[1:])


# -- a text as entries -------------------------------------------------------------------------------------------------

Key = tuple[str, str]
MOST_ENTRIES = 1 << 15
"""Maximum number of entries with stored keys: more than a draft of the largest size has; without them each entry would
read all others."""
_DOCSTRING = re.compile(r"(?:[ \t]*(?:#[^\n]*)?\n)*[ \t]*")
_COMMENTS = re.compile(r"(?:[ \t]*(?:#[^\n]*)?\n)+")


def split(source: Source, module: nodes.Module) -> tuple[str, ...]:
    """The entries of a text; joined they are that text again, but for line breaks at its end."""
    lines = source.text.rstrip("\n").split("\n")
    ends = sorted(dict.fromkeys((0, *_ends(source, module))))
    if len(ends) == 1:
        return ("\n".join(lines),) if source.text.strip() else ()
    ends[-1] = len(lines)
    return tuple("\n".join(lines[start:end]) for start, end in pairwise(ends))


def _ends(source: Source, module: nodes.Module) -> Iterator[int]:
    """The last lines of the docstring and of all statements."""
    if module.docstring is not None:
        yield _docstring_end(source)
    for statement in module.statements:
        yield source.row(max(statement.span.start, statement.span.end - 1))


def _docstring_end(source: Source) -> int:
    start = _blank(source.text)
    quotes = source.text[start : start + 3]
    quotes = quotes if quotes in ('"""', "'''") else quotes[:1]
    end = source.text.find(quotes, start + len(quotes))
    return source.row(end if end >= 0 else start)


def _blank(text: str) -> int:
    """Characters of blank lines and comments at the beginning of a text."""
    found = _DOCSTRING.match(text)
    return found.end() if found else 0


def comments_above(entry: str) -> str:
    """The comments and blank lines with which an entry begins."""
    found = _COMMENTS.match(entry)
    return found.group() if found else ""


# -- definitions of an entry ------------------------------------------------------------------------------------------


@lru_cache(maxsize=MOST_ENTRIES)
def keys(entry: str) -> frozenset[Key]:
    """Return the keys of the definitions in an entry; empty if it only adds. An entry with the same key replaces it."""
    source = Source("", entry + "\n")
    try:
        module = parse(source)
    except CompileError:
        return frozenset()
    if module.docstring is not None and not module.statements:
        return frozenset({("docstring", "")})
    return frozenset(key for statement in module.statements for key in _keys(statement, source))


def _keys(statement: nodes.Statement, source: Source) -> Iterator[Key]:
    match statement:
        case nodes.Param(entries=entries):
            yield from (("name", entry.name) for entry in entries)
        case nodes.Assign(targets=targets, value=value):
            used = {node.id for node in everything_in(value) if isinstance(node, nodes.Name)}
            yield from (("name", target) for target in targets if target not in used)
        case nodes.BehaviorDefinition(name=name) | nodes.MonitorDefinition(name=name):
            yield "name", name
        case nodes.ScenarioDefinition(name=name) | nodes.ClassDefinition(name=name):
            yield "name", name
        case nodes.Map() | nodes.TerminateAfter() | nodes.Simulation() | nodes.Signals() | nodes.Environment():
            yield type(statement).__name__, ""
        case nodes.Require(name=str(name)):
            yield "require", name
        case nodes.Domain(name=name):
            yield "domain", name
        case nodes.Expect(name=str(name)) | nodes.Optimize(name=str(name)):
            yield "objective", name
        case (
            nodes.Require()
            | nodes.RequireMonitor()
            | nodes.TerminateWhen()
            | nodes.Record()
            | nodes.Expect()
            | nodes.Optimize()
        ):
            yield "text", source.words(statement.span)


def called(key: Key) -> str:
    """A key as people know it."""
    words = {
        "Map": "`map`",
        "TerminateAfter": "`terminate after`",
        "Simulation": "`simulation`",
        "Signals": "`signals`",
        "Environment": "`environment`",
    }
    kind, name = key
    return f"`{name}`" if name else words.get(kind, f"the {kind}")


# -- where an entry goes -----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Placed:
    """A draft with an entry in it."""

    draft: Draft
    index: int
    """Index of the entry in the draft."""
    replaced: str = ""
    """Name of the replaced definition in messages; "" if none."""


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
    """Put an entry that replaces nothing at the end; a docstring first, the environment above all objects."""
    at, own = len(draft.entries), keys(entry)
    if ("docstring", "") in own:
        at = 0
    elif ("Environment", "") in own:
        at = next((index for index, each in enumerate(draft.entries) if _makes_objects(each)), at)
    return Placed(draft.with_entry(entry, at), at)


def _makes_objects(entry: str) -> bool:
    try:
        module = parse(Source("", entry + "\n"))
    except CompileError:
        return False
    return any(isinstance(node, nodes.New) for statement in module.statements for node in everything_in(statement))


def place_last(draft: Draft, entry: str) -> Placed | None:
    """Place the entry at the end, since it may use definitions below its old place; None if it replaces nothing."""
    found = _same(draft, keys(entry))
    if found is None:
        return None
    index, key = found
    return Placed(draft.without(index).with_entry(entry), len(draft.entries) - 1, called(key))


def place_with_sources(draft: Draft, entry: str) -> Placed | None:
    """Place the entry at its old place, below the entries that define the names it reads.

    These move up from further down. None if the entry replaces nothing or reads nothing from there.
    """
    found = _same(draft, keys(entry))
    if found is None:
        return None
    index, key = found
    needed, moved = names_in(entry), list[str]()
    for each in reversed(draft.entries[index + 1 :]):
        if {name for kind, name in keys(each) if kind == "name"} & needed:
            moved.insert(0, each)
            needed |= names_in(each)
    if not moved:
        return None
    below = (each for each in draft.entries[index + 1 :] if each not in moved)
    return Placed(Draft((*draft.entries[:index], *moved, entry, *below)), index + len(moved), called(key))


def names_in(entry: str) -> set[str]:
    """Return the names that an entry reads."""
    module = parse(Source("", entry + "\n"))
    every = (node for statement in module.statements for node in everything_in(statement))
    return {node.id for node in every if isinstance(node, nodes.Name)}


def _same(draft: Draft, new: frozenset[Key]) -> tuple[int, Key] | None:
    """Return the first entry with no definitions except those of the new one."""
    for index, entry in enumerate(draft.entries):
        old = keys(entry)
        if old and old <= new:
            return index, min(old)
    return None
