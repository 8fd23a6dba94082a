"""Centre lines of lanelets as chains of lines and arcs.

The package gives a centre line as a polyline with the points of both bounds, which zigzags by centimetres. Points
within `NOISE` of a straight line are left out; biarcs as long as possible then pass within `TOLERANCE` of all points.
At a point the heading is the mean of those before and after it, weighted by the squares of the lengths, so that a
straight piece stays straight beside a curve. Where consecutive lanelets meet, they have one heading, by the same
rule.
"""

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise

import numpy as np

from engine.lanelet2.read import distinct
from engine.opendrive.curves import Pose
from engine.road.opendrive.fitting import biarc, distances
from engine.road.opendrive.surfaces import shapely
from engine.road.paths import Primitive
from engine.tables import Floats

NOISE = 0.01
"""Largest distance of a point that is left out at first [m]."""
TOLERANCE = 0.02
"""Largest distance of a centre line from the points of the polyline [m]."""
BULGE = 0.1
"""Largest distance of an arc from the straight pieces of the polyline that it replaces [m]."""
STEP = 0.5
"""Spacing of the places at which a straight piece is compared [m]."""
LONG = 20.0
"""Length beyond which a piece has no more weight [m]."""
DETOUR = 1.5
"""Ratio of the lengths of a biarc and its chord beyond which the chord is taken: a kink of the map."""
GRID = 1e-3
"""Distance within which ends of centre lines are one point [m]."""

Point = tuple[int, int]
Ends = Mapping[Point, float]
"""Heading [rad] at each end of a centre line."""


def headings_of_ends(centres: Iterable[Floats]) -> Ends:
    """Return the common heading of all centre lines at each of their ends."""
    ways: dict[Point, list[tuple[float, float]]] = defaultdict(list)
    for centre in centres:
        line = _simplified(distinct(centre))
        for end, piece in ((line[0], line[1] - line[0]), (line[-1], line[-1] - line[-2])):
            ways[_cell(end)].append(_weighted(piece))
    return {
        place: math.atan2(math.fsum(y for _, y in found), math.fsum(x for x, _ in found))
        for place, found in ways.items()
    }


def _weighted(piece: Floats) -> tuple[float, float]:
    """Return the direction of a piece, with its weight as the length."""
    x, y = (float(each) for each in piece)
    length = math.hypot(x, y)
    weight = min(length, LONG) ** 2 / length
    return x * weight, y * weight


def _cell(point: Floats) -> Point:
    return round(float(point[0]) / GRID), round(float(point[1]) / GRID)


def _simplified(line: Floats) -> Floats:
    """Return a polyline without points nearer than `NOISE` to what is left; its ends stay."""
    if len(line) < 3:
        return line
    return np.array(shapely.LineString(line).simplify(NOISE, preserve_topology=False).coords)


def centre_line(centre: Floats, ends: Ends) -> tuple[Primitive, ...]:
    """Return the chain of a lanelet's centre line (n, 2), with the headings of its ends.

    It goes through the points that are left by `_simplified`, and through each point that it would pass too far away.
    """
    line = distinct(centre)
    # Index of each point of the simplified line among all of them.
    places = [int(np.argmin(np.hypot(*(line - point).T))) for point in _simplified(line)]
    while True:
        poses = _poses(line[places], ends)
        chain, missed = list[Primitive](), list[int]()
        here = 0
        while here < len(poses) - 1:
            last, found = _longest(line, places, poses, here)
            chain += found
            passed = line[places[here] + 1 : places[last]]
            if len(passed) and (away := distances(found, passed)).max() > TOLERANCE:
                missed.append(places[here] + 1 + int(away.argmax()))
            here = last
        if not missed:
            return tuple(chain)
        places = sorted({*places, *missed})


def _poses(line: Floats, ends: Ends) -> list[Pose]:
    """Return the points of a polyline with their headings."""
    ways = [_weighted(piece) for piece in np.diff(line, axis=0)]
    inner = [math.atan2(a[1] + b[1], a[0] + b[0]) for a, b in pairwise(ways)]
    headings = [ends[_cell(line[0])], *inner, ends[_cell(line[-1])]]
    return [Pose(x, y, heading) for (x, y), heading in zip(line.tolist(), headings, strict=True)]


def _longest(line: Floats, places: Sequence[int], poses: Sequence[Pose], here: int) -> tuple[int, list[Primitive]]:
    """Return the farthest point that one biarc reaches, and the biarc: by doubling, then by halving."""
    good, pieces = here + 1, _piece(poses[here], poses[here + 1])
    bad, step = len(poses), 1
    while good + 1 < bad:
        target = min(good + step, bad - 1)
        found = biarc(poses[here], poses[target])
        if found and _is_near(found, line[places[here] : places[target] + 1]):
            good, pieces, step = target, found, 2 * step
        else:
            bad, step = target, max(1, (target - good) // 2)
    return good, pieces


def _piece(first: Pose, last: Pose) -> list[Primitive]:
    """Return the biarc between neighbouring points; the straight line where there is none, or a long detour."""
    dx, dy = last.x - first.x, last.y - first.y
    chord = math.hypot(dx, dy)
    found = biarc(first, last)
    if found and math.fsum(each.length for each in found) < DETOUR * chord:
        return found
    return [Primitive(first.x, first.y, math.atan2(dy, dx), 0.0, chord)]


def lengths_along(line: Floats) -> Floats:
    """Return (n,) the lengths from the start of a polyline to its points, in the plane [m]."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line[:, :2], axis=0).T))])


def interpolated(places: Floats, stations: Floats, line: Floats) -> Floats:
    """Return the points of a polyline at some places; `stations` (n,) are those of its points."""
    return np.column_stack([np.interp(places, stations, line[:, column]) for column in range(line.shape[1])])


def _is_near(chain: Sequence[Primitive], line: Floats) -> bool:
    """Return True if a chain passes within the tolerances of the points of a polyline, and of the places between."""
    if (distances(chain, line) > TOLERANCE).any():
        return False
    s = lengths_along(line)
    places = np.arange(STEP, s[-1], STEP)
    between = interpolated(places, s, line)
    return not len(places) or not (distances(chain, between) > BULGE).any()
