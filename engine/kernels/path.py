"""Paths: poses, projections and speed limits along chains of lines and arcs. Same formulas as `engine.road.paths`.

Rows of `RoadTables.primitives` are `s0, x, y, heading, curvature, length, cos(heading), sin(heading)`. Positions in
metres, headings anticlockwise from +x in radians, curvature 1/m and positive to the left. A `RoadTables` has many words
to pass, so the public functions are copied into their callers and pass only the necessary ones to the compiled
functions.
"""

import math
from typing import NamedTuple

from engine.kernels.jit import inlined, kernel
from engine.tables import Floats, RoadTables

S0, X, Y, HEADING, CURVATURE, LENGTH, COS, SIN = range(8)
"""Columns of a primitive."""
MANY = 8
"""Number of primitives below which they are searched linearly."""
ROUNDING = 1e-6
"""Far more than distances are rounded by [m]."""


class PathPoint(NamedTuple):
    """The point of a path nearest to a given point."""

    s: float
    """Arc length, held inside the path [m]."""
    offset: float
    """Offset of the given point to the left of the path [m]."""
    heading: float
    """Heading of the path at s; not wrapped [rad]."""
    curvature: float
    """Curvature of the path at s, positive to the left [1/m]."""


class PathPose(NamedTuple):
    x: float
    y: float
    heading: float
    """Heading, not wrapped [rad]."""


class PathPlace(NamedTuple):
    x: float
    y: float
    cos: float
    """Cosine of the heading."""
    sin: float


@inlined
def path_pose(road: RoadTables, path: int, s: float) -> PathPose:
    """Return the pose at arc length `s`, limited to the path."""
    return chain_pose(road.primitives, road.path_start[path], road.path_start[path + 1], s)


@inlined
def path_curvature(road: RoadTables, path: int, s: float) -> float:
    """Return the curvature at arc length `s` [1/m]; at a joint that of the primitive that begins there."""
    return road.primitives[_find(road.primitives, road.path_start[path], road.path_start[path + 1], s), CURVATURE]


@inlined
def path_project(road: RoadTables, path: int, x: float, y: float) -> float:
    """Return the arc length of the nearest point of the whole path [m]; of equally near ones the first."""
    return chain_project(road.primitives, road.path_start[path], road.path_start[path + 1], x, y)[0]


@inlined
def path_distance(road: RoadTables, path: int, x: float, y: float) -> float:
    """Return the distance from (x, y) to the path's centre line [m]."""
    return chain_project(road.primitives, road.path_start[path], road.path_start[path + 1], x, y)[1]


@inlined
def path_project_near(road: RoadTables, path: int, x: float, y: float, s_guess: float) -> PathPoint:
    """Return the nearest point close to `s_guess`, for a follower that moved a little: without a search of the whole
    path.

    Beyond an end of the path `s` is that of the end and `offset` is measured from the end's tangent.
    """
    return _project_near(road.primitives, road.path_start[path], road.path_start[path + 1], x, y, s_guess)


@inlined
def speed_limit_ahead(road: RoadTables, path: int, s: float, max_lateral: float, deceleration: float) -> float:
    """Return the largest present speed from which every curve ahead can be met [m/s]; infinite for a straight path.

    min over the primitives ahead of sqrt(v_i^2 + 2 a (s_i - s)), with v_i^2 = `max_lateral` / |curvature|.
    """
    return chain_speed_limit(
        road.primitives, road.path_start[path], road.path_start[path + 1], s, max_lateral, deceleration
    )


@kernel
def _find(primitives: Floats, start: int, end: int, s: float) -> int:
    """Return the row of the primitive at arc length `s`: by bisection of many, as on the lanes of a town."""
    row, beyond = start, end
    while beyond - row > MANY:
        middle = (row + beyond) // 2
        if s >= primitives[middle, S0]:
            row = middle
        else:
            beyond = middle
    while row + 1 < beyond and s >= primitives[row + 1, S0]:
        row += 1
    return row


@kernel
def chain_pose(primitives: Floats, start: int, end: int, s: float) -> PathPose:
    row = _find(primitives, start, end, s)
    along = min(max(s - primitives[row, S0], 0.0), primitives[row, LENGTH])
    return _primitive_pose(primitives, row, along)


@kernel
def chain_place(primitives: Floats, start: int, end: int, s: float) -> PathPlace:
    """Return the same as `chain_pose`, with cosine and sine of the heading."""
    row = _find(primitives, start, end, s)
    if primitives[row, CURVATURE] == 0.0:
        along = min(max(s - primitives[row, S0], 0.0), primitives[row, LENGTH])
        cos, sin = primitives[row, COS], primitives[row, SIN]
        return PathPlace(primitives[row, X] + along * cos, primitives[row, Y] + along * sin, cos, sin)
    pose = chain_pose(primitives, row, row + 1, s)
    return PathPlace(pose.x, pose.y, math.cos(pose.heading), math.sin(pose.heading))


@inlined
def _primitive_pose(primitives: Floats, row: int, along: float) -> PathPose:
    """Return the pose at `along` [m] from the start of a primitive."""
    curvature = primitives[row, CURVATURE]
    ahead, left, angle = along, 0.0, 0.0
    if curvature != 0.0:
        angle = curvature * along
        half = math.sin(0.5 * angle)
        ahead, left = math.sin(angle) / curvature, 2.0 * half * half / curvature
    cos, sin = primitives[row, COS], primitives[row, SIN]
    return PathPose(
        primitives[row, X] + ahead * cos - left * sin,
        primitives[row, Y] + ahead * sin + left * cos,
        primitives[row, HEADING] + angle,
    )


