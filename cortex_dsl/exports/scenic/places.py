"""How Scenic finds a part of our road in the exported map: by a point that no other part of its kind has."""

from cortex_dsl.exports.scenic.sheet import Sheet
from cortex_dsl.semantics.model.values import Centerline, DirectionField, Region, Value
from engine.road.network import Intersection, Lane, LaneRole, Maneuver, Network
from engine.road.sections import LaneGroup, LaneSection, Road
from engine.tables import ROAD_REGION
from engine.vocabulary import ManeuverType


def place_text(sheet: Sheet, network: Network, value: Value) -> str | None:
    """An expression of Scenic for a part of the road, or a list of such; None if the value is nothing of the kind."""
    match value:
        case Lane() if value.role is LaneRole.CONNECTING:
            maneuver = next(each for each in network.maneuvers if each.connecting == value.id)
            return f"{_maneuver(sheet, maneuver)}.connectingLane"
        case Lane():
            return _lane(sheet, value)
        case Maneuver():
            return _maneuver(sheet, value)
        case LaneSection():
            return _named(sheet, f"section_{value.name}", f"network.laneSectionAt({_middle(value.lane)})")
        case LaneGroup():
            return _named(sheet, f"group_{value.name}", f"network.laneGroupAt({_middle(value.lanes[0])})")
        case Road():
            return _named(sheet, f"road_{value.name}", f"network.roadAt({_middle(value.lanes[0])})")
        case Intersection():
            return _intersection(sheet, value)
        case Network():
            return "network"
        case Centerline():
            return f"{place_text(sheet, network, value.lane)}.centerline"
        case Region():
            return _region(sheet, network, value)
        case DirectionField():
            return "roadDirection"
        case ManeuverType():
            return f"ManeuverType.{value.name}"
        case tuple() if value:
            texts = [place_text(sheet, network, item) for item in value]
            return None if None in texts else f"[{', '.join(text for text in texts if text is not None)}]"
    return None


def _lane(sheet: Sheet, lane: Lane) -> str:
    return _named(sheet, f"lane_{lane.name}", f"network.laneAt({_middle(lane)})")


def _maneuver(sheet: Sheet, maneuver: Maneuver) -> str:
    start, end = _lane(sheet, maneuver.start_lane), _lane(sheet, maneuver.end_lane)
    found = f"next(m for m in {start}.maneuvers if m.endLane is {end})"
    return _named(sheet, f"maneuver_{maneuver.start_lane.name}_to_{maneuver.end_lane.name}", found)


def _intersection(sheet: Sheet, intersection: Intersection) -> str:
    only = len(intersection.network.intersections) == 1
    name = "intersection" if only else f"intersection_{intersection.name}"
    x, y = intersection.center
    found = f"network.intersectionAt(({x!r}, {y!r}))"
    if only:  # the name that the author's file has for it, too
        sheet.lookups.setdefault(name, found)
        return name
    return _named(sheet, name, found)


def area_of(sheet: Sheet, intersection: Intersection) -> str:
    """The outline of an intersection, to a millionth of a metre.

    Scenic's own lies up to 0.08 m beside it: it makes one from twenty points of each lane of the map.
    """
    edges = intersection.network.regions.shape(intersection.region).edges[:, :2]
    corners = ", ".join(f"({round(x, 6)}, {round(y, 6)})" for x, y in edges.tolist())
    only = len(intersection.network.intersections) == 1
    name = "area_of_intersection" if only else f"area_of_{intersection.name}"
    return _named(sheet, name, f"PolygonalRegion([{corners}])")


def _region(sheet: Sheet, network: Network, region: Region) -> str | None:
    if region.id == ROAD_REGION:
        return "road"
    for element in (*network.intersections, *network.lanes):
        if element.region == region.id:
            return place_text(sheet, network, element)
    return None


def _named(sheet: Sheet, wanted: str, value: str) -> str:
    """The name of a part of the road, which is looked up once, at the top of the file."""
    known = {found: name for name, found in sheet.lookups.items()}
    if value not in known:
        known[value] = sheet.free_name(wanted)
        sheet.lookups[known[value]] = value
    return known[value]


def _middle(lane: Lane) -> str:
    """A point that lies on this lane alone."""
    pose = lane.network.paths.pose(lane.path, 0.5 * lane.length)
    return f"({pose.x!r}, {pose.y!r})"
