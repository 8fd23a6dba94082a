"""A step and the ends of a run."""

import math
from dataclasses import replace

import numpy as np
import pytest

from engine import batch, host
from engine.config import ContactConfig, SimulationConfig
from engine.kernels.rollout import advance, begin
from engine.kernels.run_state import HOSTED, Memory, Status
from engine.opcodes import Op
from engine.vehicles import MODELS
from engine.vocabulary import ActorKind, Column, Command, EndReason, ManeuverType, RuleKind, State, TemporalOp, Verdict

CAR, PEDESTRIAN, OBSTACLE = ActorKind.CAR, ActorKind.PEDESTRIAN, ActorKind.OBSTACLE
STEP = 0.05
CAR_LENGTH = MODELS[CAR].length


def lone(hand, *commands, speed: float = 10.0, kind: ActorKind = CAR, turns: int = 4, **changes: float):
    """States of one actor that takes the commands `(command, value), …` in one turn each, then coasts."""
    code = hand.assembler(kind)
    code.behaviour(0)
    for turn in commands:
        for command, value in turn:
            code.emit(Op.COMMAND, 0, int(command), hand.literal(value))
        code.emit(Op.YIELD, 0, 0)
    code.emit(Op.HALT)
    scene = hand.scenes([hand.placed(kind, 0, 0, 0, speed, **changes)])
    return hand.states(code.program(hand.road()), scene, max_time=turns * STEP)[:, 0]


def coasting(hand, *blocks, **settings):
    """Outcome of actors without behaviours."""
    kinds = [block[0] for block in blocks]
    scene = hand.scenes([hand.placed(*block) for block in blocks])
    return hand.outcome(hand.assembler(*kinds).program(hand.road()), scene, **settings)


def test_the_first_sample_is_the_scene(hand) -> None:
    """Sample 0 holds place and speed of the scene, wheels straight, pedals up."""
    states = lone(hand, speed=7.0)
    assert list(states[0]) == [0, 0, 0, 7, 0, 0, 0, 0, 1]


def test_no_pedal_is_coasting_and_pedals_last_one_step(hand) -> None:
    """Full throttle for one turn adds 3 m/s^2 for one step; then the speed stays."""
    states = lone(hand, [(Command.THROTTLE, 1.0)])
    assert states[:, State.SPEED] == pytest.approx([10, 10.15, 10.15, 10.15, 10.15])
    assert states[:, State.ACCELERATION] == pytest.approx([0, 3, 0, 0, 0])
    assert list(states[:, State.THROTTLE]) == [0, 1, 0, 0, 0]


def test_brake_beats_throttle_and_pedals_are_cut_at_one(hand) -> None:
    """Both pedals: half braking, 4 m/s^2. More than full is full."""
    states = lone(hand, [(Command.THROTTLE, 1.0), (Command.BRAKE, 0.5)], [(Command.BRAKE, 7.0)])
    assert states[:3, State.ACCELERATION] == pytest.approx([0, -4, -8])
    assert list(states[:3, State.BRAKE]) == [0, 0.5, 1]


def test_steering_stays(hand) -> None:
    """A steering angle that is asked for once is kept; the wheels turn towards it at 0.7 rad/s."""
    states = lone(hand, [(Command.STEER, 0.1)], turns=6)
    assert states[:, State.STEER] == pytest.approx([0, 0.035, 0.07, 0.1, 0.1, 0.1, 0.1])


def test_a_set_speed_holds_for_the_whole_step(hand) -> None:
    """The speed is there at once, is not counted as acceleration, and never negative."""
    states = lone(hand, [(Command.SPEED, 4.0)], [(Command.SPEED, -4.0)])
    assert list(states[:3, State.SPEED]) == [10, 4, 0]
    assert states[1, State.X] == pytest.approx(4 * STEP)
    assert states[1, State.ACCELERATION] == 0.0


