"""Levels: actors meet, see, obstruct and strike one another only while their heights differ by less than a headroom.

A road with bridges has a table of heights: points along the centres of all lanes, with height and slope. The height
of an actor is continuous: at each sample it is that of the nearest point whose height is near that of the sample
before. So an actor keeps the level of its road, through links and up ramps. A vehicle begins on the lane that it
faces along (`nearest_lane`), unless the scenario names its road. A pedestrian or an obstacle may face anywhere: it
begins on the level of the ego where that level has a lane near it. On a road without bridges there is no table, and
all heights are 0. Slopes have no effect on motion.
"""

import math

from engine.kernels.jit import deferred, inlined, kernel
from engine.kernels.nearest_lane import first_lane, lane_nearest
from engine.kernels.run_state import HOSTED, Memory, Plan, Run, Status
from engine.tables import Floats, Ints, RoadTables
from engine.vocabulary import LEVEL, LEVEL_REACH, ActorKind, HeightColumn, State

SAME_SURFACE = 0.5 * LEVEL
"""Largest change of an actor's height in a step [m]: a point farther from its height belongs to another surface."""
FRAME_X, FRAME_Y, SIDE, COLUMNS, ROWS = range(5)
"""Entries of `RoadTables.height_frame`."""


@kernel
def height_near(
    road: RoadTables, x: float, y: float, before: float, lane: int, within: float, otherwise: float
) -> float:
    """Return the height of the road at a place [m], near the height `before`; or (`lane` >= 0) that of a lane.

    `otherwise` if no point of such a road is nearer than `within` [m] and in a cell next to the place.
    """
    side = road.height_frame[SIDE]
    columns, rows = int(road.height_frame[COLUMNS]), int(road.height_frame[ROWS])
    column = math.floor((x - road.height_frame[FRAME_X]) / side)
    row = math.floor((y - road.height_frame[FRAME_Y]) / side)
    least, height = within * within, otherwise
    for across in range(max(row - 1, 0), min(row + 2, rows)):
        for along in range(max(column - 1, 0), min(column + 2, columns)):
            cell = across * columns + along
            for at in range(road.height_start[cell], road.height_start[cell + 1]):
                point = road.heights[at]
                dx, dy = x - point[HeightColumn.X], y - point[HeightColumn.Y]
                there = point[HeightColumn.HEIGHT] + dx * point[HeightColumn.SLOPE_X]
                there += dy * point[HeightColumn.SLOPE_Y]
                fits = point[HeightColumn.LANE] == lane if lane >= 0 else abs(there - before) < SAME_SURFACE
                if fits and dx * dx + dy * dy < least:
                    least, height = dx * dx + dy * dy, there
    return height


@kernel
def next_height(road: RoadTables, x: float, y: float, before: float) -> float:
    """Return the height of an actor [m] by that of the sample before; the same one beside the road."""
    return height_near(road, x, y, before, -1, math.inf, before)


@kernel
def first_height(road: RoadTables, actor: int, kind: int, x: float, y: float, heading: float, ego: float) -> float:
    """Return the height at which an actor of a kind enters the scene [m]; `ego`: height of the ego, ignored for it."""
    named = first_lane(road, actor, x, y, heading)
    lane = named if named >= 0 else lane_nearest(road, x, y, heading)
    along = height_near(road, x, y, 0.0, lane, math.inf, 0.0)
    if named >= 0 or actor == 0 or (kind != ActorKind.PEDESTRIAN and kind != ActorKind.OBSTACLE):
        return along
    return height_near(road, x, y, ego, -1, LEVEL_REACH, along)


@deferred()
def enter_level(plan: Plan, run: Run, sample: int, actor: int) -> None:
    """Store the height of an actor that enters the scene."""
    pose, ego = run.states[sample, actor], run.actors[0, Memory.HEIGHT]
    x, y, heading = pose[State.X], pose[State.Y], pose[State.HEADING]
    run.actors[actor, Memory.HEIGHT] = first_height(plan.road, actor, int(plan.kinds[actor]), x, y, heading, ego)


@deferred()
def keep_levels(plan: Plan, run: Run, sample: int) -> None:
    """Store the heights of all actors at a sample, by those of the sample before."""
    for actor in range(len(plan.kinds)):
        pose = run.states[sample, actor]
        if pose[State.PRESENT] != 0.0 and run.actors[actor, Memory.FREE] != HOSTED:
            before = run.actors[actor, Memory.HEIGHT]
            run.actors[actor, Memory.HEIGHT] = next_height(plan.road, pose[State.X], pose[State.Y], before)


@kernel
def trace_heights(road: RoadTables, kinds: Ints, states: Floats, samples: int, heights: Floats) -> None:
    """Write the heights of all actors [m] at the first samples of a record; those of absent actors are undefined."""
    for actor in range(states.shape[1]):
        present = False
        for k in range(samples):
            pose = states[k, actor]
            if pose[State.PRESENT] == 0.0:
                present = False
                continue
            if present:
                heights[k, actor] = next_height(road, pose[State.X], pose[State.Y], heights[k - 1, actor])
            else:
                x, y, heading = pose[State.X], pose[State.Y], pose[State.HEADING]
                heights[k, actor] = first_height(road, actor, int(kinds[actor]), x, y, heading, heights[k, 0])
            present = True


