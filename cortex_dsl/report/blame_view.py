"""Which requirement throws attempts away: what each does alone, its nearest miss, what to relax, what contradicts."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.layout import columns, left, right
from cortex_dsl.report.numbers import counted, percent, significant
from cortex_dsl.report.params import format_gene
from engine.feasibility import genes_read
from engine.program import Program

if TYPE_CHECKING:
    from engine.acceptance import Account, Blame, Relaxation

MOST_CURES = 3
"""Requirements that are named as cures at most."""
MOST_PARAMS = 4
"""Params of a nearest miss that are shown at most."""


def blame_view(account: "Account") -> RenderableType:
    """The table of all requirements that ever failed, and what follows from it."""
    failing = [blame for blame in account.blames if blame.alone < 1.0]
    if not failing:
        return Text("every requirement always held", "quiet")
    parts: list[RenderableType] = [_table(account, failing)]
    sentences = [_conflict(account), _nearest(account, failing), _cures(account)]
    for sentence in sentences:
        if sentence is not None:
            parts += [Text(), sentence]
    return Group(*parts)


def blame_note(account: "Account") -> str:
    """What the numbers of the table are shares of."""
    weighing = account.weighing
    met = f"{percent(weighing.acceptance, 2)} met all"
    own = " with params of their own" if len(weighing.program.space) else ""
    return f"{counted(len(weighing), 'single attempt')}{own}, each tested on all; {met}"


def _table(account: "Account", failing: Sequence["Blame"]) -> RenderableType:
    head = (left("requirement", wrap=True), right("held alone"), right("accepted without it"), right("nearest miss"))
    rows = [
        (
            Text(account.weighing.program.requirements[blame.requirement].name),
            Text(percent(blame.alone)),
            Text(percent(blame.without, 2)),
            Text(_missed_by(account, blame)),
        )
        for blame in failing
    ]
    return columns(*head, rows=rows, header=True)


def _missed_by(account: "Account", blame: "Blame") -> str:
    return "–" if blame.nearest < 0 else _amount(account, blame.requirement, _shortfall(account, blame))


def _shortfall(account: "Account", blame: "Blame") -> float:
    return -float(account.weighing.margins[blame.nearest, blame.requirement])


def _amount(account: "Account", requirement: int, amount: float) -> str:
    """In the unit in which the file speaks of such things."""
    told = account.weighing.program.requirements[requirement]
    return f"{significant(amount / told.told_scale, 3)} {told.told_unit or told.unit}".rstrip()


def _nearest(account: "Account", failing: Sequence["Blame"]) -> Text | None:
    """The attempt that came nearest to being accepted."""
    missed = [blame for blame in failing if blame.nearest >= 0]
    if not missed or account.weighing.accepted.any():
        return None
    blame = min(missed, key=lambda b: (b.others, b.requirement))
    others = "the only one that failed" if blame.others == 0 else f"with {counted(blame.others, 'other')} that failed"
    text = Text.assemble(
        "nearest miss: ", (_quoted(account, blame.requirement), "warn"), f" by {_missed_by(account, blame)}, {others}"
    )
    params = _params(account, blame)
    return Text.assemble(text, "\n" + params if params else "")


def _params(account: "Account", blame: "Blame") -> str:
    """The params that the requirement depends on, in that attempt."""
    program, genome = account.weighing.program, account.weighing.genomes[blame.nearest]
    genes = genes_read(program, blame.requirement)[:MOST_PARAMS]
    space = program.space
    values = [f"{space.names[g]} = {format_gene(space, g, float(genome[g]))} {space.units[g]}".rstrip() for g in genes]
    return "  " + ", ".join(values) if values else ""


def _name(account: "Account", requirement: int) -> str:
    return account.weighing.program.requirements[requirement].name


def _quoted(account: "Account", requirement: int) -> str:
    return f"`{_name(account, requirement)}`"


def _cures(account: "Account") -> Text | None:
    """Single requirements that would bring acceptance to the target."""
    weighing, target = account.weighing, account.target
    if target is None or weighing.acceptance >= target:
        return None
    if not account.relaxations:
        if account.conflict is not None and len(account.conflict.requirements) == 1:
            return None  # that one has no amount, and has been named
        return Text(f"no single requirement can be relaxed to accept {percent(target, 2)}")
    text = Text(f"to accept {percent(target, 2)}: ")
    for position, relaxation in enumerate(account.relaxations[:MOST_CURES]):
        text.append("\n  or " if position else "")
        text.append_text(_cure(account, relaxation))
    return text


def _cure(account: "Account", relaxation: "Relaxation") -> Text:
    name = _quoted(account, relaxation.requirement), "warn"
    if math.isinf(relaxation.amount):
        return Text.assemble("leave out ", name)
    return Text.assemble("relax ", name, f" by {_amount(account, relaxation.requirement, relaxation.amount)}")


def _conflict(account: "Account") -> Text | None:
    conflict = account.conflict
    if conflict is None:
        return None
    program = account.weighing.program
    known = "proved" if conflict.proved else f"in {counted(len(account.weighing), 'attempt')}"
    names: list[str | tuple[str, str]] = []
    for position, requirement in enumerate(conflict.requirements):
        names += [" and "] if position else []
        names += [(_quoted(account, requirement), "bad"), _place(program, requirement)]
    if len(conflict.requirements) == 1:
        return Text.assemble("never held: ", *names, f"; {known}")
    return Text.assemble("never together: ", *names, f"; {known}")


def cure_of_conflict(account: "Account") -> str:
    """What to do where requirements are proved never to hold; empty where nothing is proved."""
    conflict, program = account.conflict, account.weighing.program
    if conflict is None or not conflict.proved:
        return ""
    ours = [r for r in conflict.requirements if program.requirements[r].line]
    if not ours:
        return "place the objects elsewhere, or widen the range of a param that their places depend on"
    if len(conflict.requirements) > 1:
        return "relax one of those that never hold together, or take it out"
    named = f"{_quoted(account, ours[0])}{_place(program, ours[0])}"
    amounts = [r.amount for r in account.relaxations if r.requirement == ours[0] and math.isfinite(r.amount)]
    return f"relax {named} by {_amount(account, ours[0], amounts[0])}, or take it out" if amounts else f"change {named}"


def _place(program: Program, requirement: int) -> str:
    line = program.requirements[requirement].line
    return f" (line {program.place(line)})" if line else ""


def blame_content(account: "Account") -> dict[str, Any]:
    """The same for a JSON document; margins in SI units, params in the file's own."""
    weighing, program = account.weighing, account.weighing.program
    return {
        "attempts": len(weighing),
        "acceptance": weighing.acceptance,
        "requirements": [_blame_content(account, blame) for blame in account.blames],
        "target": account.target,
        "relax": [
            {
                "name": _name(account, relaxation.requirement),
                "amount": relaxation.amount,
                "unit": program.requirements[relaxation.requirement].unit,
                "acceptance": relaxation.acceptance,
            }
            for relaxation in account.relaxations
        ],
        "conflict": account.conflict
        and {
            "requirements": [_name(account, requirement) for requirement in account.conflict.requirements],
            "proved": account.conflict.proved,
        },
    }


def _blame_content(account: "Account", blame: "Blame") -> dict[str, Any]:
    weighing, program = account.weighing, account.weighing.program
    return {
        "name": _name(account, blame.requirement),
        "line": program.requirements[blame.requirement].line or None,
        "alone": blame.alone,
        "tested": blame.tested,
        "failed": blame.failed,
        "given_earlier": blame.given_earlier,
        "acceptance_without": blame.without,
        "nearest_miss": None
        if blame.nearest < 0
        else {
            "margin": -_shortfall(account, blame),
            "unit": program.requirements[blame.requirement].unit,
            "others_failed": blame.others,
            "params": dict(zip(program.space.names, weighing.genomes[blame.nearest].tolist(), strict=True)),
        },
    }
