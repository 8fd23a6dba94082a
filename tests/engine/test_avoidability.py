"""The reference driver, on crossings that can be worked out by hand."""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cortex_dsl import Scenario, compile_text, load
from engine import avoidability as module
from engine.avoidability import CONTACT, R157, Avoidability, Avoidance, avoidability, refuse_missing
from engine.batch import simulate
from engine.config import ContactConfig
from engine.dependence import ignores_ego
from engine.errors import ArgumentError
from engine.host import memory, plan, requested, samples_of
from engine.kernels import avoidance as kernels
from engine.kernels.bicycle import GRAVITY
from engine.kernels.perception import PATH_COLUMNS
from engine.scenes import Scenes
from engine.search.objectives import MOST_MARGIN
from engine.search.probability.monte_carlo import make_judge
from engine.verdicts import answers_and_margins, blame
from engine.vocabulary import Answer, Blame, State

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
    assert -math.inf < answer.margin < 0.0


def test_what_no_braking_avoids_is_lost() -> None:
    """Full braking without a ramp needs 26.3 m from 20 m/s."""
    (near, between, far) = (judged(braking_from_the_start(0.0, distance)) for distance in (26.0, 29.0, 34.0))
    assert near is not None
    assert near.avoidance is Avoidance.LOST
    assert between is not None
    assert between.avoidance is Avoidance.UNAVOIDABLE
    assert between.margin == -math.inf
    assert far is not None
    assert far.margin > -math.inf


def test_the_driver_brakes_no_harder_than_the_regulation_says() -> None:
    """The ego's 8 m/s^2 need 25.0 m, 0.774 g needs 26.3 m: taking over gains nothing there."""
    answer = judged(braking_from_the_start(1.0, 24.9))
    assert answer is not None
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
        if answer.avoidance in (Avoidance.LOST, Avoidance.NO_BRAKING_HELPS):
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


ALONE = """
map intersection(ways=4, lanes=1, approach=80 m)
param V = Range(20, 60) km/h, W = Range(20, 60) km/h, D = Range(10, 60) m
straight = Uniform(*filter(lambda m: m.type is ManeuverType.STRAIGHT, intersection.maneuvers))
oncoming = Uniform(*straight.reverseManeuvers).startLane
turn = Uniform(*filter(lambda m: m.type is ManeuverType.LEFT_TURN, oncoming.maneuvers))
ego = new Car before intersection by 30 m along [straight.startLane], with speed V,
    with behavior FollowTrajectoryBehavior(V, straight)
other = new Car before intersection by D along [turn.startLane], with speed W,
    with behavior {behavior}
terminate after 15 s
"""
FOLLOWS = "FollowTrajectoryBehavior(W, turn)"
THIRD = """
third = new Car following roadDirection from other for -12 m, with speed W,
    with behavior FollowTrajectoryBehavior({speed}, turn)
"""
WAITS = """
behavior Waits():
    do FollowTrajectoryBehavior(W, turn) until (distance to ego) < 15 m
    do FollowTrajectoryBehavior(W * 0.6, turn)
"""
PROGRAMS = {
    "blind": (ALONE.format(behavior=FOLLOWS), True),
    "third": (ALONE.format(behavior=FOLLOWS) + THIRD.format(speed="W"), True),
    "third runs into the other": (ALONE.format(behavior=FOLLOWS) + THIRD.format(speed="60 km/h"), True),
    "looks at the ego": (WAITS + ALONE.format(behavior="Waits()"), False),
    "random": (ALONE.format(behavior=FOLLOWS.replace("W,", "Range(10, 60) km/h,")), True),
}


