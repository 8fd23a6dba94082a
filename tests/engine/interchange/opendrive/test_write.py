"""What is linked with what, and what the document says of itself."""

import cmath
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given

from engine.interchange import InterchangeError, Provenance, SignalTimes
from engine.interchange.opendrive import road_map, write_opendrive
from engine.maps import RoadSpec
from engine.road import LaneRole, RoadError, build_network
from tests.engine.interchange.opendrive.reading_back import Document, number, only, specs
from tests.laws import examples
from tests.schemas import findings

few = examples(25)
LIGHTS = SignalTimes(green=10.0, yellow=3.0, all_red=2.0, offset=0.0)


@few
@given(specs())
def test_documents_are_valid(spec: RoadSpec) -> None:
    """By the schema of the standard, with lights and without."""
    for lights in (None, LIGHTS):
        assert not findings("opendrive", "1.7", write_opendrive(spec, lights, "road"))


@few
@given(specs())
def test_ids_are_unique(spec: RoadSpec) -> None:
    """Of roads and junctions together: some readers look them up in one table, and take 0 for none."""
    document = Document(write_opendrive(spec, LIGHTS, "road"))
    ids = Counter([*(road.attrib["id"] for road in document.root.findall("road")), *document.junctions])
    assert set(ids.values()) == {1}
    assert min(map(int, ids)) == 1
    for path in ("controller", "road/signals/signal"):
        assert set(Counter(each.attrib["id"] for each in document.root.findall(path)).values()) == {1}
    for junction in document.junctions.values():
        assert set(Counter(each.attrib["id"] for each in junction.findall("connection")).values()) == {1}


@few
@given(specs())
def test_every_maneuver_has_one_connection(spec: RoadSpec) -> None:
    """From its start lane through a road of its own, in the junction where it is driven, and no other has."""
    document, roads = Document(write_opendrive(spec, None, "road")), road_map(spec)
    wanted = [
        (
            roads.junction_id(maneuver.intersection_id),
            *(roads.places[maneuver.start].road, roads.places[maneuver.start].lane),
            *(roads.places[maneuver.connecting].road, roads.places[maneuver.connecting].lane),
        )
        for maneuver in roads.network.maneuvers
    ]
    assert sorted(connections(document)) == sorted(wanted)
    assert len({connection[3] for connection in wanted}) == len(wanted)


def connections(document: Document) -> Iterator[tuple[str, str, int, str, int]]:
    """Junction, incoming road and lane, connecting road and lane."""
    for name, junction in document.junctions.items():
        for each in junction.findall("connection"):
            link = only(each, "laneLink")
            assert each.attrib["contactPoint"] == "start"
            start, turn = each.attrib["incomingRoad"], each.attrib["connectingRoad"]
            yield name, start, int(link.attrib["from"]), turn, int(link.attrib["to"])


@few
@given(specs())
def test_links_are_mutual(spec: RoadSpec) -> None:
    """What a connection leads from, its road comes from; at both ends of a turn a road leads to its junction."""
    document = Document(write_opendrive(spec, None, "road"))
    for junction, incoming, lane, turn, through in connections(document):
        road = document.roads[turn]
        assert road.attrib["junction"] == junction
        assert only(road, "link/predecessor").attrib["elementId"] == incoming
        assert int(number(only(document.lane(turn, through), "link/predecessor"), "id")) == lane
        for end in ("predecessor", "successor"):
            side = only(road, f"link/{end}").attrib
            facing = {"start": "predecessor", "end": "successor"}[side["contactPoint"]]
            back = only(document.roads[side["elementId"]], f"link/{facing}").attrib
            assert (back["elementType"], back["elementId"]) == ("junction", junction)


@few
@given(specs())
def test_lane_links_lead_on_as_our_lanes_do(spec: RoadSpec) -> None:
    """Successors of a turn's lane are those of ours."""
    document, roads = Document(write_opendrive(spec, None, "road")), road_map(spec)
    for maneuver in roads.network.maneuvers:
        turn, end = roads.places[maneuver.connecting], roads.places[maneuver.end]
        assert only(document.roads[turn.road], "link/successor").attrib["elementId"] == end.road
        assert int(number(only(document.lane(turn.road, turn.lane), "link/successor"), "id")) == end.lane


@few
@given(specs())
def test_roads_end_where_ours_do(spec: RoadSpec) -> None:
    """An arm leads to one junction, a road between two junctions to both."""
    document, roads = Document(write_opendrive(spec, None, "road")), road_map(spec)
    for road in roads.roads:
        ends = {road.forward[0].role, road.backward[0].role}
        expected = 2 if ends == {LaneRole.LINK} else 1
        assert len(document.roads[road.id].findall("link/*")) == expected
        assert len(road.forward) == len(road.backward) == spec.lanes


