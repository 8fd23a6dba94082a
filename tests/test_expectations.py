"""Expectations and numbers of the run in both hosts, on runs that can be worked out by hand.

The ego drives east at 10 m/s from x = -40 m; a step is 0.05 s. A parked truck stands across its way, or nothing does.
"""

from pathlib import Path

import numpy as np
import pytest

from cortex_dsl import Scenario, compile_text
from engine.metrics import bodies_of, measure_trajectory
from engine.outcomes import Outcomes
from engine.program import load_program, save_program
from engine.vocabulary import EndReason, Sense, Verdict

HEAD = "map intersection(approach=60 m)\nsimulation(time_step=0.05 s, max_time=2 s)\n"
EGO = (
    "ego = new Car at (-40, -1.75), facing 0 deg, with speed 10 m/s, with length 4 m, "
    "with behavior ConstantSpeedBehavior(10 m/s)\n"
)
TRUCK = "truck = new Truck at (-20.38, -1.75), facing 0 deg, with length 8 m\n"
CONTACT = -20.38 - 4.0 - 2.0
"""Where the centre of the ego is when it touches the truck [m]: between two samples."""
TIME = (CONTACT + 40.0) / 10.0
"""When it does [s]."""

ENGINES = pytest.mark.parametrize("engine", ["batch", "world"])


def run(text: str, engine: str = "batch") -> tuple[Scenario, Outcomes]:
    scenario = compile_text(HEAD + EGO + text)
    return scenario, scenario.simulate(scenario.sample(1), engine)


def sought(text: str, engine: str) -> list[float]:
    return run(text, engine)[1].sought[0].tolist()


def broken(text: str, engine: str) -> list[float]:
    return run(text, engine)[1].broken[0].tolist()


@ENGINES
def test_what_is_kept_and_what_is_broken(engine: str) -> None:
    """The least margin over the samples is the robustness; nothing is rejected, and a lone ego drives on."""
    text = (
        "expect always ego.speed < 12 m/s\nexpect always ego.speed > 12 m/s\nexpect eventually ego.x > -30 m\n"
        "expect next ego.x > -40 m\nexpect always next ego.x > -99 m\nexpect ego.x < -30 m until ego.x > -31 m\n"
    )
    _, outcome = run(text, engine)
    assert (outcome.verdict[0], outcome.end_reason[0]) == (Verdict.VALID, EndReason.TIMEOUT)
    np.testing.assert_allclose(outcome.sought[0], [2.0, -2.0, 10.0, 0.5, -np.inf, 0.5], atol=1e-9)
    assert outcome.broken[0].tolist() == [0.0, 1.0, 0.0, 0.0, 1.0, 0.0]


@ENGINES
def test_the_instant_of_contact_is_judged(engine: str) -> None:
    """A formula reads where the ego is when it touches, between two samples; the distance is then 0 exactly."""
    text = (
        f"{TRUCK}expect always ego.x < -26 m\nexpect always (minimum distance from ego to truck) > 0 m\n"
        "expect always (minimum distance to truck) > 1 m\nexpect always not (ego intersects truck)\n"
        "expect always not self.collided\nexpect eventually self.collided\n"
    )
    _, outcome = run(text, engine)
    assert outcome.collided[0]
    assert outcome.end_time[0] == pytest.approx(TIME, abs=1e-6)
    np.testing.assert_allclose(outcome.sought[0], [-26.0 - CONTACT, 0.0, -1.0, 0.0, -1.0, 1.0], atol=1e-5)
    assert outcome.sought[0, 1] == outcome.sought[0, 3] == 0.0
    assert outcome.broken[0].tolist() == [0.0, 1.0, 1.0, 1.0, 1.0, 0.0]


@ENGINES
def test_requirements_stop_before_contact(engine: str) -> None:
    """What is required of the run is judged as ever, and what is measured is the same."""
    required = f"{TRUCK}require always (minimum distance from ego to truck) > 0 m\n"
    _, plain = run(required, engine)
    _, judged = run(required + "expect always not self.collided\n", engine)
    for name in ("verdict", "end_reason", "end_time", "min_distance", "ego_speed", "hidden_time", "first_seen"):
        np.testing.assert_array_equal(getattr(plain, name), getattr(judged, name))


