"""No driver of the library drives faster than it wants to."""

import numpy as np
import pytest

import cortex_dsl as cx
from cortex_dsl.semantics.acting.behaviours import LIBRARY
from cortex_dsl.semantics.names.builtins import BUILTINS
from engine.batch import trajectory
from engine.vocabulary import State, Verdict
from tests.laws import share
from tests.test_symmetry import ON_FOOT, View, call, text

SCENES = share(200)
ROUNDING = 1e-9
"""Excess over a target speed that is a rounding error [m/s]."""
INSIDE = "behavior"
"""Parameter of a driver that runs another one."""


def speed_of(name: str) -> str | None:
    """Return the parameter for the speed that a behavior holds or reaches; None without one."""
    names = [each.name for each in BUILTINS[name].parameters]
    return next((each for each in ("target_speed", "speed") if each in names), None)


DRIVERS = [name for name in LIBRARY if speed_of(name) or INSIDE in {each.name for each in BUILTINS[name].parameters}]


def source_of(name: str) -> str:
    """Return the encounters of `test_symmetry` with a driver whose target and first speed vary."""
    view, parameter = View(), speed_of(name)
    drives = call(name, view, "mine", "other", "TARGET", {parameter: "TARGET"} if parameter else {})
    source = text(name, view)
    usual = call(name, view, "mine", "other", "11.0 m/s", {"speed": "1.5 m/s"} if name in ON_FOOT else {})
    assert source.count(usual) == 1
    varied = source.replace(usual, drives).replace(
        "with speed 11.0 m/s, with behavior", "with speed FIRST, with behavior"
    )
    return f"param TARGET = Range(1, 16) m/s\nparam FIRST = Range(0, 16) m/s\n{varied}"


@pytest.mark.parametrize("name", DRIVERS)
def test_a_driver_never_exceeds_its_target_speed(name: str) -> None:
    """In encounters with three cars no speed is above the greater of the target and the first speed."""
    scenario = cx.compile_text(source_of(name))
    program, scenes = scenario.program, scenario.sample(SCENES, seed=8)
    assert (scenes.verdict == Verdict.VALID).all()
    wanted = scenes.genomes[:, program.space.names.index("TARGET")]
    actor = program.actors.index(View().names.askew if name in ON_FOOT else "ego")
    for row, target in enumerate(wanted.tolist()):
        speed = trajectory(program, scenes, row, scenario.config.simulation).states[:, actor, State.SPEED]
        assert speed.max() <= max(target, speed[0]) + ROUNDING, f"scene {row}"
        assert np.isfinite(speed).all()
