"""Junctions: a road of one lane for each maneuver, and the list of which lane leads into which."""

from engine.interchange.opendrive.lanes import add_lane, add_link, add_offset, add_plan, add_width
from engine.interchange.opendrive.places import RoadMap
from engine.interchange.opendrive.roads import rule
from engine.interchange.xml_text import Element, child
from engine.road import Intersection, Lane, Maneuver


def add_turn(document: Element, roads: RoadMap, maneuver: Maneuver) -> Element:
    """The road along a maneuver. Its reference line is the lane's own centre, so that both have the same length."""
    lane = maneuver.connecting_lane
    there = roads.places[lane.id]
    element = child(
        document,
        "road",
        id=there.road,
        name=maneuver.name,
        length=lane.length,
        junction=roads.junction_id(maneuver.intersection_id),
        rule=rule(roads),
    )
    link = child(element, "link")
    _add_end(link, "predecessor", roads, maneuver.start_lane, at_end=True)
    _add_end(link, "successor", roads, maneuver.end_lane, at_end=False)
    add_plan(element, roads.network.paths.primitives(lane.path))
    _add_lanes(child(element, "lanes"), roads, maneuver)
    return element


def _add_end(link: Element, end: str, roads: RoadMap, lane: Lane, *, at_end: bool) -> None:
    """The road before or behind, and which of its ends meets this one; `at_end` tells which end of the lane does."""
    place = roads.places[lane.id]
    contact = "end" if place.forward == at_end else "start"
    child(link, end, elementType="road", elementId=place.road, contactPoint=contact)


def _add_lanes(lanes: Element, roads: RoadMap, maneuver: Maneuver) -> None:
    width = maneuver.connecting_lane.width
    add_offset(lanes, -0.5 * roads.side * width)
    section = child(lanes, "laneSection", s=0)
    # The schema wants left, center, right in this order.
    left = child(section, "left") if roads.side > 0 else None
    add_lane(child(section, "center"), 0)
    lane = add_lane(child(section, "right") if left is None else left, roads.side)
    start, end = roads.places[maneuver.start], roads.places[maneuver.end]
    add_link(lane, {"predecessor": start.lane, "successor": end.lane})
    add_width(lane, width)


def add_junction(document: Element, roads: RoadMap, junction: Intersection) -> Element:
    """One connection for each maneuver, numbered from 0."""
    element = child(document, "junction", id=roads.junction_id(junction.id), name=junction.name)
    for number, maneuver in enumerate(junction.maneuvers):
        start = roads.places[maneuver.start]
        connection = child(
            element,
            "connection",
            id=number,
            incomingRoad=start.road,
            connectingRoad=roads.turn_id(maneuver),
            contactPoint="start",
        )
        child(connection, "laneLink", **{"from": start.lane, "to": roads.side})
    return element