def test_the_rear_axle_never_slips_sideways(hand) -> None:
    """Between two samples the rear axle moves along the mean heading, the centre swings out."""
    states = lone(hand, [(Command.STEER, 0.4)], speed=4.0, turns=60)
    heading = states[:, State.HEADING]
    to_center = MODELS[CAR].rear_to_center
    rear = states[:, [State.X, State.Y]] - to_center * np.column_stack([np.cos(heading), np.sin(heading)])
    way = np.diff(rear, axis=0)
    middle = (heading[1:] + heading[:-1]) / 2
    assert way[:, 1] * np.cos(middle) - way[:, 0] * np.sin(middle) == pytest.approx(np.zeros(60), abs=1e-12)
    assert heading[-1] > 1.0


def test_a_pedestrian_walks_and_an_obstacle_stands(hand) -> None:
    """A walker turns at once, once, and keeps to its top speed; a thing keeps its place whatever it is asked to do."""
    walker = lone(hand, [(Command.STEER, 1.0)], kind=PEDESTRIAN, speed=99.0)
    assert list(walker[:3, State.HEADING]) == [0, 1, 1]
    assert np.all(walker[:, State.SPEED] == MODELS[PEDESTRIAN].top_speed)
    thing = lone(hand, [(Command.SPEED, 5.0), (Command.STEER, 1.0)], kind=OBSTACLE, speed=3.0)
    assert np.all(thing[:, [State.X, State.Y, State.HEADING, State.SPEED]] == 0)


def test_timeout(hand) -> None:
    """A run that nothing ends is ended by the time limit; one between two samples counts as the later."""
    far = (CAR, 0, 0, 0, 1), (CAR, 0, 30, 0, 1)
    for limit in (0.98, 1.0):
        outcome = coasting(hand, *far, max_time=limit)
        assert outcome.end_reason[0] == EndReason.TIMEOUT
        assert outcome.end_time[0] == pytest.approx(1.0)
        assert outcome.steps[0] == 20


def test_collision_time_is_continuous(hand) -> None:
    """Two cars head on touch when the gap between their bumpers is driven, in the middle of a step."""
    outcome = coasting(hand, (CAR, 0, 0, 0, 10), (CAR, 30, 0, math.pi, 13))
    assert outcome.collided[0]
    assert outcome.end_reason[0] == EndReason.COLLISION
    assert outcome.end_time[0] == pytest.approx((30 - MODELS[CAR].length) / 23, abs=2e-5)
    assert list(outcome.contact_actors[0]) == [0, 1]
    assert outcome.min_distance[0, 0] == 0.0


def test_contact_between_others_is_noted_and_the_run_goes_on(hand) -> None:
    """Two others crash at 20 m/s; the run is the ego's, which goes on to its own end."""
    blocks = [(CAR, 0, 0, 0, 10), (CAR, 200, 50, 0, 10), (CAR, 210, 50, math.pi, 10)]
    outcome = coasting(hand, *blocks, max_time=2.0)
    assert outcome.end_reason[0] == EndReason.TIMEOUT
    assert not outcome.collided[0]
    assert list(outcome.contact_actors[0]) == [-1, -1]
    assert outcome.others_contact_time[0] == pytest.approx((10 - CAR_LENGTH) / 20, abs=1e-4)
    assert list(outcome.others_contact_actors[0]) == [1, 2]
    assert np.all(outcome.min_distance[0] > 100)


def test_nobody_else_touches_nobody_else(hand) -> None:
    """Without a contact of others there is no time of one, and nobody to name; nor where it comes after the end."""
    alone = coasting(hand, (CAR, 0, 0, 0, 10), (CAR, 10, 0, math.pi, 10))
    late = coasting(hand, (CAR, 0, 0, 0, 10), (CAR, 6, 0, 0, 0), (CAR, 60, 50, 0, 10), (CAR, 80, 50, math.pi, 10))
    for outcome in (alone, late):
        assert outcome.collided[0]
        assert np.isnan(outcome.others_contact_time[0])
        assert list(outcome.others_contact_actors[0]) == [-1, -1]


