"""Our lanes as lanelets: two bounds of equally many points, with the lanes beside each.

Points that several bounds share are the same to the last bit: along a neighbour, and from a lane to its successors.
"""

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from engine.road.junction import CHORD_TOLERANCE
from engine.road.network import Lane, Leg, Network
from engine.tables import Floats

SAME = 1e-6
"""Points of bounds closer than this are one [m]; as `PathBook` joins paths."""


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
    """All lanes, connecting ones too, in the order of `network.lanes`."""
    rows, shared = _rows(network), _SharedPoints()
    inwards, outwards = _neighbours(network, rows)
    beside_left, beside_right = (outwards, inwards) if network.spec.left_hand else (inwards, outwards)
    chords = {lane.id: _chords(row) for row in rows for lane in row}

    def lanelet(lane: Lane) -> Lanelet:
        left, right = (_bound(lane, side, chords[lane.id], shared) for side in (1.0, -1.0))
        return Lanelet(lane, left, right, beside_left.get(lane.id), beside_right.get(lane.id))

    return tuple(map(lanelet, network.lanes))


def legs(network: Network) -> Iterator[Leg]:
    return (leg for intersection in network.intersections for leg in intersection.legs)


# -- who lies beside whom


def _rows(network: Network) -> list[tuple[Lane, ...]]:
    """Lanes of one direction side by side, from the kerb to the middle; each lane is in a row."""
    rows = [row for leg in legs(network) for row in (leg.incoming_lanes, leg.outgoing_lanes)]
    turns: dict[tuple[int, str, str, int], list[Lane]] = defaultdict(list)
    for maneuver in network.maneuvers:
        start, end = maneuver.start_lane, maneuver.end_lane
        turns[maneuver.intersection_id, start.road, end.road, end.number - start.number].append(
            maneuver.connecting_lane
        )
    return rows + [tuple(sorted(row, key=lambda lane: lane.number)) for row in turns.values()]


def _neighbours(network: Network, rows: list[tuple[Lane, ...]]) -> tuple[dict[int, Beside], dict[int, Beside]]:
    """Per lane the one towards the middle of the road, and the one towards its kerb."""
    inwards: dict[int, Beside] = {}
    outwards: dict[int, Beside] = {}
    for row in rows:
        for outer, inner in pairwise(row):
            inwards[outer.id], outwards[inner.id] = Beside(inner.id, True), Beside(outer.id, True)
    for leg in legs(network):
        coming, leaving = leg.incoming_lanes[-1].id, leg.outgoing_lanes[-1].id
        inwards[coming], inwards[leaving] = Beside(leaving, False), Beside(coming, False)
    return inwards, outwards


# -- bounds


def _chords(row: tuple[Lane, ...]) -> int:
    """Equal chords that each lane of a row is cut into: enough for the widest of its arcs."""
    return max(len(lane.network.paths.stations(lane.path, CHORD_TOLERANCE)) - 1 for lane in row)


def _bound(lane: Lane, side: float, chords: int, shared: "_SharedPoints") -> Floats:
    """The left (side 1) or right (side -1) bound."""
    paths, shift = lane.network.paths, side * 0.5 * lane.width
    poses = [paths.pose(lane.path, lane.length * (i / chords)) for i in range(chords + 1)]
    return np.array(
        [shared.point(p.x - shift * np.sin(p.heading), p.y + shift * np.cos(p.heading)) for p in poses]
    )  # fmt: skip


class _SharedPoints:
    """Points of all bounds: one that was there before, up to rounding, comes back as it was."""

    def __init__(self) -> None:
        self._known: dict[tuple[int, int], tuple[float, float]] = {}

    def point(self, x: float, y: float) -> tuple[float, float]:
        column, row = round(x / SAME), round(y / SAME)
        for near in ((column + i, row + j) for i in (0, -1, 1) for j in (0, -1, 1)):
            if near in self._known:
                return self._known[near]
        self._known[column, row] = float(x), float(y)
        return self._known[column, row]
