"""How the elements of a network refer to one another: maneuvers of lanes, neighbours, default routes, conflicts."""

import numpy as np

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


# -- who meets whom


def _conflicts(network: Network, junction: Junction) -> list[tuple[int, ...]]:
    """Per maneuver its conflicting ones. All junctions are alike, so pairs are found once and copied."""
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
