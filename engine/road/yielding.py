"""Whom a maneuver has to give way to: per lane, between which arc lengths others are in its way."""

import math

import numpy as np

from engine.frozen import frozen
from engine.road.network import Lane, Maneuver
from engine.road.paths import PathBook
from engine.tables import Floats

CLEARANCE = 2.5
"""Centre lines nearer than this cannot be driven on at once: a car's width and what drivers keep beside it [m]."""
PARTING = 1.0
"""Paths out of one lane are the same to others until they lie so far apart [m]."""
SPACING = 0.5
"""Between the points at which centre lines are compared [m]."""


@frozen
class Window:
    """Part of a lane, or of what follows it, on which somebody is in the way."""

    enter: float
    """Arc length on the lane at which the part begins; beyond the lane's end for one that leads there [m]."""
    leave: float
    """… and at which it ends."""


NOWHERE = Window(math.inf, -math.inf)
"""Of a lane from which nobody comes into the way."""


def windows(maneuver: Maneuver) -> tuple[Window, ...]:
    """One for each lane of the network: where others conflict with a maneuver, whatever they do next.

    Nobody can see which way another will go, so all who come from a lane with a conflicting maneuver count until their
    paths part.
    """
    found = [NOWHERE] * len(maneuver.intersection.network.lanes)
    conflicts = maneuver.conflicting_maneuvers
    for start in dict.fromkeys(other.start_lane for other in conflicts):
        mine = {other: _overlap(maneuver, other) for other in conflicts if other.start_lane is start}
        first = min(window.enter for window in mine.values())
        found[start.id] = Window(start.length + first, math.inf)
        for other in start.maneuvers:
            leave = mine[other].leave if other in mine else _parting(other, list(mine))
            found[other.connecting] = Window(mine[other].enter if other in mine else first, leave)
    return tuple(found)


def _points(paths: PathBook, lane: Lane) -> tuple[Floats, Floats]:
    """Arc lengths along a lane, and (n, 2) places there."""
    stations = np.linspace(0.0, lane.length, max(2, math.ceil(lane.length / SPACING) + 1))
    return stations, np.array([paths.pose(lane.path, s)[:2] for s in stations])


def _overlap(maneuver: Maneuver, other: Maneuver) -> Window:
    paths = other.intersection.network.paths
    stations, places = _points(paths, other.connecting_lane)
    near = stations[paths.feet(maneuver.connecting_lane.path, *places.T).distance < CLEARANCE]
    return Window(float(near.min()), float(near.max())) if len(near) else NOWHERE


def _parting(other: Maneuver, conflicting: list[Maneuver]) -> float:
    """How far `other` runs along with one of the conflicting maneuvers from the same lane [m]."""
    paths = other.intersection.network.paths
    stations, places = _points(paths, other.connecting_lane)
    distances = [paths.feet(each.connecting_lane.path, *places.T).distance for each in conflicting]
    together = stations[np.min(distances, axis=0) < PARTING]
    return float(together.max()) if len(together) else 0.0
