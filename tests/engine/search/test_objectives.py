"""What a search looks for: rows by name, what they make of runs, and what is said of those that cannot be."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import FunctionType
from typing import Any

import numpy as np
import pytest

import cortex_dsl as cx
from cortex_dsl import Scenario
from engine.assessment import take
from engine.avoidability import Avoidance, avoidability
from engine.errors import ArgumentError, ArgumentKindError
from engine.metrics.values import pet_by_area
from engine.outcomes import Outcomes
from engine.risk import assess
from engine.search.insight.analysis import analyse
from engine.search.objectives import (
    BUILT_IN,
    FARTHEST,
    ObjectiveError,
    ObjectiveNameError,
    Runs,
    UnknownObjectiveError,
    conflict,
    expectation,
    injury,
    known_objectives,
    names_of,
    objectives,
    severity,
)
from engine.search.objectives import avoidable as how_avoidable
from engine.search.searchers import SeveralObjectivesError
from engine.search.store import StoreError
from engine.vocabulary import OBJECTIVES, Side

EXAMPLES = Path(__file__).parents[3] / "examples"
TEXT = """
map intersection(approach=60 m)
param V = Range(4, 14) m/s
param GAP = Range(6, 40) m
param PEDAL = Range(0, 1)
way = [network.lanes[0]]
behavior Careful():
    try:
        do ConstantSpeedBehavior(V)
    interrupt when (distance to truck) < 14 m:
        take SetBrakeAction(PEDAL)

ego = new Car at (-50, -1.75), facing 0 deg, with speed V, with behavior Careful()
truck = new Truck ahead of ego by GAP
expect always (minimum distance from ego to truck) > 2 m as "room"
maximize largest(ego.speed) as "fast"
minimize min_distance as "near"
terminate after 4 s
"""
AHEAD = """
map intersection(approach=60 m)
param V = Range(4, 14) m/s
param AWAY = Range(8, 30) m
ego = new Car at (-40, -1.75), facing 0 deg, with speed V, with behavior ConstantSpeedBehavior(V)
"""
"""A car that drives on, whatever stands in its way."""
SMALL: dict[str, Any] = {"generations": 3, "population": 12, "seed": 4, "jobs": 1}


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return cx.compile_text(TEXT)


@pytest.fixture(scope="module")
def runs(scenario: Scenario) -> Runs:
    """Thirty simulated scenes, collisions among them."""
    return _runs(scenario)


def _runs(scenario: Scenario, count: int = 30) -> Runs:
    scenes = scenario.sample(count, seed=3)
    outcomes = scenario.simulate(scenes)
    assert 3 < outcomes.collided.sum() < count - 3
    return Runs(scenario.program, scenario.config, scenes, outcomes, assess(outcomes))


def test_every_file_has_the_same_rows_and_its_own(scenario: Scenario) -> None:
    """In the order of the table, those of the file behind; the risk alone is no row."""
    assert tuple(row.name for row in BUILT_IN) == OBJECTIVES
    assert tuple(known_objectives(scenario.program)) == (*OBJECTIVES, "room", "fast", "near")
    assert objectives(scenario.program) == ()
    assert [row.name for row in objectives(scenario.program, ["room", "risk"])] == ["room", "risk"]


def test_an_unknown_name_is_told_with_those_that_there_are(scenario: Scenario) -> None:
    """The nearest one first."""
    with pytest.raises(UnknownObjectiveError, match="did you mean `avoidable`") as caught:
        objectives(scenario.program, ["avoidabel"])
    assert "room" in caught.value.cure
    with pytest.raises(UnknownObjectiveError, match="there are room"):
        expectation(scenario.program, "fast")


def test_avoidable_is_graded(runs: Runs) -> None:
    """2 to 3 for a collision that the reference driver avoids, 0 to 1 for others and for none at all."""
    values, outcomes = how_avoidable(runs), runs.outcomes
    collided = np.flatnonzero(outcomes.collided)
    answers = avoidability(runs.program, take(runs.scenes, collided), runs.config.simulation)
    for row, answer in zip(collided.tolist(), answers, strict=True):
        assert answer is not None
        assert (values[row] >= 2.0) == answer.avoidable
        assert values[row] <= 3.0
        assert answer.avoidance is not Avoidance.LOST or values[row] == 0.0
    assert (values[~outcomes.collided] < 1.0).all()
    assert (values >= 0.0).all()
    in_threads = replace(runs.config, search=replace(runs.config.search, jobs=3))
    np.testing.assert_array_equal(how_avoidable(replace(runs, config=in_threads)), values)


def test_conflict_is_nothing_on_contact_and_worse_than_that_without(runs: Runs) -> None:
    """Minus seconds."""
    values = conflict(runs)
    assert (values[runs.outcomes.collided] == 0.0).all()
    assert (values[~runs.outcomes.collided] < 0.0).all()
    assert np.isfinite(values).all()


def test_every_collision_is_severer_than_what_did_not_happen(runs: Runs) -> None:
    """Delta-V of whom it is larger, the car's here, by the speed at the last sample before contact."""
    values, outcomes = severity(runs), runs.outcomes
    assert (values[outcomes.collided] >= 0.0).all()
    assert (values[~outcomes.collided] < 0.0).all()
    car, truck = 1093.0, 10_000.0
    expected = outcomes.ego_speed[:, 0] * truck / (car + truck)
    braked_in_a_step = 8.0 * 0.05
    np.testing.assert_allclose(values[outcomes.collided], expected[outcomes.collided], atol=braked_in_a_step)


