"""The drawing of a network as polylines: pure data for terminals, figures and pages."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np

from engine.frozen import frozen
from engine.maps import Street
from engine.road.lights import lit_arms
from engine.road.network import Lane, LaneRole, Lines, Network, Surface, SurfaceKind
from engine.road.paths import PathBook
from engine.road.regions import Shape
from engine.road.specification import setback
from engine.road.streets import layers
from engine.tables import Bools, Floats
from engine.vocabulary import LEVEL, HeightColumn

DECK_SHADOW, DECK_EDGE = 1.6, 0.5
"""Excess of a bridge's shadow and of its edges over its width, in pictures [m]."""
NEARBY = 4.0
"""Side of a cell [m]: lanes in the same or the next cell are compared in height."""
CONSTANT_WIDTH = 0.05
"""Change of width below which a lane is drawn with a constant width [m]."""
Paint = TypeVar("Paint")
Shown = Callable[[int, float], str]
"""(phase, time [s]) -> colour of the lights: green, yellow or red; "" if unknown."""


@frozen
class SignalLine:
    """A line at which traffic waits for a light."""

    line: Floats
    """(2, 2) [m]"""
    phase: int
    shown: Shown | None

    def colour(self, time: float) -> str:
        """Return green, yellow or red; "" if unknown."""
        return "" if self.shown is None else self.shown(self.phase, time)


@frozen
class Outline:
    """Polylines, each (n, 2) [m]."""

    kerbs: tuple[Floats, ...]
    """Edges of the road: corner fillets, both sides of every arm, kerbs opposite a T's stem."""
    middle_lines: tuple[Floats, ...]
    """Lines between the two directions of a road."""
    lane_lines: tuple[Floats, ...]
    """Lines between lanes of one direction."""
    stop_lines: tuple[Floats, ...]
    """Lines across the incoming lanes of each arm; for a file, of lanes with conflicting ways."""
    areas: tuple[Floats, ...]
    """Closed rings without a repeated first point: intersections; for a file, lanes with variable widths."""
    center_lines: tuple[Floats, ...]
    """Centre lines of all lanes, connecting lanes included, in the order of `network.lanes`."""
    widths: tuple[float, ...] = ()
    """Widths of the lanes of these centre lines; 0 for a lane that is one of the areas [m]."""
    reach: float = 0.0
    """Distance from middle line to kerb of the widest road [m]."""
    buildings: tuple[Floats, ...] = ()
    """Closed rings, as of areas."""
    strips: tuple[tuple[SurfaceKind, Floats], ...] = ()
    """Closed rings of the strips beside the lanes, with their kinds."""
    stripes: tuple[Floats, ...] = ()
    """Closed rings of the painted stripes of crossings."""
    parked: tuple[Floats, ...] = ()
    """Closed rings of parked cars."""
    signals: tuple[SignalLine, ...] = ()
    """Lines across each lane with a traffic light."""
    decks: tuple[tuple[Floats, float], ...] = ()
    """Centre lines of the parts of lanes that pass over others, and their widths [m]: drawn above all other roads."""

    def deck_coats(self, shadow: Paint, edge: Paint, asphalt: Paint) -> Iterator[tuple[Floats, float, Paint]]:
        """Yield the lines of all bridges, their widths [m] and their paints, in the order in which they are painted."""
        for paint, excess in ((shadow, DECK_SHADOW), (edge, DECK_EDGE), (asphalt, 0.0)):
            for line, width in self.decks:
                yield line, width + excess, paint


def outline(network: Network, shown: Shown | None = None) -> Outline:
    """Return the complete drawing of a road; `shown` gives the states of its lights, if there is a plan.

    Lights of a file are drawn without a plan, too; all other lights are those of the plan.
    """
    drawn = _of_grid(network) if network.drawn is None else _of_lines(network, network.drawn)
    if has_street(network):
        drawn = _with_street(drawn, network)
    return replace(drawn, signals=tuple(_signals(network, shown)))


def _signals(network: Network, shown: Shown | None) -> Iterator[SignalLine]:
    lit = lit_arms(network)
    for intersection in network.intersections if lit or shown else ():
        for arm, leg in enumerate(intersection.legs):
            if lit is None or (intersection.id, arm) in lit:
                yield from (SignalLine(_stop_line(lane), leg.phase, shown) for lane in leg.incoming_lanes)


