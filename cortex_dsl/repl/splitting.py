"""A text as entries: one for each statement of its top level, with the comments above it."""

import re
from collections.abc import Iterator
from functools import lru_cache
from itertools import pairwise

from cortex_dsl.diagnostics import CompileError
from cortex_dsl.semantics.names.tree import everything_in
from cortex_dsl.source import Source
from cortex_dsl.syntax import nodes, parse

Key = tuple[str, str]
MOST_ENTRIES = 1 << 15
"""Entries whose keys are kept: more than a draft of the largest size has, or else each entry would read all others."""
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


# -- what an entry defines --------------------------------------------------------------------------------------------


@lru_cache(maxsize=MOST_ENTRIES)
def keys(entry: str) -> frozenset[Key]:
    """What an entry defines, so that another one that defines the same stands for it; nothing where it only adds."""
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
        case nodes.Map() | nodes.TerminateAfter() | nodes.Simulation() | nodes.Signals():
            yield type(statement).__name__, ""
        case nodes.Require(name=str(name)):
            yield "require", name
        case nodes.Require() | nodes.RequireMonitor() | nodes.TerminateWhen() | nodes.Record():
            yield "text", " ".join(source.slice(statement.span).split())


def called(key: Key) -> str:
    """A key as people know it."""
    words = {
        "Map": "`map`",
        "TerminateAfter": "`terminate after`",
        "Simulation": "`simulation`",
        "Signals": "`signals`",
    }
    kind, name = key
    return f"`{name}`" if name else words.get(kind, f"the {kind}")
