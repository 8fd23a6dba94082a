"""How probable a collision is, for people."""

import math
from collections.abc import Iterator

from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.ends import partners_text
from cortex_dsl.report.failures import (
    EXPOSURE,
    HOW,
    avoidable_interval_text,
    avoidable_text,
    counts_text,
    how_drawn,
    interval_text,
    probability_text,
)
from cortex_dsl.report.layout import heading
from cortex_dsl.report.numbers import counted, percent
from engine.program import Program
from engine.search.estimated import JOINT, PARAMS, Probability
from engine.search.partners import Partners

HINT = "--condition joint draws the params anew, too, until the requirements hold"
TOO_RARE = "valid runs are too rare for subset simulation to begin with; `--method mc` takes those that it finds"


def probability_view(program: Program, found: Probability) -> RenderableType:
    """The estimate with its interval, what it is conditioned on, and how it was made."""
    if not found.valid:
        return Group(heading(program.name), Text(f"no valid {_given(found)}: there is nothing to estimate", "bad"))
    if math.isnan(found.value):
        return Group(heading(program.name), Text(TOO_RARE, "bad"), Text(counts_text(found), "quiet"))
    lines = [
        Text.assemble(f"probability of a collision, given a valid {_given(found)}: ", (probability_text(found), "bad")),
        Text(f"{percent(found.level, 0)} interval: {interval_text(found)}"),
        *_avoidable(found),
        Text(),
        *_conditions(found),
        Text(counts_text(found), "quiet"),
        *_partners(program, found),
        Text(HOW[found.method], "quiet"),
    ]
    if found.levels:
        steps = ", ".join(f"{level:.2f} m" if level else "contact" for level in found.levels)
        lines.append(Text(f"levels of the first repetition: {steps}", "quiet"))
    return Group(heading(program.name), *lines, Text(EXPOSURE, "quiet"))


def _partners(program: Program, found: Probability) -> Iterator[Text]:
    """With whom the ego collided, and with whom never."""
    missing = (0,) * (len(program.actors) - 1 - len(found.by_partner))
    text = partners_text(program.actors, Partners(found.by_partner + missing, found.without_ego))
    if text and found.method == "mc":
        yield Text(f"collisions {text}", "quiet")


def _avoidable(found: Probability) -> Iterator[Text]:
    """How probable one is that a competent driver avoids."""
    if not found.driven:
        return
    yield Text.assemble("of one that a competent driver avoids (UN R157): ", (avoidable_text(found), "bad"))
    yield Text(f"{percent(found.level, 0)} interval: {avoidable_interval_text(found)}")


def _given(found: Probability) -> str:
    """What must be valid: where requirements on the run were broken, more than its beginning."""
    return "run" if found.aborted else "scene"


def _conditions(found: Probability) -> Iterator[Text]:
    """What the probability is of, and what it leaves out."""
    yield Text(how_drawn(found), "quiet")
    if found.condition == PARAMS and found.method == "mc":
        yield Text(HINT, "quiet")
    share = percent(found.valid_share)
    if not found.aborted:
        yield Text(f"{share} of all {_draws(found)} allow a valid scene; the others are conditioned out", "quiet")
        return
    broken = counted(found.aborted, "simulation")
    yield Text(f"{share} of all {_draws(found)} give a valid run; the others are conditioned out", "quiet")
    yield Text(f"{broken} broke a requirement on the run and ended there: what they came to is not counted", "warn")


def _draws(found: Probability) -> str:
    return "draws" if found.condition == JOINT else "draws of the params"
