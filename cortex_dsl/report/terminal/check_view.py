"""Output of `--check` on a file's ranges: the feasible part of each, and the reason."""

from collections.abc import Sequence

from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.findings.readable import counted, format_gene
from cortex_dsl.report.terminal.theme import indented
from engine.feasibility import Cut, Feasibility
from engine.program import Program


def feasibility_view(program: Program, found: Feasibility) -> RenderableType | None:
    """Return a line for each reason that cuts ranges, and one for impossible variants; None without any."""
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