def test_what_others_do_after_the_end_of_a_run_is_none_of_its_results(hand) -> None:
    """A temporal requirement breaks at 0.5 s, two others crash at 1.3 s; the run is over by then."""
    blocks = [(CAR, 0, 0, 0, 10), (CAR, 200, 50, 0, 10), (CAR, 230, 50, math.pi, 10)]
    code = hand.assembler(*(block[0] for block in blocks))
    rule = code.rule(hand.temporary(1), RuleKind.WATCH)
    code.emit(Op.TIME, hand.temporary(0))
    code.emit(Op.LT, hand.temporary(1), hand.temporary(0), hand.literal(0.5 - 1e-9))
    code.emit(Op.END)
    program, scene = code.program(hand.road()), hand.scenes([hand.placed(*block) for block in blocks])
    assert hand.outcome(program, scene, max_time=2.0).others_contact_time[0] == pytest.approx(1.275, abs=0.01)
    code.temporal(code.node(TemporalOp.ALWAYS, code.node(TemporalOp.ATOM, rule)))
    outcome = hand.outcome(code.program(hand.road()), scene, max_time=2.0)
    assert outcome.verdict[0] == Verdict.ABORTED
    assert outcome.end_time[0] == pytest.approx(0.5)
    assert np.isnan(outcome.others_contact_time[0])
    assert list(outcome.others_contact_actors[0]) == [-1, -1]


def test_drivers_know_how_a_sliding_body_moves(hand) -> None:
    """Struck at its side, a car slides across its heading: its velocity and its speed as a leader are its centre's."""
    path = hand.route("south", ManeuverType.STRAIGHT)
    struck, striking = hand.on_route(path, 30, 0), hand.on_route(path, 18, 12)
    struck[Column.HEADING] += math.pi / 2
    code = hand.assembler(CAR, CAR, CAR)
    for number, (op, *operands) in enumerate(
        [(Op.VELOCITY, 1), (Op.VELOCITY, 1), (Op.LEAD, 2, hand.literal(path), hand.literal(math.inf))]
    ):
        code.rule(hand.temporary(min(number, 1)), RuleKind.WATCH)
        code.emit(op, hand.temporary(0), *operands)
        code.emit(Op.END)
    scene = hand.scenes([hand.on_route(path, 5, 0), struck, striking])
    run = batch.trajectory(code.program(hand.road()), scene, 0, SimulationConfig(max_time=3.0))
    loose = np.flatnonzero(run.states[:, 1, State.PRESENT] == 2.0)
    first = int(loose[0])
    way = np.diff(run.states[first : first + 2, 1, :2], axis=0)[0] / STEP
    assert np.hypot(*way) > 3.0
    assert run.watched[first, :2] == pytest.approx(way, abs=9.81 * STEP)
    assert abs(run.states[first, 1, State.SPEED]) < 0.5
    assert not run.watched[0, :2].any()
    ahead = run.states[0, 2, State.HEADING]  # as the route leads, which is straight
    assert run.watched[first, 2] == pytest.approx(way @ [np.cos(ahead), np.sin(ahead)], abs=9.81 * STEP)
    assert run.watched[0, 2] == 0.0


def crash(hand, *blocks, max_time: float = 2.0, **settings):
    """Outcomes and states of coasting cars, the ego far away."""
    program = hand.assembler(CAR, *(block[0] for block in blocks)).program(hand.road())
    far = hand.placed(CAR, 5000, 0, 0, 0)
    others = [hand.placed(*block[:5], **(block[5] if len(block) > 5 else {})) for block in blocks]
    scenes = hand.scenes([far, *others])
    outcome = hand.outcome(program, scenes, max_time=max_time, **settings)
    return outcome, hand.states(program, scenes, max_time=max_time, **settings)[:, 1:]