def _of_grid(network: Network) -> Outline:
    road_lanes = [lane for lane in network.lanes if lane.role is not LaneRole.CONNECTING]
    return Outline(
        kerbs=(
            *network.kerbs,
            *(_border(lane, kerb=True) for lane in road_lanes if lane.number == 1),
            *(_border(road.forward.lanes[-1], kerb=False) for road in network.roads if not road.backward.lanes),
        ),
        middle_lines=tuple(
            _border(road.backward.lanes[-1], kerb=False) for road in network.roads if road.backward.lanes
        ),
        lane_lines=tuple(_border(lane, kerb=True) for lane in road_lanes if lane.number > 1),
        stop_lines=tuple(_stop_line(lane) for lane in road_lanes if lane.ends_at_line),
        areas=tuple(network.regions.shape(each.region).edges[:, :2] for each in network.intersections),
        center_lines=tuple(network.paths.points(lane.path) for lane in network.lanes),
        widths=tuple(lane.width for lane in network.lanes),
        reach=max(sum(lane.width for lane in group.lanes) for road in network.roads for group in road.groups),
        buildings=tuple(_block(*row) for row in network.buildings[: len(network.buildings) - network.parked].tolist()),
    )


# -- strips beside the lanes, and crossings ----------------------------------------------------------------------------

STRIPE = 0.5
"""Width of a painted stripe of a crossing, and of the gap between two [m]: Vienna Convention, European rules on signs
(1973), M-signs of crossings: 0.4 to 0.6 m."""


def has_street(network: Network) -> bool:
    """Return True if there may be anything beside the lanes; a plain road has kerbs only, which its lanes draw."""
    return bool(layers(network.spec)) if isinstance(network.spec, Street) else bool(network.surfaces)


def _with_street(drawn: Outline, network: Network) -> Outline:
    """Return a drawing with the strips beside the lanes, crossings and parked cars."""
    spec, beside, kerbs = network.spec, 0.0, drawn.kerbs
    edges: tuple[Floats, ...] = ()
    if isinstance(spec, Street):
        beside = setback(spec) + (spec.sidewalk or 0.0)
        if setback(spec) > 0.0:
            outer = (lane for lane in network.lanes if lane.role is not LaneRole.CONNECTING and lane.number == 1)
            curbs = (
                each for each in network.surfaces if each.kind is SurfaceKind.CURB and each.parent in network.roads
            )
            far = (_border(road.forward.lanes[-1], kerb=False) for road in network.roads if not road.backward.lanes)
            edges = tuple(_border(lane, kerb=True) for lane in outer)
            kerbs = (*network.kerbs, *(_polyline(each) for each in curbs if each.intersection_id is None), *far)
    crossings = [each for each in network.surfaces if each.kind is SurfaceKind.CROSSING]
    return replace(
        drawn,
        kerbs=kerbs,
        lane_lines=(*drawn.lane_lines, *edges),
        reach=drawn.reach + beside,
        strips=tuple(
            (each.kind, ring)
            for each in network.surfaces
            if each.kind not in (SurfaceKind.CURB, SurfaceKind.CROSSING)
            for ring in rings_of(each.shape)
        ),
        stripes=tuple(stripe for each in crossings for stripe in _stripes(each)),
        parked=tuple(_block(*row) for row in network.buildings[len(network.buildings) - network.parked :].tolist()),
    )


def _polyline(surface: Surface) -> Floats:
    paths = PathBook()
    return paths.points(paths.add(surface.line))


def rings_of(shape: Shape) -> Iterator[Floats]:
    """Yield the closed outlines of a region, each (n, 2): edges that follow each other belong together."""
    starts, ends = shape.edges[:, :2], shape.edges[:, 2:]
    cuts = np.flatnonzero(np.any(ends[:-1] != starts[1:], axis=1)) + 1
    yield from np.split(starts, cuts)


