"""The table of commands, and the command lines that people guess who know other tools.

A *mode* is what `cortexc FILE` does under a flag: a function that takes parts of the request and the terminal.
A *subcommand* is the first word (`cortexc NAME ...`): a `Command` of `cortex_dsl.console.command`.
A new one is a function or a `Command`, and a row here; nothing is imported before it is asked for.
"""

import os
import shlex
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from types import MappingProxyType
from typing import Any

from cortex_dsl.console.command import run_command
from cortex_dsl.console.request import Mode, Request
from cortex_dsl.console.terminal import Terminal, UsageError
from cortex_dsl.spelling import nearest
from engine.frozen import frozen


@frozen
class ModeRow:
    """What `cortexc FILE` does under a flag."""

    function: str
    """As `module:name`."""
    reads: tuple[str, ...]
    """The parts of the request that it takes."""


@frozen
class Subcommand:
    """A first word that `cortexc` knows, with one line for `--help`."""

    command: str
    """As `module:NAME`."""
    summary: str
    arguments: str = ""
    """As shown there, behind the name."""


MODES: dict[Mode, ModeRow] = {
    Mode.RUN: ModeRow("cortex_dsl.cli.draw_modes:run_once", ("compile", "run")),
    Mode.SEARCH: ModeRow("cortex_dsl.cli.search:search", ("compile", "run", "search")),
    Mode.SAMPLE: ModeRow("cortex_dsl.cli.draw_modes:sample_scenes", ("compile", "run", "samples")),
    Mode.CHECK: ModeRow("cortex_dsl.cli.compile_modes:check", ("compile",)),
    Mode.EMIT: ModeRow("cortex_dsl.cli.compile_modes:emit", ("compile", "stage")),
}

SUBCOMMANDS: dict[str, Subcommand] = {
    "new": Subcommand("cortex_dsl.cli.examples:NEW", "a small scenario to begin with", "FILE"),
    "examples": Subcommand("cortex_dsl.cli.examples:EXAMPLES", "the scenarios that come with cortexc", "[NAME]"),
    "repl": Subcommand("cortex_dsl.repl:REPL", "write a scenario interactively, checked as you type", "[FILE]"),
    "explain": Subcommand(
        "cortex_dsl.console.code_pages:EXPLAIN", "what a code such as SCN203 means, with an example", "[CODE]"
    ),
    "study": Subcommand("cortex_dsl.cli.study:STUDY", "many runs of several methods, compared run by run", "[FILES]"),
    "resume": Subcommand("cortex_dsl.cli.search:RESUME", "continue a search that was stopped or killed", "RUN"),
    "report": Subcommand("cortex_dsl.cli.report:REPORT", "write an HTML page of a run or a study, with replays", "RUN"),
    "analyse": Subcommand(
        "cortex_dsl.cli.analyse:ANALYSE", "kinds of failures, params that matter, avoidability", "RUN"
    ),
    "probability": Subcommand(
        "cortex_dsl.cli.analyse:PROBABILITY", "probability of a collision, with confidence interval", "FILE"
    ),
    "verify": Subcommand("cortex_dsl.cli.verify:VERIFY", "check the journal; repeat worst cases with tyre slip", "RUN"),
    "replay": Subcommand(
        "cortex_dsl.cli.replay:REPLAY", "play a case again: in the terminal, as page or film", "RUN|FILE"
    ),
    "export": Subcommand(
        "cortex_dsl.cli.export:EXPORT", "cases for other tools: OpenSCENARIO, CommonRoad …", "RUN|FILE"
    ),
    "measure": Subcommand(
        "cortex_dsl.cli.measure:MEASURE", "metrics and risk of a recorded case, from any driver", "FILE"
    ),
    "import": Subcommand(
        "cortex_dsl.cli.measure:IMPORT", "read an OpenSCENARIO case and compute its risk", "FILE.xosc"
    ),
    "paper-check": Subcommand("cortex_dsl.cli.study:PAPER_CHECK", "recompute the figures of the CORTEX-AVD paper"),
    "fmt": Subcommand("cortex_dsl.cli.fmt:FMT", "put files into the standard layout (--check, --diff)", "FILES"),
    "lsp": Subcommand("cortex_dsl.cli.lsp:LSP", "the language server, which editors start"),
}


def execute(request: Request, terminal: Terminal) -> int:
    """Run what `cortexc FILE` was asked for."""
    if request.compile.freeze is not None:
        request = replace(request, compile=_found("cortex_dsl.console.compiling:freeze_params")(request.compile))
    mode = MODES[request.mode]
    function: Callable[..., int] = _found(mode.function)
    return function(*(getattr(request, part) for part in mode.reads), terminal)


def execute_subcommand(name: str, words: Sequence[str], terminal: Terminal) -> int:
    """Run `cortexc NAME WORDS...`."""
    return run_command(_found(SUBCOMMANDS[name].command), words, terminal)


def _found(place: str) -> Any:
    """What stands at `module:name`, imported when it is asked for."""
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)


# -- command lines as people guess them who know other tools: `cortexc check FILE`, `cortexc --explain CODE` -----------

_FLAGS: Mapping[str, str] = MappingProxyType(
    {
        **dict.fromkeys(("run", "simulate", "sim", "start"), ""),
        **dict.fromkeys(("check", "lint", "validate", "compile"), "--check"),
        **dict.fromkeys(("ga", "search", "hunt", "fuzz"), "--ga"),
        "random": "--random",
        "sample": "--sample 10000",
        "emit": "--emit ast",
    }
)
"""First words that are no commands, and the flag that does what they say."""
_COMMANDS: Mapping[str, str] = MappingProxyType(
    {"format": "fmt", "analyze": "analyse", "shell": "repl", "convert": "export", "play": "replay"}
)
"""Commands of other tools, and the names of ours that do the same."""
_PAGES = ("help", "version")


def refuse_guesses(arguments: Sequence[str], commands: Iterable[str]) -> None:
    """Answer a command line whose first word is taken from elsewhere.

    Raises:
        UsageError: it is; the cure is the line as it should be.
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