def test_who_is_struck_from_behind_rolls_on(hand) -> None:
    """Equals at 20 against 10 m/s: (1 -+ 0.15) / 2 of the difference each, then they roll, slower by 0.015 g."""
    _, states = crash(hand, (CAR, 0, 0, 0, 20), (CAR, 10, 0, 0, 10))
    after = int(np.flatnonzero(states[:, 0, State.PRESENT] == 2.0)[0])
    rolled = 0.015 * 9.81 * STEP
    assert states[after, :, State.SPEED] == pytest.approx([14.25, 15.75], abs=1.01 * rolled)
    slower = states[after, :, State.SPEED] - states[after + 10, :, State.SPEED]
    assert slower == pytest.approx([10 * rolled] * 2, rel=1e-6)
    assert np.all(states[:, :, State.Y] == 0.0)
    gap = states[after:, 1, State.X] - states[after:, 0, State.X]
    assert np.all(gap >= CAR_LENGTH - 1e-3)


def test_who_is_struck_at_the_side_slides_and_comes_to_rest(hand) -> None:
    """A car struck at a right angle is pushed aside with yaw, its tyres stop it, and it stays where it then is."""
    _, states = crash(hand, (CAR, 0, 0, 0, 0), (CAR, 1.0, -12, math.pi / 2, 12), max_time=8.0)
    struck = states[:, 0]
    assert struck[-1, State.Y] > 0.5
    assert abs(struck[-1, State.HEADING]) > 0.1
    assert np.all(struck[-20:, State.X : State.HEADING + 1] == struck[-1, State.X : State.HEADING + 1])
    assert struck[-1, State.SPEED] == 0.0


def test_a_heavy_obstacle_is_a_wall_and_a_light_one_moves(hand) -> None:
    """A crate of 200 kg is knocked away, a block that is fixed stays; the car bounces back from it."""
    for fixed in (0.0, 1.0):
        _, states = crash(hand, (CAR, 0, 0, 0, 10), (OBSTACLE, 8, 0, 0, 0, {"fixed": fixed}))
        moved = states[-1, 1, State.X] - 8.0
        assert (moved > 1.0) == (fixed == 0.0)
        assert (states[-1, 0, State.SPEED] > 0.0) == (fixed == 0.0)
        if fixed:
            assert moved == 0.0


def test_a_body_is_struck_twice_in_one_step(hand) -> None:
    """The middle one of three is thrown from the left one into the right one within a step of half a second."""
    for step in (0.5, 0.05):
        _, states = crash(hand, (CAR, 0, 0, 0, 20), (CAR, 5, 0, 0, 0), (CAR, 10, 0, 0, 0), time_step=step, max_time=1.0)
        speeds = states[-1, :, State.SPEED]
        assert 0.0 < speeds[0] < speeds[1] < speeds[2] < 20.0
        assert speeds.sum() == pytest.approx(20.0, abs=0.5)


def test_a_pile_of_many_neither_hangs_nor_breaks(hand) -> None:
    """Fifteen actors of all kinds on one another from all sides: finite to the end, and no faster than anybody was."""
    kinds = [kind for kind in ActorKind if kind is not OBSTACLE]
    blocks = []
    for k in range(15):
        angle = 2 * math.pi * k / 15
        x, y = -14 * math.cos(angle), -14 * math.sin(angle)
        blocks.append((kinds[k % len(kinds)], x, y, angle, 15.0))
    outcome, states = crash(hand, *blocks, max_time=4.0)
    assert outcome.end_reason[0] == EndReason.TIMEOUT
    assert np.isfinite(states).all()
    ways = np.hypot(np.diff(states[:, :, State.X], axis=0), np.diff(states[:, :, State.Y], axis=0))
    assert ways.max() <= 60.0 * STEP
    assert ways[-1].max() < 15.0 * STEP


def test_the_ego_meets_whom_others_throw_at_it(hand) -> None:
    """A parked ego is struck by a car that another one pushes, at a time and by the actor that the record shows."""
    blocks = [(CAR, 20, 0, 0, 0), (CAR, 14, 0, 0, 0), (CAR, 0, 0, 0, 20)]
    outcome = coasting(hand, *blocks, max_time=5.0)
    assert outcome.collided[0]
    assert list(outcome.contact_actors[0]) == [0, 1]
    assert list(outcome.others_contact_actors[0]) == [1, 2]
    assert outcome.others_contact_time[0] < outcome.end_time[0]
    assert outcome.min_distance[0, 0] == 0.0
    # Closing at 0.575 of 20 m/s over the gap of 1.49 m, less what rolling took.
    assert outcome.max_closing_speed[0, 0] == pytest.approx(11.5, abs=0.1)


