"""Writer of OpenDRIVE: `write_opendrive` returns a road as a document, with roads, junctions and traffic lights."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from engine.interchange.opendrive.places import (
    Beside,
    Carriageway,
    RoadMap,
    buildings_by_road,
    parked_by_road,
    road_map,
)
from engine.interchange.opendrive.streets import TYPES, Crossed, corners, crossings_before, crossings_over, strips
from engine.interchange.recording import ARMS, NO_PROVENANCE, PHASES, Provenance, SignalTimes
from engine.interchange.xml_writing import Element, child, xml_text
from engine.maps import MapFile, MapSpec, Street
from engine.opendrive.near_roads import CROSSWALK, OBSTACLE, PARKED
from engine.road import Intersection, Lane, Maneuver, Primitive
from engine.road.network import Surface
from engine.road.specification import setback
from engine.tables import ROAD_REGION

# -- reference lines and cross sections of roads -----------------------------------------------------------------------

WIDE = {"b": 0, "c": 0, "d": 0}
"""Coefficients of a width that does not change along the road."""


def add_plan(road: Element, primitives: Sequence[Primitive]) -> None:
    """Add the reference line: lines and arcs."""
    plan, s = child(road, "planView"), 0.0
    for line in primitives:
        geometry = child(plan, "geometry", s=s, x=line.x, y=line.y, hdg=line.heading, length=line.length)
        if line.curvature == 0.0:
            child(geometry, "line")
        else:
            child(geometry, "arc", curvature=line.curvature)
        s += line.length


def add_offset(lanes: Element, offset: float) -> None:
    """Add the offset of lane 0 to the left of the reference line [m]."""
    child(lanes, "laneOffset", s=0, a=offset, **WIDE)


def add_lane(group: Element, lane: int, kind: str = "driving") -> Element:
    return child(group, "lane", id=lane, type="none" if lane == 0 else kind, level="false")


def add_link(parent: Element, ends: Mapping[str, int]) -> None:
    """Add the lanes into which a lane continues, by `predecessor` and `successor`."""
    link = child(parent, "link")
    for end, lane in ends.items():
        child(link, end, id=lane)


def add_width(lane: Element, width: float) -> None:
    child(lane, "width", sOffset=0, a=width, **WIDE)


def add_mark(lane: Element, kind: str, lane_change: str) -> None:
    """Add the line at a lane's outer border; for lane 0 in the middle of the road."""
    child(lane, "roadMark", sOffset=0, type=kind, weight="standard", color="standard", laneChange=lane_change)


# -- roads outside the junctions: both directions side by side ---------------------------------------------------------


def add_road(document: Element, roads: RoadMap, road: Carriageway) -> Element:
    element = child(document, "road", id=road.id, name=road.name, length=road.length, junction="-1", rule=rule(roads))
    _add_junctions(element, roads, road)
    add_speed_limit(element, road.lanes[0])
    add_plan(element, road.road.middle)
    section = child(child(element, "lanes"), "laneSection", s=0)
    numbered: dict[int, Lane | Surface] = {roads.places[lane.id].lane: lane for lane in road.lanes}
    numbered |= dict(strips(roads, road))
    # The schema wants left, center, right in this order, and no side without lanes.
    left = child(section, "left") if max(numbered) > 0 else section
    center = child(section, "center")
    right = child(section, "right") if min(numbered) < 0 else section
    add_mark(add_lane(center, 0), "solid", "none")
    for number in sorted(numbered, reverse=True):
        _add_lane(left if number > 0 else right, number, numbered[number])
    return element


def rule(roads: RoadMap) -> str:
    return "LHT" if roads.network.left_hand else "RHT"


STOREYS = 10.0
"""Height of a building [m]; it has no influence here, but viewers omit objects without a height."""


CAR_HEIGHT = 1.5
"""Height of a parked car [m]."""


def add_objects(road: Element, places: Sequence[Beside], cars: Sequence[Beside], crossings: Sequence[Crossed]) -> None:
    """Add the buildings near a road, the cars parked beside it and the crossings over it as objects."""
    objects = child(road, "objects") if places or cars or crossings else road
    for place in places:
        _add_object(objects, place, f"building {place.number + 1}", STOREYS, type="building")
    for place in cars:
        name = f"parked car {place.number + 1}"
        _add_object(objects, place, name, CAR_HEIGHT, type=OBSTACLE, subtype=PARKED)
    for crossing in crossings:
        element = _add_object(objects, crossing.place, crossing.name, 0.0, type=CROSSWALK)
        outline = child(child(element, "outlines"), "outline", id=0, closed="true", outer="true")
        for corner, (u, v) in enumerate(crossing.corners):
            child(outline, "cornerLocal", id=corner, u=u, v=v, z=0, height=0)


def _add_object(objects: Element, place: Beside, name: str, height: float, **kind: str) -> Element:
    number = place.number + 1
    around = {"hdg": place.heading, "pitch": 0, "roll": 0, "orientation": "none"}
    size = {"length": place.length, "width": place.width, "height": height}
    return child(objects, "object", id=number, name=name, **kind, s=place.s, t=place.t, zOffset=0, **around, **size)