@ENGINES
def test_reducers_include_contact(engine: str) -> None:
    """Over the samples and contact, at their times; `final` is the last sample before it, as of a record."""
    text = (
        f"{TRUCK}maximize largest(ego.x)\nmaximize least(ego.x)\nmaximize final(ego.x)\nmaximize mean(ego.x)\n"
        "maximize total(ego.speed)\nmaximize total(self.collided)\nmaximize end_time\n"
    )
    last = -40.0 + 0.5 * np.floor(TIME / 0.05)
    expected = [CONTACT, -40.0, last, (CONTACT - 40.0) / 2.0, CONTACT + 40.0, (TIME % 0.05) / 2.0, TIME]
    np.testing.assert_allclose(sought(text, engine), expected, atol=1e-5)


@ENGINES
def test_without_contact_the_run_ends_at_a_sample(engine: str) -> None:
    """The time limit of 2 s: the integral is the way, the mean of a linear course its middle."""
    text = "maximize total(ego.speed)\nmaximize mean(ego.x)\nmaximize largest(ego.x) - final(ego.x)\n"
    np.testing.assert_allclose(sought(text, engine), [20.0, -30.0, 0.0], atol=1e-9)


@ENGINES
def test_results_by_name_are_the_metrics(engine: str) -> None:
    """Delta-V and PET are those that a single run lists."""
    text = TRUCK + "maximize delta_v\nminimize post_encroachment_time\nminimize min_distance\nmaximize closing_speed\n"
    scenario, outcome = run(text, engine)
    scenes = scenario.sample(1)
    trajectory = scenario.watch(scenes).trajectory
    bodies = bodies_of(scenario.program, scenes.values[0])
    listed = {each.name: each.value for each in measure_trajectory(trajectory, outcome, bodies)}
    expected = [listed["dV_ego"], abs(listed["PET"]), 0.0, outcome.closing_speed[0, 0]]
    np.testing.assert_allclose(outcome.sought[0], expected, atol=1e-9)
    assert listed["dV_ego"] == pytest.approx(10.0 * bodies[1].mass / (bodies[0].mass + bodies[1].mass))


@ENGINES
def test_a_number_that_is_none_breaks_the_run(engine: str) -> None:
    """An error, never a result; it says which objective it was."""
    text = f"{TRUCK}expect always ego.speed > 1 m/s\nmaximize largest(log(ego.x / 1 m))\n"
    _, outcome = run(text, engine)
    assert (outcome.verdict[0], outcome.end_reason[0], outcome.end_rule[0]) == (Verdict.ERROR, EndReason.BROKEN, 1)
    assert not outcome.collided[0]
    for name in ("sought", "broken", "min_distance", "lateral_grip"):
        assert np.isnan(getattr(outcome, name)[0]).all()
    assert outcome.side[0, 0] == -1


@ENGINES
def test_equal_infinities_are_no_error(engine: str) -> None:
    """Two that nothing threatens are equally safe: at 0 the verdict decides."""
    text = (
        "other = new Car at (-40, 1.75), facing 180 deg\nexpect always timeToCollision(ego) >= timeToCollision(other)\n"
    )
    _, outcome = run(text, engine)
    assert (outcome.verdict[0], outcome.sought[0, 0], outcome.broken[0, 0]) == (Verdict.VALID, 0.0, 0.0)


@ENGINES
def test_depth_in_a_region(engine: str) -> None:
    """How far the outline is from the edge of its lane; outside, how far it sticks out."""
    half = 0.5 * (3.5 - 1.61)
    text = "expect always ego in road\nexpect always ego.position in road\nterminate after 1 s\n"
    np.testing.assert_allclose(sought(text, engine), [half, 1.75], atol=1e-6)
    on_the_edge = EGO.replace("-1.75)", "-3.5), with regionContainedIn None")
    scenario = compile_text(HEAD + on_the_edge + text)
    outcome = scenario.simulate(scenario.sample(1), engine)
    np.testing.assert_allclose(outcome.sought[0], [-0.5 * 1.61, 0.0], atol=1e-6)
    assert outcome.broken[0, 0] == 1.0


def test_a_saved_program_judges_the_same(tmp_path: Path) -> None:
    """Objectives are part of the file and of its digest."""
    scenario, outcome = run(f"{TRUCK}expect always not self.collided as 'whole'\nmaximize largest(ego.speed)\n")
    save_program(scenario.program, tmp_path / "program.npz")
    program = load_program(tmp_path / "program.npz")
    assert [(each.name, each.sense) for each in program.judged.objectives] == [
        ("whole", Sense.EXPECT),
        ("largest(ego.speed)", Sense.MAXIMIZE),
    ]
    from engine.batch import simulate

    again = simulate(program, scenario.sample(1), scenario.config.simulation)
    np.testing.assert_array_equal(again.sought, outcome.sought)
    other, _ = run(f"{TRUCK}expect always not self.collided as 'whole'\nminimize largest(ego.speed)\n")
    assert other.program.digest != program.digest
