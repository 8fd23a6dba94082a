"""How probable a collision is, for people."""

import math
from collections.abc import Iterator

from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.ends import partners_text
from cortex_dsl.report.layout import heading
from cortex_dsl.report.numbers import counted, percent, significant, whole
from engine.program import Program
from engine.search.evaluations import Partners
from engine.search.probability.estimates import JOINT, PARAMS, Probability
from engine.search.statistics import Interval

HOW = {
    "mc": "plain Monte Carlo; exact interval of Clopper and Pearson",
    "subset": "subset simulation (Au and Beck 2001); Student's interval over ten independent repetitions",
}

EXPOSURE = "a range is drawn evenly, which is no model of how often a road brings such values"
"""What such a probability is not."""
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
    yield Text(condition_text(found), "quiet")
    if found.condition == PARAMS and found.method == "mc":
        yield Text(HINT, "quiet")
    share = percent(found.valid_share)
    if not found.aborted:
        yield Text(f"{share} of all {_draws(found)} allow a valid scene; the others are conditioned out", "quiet")
        return
    broken = counted(found.aborted, "simulation")
    yield Text(f"{share} of all {_draws(found)} give a valid run; the others are conditioned out", "quiet")
    yield Text(f"{broken} broke a requirement on the run and ended there: what they came to is not counted", "warn")


def condition_text(found: Probability) -> str:
    """Which probability it is: the two differ where some params allow a scene more often than others."""
    if found.condition == JOINT:
        return "params and scene are drawn anew together until the requirements hold"
    often = f" in up to {counted(found.max_attempts, 'attempt')}" if found.max_attempts else ""
    return f"params are drawn once, a scene for them is then sought{often}"


def _draws(found: Probability) -> str:
    return "draws" if found.condition == JOINT else "draws of the params"


def probability_text(found: Probability) -> str:
    """The estimate: in percent where that reads well."""
    return _text(found.value)


def interval_text(found: Probability) -> str:
    """`1.20 % .. 1.90 %`."""
    if not math.isfinite(found.interval.low):
        return "none, as no chain reached contact" if found.valid else "none"
    return _range(found.interval)


def avoidable_text(found: Probability) -> str:
    """The same of a collision that a competent driver avoids."""
    return _text(found.avoidable)


def avoidable_interval_text(found: Probability) -> str:
    if not math.isfinite(found.avoidable_interval.low):
        return "none, as none of those driven again was one" if found.driven else "not known"
    return _range(found.avoidable_interval)


def _text(value: float) -> str:
    if math.isnan(value):
        return "not known"
    if value >= 0.001:
        return percent(value, 2)
    return "none seen" if value == 0.0 else significant(value, 3)


def _range(interval: Interval) -> str:
    """Both ends alike: in percent where the higher one reads well so."""
    low, high = (percent(end, 2) if interval.high >= 0.001 else significant(end, 3) for end in interval)
    return f"{low} .. {high}"


def counts_text(found: Probability) -> str:
    """What the estimate was made from: numbers whose quotient it is, or the word that they are none."""
    tried = "draw" if found.condition == JOINT else "simulation"
    runs = f"{whole(found.valid)} valid of {counted(found.simulations, tried)}"
    if found.method == "subset":
        return f"{runs}; those of chains depend on one another, so their share is no estimate"
    return f"{counted(found.collisions, 'collision')} among {runs}"
