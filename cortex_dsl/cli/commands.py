"""The table of commands. A new one is a module and a row here; nothing is imported before it is asked for.

A *mode* is what `cortexc FILE` does under a flag; its module has `execute(request, terminal) -> int`.
A *subcommand* is the first word (`cortexc NAME ...`); its module has `main(arguments, terminal) -> int`
and parses its own arguments.
"""

from collections.abc import Callable, Sequence
from importlib import import_module

from cortex_dsl.cli.request import Mode, Request
from cortex_dsl.cli.terminal import Terminal
from engine.frozen import frozen


@frozen
class Subcommand:
    """A first word that `cortexc` knows: the module behind it, and one line for `--help`."""

    module: str
    summary: str
    arguments: str = ""
    """As shown there, behind the name."""


MODES: dict[Mode, str] = {
    Mode.RUN: "cortex_dsl.cli.run",
    Mode.SEARCH: "cortex_dsl.cli.search",
    Mode.SAMPLE: "cortex_dsl.cli.sample",
    Mode.CHECK: "cortex_dsl.cli.check",
    Mode.EMIT: "cortex_dsl.cli.emit",
}

SUBCOMMANDS: dict[str, Subcommand] = {
    "repl": Subcommand("cortex_dsl.cli.repl", "write a scenario interactively, weighed as you type", "[FILE]"),
    "explain": Subcommand("cortex_dsl.cli.explain", "what a code such as SCN203 means, with an example", "[CODE]"),
    "study": Subcommand("cortex_dsl.cli.study", "many runs of several methods, compared run by run", "[FILES]"),
    "resume": Subcommand("cortex_dsl.cli.resume", "go on with a search that was stopped or killed", "RUN"),
    "report": Subcommand("cortex_dsl.cli.report", "a run or a study as a page, its worst cases to watch", "RUN"),
    "analyse": Subcommand("cortex_dsl.cli.analyse", "different failures, their kinds, and whose fault", "RUN"),
    "probability": Subcommand("cortex_dsl.cli.probability", "of a collision, with its confidence interval", "FILE"),
    "replay": Subcommand("cortex_dsl.cli.replay", "one case again: in the terminal, as a page, as a film", "RUN|FILE"),
    "export": Subcommand("cortex_dsl.cli.export", "cases for other tools: OpenSCENARIO, CommonRoad …", "RUN|FILE"),
    "measure": Subcommand("cortex_dsl.cli.measure", "metrics and risk of a recorded case, whoever drove", "FILE"),
    "import": Subcommand("cortex_dsl.cli.importing", "an OpenSCENARIO case read back and scored", "FILE.xosc"),
    "paper-check": Subcommand("cortex_dsl.cli.paper_check", "the arithmetic of the CORTEX-AVD paper, done again"),
    "fmt": Subcommand("cortex_dsl.cli.fmt", "files in the one layout (--check, --diff)", "FILES"),
    "lsp": Subcommand("cortex_dsl.cli.lsp", "the language server, for editors to start"),
}


def execute(request: Request, terminal: Terminal) -> int:
    """Run what `cortexc FILE` was asked for."""
    if request.freeze is not None:
        request = import_module("cortex_dsl.cli.freezing").frozen(request)
    command: Callable[[Request, Terminal], int] = import_module(MODES[request.mode]).execute
    return command(request, terminal)


def execute_subcommand(name: str, arguments: Sequence[str], terminal: Terminal) -> int:
    """Run `cortexc NAME ARGUMENTS...`."""
    command: Callable[[Sequence[str], Terminal], int] = import_module(SUBCOMMANDS[name].module).main
    return command(arguments, terminal)
