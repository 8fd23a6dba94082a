"""Counterfactuals of collisions: bisection against a grid search by hand, and what each value says of other scenes."""

import math
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from cortex_dsl import Scenario, compile_text
from engine.counterfactuals import Counterfactuals, counterfactuals
from engine.sampling import sample
from engine.scenes import Scenes, actor_columns
from engine.streams import key_rows
from engine.verdicts import blame
from engine.vocabulary import Blame, Column, Method
from tests.engine.drivers_by_hand import (
    Encounter,
    avoids_braking_at,
    avoids_on,
    avoids_slower,
    avoids_with_sight,
)
from tests.engine.test_references import encounter
from tests.laws import examples, share

PLACES = """
map road(length=1 km, lanes=3, one_way=True)
param V = Range(5, 30) m/s, W = Range(0, 1), X = Range(0, 70) m, Y = Range(-1, 1), SIDE = Range(0, 600) m
param FRICTION = Range(0.2, 1), SIGHT = Range(10, 120) m
environment(friction=FRICTION, sight=SIGHT)
ego = new Car at (-450, SIDE), facing 0 deg, with speed V, with regionContainedIn None
other = new {kind} at ({x}, {y}), facing {turn}, with speed {speed}, with regionContainedIn None
terminate after 24 s
"""
SITUATIONS = {
    "stands": {"kind": "Car", "x": "-440 + X", "y": "1.5 * Y", "turn": "0 deg", "speed": "0 m/s"},
    "slower": {"kind": "Car", "x": "-440 + 0.5 * X", "y": "1.5 * Y", "turn": "0 deg", "speed": "V * W"},
    "walks across": {
        "kind": "Pedestrian",
        "x": "-444 + X",
        "y": "-1.5 - X * (1 + 0.2 * Y) / (5 + 15 * W)",
        "turn": "90 deg",
        "speed": "1.5 m/s",
    },
    "crosses": {"kind": "Car", "x": "-440 + X", "y": "-4 - X * (0.9 + 0.3 * Y)", "turn": "90 deg", "speed": "0.9 * V"},
}


@cache
def compiled(situation: str) -> Scenario:
    return compile_text(PLACES.format(**SITUATIONS[situation]))


def scenes_of(scenario: Scenario, genomes: np.ndarray) -> Scenes:
    keys = key_rows(1, Method.SAMPLE, 0, 0, np.arange(len(genomes)))
    return sample(scenario.program, genomes, keys, scenario.config.simulation)


def with_param(scenario: Scenario, genomes: np.ndarray, name: str, value: float) -> np.ndarray:
    changed = genomes.copy()
    changed[:, scenario.program.space.names.index(name)] = value
    return changed


def collisions(situation: str, count: int, seed: int) -> list[tuple[Encounter, Counterfactuals, float, float]]:
    """Random collisions by the ego: for the drivers by hand, what is found, the car's brakes, the range of sight."""
    scenario = compiled(situation)
    space, rng = scenario.program.space, np.random.default_rng(seed)
    genomes = space.low + rng.random((8 * count, len(space))) * (space.high - space.low)
    near, far = (scenes_of(scenario, with_param(scenario, genomes, "SIDE", side)) for side in (0.0, 600.0))
    found = counterfactuals(scenario.program, near, scenario.config.simulation)
    rows = [row for row, each in enumerate(found) if each is not None and far.valid[row]][:count]
    made = []
    for row in rows:
        each = found[row]
        assert each is not None
        brakes = float(actor_columns(scenario.program, near.values[row])[0][Column.MAX_BRAKING])
        sight = float(genomes[row, space.names.index("SIGHT")])
        made.append((encounter(scenario, near, far, row), each, brakes, sight))
    return made


def grid_from_the_case(values: np.ndarray, avoids: np.ndarray) -> tuple[float, bool]:
    """The first value that avoids contact, and whether all further ones do: then physics is monotone."""
    if not avoids.any():
        return math.nan, True
    first = int(np.argmax(avoids))
    return float(values[first]), bool(avoids[first:].all())


