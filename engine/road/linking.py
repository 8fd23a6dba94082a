"""How the elements of a network refer to one another: maneuvers of lanes, neighbours, default routes, conflicts.

And to whom a maneuver gives way: per lane, between which arc lengths others are in its way.
"""

import math

import numpy as np

from engine.frozen import frozen
from engine.road.junction import Junction, Turn
from engine.road.network import Lane, LaneRole, Links, Maneuver, Network
from engine.road.paths import PathBook
from engine.tables import Floats
from engine.vocabulary import ManeuverType


def link(network: Network, junction: Junction) -> Links:
    """All references, once lanes, maneuvers and intersections are there."""
    lanes = network.lanes
    links = Links(
        maneuvers=[() for _ in lanes],
        intersection=[None for _ in lanes],
        successors=[() for _ in lanes],
        predecessors=[() for _ in lanes],
        default_route=[lane.path for lane in lanes],
        conflicts=_conflicts(network, junction),
    )
    for maneuver in network.maneuvers:
        _link_maneuver(links, maneuver)
    for intersection in network.intersections:
        for lane in intersection.incoming_lanes:
            links.intersection[lane.id] = intersection.id
    for lane in lanes:
        links.default_route[lane.id] = _default_route(network, links, lane, junction.near_turn)
    return links


def _link_maneuver(links: Links, maneuver: Maneuver) -> None:
    start, connecting, end = maneuver.start, maneuver.connecting, maneuver.end
    links.maneuvers[start] += (maneuver.id,)
    links.successors[start] += (connecting,)
    links.predecessors[connecting] = (start,)
    links.successors[connecting] = (end,)
    links.predecessors[end] += (connecting,)
    links.intersection[connecting] = maneuver.intersection_id


def _default_route(network: Network, links: Links, lane: Lane, near_turn: ManeuverType) -> int:
    if lane.role is LaneRole.CONNECTING:
        return network.paths.join([lane.path, network.lanes[links.successors[lane.id][0]].path])
    ranking = {ManeuverType.STRAIGHT: 0, near_turn: 1}
    choices = [network.maneuvers[i] for i in links.maneuvers[lane.id]]
    if not choices:
        return lane.path
    chosen = min(choices, key=lambda maneuver: ranking.get(maneuver.type, 2))
    return network.paths.join([network.lanes[i].path for i in (lane.id, chosen.connecting, chosen.end)])


# -- which maneuvers conflict


def _conflicts(network: Network, junction: Junction) -> list[tuple[int, ...]]:
    """Per maneuver its conflicting ones. All junctions have the same shape, so pairs are found once and copied."""
    pattern = meeting_turns(junction.turns)
    count = len(pattern)
    return [tuple(site.id * count + other for other in others) for site in network.intersections for others in pattern]


def meeting_turns(turns: tuple[Turn, ...]) -> list[tuple[int, ...]]:
    """For each turn the indices of those from other lanes whose centre line crosses or joins its own."""
    paths = PathBook()
    lines = [paths.points(paths.add(turn.primitives), 0.001) for turn in turns]

    def meet(i: int, j: int) -> bool:
        same_start = (turns[i].start, turns[i].start_lane) == (turns[j].start, turns[j].start_lane)
        same_end = (turns[i].end, turns[i].end_lane) == (turns[j].end, turns[j].end_lane)
        return not same_start and (same_end or polylines_cross(lines[i], lines[j]))

    return [tuple(j for j in range(len(turns)) if meet(min(i, j), max(i, j))) for i in range(len(turns))]


def polylines_cross(first: Floats, second: Floats) -> bool:
    """Whether any segment of one crosses any of the other."""
    a, b = first[:-1, None], first[1:, None]
    c, d = second[None, :-1], second[None, 1:]
    apart = _side(a, b, c) * _side(a, b, d) > 0.0
    return bool(np.any(~apart & (_side(c, d, a) * _side(c, d, b) <= 0.0)))


def _side(a: Floats, b: Floats, point: Floats) -> Floats:
    """Positive where the point lies left of the line from a to b."""
    ab, ap = b - a, point - a
    return ab[..., 0] * ap[..., 1] - ab[..., 1] * ap[..., 0]


# -- who gives way to whom ---------------------------------------------------------------------------------------------

CLEARANCE = 2.5
"""Centre lines nearer than this cannot be driven on at once: a car's width and what drivers keep beside it [m]."""
PARTING = 1.0
"""Paths out of one lane are the same to others until they lie so far apart [m]."""
SPACING = 0.5
"""Between the points at which centre lines are compared [m]."""


@frozen
class Window:
    """Part of a lane, or of what follows it, on which another is in the way."""

    enter: float
    """Arc length on the lane at which the part begins; beyond the lane's end for one that leads there [m]."""
    leave: float
    """… and at which it ends."""


NOWHERE = Window(math.inf, -math.inf)
"""Of a lane from which no other comes into the way."""


def windows(maneuver: Maneuver) -> tuple[Window, ...]:
    """One for each lane of the network: where others conflict with a maneuver, whatever they do next.

    No driver sees which way another will go, so all that come from a lane with a conflicting maneuver count until their
    paths part.
    """
    found = [NOWHERE] * len(maneuver.intersection.network.lanes)
    conflicts = maneuver.conflicting_maneuvers
    for start in dict.fromkeys(other.start_lane for other in conflicts):
        mine = {other: _overlap(maneuver, other) for other in conflicts if other.start_lane is start}
        first = min(window.enter for window in mine.values())
        found[start.id] = Window(start.length + first, math.inf)
        for other in start.maneuvers:
            leave = mine[other].leave if other in mine else _parting(other, list(mine))
            found[other.connecting] = Window(mine[other].enter if other in mine else first, leave)
    return tuple(found)


def _points(paths: PathBook, lane: Lane) -> tuple[Floats, Floats]:
    """Arc lengths along a lane, and (n, 2) places there."""
    stations = np.linspace(0.0, lane.length, max(2, math.ceil(lane.length / SPACING) + 1))
    return stations, np.array([paths.pose(lane.path, s)[:2] for s in stations])


def _overlap(maneuver: Maneuver, other: Maneuver) -> Window:
    paths = other.intersection.network.paths
    stations, places = _points(paths, other.connecting_lane)
    near = stations[paths.feet(maneuver.connecting_lane.path, *places.T).distance < CLEARANCE]
    return Window(float(near.min()), float(near.max())) if len(near) else NOWHERE


def _parting(other: Maneuver, conflicting: list[Maneuver]) -> float:
    """How far `other` runs along with one of the conflicting maneuvers from the same lane [m]."""
    paths = other.intersection.network.paths
    stations, places = _points(paths, other.connecting_lane)
    distances = [paths.feet(each.connecting_lane.path, *places.T).distance for each in conflicting]
    together = stations[np.min(distances, axis=0) < PARTING]
    return float(together.max()) if len(together) else 0.0
