"""The table of commands. A new one is a module and a row here; nothing is imported before it is asked for.

A *mode* is what `cortexc FILE` does under a flag; its module has `execute(request, terminal) -> int`.
A *subcommand* is the first word (`cortexc NAME ...`); its module has `main(arguments, terminal) -> int`
and parses its own arguments.
"""

import os
import shlex
from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib import import_module
from types import MappingProxyType

from cortex_dsl.console.request import Mode, Request
from cortex_dsl.console.terminal import Terminal, UsageError
from cortex_dsl.spelling import nearest
from engine.frozen import frozen


@frozen
class Subcommand:
    """A first word that `cortexc` knows: the function behind it, and one line for `--help`."""

    function: str
    """As `module:name`."""
    summary: str
    arguments: str = ""
    """As shown there, behind the name."""


MODES: dict[Mode, str] = {
    Mode.RUN: "cortex_dsl.cli.draw_modes:run_once",
    Mode.SEARCH: "cortex_dsl.cli.search:search",
    Mode.SAMPLE: "cortex_dsl.cli.draw_modes:sample_scenes",
    Mode.CHECK: "cortex_dsl.cli.compile_modes:check",
    Mode.EMIT: "cortex_dsl.cli.compile_modes:emit",
}

SUBCOMMANDS: dict[str, Subcommand] = {
    "repl": Subcommand("cortex_dsl.cli.repl:main", "write a scenario interactively, weighed as you type", "[FILE]"),
    "explain": Subcommand(
        "cortex_dsl.console.code_pages:main", "what a code such as SCN203 means, with an example", "[CODE]"
    ),
    "study": Subcommand("cortex_dsl.cli.study:main", "many runs of several methods, compared run by run", "[FILES]"),
    "resume": Subcommand("cortex_dsl.cli.search:resume", "go on with a search that was stopped or killed", "RUN"),
    "report": Subcommand("cortex_dsl.cli.report:main", "a run or a study as a page, its worst cases to watch", "RUN"),
    "analyse": Subcommand(
        "cortex_dsl.cli.analyse:analyse_run", "different failures, their kinds, and whose fault", "RUN"
    ),
    "probability": Subcommand(
        "cortex_dsl.cli.analyse:probability", "of a collision, with its confidence interval", "FILE"
    ),
    "replay": Subcommand(
        "cortex_dsl.cli.replay:main", "one case again: in the terminal, as a page, as a film", "RUN|FILE"
    ),
    "export": Subcommand("cortex_dsl.cli.export:main", "cases for other tools: OpenSCENARIO, CommonRoad …", "RUN|FILE"),
    "measure": Subcommand(
        "cortex_dsl.cli.measure:measure_file", "metrics and risk of a recorded case, whoever drove", "FILE"
    ),
    "import": Subcommand(
        "cortex_dsl.cli.measure:import_file", "an OpenSCENARIO case read back and scored", "FILE.xosc"
    ),
    "paper-check": Subcommand("cortex_dsl.cli.paper_check:main", "the arithmetic of the CORTEX-AVD paper, done again"),
    "fmt": Subcommand("cortex_dsl.cli.fmt:main", "files in the one layout (--check, --diff)", "FILES"),
    "lsp": Subcommand("cortex_dsl.cli.lsp:main", "the language server, for editors to start"),
}


def execute(request: Request, terminal: Terminal) -> int:
    """Run what `cortexc FILE` was asked for."""
    if request.freeze is not None:
        request = import_module("cortex_dsl.console.compiling").freeze_params(request)
    command: Callable[[Request, Terminal], int] = _found(MODES[request.mode])
    return command(request, terminal)


def execute_subcommand(name: str, arguments: Sequence[str], terminal: Terminal) -> int:
    """Run `cortexc NAME ARGUMENTS...`."""
    command: Callable[[Sequence[str], Terminal], int] = _found(SUBCOMMANDS[name].function)
    return command(arguments, terminal)


def _found(place: str) -> Callable[..., int]:
    """The function at `module:name`, imported when it is asked for."""
    module, _, name = place.partition(":")
    found: Callable[..., int] = getattr(import_module(module), name)
    return found


# -- Command lines as people guess them who know other tools: `cortexc check FILE`, `cortexc --explain CODE` -----------

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
"""Words for commands that have another name here."""
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
        told = f"`{meant}` is a command, not an option" if first == f"--{meant}" else f"there is no command `{first}`"
        raise UsageError(told, f"write `{_line(meant, *rest)}`")


def _command(word: str, commands: Sequence[str]) -> str | None:
    """The command that is meant by a word, which may be written as an option."""
    bare = word.removeprefix("--")
    if bare in commands or bare in _COMMANDS:
        return _COMMANDS.get(bare, bare)
    is_word = bare == word and word.replace("-", "").isalpha()
    return nearest(word, commands) if is_word else None


def _line(*words: str) -> str:
    return shlex.join(("cortexc", *words))
