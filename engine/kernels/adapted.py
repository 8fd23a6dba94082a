"""Counterfactuals of a collision: what would have had to be different for the careful driver to avoid it.

Each is found by coarse steps and then by bisection on drives of `engine.kernels.avoidance`: from the value of the case
towards the easier end, the first value that avoids contact. A window of avoidance narrower than a coarse step may be
missed: where others move, later is not always worse.

- *Approach speed*: the ego drives as in the case, but no faster than a speed; from there the careful driver perceives,
  reacts and brakes.
- *Latest braking*: full braking of the careful driver begins at an instant.
- *Sight*: the careful driver sees the other if it is no farther than a distance, hidden or not.
- *Friction*: the careful driver brakes on a road of a friction.

*Adapted speed*: while the other is hidden, or beyond the range of sight, the ego drives no faster than it could, with
the careful driver's perception, reaction and braking, and stop a little before the place of the contact; once it has
slowed down it does not speed up. Then the careful driver perceives, reacts and brakes.
"""

import math
from typing import NamedTuple

from engine.kernels.avoidance import (
    Case,
    DriveMemory,
    Replayed,
    brake_from,
    brakes_like,
    carry_on,
    collides,
    copy_row,
    found_fault,
    in_its_car,
    limited_to,
    place_ego,
    pressed,
    put,
    record_others,
    touches,
)
from engine.kernels.bicycle import GRAVITY
from engine.kernels.fault import EGO
from engine.kernels.jit import inlined, kernel
from engine.kernels.levels import follow_levels, has_levels, recall_levels
from engine.kernels.noticing import notices
from engine.kernels.perception import (
    COURSE,
    NEVER,
    OWN,
    WAY,
    Driver,
    first_sample,
    is_conflict,
    perceive,
    pose_at,
)
from engine.kernels.rollout import advance, begin
from engine.kernels.rows import Requested, Window, note_outlines
from engine.kernels.run_state import REPLACED, RUNNING, Memory, Plan, Run, Status, column_of, vehicle_of
from engine.tables import Floats
from engine.vocabulary import Column, State, Verdict

SPEED, INSTANT, SIGHT, FRICTION, ADAPTED = range(5)
"""Columns of the result."""
STEPS = (1.0, 0.5, 2.0, 0.05)
"""Coarse steps of speed [m/s], time [s], sight [m] and friction."""
WIDTHS = (0.05, 0.05, 0.05, 0.005)
"""Widths at which bisection ends, in the same units; an instant is that of a sample."""
MOST_FRICTION = 1.0
"""Greatest friction that is tried."""
SPARE = 0.1
"""Distance at which the ego can stop before the place of the contact [m]: more than steps of time round off."""
HALVINGS = 30
"""Halvings in the search of a stopping speed."""


class Approach(NamedTuple):
    """Limits of the ego's speed before the careful driver brakes."""

    fastest: float
    """Greatest speed [m/s]."""
    place: float
    """Arc length at which the ego must be able to stop while the other is hidden [m]; infinite: no such limit."""


@kernel
def counterfactual_rows(
    plan: Plan, scenes: Requested, reach: Floats, window: Window, memory: DriveMemory, driver: Driver, out: Floats
) -> None:
    """Write the counterfactuals of each valid scene of a window into `out` (n, 5).

    Highest approach speed [m/s], latest instant of full braking [s], least sight [m], least friction, each NaN if there
    is none, and 1 if adapted speed avoids contact, else 0; rows without a collision that the ego caused are unchanged.
    """
    for row in range(window.first, window.last):
        if scenes.verdict[row] == Verdict.VALID:
            case = Case(int(scenes.variant[row]), scenes.values[row], scenes.keys[row], scenes.actions[row])
            _explore(plan, memory, case, limited_to(driver, min(driver.reach, reach[row])), out[row])


@kernel
def _explore(plan: Plan, memory: DriveMemory, case: Case, driver: Driver, out: Floats) -> None:
    run, outlines, path, time_step = memory.run, memory.outlines, memory.path, plan.layout.time_step
    if not collides(plan, run, memory, case):
        return
    note_outlines(plan, run, outlines)
    if found_fault(plan, run, outlines) != EGO:
        return
    contact, other, instant = int(run.status[Status.SAMPLE]), int(run.status[Status.CONTACT_OTHER]), run.end[0]
    careful = in_its_car(plan, run, driver)
    until = carry_on(plan, run, memory, careful)
    path = path[: until + 1]
    perceived = perceive(plan, run, contact, other, outlines, path, careful)
    _note_conflicts(run, contact, other, outlines, path, time_step, careful, memory.conflicts)
    if memory.independent and memory.touching:
        record_others(plan, run, memory, case, contact, until)
    again = Replayed(case, contact, until, outlines, path, memory.own, memory.independent, memory.checkpoints)
    fastest = 0.0
    for k in range(contact):
        fastest = max(fastest, abs(memory.own[k, State.SPEED]))
    out[SPEED] = _highest_speed(plan, run, again, other, fastest, careful)
    out[INSTANT] = _latest_instant(plan, run, again, careful)
    out[SIGHT] = _least_sight(plan, run, again, memory.conflicts, careful)
    out[FRICTION] = _least_friction(plan, run, again, perceived, driver)
    part = min(1.0, max(0.0, instant / time_step - (contact - 1)))
    place = path[contact - 1, WAY] + part * (path[contact, WAY] - path[contact - 1, WAY])
    out[ADAPTED] = 0.0 if _approach(plan, run, again, other, Approach(fastest, place), careful) else 1.0


