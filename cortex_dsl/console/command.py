"""How a command reads its words: messages, help and the options that most commands have, each said once, here."""

import argparse
import os
import re
import shutil
import sys
from pathlib import Path
from typing import NoReturn

from cortex_dsl.console.request import whole_number
from cortex_dsl.console.terminal import UsageError
from cortex_dsl.spelling import nearest


class Parser(argparse.ArgumentParser):
    """argparse with messages that name the nearest option, and raise instead of ending the process."""

    def error(self, message: str) -> NoReturn:
        raise UsageError(_tidy(message, self), f"`{self.prog} --help` lists every option")

    def format_help(self) -> str:
        return _coloured(super().format_help()) if _colour_wanted(sys.stdout) else super().format_help()


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


# -- the parser of a command, with the options that every command has, or most -----------------------------------------


def command_parser(name: str, usage: str, description: str, epilog: str | None = None) -> Parser:
    """The parser of `cortexc NAME`, whose texts are printed as they are written."""
    return Parser(
        prog=f"cortexc {name}",
        usage=f"cortexc {name} {usage}",
        description=description,
        epilog=epilog,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
        add_help=False,
    )


def add_run(parser: Parser, text: str = "a run directory") -> None:
    """RUN: where a search left what it found."""
    parser.add_argument("run", metavar="RUN", nargs="?", type=Path, help=text)


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
        "--dask", metavar="ADDRESS", help=f"of a Dask scheduler; `local`: one for the time of the {what}"
    )


def add_common(parser: Parser, *, json: bool = True) -> None:
    """--json, --no-colour and --help, which come last."""
    if json:
        parser.add_argument("--json", action="store_true", help="one JSON document on stdout, and nothing else there")
    parser.add_argument("--no-colour", "--no-color", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("-h", "--help", action="store_true", help="this page")
