"""Fair starts: where braking at once would not help the ego, a scene is drawn again."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cortex_dsl import Scenario, compile_text
from cortex_dsl.diagnostics import CompileError
from engine.acceptance import account, measure_acceptance
from engine.avoidability import R157
from engine.config import SimulationConfig
from engine.fairness import MOST, fair_starts
from engine.host import requested
from engine.kernels.rows import Requested
from engine.program import Program
from engine.sampling import FREE_ATTEMPTS, draw_genomes, sample
from engine.streams import key_rows
from engine.tables import Bools
from engine.vocabulary import Method, Verdict

HEAD = "map intersection(approach=60 m)\n"
FAIR = "terminate after 6 s\nsimulation(fair=True)\n"
DRIVES = "with behavior FollowLaneBehavior(target_speed=15 m/s)"


def compiled(text: str, fair: str = FAIR) -> Scenario:
    return compile_text(HEAD + text + fair, "fair.scn")


def stopping_distance(speed: float) -> float:
    """Of the driver whose brakes build up steadily over the ramp."""
    braking, ramp = R157.deceleration, R157.ramp
    left = speed - 0.5 * braking * ramp
    return speed * ramp - braking * ramp**2 / 6.0 + left**2 / (2.0 * braking)


def test_before_a_wall_the_fair_distance_is_that_of_stopping() -> None:
    """A closed form: gaps that are longer than the way to stop are fair, no others."""
    scenario = compiled(
        f"param GAP = Range(5, 40) m\nego = new Car at (1.75, -55), facing 90 deg, with speed 15 m/s, {DRIVES}\n"
        "other = new Car ahead of ego by GAP\n"
    )
    scenes = scenario.sample(300)
    gap = scenes.genomes[:, 0]
    assert scenes.valid[gap > stopping_distance(15.0) + 0.05].all()
    assert not scenes.valid[gap < stopping_distance(15.0) - 0.05].any()
    assert (scenes.verdict[~scenes.valid] == Verdict.EXHAUSTED).all()
    assert (scenes.tested[~scenes.valid, -1] == MOST).all()
    assert np.isnan(scenes.values[~scenes.valid]).all()


@pytest.mark.parametrize(
    "others",
    [
        "other = new Car behind ego by 1 m, with speed 40 m/s, with behavior ConstantSpeedBehavior(40 m/s)\n",
        "other = new Car left of ego by 0.5 m, with speed 15 m/s, with behavior ConstantSpeedBehavior(15 m/s)\n",
    ],
    ids=["struck from behind", "beside"],
)
def test_who_comes_from_behind_or_stays_beside_makes_no_start_unfair(others: str) -> None:
    """The ego that brakes is struck, or left behind: nothing that it could have done better."""
    text = f"ego = new Car at (1.75, -40), facing 90 deg, with speed 15 m/s, {DRIVES}\n"
    assert compiled(text + others.replace("\n", ", with regionContainedIn None\n")).sample(1).valid.all()


def test_an_ego_that_stands_starts_fairly() -> None:
    """Another drives into it head-on; it could not be elsewhere."""
    text = "ego = new Car at (1.75, -40), facing 90 deg\nother = new Car at (1.75, -20), facing 270 deg, "
    assert compiled(text + "with speed 20 m/s, with behavior ConstantSpeedBehavior(20 m/s)\n").sample(1).valid.all()


CROSSING = (
    f"ego = new Car at (1.75, -Range(8, 55)), facing 90 deg, with speed Range(5, 15) m/s, {DRIVES}\n"
    "other = new Car at (Range(-50, -8), -1.75), facing 0 deg, with speed 12 m/s,\n"
    "    with behavior ConstantSpeedBehavior(12 m/s)\n"
)


def test_scenes_are_the_first_fair_ones_of_their_streams() -> None:
    """Against a slow reference: one attempt after the other of the same file without `fair`, each looked at alone."""
    fair, plain = compiled(CROSSING), compiled(CROSSING, "terminate after 6 s\n")
    keys = key_rows(3, Method.SAMPLE, 0, 0, range(60))
    none = draw_genomes(fair.program.space, keys)
    found = sample(fair.program, none, keys, fair.config.simulation)
    assert found.valid.all()
    assert (found.failed[:, -1] > 0).any()
    assert (found.attempts == found.failed.sum(axis=1) + 1).all()
    drawn = sample(plain.program, none, keys, plain.config.simulation)
    at_once = fair_starts(plain.program, requested(plain.program, drawn), plain.config.simulation)
    assert (at_once == (found.failed[:, -1] == 0)).all()
    assert (found.values[at_once] == drawn.values[at_once]).all()
    assert fair_starts(fair.program, requested(fair.program, found), fair.config.simulation).all()


@pytest.mark.parametrize("most", [1, 2, 5, 299, 300, 301, 400])
def test_fair_starts_of_few_attempts_are_those_without_pruning(most: int) -> None:
    """Bounds begin later: no scene and no count differs, also where the attempts end."""
    fair = compiled(CROSSING)
    keys = key_rows(3, Method.SAMPLE, 0, 0, range(40))
    genomes = draw_genomes(fair.program.space, keys)
    plain, pruned = (
        sample(fair.program, genomes, keys, replace(fair.config.simulation, max_attempts=most, prune=prune))
        for prune in (False, True)
    )
    early = plain.attempts < FREE_ATTEMPTS
    assert early.any()
    for name in ("verdict", "variant", "values", "attempts", "tested", "failed"):
        np.testing.assert_array_equal(getattr(plain, name)[early], getattr(pruned, name)[early])
    if most <= FREE_ATTEMPTS:
        np.testing.assert_array_equal(plain.failed, pruned.failed)


def test_a_scene_depends_on_no_other_and_on_no_thread() -> None:
    """Nor does it matter how many rows are drawn with it, or whether attempts that surely fail are jumped over."""
    scenario = compiled(CROSSING)
    whole, threads = scenario.sample(40, seed=1), scenario.sample(40, seed=1, jobs=2)
    assert np.array_equal(whole.values, threads.values)
    assert np.array_equal(whole.failed, threads.failed)
    assert np.array_equal(whole.values[:7], scenario.sample(7, seed=1).values)


def test_a_scene_that_is_drawn_again_is_driven_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A file that draws nothing comes to one scene in every attempt; all of them are counted."""
    scenario = compiled(
        f"param GAP = Range(5, 40) m\nego = new Car at (1.75, -55), facing 90 deg, with speed 15 m/s, {DRIVES}\n"
        "other = new Car ahead of ego by GAP\n"
    )
    driven: list[int] = []

    def counted(program: Program, starts: Requested, config: SimulationConfig, jobs: int = 1) -> Bools:
        driven.append(len(starts.verdict))
        return fair_starts(program, starts, config, jobs)

    monkeypatch.setattr("engine.fairness.fair_starts", counted)
    scenes = scenario.sample(50)
    assert driven == [50]
    assert not scenes.valid.all()
    assert (scenes.failed[~scenes.valid, -1] == MOST).all()


def test_the_table_of_requirements_has_its_row() -> None:
    """Every attempt that can be driven is, so that the share of fair starts is known."""
    scenario = compiled(CROSSING)
    weighing = measure_acceptance(scenario.program, 400)
    rows = {scenario.program.requirements[blame.requirement].name: blame for blame in account(weighing).blames}
    assert 0.2 < rows["fair start"].alone < 0.99
    assert (
        rows["fair start"].tested
        == 400 - rows["outlines inside the road"].failed - rows["no overlap at the start"].failed
    )
    assert math.isclose(weighing.acceptance, rows["fair start"].alone, abs_tol=0.2)


def test_without_it_nothing_is_driven_and_nothing_differs() -> None:
    """`fair=False` is the default: the same digest."""
    assert compiled(CROSSING, "").program.digest == compiled(CROSSING, "simulation(fair=False)\n").program.digest
    assert compiled(CROSSING).program.digest != compiled(CROSSING, "terminate after 6 s\n").program.digest


def test_it_is_true_or_false() -> None:
    """A length is neither."""
    with pytest.raises(CompileError):
        compiled("ego = new Car at (1.75, -40), facing 90 deg\n", "simulation(fair=3 m)\n")
