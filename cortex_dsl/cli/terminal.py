"""Where output goes: stdout for results, stderr for everything about them; plain where nobody watches."""

import os
import sys
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, TextIO

if TYPE_CHECKING:
    from rich.console import Console

WIDEST = 100
"""Columns that a view uses at most: longer lines are hard to read."""


@dataclass(frozen=True)
class Terminal:
    """The two streams of a command. rich is imported with the first view that is drawn."""

    colour: bool | None = None
    """False: never; None: where the stream is a terminal."""
    quiet: bool = False
    """stdout is for a document: views are not drawn."""

    wrote: list[str] = field(default_factory=list, repr=False)
    """The first words of what went to stdout: under --json there is one document, whatever happens."""

    @cached_property
    def out(self) -> "Console":
        return _console(sys.stdout, self.colour)

    @cached_property
    def err(self) -> "Console":
        return _console(sys.stderr, self.colour)

    def write(self, text: str) -> None:
        """Text for stdout, as it is."""
        self.wrote.append(text[:20])
        sys.stdout.write(text if text.endswith("\n") else text + "\n")

    def complain(self, message: str, cure: str = "") -> None:
        """An error of the command itself, on stderr."""
        bold, plain = ("\x1b[1;31m", "\x1b[0m") if self.colour is not False and _wants_colour(sys.stderr) else ("", "")
        sys.stderr.write(f"{bold}cortexc:{plain} {message}\n")
        if cure:
            sys.stderr.write(f"  help: {cure}\n")


def _console(stream: TextIO, colour: bool | None) -> "Console":
    from rich.console import Console

    from cortex_dsl.report.terminal.theme import THEME

    plain = colour is False or "NO_COLOR" in os.environ
    console = Console(
        file=stream,
        theme=THEME,
        highlight=False,
        emoji=False,
        markup=False,
        color_system=None if plain else "auto",
        legacy_windows=False,
    )
    if console.width > WIDEST:
        console.width = WIDEST
    return console


def _wants_colour(stream: TextIO) -> bool:
    return stream.isatty() and "NO_COLOR" not in os.environ and os.environ.get("TERM") != "dumb"