def test_an_injury_is_as_likely_as_its_curve_says() -> None:
    """Of who is struck on foot, by the relative speed; nobody has a curve for a truck."""
    walking = f"""{AHEAD}
walker = new Pedestrian ahead of ego by AWAY, facing 90 deg, with speed 0 m/s
terminate after 2 s
"""
    runs = _runs(cx.compile_text(walking))
    values, outcomes = injury(runs), runs.outcomes
    hit = outcomes.collided
    km_h = 3.6 * outcomes.ego_speed[hit, 0]
    np.testing.assert_allclose(values[hit], 1.0 / (1.0 + np.exp(6.190 - 0.078 * km_h - 0.038 * 46.0)), rtol=1e-9)
    assert (values[~hit] < 0.0).all()


def test_an_injury_needs_the_front_of_a_car() -> None:
    """A bicycle that runs into the side of a car has no curve, however little it misses the front by."""
    crossing = f"""{AHEAD}
rider = new Bicycle at (0, -1.75 - AWAY), facing 90 deg, with speed 6 m/s, with behavior ConstantSpeedBehavior(6 m/s)
terminate after 12 s
"""
    runs = _runs(cx.compile_text(crossing), 400)
    values, outcomes = injury(runs), runs.outcomes
    side = outcomes.side[outcomes.collided, 0]
    assert {Side.FRONT, Side.RIGHT} <= {*side.tolist()}
    np.testing.assert_array_equal(values[outcomes.collided] > 0.0, side == Side.FRONT)


def test_who_is_fixed_changes_nothing_of_its_own() -> None:
    """All of the change of velocity is the other's."""
    fixed = f"""{AHEAD}
block = new Car ahead of ego by AWAY, with fixed True
terminate after 2 s
"""
    runs = _runs(cx.compile_text(fixed))
    values, hit = severity(runs), runs.outcomes.collided
    np.testing.assert_allclose(values[hit], runs.outcomes.ego_speed[hit, 0], rtol=1e-6)
    assert np.isfinite(values).all()


