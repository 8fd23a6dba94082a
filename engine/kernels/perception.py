"""Perception of a conflict by a driver on the ego's path: the eyes of `engine.kernels.avoidance`.

At a sample a conflict is in sight if the ego could see the other, in any direction, and one of these holds. Within the
horizon the outlines would touch if the ego continued along its path at its present speed and the other at constant
speed and turn rate (the constant turn rate and velocity model of Schubert, Richter and Wanielik (2008), "Comparison and
evaluation of advanced motion models for vehicle tracking"). Or the other leads, nearer than the horizon, and brakes
harder than the driver considers usual, as in UN R157. A conflict is perceived after it has been in sight for the whole
time of perception.
"""

import math
from typing import NamedTuple

from engine.kernels.approach import first_contact
from engine.kernels.conflict import snapshot, time_gap
from engine.kernels.geometry import Box, shortest_turn
from engine.kernels.jit import inlined, kernel
from engine.kernels.levels import has_levels, recall_levels
from engine.kernels.noticing import notices
from engine.kernels.run_state import Plan, Run
from engine.tables import Floats
from engine.vocabulary import State

WAY, PATH_X, PATH_Y, PATH_HEADING, COURSE, OWN = range(6)
"""Columns of the ego's path, a row per sample: arc length of its centre [m], its poses, 1 for forward and -1 for
reverse motion (at a stand, as before), and its own deceleration in the following step [m/s^2].
"""
PATH_COLUMNS = 6
NEVER = -1
"""No such sample."""


class Driver(NamedTuple):
    """Parameters of the reference driver."""

    perception: float
    """Time that a conflict must be in sight to be perceived [s]."""
    reaction: float
    """Time from then until the brakes act [s]."""
    deceleration: float
    """Deceleration of full braking [m/s^2]."""
    ramp: float
    """Time from the first touch of the pedal to full braking [s]."""
    horizon: float
    """Time ahead within which a conflict is in sight [s]."""
    alarming: float
    """Deceleration of a leader beyond which there is a conflict [m/s^2]."""
    reach: float
    """Largest distance at which an actor can be seen [m]."""


@inlined
def first_sample(time: float, time_step: float) -> int:
    """Return the first sample that is not before `time` [s]."""
    return math.ceil(time / time_step - 1e-9)


@inlined
def lay_path(states: Floats, samples: int, path: Floats, time_step: float) -> None:
    way, course = 0.0, 1.0
    for k in range(samples):
        if k > 0:
            x, y = states[k, 0, State.X] - states[k - 1, 0, State.X], states[k, 0, State.Y] - states[k - 1, 0, State.Y]
            way += math.sqrt(x * x + y * y)
        path[k, WAY] = way
        path[k, PATH_X], path[k, PATH_Y] = states[k, 0, State.X], states[k, 0, State.Y]
        path[k, PATH_HEADING] = states[k, 0, State.HEADING]
        speed = states[k, 0, State.SPEED]
        course = math.copysign(1.0, speed) if speed != 0.0 else course
        path[k, COURSE] = course
        after = states[k + 1, 0, State.SPEED] if k + 1 < samples else speed
        path[k, OWN] = max(0.0, abs(speed) - abs(after)) / time_step


@inlined
def reached(path: Floats, way: float) -> int:
    """Return the last sample, except the end, whose arc length is at most `way` [m]."""
    low, high = 0, len(path) - 1
    while high - low > 1:
        middle = (low + high) // 2
        if path[middle, WAY] <= way:
            low = middle
        else:
            high = middle
    return low


