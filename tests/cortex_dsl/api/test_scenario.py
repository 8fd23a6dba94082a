"""The Python API, used as a notebook would."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cortex_dsl as cx
from cortex_dsl import Scenario, compile_text, load
from cortex_dsl.cli import main
from cortex_dsl.diagnostics import CompileError
from engine.errors import CortexError
from engine.streams import parse_key

EXAMPLE = Path(__file__).parents[3] / "examples" / "left_turn.scn"


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


def test_what_a_notebook_shows_of_one_is_singular(tmp_path: Path) -> None:
    """A count of one has a noun in the singular, in every line."""
    text = "param SPEED = Range(9, 10)\nego = new Car at (0, -1.75), with speed SPEED"
    alone = compile_text(f"{text}\n")
    driven = compile_text(f"{text}, with behavior ExternalBehavior(every=0.1 s)\n")
    (tmp_path / "crash.scn").write_text(f"{text}\nwall = new Truck ahead of ego by 5\n", encoding="utf-8")
    crash = load(tmp_path / "crash.scn")
    scenes = crash.sample(1, seed=1)
    campaign = crash.search("random", generations=1, population=1, seed=1, out=tmp_path / "run")
    world = crash.watch(scenes)
    shown = [scenes, crash.simulate(scenes), campaign, cx.open_run(tmp_path / "run"), world, world.trajectory]
    shown += [alone.watch(alone.sample(1, seed=1)).trajectory, driven.environment(1)]
    shown += [cx.study(tmp_path / "crash.scn", "random", 1, generations=1, population=1)]
    assert [repr(each) for each in shown if re.search(r"\b1 [a-z]+s\b", repr(each))] == []
    assert sum(len(re.findall(r"\b1 [a-z]+", repr(each))) for each in shown) >= 7


def test_what_a_notebook_shows_is_one_line(scenario: Scenario) -> None:
    """A cell that ends with a scenario, scenes, outcomes or a campaign says what it is, and not its every array."""
    scenes = scenario.sample(20, seed=2)
    outcomes = scenario.simulate(scenes)
    campaign = scenario.search("random", generations=2, population=5)
    risk, run = scenario.assess(outcomes), scenario.watch(scenes, int(np.flatnonzero(scenes.valid)[0]))
    assert repr(scenario).startswith("Scenario(left_turn: params EGO_INIT_DIST, ")
    assert repr(scenes) == f"Scenes(20: {scenes.valid.sum()} valid)"
    assert repr(outcomes).endswith(f"{outcomes.collided.sum()} collisions)")
    assert "among 10 individuals" in repr(campaign)
    assert all("\n" not in repr(shown) for shown in (scenario, scenes, outcomes, campaign, risk, run))
    assert repr(risk).endswith(f"; {(~scenes.valid).sum()} invalid)")
    assert repr(run.trajectory).startswith(f"Trajectory({len(run.trajectory.time)} samples of 2 actors, ")
    assert repr(run).startswith("WorldRun(")
    assert max(len(repr(shown)) for shown in (risk, run, run.trajectory)) < 100


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


def test_the_scene_of_a_seed_is_that_of_the_command(
    scenario: Scenario, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Bit for bit, whatever it took to draw it; a concrete file has a stream of its own."""
    monkeypatch.setenv("COLUMNS", "80")
    for seed in (0, 3):
        scenes = scenario.scene_of_seed(seed)
        assert main([str(EXAMPLE), "--seed", str(seed), "--json"]) == 0
        printed = json.loads(capsys.readouterr().out)
        space = scenario.program.space
        shown = {name: param["value"] for name, param in printed["params"].items()}
        assert shown == dict(zip(space.names, scenes.genomes[0].tolist(), strict=True))
        assert list(parse_key(printed["key"])) == scenes.keys[0].tolist()
    again = compile_text(scenario.concrete(scenes))
    np.testing.assert_array_equal(again.scene_of_seed().keys, scenes.keys)


