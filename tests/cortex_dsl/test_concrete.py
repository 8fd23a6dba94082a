"""A concrete copy of a scene compiles to the same scene and runs to the same outcome, bit for bit."""

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from cortex_dsl.session import Scenario, compile_text, load
from engine.sampling import sample
from engine.scenes import Outcomes

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.scn"))

EVERYTHING_RANDOM = """
map intersection(lanes=2)
param SPEED = Range(5, 80) km/h
param LANES = DiscreteRange(0, 2)
param MANNER = Uniform('calm', 'hasty')
slip = Normal(0, 2) deg
lanes = [Uniform(*intersection.incomingLanes) for i in range(2)]
weights = [Range(1, 2) t for i in range(3)]

behavior Wobble():
    while True:
        take SetSteerAction(Range(-1, 1) deg), SetThrottleAction(0.2)

ego = new Car in lanes[0].centerline, with speed SPEED, with mass weights[0], with behavior Wobble()
truck = new Truck in lanes[1].centerline, facing slip, with mass 2 * weights[2], with behavior Wobble()
walker = new Pedestrian on road, with behavior ConstantSpeedBehavior(1.4 m/s if MANNER == 'calm' else 3 m/s)
require[0.5] (distance from ego to truck) > 20 m
require LANES >= 1
terminate after 4 s
"""


def _outcome(scenario: Scenario, genomes: np.ndarray, keys: np.ndarray) -> Outcomes:
    return scenario.simulate(sample(scenario.program, genomes, keys, scenario.config.simulation))


def _assert_copies_agree(scenario: Scenario, count: int) -> None:
    scenes = scenario.sample(count, seed=5)
    outcomes = scenario.simulate(scenes)
    rows = np.flatnonzero(scenes.valid)
    assert len(rows) > count // 4
    for row in rows:
        copy = compile_text(scenario.concrete(scenes, int(row), remark="a case\nof two lines"))
        again = _outcome(copy, np.zeros((1, 0)), scenes.keys[row : row + 1])
        for field in fields(Outcomes):
            np.testing.assert_array_equal(
                getattr(outcomes, field.name)[row : row + 1], getattr(again, field.name), err_msg=field.name
            )


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_are_reproduced_bit_for_bit(path: Path) -> None:
    """Lanes, maneuvers, places and genes of a drawn scene all come back."""
    _assert_copies_agree(load(path), 12)


def test_every_kind_of_randomness_is_reproduced() -> None:
    """Discrete genes, repeated sites, soft requirements and random numbers inside behaviours."""
    _assert_copies_agree(compile_text(EVERYTHING_RANDOM), 12)


def test_constants_of_the_command_line_stay_in_the_copy() -> None:
    """`-p` values are written into the copy."""
    scenario = load(EXAMPLES[0], EGO_SPEED="33 km/h")
    text = scenario.concrete(scenario.sample(20, seed=1), int(np.flatnonzero(scenario.sample(20, seed=1).valid)[0]))
    assert "param EGO_SPEED     = 33 km/h" in text


def test_comments_of_the_author_stay() -> None:
    """Only random values are replaced."""
    scenario = compile_text("map intersection()\n# mind this\nego = new Car in road  # here\n")
    scenes = scenario.sample(50)
    text = scenario.concrete(scenes, int(np.flatnonzero(scenes.valid)[0]))
    assert "# mind this" in text
    assert "# here" in text
