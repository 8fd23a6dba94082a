"""The network of a Lanelet2 map: a lane for each lanelet of a road, an intersection where ways through it overlap.

Lanelets that overlap others, or that Autoware's `turn_direction` marks, are connecting lanes; those that overlap or
follow one another make one intersection. All others that lie side by side, in either direction, are one road. The
surface is that between the bounds as they are.
"""

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from engine.errors import InterchangeError
from engine.frozen import frozen
from engine.lanelet2.read import DRIVABLE, Lanelet, LaneletMap, read_lanelets
from engine.maps import LaneletFile
from engine.road.file_roads import (
    Junction,
    SurfaceRow,
    Way,
    add_intersections,
    add_roads,
    add_surfaces,
    link_lanes,
    role_of,
)
from engine.road.lanelet2.fitting import Ends, centre_line, headings_of_ends, interpolated, lengths_along
from engine.road.network import TRAFFIC_LIGHT, Lane, Lines, Network, RoadSign, SurfaceKind
from engine.road.opendrive.contents import Contents, packed
from engine.road.opendrive.lanes import ALIKE, NEAR
from engine.road.opendrive.planning import SPACING, STATIONS, Tile, overlapping, rising, sentences
from engine.road.opendrive.surfaces import NoSurface, outline, shape_of_polygon, shapely, union
from engine.road.paths import PathBook
from engine.tables import ROAD_REGION, Floats
from engine.vocabulary import LEVEL, HeightColumn

OVERLAP = 1.0
"""Common area from which two lanelets overlap [m^2]: bounds of neighbours may cross by centimetres."""
SHORT = 1e-9
SEEN = 9.0
"""Distance from the bounds up to which traffic in the other direction is looked for [m]: two lanes and a median."""
AGAINST = -0.9
"""Cosine of the angle between two lanelets from which they run in opposite directions."""
FLAT = 0.01
"""Difference of all heights up to which a map is flat [m]."""
KINDS: Mapping[str, SurfaceKind] = {
    "bicycle_lane": SurfaceKind.BIKE_LANE,
    "crosswalk": SurfaceKind.CROSSING,
    "walkway": SurfaceKind.SIDEWALK,
    "road_shoulder": SurfaceKind.SHOULDER,
}
"""Kinds of surfaces by the subtype of the lanelet."""


def read(spec: LaneletFile) -> Contents:
    """Return the contents of a map.

    Raises:
        InterchangeError: it cannot be read, or has no lanelets for vehicles.
        MissingExtraError: the package is not installed.
    """
    return packed(built(spec), NEAR, ALIKE)


def built(spec: LaneletFile) -> Network:
    """Return the network of a map, without a cache."""
    return _Builder(spec, read_lanelets(Path(spec.path), spec.origin)).build()


@frozen
class Strip:
    """A lanelet with bounds of equal numbers of points."""

    lanelet: Lanelet
    left: Floats
    """(n, 3) [m]"""
    right: Floats
    """(n, 3) [m]"""

    @property
    def polygon(self) -> Any:
        return outline(self.left[:, :2], self.right[:, :2])

    @property
    def width(self) -> float:
        """Return the mean width, by the length along the bounds [m]."""
        across = np.hypot(*(self.left - self.right)[:, :2].T)
        along = np.hypot(*np.diff(0.5 * (self.left + self.right)[:, :2], axis=0).T)
        return float(np.average(0.5 * (across[1:] + across[:-1]), weights=np.maximum(along, 1e-9)))

    def cut(self, spacing: float) -> tuple[Floats, Floats]:
        """Return both bounds with further points, so that none are farther apart than `spacing` [m]."""
        longest = max(float(np.hypot(*np.diff(each[:, :2], axis=0).T).max()) for each in (self.left, self.right))
        shares: Floats = np.arange(len(self.left), dtype=np.float64)
        count = max(1, math.ceil(longest / spacing))
        places: Floats = np.linspace(0.0, float(shares[-1]), (len(shares) - 1) * count + 1)
        return interpolated(places, shares, self.left), interpolated(places, shares, self.right)


