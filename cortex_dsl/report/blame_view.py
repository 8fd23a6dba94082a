"""Which requirement throws attempts away: what each does alone, its nearest miss, what to relax, what contradicts."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.layout import columns, left, right
from cortex_dsl.report.numbers import counted, percent
from cortex_dsl.report.tally import _amount, _missed_by, _params, _place, _quoted

if TYPE_CHECKING:
    from engine.blame import Account, Blame, Relaxation

MOST_CURES = 3
"""Requirements that are named as cures at most."""


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
