"""Sampled scenes: counts of verdicts and attempts, and the endings of those that an external driver drove."""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from cortex_dsl.report.blocks import Block, Column, Gauge, Note, Table, Title, Value, Words
from cortex_dsl.report.findings.driven_runs import ENDINGS, DrivenRuns, Ending
from cortex_dsl.report.findings.readable import counted, percent, ratio, whole
from cortex_dsl.report.findings.tally import Tally, most_to_blame
from cortex_dsl.report.views.requirements import requirements_view
from cortex_dsl.report.views.run import title_of
from engine.program import Program
from engine.search.statistics import clopper_pearson
from engine.vocabulary import Verdict

if TYPE_CHECKING:
    from engine.acceptance import Account

VERDICTS: Sequence[tuple[Verdict, str, str]] = (
    (Verdict.VALID, "good", "a scene was found"),
    (Verdict.EXHAUSTED, "warn", "no attempt passed"),
    (Verdict.INFEASIBLE, "warn", "shown impossible before sampling"),
    (Verdict.ABORTED, "warn", "broke a rule while it ran"),
    (Verdict.ERROR, "bad", "a bug in cortexc"),
)
BAR = 16


def sample_view(
    program: Program,
    tally: Tally,
    seconds: float,
    reproduce: str,
    account: "Account | None" = None,
    driven: Title | None = None,
) -> Title:
    """Return the whole report of `--sample N`; `seconds`: of drawing alone, 0 where that is not known."""
    rate = tally.attempts / seconds if seconds > 0 else 0.0
    attempts: Words = (
        f"{counted(tally.attempts, 'attempt')}, {percent(tally.acceptance)} of them accepted",
        Value(f"  {rate / 1e6:.1f} million a second" if rate > 1e5 else "", "quiet"),
    )
    drawn = [verdicts_table(tally), Note(attempts, apart=True), *_params_notes(program, tally)]
    requirements = requirements_view(program, tally, most_to_blame(program, tally, account), account=account)
    blocks: list[Block] = [Title(counted(tally.scenes, "scene"), drawn, reproduce)]
    return title_of(program, [*blocks, *([] if driven is None else [driven]), *requirements])


def _params_notes(program: Program, tally: Tally) -> list[Note]:
    """Return lines on the scope of an attempt, and on draws of the params that allow no scene."""
    if not len(program.space):
        return []
    hopeless = int(tally.verdicts[Verdict.INFEASIBLE])
    notes = [Note("params are drawn once for each scene; each attempt draws all the rest again", "quiet")]
    if hopeless:
        text = f"{hopeless:,} of {counted(tally.scenes, 'draw')} of the params can have no scene"
        notes.append(Note(text, "warn"))
    return notes


def verdicts_table(tally: Tally) -> Table:
    """Return every verdict that occurred, and `valid` always."""
    return _shares(
        tally.scenes, ((name.name.lower(), style, int(tally.verdicts[name]), said) for name, style, said in VERDICTS)
    )


def _shares(total: int, rows: Iterable[tuple[str, str, int, str]]) -> Table:
    """Return word, count, share and meaning of the first row, and of each other that occurred."""
    shown = [
        (
            Value(word, style),
            whole(count),
            percent(ratio(count, total)),
            Gauge(share=ratio(count, total), length=BAR, style=style),
            Value(meaning, "quiet"),
        )
        for number, (word, style, count, meaning) in enumerate(rows)
        if count or not number
    ]
    numbers = Column(numbers=True), Column(numbers=True)
    return Table((Column(), *numbers, Column(rank=1), Column(wrap=True)), shown, header=False)


def driven_view(runs: DrivenRuns, driver: str) -> Title:
    """Return the endings of scenes that an external driver drove."""
    rows = ((word, style, runs[ending], meaning) for ending, (word, style, meaning) in ENDINGS.items())
    blocks: list[Block] = [_shares(runs.driven, rows)]
    if runs.valid:
        low, high = runs.interval
        rate = f"{percent(ratio(runs.collisions, runs.valid), 2)} of {counted(runs.valid, 'run')}"
        interval = f"95 % interval {percent(low, 2)} .. {percent(high, 2)}"
        blocks.append(Note(f"collisions in {rate}; {interval}", apart=True))
        if runs[Ending.CONTROLLER]:
            text = "its lower end counts scenes in which the driver failed as safe, its upper end as collisions"
            blocks.append(Note(text))
        for name, broken in runs.broken.items():
            low, high = clopper_pearson(broken, runs.valid, unknown=runs[Ending.CONTROLLER])
            rate = f"{percent(ratio(broken, runs.valid), 2)} of {counted(runs.valid, 'run')}"
            blocks.append(Note(f"`{name}` broken in {rate}; 95 % interval {percent(low, 2)} .. {percent(high, 2)}"))
    return Title(f"{counted(runs.driven, 'scene')} driven", blocks, f"by {driver}")
