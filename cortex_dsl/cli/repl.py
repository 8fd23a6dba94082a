"""`cortexc repl [FILE]`: a session in which a scenario is written, weighed and tried."""

import argparse
import contextlib
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from cortex_dsl.console.command import Parser
from cortex_dsl.console.terminal import Exit, Terminal

if TYPE_CHECKING:
    from cortex_dsl.repl.loop import Input
    from cortex_dsl.repl.state import Desk

NO_TERMINALS = ("dumb", "unknown", "")
DESCRIPTION = """\
Write a scenario entry by entry: each is checked at once, each `require` is
weighed on 10,000 draws. Commands sample, draw, plot, run and search; `:help`
lists them. From a pipe (`cortexc repl < script`) entries are done one by one."""
EXITS = """\
exit codes of a script on standard input:
  0    every entry was fine
  1    some entries or commands were refused; the rest was done
  2    a wrong command line, or FILE cannot be read
  3    the last :sample, :scene, :run, :ga or :random found no valid scene
  70   a bug in cortexc
  130  interrupted
At a terminal it is 0.
"""


def main(arguments: Sequence[str], terminal: Terminal) -> int:
    options = _parser().parse_args(arguments)
    if options.help:
        terminal.write(_parser().format_help())
        return Exit.FINE
    from cortex_dsl.repl.loop import run
    from cortex_dsl.repl.state import Desk

    for stream in (sys.stdin, sys.stdout):
        with contextlib.suppress(AttributeError, ValueError):
            stream.reconfigure(errors="replace")  # type: ignore[union-attr]
    desk = Desk(terminal, interactive=sys.stdin is not None and sys.stdin.isatty())
    if desk.interactive:
        _greet(terminal)
    chunks = _input(desk)
    if desk.interactive:
        desk.kernels.start()
    if options.file:
        from cortex_dsl.repl.commands_draft import load

        load(desk, Path(options.file))
    return run(desk, chunks)


def _input(desk: "Desk") -> "Input":
    able = sys.stdout.isatty() and os.environ.get("TERM", "") not in NO_TERMINALS
    if desk.interactive and able:
        from cortex_dsl.repl.prompt import EditedInput

        return EditedInput(desk)
    from cortex_dsl.repl.chunks import PlainInput

    return PlainInput(desk)


def _greet(terminal: Terminal) -> None:
    from cortex_dsl.version import VERSION

    terminal.out.print(f"cortexc {VERSION}", style="title", end="")
    terminal.out.print("  :help lists the commands, Tab completes, Ctrl-D leaves", style="quiet")


def _parser() -> Parser:
    parser = Parser(
        prog="cortexc repl",
        usage="cortexc repl [FILE]",
        description=DESCRIPTION,
        epilog=EXITS,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
        add_help=False,
    )
    parser.add_argument("file", metavar="FILE", nargs="?", help="a scenario to begin with")
    parser.add_argument("--no-colour", "--no-color", action="store_true", help="plain output")
    parser.add_argument("-h", "--help", action="store_true", help="this page")
    return parser
