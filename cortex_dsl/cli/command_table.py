"""The table of commands, and the command lines that users of other tools guess.

A *mode* is the effect of a flag of `cortexc FILE`: a function of a request and the terminal. A *subcommand* is a first
word (`cortexc NAME ...`): a function that returns a `Command`. Each row is a function that imports what it needs when
it is called, so that a command loads its own modules only.
"""

import os
import shlex
from argparse import Namespace
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

from cortex_dsl.cli.file_options import DESCRIPTION, EXAMPLES, OPTIONS, WHERE_TO_READ, to_request
from cortex_dsl.console.command import Command, TwoColumns, run_command
from cortex_dsl.console.request import Mode, Request
from cortex_dsl.console.terminal import Terminal, UsageError
from cortex_dsl.spelling import nearest
from engine.frozen import frozen

# -- modes of `cortexc FILE` -------------------------------------------------------------------------------------------


def _run(request: Request, terminal: Terminal) -> int:
    from cortex_dsl.cli.draw_modes import run_once

    return run_once(request.compile, request.run, terminal)


def _search(request: Request, terminal: Terminal) -> int:
    from cortex_dsl.cli.search import search

    return search(request.compile, request.run, request.search, terminal)


def _sample(request: Request, terminal: Terminal) -> int:
    from cortex_dsl.cli.draw_modes import sample_scenes

    return sample_scenes(request.compile, request.run, request.samples, terminal)


def _check(request: Request, terminal: Terminal) -> int:
    from cortex_dsl.cli.compile_modes import check

    return check(request.compile, terminal)


def _emit(request: Request, terminal: Terminal) -> int:
    from cortex_dsl.cli.compile_modes import emit

    return emit(request.compile, request.stage, terminal)


MODES: Mapping[Mode, Callable[[Request, Terminal], int]] = {
    Mode.RUN: _run,
    Mode.SEARCH: _search,
    Mode.SAMPLE: _sample,
    Mode.CHECK: _check,
    Mode.EMIT: _emit,
}


def execute(request: Request, terminal: Terminal) -> int:
    """Run the mode of a request and return the exit code."""
    if request.compile.freeze is not None:
        from cortex_dsl.console.compiling import freeze_params

        request = replace(request, compile=freeze_params(request.compile, terminal))
    return MODES[request.mode](request, terminal)


# -- subcommands -------------------------------------------------------------------------------------------------------


Loader = Callable[[], Command]
"""Function that imports a command."""


@frozen
class Subcommand:
    """A first word of a command line, with its line in `cortexc --help`."""

    load: Loader
    summary: str
    arguments: str = ""
    """Arguments in that line."""
    first_page: bool = True
    """Whether `cortexc --help` has the line; if not, only `cortexc --help-all` has it."""


SUBCOMMANDS: dict[str, Subcommand] = {}


def _subcommand(name: str, summary: str, arguments: str = "", *, first_page: bool = True) -> Callable[[Loader], Loader]:
    """Add a row to the table."""

    def add(load: Loader) -> Loader:
        SUBCOMMANDS[name] = Subcommand(load, summary, arguments, first_page)
        return load

    return add


@_subcommand("new", "a small scenario to begin with", "FILE")
def _new() -> Command:
    from cortex_dsl.cli.examples import NEW

    return NEW


@_subcommand("examples", "the scenarios that come with cortexc", "[NAME]")
def _examples() -> Command:
    from cortex_dsl.cli.examples import EXAMPLES

    return EXAMPLES


@_subcommand("repl", "write a scenario interactively, checked as you type", "[FILE]")
def _repl() -> Command:
    from cortex_dsl.repl import REPL

    return REPL


@_subcommand("explain", "what a code such as SCN203 means, with an example", "[CODE]")
def _explain() -> Command:
    from cortex_dsl.console.code_pages import EXPLAIN

    return EXPLAIN


@_subcommand("test", "run files and fail if a limit is broken, for CI", "PATHS")
def _test() -> Command:
    from cortex_dsl.cli.test import TEST

    return TEST


@_subcommand("suite", "rating and regulation tests: Euro NCAP, UN R152 …", "NAME")
def _suite() -> Command:
    from cortex_dsl.cli.suite import SUITE

    return SUITE


@_subcommand("coverage", "cells of the domains: covered, impossible, untried …", "FILE", first_page=False)
def _coverage() -> Command:
    from cortex_dsl.cli.coverage import COVERAGE

    return COVERAGE


@_subcommand("compare", "two drivers on the same scenes: is B worse than A?", "A B")
def _compare() -> Command:
    from cortex_dsl.cli.compare import COMPARE

    return COMPARE


@_subcommand("study", "many runs of several methods, compared run by run", "[FILES]", first_page=False)
def _study() -> Command:
    from cortex_dsl.cli.study import STUDY

    return STUDY


@_subcommand("resume", "continue a search that was stopped or killed", "RUN", first_page=False)
def _resume() -> Command:
    from cortex_dsl.cli.search import RESUME

    return RESUME


@_subcommand("report", "write an HTML page of a run or a study, with replays", "RUN")
def _report() -> Command:
    from cortex_dsl.cli.report import REPORT

    return REPORT


@_subcommand("analyse", "kinds of failures, params that matter, avoidability", "RUN")
def _analyse() -> Command:
    from cortex_dsl.cli.analyse import ANALYSE

    return ANALYSE


