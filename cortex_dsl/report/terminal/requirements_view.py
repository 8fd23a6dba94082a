"""Requirements by how often they hold: their counts, which one throws attempts away, and why there is no scene."""

import math
from collections.abc import Collection, Iterator, Sequence
from typing import TYPE_CHECKING

from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.findings.readable import column_decimals, counted, fixed, percent, whole
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
from cortex_dsl.report.terminal.theme import bar, columns, indented, left, right, section
from engine.program import Program
from engine.vocabulary import GeneKind, Verdict

if TYPE_CHECKING:
    from engine.acceptance import AcceptanceStatistics, Account, Blame, Relaxation
    from engine.tables import Floats


BAR = 12


def requirements_table(program: Program, tally: Tally, culprit: int | None) -> RenderableType:
    """Counts are conditional: a requirement is tested only if the earlier ones held."""
    rows = []
    for index, requirement in enumerate(program.requirements):
        tested, rate = int(tally.tested[index]), tally.pass_rate(index)
        style = "warn" if index == culprit else "" if tested else "quiet"
        rows.append(
            (
                Text(requirement.name, style),
                Text(program.place(requirement.line) if requirement.line else "–", "quiet"),
                Text(whole(tested), style),
                Text(whole(int(tally.failed[index])), style),
                Text(percent(rate), style),
                Text(bar(rate, 1.0, BAR), "warn" if index == culprit else "bar"),
            )
        )
    head = (left("requirement", wrap=True), right("line"), right("tested"), right("failed"), right("held"), left(""))
    return columns(*head, rows=rows, header=True)


def culprit_line(program: Program, tally: Tally, culprit: int | None) -> Text:
    """One sentence about the first culprit."""
    if culprit is None:
        return Text("every requirement always held", "quiet")
    requirement, rate = program.requirements[culprit], tally.pass_rate(culprit)
    where = f" (line {program.place(requirement.line)})" if requirement.line else " (built in)"
    often = "never held" if rate == 0.0 else f"held in {percent(rate)} of its tests"
    return Text.assemble("first culprit: ", (requirement.name, "warn"), where, f" {often}")


def requirements_view(program: Program, tally: Tally, culprit: int | None = None) -> RenderableType:
    """The table and its culprit, which the counts show where nothing better is known."""
    culprit = first_culprit(program, tally) if culprit is None else culprit
    return Group(requirements_table(program, tally, culprit), Text(), culprit_line(program, tally, culprit))


# -- causes of rejected attempts: each requirement alone, its nearest miss, and a relaxation ---------------------------

MOST_CURES = 3
"""Requirements that are named as cures, and objects that leave the road, at most."""


def blame_view(account: "Account") -> RenderableType:
    """Return the table of all requirements that failed at least once, and the conclusions."""
    failing = [blame for blame in account.blames if blame.alone < 1.0]
    if not failing:
        return Text("every requirement always held", "quiet")
    parts: list[RenderableType] = [_blame_table(account, failing)]
    sentences = [_conflict(account), _off_road(account), _nearest(account, failing), _cures(account)]
    for sentence in sentences:
        if sentence is not None:
            parts += [Text(), sentence]
    return Group(*parts)


def _blame_table(account: "Account", failing: Sequence["Blame"]) -> RenderableType:
    head = (left("requirement", wrap=True), right("held alone"), right("accepted without it"), right("nearest miss"))
    rows = [
        (
            Text(account.weighing.program.requirements[blame.requirement].name),
            Text(percent(blame.alone)),
            Text(percent(blame.without, 2)),
            Text(missed_by(account, blame)),
        )
        for blame in failing
    ]
    return columns(*head, rows=rows, header=True)


