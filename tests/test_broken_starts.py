"""A scene whose first sample already breaks a temporal requirement is no scene; nor is one with a number outside of its
domain. Both are requirements with names and counts of their own.
"""

import numpy as np
import pytest

from cortex_dsl import CompileError, compile_text
from cortex_dsl.api.scenario import Scenario
from engine import batch
from engine.scenes import actor_columns
from engine.tables import Bools
from engine.vocabulary import Column, EndReason

SCENE = """
map intersection(approach=100 m)
lane = intersection.incomingLanes[0]
behavior Slow():
    while True:
        take SetBrakeAction(0.2)
ego = new Car before intersection by Range(20, 60) m along [lane], with speed Range(0, 20) m/s, with behavior Slow()
other = new Car before intersection by 80 m along [lane], with speed Range(0, 3) m/s
{line}
terminate after 2 s
"""
SCENES = 300


def compiled(line: str) -> Scenario:
    return compile_text(SCENE.format(line=line))


def held_at_start(condition: str) -> Bools:
    """(SCENES,): in which scenes of the plain file a condition holds at the first sample, by the run itself."""
    scenario = compiled(f"record initial {condition} as found")
    scenes = scenario.sample(SCENES, seed=7)
    runs = [batch.trajectory(scenario.program, scenes, row, scenario.config.simulation) for row in range(SCENES)]
    return np.array([run.watched[0, 0] != 0.0 for run in runs])


NEAR = "(distance from ego to other) < 45 m"
FAST = "ego.speed > 8 m/s"


@pytest.mark.parametrize(
    ("requirement", "may_hold"),
    [
        (f"always {NEAR}", NEAR),
        (f"always not ({FAST})", f"not ({FAST})"),
        (f"({FAST}) until ({NEAR})", f"({FAST}) or ({NEAR})"),
        (f"({FAST}) implies (always {NEAR})", f"(not ({FAST})) or ({NEAR})"),
        (f"(always {NEAR}) and (eventually {FAST})", NEAR),
        (f"(always {NEAR}) or (always {FAST})", f"({NEAR}) or ({FAST})"),
        (f"not (eventually {FAST})", f"not ({FAST})"),
    ],
)
def test_attempts_are_rejected_by_what_the_first_sample_says(requirement: str, may_hold: str) -> None:
    """The very scenes whose first sample, by the run, leaves no continuation; counted under a name of their own."""
    scenario = compiled(f"require {requirement}\nsimulation(max_attempts=1)")
    scenes = scenario.sample(SCENES, seed=7)
    np.testing.assert_array_equal(scenes.valid, held_at_start(may_hold))
    first = scenario.program.requirements[0]
    assert first.name == f"{' '.join(requirement.split())} (at the start)"
    assert scenes.failed[:, 0].sum() == (~scenes.valid).sum() > 10


@pytest.mark.parametrize(
    "requirement",
    [
        f"eventually {NEAR}",
        f"next {NEAR}",
        f"(eventually {NEAR}) or (always {FAST})",
        f"not (always {NEAR})",
        f"not (({FAST}) until ({NEAR}))".replace("until (", "until (ego.speed > 3 m/s and "),
        "always Range(0, 1) < 0.9",
        "always ego.throttle < 0.5",
    ],
)
def test_what_may_come_is_not_rejected(requirement: str) -> None:
    """`eventually`, `next`, what is drawn in the run, and what holds at every start add no requirement that rejects."""
    scenario = compiled(f"require {requirement}\nsimulation(max_attempts=1)")
    scenes = scenario.sample(SCENES, seed=7)
    kept = scenes.valid if requirement.startswith("not ((") else np.ones(SCENES, dtype=bool)
    np.testing.assert_array_equal(scenes.valid, kept)


def test_no_valid_scene_breaks_at_the_start() -> None:
    """Runs that `require always` aborts are aborted later than at 0."""
    scenario = compiled(f"require always {NEAR}\nrequire always {FAST}")
    outcomes = batch.simulate(scenario.program, scenario.sample(SCENES, seed=7), scenario.config.simulation)
    aborted = outcomes.end_reason == EndReason.ABORTED
    assert aborted.sum() > 20
    assert outcomes.end_time[aborted].min() > 0.0