# -- each counterfactual -----------------------------------------------------------------------------------------------


@inlined
def _highest_speed(plan: Plan, run: Run, again: Replayed, other: int, fastest: float, driver: Driver) -> float:
    good, bad = fastest, math.inf
    while _approach(plan, run, again, other, Approach(good, math.inf), driver):
        if good == 0.0:
            return math.nan
        good, bad = max(0.0, good - STEPS[SPEED]), good
    while bad - good > WIDTHS[SPEED] and bad < math.inf:
        middle = 0.5 * (good + bad)
        if _approach(plan, run, again, other, Approach(middle, math.inf), driver):
            bad = middle
        else:
            good = middle
    return good


@inlined
def _latest_instant(plan: Plan, run: Run, again: Replayed, driver: Driver) -> float:
    time_step = plan.layout.time_step
    step = first_sample(STEPS[INSTANT], time_step)
    good, bad = again.contact - 1, again.contact
    while brake_from(plan, run, again, good, driver).touched:
        if good == 0:
            return math.nan
        good, bad = max(0, good - step), good
    while bad - good > 1:
        middle = (good + bad) // 2
        if brake_from(plan, run, again, middle, driver).touched:
            bad = middle
        else:
            good = middle
    return good * time_step


@inlined
def _note_conflicts(
    run: Run, contact: int, other: int, outlines: Floats, path: Floats, time_step: float, driver: Driver, out: Floats
) -> None:
    """Write the distance to the other at each sample of a conflict [m], else infinity."""
    for k in range(contact):
        found = is_conflict(run.states, k, other, outlines, path, path[k, WAY], time_step, driver)
        out[k] = _distance(run.states, k, other, outlines) if found else math.inf


@inlined
def _distance(states: Floats, k: int, other: int, outlines: Floats) -> float:
    """Return the distance from the ego's centre to the other's outline [m]."""
    x, y = states[k, 0, State.X] - states[k, other, State.X], states[k, 0, State.Y] - states[k, other, State.Y]
    cos, sin = math.cos(states[k, other, State.HEADING]), math.sin(states[k, other, State.HEADING])
    along = max(0.0, abs(cos * x + sin * y) - 0.5 * outlines[other, 0])
    return math.hypot(along, max(0.0, abs(cos * y - sin * x) - 0.5 * outlines[other, 1]))


@inlined
def _braking_with_sight(again: Replayed, distances: Floats, sight: float, time_step: float, driver: Driver) -> int:
    """Return the sample at which the careful driver brakes with a range of sight [m]."""
    needed, seen = first_sample(driver.perception, time_step), 0
    for k in range(again.contact):
        seen = seen + 1 if distances[k] <= sight else 0
        if seen > needed:
            return min(k + first_sample(driver.reaction, time_step), again.contact)
    return again.contact


@inlined
def _least_sight(plan: Plan, run: Run, again: Replayed, distances: Floats, driver: Driver) -> float:
    time_step, farthest = plan.layout.time_step, 0.0
    for k in range(again.contact):
        if distances[k] < math.inf:
            farthest = max(farthest, distances[k])
    good = bad = 0.0
    tried = again.contact
    while True:
        good, bad = good + STEPS[SIGHT], good
        braking = _braking_with_sight(again, distances, good, time_step, driver)
        if braking != tried and not brake_from(plan, run, again, braking, driver).touched:
            break
        tried = braking
        if good >= farthest:
            return math.nan
    while good - bad > WIDTHS[SIGHT]:
        middle = 0.5 * (good + bad)
        braking = _braking_with_sight(again, distances, middle, time_step, driver)
        if brake_from(plan, run, again, braking, driver).touched:
            bad = middle
        else:
            good = middle
    return good


@inlined
def _on_friction(plan: Plan, run: Run, friction: float, driver: Driver) -> Driver:
    """Return the careful driver in the ego's car on a road of a friction."""
    vehicle, build_up = vehicle_of(plan, run, 0), column_of(plan, run, 0, Column.PEDAL_TIME)
    braking = min(driver.deceleration, vehicle.max_braking, friction * GRAVITY)
    share = braking / vehicle.max_braking if vehicle.max_braking > 0.0 else 0.0
    return brakes_like(driver, braking, max(driver.ramp, build_up * share))


