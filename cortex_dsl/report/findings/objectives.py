"""What the objectives of a file came to in one run: which expectations are broken, and the numbers that are sought."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from engine.outcomes import Outcomes
from engine.program import Program
from engine.vocabulary import Sense


@dataclass(frozen=True)
class Sought:
    """One objective of one run."""

    name: str
    line: int
    sense: Sense
    value: float
    """Of an `expect` its robustness: above 0 kept, below 0 broken."""
    unit: str
    broken: bool | None
    """Of an `expect`; None of a number."""


def sought_of(program: Program, outcomes: Outcomes, row: int = 0) -> tuple[Sought, ...]:
    """In the order of the file; none of a run that is not valid."""
    if outcomes.verdict[row] != 0:
        return ()
    values, broken = outcomes.sought[row].tolist(), outcomes.broken[row].tolist()
    return tuple(
        Sought(each.name, each.line, each.sense, value, each.unit, bool(fails) if each.sense is Sense.EXPECT else None)
        for each, value, fails in zip(program.judged.objectives, values, broken, strict=True)
    )


def objectives_content(found: Sequence[Sought]) -> list[dict[str, Any]]:
    """As a document has them."""
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


def broken_words(found: Sequence[Sought]) -> str:
    """`breaks "no contact" and "room"`; "" where nothing is broken."""
    names = [f'"{each.name}"' for each in found if each.broken]
    if not names:
        return ""
    return "breaks " + (names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}")
