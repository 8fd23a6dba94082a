"""The plan of a file: lanes with their centre lines, junctions and surfaces. Its computation is slow and cached.

Each place where roads pass over each other needs a note. Such a file has heights, by which actors keep their level.
"""

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import pairwise, zip_longest
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from engine.errors import InterchangeError
from engine.frozen import frozen
from engine.maps import digest_of
from engine.opendrive.read import read_opendrive
from engine.opendrive.roads import OdrRoad, limit_at, value_at
from engine.road.network import Lines
from engine.road.opendrive.beside import SurfacePlan, surfaces_of
from engine.road.opendrive.drawing import DrawnLane, drawn
from engine.road.opendrive.lanes import THROUGH, FileLane, Part
from engine.road.opendrive.linking import Links, Way
from engine.road.opendrive.remarks import remarks_on, unread_lanes
from engine.road.opendrive.surfaces import (
    NoSurface,
    outline,
    shapely,
    strip_between,
    union,
)
from engine.road.paths import Primitive
from engine.road.regions import Shape
from engine.tables import Floats
from engine.unread import not_read
from engine.vocabulary import LEVEL, HeightColumn

# -- roads that pass over each other -----------------------------------------------------------------------------------

APART = 1.0
"""Least difference in height between surfaces of which one passes over the other [m]; a car is about 1.5 m high."""
SPACING = 5.0
"""Spacing of the places along a lane at which heights are compared [m]."""
SAME_PLACE = 30.0
"""Distance along a road within which two of its places are on one level [m]: it may climb 1 m on the way."""
TOUCHING = 0.01
"""Common area up to which surfaces only touch [m^2]."""
ONE_PLANE = "less than a level, so that both are treated as one plane"
STATIONS = 2.0
"""Largest spacing of the points with heights along a lane [m]."""
SLOPES = 11
"""Number of places of a piece of an elevation profile at which its slope is computed."""
FLAT = 0.001
"""Slope up to which a road is flat."""
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


class Levels(NamedTuple):
    """Roads that pass over one another."""

    apart: tuple[str, ...] = ()
    """A sentence for each pair of roads on different levels."""
    near: tuple[str, ...] = ()
    """A sentence for each pair of roads that are less than a level apart."""
    heights: Floats = np.zeros((0, 6))
    """`Network.heights`"""


def levels(links: Links, found: Sequence[DrawnLane]) -> Levels:
    """Return the pairs of roads that cross at different heights, and the heights of all lanes if levels differ."""
    roads = links.network.roads
    if not any(road.heights for road in roads.values()):
        return Levels()
    tiles = [
        tile for lane, each in zip(links.lanes, found, strict=True) for tile in _tiles(roads[lane.road], each, SPACING)
    ]
    places = overlapping(tiles)
    apart = {pair: place for pair, place in places.items() if place[0] >= LEVEL}
    near = {pair: place for pair, place in places.items() if place[0] < LEVEL}
    close = tuple(f"{each}: {ONE_PLANE}" for each in sentences(near))
    return Levels(tuple(sentences(apart)), close, _heights(links, found) if apart else Levels().heights)


def sentences(places: Mapping[tuple[str, str], tuple[float, float, float]]) -> Iterator[str]:
    for (below, above), (height, x, y) in list(places.items())[:MOST]:
        yield f"road `{above[:40]}` passes {height:.1f} m above road `{below[:40]}` near ({x:.1f}, {y:.1f})"
    if len(places) > MOST:
        yield f"so do {len(places) - MOST} more pairs of roads"


def _steepest(roads: Iterable[OdrRoad]) -> str:
    """Return the end of the sentence about the steepest slope of all roads; empty without slopes."""
    slopes = [
        (abs(row.b + (2.0 * row.c + 3.0 * row.d * ahead) * ahead), road.id)
        for road in roads
        for row, after in zip_longest(road.heights, road.heights[1:])
        for ahead in np.linspace(0.0, max(0.0, (after.start if after else road.length) - row.start), SLOPES).tolist()
    ]
    slope, name = max((each for each in slopes if math.isfinite(each[0])), default=(0.0, ""))
    return f"; slopes of up to {100.0 * slope:.1f} %, on road `{name[:40]}`" if slope >= FLAT else ""


def _heights(links: Links, found: Sequence[DrawnLane]) -> Floats:
    """Return the rows of `Network.heights`."""
    rows: list[tuple[float, ...]] = []
    for number, (lane, each) in enumerate(zip(links.lanes, found, strict=True)):
        road = links.network.roads[lane.road]
        for part in each.rows:
            cuts = np.linspace(part.start, part.end, max(2, math.ceil((part.end - part.start) / STATIONS) + 1)).tolist()
            rows += rising([(*part.beside(s, part.centre(s)), value_at(road.heights, s)) for s in cuts], number)
    return np.array(rows).reshape(-1, len(HeightColumn))


