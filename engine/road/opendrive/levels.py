"""Roads of a file that pass over each other. Lanes are in one plane here, so each such place needs a note."""

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from engine.opendrive.roads import OdrRoad, value_at
from engine.road.opendrive.drawing import DrawnLane
from engine.road.opendrive.linking import Links
from engine.road.opendrive.surfaces import shapely
from engine.tables import Floats

APART = 1.0
"""Least difference in height between surfaces at different levels [m]; a car is about 1.5 m high."""
SPACING = 5.0
"""Spacing of the places along a lane at which heights are compared [m]."""
SAME_PLACE = 30.0
"""Distance along a road within which two of its places are on one level [m]: it may climb 1 m on the way."""
TOUCHING = 0.01
"""Common area up to which surfaces only touch [m^2]."""
MOST = 5
"""Maximum number of pairs of roads that are named; further pairs are counted."""


class Tile(NamedTuple):
    """A short piece of a lane."""

    road: str
    s: float
    """Arc length of its middle [m]."""
    height: float
    """[m]"""
    corners: tuple[tuple[float, float], ...]


def levels(links: Links, found: Sequence[DrawnLane]) -> Iterator[str]:
    """Yield the sentence about each pair of roads that cross at different heights."""
    roads = links.network.roads
    if not any(road.heights for road in roads.values()):
        return
    tiles = [
        tile for lane, each in zip(links.lanes, found, strict=True) for tile in _tiles(roads[lane.road], each, SPACING)
    ]
    places = _places(tiles)
    for (below, above), (height, x, y) in list(places.items())[:MOST]:
        yield f"road `{above[:40]}` passes {height:.1f} m above road `{below[:40]}` near ({x:.1f}, {y:.1f})"
    if len(places) > MOST:
        yield f"so do {len(places) - MOST} more pairs of roads"


def _tiles(road: OdrRoad, lane: DrawnLane, spacing: float) -> Iterator[Tile]:
    for row in lane.rows:
        cuts = np.linspace(row.start, row.end, max(2, math.ceil((row.end - row.start) / spacing) + 1)).tolist()
        sides = [[row.beside(s, row.border(s, outer=outer)) for s in cuts] for outer in (False, True)]
        for i, (first, last) in enumerate(pairwise(cuts)):
            (a, b), (c, d) = (side[i : i + 2] for side in sides)
            middle = 0.5 * (first + last)
            yield Tile(road.id, middle, value_at(road.heights, middle), (a, b, d, c))


def _places(tiles: Sequence[Tile]) -> dict[tuple[str, str], tuple[float, float, float]]:
    """Return by pair of roads, the lower one first, their difference in height and its place: (height, x, y) [m]."""
    corners: Floats = np.array([tile.corners for tile in tiles])
    polygons = shapely.make_valid(shapely.polygons(corners))
    heights: Floats = np.array([tile.height for tile in tiles])
    first, second = shapely.STRtree(polygons).query(polygons)
    apart = (heights[second] - heights[first]) >= APART
    found: dict[tuple[str, str], tuple[float, float, float]] = {}
    pairs: list[tuple[int, int]] = list(zip(first[apart].tolist(), second[apart].tolist(), strict=True))
    for one, other in pairs:
        below, above = tiles[one], tiles[other]
        key = (below.road, above.road)
        if key in found or (below.road == above.road and abs(below.s - above.s) < SAME_PLACE):
            continue
        common = polygons[one].intersection(polygons[other])
        if common.area > TOUCHING:
            found[key] = (above.height - below.height, common.centroid.x, common.centroid.y)
    return found
