"""Output streams, and exit codes of a command.

stdout is for results, stderr for remarks on them; both are plain if they are no terminal. A command ends with one of a
few exit codes; an error of the user is an exception with its cure; for an internal error one line is shown, and a file
to send.
"""

import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cached_property
from typing import TYPE_CHECKING, Any, TextIO

from cortex_dsl.plain_text import harmless
from engine.errors import CortexError

if TYPE_CHECKING:
    from rich.console import Console


WIDEST = 100
"""Columns that a view uses at most: longer lines are hard to read."""
NARROWEST, USUAL = 20, 80
"""Smallest believable width, and the width that replaces a smaller one (none, if it is not set) [characters]."""


@dataclass(frozen=True)
class Terminal:
    """The two streams of a command. rich is imported with the first view that is drawn."""

    colour: bool | None = None
    """False: never; None: where the stream is a terminal."""
    quiet: bool = False
    """stdout is for a document: views are not drawn."""

    wrote: list[str] = field(default_factory=list, repr=False)
    """First words of each output to stdout: with --json there is exactly one document."""

    diagnostics: list[dict[str, Any]] = field(default_factory=list, repr=False)
    """Diagnostics that the next document contains."""

    notes: list[str] = field(default_factory=list, repr=False)
    """Warnings and remarks of the command itself, which the next document contains too."""

    @cached_property
    def out(self) -> "Console":
        return _console(sys.stdout, self.colour)

    @cached_property
    def err(self) -> "Console":
        return _console(sys.stderr, self.colour)

    def write(self, text: str, *, coloured: bool = False) -> None:
        """Text for stdout; `coloured`: it was made here, colours and all."""
        self.wrote.append(text[:20])
        shown = text if coloured else harmless(text)
        sys.stdout.write(shown if shown.endswith("\n") else shown + "\n")

    def document(self, kind: str, content: Mapping[str, Any]) -> None:
        """Write the one document of --json, with all diagnostics and notes of the command."""
        from cortex_dsl.report.documents import document

        self.write(document(kind, {**content, "diagnostics": self.diagnostics, "notes": self.notes}))

    def note(self, text: str, style: str = "quiet") -> None:
        """Write a warning (`warn`) or a remark on the results to stderr, and store it for the document."""
        self.notes.append(text)
        self.err.print(text, style=style, soft_wrap=True)

    def complain(self, message: str, cure: str = "") -> None:
        """An error of the command itself, on stderr."""
        bold, plain = ("\x1b[1;31m", "\x1b[0m") if self.colour is not False and _wants_colour(sys.stderr) else ("", "")
        sys.stderr.write(f"{bold}cortexc:{plain} {harmless(message)}\n")
        if cure:
            sys.stderr.write(f"  help: {harmless(cure)}\n")


def _console(stream: TextIO, colour: bool | None) -> "Console":
    from cortex_dsl.console.harmless import HarmlessConsole
    from cortex_dsl.report.terminal.theme import THEME

    plain = colour is False or "NO_COLOR" in os.environ
    console = HarmlessConsole(
        file=stream,
        theme=THEME,
        highlight=False,
        emoji=False,
        markup=False,
        color_system=None if plain else "auto",
        legacy_windows=False,
    )
    if not NARROWEST <= console.width <= WIDEST:
        console.width = WIDEST if console.width > WIDEST else USUAL
    return console


def _wants_colour(stream: TextIO) -> bool:
    return stream.isatty() and "NO_COLOR" not in os.environ and os.environ.get("TERM") != "dumb"


# -- how a command ends ------------------------------------------------------------------------------------------------


class Exit(IntEnum):
    """Exit codes of every command."""

    FINE = 0
    DIAGNOSTICS = 1
    """The file has errors."""
    USAGE = 2
    """A wrong command line, or a path that cannot be read or written."""
    NO_SCENE = 3
    """Infeasible, exhausted, or a single run that was aborted."""
    BROKEN_LIMIT = 4
    """The command ran, and a stated limit was broken."""
    BUG = 70
    """Ours. `EX_SOFTWARE` of sysexits.h."""
    INTERRUPTED = 130
    """Ctrl-C: 128 + SIGINT."""


GRAVITY = (Exit.BUG, Exit.USAGE, Exit.DIAGNOSTICS, Exit.BROKEN_LIMIT, Exit.NO_SCENE)
"""Exit codes, the gravest first: a command to which several apply ends with the first of them."""


def gravest(codes: Iterable[Exit]) -> Exit:
    """Return the gravest exit code; 0 without any."""
    return min(codes, key=GRAVITY.index, default=Exit.FINE)


class UsageError(CortexError):
    """Error that the user can solve and that stops the command: its description, and the cure."""


def report_bug(error: Exception, arguments: Sequence[str], terminal: Terminal) -> None:
    """Write the details to a file and say where it is; without a file, say them shortly."""
    import tempfile
    import traceback

    from cortex_dsl.version import VERSION

    summary = f"{type(error).__name__}: {error}".splitlines()[0][:200]
    details = _details(error, arguments)
    try:
        with tempfile.NamedTemporaryFile("w", prefix="cortexc-bug-", suffix=".txt", delete=False) as file:
            file.write(details)
        cure = f"please report it with the details in {file.name}"
    except OSError:
        where = traceback.extract_tb(error.__traceback__)[-1]
        cure = f"please report it: version {VERSION}, {where.name} in line {where.lineno} of {where.filename}"
    terminal.complain(f"a bug in cortexc, not in your file: {summary}", cure)


def _details(error: Exception, arguments: Sequence[str]) -> str:
    import platform
    import traceback
    from datetime import datetime

    from cortex_dsl.version import VERSION

    head = (
        f"cortexc {VERSION}",
        f"time: {datetime.now().astimezone().isoformat(timespec='seconds')}",
        f"command: cortexc {' '.join(arguments)}",
        f"Python {sys.version} on {platform.platform()}",
    )
    return "\n".join((*head, "", *traceback.format_exception(error)))