def rising(points: Iterable[tuple[float, float, float]], lane: int) -> Iterator[tuple[float, ...]]:
    """Yield the rows of `Network.heights` between the points x, y, height [m] of a lane."""
    for (x, y, z), (x1, y1, z1) in pairwise(points):
        way = max((x1 - x) ** 2 + (y1 - y) ** 2, SAME**2)
        slope = ((z1 - z) * (x1 - x) / way, (z1 - z) * (y1 - y) / way)
        yield (0.5 * (x + x1), 0.5 * (y + y1), 0.5 * (z + z1), *slope, float(lane))


def _tiles(road: OdrRoad, lane: DrawnLane, spacing: float) -> Iterator[Tile]:
    for row in lane.rows:
        cuts = np.linspace(row.start, row.end, max(2, math.ceil((row.end - row.start) / spacing) + 1)).tolist()
        sides = [[row.beside(s, row.border(s, outer=outer)) for s in cuts] for outer in (False, True)]
        for i, (first, last) in enumerate(pairwise(cuts)):
            (a, b), (c, d) = (side[i : i + 2] for side in sides)
            middle = 0.5 * (first + last)
            yield Tile(road.id, middle, value_at(road.heights, middle), (a, b, d, c))


def overlapping(tiles: Sequence[Tile]) -> dict[tuple[str, str], tuple[float, float, float]]:
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


SAME = 1e-6
"""Distance below which points are equal [m]."""


@frozen
class LanePlan:
    """The plan of one lane."""

    lane: FileLane
    line: tuple[Primitive, ...]
    """Its centre, in driving direction."""
    shape: Shape
    bounds: tuple[Floats, Floats]
    """Left and right border with equal numbers of points, in driving direction."""
    width: float
    number: int
    name: str
    left: int | None
    right: int | None
    speed_limit: float | None
    """Speed limit in the middle of its longest part [m/s]."""


@frozen
class Plan:
    """A file's lanes, junctions and surfaces."""

    links: Links
    lanes: tuple[LanePlan, ...]
    junctions: Mapping[str, tuple[Way, ...]]
    areas: Mapping[str, Shape]
    surface: Shape
    drawn: Lines
    left_hand: bool
    remarks: tuple[str, ...]
    levels: tuple[str, ...]
    """Roads that pass over others, a sentence each."""
    heights: Floats
    """`Network.heights`"""
    unread: str
    """Content of the file that the reader does not read."""
    surfaces: tuple[SurfacePlan, ...]
    """Surfaces beside the lanes, crossings last."""


@lru_cache(maxsize=8)
def plan_of(path: str, digest: str) -> Plan:
    """Return the plan of a file with this digest; it is cached.

    Raises:
        InterchangeError: it is not an OpenDRIVE file with drivable roads, or it was replaced meanwhile.
    """
    network = read_opendrive(path)
    if digest_of(Path(path)) != digest:
        raise InterchangeError("the file changed while it was read", "start again once it is written", Path(path).name)
    links, found, left_out = drawn(network)
    lanes = tuple(_lane_plans(links, found))
    borders = [(each.inner, each.outer) for each in found]
    junctions: dict[str, list[Way]] = defaultdict(list)
    for way in links.ways:
        junctions[way.junction].append(way)
    inside: dict[str, list[Any]] = defaultdict(list)
    outlines: list[Any] = []
    try:
        outlines += (outline(*each) for each in borders)
        for lane, each in zip(links.lanes, outlines, strict=True):
            inside[network.roads[lane.road].junction].append(each)
        surface, kerbs = union(outlines)
        areas = {junction: _area(inside[junction]) for junction in junctions}
    except NoSurface as lost:
        raise _without_surface(links, outlines, lost, Path(path).name) from None
    left_hand = any(road.left_hand for road in network.roads.values())
    surfaces, lost = surfaces_of(links)
    over = levels(links, found)
    return Plan(
        links,
        lanes,
        {junction: tuple(ways) for junction, ways in junctions.items() if areas[junction] is not None},
        {junction: area for junction, area in areas.items() if area is not None},
        surface,
        Lines(kerbs, *_lines(links, borders)),
        left_hand,
        (*remarks_on(network, links, found, left_out, junctions, areas), *over.near, *lost),
        over.apart,
        over.heights,
        not_read((*network.unread, *unread_lanes(network))) + _steepest(network.roads.values()),
        surfaces,
    )