def test_columns_have_names_and_units(scenario: Scenario) -> None:
    """Of scenes, of outcomes and of a run, one value a row; what is no valid scene has none."""
    scenes = scenario.sample(30, seed=2)
    table = scenario.table(scenes)
    assert (table["verdict"] == "valid").tolist() == scenes.valid.tolist()
    np.testing.assert_array_equal(table["EGO_SPEED [km/h]"], scenes.genomes[:, 1])
    np.testing.assert_allclose(table["ego.speed [m/s]"][scenes.valid], table["EGO_SPEED [km/h]"][scenes.valid] / 3.6)
    assert np.isnan(table["adversary.x [m]"][~scenes.valid]).all()
    outcomes = scenario.simulate(scenes)
    np.testing.assert_array_equal(scenario.table(outcomes)["adversary.min_distance [m]"], outcomes.min_distance[:, 0])
    run = scenario.watch(scenes, int(np.flatnonzero(scenes.valid)[0]))
    motion = scenario.table(run)
    assert {len(column) for column in motion.values()} == {len(run.trajectory.time)}
    assert motion["ego.speed [m/s]"][0] == pytest.approx(table["ego.speed [m/s]"][scenes.valid][0])
    with pytest.raises(TypeError, match="got int"):
        scenario.table(3)  # type: ignore[arg-type]


SLIPS: dict[str, tuple[Callable[[Any], object], type[Exception], str]] = {
    "count": (lambda s: s.sample(-1), ValueError, "count: expected 0 or more, got -1"),
    "no count": (lambda s: s.sample(2.5), TypeError, "count: expected a whole number, got 2.5"),
    "several counts": (lambda s: s.sample(np.array([1, 2])), TypeError, "count: expected a whole number, got array"),
    "seed": (lambda s: s.scene_of_seed("a"), TypeError, "seed: expected a whole number"),
    "genome": (lambda s: s.sample(1, genome=[1, 2]), ValueError, "expected a value for each of EGO_INIT_DIST, "),
    "key": (lambda s: s.scene_of(np.zeros(7), (1, 2)), ValueError, "key: expected seed, method, run"),
    "jobs": (lambda s: s.simulate(s.sample(), jobs=0), ValueError, "jobs: expected 1 or more"),
    "scenes": (lambda s: s.simulate(3), TypeError, "expected Scenes, got int .`sample` draws some"),
    "outcomes": (lambda s: s.assess(s.sample()), TypeError, "expected Outcomes, got Scenes"),
    "case": (lambda s: s.scene(3), TypeError, "expected Case, got int"),
    "row": (lambda s: s.watch(s.sample(3), 9), IndexError, "there is no 9 in .*rows are 0 to 2"),
    "setting": (lambda s: s.search(seeds=3), TypeError, "no setting `seeds` .did you mean `seed`"),
    "number": (lambda s: s.search(generations="3"), TypeError, "generations: expected a whole number, got '3'"),
    "few": (lambda s: s.search(population=0), ValueError, "population: expected 1 or more, got 0"),
}


@pytest.mark.parametrize("slip", SLIPS)
def test_slips_are_answered(scenario: Scenario, slip: str) -> None:
    """By the name of what was given, what was expected, and what was got."""
    ask, error, message = SLIPS[slip]
    with pytest.raises(error, match=message) as caught:
        ask(scenario)
    assert isinstance(caught.value, CortexError)
    assert caught.value.cure


def test_scenes_of_another_scenario_are_refused(scenario: Scenario) -> None:
    """Their columns mean something else."""
    with pytest.raises(ValueError, match="of another scenario"):
        load(EXAMPLE, EGO_BRAKE=0).simulate(scenario.sample())


def test_a_scene_that_is_not_valid_is_not_written(scenario: Scenario) -> None:
    """There is nothing to write."""
    scenes = scenario.sample(30, seed=2)
    with pytest.raises(ValueError, match="not valid; only a valid one can be written"):
        scenario.concrete(scenes, int(np.flatnonzero(~scenes.valid)[0]))