def test_no_curve_reaches_a_truck(runs: Runs) -> None:
    """Such a collision counts as 0 and is not what is looked for, and still it comes before every miss."""
    values, outcomes = injury(runs), runs.outcomes
    (row,) = objectives(runs.program, ["injury"])
    assert not row.finds(runs, values).any()
    assert (values[outcomes.collided] == 0.0).all()
    assert (values[~outcomes.collided] < 0.0).all()


def test_objectives_of_the_file_turn_their_sign(runs: Runs) -> None:
    """An expectation is sought by how far it is broken, a minimum by how small it is."""
    room, fast, near = (row.value(runs) for row in objectives(runs.program, ["room", "fast", "near"]))
    np.testing.assert_array_equal(room, -runs.outcomes.sought[:, 0])
    np.testing.assert_array_equal(fast, runs.outcomes.sought[:, 1])
    np.testing.assert_array_equal(near, -runs.outcomes.min_distance[:, 0])
    (row,) = objectives(runs.program, ["room"])
    np.testing.assert_array_equal(row.finds(runs, room), runs.outcomes.min_distance[:, 0] <= 2.0)


@pytest.mark.parametrize("name", ["room", "near", "avoidable", "conflict", "severity", "injury", "controller"])
def test_a_search_climbs_what_it_is_told_to(scenario: Scenario, name: str) -> None:
    """Fitness is the objective, and the worst case has the most of it of all that are avoidable as it is, or not."""
    campaign = scenario.search("ga", objective=name, **SMALL)
    found = campaign.evaluations
    assert campaign.objective == (name,)
    valid = found.valid
    np.testing.assert_array_equal(found.fitness[valid], found.rollouts.sought[valid, 0, 0])
    worst = campaign.worst[0]
    alike = (campaign.blame == campaign.blame[worst.row]).all(axis=1) & (found.collided == worst.collided)
    assert worst.continuous == found.fitness[valid & alike].max()


def test_the_risk_is_sought_as_ever(scenario: Scenario) -> None:
    """Named or not."""
    usual, named = (scenario.search("ga", **how, **SMALL) for how in ({}, {"objective": "risk"}))
    np.testing.assert_array_equal(usual.evaluations.fitness, named.evaluations.fitness)
    assert usual.evaluations.rollouts.sought.shape[-1] == 0
    np.testing.assert_array_equal(usual.evaluations.found, usual.evaluations.collided)


def test_a_run_keeps_what_it_looks_for(scenario: Scenario, tmp_path: Path) -> None:
    """In its manifest, its journal and its tables; it goes on for that, and for nothing else."""
    file = tmp_path / "scene.scn"
    file.write_text(TEXT)
    stopped = _Stop()
    campaign = cx.search(file, "ga", objective="room", out=tmp_path / "run", on_generation=stopped, **SMALL)
    whole = cx.search(file, "ga", objective="room", out=tmp_path / "whole", **SMALL)
    assert campaign.stopped
    run = cx.open_run(tmp_path / "run")
    assert (run.record.manifest.objective, run.record.manifest.objectives) == (("room",), ("room", "fast", "near"))
    np.testing.assert_array_equal(run.record.evaluations.rollouts.sought, campaign.evaluations.rollouts.sought)
    np.testing.assert_array_equal(run.record.evaluations.rollouts.broken, campaign.evaluations.rollouts.broken)
    with pytest.raises(StoreError, match="looks for room, not for risk"):
        cx.resume(tmp_path / "run", objective="risk")
    rest = cx.resume(tmp_path / "run").campaign
    np.testing.assert_array_equal(rest.evaluations.genomes, whole.evaluations.genomes)
    np.testing.assert_array_equal(rest.evaluations.fitness, whole.evaluations.fitness)
    header = (tmp_path / "run" / "evaluations.csv").read_text().splitlines()[0].split(",")
    assert {"sought_room", "broken_room"} <= {*header}
    assert cx.open_run(tmp_path / "run").record.evaluations.found.any()