def test_a_driver_goes_on_where_that_is_the_setting(hand) -> None:
    """Struck from behind, a car whose driver goes on follows its lane again; by default it rolls out."""
    path = hand.route("south", ManeuverType.STRAIGHT)
    code = hand.assembler(CAR, CAR, CAR)
    code.follow(code.behaviour(1), hand.literal(path), hand.literal(8))
    code.emit(Op.HALT)
    far = hand.placed(CAR, 5000, 0, 0, 0)
    scene = hand.scenes([far, hand.on_route(path, 12, 5), hand.on_route(path, 3, 15)])
    program = code.program(hand.road())
    for goes_on in (False, True):
        contact = ContactConfig(drivers_go_on=goes_on)
        states = batch.trajectory(program, scene, 0, SimulationConfig(max_time=5.0), contact).states
        struck = states[:, 1, State.PRESENT] == 2.0
        if goes_on:
            assert struck.any()
            assert states[-1, 1, State.SPEED] == pytest.approx(8.0, abs=0.5)
        else:
            assert struck[-1]
            assert 9.0 < states[-1, 1, State.SPEED] < 10.8


@pytest.mark.parametrize(
    ("x", "y", "heading", "speed"), [(-0.042, -35.12, -1.235, 19.985), (-7.14, -48.569, 0.393, 18.048)]
)
def test_a_driver_goes_on_after_a_spin(hand, x: float, y: float, heading: float, speed: float) -> None:
    """Thrown back or aside, it brakes where it rolls backwards, and comes back to its lane and its speed."""
    path = hand.route("south", ManeuverType.STRAIGHT)
    code = hand.assembler(CAR, CAR, CAR)
    code.follow(code.behaviour(1), hand.literal(path), hand.literal(10))
    code.emit(Op.HALT)
    struck = hand.on_route(path, 10, 10)
    scene = hand.scenes([hand.placed(CAR, 5000, 0, 0, 0), struck, hand.placed(CAR, x, y, heading, speed)])
    contact = ContactConfig(drivers_go_on=True)
    program, config = code.program(hand.road()), SimulationConfig(max_time=20.0)
    states = batch.trajectory(program, scene, 0, config, contact).states[:, 1]
    assert np.isfinite(states).all()
    driven = states[states[:, State.PRESENT] == 1.0]
    assert (states[:, State.PRESENT] == 2.0).any()
    assert (driven[:, State.SPEED] < 0.0).any()
    assert driven[-1, State.X] == pytest.approx(struck[Column.X], abs=0.5)
    assert driven[-1, State.SPEED] > 5.0


def test_settings_of_contact_that_make_no_physics_are_refused(hand) -> None:
    """A restitution above 1 and a negative friction raise, saying which."""
    program = hand.assembler(CAR).program(hand.road())
    for name, value in (("restitution", 1.5), ("friction", -1.0), ("rolling_resistance", math.nan)):
        with pytest.raises(ValueError, match=name):
            host.plan(program, SimulationConfig(), replace(ContactConfig(), **{name: value}))


def test_of_two_contacts_the_first_counts(hand) -> None:
    """Within one step the earlier contact decides, whatever the order of the actors."""
    near, far = (CAR, 6.0, 0, math.pi, 20), (CAR, -6.4, 0, 0, 30)
    for others, touched in (((near, far), 1), ((far, near), 2)):
        outcome = coasting(hand, (CAR, 0, 0, 0, 10), *others)
        assert list(outcome.contact_actors[0]) == [0, touched]


def with_rule(hand, when: float, behaviour):
    """A lone car; a rule holds from time `when` on."""
    code = hand.assembler(CAR)
    code.rule(hand.temporary(1))
    code.emit(Op.TIME, hand.temporary(0))
    code.emit(Op.LE, hand.temporary(1), hand.literal(when), hand.temporary(0))
    code.emit(Op.END)
    code.behaviour(0)
    behaviour(code)
    code.emit(Op.HALT)
    return hand.outcome(code.program(hand.road()), hand.scenes([hand.placed(CAR, 0, 0, 0, 5)]), time_step=0.1)


