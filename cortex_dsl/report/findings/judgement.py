"""Answers of the reference drivers to one collision, and its counterfactuals, in words and as a document."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

from cortex_dsl.report.findings.readable import fixed
from engine.counterfactuals import Counterfactuals
from engine.references import OUT_OF_RANGE
from engine.verdicts import JudgedCollision
from engine.vocabulary import Answer

ANSWERS = {Answer.AVOIDS: ("avoids it", "bad"), Answer.COLLIDES: ("collides", "warn"), Answer.STRUCK: ("", "quiet")} | {
    answer: (f"out of range: {reason}", "quiet") for answer, reason in OUT_OF_RANGE.items()
}
"""Words and style of the answer of one driver."""
HEADS = ("approach", "braking", "sight", "friction", "adapted speed")
"""Heads of the columns of `counterfactual_cells`."""
LABELS = ("highest speed of approach", "latest full braking", "least sight", "least friction", "adapted speed")
"""The same in a table of one case."""
EXPLAINED = (
    "highest speed of approach, latest instant of full braking, least sight of the other, least friction of the road "
    "at which the careful driver avoids the contact; adapted speed: it approaches so that it can stop before what "
    "it does not see"
)


def covering(judged: JudgedCollision) -> list[str]:
    """Return the names of the drivers whose range covers a collision."""
    return [name for name, answer in judged.answers.items() if answer in (Answer.AVOIDS, Answer.COLLIDES)]


def drivers_text(judged: JudgedCollision) -> str:
    """Return the drivers that avoid a collision: `all 3`, `none of 3`, or `2 of 3: careful, rss`; empty without any."""
    covers = covering(judged)
    avoids = [name for name in covers if judged.answers[name] == Answer.AVOIDS]
    if not covers:
        return ""
    if not avoids:
        return f"none of {len(covers)}"
    if len(avoids) == len(covers):
        return f"all {len(covers)}" if len(covers) > 1 else covers[0]
    return f"{len(avoids)} of {len(covers)}: {', '.join(avoids)}"


def counterfactual_cells(found: Counterfactuals) -> Iterator[str]:
    """Yield the texts of the counterfactuals, in the order of `HEADS`."""
    values = (found.approach_speed * 3.6, 0, " km/h"), (found.latest_braking, 2, " s"), (found.sight, 1, " m")
    for value, digits, unit in (*values, (found.friction, 2, "")):
        yield f"{fixed(value, digits)}{unit}" if math.isfinite(value) else "none"
    yield "avoids it" if found.adapted_speed else "collides"


def judged_content(judged: JudgedCollision | None) -> dict[str, Any]:
    """Return the fields of a case in a document: `verdict`, `references` and `counterfactuals`; SI units."""
    if judged is None:
        return {"verdict": None, "references": None, "counterfactuals": None}
    return {
        "verdict": judged.verdict.name.lower(),
        "references": {name: answer.name.lower() for name, answer in judged.answers.items()},
        "counterfactuals": judged.counterfactuals and vars(judged.counterfactuals),
    }


def adapted_text(judged: Sequence[JudgedCollision]) -> str:
    """Return how many of some collisions adapted speed avoids; empty without a collision that the ego caused."""
    caused = [each.counterfactuals for each in judged if each.counterfactuals is not None]
    if not caused:
        return ""
    return f"adapted speed avoids {sum(each.adapted_speed for each in caused)} of {len(caused)} of these collisions"
