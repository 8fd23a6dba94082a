"""Requirements by how often they hold: their counts, the one that rejects most attempts, and why there is no scene."""

import math
from collections.abc import Collection, Iterator, Sequence
from typing import TYPE_CHECKING

from cortex_dsl.report.blocks import Block, Column, Gauge, Note, Table, Title, Value, Words
from cortex_dsl.report.findings.readable import ABSENT, column_decimals, counted, fixed, percent, whole
from cortex_dsl.report.findings.tally import (
    Tally,
    amount_text,
    blame_note,
    cure_of_conflict,
    first_culprit,
    missed_by,
    params_of_miss,
    place_text,
    quoted,
)
from cortex_dsl.report.views.measures import params_table
from engine.program import Program
from engine.vocabulary import GeneKind, Verdict

if TYPE_CHECKING:
    from engine.acceptance import AcceptanceStatistics, Account, Blame, Relaxation
    from engine.tables import Floats

BAR = 12
CONDITIONAL = "tested only if the earlier ones held"
ALWAYS = "every requirement always held"


def requirements_view(
    program: Program, tally: Tally, culprit: int | None = None, account: "Account | None" = None
) -> list[Title]:
    """Return the counts of each requirement with their culprit, and which one is to blame where that was examined.

    culprit: by default, the one that the counts show.
    """
    culprit = first_culprit(program, tally) if culprit is None else culprit
    blocks = [_requirements_table(program, tally, culprit), _culprit_note(program, tally, culprit)]
    blame = [] if account is None else [blame_view(account)]
    return [Title("Requirements", blocks, CONDITIONAL), *blame]


def _requirements_table(program: Program, tally: Tally, culprit: int | None) -> Table:
    """Return the counts; they are conditional, since a requirement is tested only if the earlier ones held."""
    rows: list[tuple[Words, ...]] = []
    for index, requirement in enumerate(program.requirements):
        tested, failed, rate = int(tally.tested[index]), int(tally.failed[index]), tally.pass_rate(index)
        style = "warn" if index == culprit else "" if tested else "quiet"
        rows.append(
            (
                Value(requirement.name, style),
                Value(program.place(requirement.line) if requirement.line else ABSENT, "quiet"),
                Value(whole(tested), style),
                Value(whole(failed), style),
                Value(percent(rate), style),
                Gauge(share=rate, length=BAR, style="warn" if index == culprit else "bar"),
            )
        )
    numbers = (Column(name, numbers=True, rank=rank) for name, rank in (("tested", 2), ("failed", 3), ("held", 0)))
    columns = (Column("requirement", wrap=True), Column("line", numbers=True, rank=1), *numbers, Column(rank=4))
    return Table(columns, rows)


def _culprit_note(program: Program, tally: Tally, culprit: int | None) -> Note:
    """Return one sentence about the first culprit."""
    if culprit is None:
        return Note(ALWAYS, "quiet", apart=True)
    requirement, rate = program.requirements[culprit], tally.pass_rate(culprit)
    where = place_text(program, culprit) or " (built in)"
    often = "never held" if rate == 0.0 else f"held in {percent(rate)} of its tests"
    return Note(("first culprit: ", Value(requirement.name, "warn"), f"{where} {often}"), apart=True)


# -- causes of rejected attempts: each requirement alone, its nearest miss, and a relaxation ---------------------------

MOST_CURES = 3
"""Requirements that are named as cures, and objects that leave the road, at most."""


def blame_view(account: "Account") -> Title:
    """Return all requirements that failed at least once, and the conclusions."""
    return Title("Which requirement is to blame", _blame_blocks(account), blame_note(account))


def _blame_blocks(account: "Account") -> list[Block]:
    failing = [blame for blame in account.blames if blame.alone < 1.0]
    if not failing:
        return [Note(ALWAYS, "quiet")]
    sentences = (_conflict(account), _off_road(account), _nearest(account, failing), _cures(account))
    return [_blame_table(account, failing), *(note for notes in sentences for note in notes)]


def _blame_table(account: "Account", failing: Sequence["Blame"]) -> Table:
    heads = ("held alone", "accepted without it", "nearest miss")
    rows = [
        (
            account.weighing.program.requirements[blame.requirement].name,
            percent(blame.alone),
            percent(blame.without, 2),
            missed_by(account, blame),
        )
        for blame in failing
    ]
    numbers = (Column(head, numbers=True, rank=rank) for head, rank in zip(heads, (0, 1, 2), strict=True))
    return Table((Column("requirement", wrap=True), *numbers), rows)


