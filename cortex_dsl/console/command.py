"""A command as a row: its words, its help, and the function behind it.

What all commands have is said once, here: --help, --json, --no-colour, how a slip on the command line is answered, and
the options that several of them share.
"""

import argparse
import os
import re
import shutil
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from shlex import join
from typing import Any, NoReturn

from cortex_dsl.console.request import RunRequest, whole_number
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from cortex_dsl.plain_text import harmless
from cortex_dsl.spelling import nearest
from engine.driving.names import Egos, added, words_of
from engine.frozen import frozen
from engine.vocabulary import OBSERVABLE


class Parser(argparse.ArgumentParser):
    """An argparse parser whose messages name the nearest option, and which raises instead of ending the process."""

    def error(self, message: str) -> NoReturn:
        raise UsageError(_tidy(message, self), f"`{self.prog} --help` lists every option")

    def format_help(self) -> str:
        text = harmless(super().format_help())
        return _coloured(text) if _colour_wanted(sys.stdout) else text


def _tidy(message: str, parser: Parser) -> str:
    """The sentence of argparse, shorter, and with the option that was probably meant."""
    if found := re.fullmatch(r"unrecognized arguments: (.*)", message, re.DOTALL):
        word = found[1].split(" ")[0]
        match = nearest(word.split("=")[0], parser._option_string_actions) if word.startswith("-") else None
        if match is not None:
            return f"unknown option `{word}`; did you mean `{match}`?"
        return f"unknown option `{word}`" if word.startswith("-") else f"unexpected argument `{word}`"
    return re.sub(r"^argument (?:-p/)?(\S+?)(?:/--\S+)?: ", r"\1: ", message)


class TwoColumns(argparse.RawDescriptionHelpFormatter):
    """Two columns, each option named once with its value."""

    def __init__(self, prog: str, **_: object) -> None:
        width = max(60, min(100, shutil.get_terminal_size().columns))
        super().__init__(prog, max_help_position=27, width=width)

    def _format_action_invocation(self, action: argparse.Action) -> str:
        names = ", ".join(name for name in action.option_strings if name != "--no-color")
        if not names:
            return super()._format_action_invocation(action)
        if action.nargs == 0:
            return names
        return f"{names} {self._format_args(action, self._get_default_metavar_for_optional(action))}"


def _colour_wanted(stream: object) -> bool:
    isatty = getattr(stream, "isatty", lambda: False)
    return isatty() and "NO_COLOR" not in os.environ and os.environ.get("TERM") != "dumb"


def _coloured(text: str) -> str:
    """Headings bold, options in colour."""
    text = re.sub(r"^(\S[^\n]*:)$", "\x1b[1m\\1\x1b[0m", text, flags=re.MULTILINE)
    text = re.sub(r"^(usage:)", "\x1b[1m\\1\x1b[0m", text)
    return re.sub(r"^(  (?:-\S+(?:, -\S+)*|\d+ ))", "\x1b[36m\\1\x1b[0m", text, flags=re.MULTILINE)


def cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0)) or 1
    return os.cpu_count() or 1


# -- a command ---------------------------------------------------------------------------------------------------------

EXAMPLE_RUN = "{run}"
"""Stands in a help or a cure for the run that is named as an example: the latest that is there."""


@frozen
class Command:
    """One `cortexc NAME ...`: its words, what its help says, and the function behind it.

    --help, --no-colour, --json and the complaint about a missing first word are here for all commands.
    """

    name: str
    usage: str
    """What follows the name, in a line."""
    description: str
    options: Callable[["Parser"], None]
    """Adds the options of this command alone."""
    function: Callable[[argparse.Namespace, Terminal], int]
    """What it does, from the options to an exit code; `options.words` is the command line as typed."""
    epilog: str = ""
    needs: tuple[str, str, str] | None = None
    """An argument that it cannot do without, and the message and the cure where that is missing."""
    json: bool = True
    """Whether it can answer with one document."""
    wrapped: bool = False
    """Whether its texts are wrapped to the width of the terminal."""
    no_colour: str = argparse.SUPPRESS
    """What the help says of --no-colour."""

    def parser(self) -> "Parser":
        """The parser of `cortexc NAME`, whose options keep their order."""
        parser = Parser(
            prog=f"cortexc {self.name}",
            usage="\n       ".join(f"cortexc {self.name} {line}".rstrip() for line in self.usage.split("\n")),
            description=self.description,
            epilog=with_example(self.epilog) or None,
            formatter_class=argparse.HelpFormatter if self.wrapped else argparse.RawDescriptionHelpFormatter,
            allow_abbrev=False,
            add_help=False,
        )
        self.options(parser)
        if self.json:
            add_json(parser)
        parser.add_argument("--no-colour", "--no-color", action="store_true", help=self.no_colour)
        parser.add_argument("-h", "--help", action="store_true", help="this page")
        return parser


