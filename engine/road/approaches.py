"""Parts of all lanes from which a vehicle comes over a crossing."""

import math
from functools import lru_cache

import numpy as np

from engine.road.linking import NOWHERE, Window
from engine.road.network import Lane, Network, Surface, once_per_network

REACH = 200.0
"""Distance before a crossing within which vehicles count [m]: 8 s at 25 m/s."""
SPACING = 0.25
"""Largest distance of the points of a crossing that are compared with lanes [m]."""


@once_per_network
def _found(network: Network) -> dict[int, tuple[Window, ...]]:
    """Return the windows of the crossings that were asked for, by id."""
    del network
    return {}


def approaches(crossing: Surface) -> tuple[Window, ...]:
    """Return a window per lane of the network: the part on the crossing, for any continuation of the lane."""
    found = _found(crossing.network)
    if crossing.id not in found:
        found[crossing.id] = _approaches(crossing)
    return found[crossing.id]


def _approaches(crossing: Surface) -> tuple[Window, ...]:
    lanes = crossing.network.lanes
    found = [_on(crossing, lane) for lane in lanes]
    front = [lane for lane, window in zip(lanes, found, strict=True) if window is not NOWHERE]
    while front:
        after = front.pop()
        for lane in after.predecessors:
            enter = lane.length + found[after.id].enter
            if enter - lane.length < REACH and enter < found[lane.id].enter:
                found[lane.id] = Window(enter, max(lane.length + found[after.id].leave, found[lane.id].leave))
                front.append(lane)
    return tuple(found)


def _on(crossing: Surface, lane: Lane) -> Window:
    """Return the part of a lane that lies on a crossing."""
    network, points = lane.network, _points(crossing.length, crossing.width)
    start = crossing.ends_at[0]
    c, s = math.cos(start.heading), math.sin(start.heading)
    x, y = start.x + points[0] * c - points[1] * s, start.y + points[0] * s + points[1] * c
    feet = network.paths.feet(lane.path, x, y)
    inside = (feet.distance <= 0.5 * lane.width) & (feet.s > 0.0) & (feet.s < lane.length)
    return Window(float(feet.s[inside].min()), float(feet.s[inside].max())) if inside.any() else NOWHERE


@lru_cache(maxsize=64)
def _points(length: float, width: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the points (n,) of a rectangle, along from 0 and across from its middle [m]."""
    along = np.linspace(0.0, length, 2 + int(length / SPACING))
    across = np.linspace(-0.5 * width, 0.5 * width, 2 + int(width / SPACING))
    both = np.meshgrid(along, across)
    return both[0].ravel(), both[1].ravel()