def _without_surface(links: Links, outlines: Sequence[Any], lost: NoSurface, file: str) -> InterchangeError:
    """Return the error about lanes whose surface is missing: it names one of them, unless no lane has any."""
    if lost.part is None:
        return InterchangeError("no lane in it has a width", "give its lanes a <width> above 0 m", file)
    lane = links.lanes[next((i for i, each in enumerate(outlines) if each.intersects(lost.part)), 0)]
    road = links.sections[lane.road].road
    what = f"the surface of lane {lane.parts[0].lane} of road `{road.id[:40]}` cannot be computed"
    return InterchangeError(what, "correct the widths and the reference line of that road", road.place)


def _area(outlines: Sequence[Any]) -> Shape | None:
    """Return the area of a junction's lanes; None if they have no width."""
    try:
        return union(outlines)[0]
    except NoSurface as lost:
        if lost.part is not None:
            raise
        return None


def _lane_plans(links: Links, found: Sequence[DrawnLane]) -> Iterator[LanePlan]:
    seen: dict[str, int] = defaultdict(int)
    for lane, each in zip(links.lanes, found, strict=True):
        rows, line = each.rows, each.line
        name, seen[lane.road] = f"road{lane.road}.lane{seen[lane.road]}", seen[lane.road] + 1
        widths = [row.width(0.5 * (row.start + row.end)) for row in rows]
        lengths = [row.end - row.start for row in rows]
        longest = lane.parts[int(np.argmax([_length(links, lane, part.section) for part in lane.parts]))]
        sections = links.sections[lane.road]
        beside = sections.drivable(longest.section)
        outward = [number for number in beside if number * longest.lane > 0 and abs(number) >= abs(longest.lane)]
        left, right = _neighbours(links, lane, longest, beside)
        yield LanePlan(
            lane,
            line if lane.forward else tuple(each.turned() for each in reversed(line)),
            strip_between(each.inner, each.outer),
            _bounds(lane, each.inner, each.outer),
            float(np.average(widths, weights=lengths)) or 0.1,
            len(outward),
            name,
            left,
            right,
            _speed_limit(links, lane, longest),
        )


def _bounds(lane: FileLane, inner: Floats, outer: Floats) -> tuple[Floats, Floats]:
    """Return the left and right border in driving direction, without repeated pairs of points."""
    left, right = (inner, outer) if lane.parts[0].lane < 0 else (outer, inner)
    new = (np.hypot(*np.diff(left, axis=0).T) > SAME) | (np.hypot(*np.diff(right, axis=0).T) > SAME)
    distinct = np.concatenate([[True], new])
    left, right = left[distinct], right[distinct]
    return (left, right) if lane.forward else (right[::-1], left[::-1])


def _speed_limit(links: Links, lane: FileLane, at: Part) -> float | None:
    sections = links.sections[lane.road]
    row, end = sections.rows[at.section]
    return limit_at(0.5 * (row.start + end), row.lanes[at.lane].speeds, sections.road.speeds)


def _length(links: Links, lane: FileLane, section: int) -> float:
    row, end = links.sections[lane.road].rows[section]
    return end - row.start


def _neighbours(links: Links, lane: FileLane, at: tuple[int, int], beside: Sequence[int]) -> list[int | None]:
    """Return the lanes to the left and right of its longest part."""
    section, number = at
    side = 1 if number > 0 else -1
    inner, outer = (number - side if number != side else -side), number + side
    left, right = (inner, outer) if (number < 0) == lane.forward else (outer, inner)
    of = links.lane_of
    return [of.get((lane.road, (section, each))) if each in beside else None for each in (left, right)]  # type: ignore[call-overload]


def _lines(links: Links, borders: Sequence[tuple[Floats, Floats]]) -> tuple[tuple[Floats, ...], tuple[Floats, ...]]:
    """Return middle lines, and lines between lanes of one direction, outside junctions."""
    middle: list[Floats] = []
    between: list[Floats] = []
    for lane, (inner, _) in zip(links.lanes, borders, strict=True):
        sections = links.sections[lane.road]
        if sections.road.junction != THROUGH:
            continue
        inmost = min(abs(part.lane) for part in lane.parts) == 1
        if not inmost:
            between.append(inner)
        elif lane.forward and _is_two_way(links, lane):
            middle.append(inner)
    return tuple(middle), tuple(between)


def _is_two_way(links: Links, lane: FileLane) -> bool:
    section, number = lane.parts[0]
    return any(other * number < 0 for other in links.sections[lane.road].drivable(section))
