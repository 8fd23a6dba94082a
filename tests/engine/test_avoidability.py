"""The reference driver, on crossings that can be worked out by hand."""

import math
from pathlib import Path

import numpy as np
import pytest

from cortex_dsl import Scenario, compile_text, load
from engine.avoidability import AFTERWARDS, GRAVITY, R157, Avoidability, Avoidance, avoidability
from engine.avoidability import _outlines as outlines_of
from engine.host import memory, plan, requested, samples_of
from engine.interchange.measuring import measure
from engine.interchange.recording import recorded_run
from engine.kernels import avoidance as kernels
from engine.scenes import Scenes
from engine.vocabulary import Fault
from engine.world import run

STEP = 0.05
EXAMPLE = Path(__file__).parents[2] / "examples" / "left_turn.scn"


def crossing(ego_distance: float, other_distance: float) -> Scenario:
    """At 10 m/s, the ego north and the other east. Distances of centres to where the lanes cross."""
    return compile_text(
        f"""
map intersection(ways=4, lanes=1)
ego = new Car at (1.75, {-1.75 - ego_distance}), facing 90 deg, with speed 10 m/s
other = new Car at ({1.75 - other_distance}, -1.75), facing 0 deg, with speed 10 m/s
terminate after 10 s
"""
    )


def judged(scenario: Scenario) -> Avoidability | None:
    scenes = scenario.sample(1)
    (answer,) = avoidability(scenario.program, scenes, scenario.config.simulation)
    return answer


def stopping_distance(speed: float) -> float:
    """Of the reference driver, once the brakes take hold."""
    ramp_loss = 0.5 * R157.deceleration * R157.ramp
    on_ramp = speed * R157.ramp - R157.deceleration * R157.ramp**2 / 6.0
    return on_ramp + (speed - ramp_loss) ** 2 / (2.0 * R157.deceleration)


def test_what_is_seen_early_is_avoidable() -> None:
    """Contact 3.7 s ahead is in sight at once: perceived after 0.4 s, braked for 0.75 s later, in good time."""
    answer = judged(crossing(40.0, 40.0))
    assert answer is not None
    assert answer.avoidance is Avoidance.AVOIDABLE
    assert answer.perceived == pytest.approx(0.4)
    assert answer.braking == pytest.approx(1.15)


def test_contact_is_the_instant_and_no_end_of_a_step() -> None:
    """The front of the ego reaches the side of the other, 10 m/s each, after 36.94 m: within the step from 3.65 s."""
    answer = judged(crossing(40.0, 40.0))
    assert answer is not None
    reach = 40.0 - 0.5 * 1.61 - 0.5 * 4.508
    assert answer.contact == pytest.approx(reach / 10.0, abs=1e-3)


def test_the_margin_is_what_stopping_takes() -> None:
    """The last moment is when the way to the side of the other's lane of travel is the stopping distance."""
    answer = judged(crossing(40.0, 40.0))
    assert answer is not None
    to_the_side = 40.0 - 0.5 * 1.61 - 0.5 * 4.508
    last = (to_the_side - stopping_distance(10.0)) / 10.0
    assert answer.margin == pytest.approx(last - answer.braking, abs=STEP + 1e-9)


def test_the_margin_of_what_comes_too_late_is_negative() -> None:
    """1.3 s before contact there is time to react, but not to stop or to let the other pass."""
    answer = judged(crossing(14.0, 14.0))
    assert answer is not None
    assert answer.avoidance is Avoidance.UNAVOIDABLE
    assert answer.perceived == pytest.approx(0.4)
    assert answer.margin < 0.0


def test_too_near_for_any_driver() -> None:
    """5 m before the other's side even brakes at the first moment are too late."""
    answer = judged(crossing(6.0, 6.0))
    assert answer is not None
    assert answer.avoidance is Avoidance.LOST
    assert math.isnan(answer.margin) or answer.margin == -math.inf


def test_what_happens_at_once_is_not_perceived() -> None:
    """A conflict that is in sight for less than 0.4 s is perceived by nobody; here no braking avoids it either."""
    answer = judged(crossing(4.2, 4.2))
    assert answer is not None
    assert answer.avoidance is Avoidance.LOST
    assert math.isnan(answer.perceived)
    assert math.isnan(answer.braking)
    assert math.isnan(answer.margin)


