"""Traffic lights: where they stand, whom they are for, and which belong together."""

import cmath
import math
from collections import Counter
from xml.etree.ElementTree import Element

from hypothesis import given

from cortex_dsl.semantics.evaluation import signals as language
from cortex_dsl.semantics.model.values import Signal
from engine.interchange import SignalTimes
from engine.interchange.opendrive import road_map, signal_groups, write_opendrive
from engine.maps import RoadSpec
from tests.engine.interchange.opendrive.reading_back import Document, number, only, specs
from tests.laws import examples

few = examples(20)
LIGHTS = SignalTimes(green=10.0, yellow=3.0, all_red=2.0, offset=0.0)


@few
@given(specs())
def test_every_incoming_side_has_one_light_for_its_lanes(spec: RoadSpec) -> None:
    """At the stop line, seen by those who come, valid for their lanes and no others."""
    document, roads = Document(write_opendrive(spec, LIGHTS, "road")), road_map(spec)
    wanted = Counter()
    for junction in roads.network.intersections:
        for leg in junction.legs:
            places = [roads.place(lane.id, lane.length) for lane in leg.incoming_lanes]
            ids = sorted(place.lane for place in places)
            wanted[places[0].road, places[0].s, ids[0], ids[-1]] += 1
    found = Counter()
    for name, road in document.roads.items():
        for signal in road.findall("signals/signal"):
            valid = only(signal, "validity")
            lanes = int(number(valid, "fromLane")), int(number(valid, "toLane"))
            found[name, number(signal, "s"), *lanes] += 1
            with_s = (lanes[0] > 0) == spec.left_hand
            assert signal.attrib["orientation"] == ("+" if with_s else "-")
            assert signal.attrib["dynamic"] == "yes"
            assert math.copysign(1.0, number(signal, "t")) == math.copysign(1.0, lanes[0])
            assert abs(number(signal, "t")) > spec.lanes * spec.lane_width
    assert found == wanted


@few
@given(specs())
def test_each_light_is_in_one_group(spec: RoadSpec) -> None:
    """And each group is a controller of the document, named by the one junction whose lights it switches."""
    document, groups = Document(write_opendrive(spec, LIGHTS, "road")), signal_groups(spec)
    signals = [signal.attrib["id"] for signal in document.root.iter("signal")]
    assert sorted(signals) == sorted(signal for group in groups for signal in group.signals)
    said = {
        each.attrib["id"]: tuple(control.attrib["signalId"] for control in each.findall("control"))
        for each in document.root.findall("controller")
    }
    assert said == {group.controller: group.signals for group in groups}
    for number_, junction in enumerate(document.junctions.values()):
        own = [each.attrib["id"] for each in junction.findall("controller")]
        assert own == [group.controller for group in groups if group.intersection == number_]


@few
@given(specs())
def test_phases_are_those_of_the_language(spec: RoadSpec) -> None:
    """Lights are numbered and take turns as they do when a scenario runs."""
    phases = {
        str(language.number_of(light) + 1): language.phase_of(light)
        for junction in road_map(spec).network.intersections
        for light in (Signal(junction, arm) for arm in range(len(junction.legs)))
    }
    assert phases == {signal: group.phase for group in signal_groups(spec) for signal in group.signals}


@few
@given(specs())
def test_every_turn_refers_to_the_light_before_it(spec: RoadSpec) -> None:
    """For its one lane, where that light stands; in left-hand traffic the lights of the arms must do."""
    if spec.left_hand:
        assert "signalReference" not in write_opendrive(spec, LIGHTS, "road")
        return
    document, roads = Document(write_opendrive(spec, LIGHTS, "road")), road_map(spec)
    lights = {
        signal.attrib["id"]: (name, signal) for name, road in document.roads.items() for signal in road.iter("signal")
    }
    for maneuver in roads.network.maneuvers:
        turn = roads.places[maneuver.connecting]
        reference = only(document.roads[turn.road], "signals/signalReference")
        road, light = lights[reference.attrib["id"]]
        assert road == roads.places[maneuver.start].road
        assert int(number(only(light, "validity"), "fromLane")) <= roads.places[maneuver.start].lane
        assert abs(mast(document, turn.road, reference) - mast(document, road, light)) < 1e-9
        assert int(number(only(reference, "validity"), "fromLane")) == turn.lane


def mast(document: Document, road: str, signal: Element) -> complex:
    point, heading = document.reference(road, number(signal, "s"))
    return point + number(signal, "t") * 1j * cmath.exp(1j * heading)


def test_arms_that_face_each_other_share_a_group() -> None:
    """North with south, east with west; the stem of a T is alone."""
    assert [(g.phase, g.name, g.signals) for g in signal_groups(RoadSpec())] == [
        (0, "intersection north and south", ("1", "3")),
        (1, "intersection east and west", ("2", "4")),
    ]
    assert [g.name for g in signal_groups(RoadSpec(ways=3))] == ["intersection south", "intersection east and west"]


def test_roads_without_lights_have_none() -> None:
    """Neither signals nor controllers."""
    text = write_opendrive(RoadSpec(), None, "road")
    assert "signal" not in text
    assert "controller" not in text