class _Stop:
    """Ctrl-C in the second generation."""

    def __call__(self, progress: object) -> None:
        if getattr(progress, "generation", 0) == 1:
            raise KeyboardInterrupt


def braking(outcomes: Outcomes) -> np.ndarray:
    """Larger where the ego is slower."""
    return -outcomes.ego_speed[:, 0]


def test_a_function_is_an_objective(scenario: Scenario, tmp_path: Path) -> None:
    """Of outcomes; a run is gone on with by the same function alone."""
    campaign = scenario.search("random", objective=braking, out=tmp_path / "run", **SMALL)
    found = campaign.evaluations
    np.testing.assert_array_equal(found.fitness[found.valid], -found.rollouts.ego_speed[found.valid, 0])
    assert names_of([braking]) == campaign.objective == ("braking",)
    with pytest.raises(StoreError, match="a function of a Python program"):
        cx.resume(tmp_path / "run", generations=4)
    assert len(cx.resume(tmp_path / "run", generations=4, objective=braking).campaign.generations) == 4


@pytest.mark.parametrize(
    ("function", "what"),
    [
        (lambda outcomes: outcomes.nothing, "AttributeError"),
        (lambda _: 3.0, r"shape \(\)"),
        (lambda outcomes: np.zeros((len(outcomes), 2)), r"shape \(12, 2\)"),
        (lambda outcomes: np.full(len(outcomes), np.nan), "NaN"),
        (lambda outcomes: ["a"] * len(outcomes), "type <U1"),
        (lambda outcomes: np.full(len(outcomes), 1j), "type complex128"),
        (lambda outcomes: outcomes.min_distance.fill(0.0), "read-only"),
    ],
)
def test_a_function_that_fails_is_told(
    scenario: Scenario, tmp_path: Path, function: Callable[[Outcomes], object], what: str
) -> None:
    """By its name, what it did, and what it should do; what was written before is kept."""
    calls = 0

    def later(outcomes: Outcomes) -> object:
        nonlocal calls
        calls += 1
        return braking(outcomes) if calls == 1 else function(outcomes)

    with pytest.raises(ObjectiveError, match=what) as caught:
        scenario.search("random", objective=later, out=tmp_path / "run", **SMALL)
    assert "`later`" in caught.value.message
    assert len(cx.open_run(tmp_path / "run").record.generations) == 1


def nameless(outcomes: Outcomes) -> object:
    return np.zeros(len(outcomes))


@pytest.mark.parametrize("name", ["risk", "avoidable", "room", "braking"])
def test_a_function_has_a_name_of_its_own(scenario: Scenario, tmp_path: Path, name: str) -> None:
    """A run that is kept is gone on with by names: each means one thing, and a run that cannot be read is none."""
    function = FunctionType(nameless.__code__, globals(), name)
    others = [braking] if name == "braking" else []
    with pytest.raises(ObjectiveNameError, match=f"`{name}`"):
        scenario.search("nsga2" if others else "ga", objective=[*others, function], out=tmp_path / "run", **SMALL)
    assert not (tmp_path / "run").exists()


def test_an_objective_is_named_once(scenario: Scenario) -> None:
    """Two columns of one name would be one too many."""
    with pytest.raises(ObjectiveNameError, match="twice"):
        objectives(scenario.program, ["room", "fast", "room"])


@pytest.mark.parametrize("aims", [["room"], ["room", "fast"]])
def test_a_run_for_objectives_is_analysed(scenario: Scenario, aims: list[str]) -> None:
    """Its genes are probed by what happens, whatever was sought; a gene that changes nothing is dead in both."""
    pytest.importorskip("pymoo")
    text = TEXT.replace("param PEDAL", "param DEAD = Range(0, 1)\nparam PEDAL")
    idle = cx.compile_text(text.replace("with speed V", "with speed V + 0 m/s * DEAD"))
    campaign = idle.search("nsga2", objective=aims, **SMALL)
    found = analyse(idle.program, campaign.evaluations, idle.config, budget=0)
    genes = {gene.name: gene for gene in found.genes}
    assert [name for name, gene in genes.items() if gene.dead] == ["DEAD"]
    assert {gene.name: gene.changed for gene in campaign.genes} == {name: gene.changed for name, gene in genes.items()}


