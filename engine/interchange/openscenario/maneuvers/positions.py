"""Starts and ways as positions on the lanes of the road file."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise

from engine.interchange.opendrive import LanePlace, RoadMap
from engine.interchange.openscenario.document import world_position
from engine.interchange.openscenario.maneuvers import formula
from engine.interchange.openscenario.maneuvers.formula import Formula
from engine.interchange.openscenario.maneuvers.maneuver_plan import ActorPlan, Start
from engine.interchange.xml_writing import Element, child, decimal

MIDDLE = 0.5
"""Position on a lane, as a share of its length, that names the lane: its middle is on no other lane."""
ROUNDING = 1e-9
"""Difference below which shares are equal."""
BEFORE_END = 1.0
"""Distance of the last place of a way from the end of its lane [m]."""

Text = Callable[[Formula], str]


@dataclass(frozen=True)
class Places:
    """Positions in one file."""

    roads: RoadMap
    starts: Mapping[str, Start]
    """Starts by actor."""
    values: Mapping[str, float]
    """Values of the parameters in this case."""

    def start(self, parent: Element, actor: str, text: Text) -> Element:
        """Add the `Position` of an actor's rear axle at the beginning."""
        start = self.starts[actor]
        if start.lane is None:
            return world_position(parent, start.pose)
        lane = self.roads.places[start.lane]
        position = self._on_lane(parent, lane, start.s, text, start.offset)
        if start.turned or not lane.forward:  # readers disagree on the reference of a relative heading
            child(position, "Orientation", type="absolute", h=start.pose[2])
        return position

    def way(self, parent: Element, plan: ActorPlan, text: Text) -> None:
        """Add the waypoints of a route, one for each lane."""
        self.start(child(parent, "Waypoint", routeStrategy="shortest"), plan.name, text)
        lanes = [self.roads.places[lane] for lane in plan.route]
        for lane in lanes[1:]:
            s = lane.length - BEFORE_END if lane is lanes[-1] else lane.length * MIDDLE
            self._on_lane(child(parent, "Waypoint", routeStrategy="shortest"), lane, formula.number(round(s, 6)), text)
        if len(lanes) == 1:
            end = formula.number(round(lanes[0].length - BEFORE_END, 6))
            self._on_lane(child(parent, "Waypoint", routeStrategy="shortest"), lanes[0], end, text)

    def _on_lane(self, parent: Element, lane: LanePlace, along: Formula, text: Text, left: float = 0.0) -> Element:
        """Add a position `along` a lane of the network, `left` of its centre line [m]."""
        here, s = along.value(self.values), along
        if lane.knots:
            s = _beside(lane, along, here)
        elif not lane.forward:
            s = formula.subtract(formula.number(lane.length), along)
        number = str(lane.number(here))
        element = child(child(parent, "Position"), "LanePosition", roadId=lane.road, laneId=number, s=text(s))
        if left:
            element.set("offset", decimal(left if lane.forward else -left))
        return element


def _beside(lane: LanePlace, along: Formula, here: float) -> Formula:
    """Return the arc length on the road, by the arcs of a lane and its road at `here` along the lane [m]."""
    pieces = [piece for piece in pairwise(lane.knots) if piece[1][0] > piece[0][0]]
    (begin, s), (end, last) = next((piece for piece in reversed(pieces) if piece[0][0] <= here), pieces[0])
    share = (last - s) / (end - begin)
    if abs(abs(share) - 1.0) > ROUNDING:
        return formula.add(formula.number(round(s - share * begin, 6)), formula.scaled(along, round(share, 9)))
    if share > 0.0:
        return formula.add(along, formula.number(round(s - begin, 6)))
    return formula.subtract(formula.number(round(s + begin, 6)), along)