@pytest.mark.parametrize(("left_hand", "rule", "sign"), [(False, "RHT", -1), (True, "LHT", 1)])
def test_traffic_keeps_to_its_side(left_hand: bool, rule: str, sign: int) -> None:
    """Lanes with the road lie to its right, or to its left where traffic does; lane 1 of ours is the outermost."""
    spec = RoadSpec(lanes=2, left_hand=left_hand)
    document, roads = Document(write_opendrive(spec, None, "road")), road_map(spec)
    assert {road.attrib["rule"] for road in document.roads.values()} == {rule}
    lanes = {lane.name: roads.places[lane.id].lane for lane in roads.network.lanes}
    assert [lanes[f"east.in.{i}"] for i in (1, 2)] == [2 * sign, sign]
    assert [lanes[f"east.out.{i}"] for i in (1, 2)] == [-2 * sign, -sign]
    assert lanes["east.2-west.2"] == sign


def test_the_header_says_where_it_comes_from() -> None:
    """Name, date, author, and every fact as user data."""
    provenance = Provenance(author="me", date="2026-01-02T03:04:05", facts={"seed": "7", "scenario": "a & b.scn"})
    document = Document(write_opendrive(RoadSpec(), None, "crossing", provenance))
    header = only(document.root, "header")
    assert [header.attrib[name] for name in ("revMajor", "revMinor", "name")] == ["1", "7", "crossing"]
    assert (header.attrib["vendor"], header.attrib["date"]) == ("me", "2026-01-02T03:04:05")
    said = {each.attrib["code"]: each.attrib["value"] for each in header.findall("userData")}
    assert said == {"seed": "7", "scenario": "a & b.scn"}


def test_the_same_road_gives_the_same_text() -> None:
    """Nothing of the clock or of an order by chance."""
    spec = RoadSpec(rows=2, cols=2, lanes=2)
    assert write_opendrive(spec, LIGHTS, "road") == write_opendrive(spec, LIGHTS, "road")


def test_marks_show_where_lanes_may_be_changed() -> None:
    """Broken between lanes of one direction, solid in the middle and at the kerb."""
    document = Document(write_opendrive(RoadSpec(lanes=3), None, "road"))
    marks = {lane: only(document.lane("1", lane), "roadMark").attrib for lane in document.lane_ids("1")}
    assert {lane: mark["type"] for lane, mark in marks.items() if abs(lane) in (0, 3)} == dict.fromkeys(
        (3, 0, -3), "solid"
    )
    assert {marks[lane]["laneChange"] for lane in (1, 2, -1, -2)} == {"both"}


def test_no_speed_limit_is_made_up() -> None:
    """Our roads have none."""
    assert "speed" not in write_opendrive(RoadSpec(), LIGHTS, "road")


def test_a_road_that_cannot_be_is_an_error() -> None:
    """As where networks are built."""
    with pytest.raises(RoadError, match="lanes"):
        write_opendrive(RoadSpec(lanes=9), None, "road")


def test_a_name_that_xml_cannot_hold_is_an_error() -> None:
    """Control characters."""
    with pytest.raises(InterchangeError, match="x08"):
        write_opendrive(RoadSpec(), None, "a\bb")


@pytest.mark.parametrize(
    "spec",
    [RoadSpec(buildings=6.0), RoadSpec(ways=3, rows=2, cols=2, block=80.0, approach=30.0, buildings=4.5)],
)
@pytest.mark.parametrize("left_hand", [False, True])
def test_buildings_stand_where_they_do(spec: RoadSpec, left_hand: bool) -> None:
    """Centres, headings and sizes, from s, t and heading along the road; and the schema has nothing against them."""
    spec = replace(spec, left_hand=left_hand)
    text = write_opendrive(spec, None, "road")
    assert not findings("opendrive", "1.7", text)
    document, found = Document(text), []
    for road in document.root.iter("road"):
        for thing in road.iter("object"):
            point, heading = document.reference(road.attrib["id"], number(thing, "s"))
            at = point + number(thing, "t") * 1j * cmath.exp(1j * heading)
            turned = heading + number(thing, "hdg")
            found.append([at.real, at.imag, turned, number(thing, "length"), number(thing, "width")])
    blocks = build_network(spec).buildings
    np.testing.assert_allclose(sorted(found), sorted(blocks.tolist()), rtol=0.0, atol=1e-9)