def test_a_rule_ends_the_run_before_behaviours_act(hand) -> None:
    """At the sample at which a rule holds, a behaviour's own `terminate` comes too late."""

    def terminating(code) -> None:
        rule = code.behaviour_rule()
        for _ in range(3):
            code.emit(Op.YIELD, 0, 0)
        code.emit(Op.TERMINATE, 0, rule)

    for when, rule, end in ((0.25, 0, 0.3), (0.35, 1, 0.3), (0.0, 0, 0.0)):
        outcome = with_rule(hand, when, terminating)
        assert outcome.end_reason[0] == EndReason.RULE
        assert outcome.end_rule[0] == rule
        assert outcome.end_time[0] == pytest.approx(end)


def test_a_broken_number_is_an_error(hand) -> None:
    """A NaN pedal, steering angle or speed makes the run an error, never a result; gears are numbers of our own."""
    for command in set(Command) - {Command.REVERSE, Command.BACK, Command.OFFSET, Command.ASIDE}:
        code = hand.assembler(CAR)
        code.behaviour(0)
        code.emit(Op.SQRT, hand.temporary(0), hand.literal(-1))
        code.take(0, command, hand.temporary(0))
        code.emit(Op.HALT)
        outcome = hand.outcome(code.program(hand.road()), hand.scenes([hand.placed(CAR, 0, 0, 0, 5)]))
        assert outcome.end_reason[0] == EndReason.BROKEN, command
        assert outcome.verdict[0] == Verdict.ERROR


@pytest.mark.parametrize("command", [Command.OFFSET, Command.ASIDE])
def test_a_broken_offset_is_an_error(hand, command: Command) -> None:
    """A NaN offset from a path breaks the run of its follower."""
    code = hand.assembler(CAR)
    block, path = code.behaviour(0), hand.route("south", ManeuverType.STRAIGHT)
    code.emit(Op.SQRT, hand.temporary(0), hand.literal(-1))
    code.emit(Op.COMMAND, 0, int(command), hand.temporary(0))
    code.follow(block, hand.literal(path), hand.literal(5))
    code.emit(Op.HALT)
    outcome = hand.outcome(code.program(hand.road()), hand.scenes([hand.placed(CAR, 0, 0, 0, 5)]))
    assert outcome.end_reason[0] == EndReason.BROKEN


def test_a_route_left_before_its_end_is_not_done(hand) -> None:
    """One route to its end, a step of another, then nothing more to do: the car is still on its way, and coasts."""
    path, next_path = hand.route("south", ManeuverType.STRAIGHT), hand.route("south", ManeuverType.LEFT_TURN)
    code = hand.assembler(CAR, CAR)
    main = code.behaviour(0)
    code.follow(main, hand.literal(path), hand.literal(10))
    code.emit(Op.MOVE, hand.local(1), hand.literal(0))
    code.emit(Op.FOLLOW, hand.local(1), hand.literal(next_path), hand.literal(10), hand.literal(3), "over")
    code.emit(Op.YIELD, 0, main)
    code.label("over")
    code.emit(Op.HALT)
    end = hand.network.paths.length(path)
    scene = hand.scenes([hand.on_route(path, end - 1, 10), hand.placed(CAR, 30, 30, 0, 0)])
    outcome = hand.outcome(code.program(hand.road()), scene, max_time=1.0)
    assert outcome.end_reason[0] == EndReason.TIMEOUT


