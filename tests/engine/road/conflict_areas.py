"""Conflict areas: the stretches of two paths in which what drives along them can collide.

A strip is swept by a segment of the strip's width, square to the path. A station of one path is in conflict when its
segment reaches into the other strip. Stations are tried every `STEP`; the ends of each stretch are then bisected.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.road.paths import PathBook
from engine.tables import Floats

Stretch = tuple[float, float]
"""Arc lengths of first and last conflict on a path [m]."""
Conflict = tuple[Stretch, Stretch]
"""Stretch of the first path, and of the second."""

STEP = 0.25
"""Distance of the stations tried; a shorter stretch may be missed [m]."""
ACROSS = 9
"""Points tried on each segment."""
REACH = 1e-6
"""Strips that only touch side by side, like neighbouring lanes, do not overlap [m]."""


Bools = NDArray[np.bool_]
Test = Callable[[Floats], Bools]
"""For each arc length, whether the station there is in conflict."""


class Strip(NamedTuple):
    path: int
    width: float


def conflict_areas(paths: PathBook, first: Strip, second: Strip) -> list[Conflict]:
    """All conflict areas, in order along the first path."""
    areas: list[Conflict] = []
    for stretch in _stretches(paths, first, lambda s: _reaches(paths, first, s, second)):
        others = _stretches(paths, second, lambda s, near=stretch: _reaches(paths, second, s, first, near))
        if others:  # one area may be left and entered again on the second path: its whole extent counts
            areas.append((stretch, (others[0][0], others[-1][1])))
    return areas


def _stretches(paths: PathBook, strip: Strip, test: Test) -> list[Stretch]:
    """Where along the strip's path the test holds."""
    length = paths.length(strip.path)
    stations = np.linspace(0.0, length, max(2, round(length / STEP)) + 1)
    holds = np.concatenate([[False], test(stations), [False]])
    begins = np.flatnonzero(~holds[:-1] & holds[1:]).tolist()
    ends = (np.flatnonzero(holds[:-1] & ~holds[1:]) - 1).tolist()
    return [
        (_edge(test, stations, begin, begin - 1), _edge(test, stations, end, end + 1))
        for begin, end in zip(begins, ends, strict=True)
    ]


def _edge(test: Test, stations: Floats, inside: int, outside: int) -> float:
    """The place between two stations where the test changes, to a nanometre."""
    within = float(stations[inside])
    if not 0 <= outside < len(stations):
        return within
    beyond = float(stations[outside])
    while abs(beyond - within) > 1e-9:
        middle = 0.5 * (within + beyond)
        within, beyond = (middle, beyond) if test(np.array([middle]))[0] else (within, middle)
    return within


def _reaches(paths: PathBook, strip: Strip, s: Floats, other: Strip, near: Stretch | None = None) -> Bools:
    """Whether the segments at arc lengths `s` of one strip reach into the other (there: within the stretch `near`)."""
    poses = np.array([paths.pose(strip.path, value) for value in s])
    across = (np.linspace(-0.5, 0.5, ACROSS) * (strip.width - 2.0 * REACH))[None, :]
    x = poses[:, 0, None] - across * np.sin(poses[:, 2, None])
    y = poses[:, 1, None] + across * np.cos(poses[:, 2, None])
    feet = paths.feet(other.path, x, y)
    inside = feet.distance < 0.5 * other.width - REACH
    if near is not None:
        inside &= (feet.s >= near[0] - STEP) & (feet.s <= near[1] + STEP)
    return np.any(inside, axis=1)