def strip_of(lanelet: Lanelet) -> Strip:
    """Return a lanelet with the points of each bound on the other one, too, at the same share of its length."""
    left, right = _shares(lanelet.left), _shares(lanelet.right)
    places: Floats = np.unique(np.concatenate([left, right]))
    places = places[np.concatenate([[True], np.diff(places) > SHORT])]
    return Strip(lanelet, interpolated(places, left, lanelet.left), interpolated(places, right, lanelet.right))


def _shares(line: Floats) -> Floats:
    along = lengths_along(line)
    return along / along[-1]


def components(items: Iterable[int], pairs: Iterable[tuple[int, int]]) -> list[list[int]]:
    """Return the sets of items that pairs connect, each sorted, in the order of their least items."""
    root = {item: item for item in items}

    def find(item: int) -> int:
        while root[item] != item:
            root[item] = item = root[root[item]]
        return item

    for one, other in pairs:
        low, high = sorted((find(one), find(other)))
        root[high] = low
    found: dict[int, list[int]] = defaultdict(list)
    for item in sorted(root):
        found[find(item)].append(item)
    return [found[least] for least in sorted(found)]


class _Builder:
    """The network under construction."""

    def __init__(self, spec: LaneletFile, content: LaneletMap) -> None:
        self.content, self.file = content, spec.file
        self.strips = {each.id: strip_of(each) for each in content.lanelets}
        self.lanelets = {each.id: each for each in content.lanelets if each.subtype in DRIVABLE}
        self.polygons = {each: strip.polygon for each, strip in self.strips.items()}
        self.left_hand = self.keeps_left()
        self.opposite = dict(self.opposites(1 if self.left_hand else 0))
        self.network = Network(spec, self.left_hand, PathBook(NEAR, ALIKE))
        self.network.remarks = content.notes
        self.network.unread = _listed(content.unread or {})
        self.crossing = dict(self.overlaps())
        self.junctions = self.clusters()
        self.inside = {each: number for number, found in enumerate(self.junctions) for each in found}

    # -- what belongs together ---------------------------------------------------------------------------------------

    def keeps_left(self) -> bool:
        """Return whether more lanelets have oncoming traffic on their right than on their left; no map states it."""
        order = list(self.lanelets)
        tree, votes = shapely.STRtree([self.polygons[each] for each in order]), 0
        lines = {each: self.strips[each].left[:, :2] for each in order}
        ways = {each: (line[-1] - line[0]) / max(math.dist(line[-1], line[0]), SHORT) for each, line in lines.items()}
        for each in order:
            strip = self.strips[each]
            left, right = (side[len(side) // 2, :2] for side in (strip.left, strip.right))
            across = (left - right) / max(math.dist(left, right), SHORT)
            for away in np.arange(1.0, SEEN, 1.0).tolist():
                places = (left + away * across, right - away * across)
                there = [tree.query(shapely.Point(place), "intersects").tolist() for place in places]
                sides = [any(float(ways[each] @ ways[order[other]]) < AGAINST for other in found) for found in there]
                votes += int(sides[1]) - int(sides[0])
                if any(sides):
                    break
        return votes > 0

    def opposites(self, side: int) -> Iterator[tuple[int, int]]:
        """Yield lanelets with their opposite neighbours, which share the bound on a side: 0 left, 1 right."""
        users: dict[int, list[int]] = defaultdict(list)
        for each in self.lanelets.values():
            users[each.bounds[side]].append(each.id)
        for here in users.values():
            for one in here:
                lines = {each: (self.lanelets[each].left, self.lanelets[each].right)[side] for each in here}
                ways = {each: line[-1, :2] - line[0, :2] for each, line in lines.items()}
                if (other := next((each for each in here if float(ways[one] @ ways[each]) < 0.0), None)) is not None:
                    yield one, other

    def overlaps(self) -> Iterator[tuple[int, tuple[int, ...]]]:
        """Yield the lanelets that overlap each lanelet, as the routing graph says, by more than their bounds' noise."""
        for each in self.lanelets.values():
            polygon = self.polygons[each.id]
            others = [other for other in each.conflicting if polygon.intersection(self.polygons[other]).area >= OVERLAP]
            yield each.id, tuple(others)

    def clusters(self) -> list[list[int]]:
        """Return the connecting lanelets of each intersection."""
        before = {after for each in self.lanelets.values() for after in each.following}
        inside = {
            each.id
            for each in self.lanelets.values()
            if (each.turn or self.crossing[each.id]) and each.following and each.id in before
        }
        pairs = [
            (each, other)
            for each in inside
            for other in (*self.crossing[each], *self.lanelets[each].following)
            if other in inside
        ]
        return components(inside, pairs)

    def roads(self) -> dict[int, str]:
        """Return the name of the road of each lanelet; lanelets inside an intersection are roads of their own kind."""
        pairs: list[tuple[int, int]] = []
        for each in self.lanelets.values():
            beside = [*each.beside, self.opposite.get(each.id)]
            pairs += [
                (each.id, other)
                for other in beside
                if other is not None and (each.id in self.inside) == (other in self.inside)
            ]
        return {lane: f"road{found[0]}" for found in components(self.lanelets, pairs) for lane in found}

    def ordered(self, road: Sequence[int]) -> tuple[list[int], list[int]]:
        """Return the lanelets of a road in its direction, and against it, each from the kerb to the middle."""
        forward, waiting = {road[0]: True}, [road[0]]
        while waiting:
            here = waiting.pop()
            found = [(other, forward[here]) for other in self.lanelets[here].beside if other is not None]
            if here in self.opposite:
                found.append((self.opposite[here], not forward[here]))
            for other, way in found:
                if other in road and other not in forward:
                    forward[other] = way
                    waiting.append(other)
        groups = ([each for each in road if forward.get(each, True) is way] for way in (True, False))
        along, against = (sorted(group, key=self.from_the_kerb) for group in groups)
        return along, against

    def from_the_kerb(self, lanelet: int) -> int:
        """Return the number of neighbours between a lanelet and its kerb."""
        count, here, seen = 0, lanelet, {lanelet}
        while (here := self.lanelets[here].beside[0 if self.left_hand else 1]) is not None and here not in seen:
            count += 1
            seen.add(here)
        return count

    # -- the network -------------------------------------------------------------------------------------------------

    def build(self) -> Network:
        network = self.network
        try:
            surface, kerbs = union([self.polygons[each] for each in self.lanelets])
            areas = [union([self.polygons[each] for each in found])[0] for found in self.junctions]
        except NoSurface:
            what = "the surface of its lanelets cannot be computed"
            raise InterchangeError(what, "correct bounds that cross one another", self.file) from None
        assert network.regions.add(surface) == ROAD_REGION
        regions = [network.regions.add(area) for area in areas]
        order = self.in_order()
        self.index = {each: index for index, each in enumerate(order)}
        ways = self.ways()
        self.add_lanes(order, [way for found in ways for way in found])
        add_roads(network)
        names = [f"junction{found[0]}" for found in self.junctions]
        add_intersections(network, [Junction(*each) for each in zip(names, regions, ways, strict=True)])
        network.signs = tuple(self.lights())
        add_surfaces(network, self.surfaces())
        self.add_heights()
        network.drawn = Lines(kerbs, *self.lines())
        link_lanes(network, self.successors(), self.beside())
        if self.content.priorities:
            network.links.gives_way = [tuple(self.gives_way(index)) for index in range(len(network.maneuvers))]
        return network

    def in_order(self) -> list[int]:
        """Return the lanelets of all roads, from the kerb to the middle, then those inside intersections."""
        self.road_names = self.roads()
        self.forward: dict[int, bool] = {}
        self.numbers: dict[int, int] = {}
        by_road: dict[str, list[int]] = defaultdict(list)
        for each in self.lanelets:
            by_road[self.road_names[each]].append(each)
        order: list[int] = []
        for road in by_road.values():
            for way, group in zip((True, False), self.ordered(road), strict=True):
                self.forward |= dict.fromkeys(group, way)
                self.numbers |= {each: number for number, each in enumerate(group, start=1)}
                order += group
        return sorted(order, key=lambda each: each in self.inside)

    def ways(self) -> list[list[Way]]:
        """Return the ways through each intersection."""
        before: dict[int, list[int]] = defaultdict(list)
        for each in self.lanelets.values():
            for after in each.following:
                before[after].append(each.id)
        return [
            [
                Way(self.index[start], self.index[each], self.index[end])
                for each in found
                for start in before[each]
                for end in self.lanelets[each].following
            ]
            for found in self.junctions
        ]

    def add_lanes(self, order: Sequence[int], ways: Sequence[Way]) -> None:
        network, starts, ends = self.network, {way.start for way in ways}, {way.end for way in ways}
        headings = headings_of_ends(each.centre for each in self.lanelets.values())
        lanes = list[Lane]()
        for index, each in enumerate(order):
            role = role_of(index, connects=each in self.inside, starts=starts, ends=ends)
            lanes.append(self.lane(index, each, role, headings))
        network.lanes = tuple(lanes)
        network.bounds = {
            index: (self.strips[each].left[:, :2], self.strips[each].right[:, :2]) for index, each in enumerate(order)
        }
        limits = {index: self.lanelets[each].speed_limit for index, each in enumerate(order)}
        network.speed_limits = {index: limit for index, limit in limits.items() if limit is not None}

    def lane(self, index: int, each: int, role: Any, headings: Ends) -> Lane:
        path = self.network.paths.add(centre_line(self.lanelets[each].centre, headings))
        region = self.network.regions.add(shape_of_polygon(self.polygons[each]))
        place = self.road_names[each], self.numbers[each], self.forward[each]
        return Lane(self.network, index, f"lanelet{each}", role, self.strips[each].width, path, region, *place)

    def successors(self) -> dict[int, tuple[int, ...]]:
        return {
            self.index[each.id]: tuple(self.index[after] for after in each.following) for each in self.lanelets.values()
        }

    def beside(self) -> dict[int, tuple[int | None, int | None]]:
        """Return the neighbours of all lanes: those of the routing graph, else an opposite one."""
        found: dict[int, tuple[int | None, int | None]] = {}
        inner = 1 if self.left_hand else 0
        for each in self.lanelets.values():
            both = list(each.beside)
            both[inner] = self.opposite.get(each.id) if both[inner] is None else both[inner]
            left, right = (None if here is None else self.index[here] for here in both)
            found[self.index[each.id]] = left, right
        return found

    def gives_way(self, number: int) -> Iterator[int]:
        """Yield the conflicting maneuvers with priority over one: all but those that yield to it."""
        mine = self.maneuver_lanelets(number)
        for other in self.network.links.conflicts[number]:
            theirs = self.maneuver_lanelets(other)
            if not any(mine & rule.first and theirs & rule.yields for rule in self.content.priorities):
                yield other

    def maneuver_lanelets(self, number: int) -> set[int]:
        """Return the ids of the lanelets before and inside the intersection."""
        here = self.network.maneuvers[number]
        return {int(lane.name.removeprefix("lanelet")) for lane in (here.start_lane, here.connecting_lane)}

    def lights(self) -> Iterator[RoadSign]:
        for each in self.content.lights:
            lanes = tuple(self.index[lane] for lane in each.lanelets if lane in self.index)
            road = self.network.lanes[lanes[0]].road if lanes else ""
            yield RoadSign(str(each.id), "traffic light", "", TRAFFIC_LIGHT, "", None, road, each.x, each.y, lanes)

    # -- beside the lanes --------------------------------------------------------------------------------------------

    def surfaces(self) -> Iterator[SurfaceRow]:
        """Yield all surfaces, crossings last."""
        kinds = {each.id: KINDS[each.subtype] for each in self.content.lanelets if each.subtype in KINDS}
        for each in sorted(kinds, key=lambda each: kinds[each] is SurfaceKind.CROSSING):
            kind, polygon, strip = kinds[each], self.polygons[each], self.strips[each]
            if polygon.area < OVERLAP:
                continue
            centre = strip.lanelet.centre
            line = centre_line(centre, headings_of_ends([centre]))
            at = self.intersection_near(polygon) if kind is SurfaceKind.CROSSING else None
            about = (shape_of_polygon(polygon), strip.width, self.road_beside(each), True, at)
            yield SurfaceRow(kind, f"{kind.value}{each}", line, *about)

    def road_beside(self, surface: int) -> str:
        """Return the name of the road whose lanelet shares a bound with a surface, or that it crosses; "" of none."""
        bounds = set(self.strips[surface].lanelet.bounds)
        shared = [each for each in self.lanelets if bounds & set(self.lanelets[each].bounds)]
        if not shared:
            polygon = self.polygons[surface]
            shared = [each for each in self.lanelets if polygon.intersection(self.polygons[each]).area >= OVERLAP]
        return self.road_names[shared[0]] if shared else ""

    def intersection_near(self, polygon: Any) -> int | None:
        """Return the intersection that a crossing overlaps most; None without one."""
        common = [
            (sum(polygon.intersection(self.polygons[each]).area for each in found), -number)
            for number, found in enumerate(self.junctions)
        ]
        most, number = max(common, default=(0.0, 0))
        return -number if most >= OVERLAP else None

    # -- heights, and lines to draw ----------------------------------------------------------------------------------

    def add_heights(self) -> None:
        """Add the heights of all lanes if roads pass over one another."""
        heights = np.concatenate([self.strips[each].left[:, 2] for each in self.lanelets])
        if float(np.ptp(heights)) <= FLAT:
            return
        tiles = [tile for each in self.lanelets for tile in self.tiles(each)]
        places: dict[tuple[str, str], tuple[float, float, float]] = {}
        for (below, above), place in overlapping(tiles).items():
            if place[0] >= LEVEL:
                places.setdefault((self.road_names[int(below)], self.road_names[int(above)]), place)
        self.network.levels = tuple(sentences(places))
        if places:
            rows = [row for each, index in self.index.items() for row in self.heights(each, index)]
            self.network.heights = np.array(rows).reshape(-1, len(HeightColumn))

    def tiles(self, lanelet: int) -> Iterator[Tile]:
        left, right = self.strips[lanelet].cut(SPACING)
        along = 0.0
        for (a, d), (b, c) in pairwise(zip(left, right, strict=True)):
            along += math.dist(a[:2], b[:2])
            height = float(np.mean([a[2], b[2], c[2], d[2]]))
            yield Tile(str(lanelet), along, height, tuple((float(x), float(y)) for x, y, _ in (a, b, c, d)))

    def heights(self, lanelet: int, index: int) -> Iterator[tuple[float, ...]]:
        left, right = self.strips[lanelet].cut(STATIONS)
        return rising((0.5 * (left + right)).tolist(), index)

    def lines(self) -> tuple[tuple[Floats, ...], tuple[Floats, ...]]:
        """Return the lines between opposite lanes, and those between lanes of one direction, outside intersections."""
        middle, between = list[Floats](), list[Floats]()
        for each in self.lanelets.values():
            if each.id in self.inside:
                continue
            strip, inner = self.strips[each.id], 1 if self.left_hand else 0
            line = (strip.left, strip.right)[inner][:, :2]
            if each.beside[inner] is not None:
                between.append(line)
            elif each.id in self.opposite and self.forward[each.id]:
                middle.append(line)
        return tuple(middle), tuple(between)


def _listed(unread: Mapping[str, int]) -> str:
    """Return the content that is not read, with its number, as one text."""
    return ", ".join(f"{count} {kind}" for kind, count in unread.items())
