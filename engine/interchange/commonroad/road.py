"""The road of a scenario as XML: lanelets, intersections and traffic lights, and how CommonRoad writes numbers and
points.

A lanelet has two bounds with equal numbers of points. Points that several bounds share are equal to the last bit: along
a neighbour, and from a lane to its successors. Lanes of a map file have the borders of that file, and are neighbours if
they share a whole border.
"""

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from engine.interchange.recording import ARMS, SignalTimes
from engine.interchange.xml_writing import Element, child, decimal
from engine.maps import Street
from engine.road.junction import CHORD_TOLERANCE
from engine.road.lights import lit_arms
from engine.road.network import Arm, Intersection, Lane, LaneRole, Network, Surface, SurfaceKind
from engine.road.paths import PathBook
from engine.road.regions import borders
from engine.road.streets import layers
from engine.tables import Floats
from engine.vocabulary import ManeuverType

# -- lanelets ----------------------------------------------------------------------------------------------------------

SAME = 1e-6
"""Largest distance between points of bounds that become one point [m]; as in `PathBook`."""


ONE_BORDER = 0.1
"""Largest distance between the ends of two lanes' borders in a file that count as one border [m]."""


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
    """Return all lanes, connecting lanes included, in the order of `network.lanes`."""
    rows, shared = _rows(network), _SharedPoints()
    if network.bounds:
        beside_left, beside_right = (_beside_in_file(network, side) for side in (0, 1))
    else:
        inwards, outwards = _neighbours(network, rows)
        beside_left, beside_right = (outwards, inwards) if network.left_hand else (inwards, outwards)
    chords = {lane.id: _chords(row) for row in rows for lane in row}

    def lanelet(lane: Lane) -> Lanelet:
        if lane.id in network.bounds:
            left, right = (np.array([shared.point(x, y) for x, y in bound]) for bound in network.bounds[lane.id])
        else:
            left, right = (_bound(lane, side, chords[lane.id], shared) for side in (1.0, -1.0))
        return Lanelet(lane, left, right, beside_left.get(lane.id), beside_right.get(lane.id))

    return tuple(map(lanelet, network.lanes))


# -- neighbours


def _rows(network: Network) -> list[tuple[Lane, ...]]:
    """Return rows of parallel lanes of one direction, from the kerb to the middle; each lane is in one row."""
    rows = [group.lanes for road in network.roads for group in road.groups]
    turns: dict[tuple[int, str, str, int], list[Lane]] = defaultdict(list)
    for maneuver in network.maneuvers:
        start, end = maneuver.start_lane, maneuver.end_lane
        turns[maneuver.intersection_id, start.road, end.road, end.number - start.number].append(
            maneuver.connecting_lane
        )
    return rows + [tuple(sorted(row, key=lambda lane: lane.number)) for row in turns.values()]


def _neighbours(network: Network, rows: list[tuple[Lane, ...]]) -> tuple[dict[int, Beside], dict[int, Beside]]:
    """Return per lane its neighbour towards the middle of the road, and its neighbour towards the kerb."""
    inwards: dict[int, Beside] = {}
    outwards: dict[int, Beside] = {}
    for row in rows:
        for outer, inner in pairwise(row):
            inwards[outer.id], outwards[inner.id] = Beside(inner.id, True), Beside(outer.id, True)
    for forward, backward in (road.groups for road in network.roads if len(road.groups) == 2):
        coming, leaving = forward.lanes[-1].id, backward.lanes[-1].id
        inwards[coming], inwards[leaving] = Beside(leaving, False), Beside(coming, False)
    return inwards, outwards


def _beside_in_file(network: Network, side: int) -> dict[int, Beside]:
    """Return per lane of a file its neighbour on the left (side 0) or right (1), if both share the whole border."""
    found: dict[int, Beside] = {}
    for lane, others in (network.links.beside or {}).items():
        other = others[side]
        if other is None:
            continue
        same = network.lanes[lane].forward is network.lanes[other].forward
        mine = network.bounds[lane][side]
        theirs = network.bounds[other][1 - side] if same else network.bounds[other][side][::-1]
        if max(np.hypot(*(mine[end] - theirs[end])) for end in (0, -1)) < ONE_BORDER:
            found[lane] = Beside(other, same)
    return found