def _off_road(account: "Account") -> list[Note]:
    """Return the objects that leave the road, and the cause."""
    weighing = account.weighing
    if not weighing.off_road:
        return []
    names = [weighing.program.actors[each.actor] for each in weighing.off_road[:MOST_CURES]]
    notes = [
        Note(
            ("off the road: ", Value(f"`{name}`", "warn"), f" in {percent(each.share)} of the rejected attempts"),
            apart=not position,
        )
        for position, (name, each) in enumerate(zip(names, weighing.off_road, strict=False))
    ]
    road = account.blames[weighing.program.first_built_in]
    if road.alone == 0.0 or road.without > weighing.acceptance:  # else no attempt is rejected for that alone
        notes.append(Note(f"place `{names[0]}` elsewhere, or let it stand off the road: `with regionContainedIn None`"))
    return notes


def _nearest(account: "Account", failing: Sequence["Blame"]) -> list[Note]:
    """Return the attempt that came nearest to being accepted."""
    missed = [blame for blame in failing if blame.nearest >= 0]
    if not missed or account.weighing.accepted.any():
        return []
    blame = min(missed, key=lambda b: (b.others, b.requirement))
    others = "the only one that failed" if blame.others == 0 else f"with {counted(blame.others, 'other')} that failed"
    name = Value(quoted(account, blame.requirement), "warn")
    params = params_of_miss(account, blame)
    nearest = Note(("nearest miss: ", name, f" by {missed_by(account, blame)}, {others}"), apart=True)
    return [nearest, *([Note(params)] if params else [])]


def _cures(account: "Account") -> list[Note]:
    """Return single requirements that would bring acceptance to the target."""
    weighing, target = account.weighing, account.target
    if target is None or weighing.acceptance >= target:
        return []
    if not account.relaxations:
        if account.conflict is not None and len(account.conflict.requirements) == 1:
            return []  # it has no amount, and has been named
        return [Note(f"no single requirement can be relaxed to accept {percent(target, 2)}", apart=True)]
    cures = account.relaxations[:MOST_CURES]
    begins = [f"to accept {percent(target, 2)}: ", *["  or "] * (len(cures) - 1)]
    return [
        Note((begin, *_cure(account, cure)), apart=cure is cures[0]) for begin, cure in zip(begins, cures, strict=True)
    ]


def _cure(account: "Account", relaxation: "Relaxation") -> tuple[str | Value, ...]:
    name = Value(quoted(account, relaxation.requirement), "warn")
    if math.isinf(relaxation.amount):
        return "leave out ", name
    return "relax ", name, f" by {amount_text(account, relaxation.requirement, relaxation.amount)}"


def _conflict(account: "Account") -> list[Note]:
    conflict = account.conflict
    if conflict is None:
        return []
    program = account.weighing.program
    known = "proved" if conflict.proved else f"in {counted(len(account.weighing), 'attempt')}"
    words: list[str | Value] = ["never held: " if len(conflict.requirements) == 1 else "never together: "]
    for position, requirement in enumerate(conflict.requirements):
        words += [" and "] if position else []
        words += [Value(quoted(account, requirement), "bad"), place_text(program, requirement)]
    return [Note((*words, f"; {known}"), apart=True)]


# -- effect of one more requirement: acceptance before and after, and the remaining params -----------------------------

WEIGHING_BAR = 16
LEAST_SHRINK = 0.05
"""Share of a range that must be gone before it is shown."""
FEWEST = 40
"""Accepted draws below which their range says little."""
MOST_ROWS = 8


def weighing_view(
    before: "AcceptanceStatistics | None", account: "Account", fresh: Collection[int]
) -> tuple[Note, list[Block]]:
    """Return acceptance before and after, and the blocks below that line; `fresh`: the requirements entered now."""
    after = account.weighing
    line = _acceptance_note(before, after)
    if not after.accepted.any():
        return line, _blame_blocks(account)
    failing = [b for b in account.blames if b.alone < 1.0 or b.requirement in fresh]
    shown = [b for b in failing if b.requirement in fresh] + [b for b in failing if b.requirement not in fresh]
    blocks: list[Block] = []
    if shown:
        blocks.append(_weighing_table(account, sorted(shown[:MOST_ROWS], key=failing.index), fresh))
    words: list[str | Value] = [Value("left of ", "quiet")]
    for position, remains in enumerate(_remaining_ranges(before, after)):
        words += [", "] if position else []
        words += remains
    return line, [*blocks, *([Note(words)] if len(words) > 1 else [])]