@_subcommand("probability", "probability of a collision, with confidence interval", "FILE")
def _probability() -> Command:
    from cortex_dsl.cli.analyse import PROBABILITY

    return PROBABILITY


@_subcommand("verify", "check the journal; repeat worst cases with tyre slip", "RUN", first_page=False)
def _verify() -> Command:
    from cortex_dsl.cli.verify import VERIFY

    return VERIFY


@_subcommand("replay", "play a case again: in the terminal, as page or film", "RUN|FILE")
def _replay() -> Command:
    from cortex_dsl.cli.replay import REPLAY

    return REPLAY


@_subcommand("export", "cases for other tools: OpenSCENARIO, CommonRoad …", "RUN|FILE")
def _export() -> Command:
    from cortex_dsl.cli.export import EXPORT

    return EXPORT


@_subcommand("measure", "metrics and risk of a recorded case, from any driver", "FILE")
def _measure() -> Command:
    from cortex_dsl.cli.measure import MEASURE

    return MEASURE


@_subcommand("import", "read an OpenSCENARIO case and compute its risk", "FILE.xosc", first_page=False)
def _import() -> Command:
    from cortex_dsl.cli.measure import IMPORT

    return IMPORT


@_subcommand("paper-check", "recompute the figures of the CORTEX-AVD paper", first_page=False)
def _paper_check() -> Command:
    from cortex_dsl.cli.study import PAPER_CHECK

    return PAPER_CHECK


@_subcommand("fmt", "put files into the standard layout (--check, --diff)", "FILES", first_page=False)
def _fmt() -> Command:
    from cortex_dsl.cli.fmt import FMT

    return FMT


@_subcommand("lsp", "the language server, which editors start", first_page=False)
def _lsp() -> Command:
    from cortex_dsl.cli.lsp import LSP

    return LSP


# -- `cortexc FILE` ----------------------------------------------------------------------------------------------------


def _description(*, all_rows: bool) -> str:
    """Return the first lines of the help, with one line per subcommand."""
    shown = {name: row for name, row in SUBCOMMANDS.items() if all_rows or row.first_page}
    calls = {name: f"{name} {row.arguments}".rstrip() for name, row in shown.items()}
    return DESCRIPTION + "".join(f"\n  cortexc {calls[name]:<16} {row.summary}" for name, row in shown.items())


def _perform(options: Namespace, terminal: Terminal) -> int:
    return execute(to_request(options), terminal)


FILE = Command(
    name="",
    usage="FILE [--search | --ga | --random | --method NAME] [options]\n"
    "FILE [--sample N | --check | --emit STAGE] [options]",
    description=_description(all_rows=True),
    options=OPTIONS,
    function=_perform,
    epilog=EXAMPLES + WHERE_TO_READ,
    layout=TwoColumns,
    first_page=(_description(all_rows=False), WHERE_TO_READ),
)


def run_words(words: Sequence[str], terminal: Terminal) -> int:
    """Run the command line `cortexc WORDS...` and return its exit code.

    Raises:
        UsageError: the words are not as the command needs them.
    """
    if words and words[0] in SUBCOMMANDS:
        return run_command(SUBCOMMANDS[words[0]].load(), words[1:], terminal)
    refuse_guesses(words, SUBCOMMANDS)
    return run_command(FILE, words, terminal)


# -- command lines that users of other tools guess: `cortexc check FILE`, `cortexc --explain CODE` ---------------------

_FLAGS: Mapping[str, str] = MappingProxyType(
    {
        **dict.fromkeys(("run", "simulate", "sim", "start"), ""),
        **dict.fromkeys(("check", "lint", "validate", "compile"), "--check"),
        **dict.fromkeys(("search", "hunt", "fuzz"), "--search"),
        "ga": "--ga",
        "random": "--random",
        "sample": "--sample 10000",
        "emit": "--emit ast",
    }
)
"""First words that are no commands, and the flag with that effect."""
_COMMANDS: Mapping[str, str] = MappingProxyType(
    {"format": "fmt", "analyze": "analyse", "shell": "repl", "convert": "export", "play": "replay"}
)
"""Commands of other tools, and the names of ours that do the same."""
_PAGES = ("help", "version")


def refuse_guesses(arguments: Sequence[str], commands: Iterable[str]) -> None:
    """Refuse a command line whose first word belongs to another tool.

    Raises:
        UsageError: it does; the cure is the correct line.
    """
    if not arguments or os.access(arguments[0], os.F_OK):
        return
    first, rest = arguments[0], arguments[1:]
    if first in _PAGES:
        raise UsageError(f"`{first}` is an option here", f"write `cortexc --{first}`")
    if first in _FLAGS:
        raise UsageError(
            f"there is no command `{first}`", f"write `{_line(*(rest or ['FILE']), *_FLAGS[first].split())}`"
        )
    if (meant := _command(first, tuple(commands))) is not None:
        message = (
            f"`{meant}` is a command, not an option" if first == f"--{meant}" else f"there is no command `{first}`"
        )
        raise UsageError(message, f"write `{_line(meant, *rest)}`")


def _command(word: str, commands: Sequence[str]) -> str | None:
    """The command that is meant by a word, which may be written as an option."""
    bare = word.removeprefix("--")
    if bare in commands or bare in _COMMANDS:
        return _COMMANDS.get(bare, bare)
    is_word = bare == word and word.replace("-", "").isalpha()
    return nearest(word, commands) if is_word else None


def _line(*words: str) -> str:
    return shlex.join(("cortexc", *words))
