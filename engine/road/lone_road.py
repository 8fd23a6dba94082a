"""The maker of lone roads: straight, curved all along, or straight with one bend; a country road, or one carriageway of
a motorway.

The middle of the road, at half its length, is at the origin, where the forward lanes run east. On a one-way road the
middle line is the border of the fastest lane, so that a lane has the same place as on a two-way road.
"""

import math
from collections.abc import Iterator
from itertools import pairwise

from engine.maps import LoneRoad
from engine.road.junction import CHORD_TOLERANCE
from engine.road.network import Lane, LaneGroup, LaneRole, Links, Network, Road, Surface, SurfaceKind
from engine.road.paths import PathBook, Primitive
from engine.road.regions import Shape, between, strip
from engine.road.specification import (
    LENGTHS,
    MAX_LANES,
    STREET_LENGTHS,
    RoadError,
    setback,
    wrong_choice,
    wrong_length,
    wrong_street_numbers,
    wrong_strips,
)
from engine.road.streets import CLEAR, StreetBuilder, lay_street, stretch
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
    yield from wrong_street_numbers(spec)


def wrong_lone_road(spec: LoneRoad) -> Iterator[RoadError]:
    """Yield the errors of numbers that are valid alone but not together."""
    yield from wrong_strips(spec)
    yield from _wrong_places(spec)
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
    elif radius < half + setback(spec) + (spec.sidewalk or 0.0) + INNER_RADIUS:
        yield from _too_wide_for_bend(spec, radius - half - INNER_RADIUS)
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


def _too_wide_for_bend(spec: LoneRoad, room: float) -> Iterator[RoadError]:
    """Yield the error of the widest strip beside the lanes of a bend that has `room` for all strips [m]."""
    widths = {name: getattr(spec, name) or 0.0 for name in ("parking", "sidewalk", "bike_lane", "shoulder")}
    widest = max(widths, key=lambda name: widths[name])
    fits = math.floor(10.0 * (room - sum(widths.values()) + widths[widest])) / 10.0
    low = STREET_LENGTHS[widest][0]
    radius = math.ceil(abs(spec.curve or 0.0) - room + sum(widths.values()))
    yield RoadError(
        f"`{widest}` is {widths[widest]:g} m, too wide for the inner side of a bend with `curve={spec.curve:g} m`",
        widest,
        (f"write `{widest}={fits:g} m` or less, or " if fits >= low else "leave it out, or write ")
        + f"`curve={math.copysign(radius, spec.curve or 1.0):g} m` or more",
    )


def _wrong_places(spec: LoneRoad) -> Iterator[RoadError]:
    """Yield the errors of crossings without a place, beyond the road, or over one another."""
    if isinstance(spec.crossings, bool):
        if spec.crossings:
            message = "on a road, `crossings` lists the places of the crossings"
            yield RoadError(message, "crossings", f"as in `crossings=[{0.5 * spec.length:g} m]`")
        return
    half, places = 0.5 * spec.crossing_width, sorted(spec.crossings)
    if spec.crossing_width > spec.length:
        message = f"`crossing_width` is {spec.crossing_width:g} m, longer than the road of {spec.length:g} m"
        yield RoadError(message, "crossing_width", f"write `crossing_width={spec.length:g} m` or less")
        return
    for place in places:
        if not half <= place <= spec.length - half:
            yield RoadError(
                f"a crossing at {place:g} m lies beyond the road, on which its middle can be from {half:g} m to "
                f"{spec.length - half:g} m",
                "crossings",
                f"write {half if place < half else spec.length - half:g} m",
            )
            return
    for one, other in pairwise(places):
        if other - one < spec.crossing_width:
            yield RoadError(
                f"the crossings at {one:g} m and {other:g} m overlap",
                "crossings",
                f"write {one + spec.crossing_width:g} m or more for the second, or a smaller `crossing_width`",
            )
            return


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
    lay_street(network, _surfaces)
    return network


def _surfaces(network: Network) -> tuple[Surface, ...]:
    """Return the strips beside the lanes of each direction, and the crossings."""
    street, spec = StreetBuilder(network), network.spec
    assert isinstance(spec, LoneRoad)
    middle = network.roads[0].middle
    road, length = network.roads[0], sum(each.length for each in middle)
    half, places = 0.5 * spec.crossing_width, () if isinstance(spec.crossings, bool) else sorted(spec.crossings)
    for group in road.groups:
        lane = group.lanes[0]
        along = [network.paths.project(lane.path, *_pose(list(middle), place)) for place in places]
        street.beside(lane, [(s - half - CLEAR, s + half + CLEAR) for s in along])
    if spec.one_way:
        _add_far_side(street, spec, road.forward.lanes[-1])
    walks = [each for each in street.surfaces if each.kind is SurfaceKind.SIDEWALK]
    kerb = spec.lanes * spec.lane_width + setback(spec)
    # Walked from the right of the road: in right-hand traffic from the kerb of the forward lanes.
    near, far = (kerb, 0.0 if spec.one_way else kerb), (walks[:1] + walks[-1:] if places else [])
    reach, ends = ((near[1], near[0]), far[::-1]) if spec.left_hand else (near, far)
    for number, place in enumerate(places, 1):
        part = stretch(middle, max(0.0, place - half), min(length, place + half))
        street.cross(f"{NAME}.crossing.{number}", part, reach, NAME, (ends[0].id, ends[1].id))
    return street.finish()


def _add_far_side(street: StreetBuilder, spec: LoneRoad, lane: Lane) -> None:
    """Add the kerb and the sidewalk on the side of the fastest lane of a one-way road."""
    border = [each.beside(-street.side * 0.5 * lane.width) for each in street.network.paths.primitives(lane.path)]
    if (width := spec.sidewalk) is not None:
        line, reach = street.shifted(border, -0.5 * width), -street.side * 0.5 * lane.width
        shape = between(street.edge(lane, reach), street.edge(lane, reach - street.side * width))
        street.add(SurfaceKind.SIDEWALK, "far.sidewalk", line, width, NAME, forward=False, shape=shape)
    street.add_curb("far", border, NAME, forward=False)


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
