"""What `--check` says of a file's ranges: which part of each can hold at all, and why."""

from collections.abc import Sequence
from typing import Any

from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.layout import indented
from cortex_dsl.report.numbers import counted
from cortex_dsl.report.params import format_gene
from engine.feasibility import Cut, Feasibility
from engine.program import Program


def feasibility_view(program: Program, found: Feasibility) -> RenderableType | None:
    """A line for each reason that cuts ranges, and one for impossible variants; None where there are none."""
    lines = _cut_ranges(program, found.cuts)
    rejected = int((program.code.variant_template < 0).sum())
    impossible = int((found.impossible >= 0).sum()) - rejected
    if impossible:
        who = Text.assemble(counted(impossible, "variant"), " cannot be: ", (_ruled_out(program, found), "quiet"))
        lines.append(who)
    return indented(Group(*lines)) if lines else None


def feasibility_content(program: Program, found: Feasibility) -> dict[str, Any]:
    """The same for a JSON document; params in the file's own units."""
    names = [requirement.name for requirement in program.requirements]
    return {
        "looked_at": found.looked_at,
        "infeasible": found.infeasible,
        "conflict": [names[r] for r in found.conflict],
        "cuts": [_cut_content(program, cut) for cut in found.cuts],
        "variants": len(found.impossible),
        "impossible_variants": int((found.impossible >= 0).sum()),
    }


def _cut_content(program: Program, cut: Cut) -> dict[str, Any]:
    return {
        "param": program.space.names[cut.gene],
        "unit": program.space.units[cut.gene],
        "side": "above" if cut.above else "below",
        "value": cut.value,
        "requirements": [program.requirements[r].name for r in cut.requirements],
    }


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