def _acceptance_note(before: "AcceptanceStatistics | None", after: "AcceptanceStatistics") -> Note:
    new = percent(after.acceptance, 2 if after.acceptance < 0.1 else 1)
    style = "bad" if after.acceptance == 0 else "warn" if after.acceptance < 0.01 else "good"
    if before is None or before.acceptance == after.acceptance:
        return Note((Value(new, style), " of draws accepted", Value("" if before is None else ", as before", "quiet")))
    old = percent(before.acceptance, 2 if before.acceptance < 0.1 else 1)
    return Note((Value(f"{old} → ", "quiet"), Value(new, style), " of draws accepted"))


def _weighing_table(account: "Account", blames: "list[Blame]", fresh: Collection[int]) -> Table:
    rows = [
        (
            Value(
                account.weighing.program.requirements[blame.requirement].name,
                "title" if blame.requirement in fresh else "",
            ),
            Gauge(share=blame.alone, length=WEIGHING_BAR, style="bar"),
            percent(blame.alone),
            percent(blame.given_earlier),
        )
        for blame in blames
    ]
    columns = (Column(wrap=True), Column("holds", rank=2), Column("alone", numbers=True))
    return Table((*columns, Column("after earlier", numbers=True, rank=1)), rows)


def _remaining_ranges(
    before: "AcceptanceStatistics | None", after: "AcceptanceStatistics"
) -> Iterator[tuple[str | Value, ...]]:
    """Yield the remaining range of each param that shrank clearly."""
    space = after.program.space
    rows = after.genomes[after.accepted]
    if len(rows) < FEWEST:
        return
    least = max(LEAST_SHRINK, 8.0 / len(rows))
    same = before is not None and before.program.space.names == space.names and before.accepted.any()
    old = before.genomes[before.accepted] if same and before is not None else after.genomes
    for gene, name in enumerate(space.names):
        if space.kinds[gene] == GeneKind.INDEX:
            continue
        (low, high), (old_low, old_high) = _range(rows[:, gene]), _range(old[:, gene])
        if (old_high - old_low) - (high - low) > least * float(space.high[gene] - space.low[gene]):
            decimals = max(0, column_decimals(float(space.low[gene]), float(space.high[gene])) - 1)
            ends = " .. ".join(fixed(value, decimals) for value in (low, high))
            yield Value(name, "title"), f" {ends}", Value(f" {space.units[gene]}".rstrip(), "unit")


def _range(values: "Floats") -> tuple[float, float]:
    return float(values.min()), float(values.max())


# -- reasons without any scene: every requirement with its counts, the params of the attempt, and the cure -------------

REASONS = {
    Verdict.INFEASIBLE: "the requirements contradict each other for these params",
    Verdict.EXHAUSTED: "no attempt met every requirement",
}


def no_scene_view(
    program: Program,
    tally: Tally,
    verdict: Verdict,
    genome: Sequence[float],
    account: "Account | None" = None,
) -> list[Block]:
    """Return the report for exit code 3 if nothing could be run; `verdict` is a key of `REASONS`."""
    blocks: list[Block] = [Note((Value("no valid scene", "bad"), _tried(tally, verdict)))]
    if len(tally.tested):
        blocks += requirements_view(program, tally, account=account)
    elif account is not None:
        blocks.append(blame_view(account))
    if len(program.space) and tally.scenes == 1:
        blocks.append(Title("Params of this attempt", [params_table(program.space, genome)]))
    return [*blocks, help_note(account)]


def _tried(tally: Tally, verdict: Verdict) -> str:
    if tally.scenes == 0:
        return " can be drawn from this file; that is proved, so none was tried"
    draws = f" over {counted(tally.scenes, 'draw')} of the params" if tally.scenes > 1 else ""
    return f" in {counted(tally.attempts, 'attempt')}{draws}: {REASONS[verdict]}"


def help_note(account: "Account | None") -> Note:
    """Return a cure where no scene was valid."""
    cure = "" if account is None else cure_of_conflict(account)
    return Note(
        f"help: {cure or 'another --seed, a wider range or window in the file, or more --max-attempts'}", apart=True
    )