@inlined
def local_place(primitives: Floats, row: int, x: float, y: float) -> tuple[float, float]:
    """Return the position of a point ahead of a primitive's start, and to its left [m]."""
    dx, dy = x - primitives[row, X], y - primitives[row, Y]
    cos, sin = primitives[row, COS], primitives[row, SIN]
    return dx * cos + dy * sin, dy * cos - dx * sin


@inlined
def _arc_angle(curvature: float, ahead: float, left: float) -> float:
    """Return the angle on the circle up to the point's normal, in (-pi, pi] [rad]."""
    if curvature > 0.0:
        return math.atan2(ahead, 1.0 / curvature - left)
    return math.atan2(ahead, left - 1.0 / curvature)


@inlined
def _arc_offset(curvature: float, ahead: float, left: float) -> float:
    """Return the offset of a point to the left of the circle [m]: radius minus distance from the centre, signed by the
    side.
    """
    radius = 1.0 / curvature
    return radius - math.copysign(math.sqrt(ahead * ahead + (radius - left) * (radius - left)), radius)


@inlined
def chain_project(primitives: Floats, start: int, end: int, x: float, y: float) -> tuple[float, float]:
    """Return arc length and distance of the nearest point [m]; of equally near ones the first."""
    return chain_project_within(primitives, start, end, x, y, math.inf)


@inlined
def chain_project_within(
    primitives: Floats, start: int, end: int, x: float, y: float, bound: float
) -> tuple[float, float]:
    """Return the same if the distance is below `bound`; else 0 and `bound`.

    Primitives that begin too far away are skipped, and those whose whole line or circle is: they are no nearer.
    """
    best_s, best_distance = 0.0, bound
    for row in range(start, end):
        dx, dy = x - primitives[row, X], y - primitives[row, Y]
        reach = best_distance + primitives[row, LENGTH] + ROUNDING
        if dx * dx + dy * dy > reach * reach:
            continue
        ahead, left = local_place(primitives, row, x, y)
        curvature = primitives[row, CURVATURE]
        aside = left if curvature == 0.0 else _arc_offset(curvature, ahead, left)
        if abs(aside) > best_distance + ROUNDING:
            continue
        s, distance = _primitive_foot(primitives, row, x, y)
        if distance < best_distance:
            best_s, best_distance = primitives[row, S0] + s, distance
    return best_s, best_distance


@inlined
def _primitive_foot(primitives: Floats, row: int, x: float, y: float) -> tuple[float, float]:
    """Return the arc length from a primitive's start to its nearest point, and the distance to it [m]."""
    ahead, left = local_place(primitives, row, x, y)
    length, curvature = primitives[row, LENGTH], primitives[row, CURVATURE]
    if curvature == 0.0:
        s = min(max(ahead, 0.0), length)
        return s, abs(left) if s == ahead else math.hypot(ahead - s, left)
    s = _arc_angle(curvature, ahead, left) / abs(curvature)
    if 0.0 <= s <= length:
        return s, abs(_arc_offset(curvature, ahead, left))
    pose = _primitive_pose(primitives, row, length)
    to_start, to_end = math.hypot(ahead, left), math.hypot(x - pose.x, y - pose.y)
    if to_end < to_start:
        return length, to_end
    return 0.0, to_start


@kernel
def _project_near(primitives: Floats, start: int, end: int, x: float, y: float, s_guess: float) -> PathPoint:
    row = _find(primitives, start, end, s_guess)
    direction = 0
    while True:
        ahead, left = local_place(primitives, row, x, y)
        length, curvature = primitives[row, LENGTH], primitives[row, CURVATURE]
        s = ahead
        if curvature != 0.0:
            s = _arc_angle(curvature, ahead, left) / abs(curvature)
        # Two neighbours share the normal at their joint; rounding there must not send the search to and fro.
        if s > length and row + 1 < end and direction >= 0:
            row, direction = row + 1, 1
        elif s < 0.0 and row > start and direction <= 0:
            row, direction = row - 1, -1
        else:
            return _point(primitives, row, s, ahead, left)


@inlined
def _point(primitives: Floats, row: int, s: float, ahead: float, left: float) -> PathPoint:
    curvature = primitives[row, CURVATURE]
    along = min(max(s, 0.0), primitives[row, LENGTH])
    if curvature == 0.0:
        return PathPoint(primitives[row, S0] + along, left, primitives[row, HEADING], 0.0)
    offset = _arc_offset(curvature, ahead, left)
    if along != s:  # beyond an end of the path: measured from the tangent there
        angle = curvature * along
        half = math.sin(0.5 * angle)
        offset = (left - 2.0 * half * half / curvature) * math.cos(angle) - (
            ahead - math.sin(angle) / curvature
        ) * math.sin(angle)
    return PathPoint(primitives[row, S0] + along, offset, primitives[row, HEADING] + curvature * along, curvature)


@inlined
def chain_speed_limit(
    primitives: Floats, start: int, end: int, s: float, max_lateral: float, deceleration: float
) -> float:
    squared = math.inf
    for row in range(_find(primitives, start, end, s), end):
        allowance = 2.0 * deceleration * max(primitives[row, S0] - s, 0.0)
        if allowance >= squared:
            break
        if primitives[row, CURVATURE] != 0.0:
            squared = min(squared, max_lateral / abs(primitives[row, CURVATURE]) + allowance)
    return math.sqrt(squared)
