"""Starts and ways as positions on the lanes of the road file."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from engine.interchange.opendrive import LanePlace, RoadMap
from engine.interchange.openscenario.document import world_position
from engine.interchange.openscenario.maneuvers import formula
from engine.interchange.openscenario.maneuvers.formula import Formula
from engine.interchange.openscenario.maneuvers.plan import ActorPlan, Start
from engine.interchange.xml_text import Element, child, decimal

MIDDLE = 0.5
"""A lane on the way is named by its middle, which is on no other lane."""
BEFORE_END = 1.0
"""The last place of a way lies so far before the end of its lane [m]."""

Text = Callable[[Formula], str]


@dataclass(frozen=True)
class Places:
    """Positions in one file."""

    roads: RoadMap
    starts: Mapping[str, Start]
    """By actor."""

    def start(self, parent: Element, actor: str, text: Text) -> Element:
        """The `Position` of an actor's rear axle at the beginning."""
        start = self.starts[actor]
        if start.lane is None:
            return world_position(parent, start.pose)
        lane = self.roads.places[start.lane]
        position = _lane_position(parent, lane, start.s, text, start.offset)
        if start.turned or not lane.forward:  # readers differ in what a relative heading is relative to
            child(position, "Orientation", type="absolute", h=start.pose[2])
        return position

    def way(self, parent: Element, plan: ActorPlan, text: Text) -> None:
        """The waypoints of a route, one for each lane."""
        self.start(child(parent, "Waypoint", routeStrategy="shortest"), plan.name, text)
        lanes = [self.roads.places[lane] for lane in plan.route]
        for lane in lanes[1:]:
            s = lane.length - BEFORE_END if lane is lanes[-1] else lane.length * MIDDLE
            _lane_position(child(parent, "Waypoint", routeStrategy="shortest"), lane, formula.number(round(s, 6)), text)
        if len(lanes) == 1:
            end = formula.number(round(lanes[0].length - BEFORE_END, 6))
            _lane_position(child(parent, "Waypoint", routeStrategy="shortest"), lanes[0], end, text)


def _lane_position(parent: Element, lane: LanePlace, along: Formula, text: Text, left: float = 0.0) -> Element:
    """`along` our lane, `left` of its centre line [m]."""
    s = along if lane.forward else formula.subtract(formula.number(lane.length), along)
    element = child(child(parent, "Position"), "LanePosition", roadId=lane.road, laneId=str(lane.lane), s=text(s))
    if left:
        element.set("offset", decimal(left if lane.forward else -left))
    return element
