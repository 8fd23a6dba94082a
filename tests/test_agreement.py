"""The two hosts agree on every example: states before contact within 1e-9 m, contact always. (The full run of ten
thousand scenes is `python -m benchmarks.agreement`.)
"""

from pathlib import Path

import numpy as np
import pytest

from benchmarks import limit
from benchmarks.agreement import CONSTRUCTS, TOLERANCE, compare
from cortex_dsl import compile_text, load
from tests.laws import share

FOLDER = Path(__file__).parents[1] / "examples"
EXAMPLES = sorted([*FOLDER.glob("*.scn"), *FOLDER.glob("roads/*.scn")])
SCENES = share(60)

CROWD = """
map intersection(ways=4, lanes=2, rows=1, cols=2, block=90 m, left_hand=True)
param SPEED = Range(20, 70) km/h
ego = new Car on road, with speed SPEED, with behavior FollowLaneBehavior(SPEED)
truck = new Truck on road, with speed SPEED, with behavior FollowLaneBehavior(30 km/h)
rider = new Motorcycle on road, with speed 10 m/s, with behavior FollowLaneBehavior(15 m/s)
bike = new Bicycle on road, with speed 4 m/s, with behavior ConstantSpeedBehavior(4 m/s)
walker = new Pedestrian on road, with speed 1 m/s, with behavior ConstantSpeedBehavior(1.5 m/s)
crate = new Obstacle on road
terminate after 6 s
"""


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_hosts_agree_on_the_examples(path: Path) -> None:
    """Random scenes of each, collisions among them."""
    scenario, count = load(path), max(60, SCENES)
    found = compare(scenario, count)
    if not found.collisions:  # a file of rare ones
        found = compare(scenario, count := 10 * count)
    assert found.scenes == count
    assert found.collisions > 0
    assert found.flags_differ == 0
    assert found.states_differ <= TOLERANCE
    assert found.metrics_differ <= TOLERANCE


def test_hosts_agree_on_a_crowd_of_every_kind() -> None:
    """Six actors of six kinds on a grid with left-hand traffic."""
    found = compare(compile_text(CROWD), SCENES)
    assert found.collisions > 0
    assert found.flags_differ == 0
    assert found.states_differ <= TOLERANCE
    assert found.metrics_differ <= TOLERANCE


def test_every_construct_has_a_scenario() -> None:
    """Nothing is left out of the comparison."""
    assert {path.stem for path in CONSTRUCTS} >= {
        "guards", "library", "modular", "monitors", "picks", "signals", "temporal",
    }  # fmt: skip


@pytest.mark.parametrize("path", CONSTRUCTS, ids=lambda path: path.stem)
def test_hosts_agree_on_every_construct(path: Path) -> None:
    """Verdicts, ends and their rules, states, records and metrics; several ends occur."""
    found = compare(load(path), SCENES)
    assert found.scenes == SCENES
    assert found.ends > 1 or path.stem == "pile"  # where nobody gets through
    assert found.aborted > 0 or path.stem not in ("guards", "modular", "monitors", "picks", "temporal")
    assert found.flags_differ == 0
    assert found.states_differ <= TOLERANCE
    assert found.metrics_differ <= TOLERANCE


def test_the_hand_written_limit_is_the_same_simulation() -> None:
    """The benchmark's yardstick gives the outcomes of the batch host, bit for bit."""
    scenario = load(next(path for path in EXAMPLES if path.stem == "left_turn"))
    scenes = scenario.sample(300, seed=11)
    by_hand = limit.simulate(scenario.program, limit.inputs(scenario.program, scenes), scenario.config.simulation)
    outcomes = scenario.simulate(scenes)
    np.testing.assert_array_equal(by_hand.collided, outcomes.collided[scenes.valid])
    np.testing.assert_array_equal(by_hand.end_time, outcomes.end_time[scenes.valid])
    np.testing.assert_array_equal(by_hand.metrics[:, 0], outcomes.min_distance[scenes.valid, 0])
    np.testing.assert_array_equal(by_hand.metrics[:, 3], outcomes.ttc_at_ms[scenes.valid, 0])