def test_who_is_done_leaves_and_is_not_touched(hand) -> None:
    """At the end of its route a car is gone: another drives through its last place; then all is done."""
    path = hand.route("south", ManeuverType.STRAIGHT)
    length = hand.network.paths.length(path)
    code = hand.assembler(CAR, CAR)
    for actor in range(2):
        code.follow(code.behaviour(actor), hand.literal(path), hand.literal(10), progress=actor)
        code.emit(Op.HALT)
    scene = hand.scenes([hand.on_route(path, length - 5, 10), hand.on_route(path, length - 15, 10)])
    program = code.program(hand.road())
    outcome, states = hand.outcome(program, scene), hand.states(program, scene)
    assert outcome.end_reason[0] == EndReason.ALL_DONE
    present = states[:, 0, State.PRESENT]
    assert list(present) == [1] * len(present)
    # The front is half a car before the centre, and would pass the end in the step that begins at 0.25 s.
    assert outcome.end_time[0] == pytest.approx(0.25)
    front = states[:, 0, State.Y] + 0.5 * CAR_LENGTH
    assert np.all(front < hand.network.paths.pose(path, length).y)
    assert np.isnan(outcome.left_road_time).all()


def test_an_absent_actor_is_passed_through_and_not_seen(hand) -> None:
    """Three cars: the second leaves, the ego drives through its last place, unscathed and without seeing it."""
    path = hand.route("south", ManeuverType.STRAIGHT)
    length = hand.network.paths.length(path)
    code = hand.assembler(CAR, CAR, CAR)
    code.follow(code.behaviour(1), hand.literal(path), hand.literal(1))
    code.emit(Op.HALT)
    block = code.behaviour(0)
    code.label("look")
    code.emit(Op.WITHIN, hand.temporary(0), 0, hand.literal(100))
    code.emit(Op.COMMAND, 0, int(Command.THROTTLE), hand.temporary(0))
    code.emit(Op.YIELD, 0, block)
    code.emit(Op.JUMP, 0, "look")
    ahead, behind = hand.on_route(path, length - 0.5 * CAR_LENGTH - 0.15, 1), hand.on_route(path, length - 20, 15)
    aside = hand.placed(CAR, -300, 300, math.pi, 0)
    program, scene = code.program(hand.road()), hand.scenes([behind, ahead, aside])
    states = hand.states(program, scene, max_time=2)
    assert list(states[:4, 1, State.PRESENT]) == [1, 1, 1, 0]
    assert list(states[1:5, 0, State.THROTTLE]) == [1, 1, 1, 0]
    assert hand.outcome(program, scene, max_time=2).end_reason[0] == EndReason.TIMEOUT


def leaving(hand, *declared: str):
    """The outcome of two cars, of which the other leaves at once and the ego coasts."""
    path = hand.route("south", ManeuverType.STRAIGHT)
    code = hand.assembler(CAR, CAR)
    if "rule" in declared:
        after(code, hand, 99.0, RuleKind.TERMINATE)
    if "record" in declared:
        after(code, hand, 99.0, RuleKind.WATCH)
    if "monitor" in declared:
        block = code.monitor()
        code.label("again")
        code.emit(Op.YIELD, 0, block)
        code.emit(Op.JUMP, 0, "again")
    code.follow(code.behaviour(1), hand.literal(path), hand.literal(10))
    code.emit(Op.HALT)
    scene = hand.scenes([hand.placed(CAR, 0, 0, 0, 1), hand.on_route(path, hand.network.paths.length(path) - 3, 10)])
    return hand.outcome(code.program(hand.road()), scene, max_time=3.0)


def after(code, hand, time: float, kind: RuleKind) -> None:
    """A rule that holds from a time on."""
    code.rule(hand.temporary(1), kind)
    code.emit(Op.TIME, hand.temporary(0))
    code.emit(Op.LE, hand.temporary(1), hand.literal(time), hand.temporary(0))
    code.emit(Op.END)


@pytest.mark.parametrize(
    ("declared", "reason"),
    [
        ("", EndReason.ALL_DONE),
        ("rule", EndReason.ALL_DONE),
        ("record", EndReason.TIMEOUT),
        ("monitor", EndReason.TIMEOUT),
    ],
)
def test_an_ego_left_alone_goes_on_where_somebody_looks(hand, declared: str, reason: EndReason) -> None:
    """A record or a monitor keeps a run alive whose ego is alone; `terminate when` does not."""
    assert leaving(hand, declared).end_reason[0] == reason


