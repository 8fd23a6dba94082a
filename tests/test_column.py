"""Three cars in a column: how often the ego crashes, held against a reading of the same world on one line.

The ego and the second car brake at times that do not depend on the others, and nobody leaves the lane. So each run is
three points on a line, with impacts by restitution and momentum, and wheels that roll afterwards.
"""

from pathlib import Path

import numpy as np
import pytest

from cortex_dsl import Scenario, load
from engine import batch
from engine.sampling import sample, uniform_genomes
from engine.scenes import Scenes
from engine.search.probability.monte_carlo import estimate
from engine.streams import key_rows
from engine.tables import Floats
from engine.vehicles import CAR
from engine.vocabulary import Method

FINE, END, STEP = 1e-3, 12.0, 0.05
RESTITUTION, ROLLING = 0.15, 0.015 * 9.81


@pytest.fixture(scope="module")
def column() -> Scenario:
    return load(Path(__file__).parent / "agreement" / "column.scn")


@pytest.fixture(scope="module")
def scenes(column: Scenario) -> Scenes:
    """Four hundred starts."""
    keys = key_rows(3, Method.SAMPLE, 0, 0, range(400))
    return sample(column.program, uniform_genomes(column.program.space, keys), keys, column.config.simulation)


def on_a_line(speed: Floats, gap: Floats, headway: Floats, brake: Floats, reaction: Floats) -> tuple[Floats, Floats]:
    """Whether the ego crashes, and whether the other two do so before, by steps of a millisecond."""
    place = np.stack([np.zeros_like(gap), headway + 4.6, headway + gap + 9.2])
    velocity = np.tile(speed, (3, 1))
    late = np.ceil(np.round(reaction / STEP, 9)) * STEP
    starts = np.stack([1.0 + np.ceil(np.round(2.0 * reaction / STEP, 9)) * STEP, 1.0 + late, np.full_like(gap, 1.0)])
    pedal = np.stack([np.full_like(gap, 0.8), np.full_like(gap, 0.8), brake]) * CAR.max_braking
    loose = np.zeros((3, len(gap)), dtype=bool)
    crashed, others = np.zeros(len(gap), dtype=bool), np.zeros(len(gap), dtype=bool)
    for k in range(round(END / FINE)):
        slower = np.where(loose, ROLLING, np.where(k * FINE >= starts - 1e-9, pedal, 0.0)) * FINE
        after = np.maximum(0.0, velocity - slower)
        place += 0.5 * FINE * (velocity + after)
        velocity = after
        crashed |= (place[1] - place[0] <= CAR.length) & (velocity[0] > velocity[1])
        hit = (place[2] - place[1] <= CAR.length) & (velocity[1] > velocity[2]) & ~crashed
        others |= hit
        mean, half = 0.5 * (velocity[1] + velocity[2]), 0.5 * RESTITUTION * (velocity[1] - velocity[2])
        velocity[1], velocity[2] = np.where(hit, mean - half, velocity[1]), np.where(hit, mean + half, velocity[2])
        loose[1:] |= hit
    return crashed, others


def in_si(genomes: Floats) -> Floats:
    """Speed, gap, headway, pedal and reaction, a row each."""
    return (genomes * [1 / 3.6, 1.0, 1.0, 1.0, 1.0]).T


def test_the_ego_crashes_as_often_as_on_the_line(column: Scenario, scenes: Scenes) -> None:
    """The same runs but for a few that only just touch; in a good part of them the others crash first."""
    crashed, others = on_a_line(*in_si(scenes.genomes))
    outcomes = batch.simulate(column.program, scenes, column.config.simulation)
    first = np.isfinite(outcomes.others_contact_time)
    assert np.mean(outcomes.collided != crashed) <= 0.01
    assert np.mean(first != others) <= 0.01
    assert 0.5 < outcomes.collided.mean() < 0.7
    assert (first & outcomes.collided).mean() > 0.1


def test_the_probability_covers_it(column: Scenario) -> None:
    """The interval of a thousand runs holds the share of twenty thousand on the line."""
    space, random = column.program.space, np.random.default_rng(7)
    share = on_a_line(*in_si(random.uniform(space.low, space.high, (20_000, len(space.low)))))[0].mean()
    found = estimate(column.program, column.config, "mc", 1_000, seed=5)
    assert found.interval[0] < share < found.interval[1]
    assert found.without_ego > 300