@pytest.mark.parametrize("name", PROGRAMS)
def test_the_others_move_as_recorded_only_where_that_changes_nothing(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every answer, margins included, is the same as with drives that simulate the others again."""
    text, ignored = PROGRAMS[name]
    scenario = compile_text(text)
    assert ignores_ego(scenario.program) == ignored
    scenes = scenario.sample(600, seed=5)
    found = avoidability(scenario.program, scenes), blame(scenario.program, scenes).tolist()
    assert len({each and each.avoidance for each in found[0]}) > 2
    outcomes = simulate(scenario.program, scenes)
    both = outcomes.collided & np.isfinite(outcomes.others_contact_time)
    assert both.any() == name.startswith("third")
    monkeypatch.setattr(module, "ignores_ego", lambda program: False)
    again = avoidability(scenario.program, scenes), blame(scenario.program, scenes).tolist()
    assert repr(found) == repr(again)


REACTS = {
    "left_turn": EXAMPLE.read_text(encoding="utf-8"),
    "platoon": EXAMPLE.with_name("roads").joinpath("platoon.scn").read_text(encoding="utf-8"),
    "careful": ALONE.format(behavior=f"EmergencyBrakeBehavior({FOLLOWS}, foresees=False, latency=1 s)"),
    "looks at the ego": PROGRAMS["looks at the ego"][0],
    "two that touch": WAITS + ALONE.format(behavior="Waits()") + THIRD.format(speed="60 km/h"),
    "random": ALONE.format(behavior=FOLLOWS.replace("W,", "Normal(W, 3 km/h),")),
}


@pytest.mark.parametrize("name", REACTS)
def test_a_drive_from_a_checkpoint_is_the_drive_from_the_start(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where others react to the ego, every answer is the same as with drives that begin anew."""
    scenario, made = compile_text(REACTS[name]), module.checkpoints
    scenes, config = scenario.sample(200, seed=6), scenario.config.simulation
    monkeypatch.setattr(module, "ignores_ego", lambda program: False)
    found = avoidability(scenario.program, scenes, config)
    assert sum(each is not None for each in found) > 5
    monkeypatch.setattr(module, "checkpoints", lambda run, samples, *, touching: made(run, 0, touching=touching))
    assert repr(avoidability(scenario.program, scenes, config)) == repr(found)


def test_a_margin_counts_up_to_its_limit() -> None:
    """The margin behind `avoidable` is that of every moment tried, up to the limit that counts."""
    scenario = load(EXAMPLE.with_name("right_into_crossing.scn"))
    scenes, config = scenario.sample(1500, seed=1), scenario.config.simulation
    answers, limited = answers_and_margins(scenario.program, scenes, config, references=("careful",))
    complete = avoidability(scenario.program, scenes, config)
    found = [row for row in zip(complete, answers[:, 0].tolist(), limited.tolist(), strict=True) if row[0]]
    assert any(whole.margin > MOST_MARGIN + 1.0 for whole, _, _ in found if whole)
    for whole, answer, margin in found:
        assert whole is not None
        assert (answer == Answer.AVOIDS) == whole.avoidable
        assert margin <= MOST_MARGIN + 2.0 * config.time_step or not math.isfinite(margin)
        if not whole.struck and not math.isnan(whole.margin):
            assert min(margin, MOST_MARGIN) == pytest.approx(min(whole.margin, MOST_MARGIN))


def every_moment(scenario: Scenario, scenes: Scenes, row: int) -> list[bool]:
    """Whether the reference driver avoids contact when it brakes at each sample before it."""
    again, touches = driven_again(scenario, scenes, row)
    return [not touches(k) for k in range(again.contact)]


def driven_again(scenario: Scenario, scenes: Scenes, row: int) -> tuple[kernels.ReferenceDrive, Callable[[int], bool]]:
    """What the kernel says of a scene, and whether braking from a sample touches anybody."""
    config, program = scenario.config.simulation, scenario.program
    shared, rows = plan(program, config), requested(program, scenes)
    run = memory(program, samples_of(config) + 1 + math.ceil(kernels.LONGEST / config.time_step))
    path, outlines = np.zeros((len(run.states), PATH_COLUMNS)), np.zeros((len(program.actors), 3))
    case = kernels.Case(int(rows.variant[row]), rows.values[row], rows.keys[row], rows.actions[row])
    own = np.zeros((len(run.states), len(State)))
    nothing = module.checkpoints(run, 0, touching=False)
    drives = kernels.DriveMemory(
        run,
        outlines,
        path,
        own,
        independent=False,
        touching=True,
        onsets=np.zeros((0, 2), dtype=np.int64),
        conflicts=np.zeros(0),
        checkpoints=nothing,
    )
    found = kernels.resimulate_with_reference(shared, drives, case, R157)
    until = found.contact + math.ceil(kernels.AFTERWARDS / config.time_step)
    again = kernels.Replayed(
        case, found.contact, until, outlines, path[: until + 1], own, recorded=False, checkpoints=nothing
    )
    return found, lambda k: kernels.brake_from(shared, run, again, k, R157).touched


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


# -- where it is said, and of what ------------------------------------------------------------------------------------


def along_the_road(rest: str, weather: str = "") -> Scenario:
    """A long straight road to the east."""
    return compile_text(f"map intersection(ways=4, lanes=1, approach=320 m)\n{weather}\n{rest}\nterminate after 14 s\n")


def test_backwards_is_forwards_seen_from_behind() -> None:
    """An ego that backs into a car that stands gets the answer of one that runs into it forwards, pedals alike."""
    text = """
behavior Go():
    take SetReverseAction({gear})
    while True:
        take SetThrottleAction(0.5)
ego = new Car at (-150, -1.75), facing 0 deg, with behavior Go()
other = new Car at ({place}, -1.75), facing 0 deg
"""
    back, ahead = (
        judged(along_the_road(text.format(gear=gear, place=-150 + way * 25)))
        for gear, way in (("True", -1), ("False", 1))
    )
    assert ahead is not None
    assert ahead.avoidable
    assert ahead.margin > 0.5
    assert back == ahead


TOWARDS = """
ego = new Car at (-200, -1.75), facing 0 deg, with speed 30 m/s, with visibleDistance {view}
other = new Car at (-100, -1.75), facing 0 deg
"""


def test_sight_is_that_of_the_weather() -> None:
    """A car that stands 100 m ahead is within the horizon at once; in fog of 60 m it is seen when its rear is so near.
    Darkness and the ego's own view are no limits.
    """
    clear, dark, blind, fog = (
        judged(along_the_road(TOWARDS.format(view=view), weather))
        for view, weather in (
            ("50 m", ""),
            ("50 m", "environment(light=0.4)"),
            ("20 m", ""),
            ("50 m", "environment(sight=Range(59.99, 60.01) m)"),
        )
    )
    assert clear is not None
    assert clear.perceived == pytest.approx(0.4)
    assert clear == dark == blind
    assert fog is not None
    assert fog.perceived == pytest.approx((100.0 - 0.5 * 4.508 - 60.0) / 30.0 + 0.4, abs=STEP)
    assert not fog.avoidable


def test_a_drive_is_followed_until_the_driver_stands() -> None:
    """On ice it takes 204 m and 20 s from 20 m/s: a car that stands 200 m ahead is struck, though late."""
    text = """
ego = new Car at (-300, -1.75), facing 0 deg, with speed 20 m/s, with friction 0.1
other = new Car at ({place}, -1.75), facing 0 deg
"""
    near, far = (judged(along_the_road(text.format(place=-300 + way + 4.508))) for way in (200, 212))
    assert near is not None
    assert near.avoidance is Avoidance.LOST
    assert far is not None
    assert far.avoidance is Avoidance.UNAVOIDABLE


def test_only_who_drives_into_it_began_too_late() -> None:
    """Somebody comes against the ego in its own lane: whenever it stops, it is struck there."""
    answer = judged(
        along_the_road("""
ego = new Car at (-250, -1.75), facing 0 deg, with speed 5 m/s
other = new Car at (-150, -1.75), facing 180 deg, with speed 10 m/s
""")
    )
    assert answer is not None
    assert answer.avoidance is Avoidance.NO_BRAKING_HELPS


def test_who_is_struck_sooner_has_not_let_the_ego_brake_as_hard() -> None:
    """The ego touches its brakes; the reference driver's are struck from behind before the contact of old."""
    scenario = along_the_road("""
behavior Touch():
    while True:
        take SetBrakeAction(0.1)
ego = new Car at (-200, -1.75), facing 0 deg, with speed 15 m/s, with behavior Touch()
other = new Car at (-155.5, -1.75), facing 0 deg
follower = new Car at (-209.5, -1.75), facing 0 deg, with speed 15 m/s
""")
    again, _ = driven_again(scenario, scenario.sample(1), 0)
    assert again.perceived >= 0
    assert not again.avoided
    assert not again.as_hard


def test_the_answers_are_those_of_the_run_with_its_contact_settings() -> None:
    """Of a column whose cars crash: who collides, and when, hangs on restitution and friction."""
    scenario = load(EXAMPLE.parents[1] / "tests" / "agreement" / "column.scn")
    scenes, settings = scenario.sample(150, seed=4), scenario.config.simulation
    rubber = ContactConfig(restitution=0.9, friction=0.1)
    plain, bouncing = (simulate(scenario.program, scenes, settings, contact=how) for how in (CONTACT, rubber))
    assert (plain.end_time != bouncing.end_time).any()
    answers = avoidability(scenario.program, scenes, settings, contact=rubber)
    assert [answer is not None for answer in answers] == bouncing.collided.tolist()
    times = [answer.contact for answer in answers if answer is not None]
    assert times == bouncing.end_time[bouncing.collided].tolist()
    there = np.array([answer is not None for answer in answers])
    refuse_missing(bouncing.collided, there)
    with pytest.raises(ArgumentError, match="run again it does not"):
        refuse_missing(np.ones(len(answers), dtype=bool), np.concatenate([[False], there[1:]]))
    alone = replace(scenario.config.search, references=("careful",))
    config = replace(scenario.config, contact=rubber, search=alone)
    rows = np.flatnonzero(bouncing.collided)
    judge = make_judge(scenario.program, config)
    avoidable = [answer.avoidable for answer in answers if answer is not None]
    assert judge(scenes.genomes[rows], scenes.keys[rows]).tolist() == avoidable


@pytest.mark.parametrize("name", ["left_turn", "left_against_crossing"])
def test_one_drive_says_what_all_of_them_say(name: str) -> None:
    """Yes, no, or struck: of every collision the same in a word as with all moments tried, whatever the threads."""
    scenario = load(EXAMPLE.with_name(f"{name}.scn"))
    config = scenario.config.simulation
    scenes = scenario.sample(400, seed=5)
    said = blame(scenario.program, scenes, config, jobs=3)
    answers = avoidability(scenario.program, scenes, config)
    assert said.tolist() == [_in_a_word(answer) for answer in answers]
    assert (said == Blame.AVOIDABLE).any()
    assert (said == Blame.UNAVOIDABLE).any()
    np.testing.assert_array_equal((said != Blame.NONE), simulate(scenario.program, scenes, config).collided)
    np.testing.assert_array_equal(said, blame(scenario.program, scenes, config))


def _in_a_word(answer: Avoidability | None) -> Blame:
    if answer is None:
        return Blame.NONE
    if answer.struck:
        return Blame.STRUCK
    return Blame.AVOIDABLE if answer.avoidable else Blame.UNAVOIDABLE
