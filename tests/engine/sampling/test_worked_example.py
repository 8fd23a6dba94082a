"""The scenario of the language's worked example, against rejection sampling written out in numpy."""

import numpy as np
import pytest
from scipy import stats

from engine.config import SimulationConfig
from engine.opcodes import Op
from engine.sampling import sample, uniform_genomes
from engine.streams import key_rows
from engine.vocabulary import Column, ManeuverType, Method, Verdict

WINDOW = 2.5
APPROACH = 50.0
LENGTH = 4.5
SCENES = 3000
SPEED = 1 / 3.6


def oncoming(lane):
    """The lane from which traffic comes towards `lane`."""
    straight = next(m for m in lane.maneuvers if m.type is ManeuverType.STRAIGHT)
    return straight.reverse_maneuvers[0].start_lane


def pose_and_window(path: str, draw: str, gene: str, at: int):
    """Rows that place a car at a drawn arc length and compare its distance to the junction with a gene."""
    t = [f"T{at + i}" for i in range(8)]
    rows = [
        (Op.MUL, t[0], draw, "L1"),
        (Op.PATH_POSE, t[1], path, t[0]),
        (Op.REGION_DISTANCE, t[4], "L0", t[1], t[2]),
        (Op.SUB, t[5], t[4], gene),
        (Op.ABS, t[6], t[5]),
        (Op.LE, t[7], t[6], "L2"),
    ]
    return rows, t[7]


@pytest.fixture(scope="module")
def program(network, assemble):
    """Scenario A: four variants of where the ego comes from; the draws are two arc lengths."""
    junction = network.intersections[0]
    lanes = junction.incoming_lanes
    return assemble(
        poses=[("T1", "T2", "T3"), ("T9", "T10", "T11")],
        literals=(junction.region, APPROACH, WINDOW),
        variants=[(lane.path, oncoming(lane).path) for lane in lanes],
        weights=(1, 1, 1, 1),
        genes=[(5, 58), (5, 80, SPEED), (0, 1), (5, 58), (5, 80, SPEED), (0, 20), (0, 5)],
        draws=2,
        checks=[pose_and_window("V0", "D0", "G0", 0), pose_and_window("V1", "D1", "G3", 8)],
    )


def run(program, ego: float, adversary: float, scenes: int = SCENES, **config):
    genomes = np.tile([ego, 40.0, 0.5, adversary, 40.0, 5.0, 1.0], (scenes, 1))
    return sample(program, genomes, key_rows(1, Method.SAMPLE, 0, 0, range(scenes)), SimulationConfig(**config))


def brute_force(ego: float, adversary: float, attempts: int = 600_000):
    """(accepted, 3): variant and both distances to the stop line, by rejection in numpy."""
    rng = np.random.default_rng(5)
    variant = rng.integers(0, 4, attempts)
    distance = APPROACH - APPROACH * rng.random((attempts, 2))
    windows = np.all(np.abs(distance - [ego, adversary]) <= WINDOW, axis=1)
    on_road = np.all(distance <= APPROACH - LENGTH / 2, axis=1)
    return np.column_stack([variant, distance])[windows & on_road]


@pytest.mark.parametrize(("ego", "adversary"), [(30.0, 20.0), (49.0, 5.0), (6.0, 47.0)])
def test_accepted_scenes_follow_the_law_of_rejection(program, ego, adversary):
    """Start distances and variants of accepted scenes are distributed as by brute force, also at the road's end."""
    scenes, expected = run(program, ego, adversary, max_attempts=20_000), brute_force(ego, adversary)
    assert scenes.valid.all()
    distances = APPROACH * (1.0 - scenes.draws)
    for column in range(2):
        assert stats.ks_2samp(distances[:, column], expected[:, column + 1]).pvalue > 0.001
    assert stats.chisquare(np.bincount(scenes.variant, minlength=4)).pvalue > 0.001
    assert stats.spearmanr(distances[:, 0], distances[:, 1]).pvalue > 0.001


def test_attempts_follow_the_acceptance_rate(program):
    """The number of attempts is geometric with the acceptance probability (5 m of 50 m, twice)."""
    attempts = run(program, 30.0, 20.0).attempts
    assert stats.ks_1samp(attempts / 100.0, stats.expon.cdf).statistic < 0.05


def test_scene_values_are_the_poses(program, network):
    """Scene values hold the poses that the draws of the accepted attempt lead to."""
    scenes = run(program, 30.0, 20.0, scenes=50)
    lanes = network.intersections[0].incoming_lanes
    for variant, draws, values in zip(scenes.variant, scenes.draws, scenes.values, strict=True):
        expected = network.paths.pose(lanes[variant].path, APPROACH * draws[0])
        np.testing.assert_allclose(values[[Column.X, Column.Y, Column.HEADING]], expected, atol=1e-12)


def test_out_of_reach_is_exhausted(program):
    """A start distance beyond the approach fails at its own requirement every time."""
    scenes = run(program, 53.0, 20.0, scenes=4, max_attempts=300)
    assert np.all(scenes.verdict == Verdict.EXHAUSTED)
    assert np.all(scenes.attempts == 300)
    assert np.all(scenes.tested[:, 0] == 300)
    assert np.all(scenes.failed[:, 0] == 300)
    assert scenes.tested[:, 1:].sum() == 0
    assert np.isnan(scenes.values).all()
    assert np.isnan(scenes.draws).all()
    assert np.all(scenes.variant == -1)


def test_share_of_invalid_genomes(program):
    """Uniform genomes are invalid in some 28.5 % of cases, nearly all decided by the genes."""
    keys = key_rows(2, Method.RANDOM, 0, 0, range(1500))
    genomes = uniform_genomes(program.space, keys)
    invalid = ~sample(program, genomes, keys).valid
    reachable = np.all(genomes[:, [0, 3]] <= APPROACH + WINDOW - LENGTH / 2, axis=1)
    assert 0.24 < invalid.mean() < 0.33
    assert np.all(invalid[~reachable])
    assert invalid[reachable].mean() < 0.03
