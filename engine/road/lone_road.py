"""The maker of lone roads: straight, curved all along, or straight with one bend; a country road, or one carriageway of
a motorway.

The middle of the road, at half its length, is at the origin, where the forward lanes run east. On a one-way road the
middle line is the border of the fastest lane, so that a lane has the same place as on a two-way road.
"""

import math
from collections.abc import Iterator

from engine.maps import LoneRoad
from engine.road.junction import CHORD_TOLERANCE
from engine.road.network import Lane, LaneGroup, LaneRole, Links, Network, Road
from engine.road.paths import PathBook, Primitive
from engine.road.regions import Shape, strip
from engine.road.specification import LENGTHS, MAX_LANES, RoadError, wrong_choice, wrong_length
from engine.tables import ROAD_REGION

NAME = "road"
SHORTEST, LONGEST = 10.0, 100_000.0
"""[m]"""
FLATTEST = 1e6
"""Largest radius of a bend [m]."""
INNER_RADIUS = 5.0
"""Least radius of the inner kerb of a bend [m]."""
MOST_CURVED = math.radians(270.0)
"""Largest turn of a road that is curved along its whole length, so that its ends do not meet [rad]."""
MOST_BENT = math.pi
"""Largest turn of a road with straight ends, so that it does not cross itself [rad]."""


def wrong_lone_road_numbers(spec: LoneRoad) -> Iterator[RoadError]:
    """Yield the errors of single numbers that no road allows."""
    yield from wrong_choice("lanes", spec.lanes, range(1, MAX_LANES + 1))
    yield from wrong_length("lane_width", spec.lane_width, *LENGTHS["lane_width"])
    yield from wrong_length("length", spec.length, SHORTEST, LONGEST)
    if spec.curve is not None and not abs(spec.curve) <= FLATTEST:
        message = f"`curve` is {spec.curve:g} m, a radius of more than {FLATTEST:g} m"
        yield RoadError(message, "curve", "leave it out for a straight road")
    if spec.bend is not None and not 0.0 < spec.bend <= MOST_BENT:
        message = f"`bend` is {math.degrees(spec.bend):g} deg, but must lie between 0 deg and 180 deg"
        yield RoadError(message, "bend", "write a negative `curve` for a bend to the right")


def wrong_lone_road(spec: LoneRoad) -> Iterator[RoadError]:
    """Yield the errors of numbers that are valid alone but not together."""
    if spec.curve is None:
        if spec.bend is not None:
            yield RoadError("`bend` says how far the road turns, but not how sharply", "bend", "add `curve=200 m`")
        return
    radius, half = abs(spec.curve), spec.lanes * spec.lane_width
    least = 1.5 * half + INNER_RADIUS
    if radius < least:
        yield RoadError(
            f"`curve` is {spec.curve:g} m, but the bend of a road of {2.0 * half:g} m needs a radius of {least:g} m",
            "curve",
            f"write `curve={math.copysign(math.ceil(least), spec.curve):g} m` or more, or fewer lanes",
        )
    elif spec.bend is None and spec.length > MOST_CURVED * radius:
        yield RoadError(
            f"a road of {spec.length:g} m that curves all along with a radius of {radius:g} m meets itself",
            "length",
            f"write `length={math.floor(MOST_CURVED * radius)} m` or less, or say by `bend` how far it turns",
        )
    elif spec.bend is not None and spec.bend * radius > spec.length:
        yield RoadError(
            f"a bend of {math.degrees(spec.bend):g} deg with a radius of {radius:g} m is {spec.bend * radius:.1f} m "
            f"long, longer than the road of {spec.length:g} m",
            "length",
            f"write `length={math.ceil(spec.bend * radius)} m` or more, or a smaller `bend`",
        )


def lone_road(spec: LoneRoad) -> Network:
    """Return the network of a valid specification."""
    network = Network(spec, spec.left_hand)
    middle = middle_line(spec)
    assert network.regions.add(_surface(spec, middle)) == ROAD_REGION
    directions = (True,) if spec.one_way else (True, False)
    network.lanes = tuple(
        _lane(network, index, number, middle, forward=forward)
        for index, (forward, number) in enumerate((f, n) for f in directions for n in range(1, int(spec.lanes) + 1))
    )
    forward, backward = (
        LaneGroup(network, NAME, way, tuple(lane for lane in network.lanes if lane.forward is way))
        for way in (True, False)
    )
    network.roads = (Road(network, NAME, forward, backward, middle),)
    none: list[tuple[int, ...]] = [() for _ in network.lanes]
    network.links = Links(none, [None for _ in none], none, none, [lane.path for lane in network.lanes])
    return network


def middle_line(spec: LoneRoad) -> tuple[Primitive, ...]:
    """Return the line between the two directions."""
    if spec.curve is None:
        return (Primitive(-0.5 * spec.length, 0.0, 0.0, 0.0, spec.length),)
    bent = spec.length if spec.bend is None else spec.bend * abs(spec.curve)
    straight, arcs = 0.5 * (spec.length - bent), math.ceil(bent / (math.pi * abs(spec.curve)) - 1e-9)
    lengths = [(0.0, straight), *[(1.0 / spec.curve, bent / arcs)] * arcs, (0.0, straight)]
    turn, x, y = -0.5 * bent / spec.curve, 0.0, 0.0
    chain: list[Primitive] = []
    for curvature, length in lengths:
        if length > 0.0:
            chain.append(Primitive(x, y, turn, curvature, length))
            x, y, turn = chain[-1].pose(length)
    centre = _pose(chain, 0.5 * spec.length)
    return tuple(each.moved(-centre[0], -centre[1]) for each in chain)


def _pose(chain: list[Primitive], s: float) -> tuple[float, float]:
    paths = PathBook()
    pose = paths.pose(paths.add(chain), s)
    return pose.x, pose.y


def _lane(network: Network, index: int, number: int, middle: tuple[Primitive, ...], *, forward: bool) -> Lane:
    spec = network.spec
    assert isinstance(spec, LoneRoad)
    right = (int(spec.lanes) - number + 0.5) * spec.lane_width * (1.0 if forward else -1.0)
    line = [each.beside(right if spec.left_hand else -right) for each in middle]
    path = network.paths.add(line if forward else [each.turned() for each in reversed(line)])
    region = network.regions.add(strip(network.paths, path, spec.lane_width, CHORD_TOLERANCE))
    name = f"{'forward' if forward else 'backward'}.{number}"
    return Lane(network, index, name, LaneRole.THROUGH, spec.lane_width, path, region, NAME, number, forward)


def _surface(spec: LoneRoad, middle: tuple[Primitive, ...]) -> Shape:
    """Return the area between the kerbs."""
    half, paths = int(spec.lanes) * spec.lane_width, PathBook()
    if not spec.one_way:
        return strip(paths, paths.add(middle), 2.0 * half, CHORD_TOLERANCE)
    to_left = 0.5 * half if spec.left_hand else -0.5 * half
    return strip(paths, paths.add([each.beside(to_left) for each in middle]), half, CHORD_TOLERANCE)
