"""What to draw of a network, as polylines: pure data for terminals, figures and pages."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from engine.frozen import frozen
from engine.road.lights import lit_arms
from engine.road.network import Lane, LaneRole, Lines, Network
from engine.tables import Bools, Floats

KEPT = 0.05
"""A lane whose width changes by less is drawn as one that keeps it [m]."""
Shown = Callable[[int, float], str]
"""What the lights of a phase show at a time [s]: green, yellow or red; nothing where that is not known."""


@frozen
class SignalLine:
    """A line at which traffic waits for a light."""

    line: Floats
    """(2, 2) [m]"""
    phase: int
    shown: Shown | None

    def colour(self, time: float) -> str:
        """green, yellow or red; empty where that is not known."""
        return "" if self.shown is None else self.shown(self.phase, time)


@frozen
class Outline:
    """Polylines, each (n, 2) [m]."""

    kerbs: tuple[Floats, ...]
    """Edges of the road: corner fillets, both sides of every arm, kerbs opposite a T's stem."""
    middle_lines: tuple[Floats, ...]
    """Between the two directions of a road."""
    lane_lines: tuple[Floats, ...]
    """Between lanes of one direction."""
    stop_lines: tuple[Floats, ...]
    """Across the incoming lanes of each arm; of a file, those whose ways others meet."""
    areas: tuple[Floats, ...]
    """Closed rings, whose first point is not repeated: intersections; of a file, lanes that do not keep their width."""
    center_lines: tuple[Floats, ...]
    """Of all lanes, connecting ones too, in the order of `network.lanes`."""
    widths: tuple[float, ...] = ()
    """Of the lanes that have these centre lines; 0 where the lane is one of the areas [m]."""
    reach: float = 0.0
    """Of the widest road, from its middle line to its kerb [m]."""
    buildings: tuple[Floats, ...] = ()
    """Closed rings, as of areas."""
    signals: tuple[SignalLine, ...] = ()
    """Across each lane whose traffic waits for a light."""


def outline(network: Network, shown: Shown | None = None) -> Outline:
    """Everything that a drawing of the road may show; `shown` is what its lights show, where there is a plan of them.

    The lights of a file are there without a plan, too; all others are the plan's.
    """
    drawn = _of_grid(network) if network.drawn is None else _of_lines(network, network.drawn)
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
            *_far_kerbs(network),
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
        buildings=tuple(_block(*row) for row in network.buildings.tolist()),
    )


def _of_lines(network: Network, drawn: Lines) -> Outline:
    """Of a network whose lanes do not keep their width."""
    changing = {
        lane: np.vstack([left, right[::-1]])
        for lane, (left, right) in network.bounds.items()
        if np.ptp(np.hypot(*(left - right).T)) > KEPT
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
    )


def _is_met(lane: Lane) -> bool:
    """Whether other ways meet those that lead on from it: at most junctions of a motorway none do."""
    return any(each.conflicting_maneuvers for each in lane.maneuvers)


def near(road: Outline, points: Floats, reach: float) -> Outline:
    """What of a drawing lies within `reach` of the rectangle around some points (n, 2) [m]: of a town, where one is."""
    low, high = points.min(axis=0) - reach, points.max(axis=0) + reach
    kept = [i for i, line in enumerate(road.center_lines) if _passing(line, low, high).any()]
    return replace(
        road,
        kerbs=_parts(road.kerbs, low, high),
        middle_lines=_parts(road.middle_lines, low, high),
        lane_lines=_parts(road.lane_lines, low, high),
        stop_lines=_parts(road.stop_lines, low, high),
        areas=tuple(ring for ring in road.areas if _passing(ring, low, high).any()),
        center_lines=tuple(road.center_lines[i] for i in kept),
        widths=tuple(road.widths[i] for i in kept),
        signals=tuple(each for each in road.signals if _passing(each.line, low, high).any()),
    )


def _passing(line: Floats, low: Floats, high: Floats) -> Bools:
    """Per segment, whether the rectangle around it meets another one."""
    least, most = np.minimum(line[:-1], line[1:]), np.maximum(line[:-1], line[1:])
    return np.all((most >= low) & (least <= high), axis=1)


def _parts(lines: Sequence[Floats], low: Floats, high: Floats) -> tuple[Floats, ...]:
    """The stretches of lines that pass there."""
    parts: list[Floats] = []
    for line in lines:
        edges = np.flatnonzero(np.diff(np.concatenate([[False], _passing(line, low, high), [False]])))
        parts += [line[first : last + 1] for first, last in edges.reshape(-1, 2).tolist()]
    return tuple(parts)


def _far_kerbs(network: Network) -> tuple[Floats, ...]:
    """Those of one-way roads beside their fastest lanes."""
    return tuple(_border(road.forward.lanes[-1], kerb=False) for road in network.roads if not road.backward.lanes)


def _block(x: float, y: float, _heading: float, length: float, width: float) -> Floats:
    """(4, 2) corners, anticlockwise."""
    return np.array([x, y]) + 0.5 * np.array([length, width]) * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])


def _border(lane: Lane, *, kerb: bool) -> Floats:
    """(n, 2) border of a road lane, in its direction: the one nearer to the kerb, or the one nearer to the middle."""
    side = 1.0 if kerb == lane.network.left_hand else -1.0
    return np.array([_beside(lane, s, side) for s in lane.network.paths.stations(lane.path)])


def _beside(lane: Lane, s: float, side: float) -> tuple[float, float]:
    """Point on the left (side 1) or right (side -1) border."""
    pose = lane.network.paths.pose(lane.path, s)
    shift = side * 0.5 * lane.width
    return pose.x - shift * float(np.sin(pose.heading)), pose.y + shift * float(np.cos(pose.heading))


def _stop_line(lane: Lane) -> Floats:
    return np.array([_beside(lane, lane.length, -1.0), _beside(lane, lane.length, 1.0)])