def grids(case: Encounter, brakes: float, sight: float) -> dict[str, tuple[np.ndarray, Callable[[float], bool]]]:
    """The values that a grid search tries, from that of the case on, and whether a driver by hand avoids contact."""
    step, fastest = case.step, float(case.ego_speed[: case.contact].max())
    seen = [far for far, there in zip(case.distances, case.conflicts, strict=True) if there]
    return {
        "approach_speed": (np.arange(fastest, 0.0, -0.1), lambda v: avoids_slower(case, v, sight=sight)),
        "latest_braking": (
            np.arange(case.contact - 1, -1, -1) * step,
            lambda t: avoids_braking_at(case, round(t / step)),
        ),
        "sight": (np.arange(0.1, max(seen, default=0.0) + 2.0, 0.1), lambda s: avoids_with_sight(case, s)),
        "friction": (np.arange(0.01, 1.005, 0.01), lambda f: avoids_on(case, f, brakes, sight)),
    }


def thinned(values: np.ndarray, value: float) -> np.ndarray:
    """A grid as it is near a value; farther off a few of its points, and all of them in a night."""
    if settings().max_examples >= NIGHT:
        return values
    sparse = np.arange(len(values)) % max(1, len(values) // 8) == 0
    near = np.argsort(np.abs(values - value))[:4] if math.isfinite(value) else np.zeros(0, dtype=np.int64)
    sparse[near] = True
    return values[sparse]


NIGHT = 1000
"""Examples of a law in a night."""
TOLERANCES = {"approach_speed": 0.1, "latest_braking": 0.05, "sight": 0.1, "friction": 0.01}


@pytest.mark.parametrize("situation", SITUATIONS)
def test_bisection_finds_what_a_grid_search_finds(situation: str) -> None:
    """Where physics is monotone, the same value; elsewhere a boundary, beyond which contact returns."""
    found = collisions(situation, share(12), 3)
    assert found
    for case, said, brakes, sight in found:
        for name, (values, avoids) in grids(case, brakes, sight).items():
            value, wide = getattr(said, name), TOLERANCES[name]
            values = thinned(values, value)
            flags = np.array([avoids(each) for each in values])
            expected, monotone = grid_from_the_case(values, flags)
            if monotone or math.isnan(expected):
                assert value == pytest.approx(expected, abs=wide + 1e-9, nan_ok=True), (name, situation)
            elif not math.isnan(value):
                near = np.abs(values - value) <= wide + 1e-9
                assert flags[near].any(), (name, situation)
                assert not flags[near].all() or near[0], (name, situation)


# -- what a value says of other scenes ---------------------------------------------------------------------------------


def before_obstacle(scenario: Scenario, speed: float, ahead: float, friction: float, sight: float) -> np.ndarray:
    """Return the genome (1, d) of an ego that drives towards what stands in its way."""
    values = {"V": speed, "W": 0.0, "X": ahead, "Y": 0.0, "SIDE": 0.0, "FRICTION": friction, "SIGHT": sight}
    return np.array([[values[name] for name in scenario.program.space.names]])


def careful_avoids(scenario: Scenario, genomes: np.ndarray) -> bool:
    """Whether a scene has no collision, or one that the careful driver avoids."""
    scenes = scenes_of(scenario, genomes)
    (said,) = blame(scenario.program, scenes, scenario.config.simulation, references=("careful",)).tolist()
    return said in (Blame.NONE, Blame.AVOIDABLE)


@given(st.floats(8.0, 30.0), st.floats(20.0, 69.0), st.floats(0.3, 1.0), st.floats(15.0, 110.0))
@examples(40)
def test_before_an_obstacle_each_value_is_the_limit_between_scenes(
    speed: float, ahead: float, friction: float, sight: float
) -> None:
    """Scenes that differ from a collision in speed, friction or sight only: avoidable on one side of the value."""
    scenario = compiled("stands")
    genomes = before_obstacle(scenario, speed, ahead, friction, sight)
    scenes = scenes_of(scenario, genomes)
    (found,) = counterfactuals(scenario.program, scenes, scenario.config.simulation)
    assume(found is not None)
    assert found is not None
    assert careful_avoids(scenario, genomes) == (found.approach_speed >= speed - 1e-9)
    limits = (("V", found.approach_speed, -0.2, 8.0, speed), ("FRICTION", found.friction, 0.02, 0.2, 1.0))
    for name, value, easier, low, high in limits:
        if low < value - abs(easier) and value + abs(easier) < high:
            assert careful_avoids(scenario, with_param(scenario, genomes, name, value + easier)), name
            assert not careful_avoids(scenario, with_param(scenario, genomes, name, value - easier)), name
    if 10.2 < found.sight < 119.8:
        assert careful_avoids(scenario, with_param(scenario, genomes, "SIGHT", found.sight + 0.2))
        assert not careful_avoids(scenario, with_param(scenario, genomes, "SIGHT", found.sight - 0.2))


@given(st.floats(8.0, 30.0), st.floats(20.0, 69.0), st.floats(0.3, 0.9), st.floats(15.0, 100.0))
@examples(30)
def test_before_an_obstacle_more_of_each_is_never_worse(
    speed: float, ahead: float, friction: float, sight: float
) -> None:
    """A longer sight, a better road, and a slower approach let the careful driver avoid what it avoided before."""
    scenario = compiled("stands")
    genomes = before_obstacle(scenario, speed, ahead, friction, sight)
    before = careful_avoids(scenario, genomes)
    for name, value in (("SIGHT", sight + 15.0), ("FRICTION", friction + 0.1), ("V", speed - 2.0)):
        assert careful_avoids(scenario, with_param(scenario, genomes, name, value)) >= before, name


@given(st.floats(10.0, 30.0), st.floats(40.0, 69.0), st.floats(0.3, 1.0), st.floats(12.0, 60.0))
@examples(30)
def test_adapted_speed_avoids_whatever_stands_in_fog(speed: float, ahead: float, friction: float, sight: float) -> None:
    """An ego that can always stop within what it sees meets nothing that stands, unless the scene begins too late."""
    scenario = compiled("stands")
    genomes = before_obstacle(scenario, speed, ahead, friction, sight)
    assume(sight < ahead + 5.0)
    (found,) = counterfactuals(scenario.program, scenes_of(scenario, genomes), scenario.config.simulation)
    assume(found is not None)
    assert found is not None
    assert found.adapted_speed


def test_adapted_speed_is_that_of_the_drive_by_hand() -> None:
    """In fog, with others that stand, cross or walk."""
    agreed = 0
    for situation in SITUATIONS:
        scenario = compiled(situation)
        for case, said, _, sight in collisions(situation, share(40), 11):
            at = case.contact - 1
            inside = np.linspace(0.0, 1.0, 2001)
            xs = case.ego_x[at] + inside * (case.ego_x[at + 1] - case.ego_x[at])
            hit = [x for x in xs if case.touch_at(at, x, (x - xs[0]) / (xs[-1] - xs[0]))]
            fastest = float(case.ego_speed[: case.contact].max())
            assert said.adapted_speed == avoids_slower(case, fastest, hit[0], sight), situation
            agreed += 1
        assert scenario is compiled(situation)
    assert agreed >= 4


VAN = """
map road(length=400 m)
environment(friction=0.5)
param V = Range(10, 16) m/s
van = new Truck at (0, -5.4), facing 0 deg, with regionContainedIn None
behavior Runs():
    while (distance from self to ego) > 26 m:
        wait
    do WalkForwardBehavior(3 m/s)
child = new Pedestrian at (5.5, -6.5), facing 90 deg, with speed 0 m/s, with behavior Runs(),
    with regionContainedIn None
ego = new Car at (-60, -1.75), facing 0 deg, with speed V
terminate after 15 s
"""


def test_adapted_speed_avoids_who_runs_out_from_behind_a_van() -> None:
    """On a wet road a driver that only reacts avoids no such collision; one that slows down for what it cannot see
    avoids all of them.
    """
    scenario = compile_text(VAN)
    scenes, config = scenario.sample(60, seed=2), scenario.config.simulation
    said = blame(scenario.program, scenes, config)
    found = [each for each in counterfactuals(scenario.program, scenes, config) if each is not None]
    assert len(found) > 10
    assert (said == Blame.AVOIDABLE).sum() < 0.2 * len(found)
    assert sum(each.adapted_speed for each in found) > 0.9 * len(found)