@deferred()
def trace_levels(plan: Plan, run: Run, samples: int) -> None:
    """Write the heights at the first samples of a run into `Run.heights`, for `recall_levels` and `follow_levels`."""
    trace_heights(plan.road, plan.kinds, run.states, samples, run.heights)


@deferred()
def recall_levels(plan: Plan, run: Run, sample: int) -> None:
    """Set the heights of all actors to those of a sample of `trace_levels`."""
    for actor in range(len(plan.kinds)):
        run.actors[actor, Memory.HEIGHT] = run.heights[sample, actor]


@deferred()
def follow_levels(plan: Plan, run: Run, sample: int) -> None:
    """Set the heights of the others to those of a sample of `trace_levels`, that of the ego by the sample before."""
    pose, before = run.states[sample, 0], run.actors[0, Memory.HEIGHT]
    recall_levels(plan, run, sample)
    run.actors[0, Memory.HEIGHT] = next_height(plan.road, pose[State.X], pose[State.Y], before)


@deferred()
def look_back(plan: Plan, run: Run, sample: int, seen: int) -> None:
    """Set the heights of all actors at `sample` to those at an earlier sample, until `look_ahead` restores them.

    Heights are followed backwards, because parallel runs keep only their last samples.
    """
    actors, kept = len(plan.kinds), len(run.heights) - 1
    for actor in range(actors):
        height = run.actors[actor, Memory.HEIGHT]
        run.heights[kept, actors + actor] = height
        for back in range(sample - seen if run.actors[actor, Memory.FREE] != HOSTED else 0):
            pose = run.states[sample - 1 - back, actor]
            if pose[State.PRESENT] != 0.0:
                height = next_height(plan.road, pose[State.X], pose[State.Y], height)
        run.actors[actor, Memory.HEIGHT] = height


@deferred()
def look_ahead(plan: Plan, run: Run) -> None:
    """Restore the heights of all actors after `look_back`."""
    actors, kept = len(plan.kinds), len(run.heights) - 1
    for actor in range(actors):
        run.actors[actor, Memory.HEIGHT] = run.heights[kept, actors + actor]


@kernel
def hide_levels(states: Floats, samples: int, heights: Floats, touched: int, contact: int) -> None:
    """Let each other actor be absent while it is not on the ego's level, and store its presence behind `heights`.

    A pair has one time together: of several times on one level with the ego, that of the smallest distance; for the
    actor `touched` in the step after the sample `contact`, that of the contact (-1: no such actor). `heights`
    (rows, 2 * actors).
    """
    actors = states.shape[1]
    for other in range(1, actors):
        first, last, least, begin = 0, 0, math.inf, -1
        nearest = math.inf
        for k in range(samples + 1):
            together = k < samples and states[k, 0, State.PRESENT] != 0.0 and states[k, other, State.PRESENT] != 0.0
            meets = other == touched and k == contact
            if together and (meets or abs(heights[k, other] - heights[k, 0]) < LEVEL):
                begin = k if begin < 0 else begin
                nearest = -1.0 if meets else nearest
                dx = states[k, other, State.X] - states[k, 0, State.X]
                dy = states[k, other, State.Y] - states[k, 0, State.Y]
                nearest = min(nearest, dx * dx + dy * dy)
                continue
            if begin >= 0 and nearest < least:
                first, last, least = begin, k, nearest
            begin, nearest = -1, math.inf
        for k in range(samples):
            heights[k, actors + other] = states[k, other, State.PRESENT]
            if not first <= k < last:
                states[k, other, State.PRESENT] = 0.0


@deferred()
def measure_on_levels(plan: Plan, run: Run, samples: int) -> None:
    """Prepare the record of a run for measures of pairs on one level; `restore_levels` reverts it."""
    trace_heights(plan.road, plan.kinds, run.states, samples, run.heights)
    touched = int(run.status[Status.CONTACT_OTHER])
    hide_levels(run.states, samples, run.heights, touched, int(run.status[Status.SAMPLE]) - 1)
    for actor in range(len(plan.kinds)):
        run.heights[len(run.heights) - 1, actor] = run.actors[actor, Memory.HEIGHT]
        run.actors[actor, Memory.HEIGHT] = 0.0
    run.status[Status.SHADED] = -1


@deferred()
def restore_levels(plan: Plan, run: Run, samples: int) -> None:
    """Restore the record and the heights of all actors after `measure_on_levels`."""
    actors = len(plan.kinds)
    for actor in range(actors):
        for k in range(samples if actor > 0 else 0):
            run.states[k, actor, State.PRESENT] = run.heights[k, actors + actor]
        run.actors[actor, Memory.HEIGHT] = run.heights[len(run.heights) - 1, actor]


@inlined
def has_levels(plan: Plan) -> bool:
    """Return True if roads pass over one another."""
    return len(plan.road.heights) > 0
