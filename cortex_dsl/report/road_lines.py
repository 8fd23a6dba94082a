"""The lines of an OpenDRIVE road as drawings show them."""

from collections.abc import Iterator

import numpy as np

from engine.interchange.opendrive.read import OdrNetwork, OdrRoad
from engine.road.outline import Outline
from engine.tables import Floats

APART = 2.0
"""Between two points of a line [m]."""
MOST_POINTS = 5_000
"""Of all roads together; larger maps are drawn coarser."""
THROUGH = "-1"
"""The junction of a road that is none's."""


def road_outline(road: OdrNetwork | None) -> Outline:
    """Kerbs and middle lines of all roads between junctions; nothing where there is no road."""
    roads = [] if road is None else [each for each in road.roads.values() if each.junction == THROUGH]
    apart = max(APART, sum(each.length for each in roads) / MOST_POINTS)
    lines = [_lines(each, np.linspace(0.0, each.length, max(2, round(each.length / apart) + 1))) for each in roads]
    return Outline(
        kerbs=tuple(kerb for kerbs, _ in lines for kerb in kerbs),
        middle_lines=tuple(middle for _, middle in lines),
        lane_lines=(),
        stop_lines=(),
        intersections=(),
        center_lines=(),
    )


def _lines(road: OdrRoad, distances: Floats) -> tuple[tuple[Floats, Floats], Floats]:
    """The two edges of a road, and its reference line."""
    edges = np.array([_edges(road, s) for s in distances.tolist()]).reshape(-1, 3, 2)
    return (edges[:, 0], edges[:, 1]), edges[:, 2]


def _edges(road: OdrRoad, s: float) -> list[tuple[float, float]]:
    """Right edge, left edge, reference line."""
    shifts = list(_shifts(road, s))
    poses = [road.reference(s).moved(0.0, shift) for shift in (min(shifts), max(shifts), 0.0)]
    return [(pose.x, pose.y) for pose in poses]


def _shifts(road: OdrRoad, s: float) -> Iterator[float]:
    """How far left of the reference line each lane that is driven on begins and ends [m]."""
    yield 0.0
    section, center = road.section(s), road.center(0, s)
    for lane, row in section.lanes.items():
        if lane and row.type == "driving":
            yield from (center + edge for edge in section.edges(lane, s))
