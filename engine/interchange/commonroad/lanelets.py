"""Lanes as lanelets: two bounds with equal numbers of points, and the adjacent lanes.

Points that several bounds share are equal to the last bit: along a neighbour, and from a lane to its successors. Lanes
of a map file have the borders of that file, and are neighbours if they share a whole border.
"""

from collections import defaultdict
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from engine.road.junction import CHORD_TOLERANCE
from engine.road.network import Lane, Network
from engine.tables import Floats

SAME = 1e-6
"""Largest distance between points of bounds that become one point [m]; as in `PathBook`."""


ONE_BORDER = 0.1
"""Largest distance between the ends of two lanes' borders in a file that count as one border [m]."""


@dataclass(frozen=True)
class Beside:
    """A neighbour of a lane."""

    lane: int
    same_direction: bool


@dataclass(frozen=True)
class Lanelet:
    """One lane; bounds are (n, 2) [m] in its direction."""

    lane: Lane
    left: Floats
    right: Floats
    beside_left: Beside | None
    beside_right: Beside | None


def lanelets(network: Network) -> tuple[Lanelet, ...]:
    """Return all lanes, connecting lanes included, in the order of `network.lanes`."""
    rows, shared = _rows(network), _SharedPoints()
    if network.bounds:
        beside_left, beside_right = (_beside_in_file(network, side) for side in (0, 1))
    else:
        inwards, outwards = _neighbours(network, rows)
        beside_left, beside_right = (outwards, inwards) if network.left_hand else (inwards, outwards)
    chords = {lane.id: _chords(row) for row in rows for lane in row}

    def lanelet(lane: Lane) -> Lanelet:
        if lane.id in network.bounds:
            left, right = (np.array([shared.point(x, y) for x, y in bound]) for bound in network.bounds[lane.id])
        else:
            left, right = (_bound(lane, side, chords[lane.id], shared) for side in (1.0, -1.0))
        return Lanelet(lane, left, right, beside_left.get(lane.id), beside_right.get(lane.id))

    return tuple(map(lanelet, network.lanes))


# -- neighbours


def _rows(network: Network) -> list[tuple[Lane, ...]]:
    """Return rows of parallel lanes of one direction, from the kerb to the middle; each lane is in one row."""
    rows = [group.lanes for road in network.roads for group in road.groups]
    turns: dict[tuple[int, str, str, int], list[Lane]] = defaultdict(list)
    for maneuver in network.maneuvers:
        start, end = maneuver.start_lane, maneuver.end_lane
        turns[maneuver.intersection_id, start.road, end.road, end.number - start.number].append(
            maneuver.connecting_lane
        )
    return rows + [tuple(sorted(row, key=lambda lane: lane.number)) for row in turns.values()]


def _neighbours(network: Network, rows: list[tuple[Lane, ...]]) -> tuple[dict[int, Beside], dict[int, Beside]]:
    """Return per lane its neighbour towards the middle of the road, and its neighbour towards the kerb."""
    inwards: dict[int, Beside] = {}
    outwards: dict[int, Beside] = {}
    for row in rows:
        for outer, inner in pairwise(row):
            inwards[outer.id], outwards[inner.id] = Beside(inner.id, True), Beside(outer.id, True)
    for forward, backward in (road.groups for road in network.roads if len(road.groups) == 2):
        coming, leaving = forward.lanes[-1].id, backward.lanes[-1].id
        inwards[coming], inwards[leaving] = Beside(leaving, False), Beside(coming, False)
    return inwards, outwards


def _beside_in_file(network: Network, side: int) -> dict[int, Beside]:
    """Return per lane of a file its neighbour on the left (side 0) or right (1), if both share the whole border."""
    found: dict[int, Beside] = {}
    for lane, others in (network.links.beside or {}).items():
        other = others[side]
        if other is None:
            continue
        same = network.lanes[lane].forward is network.lanes[other].forward
        mine = network.bounds[lane][side]
        theirs = network.bounds[other][1 - side] if same else network.bounds[other][side][::-1]
        if max(np.hypot(*(mine[end] - theirs[end])) for end in (0, -1)) < ONE_BORDER:
            found[lane] = Beside(other, same)
    return found


# -- bounds


def _chords(row: tuple[Lane, ...]) -> int:
    """Return the number of equal chords for each lane of a row, enough for the widest of its arcs."""
    return max(len(lane.network.paths.stations(lane.path, CHORD_TOLERANCE)) - 1 for lane in row)


def _bound(lane: Lane, side: float, chords: int, shared: "_SharedPoints") -> Floats:
    """Return the left (side 1) or right (side -1) bound."""
    paths, shift = lane.network.paths, side * 0.5 * lane.width
    poses = [paths.pose(lane.path, lane.length * (i / chords)) for i in range(chords + 1)]
    return np.array(
        [shared.point(p.x - shift * np.sin(p.heading), p.y + shift * np.cos(p.heading)) for p in poses]
    )  # fmt: skip


class _SharedPoints:
    """Points of all bounds: a point near an earlier point, up to rounding, is replaced by it."""

    def __init__(self) -> None:
        self._known: dict[tuple[int, int], tuple[float, float]] = {}

    def point(self, x: float, y: float) -> tuple[float, float]:
        column, row = round(x / SAME), round(y / SAME)
        for near in ((column + i, row + j) for i in (0, -1, 1) for j in (0, -1, 1)):
            if near in self._known:
                return self._known[near]
        self._known[column, row] = float(x), float(y)
        return self._known[column, row]