def _off_road(account: "Account") -> Text | None:
    """Return the objects that leave the road, and the cause."""
    weighing = account.weighing
    if not weighing.off_road:
        return None
    names = [weighing.program.actors[each.actor] for each in weighing.off_road[:MOST_CURES]]
    lines = [
        Text.assemble("off the road: ", (f"`{name}`", "warn"), f" in {percent(each.share)} of the rejected attempts")
        for name, each in zip(names, weighing.off_road, strict=False)
    ]
    road = account.blames[weighing.program.first_built_in]
    if road.alone == 0.0 or road.without > weighing.acceptance:  # else no attempt is rejected for that alone
        lines.append(Text(f"place `{names[0]}` elsewhere, or let it stand off the road: `with regionContainedIn None`"))
    return Text("\n").join(lines)


def _nearest(account: "Account", failing: Sequence["Blame"]) -> Text | None:
    """The attempt that came nearest to being accepted."""
    missed = [blame for blame in failing if blame.nearest >= 0]
    if not missed or account.weighing.accepted.any():
        return None
    blame = min(missed, key=lambda b: (b.others, b.requirement))
    others = "the only one that failed" if blame.others == 0 else f"with {counted(blame.others, 'other')} that failed"
    text = Text.assemble(
        "nearest miss: ", (quoted(account, blame.requirement), "warn"), f" by {missed_by(account, blame)}, {others}"
    )
    params = params_of_miss(account, blame)
    return Text.assemble(text, "\n" + params if params else "")


def _cures(account: "Account") -> Text | None:
    """Single requirements that would bring acceptance to the target."""
    weighing, target = account.weighing, account.target
    if target is None or weighing.acceptance >= target:
        return None
    if not account.relaxations:
        if account.conflict is not None and len(account.conflict.requirements) == 1:
            return None  # it has no amount, and has been named
        return Text(f"no single requirement can be relaxed to accept {percent(target, 2)}")
    text = Text(f"to accept {percent(target, 2)}: ")
    for position, relaxation in enumerate(account.relaxations[:MOST_CURES]):
        text.append("\n  or " if position else "")
        text.append_text(_cure(account, relaxation))
    return text


def _cure(account: "Account", relaxation: "Relaxation") -> Text:
    name = quoted(account, relaxation.requirement), "warn"
    if math.isinf(relaxation.amount):
        return Text.assemble("leave out ", name)
    return Text.assemble("relax ", name, f" by {amount_text(account, relaxation.requirement, relaxation.amount)}")


def _conflict(account: "Account") -> Text | None:
    conflict = account.conflict
    if conflict is None:
        return None
    program = account.weighing.program
    known = "proved" if conflict.proved else f"in {counted(len(account.weighing), 'attempt')}"
    names: list[str | tuple[str, str]] = []
    for position, requirement in enumerate(conflict.requirements):
        names += [" and "] if position else []
        names += [(quoted(account, requirement), "bad"), place_text(program, requirement)]
    if len(conflict.requirements) == 1:
        return Text.assemble("never held: ", *names, f"; {known}")
    return Text.assemble("never together: ", *names, f"; {known}")


# -- effect of one more requirement: acceptance before and after, and the remaining params -----------------------------

WEIGHING_BAR = 16
LEAST_SHRINK = 0.05
"""Share of a range that must be gone before it is shown."""
FEWEST = 40
"""Accepted draws below which their range says little."""
MOST_ROWS = 8


def weighing_view(
    before: "AcceptanceStatistics | None", account: "Account", fresh: Collection[int], *, ascii_only: bool = False
) -> RenderableType:
    """`fresh`: the requirements that were entered just now."""
    after = account.weighing
    parts: list[RenderableType] = [_acceptance_line(before, after, ascii_only=ascii_only)]
    if not after.accepted.any():
        return Group(*parts, indented(blame_view(account)))
    failing = [b for b in account.blames if b.alone < 1.0 or b.requirement in fresh]
    shown = [b for b in failing if b.requirement in fresh] + [b for b in failing if b.requirement not in fresh]
    if shown:
        kept = sorted(shown[:MOST_ROWS], key=failing.index)
        parts.append(indented(_weighing_table(account, kept, fresh, ascii_only=ascii_only)))
    if remains := list(_remains(before, after)):
        parts.append(indented(Text.assemble(("left of ", "quiet"), Text(", ").join(remains))))
    return Group(*parts)