def test_scenes_that_pass_are_the_same_as_before() -> None:
    """The requirement draws nothing: with one attempt each, what passes has the values it had without it."""
    plain = compiled("simulation(max_attempts=1)").sample(SCENES, seed=7)
    held = compiled(f"require always {NEAR}\nsimulation(max_attempts=1)").sample(SCENES, seed=7)
    np.testing.assert_array_equal(held.values[held.valid], plain.values[held.valid])


def test_it_stands_in_the_order_of_the_file() -> None:
    """Between the requirements above and below it."""
    lines = f"require {NEAR} as first\nrequire always {FAST} as second\nrequire ego.speed < 19 m/s as third"
    names = [each.name for each in compiled(lines).program.requirements]
    assert names[:3] == ["first", "second (at the start)", "third"]


def test_a_start_that_always_breaks_is_proved() -> None:
    """`--check` says that no scene can pass."""
    scenario = compiled("require always ego.speed > 30 m/s")
    assert not scenario.sample(3, seed=1).valid.any()


# -- domains ----------------------------------------------------------------------------------------------------------


def drawn(given: str, kind: str = "Car") -> Scenario:
    return compile_text(f"map intersection()\nego = new Car on road\nother = new {kind} on road, {given}\n")


@pytest.mark.parametrize(
    ("given", "kind", "column", "low", "high"),
    [
        ("with speed Normal(5, 5) m/s", "Car", Column.SPEED, 0.0, 50.8),
        ("with speed Normal(10, 5) m/s", "Bicycle", Column.SPEED, 0.0, 13.89),
        ("with length Normal(2, 2) m", "Car", Column.LENGTH, 0.0, 100.0),
        ("with mass Normal(500, 600) kg", "Obstacle", Column.MASS, 0.0, 1e6),
        ("with mass exp(Normal(10, 5)) * 1 kg", "Car", Column.MASS, 0.0, 1e6),
        ("with friction Normal(0.3, 0.3)", "Car", Column.FRICTION, 0.0, 10.0),
        ("with visibleDistance Normal(10, 20) m", "Car", Column.VIEW_DISTANCE, 0.0, np.inf),
    ],
)
def test_what_is_drawn_lies_in_its_domain(given: str, kind: str, column: Column, low: float, high: float) -> None:
    """Attempts outside are counted under `PROPERTY of NAME within its domain`."""
    scenario = drawn(given, kind)
    name = f"{given.split()[1]} of other within its domain"
    assert name in [each.name for each in scenario.program.requirements]
    scenes = scenario.sample(300, seed=2)
    values = np.array([actor_columns(scenario.program, row)[1, column] for row in scenes.values[scenes.valid]])
    assert low <= values.min() <= values.max() <= high
    assert scenes.failed[:, 0].sum() > 10


@pytest.mark.parametrize("given", ["with speed 5 m/s", "with speed Range(0, 50) m/s", "with length Range(2, 5) m"])
def test_what_cannot_leave_its_domain_is_no_requirement(given: str) -> None:
    """Bounded numbers are checked once, at compilation."""
    assert len(drawn(given).program.requirements) == 2


@pytest.mark.parametrize(
    ("given", "code"),
    [
        ("with mass -3 kg", "SCN402"),
        ("with mass 0 kg", "SCN402"),
        ("with mass 1e9 kg", "SCN402"),
        ("with mass 1e400 kg", "SCN121"),
        ("with mass Range(-3, 3) kg", "SCN403"),
        ("with speed 60 m/s", "SCN437"),
        ("with speed Range(0, 60) m/s", "SCN437"),
        ("with topSpeed 10 m/s, with speed 40 km/h", "SCN437"),
    ],
)
def test_what_is_known_to_be_outside_is_an_error(given: str, code: str) -> None:
    """Of constants, and of numbers whose bounds are known."""
    with pytest.raises(CompileError) as error:
        drawn(given)
    assert error.value.message.startswith(code)
