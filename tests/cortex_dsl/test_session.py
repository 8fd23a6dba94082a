"""The Python API, used as a notebook would."""

from pathlib import Path

import numpy as np
import pytest

from cortex_dsl.diagnostics import CompileError
from cortex_dsl.session import Scenario, compile_text, load

EXAMPLE = Path(__file__).parents[2] / "examples" / "left_turn.scn"


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return load(EXAMPLE)


def test_shapes_are_as_documented(scenario: Scenario) -> None:
    """Rows of every array belong to the same scene."""
    scenes = scenario.sample(50, seed=2)
    outcomes = scenario.simulate(scenes, jobs=2)
    risk = scenario.assess(outcomes)
    assert scenes.genomes.shape == (50, 7)
    assert scenes.tested.shape == (50, len(scenario.program.requirements))
    assert outcomes.min_distance.shape == (50, 1)
    assert outcomes.left_road_time.shape == (50, 2)
    assert risk.score.shape == (50,)
    assert ((risk.score == -1) == ~scenes.valid).all()


def test_hosts_are_chosen_by_name(scenario: Scenario) -> None:
    """Both give the same outcomes; another name is refused."""
    scenes = scenario.sample(10, seed=2)
    batch, world = scenario.simulate(scenes, engine="batch"), scenario.simulate(scenes, engine="world")
    np.testing.assert_array_equal(batch.collided, world.collided)
    with pytest.raises(ValueError, match="expected batch or world"):
        scenario.simulate(scenes, engine="carla")


def test_params_may_be_fixed(scenario: Scenario) -> None:
    """A fixed param is no gene any more; values may carry a unit."""
    fixed = load(EXAMPLE, EGO_SPEED="36 km/h", EGO_BRAKE=1)
    assert "EGO_SPEED" not in fixed.program.space.names
    assert len(fixed.program.space) == len(scenario.program.space) - 2
    scenes = fixed.sample(40)
    assert fixed.watch(scenes, int(np.flatnonzero(scenes.valid)[0])).trajectory.states[0, 0, 3] == pytest.approx(10.0)


def test_one_genome_has_many_scenes(scenario: Scenario) -> None:
    """A genome is a distribution of scenes: nuisance values differ, genes do not."""
    genome = np.array([20.0, 40.0, 0.5, 20.0, 40.0, 5.0, 1.0])
    scenes = scenario.sample(30, genome=genome)
    assert (scenes.genomes == genome).all()
    assert scenes.valid.all()
    assert len(np.unique(scenes.values[:, 0])) > 10


def test_what_a_notebook_shows_is_one_line(scenario: Scenario) -> None:
    """A cell that ends with a scenario, scenes, outcomes or a campaign says what it is, and not its every array."""
    scenes = scenario.sample(20, seed=2)
    outcomes = scenario.simulate(scenes)
    campaign = scenario.search("random", generations=2, population=5)
    assert repr(scenario).startswith("Scenario(left_turn: params EGO_INIT_DIST, ")
    assert repr(scenes) == f"Scenes(20: {scenes.valid.sum()} valid)"
    assert repr(outcomes).endswith(f"{outcomes.collided.sum()} collisions)")
    assert "among 10 individuals" in repr(campaign)
    assert all("\n" not in repr(shown) for shown in (scenario, scenes, outcomes, campaign))


def test_unknown_profiles_are_refused(scenario: Scenario) -> None:
    """The message names those that there are."""
    outcomes = scenario.simulate(scenario.sample(2))
    with pytest.raises(ValueError, match="expected one of paper, paper-mm"):
        scenario.assess(outcomes, profile="lenient")


def test_a_search_and_its_worst_case(scenario: Scenario) -> None:
    """The worst case, drawn again from its key, has the outcome that the campaign recorded."""
    campaign = scenario.search("ga", generations=3, population=20, seed=4)
    worst = campaign.worst[0]
    outcomes = scenario.simulate(scenario.scene(worst))
    assert scenario.assess(outcomes).score[0] == worst.score
    assert outcomes.min_distance[0, 0] == worst.min_distance


def test_the_file_decides_what_it_says_about_its_simulation() -> None:
    """Settings of the file come before the config's defaults."""
    scenario = compile_text(
        "map intersection()\nsimulation(time_step=0.1 s, max_attempts=7)\nego = new Car in road\nterminate after 3 s\n"
    )
    assert scenario.config.simulation.time_step == 0.1
    assert scenario.config.simulation.max_attempts == 7
    assert scenario.config.simulation.max_time == 3.0


def test_mistakes_are_raised_with_all_their_places() -> None:
    """One exception carries every diagnostic."""
    with pytest.raises(CompileError) as caught:
        compile_text("ego = new Car at (0, 0), with sped 5\nrequire ego.sped > 3\n")
    assert len(caught.value.diagnostics) == 2


def test_records_come_with_the_run() -> None:
    """Over time and at the end, by the names that the file gives them."""
    text = EXAMPLE.read_text() + 'record ego.speed as "pace"\nrecord final (distance from ego to adversary) as "gap"\n'
    scenario = compile_text(text)
    scenes = scenario.sample(8, seed=6)
    run = scenario.watch(scenes, int(np.flatnonzero(scenes.valid)[0]))
    pace, gap = run.records
    assert (pace.name, pace.unit, gap.name, gap.unit) == ("pace", "m/s", "gap", "m")
    assert len(pace.values) == len(pace.time) > 1
    assert len(gap.values) == 1
    assert gap.time[0] == pace.time[-1]
