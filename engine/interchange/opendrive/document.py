"""The document as a whole."""

from engine.interchange.opendrive.junctions import add_junction, add_turn
from engine.interchange.opendrive.places import RoadMap, road_map
from engine.interchange.opendrive.roads import add_road
from engine.interchange.opendrive.signals import add_controllers, add_controllers_of, add_reference, add_signals
from engine.interchange.recording import Provenance, SignalTimes
from engine.interchange.xml_text import Element, child, xml_text
from engine.program import RoadSpec
from engine.tables import ROAD_REGION

REVISION = {"revMajor": 1, "revMinor": 7}
NO_PROVENANCE = Provenance()


def write_opendrive(
    spec: RoadSpec, signals: SignalTimes | None, name: str, provenance: Provenance = NO_PROVENANCE
) -> str:
    """The road of a specification as OpenDRIVE 1.7, with lights where there is a plan; their times stand elsewhere,
    in OpenSCENARIO.

    Raises:
        RoadError: no road fits the specification.
        InterchangeError: a name holds a character that XML cannot.
    """
    roads = road_map(spec)
    document = Element("OpenDRIVE")
    _add_header(document, roads, name, provenance)
    for road in roads.roads:
        element = add_road(document, roads, road)
        if signals is not None:
            add_signals(element, roads, road)
    for maneuver in roads.network.maneuvers:
        element = add_turn(document, roads, maneuver)
        if signals is not None:
            add_reference(element, roads, maneuver)
    if signals is not None:
        add_controllers(document, roads)
    for junction in roads.network.intersections:
        element = add_junction(document, roads, junction)
        if signals is not None:
            add_controllers_of(element, junction)
    return xml_text(document)


def _add_header(document: Element, roads: RoadMap, name: str, provenance: Provenance) -> None:
    hull = roads.network.regions.shape(ROAD_REGION).hull
    west, south, east, north = (*hull[:, :2].min(axis=0), *hull[:, :2].max(axis=0))
    bounds = {"north": north, "south": south, "east": east, "west": west}
    header = child(
        document, "header", **REVISION, name=name, date=provenance.date, **bounds, vendor=provenance.author
    )  # fmt: skip
    for code, value in (*provenance.facts.items(), *provenance.genome.items()):
        child(header, "userData", code=code, value=value)