def _acceptance_line(before: "AcceptanceStatistics | None", after: "AcceptanceStatistics", *, ascii_only: bool) -> Text:
    new = percent(after.acceptance, 2 if after.acceptance < 0.1 else 1)
    style = "bad" if after.acceptance == 0 else "warn" if after.acceptance < 0.01 else "good"
    if before is None or before.acceptance == after.acceptance:
        return Text.assemble((new, style), " of draws accepted", ("" if before is None else ", as before", "quiet"))
    old = percent(before.acceptance, 2 if before.acceptance < 0.1 else 1)
    arrow = "->" if ascii_only else "→"
    return Text.assemble((f"{old} {arrow} ", "quiet"), (new, style), " of draws accepted")


def _weighing_table(
    account: "Account", blames: "list[Blame]", fresh: Collection[int], *, ascii_only: bool
) -> RenderableType:
    rows = []
    for blame in blames:
        style = "title" if blame.requirement in fresh else ""
        filled = "#" * round(blame.alone * WEIGHING_BAR) if ascii_only else bar(blame.alone, 1.0, WEIGHING_BAR)
        name = account.weighing.program.requirements[blame.requirement].name
        rows.append(
            (
                Text(name, style),
                Text(filled, "bar"),
                Text(percent(blame.alone)),
                Text(percent(blame.given_earlier)),
            )
        )
    head = (left("", wrap=True), left("holds"), right("alone"), right("after earlier"))
    return columns(*head, rows=rows, header=True)


def _remains(before: "AcceptanceStatistics | None", after: "AcceptanceStatistics") -> Iterator[Text]:
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
            yield Text.assemble((name, "title"), f" {ends}", (f" {space.units[gene]}".rstrip(), "unit"))


def _range(values: "Floats") -> tuple[float, float]:
    return float(values.min()), float(values.max())


# -- reasons without any scene: every requirement with its counts, the params of the attempt, and the cure -------------

REASONS = {
    Verdict.INFEASIBLE: "the requirements contradict each other for these params",
    Verdict.EXHAUSTED: "no attempt met every requirement",
}


def exhausted_view(
    program: Program,
    tally: Tally,
    verdict: Verdict,
    genome: Sequence[float],
    account: "Account | None" = None,
) -> RenderableType:
    """Return the report for exit code 3 if nothing could be run; `verdict` is a key of `REASONS`."""
    parts: list[RenderableType] = [Text.assemble(("no valid scene", "bad"), _tried(tally, verdict))]
    if len(tally.tested):
        parts.append(section("Requirements", requirements_view(program, tally), "tested only if the earlier ones held"))
    if account is not None:
        parts.append(section("Which requirement is to blame", blame_view(account), blame_note(account)))
    if len(program.space) and tally.scenes == 1:
        from cortex_dsl.report.terminal.render import rendered
        from cortex_dsl.report.views.measures import params_table

        parts.append(section("Params of this attempt", rendered(params_table(program.space, genome), 80)))
    parts += [Text(), _help_line(account)]
    return Group(*parts)


def _tried(tally: Tally, verdict: Verdict) -> str:
    if tally.scenes == 0:
        return " can be drawn from this file; that is proved, so none was tried"
    draws = f" over {counted(tally.scenes, 'draw')} of the params" if tally.scenes > 1 else ""
    return f" in {counted(tally.attempts, 'attempt')}{draws}: {REASONS[verdict]}"


def _help_line(account: "Account | None") -> Text:
    if account is not None and (cure := cure_of_conflict(account)):
        return Text(f"help: {cure}")
    return Text("help: another --seed, a wider range or window in the file, or more --max-attempts")
