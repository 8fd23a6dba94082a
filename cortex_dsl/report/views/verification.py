"""The view of `verify --model dynamic`: the worst cases that also occur with slipping tyres."""

from collections.abc import Sequence

from cortex_dsl.report.blocks import Block, Column, Facts, Gauge, Note, Table, Title, Value, Words
from cortex_dsl.report.findings.readable import ABSENT, counted, percent, speed_unit
from cortex_dsl.report.findings.verification_report import ANSWERS, HOW, beyond_text, counts_text, drive_text
from engine.outcomes import MODEL_RANGE
from engine.program import Program
from engine.search.ranking import Case
from engine.verification import Verified

GRIP = f"the most that the ego uses in the run; above {percent(MODEL_RANGE, 0)} the search's model is not accurate"


def verification_view(program: Program, cases: Sequence[Case], answers: Sequence[Verified]) -> Title:
    """Return the view of `cortexc verify --model dynamic`; `answers` are those of `cases`."""
    if not answers:
        return Title(program.name, [Note("no valid case to drive again", "warn")])
    blocks: list[Block] = [
        Note((Value(counted(len(answers), "case"), "title"), f" driven again: {counts_text(answers)}"))
    ]
    if line := beyond_text(answers):
        blocks.append(Note(line, "quiet"))
    first, grip = (Column("#", numbers=True), Column("risk", numbers=True)), Column("grip", numbers=True)
    drives = Column("the run", wrap=True), Column("dynamic", wrap=True)
    wide, narrow = zip(*(_rows(program, *row) for row in zip(cases, answers, strict=True)), strict=True)
    below = Table((*first, Column("answer", wrap=True), grip), narrow)
    table = Table((*first, Column("answer"), *drives, grip, Column()), wide, name="tests", narrow=below)
    given = [ANSWERS[answer] for answer in ANSWERS if answer in {found.answer for found in answers}]
    legend = [(Value(name, style), Value(text, "quiet")) for name, style, text in given]
    blocks += [
        Title("With slipping tyres", [table]),
        Note(""),
        Facts([*legend, ("grip", Value(GRIP, "quiet"))]),
        Note(HOW, "quiet"),
    ]
    return Title(program.name, blocks)


def _rows(program: Program, case: Case, found: Verified) -> tuple[Sequence[Words], Sequence[Words]]:
    """Return rank, risk, answer, both drives, and the share of the grip in use; then with the drives in one cell."""
    unit, used = speed_unit(program), found.run.combined_grip
    run, dynamic = (drive_text(program, drive, unit) for drive in (found.run, found.dynamic))
    name, answer_style, _ = ANSWERS[found.answer]
    style, known = "warn" if used > MODEL_RANGE else "quiet", used == used
    grip, gauge = Value(percent(used, 0) if known else ABSENT, style), Gauge(style=style, share=used) if known else ""
    first, answer = (Value(str(case.rank), "quiet"), Value(str(case.score), "", case.score)), Value(name, answer_style)
    both = Value(f"\n{' → '.join(filter(None, (run, dynamic)))}", "quiet")
    return (*first, answer, run, dynamic or ABSENT, grip, gauge), (*first, (answer, both), grip)
