"""Warnings of drivers: who gives them, what a file reads of them, and a person who brakes after one."""

import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cortex_dsl as cx
from cortex_dsl import compile_text
from cortex_dsl.diagnostics import CompileError
from engine import batch
from engine.errors import ControllerError
from engine.tables import Floats
from engine.vocabulary import State

from .laws import examples

SCENE = """
map road(lanes=1, length=1000 m)
ego = new Car at (-300, -1.75), facing 0 deg, with speed {speed} m/s, with drag 0 m/s^2, with behavior {behavior}
lead = new Car ahead of ego by {gap} m, facing 0 deg
{reads}
terminate after 12 s
"""
READS = """record ego.timeSinceWarning as "since"
record ego.warningTTC as "ttc"
record ego.isWarning as "warns"
"""
EXTERNAL = "ExternalBehavior(trajectory=[network.lanes[0]])"


def states(scenario: cx.Scenario) -> Floats:
    """Return (samples, columns) the states of the ego in the only scene."""
    scenes = scenario.sample(1, seed=1)
    return batch.trajectory(scenario.program, scenes, 0, scenario.config.simulation).states[:, 0]


def records(scenario: cx.Scenario) -> list[Floats]:
    """Return what the only scene records over time."""
    scenes = scenario.sample(1, seed=1)
    return [np.asarray(each.values) for each in scenario.watch(scenes, 0).records]


@examples(20)
@given(st.floats(8.0, 30.0), st.floats(0.5, 4.0), st.floats(0.3, 6.0), st.floats(0.0, 1.5))
def test_a_person_brakes_after_the_warning(speed: float, ttc: float, braking: float, delay: float) -> None:
    """The first warning is at that time to collision, and the deceleration begins that much later."""
    driver = f"EmergencyBrakeBehavior(FollowLaneBehavior({speed} m/s), max_speed=0 m/s, warning_ttc={ttc} s)"
    person = f"ManualBrakeBehavior({driver}, deceleration={braking} m/s^2, delay={delay} s)"
    gap = speed * (ttc + 1.0)
    scenario = compile_text(SCENE.format(speed=speed, behavior=person, gap=gap, reads=READS))
    since, told, warns = records(scenario)
    run, step = states(scenario), scenario.config.simulation.time_step
    began = int(np.flatnonzero(warns)[0])
    assert began * step == pytest.approx(1.0 + step, abs=1.5 * step)
    assert told[began] == pytest.approx(ttc, abs=2.0 * step)
    assert (told[began:] == told[began]).all()
    assert (since[:began] == -1.0).all()
    assert np.diff(since[began:]) == pytest.approx(step)
    slower = np.flatnonzero(run[:, State.SPEED] < speed - 1e-6)
    if len(slower):  # else the contact came first
        assert slower[0] - began == pytest.approx(delay / step + 0.5, abs=2.0)


def plain(observations: Floats) -> Floats:
    """Return a driver's usual actions: it rolls."""
    return np.zeros((len(observations), 3))


class Warner:
    """A driver with its own column, which warns from a time on."""

    def __init__(self, first: int) -> None:
        self.first, self.asked = first, 0

    def reset(self, lanes: Floats, keys: Floats) -> None:
        """Begin anew."""
        del lanes, keys
        self.asked = 0

    def act(self, observations: Floats, active: Floats) -> Floats:
        """Return actions."""
        del active
        self.asked += 1
        return np.column_stack([plain(observations), np.full(len(observations), float(self.asked > self.first))])


def test_a_driver_without_the_column_drives_as_if_nothing_were_read() -> None:
    """Files that read warnings change nothing for drivers that give none; they never warn."""
    texts = [SCENE.format(speed=15, behavior=EXTERNAL, gap=80, reads=reads) for reads in ("", READS)]
    without, reading = (compile_text(text).driven_by(plain) for text in texts)
    assert np.array_equal(states(without), states(reading))
    since, told, warns = records(reading)
    assert (since == -1.0).all()
    assert not told.any()
    assert not warns.any()
    assert without.sample(1).actions.shape[-1] == 3


@pytest.mark.parametrize("first", [0, 20, 55])
def test_a_driver_warns_by_its_column(first: int) -> None:
    """From the step on in which it does, and a person brakes by at least as much as the driver."""
    person = f"ManualBrakeBehavior({EXTERNAL}, deceleration=2 m/s^2, delay=0.5 s)"
    scenario = compile_text(SCENE.format(speed=15, behavior=person, gap=80, reads=READS)).driven_by(Warner(first))
    since, _, _ = records(scenario)
    step = scenario.config.simulation.time_step
    assert int(np.flatnonzero(since >= 0.0)[0]) == pytest.approx(first, abs=1)
    speeds = states(scenario)[:, State.SPEED]
    late = first + round(0.5 / step) + 4
    assert speeds[late] - speeds[late + 10] == pytest.approx(2.0 * 10 * step, rel=0.02)
    assert speeds[first] == pytest.approx(15.0, rel=1e-3)


def test_a_warning_out_of_its_range_is_refused() -> None:
    scenario = compile_text(SCENE.format(speed=15, behavior=EXTERNAL, gap=80, reads=READS))
    with pytest.raises(ControllerError, match="warning = 2"):
        scenario.driven_by(lambda seen: np.tile([0.0, 0.0, 0.0, 2.0], (len(seen), 1))).sample(1)
    with pytest.raises(ControllerError, match="shape"):
        scenario.driven_by(lambda seen: np.zeros((len(seen), 5))).sample(1)


STACK = """
import json, os
import numpy as np
read = os.fdopen(int(os.environ["CORTEXC_READ"]), "rb")
write = os.fdopen(int(os.environ["CORTEXC_WRITE"]), "wb")
header = json.loads(read.readline())
n, wide = header["lanes"], len(header["observations"])
assert header["warning"] is True and len(header["actions"]) == 3
write.write(b'ANSWER\\n')
write.flush()
while read.read(8 + 8 * n + 48 * n + 2 * n):
    read.read(8 * n * wide)
    write.write(np.tile(ACTIONS, (n, 1)).astype("<f8").tobytes())
    write.flush()
"""


@pytest.mark.parametrize(
    ("answer", "actions", "warns"),
    [
        ('{"version": 1}', [0.0, 0.0, 0.0], False),
        ('{"version": 1, "warning": true}', [0.0, 0.0, 0.0, 1.0], True),
        ('{"version": 1, "warning": true}', [0.0, 0.0, 0.0, 0.0], False),
    ],
)
def test_a_process_says_whether_it_warns(tmp_path: Path, answer: str, actions: list[float], warns: bool) -> None:
    """An old one is not asked for more than it gives."""
    stack = tmp_path / "stack.py"
    stack.write_text(STACK.replace("ANSWER", answer).replace("ACTIONS", str(actions)), encoding="utf-8")
    scenario = compile_text(SCENE.format(speed=15, behavior=EXTERNAL, gap=80, reads=READS))
    since, _, _ = records(scenario.driven_by(f"process:{sys.executable} {stack}"))
    assert (since >= 0.0).any() == warns


def test_warnings_are_known_only_while_the_scene_runs() -> None:
    text = SCENE.format(speed=15, behavior=EXTERNAL, gap=80, reads="require ego.warningTTC < 3 s")
    with pytest.raises(CompileError, match="SCN609"):
        compile_text(text)
