"""What a replay shows after contact: outlines overlap there, and nothing before it is another."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from engine.errors import InterchangeError
from engine.interchange.after_contact import ONWARD, shown_after_contact, up_to_contact
from engine.interchange.contract import AFTER_CONTACT, ExportOptions
from engine.interchange.measuring import measure
from engine.interchange.openscenario import write_trajectories
from engine.interchange.openscenario.read import read_openscenario
from engine.interchange.recording import Contact, Recording
from engine.vocabulary import State
from tests.engine.interchange.commonroad.recordings import actor
from tests.engine.interchange.openscenario.conftest import recording

GAP = 3.0
SPEED = 10.0
TOUCH = GAP / SPEED


def crash(step: float = 0.05) -> Recording:
    """The ego drives into the rear of a standing car after 0.3 s, bounces off, and stands."""
    one, other = actor("ego"), actor("other")
    far = GAP + (one.length + other.length) / 2
    time = sorted({*np.round(np.arange(0.0, 0.8, step), 9), TOUCH})
    ways = [[(min(SPEED * t, GAP), 0.0, 0.0) for t in time], [(far + max(0.0, t - TOUCH), 0.0, 0.0) for t in time]]
    made = recording([one, other], time, ways)
    made.states[:, 0, State.SPEED] = [SPEED if t <= TOUCH else 0.0 for t in time]
    return replace(made, contact=Contact(TOUCH, (0, 1)))


@pytest.mark.parametrize("step", [0.05, 0.07])
@pytest.mark.parametrize("after", ["through", "stop"])
def test_outlines_overlap_after_contact_and_not_before(after: str, step: float) -> None:
    made = crash(step)
    shown = shown_after_contact(made, after)
    scored = made.scored_samples()
    assert (shown.states[:scored] == made.states[:scored]).all()
    assert (np.diff(shown.time) > 0.0).all()
    gap = (
        shown.states[:, 1, State.X] - shown.states[:, 0, State.X] - (made.actors[0].length + made.actors[1].length) / 2
    )
    assert (gap[:scored] >= -1e-12).all()
    assert (gap[scored:] < -1e-3).all()
    if after == "through":
        assert shown.time[-1] == pytest.approx(TOUCH + ONWARD, abs=step)
        assert shown.states[-1, 0, State.X] == pytest.approx(SPEED * shown.time[-1])
    else:
        assert (shown.states[scored:] == shown.states[-1]).all()
        assert shown.states[-1, 0, State.SPEED] == 0.0


def test_physics_and_no_contact_leave_it_as_it_is() -> None:
    made = crash()
    assert shown_after_contact(made, "physics") is made
    quiet = replace(made, contact=None)
    assert all(shown_after_contact(quiet, after) is quiet for after in AFTER_CONTACT)


def test_contact_of_the_first_two_samples() -> None:
    """Nothing is known of a way before: speed and heading say it."""
    made = crash()
    late = up_to_contact(replace(made, time=made.time[:2], states=made.states[5:7], contact=Contact(0.0, (0, 1))), 0.0)
    shown = shown_after_contact(late, "through")
    assert shown.states[-1, 0, State.X] > late.states[0, 0, State.X] + 5.0


@pytest.mark.parametrize("after", AFTER_CONTACT)
def test_measures_pass_over_what_follows(after: str, tmp_path: Path) -> None:
    """The same contact and the same numbers, whatever a file shows after it; what was no motion does not come back."""
    shown = shown_after_contact(crash(), after)
    (text,) = write_trajectories(shown, "case", ExportOptions(after_contact=after), None).files.values()
    (tmp_path / "case.xosc").write_text(str(text), encoding="utf-8")
    read = read_openscenario(tmp_path / "case.xosc")
    assert ('name="cortexc_after_contact"' in str(text)) == (after != "physics")
    assert any("passed over" in remark for remark in read.remarks) == (after != "physics")
    assert (read.recording.time[-1] <= TOUCH + 0.05 + 1e-9) == (after != "physics")
    outcomes = measure(read.recording).outcomes
    assert outcomes.collided[0]
    assert outcomes.end_time[0] == pytest.approx(TOUCH, abs=1e-6)


@pytest.mark.parametrize("how", [{"after_contact": "bounce"}, {"mode": "maneuver", "after_contact": "stop"}])
def test_what_makes_no_sense_is_refused(how: dict[str, str]) -> None:
    with pytest.raises(InterchangeError):
        ExportOptions(**how)  # type: ignore[arg-type]