@pytest.mark.parametrize(
    ("objective", "error"), [(3, ArgumentKindError), ([], ArgumentError), ("nothing", UnknownObjectiveError)]
)
def test_what_is_no_objective(scenario: Scenario, objective: object, error: type[Exception]) -> None:
    """Said before anything is made."""
    with pytest.raises(error):
        scenario.search(objective=objective, **SMALL)  # type: ignore[arg-type]


def test_several_objectives_need_a_method_for_them(scenario: Scenario) -> None:
    """NSGA-II takes as many as there are; the genetic algorithm one."""
    with pytest.raises(SeveralObjectivesError, match="nsga2"):
        scenario.search("ga", objective=["room", "fast"], **SMALL)
    pytest.importorskip("pymoo")
    campaign = scenario.search("nsga2", objective=["room", "fast"], **SMALL)
    assert campaign.evaluations.rollouts.sought.shape[-1] == 2


def test_map_elites_fills_cells_below_zero(scenario: Scenario) -> None:
    """An objective that is never positive is kept all the same."""
    pytest.importorskip("ribs")
    campaign = scenario.search("map_elites", objective="conflict", **SMALL)
    assert len({genome.tobytes() for genome in campaign.evaluations.genomes}) == 36


def test_probability_of_a_breach(scenario: Scenario) -> None:
    """The share of runs that break it, which is that of a least distance of at most 2 m."""
    from engine.search.probability.monte_carlo import estimate

    found = estimate(scenario.program, scenario.config, "mc", 400, seed=5, of="room")
    plain = estimate(scenario.program, scenario.config, "mc", 400, seed=5)
    assert (found.of, plain.of) == ("room", "")
    assert found.value >= plain.value > 0.0
    with pytest.raises(UnknownObjectiveError):
        estimate(scenario.program, scenario.config, "mc", 10, of="fast")


@pytest.mark.parametrize("method", ["mc", "subset", "importance"])
def test_runs_without_a_number_are_told(scenario: Scenario, method: str) -> None:
    """What is no number counts neither way, and an estimate says how often that was."""
    from engine.search.probability.estimates import content
    from engine.search.probability.monte_carlo import estimate

    root = cx.compile_text(TEXT + 'expect always sqrt((V - 9 m/s) / (1 m/s)) < 9 as "root"\n')
    found = estimate(root.program, root.config, method, 1_000, seed=5, of="room")
    assert found.errors == content(found)["errors"] >= 0.2 * found.simulations
    assert found.value <= 1.0  # here the mean weight is above
    assert "errors" not in content(estimate(scenario.program, scenario.config, "mc", 100, of="room"))


@pytest.mark.parametrize("name", ["left_against_crossing", "right_and_oncoming_left"])
def test_the_gap_is_that_of_the_metric(name: str) -> None:
    """Of the batch, against each encounter measured alone; where it has none, the way left over the closing speed."""
    scenario = cx.load(EXAMPLES / f"{name}.scn")
    scenes = scenario.sample(40, seed=5)
    outcomes = scenario.simulate(scenes)
    runs = Runs(scenario.program, scenario.config, scenes, outcomes, assess(outcomes))
    values = conflict(runs)
    for row in np.flatnonzero(runs.valid & ~outcomes.collided).tolist():
        (pair,) = runs.encounters(row)
        gap = abs(pet_by_area(pair))
        closing = outcomes.closing_speed[row, 0]
        left = outcomes.min_distance[row, 0] / closing if closing > 0.0 else FARTHEST
        assert values[row] == -min(FARTHEST, gap if np.isfinite(gap) else left)
