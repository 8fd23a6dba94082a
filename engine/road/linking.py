"""References between the elements of a network: maneuvers of lanes, neighbours, default routes, conflicts.

Also the right of way: per lane, the range of arc lengths in which other actors conflict with a maneuver.
"""

import math
from collections import defaultdict
from collections.abc import Mapping
from functools import lru_cache
from heapq import heappop, heappush
from itertools import combinations, pairwise

import numpy as np

from engine.frozen import frozen
from engine.road.junction import Junction, Turn
from engine.road.network import Lane, LaneRole, Links, Maneuver, Network
from engine.road.paths import PathBook
from engine.tables import Floats
from engine.vocabulary import ManeuverType

Beside = Mapping[int, tuple[int | None, int | None]]
"""Left and right neighbour per lane."""
Successors = Mapping[int, tuple[int, ...]]
"""Lanes into which a lane continues without an intersection; drivers without a plan take the first."""


def link(network: Network, junction: Junction) -> Links:
    """Return all references of a network with lanes, maneuvers and intersections."""
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
    """Return the conflicting maneuvers per maneuver. All junctions have one shape, so pairs are computed once and
    copied.
    """
    pattern = meeting_turns(junction.turns)
    count = len(pattern)
    return [tuple(site.id * count + other for other in others) for site in network.intersections for others in pattern]


@lru_cache(maxsize=16)
def meeting_turns(turns: tuple[Turn, ...]) -> tuple[tuple[int, ...], ...]:
    """Return for each turn the indices of turns from other lanes whose centre line crosses or joins its own."""
    paths = PathBook()
    lines = [paths.points(paths.add(turn.primitives), 0.001) for turn in turns]

    def meet(i: int, j: int) -> bool:
        same_start = (turns[i].start, turns[i].start_lane) == (turns[j].start, turns[j].start_lane)
        same_end = (turns[i].end, turns[i].end_lane) == (turns[j].end, turns[j].end_lane)
        return not same_start and (same_end or polylines_cross(lines[i], lines[j]))

    return tuple(tuple(j for j in range(len(turns)) if meet(min(i, j), max(i, j))) for i in range(len(turns)))


# -- networks of any shape ---------------------------------------------------------------------------------------------

TURN_THRESHOLD = math.radians(20.0)
"""Angle below which a way through a junction leads straight on, as in Scenic."""
ROUTE = 1000.0
"""Length of the route of a driver without a plan [m]; it continues to the end of a lane."""


def maneuver(index: int, intersection: int, start: Lane, connecting: Lane, end: Lane) -> Maneuver:
    """Return the maneuver from lane to lane, named after them."""
    kind = maneuver_type(start, connecting, end)
    name = f"{start.name}-{end.name} {kind.name.lower()}"
    return Maneuver(connecting.network, index, name, kind, start.id, connecting.id, end.id, intersection)


def maneuver_type(start: Lane, connecting: Lane, end: Lane) -> ManeuverType:
    """Return a U-turn for the same road, else the type by the angle of the connecting lane, as in Scenic."""
    if start.road == end.road:
        return ManeuverType.U_TURN
    paths = connecting.network.paths
    first, last = paths.pose(connecting.path, 0.0), paths.pose(connecting.path, connecting.length)
    turn = math.remainder(last.heading - first.heading, math.tau)
    if abs(turn) < TURN_THRESHOLD:
        return ManeuverType.STRAIGHT
    return ManeuverType.LEFT_TURN if turn > 0.0 else ManeuverType.RIGHT_TURN


def link_by_ways(network: Network, successors: Successors, beside: Beside | None = None) -> float:
    """Link lanes by the maneuvers of a network, and by their successors without an intersection.

    Return the largest gap [m] between ends that no vehicle can cross.
    """
    none: list[tuple[int, ...]] = [() for _ in network.lanes]
    links = network.links = Links(
        maneuvers=list(none),
        intersection=[None for _ in none],
        successors=list(none),
        predecessors=list(none),
        default_route=[lane.path for lane in network.lanes],
        conflicts=conflicts_of(network),
        beside=beside,
    )
    for maneuver in network.maneuvers:
        links.maneuvers[maneuver.start] += (maneuver.id,)
        links.intersection[maneuver.start] = links.intersection[maneuver.connecting] = maneuver.intersection_id
        _follow(links, maneuver.start, maneuver.connecting)
    for before, following in successors.items():
        for after in following:
            _follow(links, before, after)
    apart = [0.0]
    for lane in network.lanes:
        route = _route(lane, successors, apart)
        links.default_route[lane.id] = network.paths.join([network.lanes[i].path for i in route])
    return max(apart)


