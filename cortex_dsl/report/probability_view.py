"""How probable a collision is, for people."""

import math

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


def probability_view(program: Program, found: Probability) -> RenderableType:
    """The estimate with its interval, what it is conditioned on, and how it was made."""
    if not found.valid:
        return Group(heading(program.name), Text("no valid scene: there is nothing to estimate", "bad"))
    lines = [
        Text.assemble("probability of a collision, given a valid scene: ", (_number(found.value), "bad")),
        Text(_interval(found)),
        Text(f"{percent(found.valid_share)} of all draws allow a valid scene; the others are conditioned out", "quiet"),
        Text(_work(found), "quiet"),
        Text(HOW[found.method], "quiet"),
    ]
    if found.levels:
        steps = ", ".join(f"{level:.2f} m" if level else "contact" for level in found.levels)
        lines.append(Text(f"levels of the first repetition: {steps}", "quiet"))
    return Group(heading(program.name), *lines)


def _number(value: float) -> str:
    """A probability: in percent where that reads well."""
    if value >= 0.001:
        return percent(value, 2)
    return "none seen" if value == 0.0 else significant(value, 3)


def _interval(found: Probability) -> str:
    level = percent(found.level, 0)
    if not math.isfinite(found.interval.low):
        return f"{level} interval: none, as no chain reached contact"
    low, high = (percent(end, 2) if found.value >= 0.001 else significant(end, 3) for end in found.interval)
    return f"{level} interval: {low} .. {high}"


def _work(found: Probability) -> str:
    hits = counted(found.collisions, "collision")
    return f"{hits} among {whole(found.valid)} valid of {counted(found.simulations, 'simulation')}"