def test_no_collision_no_answer() -> None:
    """Who passes behind the other has nothing to avoid; an invalid scene neither."""
    assert judged(crossing(40.0, 20.0)) is None
    assert judged(crossing(200.0, 40.0)) is None


def test_a_driver_who_brakes_no_later_is_never_blamed() -> None:
    """Quicker drivers avoid at least as much, and the margin grows by the time that they save."""
    scenario = crossing(40.0, 40.0)
    scenes = scenario.sample(1)
    quick = R157._replace(reaction=0.5)
    (fast,) = avoidability(scenario.program, scenes, scenario.config.simulation, quick)
    slow = judged(scenario)
    assert fast is not None
    assert slow is not None
    assert fast.margin == pytest.approx(slow.margin + 0.25)


@pytest.mark.parametrize("arm", [(90.0, 0.0), (180.0, 90.0), (270.0, 180.0), (0.0, 270.0)])
def test_the_answer_does_not_depend_on_the_arm(arm: tuple[float, float]) -> None:
    """Turned about the intersection's middle, the case is the same."""
    turn = math.radians(arm[0] - 90.0)
    spin = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    (ax, ay), (bx, by) = spin @ (1.75, -41.75), spin @ (-38.25, -1.75)
    answer = judged(
        compile_text(
            f"""
map intersection(ways=4, lanes=1)
ego = new Car at ({ax}, {ay}), facing {arm[0]} deg, with speed 10 m/s
other = new Car at ({bx}, {by}), facing {arm[1]} deg, with speed 10 m/s
terminate after 10 s
"""
        )
    )
    assert answer == judged(crossing(40.0, 40.0))


def test_an_ego_that_brakes_as_hard_is_told_apart() -> None:
    """It brakes with all it has from the start, and still cannot stop."""
    scenario = compile_text(
        """
map intersection(ways=4, lanes=1)
behavior Brake():
    while True:
        take SetBrakeAction(1)
ego = new Car at (1.75, -22), facing 90 deg, with speed 20 m/s, with behavior Brake()
other = new Car at (1.75, -1.75), facing 0 deg
terminate after 10 s
"""
    )
    answer = judged(scenario)
    assert answer is not None
    assert answer.avoidance in (Avoidance.BRAKED_AS_HARD, Avoidance.LOST)
    assert not answer.avoidable


def braking_from_the_start(brake: float, distance: float) -> Scenario:
    """The ego at 20 m/s has its pedal down from the first step; a car stands across, its side so far ahead."""
    return compile_text(
        f"""
map intersection(ways=4, lanes=1)
behavior Brake():
    while True:
        take SetBrakeAction({brake})
ego = new Car at (1.75, {-1.75 - distance - 0.5 * 1.61 - 0.5 * 4.508}), facing 90 deg, with speed 20 m/s,
    with behavior Brake()
other = new Car at (1.75, -1.75), facing 0 deg
terminate after 10 s
"""
    )


def test_who_takes_over_does_not_let_go_of_the_pedal() -> None:
    """At 7.2 m/s^2 from the start the ego needs 27.8 m; to press harder within 0.6 s of the start needs 26.8 m, but
    would need 32.2 m if the driver first let go.
    """
    answer = judged(braking_from_the_start(0.9, 27.3))
    assert answer is not None
    assert not answer.lost
    assert -math.inf < answer.margin < 0.0


def test_what_no_braking_avoids_is_lost() -> None:
    """Full braking without a ramp needs 26.3 m from 20 m/s."""
    (near, between, far) = (judged(braking_from_the_start(0.0, distance)) for distance in (26.0, 29.0, 34.0))
    assert near is not None
    assert near.lost
    assert between is not None
    assert not between.lost
    assert between.margin == -math.inf
    assert far is not None
    assert far.margin > -math.inf


def test_the_driver_brakes_no_harder_than_the_regulation_says() -> None:
    """The ego's 8 m/s^2 need 25.0 m, 0.774 g needs 26.3 m: taking over gains nothing there."""
    answer = judged(braking_from_the_start(1.0, 24.9))
    assert answer is not None
    assert answer.lost
    assert answer.avoidance is Avoidance.LOST