# -- bounds


def _chords(row: tuple[Lane, ...]) -> int:
    """Return the number of equal chords for each lane of a row, enough for the widest of its arcs."""
    return max(len(lane.network.paths.stations(lane.path, CHORD_TOLERANCE)) - 1 for lane in row)


def _bound(lane: Lane, side: float, chords: int, shared: "_SharedPoints") -> Floats:
    """Return the left (side 1) or right (side -1) bound."""
    paths, shift = lane.network.paths, side * 0.5 * lane.width
    poses = [paths.pose(lane.path, lane.length * (i / chords)) for i in range(chords + 1)]
    return np.array(
        [shared.point(p.x - shift * np.sin(p.heading), p.y + shift * np.cos(p.heading)) for p in poses]
    )  # fmt: skip


class _SharedPoints:
    """Points of all bounds: a point near an earlier point, up to rounding, is replaced by it."""

    def __init__(self) -> None:
        self._known: dict[tuple[int, int], tuple[float, float]] = {}

    def point(self, x: float, y: float) -> tuple[float, float]:
        column, row = round(x / SAME), round(y / SAME)
        for near in ((column + i, row + j) for i in (0, -1, 1) for j in (0, -1, 1)):
            if near in self._known:
                return self._known[near]
        self._known[column, row] = float(x), float(y)
        return self._known[column, row]


# -- numbers, points and states ----------------------------------------------------------------------------------------


def add_text(parent: Element, tag: str, text: str) -> None:
    child(parent, tag).text = text


def add_point(parent: Element, x: float, y: float) -> None:
    point = child(parent, "point")
    add_text(point, "x", decimal(x))
    add_text(point, "y", decimal(y))


def add_exact(parent: Element, values: Mapping[str, float]) -> None:
    """Add a child with an exact value for each name."""
    for tag, value in values.items():
        add_text(child(parent, tag), "exact", decimal(value))


def add_interval(parent: Element, tag: str, start: float, end: float) -> None:
    interval = child(parent, tag)
    add_text(interval, "intervalStart", decimal(start))
    add_text(interval, "intervalEnd", decimal(end))


def add_rectangle(parent: Element, length: float, width: float) -> Element:
    rectangle = child(parent, "rectangle")
    add_text(rectangle, "length", decimal(length))
    add_text(rectangle, "width", decimal(width))
    return rectangle


# -- the road as XML ---------------------------------------------------------------------------------------------------

LANELET_TYPES = {LaneRole.CONNECTING: "intersection", LaneRole.THROUGH: "country"}
SUCCESSORS = {
    "successorsRight": ManeuverType.RIGHT_TURN,
    "successorsStraight": ManeuverType.STRAIGHT,
    "successorsLeft": ManeuverType.LEFT_TURN,
}


@dataclass(frozen=True)
class Ids:
    """Unique numbers of a file's elements: lanelets, then intersections, lights, actors, and the ego's problem."""

    network: Network

    def lanelet(self, lane: int) -> int:
        return 1 + lane

    def intersection(self, site: int) -> int:
        return 1 + len(self.network.lanes) + site

    def incoming(self, site: int, arm: int) -> int:
        return self.intersection(len(self.network.intersections)) + self.network.arms * site + arm

    def light(self, site: int, arm: int) -> int:
        return self.incoming(len(self.network.intersections), 0) + self.network.arms * site + arm

    def strip(self, number: int) -> int:
        """Return the number of a strip beside the lanes, or of a crossing, by its place in `strips`."""
        return self.light(len(self.network.intersections), 0) + number

    def actor(self, index: int) -> int:
        """Return the number of an actor; the ego, actor 0, is the planning problem."""
        return self.strip(len(strips(self.network))) + index


def arms_of(intersection: Intersection) -> Mapping[int, Arm]:
    """Return the arms with incoming lanes, by number: clockwise, on a grid from the north; a T has no arm of one
    number.
    """
    legs = intersection.legs
    numbers = [ARMS.index(leg.name) if leg.name in ARMS else place for place, leg in enumerate(legs)]
    return {number: leg for number, leg in zip(numbers, legs, strict=True) if leg.incoming_lanes}


