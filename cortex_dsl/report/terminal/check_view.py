"""What `--check` says of a file's ranges: which part of each can hold at all, and why."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.diagnostics import Diagnostic, Severity
from cortex_dsl.report.findings.readable import counted, format_gene
from cortex_dsl.report.findings.snippet import draw
from cortex_dsl.report.terminal.theme import indented
from cortex_dsl.source import Source
from engine.feasibility import Cut, Feasibility
from engine.program import Program

if TYPE_CHECKING:
    from rich.console import Console


def feasibility_view(program: Program, found: Feasibility) -> RenderableType | None:
    """A line for each reason that cuts ranges, and one for impossible variants; None where there are none."""
    lines = _cut_ranges(program, found.cuts)
    rejected = int((program.code.variant_template < 0).sum())
    impossible = int((found.impossible >= 0).sum()) - rejected
    if impossible:
        who = Text.assemble(counted(impossible, "variant"), " cannot be: ", (_ruled_out(program, found), "quiet"))
        lines.append(who)
    return indented(Group(*lines)) if lines else None


def _cut_ranges(program: Program, cuts: Sequence[Cut]) -> list[Text]:
    """Ranges of one reason in one line, in the order in which the first of each was found."""
    together: dict[str, list[Text]] = {}
    for cut in cuts:
        together.setdefault(_reason(program, cut), []).append(_range(program, cut))
    return [
        Text.assemble(Text(", ").join(ranges), " cannot hold: ", (reason, "quiet"))
        for reason, ranges in together.items()
    ]


def _range(program: Program, cut: Cut) -> Text:
    side = "above" if cut.above else "below"
    value = format_gene(program.space, cut.gene, cut.value)
    return Text.assemble(
        (program.space.names[cut.gene], "warn"), f" {side} {value}", (f" {program.space.units[cut.gene]}", "unit")
    )


def _reason(program: Program, cut: Cut) -> str:
    return ", ".join(program.requirements[r].name for r in cut.requirements) or "whatever else is drawn"


def _ruled_out(program: Program, found: Feasibility) -> str:
    ours = program.code.variant_template >= 0
    return ", ".join(program.requirements[r].name for r in sorted(set(found.impossible[ours].tolist()) - {-1}))


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
"""Diagnostics that are drawn; whoever wants thousands reads them from a document."""


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
        console.print(f"\nand {left:,} more; --format json tells all", soft_wrap=True)


def _drawn(diagnostics: Sequence[Diagnostic]) -> Sequence[Diagnostic]:
    """As many as one would read, errors before all others, in the order of the file."""
    if len(diagnostics) <= MOST_DRAWN:
        return diagnostics
    grave = sorted(range(len(diagnostics)), key=lambda index: diagnostics[index].severity is not Severity.ERROR)
    return [diagnostics[index] for index in sorted(grave[:MOST_DRAWN])]
