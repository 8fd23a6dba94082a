"""What a recording states and its reader does not read has one note for each kind, and changes nothing."""

import re
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from engine.interchange.sources import read_recording
from tests.engine.interchange import test_sources as sources
from tests.engine.interchange.openscenario.read.files import simple
from tests.engine.road.opendrive.files import written
from tests.engine.road.opendrive.test_surfaces import HIGH, LOW

ELEMENT = '<cortexcTest a="1"><inner/></cortexcTest>'
NOTE = re.compile(r"not read: `([^`]+)` \(([\d,]+), (.+)\)")


def notes(path: Path) -> dict[str, str]:
    found = [NOTE.fullmatch(remark) for remark in read_recording(path).remarks]
    named = [match.group(1) for match in found if match]
    assert len(named) == len(set(named))
    return {match.group(1): f"{match.group(2)}, {match.group(3)}" for match in found if match}


@pytest.mark.parametrize("write", [sources.fcd, sources.commonroad, simple])
def test_an_unknown_element_anywhere_has_one_note(tmp_path: Path, write: Callable) -> None:
    """Put in behind every begin of an element that has contents; the recording stays what it was."""
    if write is simple:
        path = tmp_path / "case.xosc"
        path.write_text(simple())
    else:
        path = write(tmp_path)
    text, before = path.read_text(), notes(path)
    states = read_recording(path).recording.states
    begins = re.finditer(r"<(\w+)(?: [^<>]*[^/<>])?>\n?", text)
    for name, at in {match.group(1): match.end() for match in begins}.items():
        if name in ("x", "y", "exact", "length", "width", "orientation", "type", "role"):
            continue  # holds a text
        path.write_text(text[:at] + ELEMENT + text[at:])
        found = notes(path)
        line = text[:at].count("\n") + 1
        assert found == {**before, "cortexcTest": f"1, {path.name}, line {line}"}, name
        assert np.array_equal(read_recording(path).recording.states, states)


def test_simulators_logs_name_what_is_passed_over(tmp_path: Path) -> None:
    """Attributes, columns, lists of lines, fields of messages."""
    assert notes(sources.fcd(tmp_path))["vehicle.lane"] == "100, fcd.xml, line 2"
    assert notes(sources.esmini_log(tmp_path))["Wheel_Angle [deg]"] == "2, full_log.csv, line 2, column 6"
    assert notes(sources.carla_log(tmp_path))["State traffic lights"].startswith("50, recorder.txt, line ")
    trace = sources.osi(tmp_path)
    content = trace.read_bytes()
    size = int.from_bytes(content[:4], "little")
    light = bytes([7 << 3 | 2, 2, 1 << 3, 5])  # a traffic light, in the first message
    trace.write_bytes((size + len(light)).to_bytes(4, "little") + content[4 : 4 + size] + light + content[4 + size :])
    assert notes(trace)["traffic_light"] == "1, trace.osi, message 1"


def test_weather_of_a_scenario_is_named(tmp_path: Path) -> None:
    """Each part of an environment on its own."""
    environment = (
        '<GlobalAction><EnvironmentAction><Environment name="e"><Weather><Fog visualRange="50"/>'
        '<Precipitation precipitationType="rain"/></Weather><RoadCondition frictionScaleFactor="0.4"/></Environment>'
        "</EnvironmentAction></GlobalAction>"
    )
    path = tmp_path / "case.xosc"
    path.write_text(simple().replace("<Actions>", f"<Actions>{environment}", 1))
    assert {"Fog", "Precipitation", "RoadCondition"} <= notes(path).keys()


def test_attributes_of_a_scenario_that_change_a_run_are_named(tmp_path: Path) -> None:
    """Unless they are zero; heights have a remark of their own, where they differ by a level."""
    path = tmp_path / "case.xosc"
    path.write_text(re.sub(r"(<WorldPosition [^>]*?) ?/>", r'\1 z="0.3" p="0" r="-0.000e+00"/>', simple()))
    before = notes(path)
    assert not [name for name in before if name.startswith("WorldPosition")]
    assert "one plane" not in " ".join(read_recording(path).remarks)
    path.write_text(path.read_text().replace('z="0.3" p="0"', 'z="6.3" p="0.1"', 1))
    assert notes(path).keys() - before.keys() == {"WorldPosition.p"}
    assert "positions have heights from 0.3 to 6.3 m" in " ".join(read_recording(path).remarks)


def test_fields_of_moving_objects_are_named(tmp_path: Path) -> None:
    """An acceleration counts for each object of each message; a zero is no statement."""
    trace = sources.osi(tmp_path)
    before, content = notes(trace), trace.read_bytes()
    size = int.from_bytes(content[:4], "little")
    for value, said in ((1.5, {"moving_object.acceleration"}), (0.0, set())):
        acceleration = bytes([1 << 3 | 1]) + struct.pack("<d", value)
        base = bytes([5 << 3 | 2, len(acceleration)]) + acceleration
        thing = bytes([2 << 3 | 2, len(base)]) + base + bytes([1 << 3 | 2, 2, 1 << 3, 99])
        first = content[4 : 4 + size] + bytes([5 << 3 | 2, len(thing)]) + thing
        trace.write_bytes(len(first).to_bytes(4, "little") + first + content[4 + size :])
        assert notes(trace).keys() - before.keys() == said


@pytest.mark.parametrize("height", [0.0, 8.0])
def test_roads_of_a_recording_at_different_heights_are_named(tmp_path: Path, height: float) -> None:
    """All are judged in one plane, as positions have no heights."""
    written(tmp_path, LOW, HIGH if height else HIGH.replace('a="8.0"', 'a="0.0"')).rename(tmp_path / "road.xodr")
    network = '<RoadNetwork><LogicFile filepath="road.xodr"/></RoadNetwork>'
    (tmp_path / "case.xosc").write_text(simple(network=network))
    found = [remark for remark in read_recording(tmp_path / "case.xosc").remarks if "passes 8.0 m above" in remark]
    assert len(found) == (height > 0.0)