def _add_junctions(element: Element, roads: RoadMap, road: Carriageway) -> None:
    """Add the junctions at a road's ends; at the border of the network there is none."""
    link = child(element, "link")
    for end, junction in (("predecessor", road.junctions[0]), ("successor", road.junctions[1])):
        if junction is not None:
            child(link, end, elementType="junction", elementId=roads.junction_id(junction.id))


def add_speed_limit(road: Element, lane: Lane) -> None:
    """Add the speed limit of all its lanes."""
    if lane.speed_limit is not None:
        child(child(road, "type", s=0, type="unknown"), "speed", max=lane.speed_limit, unit="m/s")


def _add_lane(group: Element, number: int, lane: Lane | Surface) -> None:
    element = add_lane(group, number, TYPES[lane.kind] if isinstance(lane, Surface) else "driving")
    add_width(element, lane.width)
    if isinstance(lane, Surface) or lane.number == 1:
        add_mark(element, "solid", "none")
    else:
        add_mark(element, "broken", "both")


# -- corners: a road for the sidewalk around each of them, along its kerb ----------------------------------------------


def add_corners(document: Element, roads: RoadMap) -> None:
    """Add a road with a sidewalk for each corner; its reference line is the kerb."""
    for number, (walk, kerb) in enumerate(corners(roads)):
        about = {"id": roads.corner_id(number), "name": walk.name, "length": sum(each.length for each in kerb)}
        element = child(document, "road", **about, junction="-1", rule=rule(roads))
        add_plan(element, kerb)
        section = child(child(element, "lanes"), "laneSection", s=0)
        # The schema wants left, center, right in this order.
        left = child(section, "left") if roads.side > 0 else None
        add_lane(child(section, "center"), 0)
        group = child(section, "right") if left is None else left
        add_width(add_lane(group, roads.side, TYPES[walk.kind]), walk.width)


# -- junctions: a road of one lane for each maneuver, and the list of which lane leads into which ----------------------


def add_turn(document: Element, roads: RoadMap, maneuver: Maneuver) -> Element:
    """Add the road along a maneuver. Its reference line is the lane's own centre, so both have the same length."""
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
    add_speed_limit(element, lane)
    add_plan(element, roads.network.paths.primitives(lane.path))
    _add_lanes(child(element, "lanes"), roads, maneuver)
    add_objects(element, (), (), crossings_before(roads, maneuver))
    return element


def _add_end(link: Element, end: str, roads: RoadMap, lane: Lane, *, at_end: bool) -> None:
    """Add the road before or after this road, and its end that meets this road; `at_end`: the end of the lane does."""
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
    """Add one connection for each maneuver, numbered from 0."""
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


# -- traffic lights: one for each arm, at the kerb by its stop line; those of a phase under one controller -------------

MAST_OFFSET = 0.5
"""Distance of a light's mast from the kerb [m]."""
ABOVE = 2.5
"""Height of a light's housing above the ground [m]: Manual on Uniform Traffic Control Devices (2009), section 4D.15."""
TRAFFIC_LIGHT = {"country": "OpenDRIVE", "type": "1000001", "subtype": "-1"}
"""Red, yellow, green, as OpenDRIVE numbers signals that belong to no country."""


@dataclass(frozen=True)
class SignalGroup:
    """Lights of one junction with equal states; a controller in OpenDRIVE."""

    phase: int
    """0 or 1, as `SignalTimes` counts."""
    intersection: int
    """Index of the intersection in the network."""
    controller: str
    """Id of the controller, which OpenSCENARIO's TrafficSignalController names."""
    name: str
    signals: tuple[str, ...]
    """Ids of the lights."""


def signal_groups(spec: MapSpec) -> tuple[SignalGroup, ...]:
    """Return all groups of a road with lights: two for each junction, in the order of junctions and phases.

    () for a map file, which does not contain the lights of cortexc.
    """
    return () if isinstance(spec, MapFile) else groups_of(road_map(spec))


def groups_of(roads: RoadMap) -> tuple[SignalGroup, ...]:
    return tuple(_group(junction, phase) for junction in roads.network.intersections for phase in range(PHASES))


def _group(junction: Intersection, phase: int) -> SignalGroup:
    arms = [(arm, leg) for arm, leg in enumerate(junction.legs) if leg.phase == phase and leg.incoming_lanes]
    return SignalGroup(
        phase=phase,
        intersection=junction.id,
        controller=str(junction.id * PHASES + phase + 1),
        name=f"{junction.name} {' and '.join(leg.name for _, leg in arms)}",
        signals=tuple(_signal_id(junction, arm) for arm, _ in arms),
    )


def _signal_id(junction: Intersection, arm: int) -> str:
    """Return the number of a junction's light, by its arm as in the language."""
    return str(junction.id * len(ARMS) + arm + 1)


