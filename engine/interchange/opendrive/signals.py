"""Traffic lights: one for each arm, at the kerb by its stop line; those of a phase under one controller."""

from dataclasses import dataclass

from engine.interchange.opendrive.places import Carriageway, RoadMap, road_map
from engine.interchange.recording import ARMS, PHASES, phase_of
from engine.interchange.xml_text import Element, child
from engine.program import RoadSpec
from engine.road import Intersection, Lane, Maneuver

BESIDE = 0.5
"""From the kerb to a light's mast [m]."""
ABOVE = 2.5
"""From the ground to a light's housing [m]: Manual on Uniform Traffic Control Devices (2009), section 4D.15."""
TRAFFIC_LIGHT = {"country": "OpenDRIVE", "type": "1000001", "subtype": "-1"}
"""Red, yellow, green, as OpenDRIVE numbers signals that belong to no country."""


@dataclass(frozen=True)
class SignalGroup:
    """Lights of one junction that always show the same; a controller in OpenDRIVE."""

    phase: int
    """0 or 1, as `SignalTimes` counts."""
    intersection: int
    """Index in our network."""
    controller: str
    """Id of the controller, which OpenSCENARIO's TrafficSignalController names."""
    name: str
    signals: tuple[str, ...]
    """Ids of the lights."""


def signal_groups(spec: RoadSpec) -> tuple[SignalGroup, ...]:
    """All groups of a road with lights: two for each junction, in the order of junctions and phases."""
    return groups_of(road_map(spec))


def groups_of(roads: RoadMap) -> tuple[SignalGroup, ...]:
    return tuple(_group(junction, phase) for junction in roads.network.intersections for phase in range(PHASES))


def _group(junction: Intersection, phase: int) -> SignalGroup:
    arms = [(arm, leg) for arm, leg in enumerate(junction.legs) if phase_of(leg.name) == phase]
    return SignalGroup(
        phase=phase,
        intersection=junction.id,
        controller=str(junction.id * PHASES + phase + 1),
        name=f"{junction.name} {' and '.join(leg.name for _, leg in arms)}",
        signals=tuple(_signal_id(junction, arm) for arm, _ in arms),
    )


def _signal_id(junction: Intersection, arm: int) -> str:
    """Lights of a junction are numbered by its arms, as in the language."""
    return str(junction.id * len(ARMS) + arm + 1)


def add_signals(element: Element, roads: RoadMap, road: Carriageway) -> None:
    """The lights at the ends of a road, where its lanes lead into junctions."""
    signals = child(element, "signals")
    for lanes in (road.forward, road.backward):
        junction = lanes[0].intersection
        if junction is not None:
            arm = _arm(junction, lanes[0])
            _add_signal(signals, roads, _signal_id(junction, arm), f"{junction.name} {junction.legs[arm].name}", lanes)


def _add_signal(signals: Element, roads: RoadMap, signal: str, name: str, lanes: tuple[Lane, ...]) -> None:
    places = [roads.places[lane.id] for lane in lanes]
    at, ids = places[0], sorted(place.lane for place in places)
    beside = len(lanes) * lanes[0].width + BESIDE
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
    """The light of a turn, on the turn's own road: some readers, Scenic among them, ask there whether it has one.

    Only in right-hand traffic: those readers know no other, and netconvert takes left-hand roads for right-hand ones,
    misses the turns and then warns of their lights.
    """
    if roads.network.spec.left_hand:
        return
    start, junction = maneuver.start_lane, maneuver.intersection
    place = roads.places[maneuver.connecting]
    to_kerb = (start.number - 0.5) * start.width + BESIDE
    reference = child(
        child(element, "signals"),
        "signalReference",
        id=_signal_id(junction, _arm(junction, start)),
        s=0,
        t=roads.side * to_kerb,
        orientation="+",
    )
    child(reference, "validity", fromLane=place.lane, toLane=place.lane)


def _arm(junction: Intersection, lane: Lane) -> int:
    return next(i for i, leg in enumerate(junction.legs) if lane in leg.incoming_lanes)


def add_controllers(document: Element, roads: RoadMap) -> None:
    """The controllers of all junctions."""
    for group in groups_of(roads):
        controller = child(document, "controller", id=group.controller, name=group.name, sequence=group.phase)
        for signal in group.signals:
            child(controller, "control", signalId=signal, type="0")


def add_controllers_of(element: Element, junction: Intersection) -> None:
    """Which controllers a junction has."""
    for phase in range(PHASES):
        child(element, "controller", id=_group(junction, phase).controller, type="0", sequence=phase)