@pytest.mark.parametrize("params", [{"EGO_SPED": 3}, {"EGO_SPEED": "fast"}, {"EGO_SPEED": "3 m"}])
def test_a_keyword_is_not_called_an_option(params: dict[str, Any]) -> None:
    """Who works in Python has typed no `-p`; the cure comes with the message."""
    with pytest.raises(CompileError) as caught:
        load(EXAMPLE, **params)
    assert all("-p" not in f"{each.message} {each.reason} {each.cure}" for each in caught.value.diagnostics)
    assert "EGO_SPE" in str(caught.value)
    assert ("did you mean `EGO_SPEED`?" in str(caught.value)) == ("EGO_SPED" in params)


WRONG: dict[str, Callable[[Scenario, Path], object]] = {
    "load a name with a zero": lambda _, __: cx.load("a\0b"),
    "load config": lambda _, __: load(EXAMPLE, config=3),  # type: ignore[arg-type]
    "load scenario": lambda _, __: load(EXAMPLE, scenario=3),  # type: ignore[arg-type]
    "sample far too many": lambda s, _: s.sample(10**30),
    "genome of a word": lambda s, _: s.sample(genome="x"),  # type: ignore[arg-type]
    "genome of a dict": lambda s, _: s.sample(genome={}),  # type: ignore[arg-type]
    "key of a word": lambda s, _: s.scene_of(s.program.space.low, "x"),
    "show nothing": lambda s, _: s.show(None),  # type: ignore[arg-type]
    "replay nothing": lambda s, _: s.replay(None),  # type: ignore[arg-type]
    "replay no row": lambda s, _: s.replay(s.sample(2), "x"),  # type: ignore[arg-type]
    "save below no folder": lambda s, tmp: s.show(s.sample()).save(tmp / "none" / "a.svg"),
    "save over a folder": lambda s, tmp: s.show(s.sample()).save(tmp),
    "method": lambda s, _: s.search(3),  # type: ignore[arg-type]
    "aggregate": lambda s, _: s.search(aggregate=3),  # type: ignore[arg-type]
    "workers": lambda s, _: s.search(workers=3),  # type: ignore[arg-type]
    "on_generation": lambda s, _: s.search(on_generation=3),  # type: ignore[arg-type]
    "out of a search": lambda s, _: s.search(out=3),  # type: ignore[arg-type]
    "run": lambda _, __: cx.open_run(None),  # type: ignore[arg-type]
    "run to resume": lambda _, __: cx.resume(3),  # type: ignore[arg-type]
    "generations to resume": lambda _, tmp: cx.resume(tmp, generations="x"),  # type: ignore[arg-type]
    "formats": lambda s, tmp: cx.export(s, None, tmp),  # type: ignore[arg-type]
    "out of an export": lambda s, _: cx.export(s, ["csv"], None),  # type: ignore[arg-type]
    "ego": lambda _, __: cx.measure("a.csv", ego=3),  # type: ignore[arg-type]
    "step": lambda _, __: cx.measure("a.csv", step="x"),  # type: ignore[arg-type]
    "window of one time": lambda _, __: cx.measure("a.csv", window=3),  # type: ignore[arg-type]
    "window of words": lambda _, __: cx.measure("a.csv", window=("1", "2")),  # type: ignore[arg-type]
    "window that ends before it begins": lambda _, __: cx.measure("a.csv", window=(2, 1)),
    "window of three": lambda _, __: cx.measure("a.csv", window=(0, 1, 2)),  # type: ignore[arg-type]
    "methods of a study": lambda s, _: cx.study(s, [3]),  # type: ignore[list-item]
    "out of a study": lambda s, _: cx.study(s, out=3),  # type: ignore[arg-type]
    "an objective of a study that has no name": lambda s, _: cx.study(s, objective=len),  # type: ignore[arg-type]
    "a number for several": lambda s, _: cx.study(s, objective=3),  # type: ignore[arg-type]
}


@pytest.mark.parametrize("wrong", WRONG.values(), ids=WRONG)
def test_wrong_arguments_are_cortex_errors(
    scenario: Scenario, tmp_path: Path, wrong: Callable[[Scenario, Path], object]
) -> None:
    """What is wrong and its cure, before anything is done."""
    with pytest.raises(CortexError) as caught:
        wrong(scenario, tmp_path)
    assert caught.value.message
    assert caught.value.cure