def add_signals(element: Element, roads: RoadMap, road: Carriageway) -> None:
    """Add the lights at the ends of a road, where its lanes lead into junctions."""
    signals = child(element, "signals")
    for lanes in (road.forward, road.backward):
        junction = lanes[0].intersection if lanes else None
        if junction is not None:
            arm = _arm(junction, lanes[0])
            _add_signal(signals, roads, _signal_id(junction, arm), f"{junction.name} {junction.legs[arm].name}", lanes)


def _add_signal(signals: Element, roads: RoadMap, signal: str, name: str, lanes: tuple[Lane, ...]) -> None:
    places = [roads.places[lane.id] for lane in lanes]
    at, ids = places[0], sorted(place.lane for place in places)
    beside = len(lanes) * lanes[0].width + _to_kerb(roads) + MAST_OFFSET
    light = child(
        signals,
        "signal",
        id=signal,
        name=name,
        s=at.s(at.length),
        t=beside if at.lane > 0 else -beside,
        zOffset=ABOVE,
        dynamic="yes",
        orientation="+" if at.forward else "-",
        **TRAFFIC_LIGHT,
    )
    child(light, "validity", fromLane=ids[0], toLane=ids[-1])


def add_reference(element: Element, roads: RoadMap, maneuver: Maneuver) -> None:
    """Add a reference to a turn's light on the turn's road: some readers, such as Scenic, look for it there.

    Only in right-hand traffic: those readers know no other, and netconvert takes left-hand roads for right-hand ones,
    misses the turns and then warns of their lights.
    """
    if roads.network.left_hand:
        return
    start, junction = maneuver.start_lane, maneuver.intersection
    place = roads.places[maneuver.connecting]
    to_kerb = (start.number - 0.5) * start.width + _to_kerb(roads) + MAST_OFFSET
    reference = child(
        child(element, "signals"),
        "signalReference",
        id=_signal_id(junction, _arm(junction, start)),
        s=0,
        t=roads.side * to_kerb,
        orientation="+",
    )
    child(reference, "validity", fromLane=place.lane, toLane=place.lane)


def _to_kerb(roads: RoadMap) -> float:
    """Return the distance from the border of the outer lane to the kerb [m]."""
    return setback(roads.network.spec) if isinstance(roads.network.spec, Street) else 0.0


def _arm(junction: Intersection, lane: Lane) -> int:
    return next(i for i, leg in enumerate(junction.legs) if lane in leg.incoming_lanes)


def add_controllers(document: Element, roads: RoadMap) -> None:
    """Add the controllers of all junctions."""
    for group in groups_of(roads):
        controller = child(document, "controller", id=group.controller, name=group.name, sequence=group.phase)
        for signal in group.signals:
            child(controller, "control", signalId=signal, type="0")


def add_controllers_of(element: Element, junction: Intersection) -> None:
    """Add the references of a junction to its controllers."""
    for phase in range(PHASES):
        child(element, "controller", id=_group(junction, phase).controller, type="0", sequence=phase)


# -- the document as a whole -------------------------------------------------------------------------------------------

REVISION = {"revMajor": 1, "revMinor": 7}


def write_opendrive(
    spec: MapSpec, signals: SignalTimes | None, name: str, provenance: Provenance = NO_PROVENANCE, place: str = ""
) -> str:
    """Return the road of a specification as OpenDRIVE 1.7, with lights if there is a plan (OpenSCENARIO has their
    times); `place` is the text of its <geoReference>.

    Raises:
        RoadError: no road fits the specification.
        InterchangeError: a name contains a character that XML does not allow.
    """
    roads = road_map(spec)
    document = Element("OpenDRIVE")
    _add_header(document, roads, name, provenance, place)
    beside, cars = buildings_by_road(roads), parked_by_road(roads)
    for road in roads.roads:
        element = add_road(document, roads, road)
        add_objects(element, beside[road.id], cars[road.id], crossings_over(roads, road))
        if signals is not None:
            add_signals(element, roads, road)
    for maneuver in roads.network.maneuvers:
        element = add_turn(document, roads, maneuver)
        if signals is not None:
            add_reference(element, roads, maneuver)
    add_corners(document, roads)
    if signals is not None:
        add_controllers(document, roads)
    for junction in roads.network.intersections:
        element = add_junction(document, roads, junction)
        if signals is not None:
            add_controllers_of(element, junction)
    return xml_text(document)


def _add_header(document: Element, roads: RoadMap, name: str, provenance: Provenance, place: str) -> None:
    hull = roads.network.regions.shape(ROAD_REGION).hull
    west, south, east, north = (*hull[:, :2].min(axis=0), *hull[:, :2].max(axis=0))
    bounds = {"north": north, "south": south, "east": east, "west": west}
    said = {"name": name, "date": provenance.date, **bounds, "vendor": provenance.author}
    header = child(document, "header", **REVISION, **said)
    if place:
        child(header, "geoReference").text = place
    for code, value in (*provenance.facts.items(), *provenance.genome.items()):
        child(header, "userData", code=code, value=value)
