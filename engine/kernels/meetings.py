"""Who touches whom in a step: the ego's contact ends the run, those of others are settled.

A step in which two without the ego touch is settled in the order of time: at the instant of a contact all bodies that
touch there are given their velocities by `impact.resolve`, whoever they changed is loose from then on and goes straight
to where `coasting` says that it is at the end of the step, and the next contact is looked for on these ways. What the
record keeps of such a step is its start and its end: between the two a struck body moves linearly for the ego's own
contact and for all metrics, as everybody does in every step.

Contact is where two come within `TOUCH` while they approach. Two who touch and part, or rest against one another, are
left alone until they approach again, looked at `LOOKS` times a step. Two who came into the scene inside one another (a
file may say so) have no side that keeps one out of the other: their centres may not approach either.
"""

import math
from typing import NamedTuple

import numpy as np

from engine.kernels.approach import TOUCH, circles_apart, first_contact, probe, relative_motion
from engine.kernels.blows import MAX_BLOWS, PAUSE, PULSE, Blow
from engine.kernels.coasting import STILL
from engine.kernels.contact import BODY, CONTACT, FLAT, Body, Contact, add_contact, closing, touching, wedged
from engine.kernels.geometry import building, frame, nearest_points
from engine.kernels.impact import resolve
from engine.kernels.jit import deferred, inlined, kernel
from engine.kernels.legs import (
    Leg,
    along_leg,
    beside,
    bodies_of,
    embody,
    lay_leg,
    met_up_to,
    note_walls,
    on_leg,
    outline_on_leg,
    stays_off,
    takes_part,
)
from engine.kernels.loose import go_on, write_loose
from engine.kernels.run_state import Plan, Run, Slot, Status, end_run, outline_of
from engine.tables import Floats
from engine.vocabulary import EndReason, State

MAX_MEETINGS = 64
"""Instants of contact that one step settles; what is left is settled in the next."""
LOOKS = 10
"""How often in a step two who touch already are looked at again."""
MAX_LOOKS = 512
"""Bound on one search."""
NEVER = 2.0
UNKNOWN = -1.0


# -- contact in a step -------------------------------------------------------------------------------------------------


class Meeting(NamedTuple):
    """The first two that touch in a step: at which part of it, and who, the lower one first; -1 if nobody does. The
    other may be a building (`kernels.legs`).
    """

    part: float
    one: int
    other: int


@inlined
def search_contact(plan: Plan, run: Run, low: int, high: int) -> Meeting:
    """The first contact in this step of an actor from `low` to `high` (exclusive) with a later one, or with a
    building; ties: the lower pair. A state that became NaN ends the run. Copied into its caller: call it in one place.
    """
    sample = int(run.status[Status.SAMPLE])
    first, first_one, first_other = NEVER, -1, -1
    for one in range(low, high):
        if run.states[sample + 1, one, State.PRESENT] == 0.0:
            continue
        if not _is_finite(run, sample + 1, one):
            end_run(plan, run, EndReason.BROKEN, -1, 1.0)
            return Meeting(1.0, -1, -1)
        before, after = outline_of(plan, run, sample, one), outline_of(plan, run, sample + 1, one)
        for other in range(one + 1, len(plan.kinds)):
            if run.states[sample + 1, other, State.PRESENT] == 0.0:
                continue
            there, then = outline_of(plan, run, sample, other), outline_of(plan, run, sample + 1, other)
            if circles_apart(before, after, there, then):
                continue
            part = first_contact(before, after, there, then)
            if 0.0 <= part < first and (one == 0 or _moves(run, sample, one) or _moves(run, sample, other)):
                first, first_one, first_other = part, one, other
        for wall in range(len(plan.road.buildings)):
            block = building(plan.road.buildings, wall)
            if beside(block, before, after) or not (one == 0 or _moves(run, sample, one)):
                continue
            part = first_contact(block, block, before, after)
            if 0.0 <= part < first:
                first, first_one, first_other = part, one, len(plan.kinds) + wall
    return Meeting(first, first_one, first_other)


@inlined
def _moves(run: Run, sample: int, actor: int) -> bool:
    """Whether a body is elsewhere, or turned, at the end of the step: others who stand touch for good, or never."""
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


# -- a step in which others touch --------------------------------------------------------------------------------------


