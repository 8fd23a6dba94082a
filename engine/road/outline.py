"""What to draw of a network, as polylines: pure data for terminals, figures and pages."""

import numpy as np

from engine.frozen import frozen
from engine.road.grid import Grid
from engine.road.network import Lane, LaneRole, Network
from engine.tables import Floats


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
    """Across the incoming lanes of each arm."""
    intersections: tuple[Floats, ...]
    """Closed rings: the first point is not repeated."""
    center_lines: tuple[Floats, ...]
    """Of all lanes, connecting ones too, in the order of `network.lanes`."""
    buildings: tuple[Floats, ...] = ()
    """Closed rings, as of intersections."""


def outline(network: Network) -> Outline:
    """Everything that a drawing of the road may show."""
    grid = Grid(network.spec)
    road_lanes = [lane for lane in network.lanes if lane.role is not LaneRole.CONNECTING]
    return Outline(
        kerbs=(*_corner_kerbs(grid), *(_border(lane, kerb=True) for lane in road_lanes if lane.number == 1)),
        middle_lines=_middle_lines(road_lanes, network.spec.lanes),
        lane_lines=tuple(_border(lane, kerb=True) for lane in road_lanes if lane.number > 1),
        stop_lines=tuple(_stop_line(lane) for lane in road_lanes if lane.maneuvers),
        intersections=tuple(grid.junction.outline + np.array([site.x, site.y]) for site in grid.sites),
        center_lines=tuple(network.paths.points(lane.path) for lane in network.lanes),
        buildings=tuple(_block(*row) for row in network.buildings.tolist()),
    )


def _block(x: float, y: float, _heading: float, length: float, width: float) -> Floats:
    """(4, 2) corners, anticlockwise."""
    return np.array([x, y]) + 0.5 * np.array([length, width]) * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])


def _corner_kerbs(grid: Grid) -> list[Floats]:
    return [kerb + np.array([site.x, site.y]) for site in grid.sites for kerb in grid.junction.corner_kerbs]


def _border(lane: Lane, *, kerb: bool) -> Floats:
    """(2, 2) border of a road lane, in its direction: the one nearer to the kerb, or the one nearer to the middle."""
    left_hand = lane.network.spec.left_hand
    side = 1.0 if kerb == left_hand else -1.0
    return np.array([_beside(lane, s, side) for s in (0.0, lane.length)])


def _beside(lane: Lane, s: float, side: float) -> tuple[float, float]:
    """Point on the left (side 1) or right (side -1) border."""
    pose = lane.network.paths.pose(lane.path, s)
    shift = side * 0.5 * lane.width
    return pose.x - shift * float(np.sin(pose.heading)), pose.y + shift * float(np.cos(pose.heading))


def _middle_lines(road_lanes: list[Lane], lanes: int) -> tuple[Floats, ...]:
    """One a road: both directions would draw it twice."""
    lines = {lane.road: _border(lane, kerb=False) for lane in road_lanes if lane.number == lanes}
    return tuple(lines.values())


def _stop_line(lane: Lane) -> Floats:
    return np.array([_beside(lane, lane.length, -1.0), _beside(lane, lane.length, 1.0)])