@pytest.mark.parametrize("name", ["left_turn", "crossing_left_turn"])
def test_answers_are_those_of_every_moment_tried(name: str) -> None:
    """Braking later can be better: what is said of a case is what trying each of its samples says."""
    scenario = load(EXAMPLE.with_name(f"{name}.scn"))
    scenes = scenario.sample(400, seed=3)
    answers = avoidability(scenario.program, scenes, scenario.config.simulation)
    known = [(row, answer) for row, answer in enumerate(answers) if answer is not None and not answer.struck]
    assert len(known) > 20
    for row, answer in known:
        helps = every_moment(scenario, scenes, row)
        if answer.lost:
            assert not any(helps)
        if answer.margin == -math.inf:
            assert not any(helps)
        if math.isfinite(answer.margin):
            assert any(helps)
            begun = round(answer.braking / STEP)
            latest = begun + round(answer.margin / STEP)
            assert helps[latest]
            if answer.avoidable:
                assert all(helps[begun : latest + 1])
                assert latest + 1 == len(helps) or not helps[latest + 1]
            else:
                assert not any(helps[min(begun, latest) + 1 : max(begun, latest)])


def every_moment(scenario: Scenario, scenes: Scenes, row: int) -> list[bool]:
    """Whether the reference driver avoids contact when it brakes at each sample before it."""
    config, program = scenario.config.simulation, scenario.program
    shared, rows = plan(program, config), requested(scenes)
    extra = math.ceil(AFTERWARDS / config.time_step)
    run = memory(program, samples_of(config) + 1 + extra)
    path, outlines = np.zeros((len(run.states), kernels.PATH_COLUMNS)), outlines_of(program, rows.values[row])
    case = kernels.Case(int(rows.variant[row]), rows.values[row], rows.keys[row])
    contact = kernels.weigh(shared, run, case, outlines, path, extra, R157).contact
    until = min(contact + extra, len(run.states) - 1)
    return [
        not kernels._drive(shared, run, case, k, contact, until, outlines, path, R157).touched for k in range(contact)
    ]


def test_the_numbers_are_the_regulations() -> None:
    """UN R157, Annex 4, Appendix 3."""
    assert (R157.perception, R157.reaction, R157.ramp, R157.alarming) == (0.4, 0.75, 0.6, 5.0)
    assert R157.deceleration == pytest.approx(0.774 * GRAVITY)


# -- with the ego's own brakes, on its own road -----------------------------------------------------------------------


def standing_ahead(distance: float, more: str = "", speed: float = 15.0) -> Scenario:
    """The ego rolls east at a steady speed towards a car that stands in its lane, so far ahead."""
    return compile_text(
        f"""
map intersection(ways=4, lanes=1)
ego = new Car at (-45, -1.75), facing 0 deg, with speed {speed} m/s{more}
other = new Car at ({-45 + distance + 4.508}, -1.75), facing 0 deg
terminate after 12 s
"""
    )


@pytest.mark.parametrize(
    ("more", "braking", "ramp"),
    [
        ("", 0.774 * GRAVITY, R157.ramp),
        (", with friction 0.3", 0.3 * 9.81, R157.ramp),
        (", with maxBraking 4 m/s^2", 4.0, R157.ramp),
        (", with maxBraking 4 m/s^2, with pedalTime 1.2 s", 4.0, 1.2),
        (", with pedalTime 1.2 s", 0.774 * GRAVITY, 1.2 * 0.774 * GRAVITY / 8.0),
    ],
)
def test_the_driver_brakes_as_hard_as_tyres_and_brakes_allow(more: str, braking: float, ramp: float) -> None:
    """The last moment is when the way that is left is the stopping distance on that road, with these brakes."""
    speed, distance = 8.0, 30.0
    loss = 0.5 * braking * ramp
    stopping = speed * ramp - braking * ramp**2 / 6.0 + (speed - loss) ** 2 / (2.0 * braking)
    answer = judged(standing_ahead(distance, more, speed))
    assert answer is not None
    latest = answer.braking + answer.margin
    assert latest == pytest.approx((distance - stopping) / speed, abs=STEP + 1e-9)