@inlined
def _least_friction(plan: Plan, run: Run, again: Replayed, perceived: int, driver: Driver) -> float:
    if perceived == NEVER:
        return math.nan
    braking = perceived + first_sample(driver.reaction, plan.layout.time_step)
    good = bad = 0.0
    while True:
        good, bad = good + STEPS[FRICTION], good
        if good > MOST_FRICTION + 0.5 * STEPS[FRICTION]:
            return math.nan
        if not brake_from(plan, run, again, braking, _on_friction(plan, run, good, driver)).touched:
            break
    while good - bad > WIDTHS[FRICTION]:
        middle = 0.5 * (good + bad)
        if brake_from(plan, run, again, braking, _on_friction(plan, run, middle, driver)).touched:
            bad = middle
        else:
            good = middle
    return good


# -- a drive with another approach -------------------------------------------------------------------------------------


@kernel
def _approach(plan: Plan, run: Run, again: Replayed, other: int, limits: Approach, driver: Driver) -> bool:
    """Drive a case within limits, with the careful driver's perception; return True if the ego touches any actor."""
    case, contact, outlines, path = again.case, again.contact, again.outlines, again.path
    time_step, states, own = plan.layout.time_step, run.states, again.own
    needed, reaction = first_sample(driver.perception, time_step), first_sample(driver.reaction, time_step)
    if not again.recorded:
        begin(plan, run, case.variant, case.values, case.key, case.actions)
    scored = again.recorded or run.status[Status.END] == RUNNING
    if again.recorded:
        copy_row(own[0], states[0, 0])
        if has_levels(plan):
            recall_levels(plan, run, 0)
    departed, seen, braking, way, held = False, 0, again.until, 0.0, 0.0
    speed, limit = abs(own[0, State.SPEED]), limits.fastest
    for k in range(again.until):
        if braking == again.until:  # not perceived yet
            visible = notices(plan, run, k, 0, other, driver.reach)
            conflict = visible and is_conflict(states, k, other, outlines, path, way, time_step, driver)
            seen = seen + 1 if conflict else 0
            if seen > needed:
                braking = min(k + reaction, again.until - 1)
            elif not visible and limits.place < math.inf:
                limit = min(limit, _stopping_speed(limits.place - SPARE - way, time_step, driver))
        if not departed and (k == braking or limit < max(speed, abs(own[k + 1, State.SPEED]))):
            departed = True
            held = path[max(k - 1, 0), OWN]
            if not again.recorded:
                run.actors[0, Memory.FREE] = REPLACED
            if k == 0 and limit < speed:
                speed = limit
                put(states, 0, pose_at(path, way, outlines[0, 0], outlines[0, 1]), path[0, COURSE] * speed)
        if departed:
            slower = min(abs(own[k + 1, State.SPEED]), max(limit, speed - driver.deceleration * time_step))
            if k >= braking:
                held = max(held, path[k, OWN]) if k < contact else held
                middle = (k - braking + 0.5) * time_step
                slower = max(0.0, speed - max(min(held, driver.deceleration), pressed(driver, middle)) * time_step)
            way += 0.5 * (speed + slower) * time_step
            speed = slower
            place_ego(states, k + 1, path, way, outlines, speed)
        else:
            way, speed = path[k + 1, WAY], abs(own[k + 1, State.SPEED])
            if again.recorded:
                copy_row(own[k + 1], states[k + 1, 0])
        if not again.recorded:
            advance(plan, run, k + 1, scored and not departed)
        elif has_levels(plan):
            follow_levels(plan, run, k + 1)
        if touches(run, k, outlines):
            return True
    return False


@inlined
def _stopping_speed(distance: float, time_step: float, driver: Driver) -> float:
    """Return the speed from which the careful driver stops within a distance [m/s].

    One step is added to its perception: the other comes into sight between two samples.
    """
    slow, fast = 0.0, math.sqrt(2.0 * driver.deceleration * max(0.0, distance))
    waits = driver.perception + driver.reaction + time_step
    for _ in range(HALVINGS):
        middle = 0.5 * (slow + fast)
        if middle * waits + _braking_distance(middle, driver) <= distance:
            slow = middle
        else:
            fast = middle
    return slow


@inlined
def _braking_distance(speed: float, driver: Driver) -> float:
    """Return the distance in which the driver stops once it touches the pedal [m]."""
    braking, ramp = driver.deceleration, driver.ramp
    if braking <= 0.0:
        return math.inf if speed > 0.0 else 0.0
    left = speed - 0.5 * braking * ramp
    if left < 0.0:
        return 2.0 / 3.0 * speed * math.sqrt(2.0 * speed * ramp / braking)
    return speed * ramp - braking * ramp * ramp / 6.0 + left * left / (2.0 * braking)
