"""Buildings are walls: who slides or drives into one is stopped by it, and the ego's run ends there."""

import math

import numpy as np
import pytest

from benchmarks.agreement import TOLERANCE, compare
from cortex_dsl import Scenario, compile_text, load
from engine import batch, world
from engine.interchange.recording import recorded_run
from engine.kernels.geometry import Box, box_distance
from engine.scenes import Trajectory
from engine.tables import A_BUILDING
from engine.vocabulary import EndReason, State

INTO = """
map intersection(ways=4, lanes=1, approach=50 m, buildings=3.5 m)
behavior Straight():
    while True:
        wait
ego = new Car at (0 m, -40 m), facing 0 deg, with speed 10 m/s, with drag 0, with behavior Straight(),
    with allowCollisions True, with regionContainedIn None
other = new Car at (-40 m, 1.75 m), facing 180 deg, with speed 0 m/s
terminate after 4 s
"""


def run_of(text: str) -> tuple[Scenario, world.WorldRun]:
    scenario = compile_text(text)
    return scenario, world.run(scenario.program, scenario.sample(1), 0, scenario.config)


def deepest(scenario: Scenario, trajectory: Trajectory) -> float:
    """How far any outline, made smaller by so much on each side, still reaches into a building [m]."""
    deepest = 0.0
    for states in trajectory.states:
        for actor, (length, width) in enumerate(trajectory.outlines.tolist()):
            x, y, heading = states[actor, : State.HEADING + 1].tolist()
            for wall in scenario.program.road.buildings.tolist():
                while box_distance(Box(x, y, heading, length - 2 * deepest, width - 2 * deepest), Box(*wall)) == 0.0:
                    deepest += 0.005
                    assert deepest < 0.5
    return deepest


def test_the_ego_that_drives_into_a_building_has_crashed() -> None:
    """The road does not end its run; the wall does, when its front is there."""
    scenario, run = run_of(INTO)
    outcomes, front = run.outcomes, 0.5 * float(run.trajectory.outlines[0, 0])
    assert outcomes.end_reason[0] == EndReason.BUILDING
    assert outcomes.contact_actors[0].tolist() == [0, A_BUILDING]
    assert not outcomes.collided[0]  # risk is of pairs, and C is 0
    blocks = scenario.program.road.buildings.tolist()
    wall = min(x - length / 2 for x, y, _, length, width in blocks if x > 0 and abs(y + 40) < width / 2)
    assert outcomes.end_time[0] == pytest.approx((wall - front) / 10.0, abs=1e-4)
    assert outcomes.left_road_time[0, 0] < outcomes.end_time[0]
    np.testing.assert_array_equal(outcomes.end_time, scenario.simulate(scenario.sample(1)).end_time)


def test_what_the_wall_does_is_told() -> None:
    """It gives back what restitution says, and stops the rest."""
    scenario, run = run_of(INTO)
    (impact,) = run.impacts
    assert impact.actors == (0, A_BUILDING)
    assert impact.delta_v == (pytest.approx(10.0 * (1.0 + scenario.config.contact.restitution), rel=0.02), 0.0)
    assert impact.clock[0] == 12
    assert deepest(scenario, run.trajectory) < 0.02


def test_a_recording_of_it_ends_there() -> None:
    scenario, run = run_of(INTO)
    recording = recorded_run(scenario.program, scenario.sample(1), run, step=scenario.config.simulation.time_step)
    assert recording.contact is not None
    assert recording.contact.actors == (0,)


PINCHED = """
map intersection(ways=4, lanes=1, approach=50 m, buildings=8 m)
behavior Straight():
    while True:
        wait
ego = new Car at (-40 m, 1.75 m), facing 180 deg, with speed 0 m/s
bus = new Bus at (-1 m, -30 m), facing 0 deg, with speed 10 m/s, with drag 0, with behavior Straight(),
    with regionContainedIn None
bike = new Bicycle at (10.5 m, -30 m), facing {facing} deg, with speed 0 m/s, with regionContainedIn None
terminate after 2 s
"""


@pytest.mark.parametrize("facing", [0, 60, 90])
def test_a_bicycle_between_a_bus_and_a_building(facing: int) -> None:
    """Nobody is ever faster than the bus was and its rebound, and no delta-V is more than masses and speeds allow."""
    scenario, run = run_of(PINCHED.format(facing=facing))
    assert any(impact.actors == (2, A_BUILDING) for impact in run.impacts)
    steps = np.hypot(*np.diff(run.trajectory.states[:, 1:, :2], axis=0).transpose(2, 0, 1))
    most = 10.0 * (1.0 + scenario.config.contact.restitution)
    assert steps.max() <= most * scenario.config.simulation.time_step + 1e-6
    for impact in run.impacts:
        assert max(impact.delta_v) <= 2.0 * most


def test_nobody_is_shoved_through_a_wall() -> None:
    """Cars that slide about between buildings: both hosts alike, and nobody inside a block."""
    scenario = load("tests/agreement/walls.scn")
    found = compare(scenario, 40, seed=1)
    assert found.flags_differ == 0
    assert max(found.states_differ, found.metrics_differ) <= TOLERANCE
    scenes = scenario.sample(12, seed=3)
    ends = scenario.simulate(scenes).end_reason
    assert EndReason.BUILDING in ends
    met = 0
    for row in np.flatnonzero(scenes.valid).tolist():
        trajectory = batch.trajectory(scenario.program, scenes, row, scenario.config.simulation)
        assert deepest(scenario, trajectory) < 0.02
        run = world.run(scenario.program, scenes, row, scenario.config)
        assert deepest(scenario, run.trajectory) < 0.05
        met += sum(A_BUILDING in impact.actors for impact in run.impacts)
        assert all(math.isfinite(value) for impact in run.impacts for value in impact.delta_v)
    assert met > 0