def run_command(command: Command, words: Sequence[str], terminal: Terminal) -> int:
    """Run `cortexc NAME WORDS...` and return its exit code.

    Raises:
        UsageError: the words are not as the command needs them.
    """
    parser = command.parser()
    options = parser.parse_args(words)
    if options.help:
        terminal.write(parser.format_help(), coloured=True)
        return Exit.FINE
    if command.needs is not None and not getattr(options, command.needs[0]):
        raise UsageError(command.needs[1], with_example(command.needs[2]))
    options.words = tuple(words)
    return command.function(options, terminal)


FORM = ("--json", "--no-colour", "--no-color")
"""Options that change only the form of the output."""


def typed_again(name: str, words: Sequence[str]) -> str:
    """Return the command line as it was typed, without the options of `FORM`."""
    return join(["cortexc", name, *(word for word in words if word not in FORM)])


def with_example(text: str) -> str:
    """The text with an example of a run in its place."""
    if EXAMPLE_RUN not in text:
        return text
    from engine.search.store import example_run

    return text.replace(EXAMPLE_RUN, str(example_run()))


# -- options that several commands have, each worded once --------------------------------------------------------------


def add_run(parser: Parser, text: str = "a run directory") -> None:
    """RUN: where a search left what it found."""
    parser.add_argument("run", metavar="RUN", nargs="?", type=Path, help=with_example(text))


def add_jobs(parser: Parser, who: str = "threads") -> None:
    """--jobs: as many at a time; as many as there are cores unless it is given."""
    parser.add_argument(
        "--jobs",
        metavar="N",
        type=whole_number(1, 1024),
        default=cores(),
        help=f"{who}; results never depend on it ({cores()})",
    )


def add_dask(parser: Parser, what: str) -> None:
    """--dask: workers elsewhere."""
    parser.add_argument(
        "--dask", metavar="ADDRESS", help=f"address of a Dask scheduler; `local` starts one for the {what}"
    )


def add_ego(parser: argparse._ActionsContainer, *, batch: bool = True) -> None:
    """--ego: who drives for a controller of the file; `batch`: how many scenes at once, and what is observed, too."""
    parser.add_argument(
        "--ego",
        metavar="NAME",
        action=_OneMoreDriver,
        help="driver of the ego: python:package.module:function or process:COMMAND; of several controllers one for "
        "each: --ego CONTROLLER=python:...",
    )
    if batch:
        parser.add_argument(
            "--ego-observes",
            metavar="WHAT",
            choices=OBSERVABLE,
            help="what it observes: records of the file, where it has any, or egocentric, what is seen from its seat "
            "(records)",
        )
        parser.add_argument(
            "--ego-batch",
            metavar="N",
            type=whole_number(1, 10**6),
            help="scenes passed to this driver in one call (256)",
        )


DRIVER_OPTIONS = ("ego", "ego_batch", "ego_observes")


def flag_of(name: str) -> str:
    """How an option is written on the command line."""
    return "--" + name.replace("_", "-")


def driver_options(options: argparse.Namespace) -> dict[str, Any]:
    """Those about the driver that were given.

    Raises:
        UsageError: there are some, and no driver.
    """
    given = {name: value for name in DRIVER_OPTIONS if (value := getattr(options, name)) is not None}
    if given and "ego" not in given:
        raise UsageError(f"{flag_of(next(iter(given)))} has no effect without a driver", "add --ego NAME")
    return given


def driver_words(ego: Egos | None, batch: int | None, observes: str | None) -> list[str]:
    """The words of a command line that name a driver again; of what is as it is anyway, nothing."""
    usual = RunRequest()
    words = [] if ego is None else words_of(ego)
    words += [] if batch in (None, usual.ego_batch) else ["--ego-batch", str(batch)]
    return words + ([] if observes in (None, usual.ego_observes) else ["--ego-observes", str(observes)])


def refuse_driver(options: argparse.Namespace) -> None:
    """Raise UsageError for options about the driver where a run is shown: it has its own, and keeps what it decided."""
    for name in DRIVER_OPTIONS:
        if getattr(options, name) is not None:
            flag = flag_of(name)
            raise UsageError(f"{flag} is for a scenario, and a run keeps what its driver decided", f"leave {flag} out")


class _OneMoreDriver(argparse.Action):
    """Drivers of several controllers are named one after the other."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Any,
        option_string: str | None = None,  # noqa: ARG002 - argparse's
    ) -> None:
        before: Egos | None = getattr(namespace, self.dest)
        try:
            setattr(namespace, self.dest, added(before, values))
        except ValueError as error:
            parser.error(f"--ego {values}: {error}")


def add_json(parser: argparse._ActionsContainer) -> None:
    """--json: for programs that read the answer."""
    parser.add_argument("--json", action="store_true", help="one JSON document on stdout, and nothing else there")
