"""A whole file: as it was read by a person, what is said of it, and what cannot be written.

`UPDATE_GOLDEN=1 pytest` on this file writes `small.xosc`, to be read before it is kept.
"""

import os
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from engine.errors import InterchangeError
from engine.interchange.contract import ExportOptions
from engine.interchange.openscenario import write, write_trajectories
from engine.interchange.recording import Contact, Recording, SignalTimes
from engine.maps import RoadSpec
from engine.vocabulary import State
from engine.xml import Limits
from tests.engine.interchange.openscenario.conftest import (
    ROAD,
    actor,
    polyline,
    recording,
    scenario,
    small,
    with_lights,
)

GOLDEN = Path(__file__).with_name("small.xosc")


def remarks(of: Recording, version: str = "1.2", road_file: str | None = ROAD) -> str:
    return "\n".join(write_trajectories(of, "case", ExportOptions(osc=version), road_file).remarks)


def test_a_small_recording_is_written_as_it_was_read() -> None:
    """A car, a bus, a walker who comes and goes, a box and lights that begin in the middle of a phase."""
    export = write_trajectories(with_lights(offset=4.0), "small", ExportOptions(), ROAD)
    assert list(export.files) == [GOLDEN.name]
    text = export.files[GOLDEN.name]
    assert isinstance(text, str)
    if os.environ.get("UPDATE_GOLDEN"):
        GOLDEN.write_text(text, encoding="utf-8")
    assert text == GOLDEN.read_text(encoding="utf-8")


def test_what_the_format_has_no_place_for_is_said() -> None:
    """Speeds and pedals, a changed name, what follows contact."""
    said = remarks(small())
    assert "cortexc.*" in said
    assert "steering" in said
    assert "`bus 12` is called `bus_12`" in said
    assert "first contact at 0.120 s" in said
    assert "light" not in said


def test_what_was_not_recorded_is_not_said_to_stand_there() -> None:
    """A motion from elsewhere has no wheel and pedals, in the file as in its remark."""
    of = replace(small(), commands=False)
    assert "steering" not in remarks(of)
    assert "pedals" not in remarks(of)
    names = {each.get("name") for each in scenario(of).iter("Property")}
    assert {"cortexc.speed", "cortexc.acceleration"} <= names
    assert not names & {"cortexc.steer", "cortexc.throttle", "cortexc.brake"}


def test_who_never_comes_in_is_not_in_the_file() -> None:
    """Nothing could say where it is; contact counts those who are there."""
    ways = [[(0, 0, 0)] * 2, [None] * 2, [(9, 0, 0), (8, 0, 0)]]
    of = recording([actor("ego"), actor("away"), actor("other")], [0.0, 0.05], ways)
    root = scenario(replace(of, contact=Contact(0.05, (0, 2))))
    assert [each.get("name") for each in root.iter("ScenarioObject")] == ["ego", "other"]
    assert "away" not in {each.get("entityRef") for each in root.iter()}
    contact = root.find(".//ParameterDeclaration[@name='cortexc_contact_actors']").get("value")
    assert contact == "0 1"


def test_readers_of_the_first_version_are_warned() -> None:
    """ScenarioRunner knows no actor that comes later."""
    assert "walker" in remarks(small(), "1.0")
    assert "walker" not in remarks(small(), "1.2")


def test_users_of_esmini_are_warned_of_its_filter() -> None:
    """It drops what lies close together; where nothing does, there is nothing to say."""
    fast, slow = ([(0.0, 0, 0), (way, 0, 0)] for way in (0.2, 0.05))
    assert "--traj_filter 0" in remarks(recording([actor("car")], [0.0, 0.05], [slow]))
    assert "--traj_filter 0" not in remarks(recording([actor("car")], [0.0, 0.05], [fast]))
    assert "--traj_filter 0" not in remarks(recording([actor("car")], [0.0], [slow[:1]]))


def test_lights_that_cannot_be_written_are_said() -> None:
    """Without a road there is no place for them; a plan that the scenario changes is only a plan."""
    assert "no road is named" in remarks(with_lights(), road_file=None)
    assert "traffic lights are left out" in remarks(with_lights(), road_file=None)
    assert "traffic lights are left out" in remarks(replace(with_lights(), road=None))
    changed = with_lights()
    assert changed.signals is not None
    assert "fixed plan alone" in remarks(replace(changed, signals=replace(changed.signals, controlled=True)))
    assert "light" not in remarks(with_lights())


def test_a_recording_that_begins_later_begins_at_zero() -> None:
    """A scenario's time does; contact and all samples move with it."""
    late = recording([actor("a"), actor("b")], [5.0, 5.05], [[(0, 0, 0), (1, 0, 0)], [(9, 0, 0), (8, 0, 0)]])
    late = replace(late, contact=Contact(5.05, (0, 1)), road=RoadSpec(), signals=SignalTimes(10.0, 3.0, 1.0, 2.0))
    root = scenario(late)
    assert polyline(root.find(".//Polyline")).times == pytest.approx([0.0, 0.05])
    contact = root.find(".//ParameterDeclaration[@name='cortexc_contact_time']").get("value")
    assert float(contact) == pytest.approx(0.05)
    green = root.find(".//TrafficSignalController/Phase[@name='green']")
    assert float(green.get("duration")) == pytest.approx(10.0 - 2.0 - 5.0)
    assert "5 s less" in remarks(late)


def test_an_empty_recording_is_refused() -> None:
    """No samples or no actors."""
    nobody = recording([], [0.0], [])
    never = recording([actor("car")], [], [[]])
    for empty in (nobody, never):
        with pytest.raises(InterchangeError, match="no actor at any time"):
            write_trajectories(empty, "case", ExportOptions(), ROAD)


def test_a_broken_state_is_refused() -> None:
    """NaN is refused with actor and time; samples at which an actor is absent are not checked."""
    broken = small()
    broken.states[0, 2] = np.nan
    broken.states[0, 2, State.PRESENT] = 0.0
    write_trajectories(broken, "case", ExportOptions(), ROAD)
    broken.states[2, 1, State.X] = np.nan
    with pytest.raises(InterchangeError, match=r"`bus 12` has no finite state at 0\.1 s"):
        write_trajectories(broken, "case", ExportOptions(), ROAD)


def test_a_name_that_xml_cannot_hold_is_refused() -> None:
    """Control characters in a text."""
    with pytest.raises(InterchangeError, match="character"):
        write_trajectories(recording([actor("a\x01")], [0.0], [[(0, 0, 0)]]), "case", ExportOptions(), ROAD)


def test_a_file_that_is_larger_than_import_takes_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    """With its size and the limits."""
    assert "refuses" not in remarks(small())
    monkeypatch.setattr(write, "LIMITS", Limits(elements=100))
    assert re.search(r"`cortexc import` refuses a file of 4 actors, \d+ elements, 0 MB", remarks(small()))