def _follow(links: Links, before: int, after: int) -> None:
    if after not in links.successors[before]:
        links.successors[before] += (after,)
        links.predecessors[after] += (before,)


def _route(lane: Lane, successors: Successors, apart: list[float]) -> list[int]:
    """Return the lanes of a driver without a plan: straight on if possible."""
    network, route, length = lane.network, [lane.id], lane.length
    while length < ROUTE:
        here = network.lanes[route[-1]]
        onward = _onward(here, successors)
        if not onward or any(index in route for index in onward):
            break
        chain = [here, *(network.lanes[index] for index in onward)]
        if not all(network.paths.continues(a.path, b.path) for a, b in pairwise(chain)):
            apart.append(_gap(chain[0], chain[1]))
            break
        route += onward
        length += sum(network.lanes[index].length for index in onward)
    return route


def _gap(before: Lane, after: Lane) -> float:
    paths = before.network.paths
    end, start = paths.pose(before.path, before.length), paths.pose(after.path, 0.0)
    return math.hypot(end.x - start.x, end.y - start.y)


def _onward(lane: Lane, successors: Successors) -> list[int]:
    near = ManeuverType.LEFT_TURN if lane.network.left_hand else ManeuverType.RIGHT_TURN
    ranking = {ManeuverType.STRAIGHT: 0, near: 1}
    if lane.maneuvers:
        chosen = min(lane.maneuvers, key=lambda maneuver: ranking.get(maneuver.type, 2))
        return [chosen.connecting, chosen.end]
    return list(successors.get(lane.id, ())[:1])


def conflicts_of(network: Network) -> list[tuple[int, ...]]:
    """Return per maneuver those of its intersection from other lanes whose centre lines meet its own."""
    lines = {each.connecting: network.paths.points(each.connecting_lane.path, 0.01) for each in network.maneuvers}
    found: list[list[int]] = [[] for _ in network.maneuvers]
    by_place: dict[int, list[Maneuver]] = defaultdict(list)
    for maneuver in network.maneuvers:
        by_place[maneuver.intersection_id].append(maneuver)
    for here in by_place.values():
        for one, other in combinations(here, 2):
            if one.start != other.start and _conflict(one, other, lines):
                found[one.id].append(other.id)
                found[other.id].append(one.id)
    return [tuple(sorted(others)) for others in found]


def _conflict(one: Maneuver, other: Maneuver, lines: Mapping[int, Floats]) -> bool:
    return one.end == other.end or polylines_cross(lines[one.connecting], lines[other.connecting])


def shortest_way(start: Lane, end: Lane) -> tuple[Lane, ...]:
    """Return the lanes of the shortest way from `start` to `end`, both included; () without a way.

    Source: Dijkstra, "A note on two problems in connexion with graphs", 1959.
    """
    lanes, paths = start.network.lanes, start.network.paths
    best, before = {start.id: start.length}, dict[int, int]()
    waiting = [(start.length, start.id)]
    while waiting:
        length, here = heappop(waiting)
        if here == end.id:
            return _traced(start, end, before)
        for after in lanes[here].successors:
            further = length + after.length
            if further < best.get(after.id, math.inf) and paths.continues(lanes[here].path, after.path):
                best[after.id], before[after.id] = further, here
                heappush(waiting, (further, after.id))
    return ()


def _traced(start: Lane, end: Lane, before: Mapping[int, int]) -> tuple[Lane, ...]:
    way = [end.id]
    while way[-1] != start.id:
        way.append(before[way[-1]])
    return tuple(start.network.lanes[index] for index in reversed(way))