def test_ice_makes_collisions_that_no_driver_avoids() -> None:
    """From 15 m/s the regulation's braking needs 20 m, that on ice 113 m."""
    dry, ice = judged(standing_ahead(40.0)), judged(standing_ahead(40.0, ", with friction 0.1"))
    assert dry is not None
    assert ice is not None
    assert dry.avoidable
    assert ice.avoidance is Avoidance.LOST


def test_nobody_braked_as_hard_who_did_not_brake() -> None:
    """Neither who rolls on, nor who stands: the label is of those alone who slowed down."""
    for distance in (18.0, 22.0, 26.0, 30.0):
        answer = judged(standing_ahead(distance))
        assert answer is not None
        assert answer.avoidance is not Avoidance.BRAKED_AS_HARD


def test_a_leader_that_brakes_hard_is_perceived_at_once() -> None:
    """40 m ahead at the same speed contact is far away; by the regulation the risk begins with the braking already."""
    text = """
map intersection(ways=4, lanes=1, approach=200 m)
behavior Brake():
    do SetSpeed() for 1 s
    while True:
        take SetBrakeAction({pedal})
behavior SetSpeed():
    while True:
        take SetThrottleAction(0)
ego = new Car at (-190, -1.75), facing 0 deg, with speed 15 m/s
other = new Car at (-150, -1.75), facing 0 deg, with speed 15 m/s, with behavior Brake()
terminate after 15 s
"""
    hard, soft = (judged(compile_text(text.replace("{pedal}", pedal))) for pedal in ("0.8", "0.5"))
    assert hard is not None
    assert soft is not None
    assert hard.perceived == pytest.approx(1.05 + 0.4, abs=STEP + 1e-9)
    assert soft.perceived > hard.perceived + 0.2


# -- fault ------------------------------------------------------------------------------------------------------------


def test_who_is_struck_from_behind_has_not_failed() -> None:
    """The ego drives slowly on, another runs into its rear; the same the other way round is the ego's."""
    text = """
map intersection(ways=4, lanes=1)
ego = new Car at ({0}, -1.75), facing 0 deg, with speed {1} m/s
other = new Car at ({2}, -1.75), facing 0 deg, with speed {3} m/s
terminate after 12 s
"""
    struck = judged(compile_text(text.format(-30, 3, -50, 12)))
    assert struck is not None
    assert struck.avoidance is Avoidance.STRUCK_FROM_BEHIND
    assert struck.struck
    own = judged(compile_text(text.format(-50, 12, -30, 3)))
    assert own is not None
    assert not own.struck


@pytest.mark.parametrize(
    ("place", "expected"),
    [((-30.0, -1.75), Avoidance.STRUCK_STANDING), ((0.0, -1.75), Avoidance.LOST)],
)
def test_who_stands_where_one_may_stand_has_not_failed(place: tuple[float, float], expected: Avoidance) -> None:
    """In its lane before an intersection, but not in the middle of it."""
    x, y = place
    answer = judged(
        compile_text(
            f"""
map intersection(ways=4, lanes=1)
ego = new Car at ({x}, {y}), facing 0 deg
other = new Car at ({x + 25}, {y}), facing 180 deg, with speed 10 m/s
terminate after 12 s
"""
        )
    )
    assert answer is not None
    assert answer.avoidance is expected


def test_both_hosts_and_a_recording_say_whose_failure_it_was() -> None:
    """The same for every collision of an example."""
    scenario = load(EXAMPLE)
    scenes = scenario.sample(60, seed=2)
    outcomes = scenario.simulate(scenes)
    for row in np.flatnonzero(outcomes.collided).tolist()[:12]:
        ran = run(scenario.program, scenes, row, scenario.config)
        assert ran.outcomes.fault[0].tolist() == outcomes.fault[row].tolist()
        recording = recorded_run(scenario.program, scenes, ran, row=row, step=scenario.config.simulation.time_step)
        assert measure(recording).outcomes.fault[0].tolist() == outcomes.fault[row].tolist()
    touched = outcomes.fault[outcomes.collided].max(axis=1)
    assert set(touched.tolist()) <= {int(fault) for fault in Fault}
    assert (outcomes.fault[~outcomes.collided] == -1).all()
