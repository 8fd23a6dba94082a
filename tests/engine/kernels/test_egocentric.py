"""What a driver observes where the file says nothing else, of scenes that are placed by hand."""

import math

import numpy as np
import pytest

import cortex_dsl as cx
from engine.environment import Environment
from engine.tables import SLIDING
from engine.vocabulary import State

TO_CENTER, TIME_STEP = 1.423, 0.05
PLACED = """
map intersection(approach=100 m)
lane = intersection.incomingLanes[0]
ego = new Car before intersection by 60 m along [lane], with speed 10 m/s, with behavior ExternalBehavior()
other = new Car at ego offset by (-3, 20), facing 90 deg relative to ego, with speed 4 m/s, with regionContainedIn None
terminate after 5 s
"""
STRUCK = """
map intersection(approach=100 m)
lane = intersection.incomingLanes[0]
ego = new Car before intersection by 90 m along [lane], with speed 0 m/s, with behavior ExternalBehavior()
one = new Car at ego offset by (0, 30), facing 90 deg relative to ego, with speed 0 m/s, with regionContainedIn None
two = new Car at ego offset by (-1, 12), facing ego.heading, with speed 15 m/s, with regionContainedIn None
terminate after 5 s
"""


def observed(text: str) -> tuple[Environment, list[str]]:
    environment = cx.compile_text(text).environment(1)
    return environment, [name for name, _ in environment.observations]


def test_everything_is_in_the_frame_of_the_actor() -> None:
    """The path goes straight on; the other is 20 m ahead, 3 m to the left, and drives to the left."""
    environment, names = observed(PLACED)
    seen = dict(zip(names, environment.reset(seed=1)[0], strict=True))
    for away in (5, 10, 15, 20, 30, 40):
        assert seen[f"path {away} m ahead: x"] == pytest.approx(away - TO_CENTER)
        assert seen[f"path {away} m ahead: y"] == pytest.approx(0.0, abs=1e-9)
    assert seen["path left"] > 60.0
    own = {"speed": 10.0, "acceleration": 0.0, "steer": 0.0, "path offset": 0.0, "path heading": 0.0}
    other = {"seen": 1.0, "x": 20.0, "y": 3.0, "heading": math.pi / 2.0, "vx": -10.0, "vy": 4.0}
    for name, value in (own | {f"nearest 1: {key}": value for key, value in other.items()}).items():
        assert seen[name] == pytest.approx(value, abs=1e-9), name
    assert seen["nearest 2: seen"] == 0.0


def test_of_a_body_that_slides_the_velocity_is_that_of_its_centre() -> None:
    """A car that is struck from the side moves across its own heading: between two samples by what was seen at both."""
    environment, names = observed(STRUCK)
    environment.reset(seed=1)
    columns = [names.index(f"nearest 2: {name}") for name in ("x", "vx", "y", "vy")]
    seen = np.array([environment.step([[0.0, 1.0, 0.0]]).observations[0, columns] for _ in range(28)])[-8:]
    assert (environment.episodes.runs.states[0, 1:, State.PRESENT] == SLIDING).all()
    for place, rate in (seen[:, :2].T, seen[:, 2:].T):
        np.testing.assert_allclose(np.diff(place) / TIME_STEP, 0.5 * (rate[1:] + rate[:-1]), atol=0.02)
    assert seen[0, 1] > 7.0
