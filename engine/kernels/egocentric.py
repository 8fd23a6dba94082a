"""Default observation of a driver: its own state, its path ahead, and the nearest actors that it sees.

Everything is in the frame of the actor: x ahead of the middle of its outline, y to its left, headings relative to its
own. Actors hidden behind others or buildings, or beyond the visibility of the weather, are left out.
"""

import math
from typing import NamedTuple

from engine.kernels.evaluate import wrap_angle
from engine.kernels.impacts.motion import velocity_of
from engine.kernels.jit import inlined, shared
from engine.kernels.nearest_lane import lane_nearest
from engine.kernels.noticing import notices
from engine.kernels.path import path_pose, path_project, path_project_near
from engine.kernels.run_state import Memory, Plan, Run, Status, column_of
from engine.kernels.slots import resume_run
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import Column, State

OWN = (
    ("speed", "m/s"), ("acceleration", "m/s^2"), ("steer", "rad"),
    ("path offset", "m"), ("path heading", "rad"), ("path left", "m"),
)  # fmt: skip
"""Its own state, with the offset of its rear axle to the left of its path, the path's heading there, and its length
left.
"""
AHEAD = (5.0, 10.0, 15.0, 20.0, 30.0, 40.0)
"""Points of its path, so far on from the rear axle [m]; beyond its end, the end."""
NEAREST = 4
"""Maximum number of other actors; zeros if fewer are seen."""
EACH = (
    ("seen", ""), ("x", "m"), ("y", "m"), ("heading", "rad"), ("vx", "m/s"), ("vy", "m/s"),
    ("length", "m"), ("width", "m"),
)  # fmt: skip
"""Numbers of each other actor, the nearest first: 1, pose, velocity relative to the actor, size."""
WIDTH = len(OWN) + 2 * len(AHEAD) + NEAREST * len(EACH)


class Frame(NamedTuple):
    """Pose of an actor, as a frame."""

    x: float
    y: float
    heading: float
    cos: float
    """Cosine of the heading."""
    sin: float


@shared
def write_observation(plan: Plan, run: Run, actor: int, paths: Ints, reach: Floats, chosen: Bools, out: Floats) -> None:
    """Write the observation of an actor at the current samples of the chosen slots into `out` (slots, WIDTH), and zeros
    into all other rows.

    `paths` (slots,): the path that the actor follows; -1: that of its lane. `reach` (slots,): distance of sight [m].
    """
    for slot in range(len(chosen)):
        out[slot, :] = 0.0
        if not chosen[slot]:
            continue
        its = run.slots[slot]
        resume_run(its, slot)
        sample = int(its.status[Status.SAMPLE])
        if its.states[sample, actor, State.PRESENT] != 0.0:
            heading = its.states[sample, actor, State.HEADING]
            frame = Frame(
                its.states[sample, actor, State.X],
                its.states[sample, actor, State.Y],
                heading,
                math.cos(heading),
                math.sin(heading),
            )
            _observe_itself(plan, its, sample, actor, frame, int(paths[slot]), out[slot])
            _observe_others(plan, its, sample, actor, frame, float(reach[slot]), out[slot])


@inlined
def _from(frame: Frame, dx: float, dy: float) -> tuple[float, float]:
    """Return a difference of positions or velocities in the frame: ahead and to the left."""
    return dx * frame.cos + dy * frame.sin, dy * frame.cos - dx * frame.sin


@inlined
def _observe_itself(plan: Plan, run: Run, sample: int, actor: int, frame: Frame, path: int, out: Floats) -> None:
    row, x, y = run.states[sample, actor], run.actors[actor, Memory.REAR_X], run.actors[actor, Memory.REAR_Y]
    out[0], out[1], out[2] = row[State.SPEED], row[State.ACCELERATION], row[State.STEER]
    if path < 0 and len(plan.road.lane_route) > 0:
        path = int(plan.road.lane_route[lane_nearest(plan.road, frame.x, frame.y, frame.heading)])
    if path < 0:
        return
    point = path_project_near(plan.road, path, x, y, path_project(plan.road, path, x, y))
    out[3], out[4] = point.offset, wrap_angle(point.heading - frame.heading)
    out[5] = plan.road.path_length[path] - point.s
    for number in range(len(AHEAD)):
        there = path_pose(plan.road, path, point.s + AHEAD[number])
        at = len(OWN) + 2 * number
        out[at], out[at + 1] = _from(frame, there.x - frame.x, there.y - frame.y)


@inlined
def _observe_others(plan: Plan, run: Run, sample: int, actor: int, frame: Frame, reach: float, out: Floats) -> None:
    """Write the nearest actors by their centres, in ascending distance; of equally near ones the lower number first."""
    speed = run.states[sample, actor, State.SPEED]
    before, last = -1.0, -1
    for number in range(NEAREST):
        nearest, least = -1, math.inf
        for other in range(len(plan.kinds)):
            dx, dy = run.states[sample, other, State.X] - frame.x, run.states[sample, other, State.Y] - frame.y
            away = dx * dx + dy * dy
            later = away > before or (away == before and other > last)
            if other != actor and later and away < least and notices(plan, run, sample, actor, other, reach):
                nearest, least = other, away
        if nearest < 0:
            return
        before, last = least, nearest
        it, at = run.states[sample, nearest], len(OWN) + 2 * len(AHEAD) + number * len(EACH)
        rate = velocity_of(run, sample, nearest)
        out[at] = 1.0
        out[at + 1], out[at + 2] = _from(frame, it[State.X] - frame.x, it[State.Y] - frame.y)
        out[at + 3] = wrap_angle(it[State.HEADING] - frame.heading)
        out[at + 4], out[at + 5] = _from(frame, rate.x - speed * frame.cos, rate.y - speed * frame.sin)
        out[at + 6] = column_of(plan, run, nearest, Column.LENGTH)
        out[at + 7] = column_of(plan, run, nearest, Column.WIDTH)