def add_road(root: Element, ids: Ids, signals: SignalTimes | None, step: float) -> None:
    """Add all lanelets, then all lights of a fixed plan, then all intersections, in the order of the schema."""
    network = ids.network
    lights = {} if signals is None else _lights(ids)
    for lanelet in lanelets(network):
        _add_lanelet(root, ids, lanelet, lights.get(lanelet.lane.id))
    for number, strip in enumerate(strips(network)):
        _add_strip(root, ids.strip(number), strip)
    if signals is not None:
        for intersection in network.intersections:
            for arm, leg in arms_of(intersection).items():
                if not lights.keys().isdisjoint(lane.id for lane in leg.incoming_lanes):
                    _add_light(root, ids.light(intersection.id, arm), leg, cycle(signals, leg.phase, step))
    for intersection in network.intersections:
        _add_intersection(root, ids, intersection)


# -- lanelets


def _add_lanelet(root: Element, ids: Ids, lanelet: Lanelet, light: int | None) -> None:
    lane = lanelet.lane
    element = child(root, "lanelet", id=ids.lanelet(lane.id))
    left_marking, right_marking = _markings(lanelet)
    _add_bound(element, "leftBound", lanelet.left, left_marking)
    _add_bound(element, "rightBound", lanelet.right, right_marking)
    _add_references(element, "predecessor", (ids.lanelet(other.id) for other in lane.predecessors))
    _add_references(element, "successor", (ids.lanelet(other.id) for other in lane.successors))
    _add_neighbour(element, "adjacentLeft", ids, lanelet.beside_left)
    _add_neighbour(element, "adjacentRight", ids, lanelet.beside_right)
    if lane.ends_at_line and not lane.network.bounds:  # not every junction of a file has lines
        _add_stop_line(element, lanelet, light)
    add_text(element, "laneletType", LANELET_TYPES.get(lane.role, "urban"))
    add_text(element, "userOneWay", "vehicle")
    if light is not None:
        child(element, "trafficLightRef", ref=light)


STRIP_TYPES = {
    SurfaceKind.SIDEWALK: ("sidewalk", "userBidirectional", "pedestrian"),
    SurfaceKind.SHOULDER: ("shoulder", "userOneWay", "vehicle"),
    SurfaceKind.PARKING: ("shoulder", "userOneWay", "vehicle"),
    SurfaceKind.BIKE_LANE: ("bicycleLane", "userOneWay", "bicycle"),
    SurfaceKind.CROSSING: ("crosswalk", "userBidirectional", "pedestrian"),
}
"""Types and users of the lanelets of strips; CommonRoad has none for parking rows."""


def strips(network: Network) -> tuple[Surface, ...]:
    """Return the strips and crossings that become lanelets: those of roads with a maker, which have one width."""
    if not isinstance(network.spec, Street) or not layers(network.spec):
        return ()
    return tuple(each for each in network.surfaces if each.kind in STRIP_TYPES)


def _add_strip(root: Element, number: int, strip: Surface) -> None:
    kind, users, user = STRIP_TYPES[strip.kind]
    element, paths = child(root, "lanelet", id=number), PathBook()
    left, right = borders(paths, paths.add(strip.line), strip.width, CHORD_TOLERANCE)
    _add_bound(element, "leftBound", left, "unknown")
    _add_bound(element, "rightBound", right, "unknown")
    add_text(element, "laneletType", kind)
    add_text(element, users, user)


def _add_bound(lanelet: Element, tag: str, points: Floats, marking: str) -> None:
    bound = child(lanelet, tag)
    for x, y in points.tolist():
        add_point(bound, x, y)
    add_text(bound, "lineMarking", marking)


def _markings(lanelet: Lanelet) -> tuple[str, str]:
    """Return the markings of the left and the right bound; within an intersection there are none."""
    if lanelet.lane.role is LaneRole.CONNECTING:
        return "no_marking", "no_marking"
    return _marking(lanelet.beside_left), _marking(lanelet.beside_right)


def _marking(beside: Beside | None) -> str:
    return "curb" if beside is None else "dashed" if beside.same_direction else "solid"


def _add_references(parent: Element, tag: str, ids: Iterable[int]) -> None:
    for each in ids:
        child(parent, tag, ref=each)