def _stripes(crossing: Surface) -> Iterator[Floats]:
    """Yield the painted stripes of a crossing, along the road."""
    start, _ = crossing.ends_at
    count = max(1, int((crossing.length / STRIPE + 1.0) // 2.0))
    first = 0.5 * (crossing.length - (2 * count - 1) * STRIPE)
    for number in range(count):
        ahead = first + (2 * number + 0.5) * STRIPE
        x, y = start.x + ahead * np.cos(start.heading), start.y + ahead * np.sin(start.heading)
        yield _block(x, y, start.heading, STRIPE, crossing.width)


def _of_lines(network: Network, drawn: Lines) -> Outline:
    """Return the drawing of a network with lanes of variable widths."""
    changing = {
        lane: np.vstack([left, right[::-1]])
        for lane, (left, right) in network.bounds.items()
        if np.ptp(np.hypot(*(left - right).T)) > CONSTANT_WIDTH
    }
    return Outline(
        kerbs=drawn.kerbs,
        middle_lines=drawn.middle,
        lane_lines=drawn.between,
        stop_lines=tuple(_stop_line(lane) for lane in network.lanes if lane.ends_at_line and _is_met(lane)),
        areas=tuple(changing.values()),
        center_lines=tuple(network.paths.points(lane.path) for lane in network.lanes),
        widths=tuple(0.0 if lane.id in changing else lane.width for lane in network.lanes),
        reach=max(sum(lane.width for lane in group.lanes) for road in network.roads for group in road.groups),
        buildings=(),
        decks=tuple(_decks(network)),
    )


def _decks(network: Network) -> Iterator[tuple[Floats, float]]:
    """Yield the parts of lanes that are a level or more above another lane nearby."""
    rows = network.heights
    if not len(rows):
        return
    places = np.floor(rows[:, :2] / NEARBY).astype(np.int64)
    places -= places.min(axis=0) - 1
    lowest = np.full(places.max(axis=0) + 2, np.inf)
    np.minimum.at(lowest, (places[:, 0], places[:, 1]), rows[:, HeightColumn.HEIGHT])
    shifts = [(across, along) for across in (-1, 0, 1) for along in (-1, 0, 1)]
    around = np.min([lowest[places[:, 0] + across, places[:, 1] + along] for across, along in shifts], axis=0)
    above = rows[:, HeightColumn.HEIGHT] - around >= LEVEL
    lane = rows[:, HeightColumn.LANE].astype(np.int64)
    numbers: list[int] = np.unique(lane[above]).tolist()
    for number in numbers:
        own = np.flatnonzero(lane == number)
        edges = np.flatnonzero(np.diff(np.concatenate([[False], above[own], [False]])))
        for first, last in edges.reshape(-1, 2).tolist():
            part = own[max(first - 1, 0) : last + 1]
            if len(part) > 1:
                yield rows[part, :2], network.lanes[number].width


def _is_met(lane: Lane) -> bool:
    """Return True if other ways conflict with its maneuvers; at most junctions of a motorway none do."""
    return any(each.conflicting_maneuvers for each in lane.maneuvers)


def near(road: Outline, points: Floats, reach: float) -> Outline:
    """Return the part of a drawing within `reach` [m] of the rectangle around some points (n, 2) [m]."""
    low, high = points.min(axis=0) - reach, points.max(axis=0) + reach
    visible = [i for i, line in enumerate(road.center_lines) if _passing(line, low, high).any()]
    return replace(
        road,
        kerbs=_parts(road.kerbs, low, high),
        middle_lines=_parts(road.middle_lines, low, high),
        lane_lines=_parts(road.lane_lines, low, high),
        stop_lines=_parts(road.stop_lines, low, high),
        areas=tuple(ring for ring in road.areas if _passing(ring, low, high).any()),
        center_lines=tuple(road.center_lines[i] for i in visible),
        widths=tuple(road.widths[i] for i in visible),
        strips=tuple(each for each in road.strips if _passing(each[1], low, high).any()),
        stripes=tuple(ring for ring in road.stripes if _passing(ring, low, high).any()),
        signals=tuple(each for each in road.signals if _passing(each.line, low, high).any()),
        decks=tuple(each for each in road.decks if _passing(each[0], low, high).any()),
    )


def _passing(line: Floats, low: Floats, high: Floats) -> Bools:
    """Return per segment True if the rectangle around it meets the given rectangle."""
    least, most = np.minimum(line[:-1], line[1:]), np.maximum(line[:-1], line[1:])
    return np.all((most >= low) & (least <= high), axis=1)


def _parts(lines: Sequence[Floats], low: Floats, high: Floats) -> tuple[Floats, ...]:
    """Return the stretches of lines that pass there."""
    parts: list[Floats] = []
    for line in lines:
        edges = np.flatnonzero(np.diff(np.concatenate([[False], _passing(line, low, high), [False]])))
        parts += [line[first : last + 1] for first, last in edges.reshape(-1, 2).tolist()]
    return tuple(parts)


def _block(x: float, y: float, heading: float, length: float, width: float) -> Floats:
    """Return (4, 2) corners, anticlockwise."""
    corners = 0.5 * np.array([length, width]) * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    cos, sin = np.cos(heading), np.sin(heading)
    return np.array([x, y]) + corners @ np.array([[cos, sin], [-sin, cos]])


def _border(lane: Lane, *, kerb: bool) -> Floats:
    """Return (n, 2) border of a road lane, in its direction: towards the kerb, or towards the middle."""
    side = 1.0 if kerb == lane.network.left_hand else -1.0
    return np.array([_beside(lane, s, side) for s in lane.network.paths.stations(lane.path)])


def _beside(lane: Lane, s: float, side: float) -> tuple[float, float]:
    """Return a point on the left (side 1) or right (side -1) border."""
    pose = lane.network.paths.pose(lane.path, s)
    shift = side * 0.5 * lane.width
    return pose.x - shift * float(np.sin(pose.heading)), pose.y + shift * float(np.cos(pose.heading))


def _stop_line(lane: Lane) -> Floats:
    return np.array([_beside(lane, lane.length, -1.0), _beside(lane, lane.length, 1.0)])
