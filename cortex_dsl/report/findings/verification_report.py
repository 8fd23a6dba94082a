"""A second opinion: the answers by name, each case in words, and all of it as a document."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from cortex_dsl.report.findings.readable import KM_H, SpeedUnit, counted, fixed, percent
from engine.outcomes import MODEL_RANGE
from engine.program import Program
from engine.search.ranking import Case
from engine.streams import format_key
from engine.verification import NOBODY, Answer, Drive, Verified
from engine.vocabulary import Verdict

ANSWERS: Mapping[Answer, tuple[str, str, str]] = {
    Answer.SURVIVES: ("survives", "bad", "with slipping tyres the danger is the same"),
    Answer.DIFFERS: ("differs", "warn", "with slipping tyres it is dangerous in another way, such as a near miss"),
    Answer.MODEL: ("artefact of the model", "good", "a car with slipping tyres is not in this danger"),
    Answer.STEP: ("artefact of the step", "good", "the model of the search with finer time steps is not in it either"),
    Answer.NOT_JUDGED: ("not judged", "quiet", "no cited tyre data for an ego of this kind"),
    Answer.BACKWARDS: ("not judged: backwards", "quiet", "no cited tyre data for an ego that drives backwards"),
}
"""Name, style in a terminal and meaning of each answer, in the order of reports."""
HOW = (
    "Cars drive by a single-track drift model with load transfer, saturating tyres and anti-lock, under the same "
    "behaviours; others move as before. A case is an artefact of the step where the search's own model avoids it in "
    "steps of 5 ms, or with drivers who look as often, unless they draw random numbers as they act."
)


def drive_text(program: Program, drive: Drive | None, unit: SpeedUnit = KM_H) -> str:
    """`adversary at 34 km/h, 2.10 s`, or how near it came; empty where nothing was driven."""
    if drive is None:
        return ""
    if drive.verdict != Verdict.VALID:
        return f"invalid: {drive.verdict.name.lower()}"
    if drive.collided:
        speed = unit.number(drive.closing_speed, 0)
        return f"{program.actors[drive.partner]} at {speed} {unit.name}, {fixed(drive.time, 2)} s"
    return f"no collision, {fixed(drive.min_distance, 2)} m" if drive.partner != NOBODY else "no other actor met"


def counts_text(answers: Sequence[Verified]) -> str:
    """`8 survive, 1 differs …`: how often there is each answer."""
    counts = Counter(one.answer for one in answers)
    return ", ".join(f"{counts[answer]} {_of_several(answer, counts[answer])}" for answer in ANSWERS if counts[answer])


def _of_several(answer: Answer, count: int) -> str:
    name = ANSWERS[answer][0]
    if count == 1 or answer in (Answer.NOT_JUDGED, Answer.BACKWARDS):
        return name
    return name.replace("artefact", "artefacts") if " " in name else name.removesuffix("s")


def beyond_text(answers: Sequence[Verified]) -> str:
    """Return the number of cases whose grip exceeds the model of the search; empty without any."""
    beyond = sum(one.run.combined_grip > MODEL_RANGE for one in answers)
    if not beyond:
        return ""
    more = f"more than {percent(MODEL_RANGE, 0)} of its grip, beyond the kinematic model"
    return f"in {counted(beyond, 'case')} the ego uses {more}"


def verification_content(program: Program, cases: Sequence[Case], answers: Sequence[Verified]) -> dict[str, Any]:
    """The answers as the content of a document, SI units."""
    return {
        "program": program.digest,
        "model": "dynamic",
        "answers": {ANSWERS[answer][0]: sum(one.answer is answer for one in answers) for answer in Answer},
        "cases": [_case_content(program, *row) for row in zip(cases, answers, strict=True)],
    }


def _case_content(program: Program, case: Case, found: Verified) -> dict[str, Any]:
    return {
        "case": case.rank,
        "key": format_key(case.key),
        "score": case.score,
        "answer": ANSWERS[found.answer][0],
        "sliding": [program.actors[actor] for actor in found.slides],
        "run": _drive_content(program, found.run),
        "finer": _drive_content(program, found.finer),
        "alert": _drive_content(program, found.alert),
        "dynamic": _drive_content(program, found.dynamic),
    }


def _drive_content(program: Program, drive: Drive | None) -> dict[str, Any] | None:
    if drive is None:
        return None
    partner = None if drive.partner == NOBODY else program.actors[drive.partner]
    numbers = {"min_distance" if name == "distances" else name: value for name, value in vars(drive).items()}
    return numbers | {"min_distance": drive.min_distance, "partner": partner, "verdict": drive.verdict.name.lower()}