def _add_neighbour(lanelet: Element, tag: str, ids: Ids, beside: Beside | None) -> None:
    if beside is not None:
        direction = "same" if beside.same_direction else "opposite"
        child(lanelet, tag, ref=ids.lanelet(beside.lane), drivingDir=direction)


def _add_stop_line(parent: Element, lanelet: Lanelet, light: int | None) -> None:
    line = child(parent, "stopLine")
    for bound in (lanelet.left, lanelet.right):
        add_point(line, *bound[-1].tolist())
    add_text(line, "lineMarking", "solid")
    if light is not None:
        child(line, "trafficLightRef", ref=light)


# -- intersections


def _add_intersection(root: Element, ids: Ids, intersection: Intersection) -> None:
    element = child(root, "intersection", id=ids.intersection(intersection.id))
    arms = arms_of(intersection)
    for arm, leg in arms.items():
        incoming = child(element, "incoming", id=ids.incoming(intersection.id, arm))
        _add_references(incoming, "incomingLanelet", (ids.lanelet(lane.id) for lane in leg.incoming_lanes))
        maneuvers = [maneuver for lane in leg.incoming_lanes for maneuver in lane.maneuvers]
        for tag, kind in SUCCESSORS.items():
            ways = (ids.lanelet(maneuver.connecting) for maneuver in maneuvers if maneuver.type is kind)
            _add_references(incoming, tag, ways)
        # Despite its name, commonroad-io reads `isLeftOf` as the incoming road on the left of this incoming road.
        on_the_left = (arm + 1) % max(len(ARMS), len(intersection.legs))
        if on_the_left in arms:
            child(incoming, "isLeftOf", ref=ids.incoming(intersection.id, on_the_left))


# -- traffic lights


def _lights(ids: Ids) -> dict[int, int]:
    """Return the light at the end of each incoming lane that has a light."""
    lit = lit_arms(ids.network)
    return {
        lane.id: ids.light(intersection.id, arm)
        for intersection in ids.network.intersections
        for arm, leg in arms_of(intersection).items()
        if lit is None or (intersection.id, intersection.legs.index(leg)) in lit
        for lane in leg.incoming_lanes
    }


@dataclass(frozen=True)
class Cycle:
    """Cyclic plan of a light in whole steps."""

    colours: tuple[tuple[str, int], ...]
    """Each with its duration, 1 or more."""
    offset: int
    """Step at which the first colour begins."""
    is_exact: bool
    """True if all changes are on whole steps."""


def cycle(signals: SignalTimes, phase: int, step: float) -> Cycle:
    """Return the plan of the lights of one phase, with each change at the nearest step."""
    begin = signals.begins(phase)
    times = [0.0, signals.green, signals.green + signals.yellow, signals.cycle]
    exact = [time / step for time in times]
    whole = [round(time) for time in exact]
    spans = [after - before for before, after in pairwise(whole)]
    colours = [(colour, span) for colour, span in zip(("green", "yellow", "red"), spans, strict=True) if span > 0]
    moved = max(abs(a - b) for a, b in zip([*exact, begin / step], [*whole, round(begin / step)], strict=True))
    return Cycle(tuple(colours), round(begin / step) % max(whole[-1], 1), moved < 1e-6)


def _add_light(root: Element, number: int, leg: Arm, shown: Cycle) -> None:
    light = child(root, "trafficLight", id=number)
    plan = child(light, "cycle")
    for colour, duration in shown.colours:
        element = child(plan, "cycleElement")
        add_text(element, "duration", str(duration))
        add_text(element, "color", colour)
    if shown.offset > 0:
        add_text(plan, "timeOffset", str(shown.offset))
    add_point(child(light, "position"), *_kerb_side(leg))
    add_text(light, "direction", "all")
    add_text(light, "active", "true")


def _kerb_side(leg: Arm) -> tuple[float, float]:
    """Return the end of an arm's stop line at the kerb [m]."""
    lane = leg.incoming_lanes[0]
    pose = lane.network.paths.pose(lane.path, lane.length)
    shift = (0.5 if lane.network.left_hand else -0.5) * lane.width
    return pose.x - shift * math.sin(pose.heading), pose.y + shift * math.cos(pose.heading)
