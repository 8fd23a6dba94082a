"""Results of the objectives of the file in one run: broken expectations, and values of the objectives."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from engine.outcomes import Outcomes
from engine.program import Program
from engine.tables import Floats
from engine.vocabulary import EndReason, RuleKind, Sense, Verdict


@dataclass(frozen=True)
class ObjectiveResult:
    """One objective of one run."""

    name: str
    line: int
    sense: Sense
    value: float
    """Value of the objective; for an `expect` its robustness: above 0 if it holds, below 0 if it is broken."""
    unit: str
    broken: bool | None
    """Whether an `expect` is broken; None for a number."""


def objective_results(program: Program, outcomes: Outcomes, row: int = 0) -> tuple[ObjectiveResult, ...]:
    """Return the results in the order of the file; () for an invalid run."""
    if outcomes.verdict[row] != 0:
        return ()
    values, broken = outcomes.sought[row].tolist(), outcomes.broken[row].tolist()
    return tuple(
        ObjectiveResult(
            each.name, each.line, each.sense, value, each.unit, bool(fails) if each.sense is Sense.EXPECT else None
        )
        for each, value, fails in zip(program.judged.objectives, values, broken, strict=True)
    )


def objectives_content(found: Sequence[ObjectiveResult]) -> list[dict[str, Any]]:
    """Return the results in the form of a document."""
    return [
        {
            "name": each.name,
            "sense": each.sense.name.lower(),
            "line": each.line,
            "broken": each.broken,
            "robustness" if each.sense is Sense.EXPECT else "value": each.value,
            "unit": each.unit,
        }
        for each in found
    ]


def broken_words(found: Sequence[ObjectiveResult]) -> str:
    """`breaks "no contact" and "room"`; "" where nothing is broken."""
    names = [f'"{each.name}"' for each in found if each.broken]
    if not names:
        return ""
    return "breaks " + (names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}")


# -- results of each in many runs --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Weighed:
    """An objective, or a requirement on the run, in some runs of scenes as the file draws them."""

    name: str
    line: int
    sense: Sense | None
    """Sense; None: a requirement, whose runs exclude those rejected for another reason."""
    unit: str
    values: Floats
    """(runs,) robustness, or the number; of a requirement 1 where it was met, else -1."""
    kept: int
    """Runs in which an `expect` or a requirement holds."""

    @property
    def runs(self) -> int:
        return len(self.values)


def weighed_objectives(program: Program, outcomes: Outcomes) -> tuple[Weighed, ...]:
    """Objectives and requirements on the run, in the order of the file."""
    valid = outcomes.verdict == Verdict.VALID
    found = [
        Weighed(each.name, each.line, each.sense, each.unit, values[valid], int((broken[valid] == 0.0).sum()))
        for each, values, broken in zip(program.judged.objectives, outcomes.sought.T, outcomes.broken.T, strict=True)
    ]
    for number, rule in enumerate(program.rules):
        if rule.kind is RuleKind.ABORT:
            broken = (outcomes.end_reason == EndReason.ABORTED) & (outcomes.end_rule == number)
            met = np.where(broken, -1.0, 1.0)[valid | broken]
            found.append(Weighed(rule.name, rule.line, None, "", met, int((met > 0.0).sum())))
    return tuple(sorted(found, key=lambda each: each.line))