@kernel
def pose_at(path: Floats, way: float, length: float, width: float) -> Box:
    """Return the ego's outline at an arc length of its path; beyond the end straight on in its direction of travel."""
    low = reached(path, way)
    high = min(low + 1, len(path) - 1)
    span = path[high, WAY] - path[low, WAY]
    heading = path[low, PATH_HEADING]
    if way > path[high, WAY] or span <= 0.0:
        beyond, heading = max(0.0, way - path[high, WAY]) * path[high, COURSE], path[high, PATH_HEADING]
        x, y = path[high, PATH_X] + beyond * math.cos(heading), path[high, PATH_Y] + beyond * math.sin(heading)
        return Box(x, y, heading, length, width)
    part = (way - path[low, WAY]) / span
    return Box(
        path[low, PATH_X] + part * (path[high, PATH_X] - path[low, PATH_X]),
        path[low, PATH_Y] + part * (path[high, PATH_Y] - path[low, PATH_Y]),
        heading + part * shortest_turn(heading, path[high, PATH_HEADING]),
        length,
        width,
    )


# -- perception of conflicts -----------------------------------------------------------------------------------------


@kernel
def perceive(plan: Plan, run: Run, contact: int, other: int, outlines: Floats, path: Floats, driver: Driver) -> int:
    """Return the first sample before `contact` at which the conflict has been in sight for the time of perception."""
    needed, seen = first_sample(driver.perception, plan.layout.time_step), 0
    for k in range(contact):
        seen = seen + 1 if is_in_sight(plan, run, k, other, outlines, path, driver) else 0
        if seen > needed:
            return k
    return NEVER


@kernel
def is_in_sight(plan: Plan, run: Run, k: int, other: int, outlines: Floats, path: Floats, driver: Driver) -> bool:
    """Return True if there is a conflict at sample k with an actor that can be seen.

    On a road with levels it needs `levels.trace_levels`, and sets the heights of all actors to those of sample k.
    """
    conflict = is_conflict(run.states, k, other, outlines, path, path[k, WAY], plan.layout.time_step, driver)
    if conflict and has_levels(plan):
        recall_levels(plan, run, k)
    return conflict and notices(plan, run, k, 0, other, driver.reach)


@inlined
def is_conflict(
    states: Floats, k: int, other: int, outlines: Floats, path: Floats, way: float, time_step: float, driver: Driver
) -> bool:
    """Return True if a conflict exists at sample k: contact ahead, or a leader that brakes hard; `way`: arc length of
    the ego on its path [m].
    """
    if states[k, 0, State.PRESENT] == 0.0 or states[k, other, State.PRESENT] == 0.0:
        return False
    if k > 0 and states[k, other, State.ACCELERATION] < -driver.alarming:
        now = snapshot(states, k + 1, k, 0.0, time_step, other, outlines)
        if time_gap(now) < driver.horizon:
            return True
    return _would_touch(states, k, other, outlines, path, way, time_step, driver.horizon)


@kernel
def _would_touch(
    states: Floats, k: int, other: int, outlines: Floats, path: Floats, way: float, time_step: float, horizon: float
) -> bool:
    """Return True if the outlines would touch within the horizon if both continued as at sample k."""
    speed = abs(states[k, 0, State.SPEED])
    theirs, heading = states[k, other, State.SPEED], states[k, other, State.HEADING]
    turn = shortest_turn(states[max(k - 1, 0), other, State.HEADING], heading)
    ahead = outlines[other, 2]
    x = states[k, other, State.X] - ahead * math.cos(heading)
    y = states[k, other, State.Y] - ahead * math.sin(heading)
    length, width = outlines[other, 0], outlines[other, 1]
    ego = pose_at(path, way, outlines[0, 0], outlines[0, 1])
    them = Box(states[k, other, State.X], states[k, other, State.Y], heading, length, width)
    for step in range(first_sample(horizon, time_step)):
        x += theirs * time_step * math.cos(heading + 0.5 * turn)
        y += theirs * time_step * math.sin(heading + 0.5 * turn)
        heading += turn
        ego_after = pose_at(path, way + (step + 1) * speed * time_step, outlines[0, 0], outlines[0, 1])
        after = Box(x + ahead * math.cos(heading), y + ahead * math.sin(heading), heading, length, width)
        if first_contact(ego, ego_after, them, after) >= 0.0:
            return True
        ego, them = ego_after, after
    return False
