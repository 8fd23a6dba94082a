"""Roads outside the junctions: both directions side by side, each as many lanes as the other."""

import math

from engine.interchange.opendrive.lanes import add_lane, add_mark, add_plan, add_width
from engine.interchange.opendrive.places import Carriageway, RoadMap
from engine.interchange.xml_text import Element, child
from engine.road import Primitive


def add_road(document: Element, roads: RoadMap, road: Carriageway) -> Element:
    element = child(document, "road", id=road.id, name=road.name, length=road.length, junction="-1", rule=rule(roads))
    _add_junctions(element, roads, road)
    add_plan(element, [middle(road)])
    section = child(child(element, "lanes"), "laneSection", s=0)
    count = len(road.forward)
    left, center, right = (child(section, side) for side in ("left", "center", "right"))
    add_mark(add_lane(center, 0), "solid", "none")
    for lane in (*range(count, 0, -1), *range(-1, -count - 1, -1)):
        _add_lane(left if lane > 0 else right, lane, road)
    return element


def rule(roads: RoadMap) -> str:
    return "LHT" if roads.network.spec.left_hand else "RHT"


def middle(road: Carriageway) -> Primitive:
    """The line between the two directions of a road, with its forward traffic."""
    lane = road.forward[-1]
    start, shift = lane.network.paths.pose(lane.path, 0.0), 0.5 * lane.width
    to_left = -shift if lane.network.spec.left_hand else shift
    cos, sin = round(math.cos(start.heading)), round(math.sin(start.heading))  # exact: roads run along the axes
    return Primitive(start.x - to_left * sin, start.y + to_left * cos, start.heading, 0.0, lane.length)


def _add_junctions(element: Element, roads: RoadMap, road: Carriageway) -> None:
    """The junctions at a road's ends; at the border of the network there is none."""
    link = child(element, "link")
    for end, lane in (("predecessor", road.backward[0]), ("successor", road.forward[0])):
        if lane.intersection is not None:
            child(link, end, elementType="junction", elementId=roads.junction_id(lane.intersection.id))


def _add_lane(group: Element, lane: int, road: Carriageway) -> None:
    element = add_lane(group, lane)
    add_width(element, road.forward[0].width)
    if abs(lane) == len(road.forward):
        add_mark(element, "solid", "none")
    else:
        add_mark(element, "broken", "both")
