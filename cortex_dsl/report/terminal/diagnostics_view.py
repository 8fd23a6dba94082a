"""Diagnostics in colour, as many as one would read."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from cortex_dsl.diagnostics import Diagnostic, Severity
from cortex_dsl.report.findings.snippet import draw
from cortex_dsl.source import Source

if TYPE_CHECKING:
    from rich.console import Console

_COLOURS = {
    Severity.ERROR: "bold red",
    Severity.WARNING: "bold yellow",
    Severity.NOTE: "bold cyan",
    Severity.HINT: "bold blue",
}
_STYLES = {
    "plain": "",
    "source": "",
    "place": "",
    "message": "bold",
    "gutter": "bright_blue",
    "secondary": "bright_blue",
    "reason": "",
    "help": "bold green",
}
MOST_DRAWN = 100
"""Diagnostics that are drawn at most; a JSON document holds all of them."""


def print_diagnostics(source: Source, diagnostics: Sequence[Diagnostic], console: "Console") -> None:
    """Print diagnostics in colour, a blank line between them.

    A headline is one line for programs that read it, and at a terminal no wider than that.
    """
    from rich.text import Text

    drawn = _drawn(diagnostics)
    for index, diagnostic in enumerate(drawn):
        if index:
            console.print()
        styles = _STYLES | {"primary": _COLOURS[diagnostic.severity], "severity": _COLOURS[diagnostic.severity]}
        for number, line in enumerate(draw(source, diagnostic, console.width)):
            text = Text.assemble(*((piece, styles[style]) for piece, style in line))
            console.print(text, soft_wrap=number > 0 or not console.is_terminal)
    if left := len(diagnostics) - len(drawn):
        console.print(f"\nand {left:,} more; --format json lists all", soft_wrap=True)


def _drawn(diagnostics: Sequence[Diagnostic]) -> Sequence[Diagnostic]:
    """Return a readable number of diagnostics, errors first, in the order of the file."""
    if len(diagnostics) <= MOST_DRAWN:
        return diagnostics
    grave = sorted(range(len(diagnostics)), key=lambda index: diagnostics[index].severity is not Severity.ERROR)
    return [diagnostics[index] for index in sorted(grave[:MOST_DRAWN])]
