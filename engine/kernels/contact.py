"""First contact of any two in a recording: between samples everybody moves linearly, whoever drove."""

from typing import NamedTuple

from engine.kernels.geometry import FRACTION_AT_START, TOUCH, Box, box_distance, first_contact
from engine.kernels.inline import inlined
from engine.kernels.jit import kernel
from engine.tables import Floats
from engine.vocabulary import State


class Touch(NamedTuple):
    """Where two touch: after sample `sample` by `part` (0 .. 1) of the way to the next; sample -1: nobody does."""

    sample: int
    part: float
    one: int
    other: int


@kernel
def search_contact(states: Floats, outlines: Floats) -> Touch:
    """The first contact; ties go to the lower pair, as in a run of ours.

    `states` (samples, actors, len(State)) with headings that are not wrapped, at times that need not be even;
    `outlines` (actors, at least 2): length, width [m]. Two who are there at one sample alone, or at the last one, touch
    if they do then.
    """
    samples, actors = states.shape[0], states.shape[1]
    for k in range(samples):
        first, first_one, first_other = 2.0, -1, -1
        for one in range(actors):
            if states[k, one, State.PRESENT] == 0.0:
                continue
            for other in range(one + 1, actors):
                if states[k, other, State.PRESENT] == 0.0:
                    continue
                part = _part_until_contact(states, samples, k, one, other, outlines)
                if 0.0 <= part < first:
                    first, first_one, first_other = part, one, other
        if first_one >= 0:
            return Touch(k, first if first > FRACTION_AT_START else 0.0, first_one, first_other)
    return Touch(-1, 0.0, -1, -1)


@inlined
def _part_until_contact(states: Floats, samples: int, k: int, one: int, other: int, outlines: Floats) -> float:
    """Fraction of the way to the next sample; -1.0 without contact in it."""
    a0, b0 = _box(states, k, one, outlines), _box(states, k, other, outlines)
    after = min(k + 1, samples - 1)
    if after == k or states[after, one, State.PRESENT] == 0.0 or states[after, other, State.PRESENT] == 0.0:
        return 0.0 if box_distance(a0, b0) < TOUCH else -1.0
    return first_contact(a0, _box(states, after, one, outlines), b0, _box(states, after, other, outlines))


@inlined
def _box(states: Floats, k: int, actor: int, outlines: Floats) -> Box:
    return Box(
        states[k, actor, State.X],
        states[k, actor, State.Y],
        states[k, actor, State.HEADING],
        outlines[actor, 0],
        outlines[actor, 1],
    )
