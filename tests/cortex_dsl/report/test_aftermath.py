"""What is reported after contact: the speed of bodies that slide sideways, and when they lie still."""

import numpy as np
import pytest

from cortex_dsl import compile_text
from cortex_dsl.report.findings.story import aftermath, speeds
from engine.vocabulary import State
from engine.world import WorldRun
from engine.world.pymunk_host import EventKind

STRUCK = """\
map intersection(approach=80 m)

mine = Uniform(*filter(lambda m: m.type is ManeuverType.STRAIGHT, intersection.maneuvers))

ego = new Car before intersection by 40 m along mine,
    with speed 36 km/h,
    with behavior FollowTrajectoryBehavior(36 km/h, mine)
walker = new Pedestrian ahead of ego by 12 m, facing ego.heading + 90 deg, with behavior WalkForwardBehavior(0.3 m/s)

terminate after 10 s
"""


@pytest.fixture(scope="module")
def struck() -> WorldRun:
    """Somebody on foot is struck from the side and thrown at the speed of the car."""
    scenario = compile_text(STRUCK)
    return scenario.watch(scenario.sample(1))


def test_a_thrown_body_is_as_fast_as_it_moves(struck: WorldRun) -> None:
    """Along its own heading it hardly moves; its centre moves at the speed that the blow gave it."""
    after = struck.trajectory.contact_sample + 1
    along = abs(struck.trajectory.states[after, 1, State.SPEED])
    shown = speeds(struck.trajectory)[after, 1]
    assert along < 1.0
    assert shown == pytest.approx(struck.impacts[0].delta_v[1], abs=1.0)
    assert shown > 8.0


def test_up_to_contact_speeds_are_those_of_the_drive(struck: WorldRun) -> None:
    """Nothing is changed that was scored."""
    scored = slice(struck.trajectory.contact_sample + 1)
    assert np.array_equal(speeds(struck.trajectory)[scored], struck.trajectory.states[scored, :, State.SPEED])


def test_rest_is_reported_when_the_world_sees_it(struck: WorldRun) -> None:
    """Within two samples of when the bodies stood still, and long after the blow."""
    scenario = compile_text(STRUCK)
    rests = {
        m.actor: m.time for m in aftermath(scenario.program, struck.impacts, struck.trajectory) if m.kind == "rest"
    }
    seen = {event.actors[0]: event.time for event in struck.events if event.kind == EventKind.REST}
    assert rests.keys() == seen.keys() == {0, 1}
    step = float(struck.trajectory.time[1])
    for actor, time in rests.items():
        assert time == pytest.approx(seen[actor], abs=2 * step)
    assert rests[1] > float(struck.outcomes.end_time[0]) + 0.5


def test_who_has_left_has_no_speed(struck: WorldRun) -> None:
    """Before contact as after it."""
    states = struck.trajectory.states.copy()
    states[:, 1, State.PRESENT] = 0.0
    gone = speeds(type(struck.trajectory)(struck.trajectory.time, states, struck.trajectory.outlines, 3))
    assert np.isnan(gone[:, 1]).all()
    assert not np.isnan(gone[:, 0]).any()
