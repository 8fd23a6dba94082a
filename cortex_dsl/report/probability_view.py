"""How probable a collision is, for people."""

import math
from collections.abc import Iterator

from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.layout import heading
from cortex_dsl.report.numbers import counted, percent, significant, whole
from engine.program import Program
from engine.search.probability import Probability

HOW = {
    "mc": "plain Monte Carlo; exact interval of Clopper and Pearson",
    "subset": "subset simulation (Au and Beck 2001); Student's interval over ten independent repetitions",
}

TOO_RARE = "valid runs are too rare for subset simulation to begin with; `--method mc` takes those that it finds"


def probability_view(program: Program, found: Probability) -> RenderableType:
    """The estimate with its interval, what it is conditioned on, and how it was made."""
    if not found.valid:
        return Group(heading(program.name), Text(f"no valid {_given(found)}: there is nothing to estimate", "bad"))
    if math.isnan(found.value):
        return Group(heading(program.name), Text(TOO_RARE, "bad"), Text(_work(found), "quiet"))
    lines = [
        Text.assemble(f"probability of a collision, given a valid {_given(found)}: ", (probability_text(found), "bad")),
        Text(f"{percent(found.level, 0)} interval: {interval_text(found)}"),
        *_conditions(found),
        Text(_work(found), "quiet"),
        Text(HOW[found.method], "quiet"),
    ]
    if found.levels:
        steps = ", ".join(f"{level:.2f} m" if level else "contact" for level in found.levels)
        lines.append(Text(f"levels of the first repetition: {steps}", "quiet"))
    return Group(heading(program.name), *lines)


def _given(found: Probability) -> str:
    """What must be valid: where requirements on the run were broken, more than its beginning."""
    return "run" if found.aborted else "scene"


def _conditions(found: Probability) -> Iterator[Text]:
    """What the probability leaves out."""
    share = percent(found.valid_share)
    if not found.aborted:
        yield Text(f"{share} of all draws allow a valid scene; the others are conditioned out", "quiet")
        return
    broken = counted(found.aborted, "simulation")
    yield Text(f"{share} of all draws give a valid run; the others are conditioned out", "quiet")
    yield Text(f"{broken} broke a requirement on the run and ended there: what they came to is not counted", "warn")


def probability_text(found: Probability) -> str:
    """The estimate: in percent where that reads well."""
    if math.isnan(found.value):
        return "not known"
    if found.value >= 0.001:
        return percent(found.value, 2)
    return "none seen" if found.value == 0.0 else significant(found.value, 3)


def interval_text(found: Probability) -> str:
    """`1.20 % .. 1.90 %`."""
    if not math.isfinite(found.interval.low):
        return "none, as no chain reached contact" if found.valid else "none"
    low, high = (percent(end, 2) if found.value >= 0.001 else significant(end, 3) for end in found.interval)
    return f"{low} .. {high}"


def _work(found: Probability) -> str:
    tried = f"{whole(found.valid)} valid of {counted(found.simulations, 'simulation')}"
    if found.levels:
        return f"{tried}; those of chains depend on one another, so their share is no estimate"
    return f"{counted(found.collisions, 'collision')} among {tried}"