@deferred(allocates=True)
def settle_others(plan: Plan, run: Run, sample: int, part: float, one: int, other: int) -> None:
    """Go through the contacts of others in a step, from the first, and rewrite the next sample of whom they strike."""
    actors, count = len(plan.kinds), bodies_of(plan)
    if other < actors:
        _note_first(plan, run, sample + part, one, other)
    _note_insides(plan, run, sample)
    for actor in range(1, actors):
        if run.states[sample + 1, actor, State.PRESENT] != 0.0 and run.actors[actor, Slot.FREE] == 0.0:
            lay_leg(plan, run, sample, actor)
        note_walls(plan, run, actor)
    bodies = np.zeros((count, BODY))
    contacts = np.zeros((count * (count - 1) // 2, CONTACT))
    due = np.full((actors, count), UNKNOWN)
    for _ in range(MAX_MEETINGS):
        if not part <= 1.0:
            break
        meeting = contacts[: _gather(plan, run, sample, part, bodies, contacts)]
        if len(meeting) > 0:
            before = bodies.copy()
            resolve(bodies, meeting, plan.layout.restitution, plan.layout.contact_friction)
            _loosen(plan, run, sample, part, before, bodies, meeting)
        part = _next_meeting(plan, run, sample, part, due, bodies, contacts)
    for actor in range(1, actors):
        if run.states[sample + 1, actor, State.PRESENT] != 0.0 and run.legs[actor, Leg.STRUCK] != 0.0:
            write_loose(plan, run, sample, actor)


@inlined
def _gather(plan: Plan, run: Run, sample: int, part: float, bodies: Floats, contacts: Floats) -> int:
    """All bodies at a part of the step, and the contacts of those that touch and approach; how many."""
    actors, count = len(plan.kinds), 0
    for body in range(1, len(bodies)):
        if takes_part(run, sample, body):
            embody(plan, run, body, part, bodies)
    for one in range(1, actors):
        if not takes_part(run, sample, one):
            continue
        here = outline_on_leg(plan, run, one, part)
        for other in range(one + 1, met_up_to(plan, run, one)):
            if not takes_part(run, sample, other) or stays_off(plan, run, here, here, other, part, part):
                continue
            if _approach(plan, run, part, one, other, bodies, contacts, count):
                count += 1
    return count


@inlined
def _approach(
    plan: Plan, run: Run, part: float, one: int, other: int, bodies: Floats, contacts: Floats, row: int
) -> bool:
    """Whether two touch and approach; their contact is written into a row either way."""
    first, second = frame(outline_on_leg(plan, run, one, part)), frame(outline_on_leg(plan, run, other, part))
    # A little further than where the search stops, which computes the same places with other roundings.
    if nearest_points(first, second).distance > 1.5 * TOUCH:
        return False
    if bodies[one, Body.LIGHTNESS] + bodies[other, Body.LIGHTNESS] == 0.0:
        return False
    found = touching(first, second)
    add_contact(contacts, row, one, other, found)
    if closing(bodies, contacts, row) > STILL:
        return True
    if found.gap >= -FLAT or other >= len(plan.kinds):
        return False
    add_contact(contacts, row, one, other, wedged(first, second))
    came_so = run.actors[one, Slot.INSIDE] != 0.0 and run.actors[other, Slot.INSIDE] != 0.0
    return came_so and closing(bodies, contacts, row) > STILL


@kernel
def _note_insides(plan: Plan, run: Run, sample: int) -> None:
    """Note of all who have come into the scene since others last touched whether they are inside another. Who came in
    inside one another touch in the first step in which one of them moves.
    """
    for one in range(1, len(plan.kinds)):
        if run.actors[one, Slot.INSIDE] >= 0.0 or run.states[sample, one, State.PRESENT] == 0.0:
            continue
        run.actors[one, Slot.INSIDE] = 0.0
        for other in range(1, len(plan.kinds)):
            if (
                other != one
                and run.states[sample, other, State.PRESENT] != 0.0
                and _inside(plan, run, sample, one, other)
            ):
                run.actors[one, Slot.INSIDE] = run.actors[other, Slot.INSIDE] = 1.0


@inlined
def _inside(plan: Plan, run: Run, sample: int, one: int, other: int) -> bool:
    here, there = outline_of(plan, run, sample, one), outline_of(plan, run, sample, other)
    return touching(frame(here), frame(there)).gap < -FLAT


@inlined
def _loosen(plan: Plan, run: Run, sample: int, part: float, before: Floats, bodies: Floats, contacts: Floats) -> None:
    """Keep the contacts of an instant that were resolved; whoever they changed is loose, and goes on from there."""
    time = (sample + part) * plan.layout.time_step
    for contact in range(len(contacts)):
        _note_meeting(plan, run, time, part, before, contacts[contact])
        one, other = int(contacts[contact, Contact.ONE]), int(contacts[contact, Contact.OTHER])
        if other < len(plan.kinds):
            _note_first(plan, run, sample + part, one, other)
    for number in range(run.status[Status.BLOWS]):
        _add_changes(run.impacts[number], time, before, bodies)
    for actor in range(1, len(plan.kinds)):
        if (
            bodies[actor, Body.VX] != before[actor, Body.VX]
            or bodies[actor, Body.VY] != before[actor, Body.VY]
            or bodies[actor, Body.SPIN] != before[actor, Body.SPIN]
        ):
            along, leg = along_leg(run, actor, part), run.legs[actor]
            for column in range(3):
                leg[Leg.X0 + column] = on_leg(run, actor, Leg.X0 + column, along)
                leg[Leg.VX0 + column] = bodies[actor, Body.VX + column]
            leg[Leg.BEGIN], leg[Leg.STRUCK], leg[Leg.ROLLING] = part, 1.0, 0.0
            steer = run.states[sample, actor, State.STEER]
            go_on(plan, run, actor, steer, (1.0 - part) * plan.layout.time_step)
            note_walls(plan, run, actor)


@inlined
def _note_first(plan: Plan, run: Run, samples: float, one: int, other: int) -> None:
    """Keep when and which two others touched first, in samples from the start."""
    if math.isnan(run.end[2]):
        run.end[2] = samples * plan.layout.time_step
        run.status[Status.OTHERS_ONE], run.status[Status.OTHERS_OTHER] = one, other


@inlined
def _note_meeting(plan: Plan, run: Run, time: float, part: float, before: Floats, row: Floats) -> None:
    """Keep where and how two meet, unless they are in the same impact still, or there is no room."""
    one, other = int(row[Contact.ONE]), int(row[Contact.OTHER])
    for number in range(run.status[Status.BLOWS]):
        blow = run.impacts[number]
        lasts = time - blow[Blow.TIME] <= PULSE or time - blow[Blow.LAST] <= PAUSE
        if blow[Blow.ONE] == one and blow[Blow.OTHER] == other and lasts:
            blow[Blow.LAST] = time
            return
    number = run.status[Status.BLOWS]
    if number >= MAX_BLOWS:
        return
    run.status[Status.BLOWS] = number + 1
    blow = run.impacts[number]
    blow[:] = 0.0
    blow[Blow.TIME] = blow[Blow.LAST] = time
    blow[Blow.ONE], blow[Blow.OTHER] = one, other
    second = 0.5 if row[Contact.POINTS] > 1.0 else 0.0
    for axis in range(2):
        first = row[Contact.X1 + axis]
        blow[Blow.X + axis] = first + second * (row[Contact.X2 + axis] - first)
    for side in range(2):
        actor = other if side else one
        for axis in range(2):
            blow[Blow.VX_ONE + 2 * side + axis] = before[actor, Body.VX + axis]
            blow[Blow.X_ONE + 2 * side + axis] = before[actor, Body.X + axis]
        blow[Blow.HEADING_ONE + side] = outline_on_leg(plan, run, actor, part).heading


@inlined
def _add_changes(blow: Floats, time: float, before: Floats, after: Floats) -> None:
    """Add what an instant did to the two of an impact that is not over."""
    if time - blow[Blow.TIME] > PULSE:
        return
    for side in range(2):
        actor = int(blow[Blow.ONE + side])
        for axis in range(2):
            change = after[actor, Body.VX + axis] - before[actor, Body.VX + axis]
            blow[Blow.CHANGE_X_ONE + 2 * side + axis] += change


# -- the next contact --------------------------------------------------------------------------------------------------


@inlined
def _next_meeting(
    plan: Plan, run: Run, sample: int, part: float, due: Floats, bodies: Floats, contacts: Floats
) -> float:
    """The part of the step at which two next touch and approach; `NEVER` if nobody does. Overwrites a contact.

    `due` (actors, bodies) keeps it for each pair: it is searched anew only where one of the two has been struck now.
    """
    first = NEVER
    for one in range(1, len(plan.kinds)):
        if not takes_part(run, sample, one):
            continue
        before, after = outline_on_leg(plan, run, one, part), outline_on_leg(plan, run, one, 1.0)
        for other in range(one + 1, met_up_to(plan, run, one)):
            if due[one, other] <= part or _struck_at(plan, run, one, part) or _struck_at(plan, run, other, part):
                due[one, other] = NEVER
                if takes_part(run, sample, other) and not stays_off(plan, run, before, after, other, part, 1.0):
                    due[one, other] = _meet(plan, run, part, one, other, bodies, contacts)
            first = min(first, due[one, other])
    return first


@inlined
def _struck_at(plan: Plan, run: Run, body: int, part: float) -> bool:
    """Whether a body goes its way since this part of the step only."""
    return body < len(plan.kinds) and run.legs[body, Leg.STRUCK] != 0.0 and run.legs[body, Leg.BEGIN] == part


@inlined
def _meet(plan: Plan, run: Run, part: float, one: int, other: int, bodies: Floats, contacts: Floats) -> float:
    """When two next touch and approach: by conservative advancement as far as they are apart, else by looking."""
    a0, a1 = outline_on_leg(plan, run, one, part), outline_on_leg(plan, run, one, 1.0)
    b0, b1 = outline_on_leg(plan, run, other, part), outline_on_leg(plan, run, other, 1.0)
    motion = relative_motion(a0, a1, b0, b1)
    fraction = 0.0
    for _ in range(MAX_LOOKS):
        nearest = probe(a0, b0, motion, fraction).nearest
        if nearest.distance < TOUCH:
            now = part + fraction * (1.0 - part)
            embody(plan, run, one, now, bodies)
            embody(plan, run, other, now, bodies)
            if _approach(plan, run, now, one, other, bodies, contacts, 0):
                return now
            if fraction >= 1.0:
                return NEVER
            fraction = min(1.0, fraction + 1.0 / LOOKS)
            continue
        rate = max(0.0, -(nearest.x * motion.x + nearest.y * motion.y)) + motion.swing
        if not nearest.distance <= rate * (1.0 - fraction):
            return NEVER
        fraction = min(1.0, fraction + nearest.distance / rate)
    return NEVER
