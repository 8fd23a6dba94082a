"""Completions for the words after a command: a row of the table of commands names the kind of each word."""

import shlex
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from prompt_toolkit.completion import CompleteEvent, Completion, PathCompleter
from prompt_toolkit.document import Document

from cortex_dsl.console.user_files import is_folder
from cortex_dsl.editor.analysis import Analysis, View
from cortex_dsl.editor.completion import complete
from cortex_dsl.editor.fitting import Candidate
from cortex_dsl.editor.lexer import word_before
from cortex_dsl.repl.chunks import parted
from cortex_dsl.repl.commands import COMMANDS
from cortex_dsl.repl.state import State

Offer = tuple[str, str]
"""A word, and its description."""


def of_command(state: State, analysis: Analysis, text: str, event: CompleteEvent) -> Iterator[Completion]:
    """Complete a line after its colon: the name of the command, or its present word; `analysis`: of the draft."""
    name, blank, rest = text.partition(" ")
    if not blank:
        yield from _named(name, ((row.name, row.summary) for row in COMMANDS.values()))
        return
    row = COMMANDS.get(name.removesuffix("!"))
    if row is None or not row.completes:
        return
    *before, word = rest.lstrip().split(" ", len(row.completes) - 1) if rest.strip() else [""]
    kind = row.completes[min(len(before), len(row.completes) - 1)]
    if kind in PATHS:
        yield from PathCompleter(expanduser=True, file_filter=PATHS[kind]).get_completions(Document(word), event)
    elif kind == "value":
        yield from _values(state, analysis, word)
    elif kind == "aim":
        yield from _aims(state, word)
    else:
        yield from _named(word.rpartition(",")[2] if kind == "format" else word, KINDS[kind](state))


def _named(begun: str, offers: Iterator[Offer]) -> Iterator[Completion]:
    for word, meta in offers:
        if word.lower().startswith(begun.lower()):
            yield Completion(word, -len(begun), display_meta=meta)


# -- an expression -----------------------------------------------------------------------------------------------------

ASKING = ("maximize ", "expect ")
"""Statements of numbers and of truths; the beginning of both can be plotted."""


def _values(state: State, analysis: Analysis, argument: str) -> Iterator[Completion]:
    """Yield continuations of the last expression."""
    part = parted(argument)[-1] + (" " if argument.endswith(" ") else "")
    word = word_before(part, len(part))
    found: dict[str, Candidate] = {}
    for asking in ASKING:
        text = f"{state.draft.text}{asking}{part}"
        for each in complete(View(state.name, text, analysis), len(text)):
            best = found.setdefault(each.label, each)
            found[each.label] = min(best, each, key=lambda c: c.rank)
    for each in sorted(found.values(), key=lambda c: (c.rank, c.label.lower())):
        if each.label.lower().startswith(word.lower()):
            yield Completion(each.label, -len(word), display_meta=each.detail or each.kind)


# -- objectives of a search --------------------------------------------------------------------------------------------


def _aims(state: State, argument: str) -> Iterator[Completion]:
    """Yield the flag, and after it a name of an objective."""
    before, _, word = argument.rpartition(" ")
    if not before.endswith("--objective"):
        yield from _named(word, iter([("--objective", "objective of the search, instead of the risk")]))
        return
    from engine.search.objectives import BUILT_IN, of_file

    compiled = state.checked.compiled
    rows = (*BUILT_IN, *(() if compiled is None else of_file(compiled.program)))
    yield from _named(word, ((shlex.quote(row.name), row.sentence) for row in rows))


# -- words of a kind ---------------------------------------------------------------------------------------------------


def _params(state: State) -> Iterator[Offer]:
    program = state.checked.weighable
    yield from ((name, "param") for name in (() if program is None else program.space.names))


def _codes(_state: State) -> Iterator[Offer]:
    from cortex_dsl.codes import entries

    yield from ((entry.code, entry.title) for entry in entries())


def _commands(_state: State) -> Iterator[Offer]:
    yield from ((row.name, row.summary) for row in COMMANDS.values())


def _names(state: State) -> Iterator[Offer]:
    from cortex_dsl.repl.commands_info import known

    yield from ((name, "") for name in dict.fromkeys(known(state)))


def _entries(state: State) -> Iterator[Offer]:
    for number, entry in enumerate(state.draft.entries, start=1):
        yield str(number), entry.strip().split("\n")[0]


def _cases(state: State) -> Iterator[Offer]:
    for case in () if state.found is None else state.found.campaign.worst:
        yield str(case.rank), f"risk {case.score}"


def _formats(_state: State) -> Iterator[Offer]:
    from cortex_dsl.interchange.formats import FORMATS

    yield from ((name, row.summary) for name, row in FORMATS.items())


def _paces(_state: State) -> Iterator[Offer]:
    yield from ((pace, "as fast as it happens") for pace in ("0.25x", "0.5x", "1x", "2x", "4x"))


KINDS: Mapping[str, Callable[[State], Iterator[Offer]]] = {
    "param": _params,
    "code": _codes,
    "command": _commands,
    "name": _names,
    "entry": _entries,
    "case": _cases,
    "format": _formats,
    "pace": _paces,
}


def _is_scenario(name: str) -> bool:
    path = Path(name)
    return path.suffix in (".scn", ".scenic") or is_folder(path)


PATHS: Mapping[str, Callable[[str], bool]] = {"file": _is_scenario, "path": lambda _name: True}
