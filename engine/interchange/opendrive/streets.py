"""Strips beside the lanes, corners and crossings of a network in OpenDRIVE's terms: lanes, roads and objects."""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from engine.interchange.opendrive.places import Beside, Carriageway, RoadMap, beside_path
from engine.maps import RoadSpec
from engine.road import Maneuver, Primitive
from engine.road.network import LANE_TYPES, Surface, SurfaceKind
from engine.road.outline import rings_of
from engine.road.paths import PathBook
from engine.road.specification import crossing_depth
from engine.road.streets import extended

TYPES = {kind: types[0] for kind, types in LANE_TYPES.items() if kind is not SurfaceKind.CURB}
"""Types of the lanes of strips beside the lanes of traffic."""


def strips(roads: RoadMap, road: Carriageway) -> Iterator[tuple[int, Surface]]:
    """Yield the strips of a road with the numbers of their lanes, from the outer lanes outwards."""
    along = [each for each in roads.network.surfaces if each.road == road.name and each.kind in TYPES]
    for forward, lanes in ((True, road.forward), (False, road.backward)):
        side = roads.side if forward else -roads.side
        own = (each for each in along if each.forward is forward)
        yield from ((side * number, strip) for number, strip in enumerate(own, len(lanes) + 1))


class Crossed(NamedTuple):
    """A crossing beside the reference line of a road."""

    place: Beside
    name: str
    corners: tuple[tuple[float, float], ...]
    """Corners of its outline in its own frame: along the way of people on foot, and to the left [m]."""


def _crossed(surface: Surface, line: Sequence[Primitive]) -> Crossed:
    paths = PathBook()
    start, end = surface.ends_at
    x, y = 0.5 * (start.x + end.x), 0.5 * (start.y + end.y)
    place = beside_path(paths, paths.add(line), x, y, start.heading)
    cos, sin = math.cos(start.heading), math.sin(start.heading)
    ring = next(rings_of(surface.shape)) - (x, y)
    corners = tuple((u * cos + v * sin, v * cos - u * sin) for u, v in ring.tolist())
    number = len(surface.network.buildings) + surface.id
    return Crossed(Beside(number, *place, surface.length, surface.width), surface.name, corners)


def crossings_over(roads: RoadMap, road: Carriageway) -> list[Crossed]:
    """Return the crossings over a road outside the junctions."""
    over = (each for each in roads.network.surfaces if each.kind is SurfaceKind.CROSSING and each.road == road.name)
    return [_crossed(each, road.road.middle) for each in over]


def crossings_before(roads: RoadMap, maneuver: Maneuver) -> list[Crossed]:
    """Return the crossing over the arm of a maneuver's start, if the maneuver is the first one of its arm."""
    junction = maneuver.intersection
    arm = next(i for i, leg in enumerate(junction.legs) if maneuver.start_lane in leg.incoming_lanes)
    if maneuver is not next(each for lane in junction.legs[arm].incoming_lanes for each in lane.maneuvers):
        return []
    line = roads.network.paths.primitives(maneuver.connecting_lane.path)
    own = (each for each in roads.network.surfaces if (each.intersection_id, each.arm) == (junction.id, arm))
    return [_crossed(each, line) for each in own]


def corners(roads: RoadMap) -> Iterator[tuple[Surface, list[Primitive]]]:
    """Yield the sidewalks around corners with the kerbs along them, from stop line to stop line."""
    network = roads.network
    depth = crossing_depth(network.spec) if isinstance(network.spec, RoadSpec) else 0.0
    for walk in network.surfaces:
        if walk.kind is SurfaceKind.SIDEWALK and walk.intersection_id is not None:
            kerb = [each.beside(-0.5 * roads.side * walk.width) for each in walk.line]
            yield walk, extended(kerb, depth, depth)
