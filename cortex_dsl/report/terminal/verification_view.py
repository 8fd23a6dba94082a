"""Output of `cortexc verify --model dynamic`: the worst cases that also occur with slipping tyres."""

from collections.abc import Sequence

from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.findings.readable import ABSENT, SpeedUnit, counted, percent, speed_unit
from cortex_dsl.report.findings.verification_report import ANSWERS, HOW, beyond_text, counts_text, drive_text
from cortex_dsl.report.terminal.theme import bar, columns, heading, left, right, section
from engine.outcomes import MODEL_RANGE
from engine.program import Program
from engine.search.ranking import Case
from engine.verification import Verified

GAUGE = 8
WIDE = 96
"""Console width [characters] from which the answer is next to the drives, not above them."""


def verification_view(
    program: Program, cases: Sequence[Case], answers: Sequence[Verified], width: int
) -> RenderableType:
    """The whole page of `cortexc verify --model dynamic`."""
    if not answers:
        return Group(heading(program.name), Text("no valid case to drive again", "warn"))
    head = Text.assemble((counted(len(answers), "case"), "title"), f" driven again: {counts_text(answers)}")
    parts: list[RenderableType] = [heading(program.name), head]
    if line := beyond_text(answers):
        parts.append(Text(line, "quiet"))
    table = _wide(program, cases, answers) if width >= WIDE else _narrow(program, cases, answers)
    parts += [section("With slipping tyres", table), Text(), _legend(answers), Text(HOW, "quiet")]
    return Group(*parts)


def _wide(program: Program, cases: Sequence[Case], answers: Sequence[Verified]) -> RenderableType:
    unit = speed_unit(program)
    head = right("#"), right("risk"), left("answer"), left("the run", wrap=True), left("dynamic", wrap=True)
    rows = [
        (
            Text(str(case.rank), "quiet"),
            Text(str(case.score)),
            _answer(found),
            Text(drive_text(program, found.run, unit)),
            Text(drive_text(program, found.dynamic, unit) or ABSENT),
            *_grip(found),
        )
        for case, found in zip(cases, answers, strict=True)
    ]
    return columns(*head, right("grip"), left(), rows=rows, header=True)


def _narrow(program: Program, cases: Sequence[Case], answers: Sequence[Verified]) -> RenderableType:
    unit = speed_unit(program)
    rows = [
        (
            Text(str(case.rank), "quiet"),
            Text(str(case.score)),
            Group(_answer(found), Text(_both(program, found, unit), "quiet")),
            _grip(found)[0],
        )
        for case, found in zip(cases, answers, strict=True)
    ]
    return columns(right("#"), right("risk"), left("answer", wrap=True), right("grip"), rows=rows, header=True)


def _both(program: Program, found: Verified, unit: SpeedUnit) -> str:
    parts = drive_text(program, found.run, unit), drive_text(program, found.dynamic, unit)
    return " → ".join(part for part in parts if part)


def _answer(found: Verified) -> Text:
    name, style, _ = ANSWERS[found.answer]
    return Text(name, style)


def _grip(found: Verified) -> tuple[Text, Text]:
    used = found.run.combined_grip
    if used != used:
        return Text(ABSENT, "quiet"), Text("")
    style = "warn" if used > MODEL_RANGE else "quiet"
    return Text(percent(used, 0), style), Text(bar(used, 1.0, GAUGE), style)


def _legend(answers: Sequence[Verified]) -> RenderableType:
    """Return the meanings of the answers that occur."""
    given = {found.answer for found in answers}
    rows = [
        (Text(name, style), Text(text, "quiet")) for answer, (name, style, text) in ANSWERS.items() if answer in given
    ]
    return columns(left(), left(wrap=True), rows=[*rows, (Text("grip"), Text(_GRIP, "quiet"))])


_GRIP = f"the most that the ego uses in the run; above {percent(MODEL_RANGE, 0)} the search's model is not accurate"