def polylines_cross(first: Floats, second: Floats) -> bool:
    """Return True if a segment of `first` crosses a segment of `second`."""
    a, b = first[:-1, None], first[1:, None]
    c, d = second[None, :-1], second[None, 1:]
    apart = _side(a, b, c) * _side(a, b, d) > 0.0
    return bool(np.any(~apart & (_side(c, d, a) * _side(c, d, b) <= 0.0)))


def _side(a: Floats, b: Floats, point: Floats) -> Floats:
    """Return a value that is positive if the point is left of the line from a to b."""
    ab, ap = b - a, point - a
    return ab[..., 0] * ap[..., 1] - ab[..., 1] * ap[..., 0]


# -- right of way ------------------------------------------------------------------------------------------------------

CLEARANCE = 2.5
"""Distance of centre lines below which they cannot be driven at once [m]: a car's width and the usual lateral gap."""
PARTING = 1.0
"""Distance up to which paths out of one lane look the same to other drivers [m]."""
SPACING = 0.5
"""Distance between the points at which centre lines are compared [m]."""


@frozen
class Window:
    """Part of a lane, or of its continuation, in which an actor conflicts."""

    enter: float
    """Arc length on the lane at which the part begins; beyond the lane's end if the part is on its continuation [m]."""
    leave: float
    """Arc length at which the part ends [m]."""


NOWHERE = Window(math.inf, -math.inf)
"""Window of a lane without a conflict."""


def windows(maneuver: Maneuver) -> tuple[Window, ...]:
    """Return a window per lane of the network in which other actors conflict with a maneuver, for any continuation.

    Drivers do not know the plans of others, so all actors from a lane with a conflicting maneuver count until their
    paths part.
    """
    found = [NOWHERE] * len(maneuver.intersection.network.lanes)
    conflicts = maneuver.gives_way_to
    for start in dict.fromkeys(other.start_lane for other in conflicts):
        mine = {other: _overlap(maneuver, other) for other in conflicts if other.start_lane is start}
        first = min(window.enter for window in mine.values())
        found[start.id] = Window(start.length + first, math.inf)
        for other in start.maneuvers:
            leave = mine[other].leave if other in mine else _parting(other, list(mine))
            found[other.connecting] = Window(mine[other].enter if other in mine else first, leave)
        if maneuver.intersection.network.links.gives_way is not None:
            _look_upstream(found, start, start.length + first)
    return tuple(found)


UPSTREAM = 60.0
"""Distance upstream of a merge within which drivers look in a ring [m]: 5 s at 12 m/s."""


def _look_upstream(found: list[Window], lane: Lane, ahead: float) -> None:
    """Add windows for actors further upstream in the ring, including those that have just entered it."""
    for before in lane.predecessors:
        enter = before.length + ahead
        if found[before.id] is NOWHERE and before.role is not LaneRole.INCOMING and ahead < UPSTREAM:
            found[before.id] = Window(enter, math.inf)
            _look_upstream(found, before, enter)


def _points(paths: PathBook, lane: Lane) -> tuple[Floats, Floats]:
    """Return arc lengths along a lane, and (n, 2) places there."""
    stations = np.linspace(0.0, lane.length, max(2, math.ceil(lane.length / SPACING) + 1))
    return stations, np.array([paths.pose(lane.path, s)[:2] for s in stations])


def _overlap(maneuver: Maneuver, other: Maneuver) -> Window:
    paths = other.intersection.network.paths
    stations, places = _points(paths, other.connecting_lane)
    near = stations[paths.feet(maneuver.connecting_lane.path, *places.T).distance < CLEARANCE]
    return Window(float(near.min()), float(near.max())) if len(near) else NOWHERE


def _parting(other: Maneuver, conflicting: list[Maneuver]) -> float:
    """Return the length along which `other` coincides with a conflicting maneuver from the same lane [m]."""
    paths = other.intersection.network.paths
    stations, places = _points(paths, other.connecting_lane)
    distances = [paths.feet(each.connecting_lane.path, *places.T).distance for each in conflicting]
    together = stations[np.min(distances, axis=0) < PARTING]
    return float(together.max()) if len(together) else 0.0
