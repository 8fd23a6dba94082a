"""The first contact in a step, among actors and buildings.

Of many actors, only those whose spans on one axis overlap are compared, by a list that is kept sorted from step to step
(Baraff, 1992, "Dynamic simulation of non-penetrating rigid bodies"). The result does not depend on the order of the
comparisons.
"""

import math
from typing import NamedTuple

from engine.kernels.approach import TOUCH, circles_apart, first_contact
from engine.kernels.geometry import building
from engine.kernels.impacts.motion import NEVER, beside
from engine.kernels.jit import inlined
from engine.kernels.run_state import Plan, Run, column_of, current_sample, end_run, on_one_level, outline_of
from engine.vocabulary import Column, EndReason, State

FEW = 5
"""Number of actors up to which every two are compared."""


class FirstContact(NamedTuple):
    """First contact in a step: its part of the step and two bodies, the second may be a building; -1 if none."""

    part: float
    one: int
    other: int


@inlined
def search_contact(plan: Plan, run: Run, low: int, high: int) -> FirstContact:
    """Return the first contact in this step of an actor from `low` to `high` (exclusive) with a later actor or a
    building; of simultaneous contacts, the lower pair. A state that is NaN ends the run. The code is copied into its
    caller: call it in one place.
    """
    sample, actors, found = current_sample(run), len(plan.kinds), FirstContact(NEVER, -1, -1)
    for one in range(low, high):
        if run.states[sample + 1, one, State.PRESENT] != 0.0 and not _is_finite(run, sample + 1, one):
            end_run(plan, run, EndReason.BROKEN, -1, 1.0)
            return FirstContact(1.0, -1, -1)
    sweeps = high - low > FEW
    if sweeps:
        _sort_spans(plan, run, sample, low)
    for place in range(0 if sweeps else low, actors if sweeps else high):
        one = int(run.sweep_order[place]) if sweeps else place
        if one < low or run.states[sample + 1, one, State.PRESENT] == 0.0:
            continue
        for later in range(place + 1, actors):
            other = int(run.sweep_order[later]) if sweeps else later
            if sweeps and run.sweep_spans[other, 0] > run.sweep_spans[one, 1]:
                break
            if run.states[sample + 1, other, State.PRESENT] == 0.0:
                continue
            lower, upper = min(one, other), max(one, other)
            before, after = outline_of(plan, run, sample, lower), outline_of(plan, run, sample + 1, lower)
            there, then = outline_of(plan, run, sample, upper), outline_of(plan, run, sample + 1, upper)
            if circles_apart(before, after, there, then) or not on_one_level(run, lower, upper):
                continue
            met = FirstContact(first_contact(before, after, there, then), lower, upper)
            if lower == 0 or _moves(run, sample, lower) or _moves(run, sample, upper):
                found = _earlier(met, found)
    for one in range(low, high if len(plan.road.buildings) > 0 else low):
        if run.states[sample + 1, one, State.PRESENT] == 0.0 or not (one == 0 or _moves(run, sample, one)):
            continue
        before, after = outline_of(plan, run, sample, one), outline_of(plan, run, sample + 1, one)
        for wall in range(len(plan.road.buildings)):
            block = building(plan.road.buildings, wall)
            if not beside(block, before, after):
                met = FirstContact(first_contact(block, block, before, after), one, actors + wall)
                found = _earlier(met, found)
    return found


@inlined
def _earlier(met: FirstContact, found: FirstContact) -> FirstContact:
    """Return the earlier of two contacts, of simultaneous contacts the lower pair.

    No contact is a part below 0 of `met`, and the part `NEVER` of `found`.
    """
    is_lower = met.one < found.one or (met.one == found.one and met.other < found.other)
    is_earlier = met.part < found.part or (met.part == found.part and is_lower)
    return met if met.part >= 0.0 and is_earlier else found


@inlined
def _sort_spans(plan: Plan, run: Run, sample: int, low: int) -> None:
    """Write the span of each actor from `low` on in this step, and sort the actors by the beginnings of the spans.

    The axis is that along which the actors are spread more. The order of the last step, which is nearly right, is
    sorted by insertion. An absent actor has no span and is last.
    """
    states, spans, order = run.states, run.sweep_spans, run.sweep_order
    least_x = least_y = math.inf
    most_x = most_y = -math.inf
    for actor in range(low, len(plan.kinds)):
        if states[sample + 1, actor, State.PRESENT] != 0.0:
            x, y = states[sample + 1, actor, State.X], states[sample + 1, actor, State.Y]
            least_x, least_y, most_x, most_y = min(least_x, x), min(least_y, y), max(most_x, x), max(most_y, y)
    axis = State.X if most_x - least_x >= most_y - least_y else State.Y
    for actor in range(len(plan.kinds)):
        spans[actor, 0] = spans[actor, 1] = math.inf
        if actor >= low and states[sample + 1, actor, State.PRESENT] != 0.0:
            start, end = states[sample, actor, axis], states[sample + 1, actor, axis]
            # More than the radius of the circumscribed circle, so that bodies beyond it cannot touch.
            reach = (
                0.5 * (column_of(plan, run, actor, Column.LENGTH) + column_of(plan, run, actor, Column.WIDTH)) + TOUCH
            )
            spans[actor, 0], spans[actor, 1] = min(start, end) - reach, max(start, end) + reach
    for place in range(1, len(order)):
        actor, at = order[place], place
        while at > 0 and spans[order[at - 1], 0] > spans[actor, 0]:
            order[at] = order[at - 1]
            at -= 1
        order[at] = actor


@inlined
def _moves(run: Run, sample: int, actor: int) -> bool:
    """Return True if the pose of a body changes in the step; two actors at rest begin no contact."""
    before, after = run.states[sample, actor], run.states[sample + 1, actor]
    return (
        before[State.X] != after[State.X]
        or before[State.Y] != after[State.Y]
        or before[State.HEADING] != after[State.HEADING]
    )


@inlined
def _is_finite(run: Run, sample: int, actor: int) -> bool:
    states = run.states
    position = states[sample, actor, State.X] + states[sample, actor, State.Y]
    return math.isfinite(position + states[sample, actor, State.HEADING] + states[sample, actor, State.SPEED])