def test_a_run_is_over_when_the_ego_has_left(hand) -> None:
    """Two others go on, but nobody looks at them."""
    path = hand.route("south", ManeuverType.STRAIGHT)
    code = hand.assembler(CAR, CAR, CAR)
    code.follow(code.behaviour(0), hand.literal(path), hand.literal(10))
    code.emit(Op.HALT)
    near = hand.on_route(path, hand.network.paths.length(path) - 3, 10)
    scene = hand.scenes([near, hand.placed(CAR, 0, 0, 0, 1), hand.placed(CAR, -20, 0, 0, 1)])
    outcome = hand.outcome(code.program(hand.road()), scene, max_time=3.0)
    assert outcome.end_reason[0] == EndReason.ALL_DONE
    assert outcome.end_time[0] < 0.5


def test_a_lone_actor_runs_until_it_leaves(hand) -> None:
    """With one actor ALL_DONE means that nobody is left."""
    path = hand.route("south", ManeuverType.STRAIGHT)
    code = hand.assembler(CAR)
    code.follow(code.behaviour(0), hand.literal(path), hand.literal(10))
    code.emit(Op.HALT)
    outcome = hand.outcome(code.program(hand.road()), hand.scenes([hand.on_route(path, 5, 10)]))
    assert outcome.end_reason[0] == EndReason.ALL_DONE
    assert outcome.end_time[0] == pytest.approx((hand.network.paths.length(path) - 0.5 * CAR_LENGTH - 5) / 10, abs=0.06)


def test_left_road_is_the_first_sample_outside(hand) -> None:
    """Against the polygon of the road itself, for cars that leave it in all directions."""
    network = hand.network
    program = hand.assembler(CAR).program(hand.road())
    for heading in np.linspace(0.1, 6.2, 12):
        scene = hand.scenes([hand.placed(CAR, 0, 0, heading, 8.0)])
        outcome, states = hand.outcome(program, scene, max_time=8), hand.states(program, scene, max_time=8)
        outside = [not network.regions.contains(0, x, y) for x, y in states[:-1, 0, :2]]
        assert outcome.left_road_time[0, 0] == pytest.approx(np.argmax(outside) * STEP)


def test_a_run_goes_on_around_free_bodies(hand, crossing, crossing_scenes) -> None:
    """Unscored, a free body's next row is left alone, while the other actor goes on as it would have."""
    config = SimulationConfig()
    scenes = crossing_scenes(1, seed=3)
    plan, run = host.plan(crossing, config), host.memory(crossing, 200)
    begin(plan, run, 0, scenes.values[0], scenes.keys[0], np.zeros((0, 0)))
    advance(plan, run, 10, True)
    assert run.status[Status.SAMPLE] == 10
    run.actors[0, Memory.FREE] = HOSTED
    for sample in range(11, 40):
        run.states[sample, 0] = run.states[10, 0]
        run.states[sample, 0, State.X] += 1000.0
        advance(plan, run, sample, False)
    undisturbed = hand.states(crossing, scenes)
    assert np.all(run.states[11:40, 0, State.X] == run.states[10, 0, State.X] + 1000.0)
    shared = min(40, len(undisturbed))
    assert np.array_equal(run.states[:shared, 1], undisturbed[:shared, 1])
    assert run.status[Status.END] == -1


def test_settings_that_make_no_simulation_are_refused(hand) -> None:
    """A step of zero, a negative time and more steps than memory each raise, saying which."""
    for settings, word in (
        ({"time_step": 0.0}, "time_step"),
        ({"max_time": -1}, "max_time"),
        ({"max_time": 1e9}, "steps"),
    ):
        with pytest.raises(ValueError, match=word):
            coasting(hand, (CAR, 0, 0, 0, 1), **settings)


def test_a_scene_may_change_what_an_actor_can_do(hand) -> None:
    """With half the braking the same pedal slows it half as fast."""
    states = lone(hand, [(Command.BRAKE, 1.0)], max_braking=4.0)
    assert states[1, State.ACCELERATION] == pytest.approx(-4.0)
