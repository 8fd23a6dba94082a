"""Who drives from outside drives as a behaviour of the file does, and what goes wrong with it is told by its name."""

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cortex_dsl as cx
from engine import batch, host
from engine.assessment import take
from engine.config import SimulationConfig
from engine.control import columns
from engine.driving import stepping
from engine.driving.blocks import HOPELESS, Driven, Driver
from engine.driving.decisions import is_reproducible
from engine.driving.observations import EGOCENTRIC
from engine.driving.stepping import ParallelRuns
from engine.errors import ControllerError
from engine.kernels.rows import simulate_rows
from engine.outcomes import OUTCOMES, Outcomes
from engine.scenes import Scenes
from engine.tables import Bools, Floats, Ints
from engine.vehicles import MODELS
from engine.vocabulary import STORED, ActorKind, Measure, Verdict

ROOT = Path(__file__).parents[3]
EXAMPLES = ("left_turn", "right_and_oncoming_left", "left_against_crossing", "crossing_left_turn",
            "right_into_crossing", "three_way_left")  # fmt: skip
"""A to F, in the order of the paper or not."""
SPEED, OFFSET, HEADING = (([name for name, _ in EGOCENTRIC]).index(n) for n in ("speed", "path offset", "path heading"))


def scenario_of(name: str, behaviour: str) -> cx.Scenario:
    """An example whose ego does something else."""
    text = (ROOT / "examples" / f"{name}.scn").read_text(encoding="utf-8")
    found = re.sub(r"with behavior EgoBehavior\(egoTrajectory\)", f"with behavior {behaviour}", text)
    assert found != text
    return cx.compile_text(found, name=f"{name}.scn")


def cruising(observations: Floats) -> Floats:
    """10 m/s along the path, by hand."""
    wanted = 4.0 * (10.0 - observations[:, SPEED])
    turn = 2.0 / 5.0 * np.sin(observations[:, HEADING]) - np.clip(observations[:, OFFSET], -1.0, 1.0) / 25.0
    steer = np.clip(np.arctan(2.6 * turn), -0.5, 0.5)
    return np.stack([np.clip(wanted / 3.0, 0.0, 1.0), np.clip(-wanted / 8.0, 0.0, 1.0), steer], axis=1)


def same(one: Outcomes, other: Outcomes) -> None:
    for field in fields(Outcomes):
        ours, theirs = getattr(one, field.name), getattr(other, field.name)
        assert np.array_equal(ours, theirs, equal_nan=ours.dtype.kind == "f"), field.name


# -- the same run ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", EXAMPLES)
def test_a_driver_from_outside_is_a_behaviour_of_the_file(name: str) -> None:
    """Who asks for the very speeds that a library behaviour asks for has its very runs, bit for bit, in A to F."""
    inside = scenario_of(name, "FollowTrajectoryBehavior(10 m/s, egoTrajectory, max_lateral=none)")
    outside = scenario_of(name, 'ExternalBehavior(trajectory=egoTrajectory, actions="speed")')
    scenes = outside.sample(60, seed=3)
    driven = Driver(lambda seen: np.tile([10.0, 0.0], (len(seen), 1))).drive(
        outside.program, scenes, outside.config.simulation
    )
    same(driven.outcomes, inside.simulate(inside.sample(60, seed=3)))


def cruised(scenario: cx.Scenario, scenes: Scenes) -> ParallelRuns:
    """Lanes in which the scenes have been driven to their ends, `cruising`, and are not judged yet."""
    lanes, every = ParallelRuns(scenario.program, len(scenes), scenario.config.simulation), np.arange(len(scenes))
    lanes.place(every, scenes)
    lanes.step()
    while lanes.running.any():
        asked = lanes.asked(0)
        lanes.decide(0, asked, cruising(lanes.observe(0, asked)))
        lanes.step()
    return lanes


@pytest.mark.parametrize("name", EXAMPLES)
def test_a_stepped_run_is_the_run_of_the_batch_host(name: str) -> None:
    """It ends at the same sample for the same reason, with everybody in the same place, bit for bit."""
    scenario = scenario_of(name, "ExternalBehavior(trajectory=egoTrajectory, every=0.1 s)")
    scenes = scenario.sample(60, seed=4)
    lanes = cruised(scenario, scenes)
    held(scenario, lanes, scenes)
    assert lanes.nbytes / 60 < 8000.0


def test_who_looks_at_what_was_does_so_in_lanes() -> None:
    """A driver with a latency beside the one from outside sees its own scene as it was, not that of another lane."""
    text = (ROOT / "examples" / "left_turn.scn").read_text(encoding="utf-8")
    text = text.replace("EgoBehavior(egoTrajectory)", "ExternalBehavior(trajectory=egoTrajectory)")
    old = "FollowTrajectoryBehavior(target_speed=ADV_SPEED, trajectory=advTrajectory)"
    assert old in text
    scenario = cx.compile_text(text.replace(old, f"EmergencyBrakeBehavior({old}, latency=0.3 s)"))
    scenes = scenario.sample(60, seed=4)
    lanes = cruised(scenario, scenes)
    held(scenario, lanes, scenes)
    at_once = cx.compile_text(text.replace(old, f"EmergencyBrakeBehavior({old})"))
    assert not np.array_equal(lanes.states, cruised(at_once, at_once.sample(60, seed=4)).states)


@pytest.mark.parametrize("seen", ["timeToCollision(self, ego) < 2 s", "abs(ego.angularSpeed) > 0.02"])
def test_how_fast_another_turns_is_seen_in_lanes(seen: str) -> None:
    """It takes the sample before, and that of the same lane."""
    text = (ROOT / "examples" / "left_turn.scn").read_text(encoding="utf-8")
    text = text.replace("EgoBehavior(egoTrajectory)", "ExternalBehavior(trajectory=egoTrajectory)")
    old = "FollowTrajectoryBehavior(target_speed=ADV_SPEED, trajectory=advTrajectory)"
    assert old in text
    wary = f"behavior Wary():\n    try:\n        do {old}\n    interrupt when {seen}:\n        take SetBrakeAction(1)\n"
    text = text.replace("\nego = ", f"\n{wary}\nego = ", 1).replace(f"with behavior {old}", "with behavior Wary()")
    scenario = cx.compile_text(text)
    scenes = scenario.sample(60, seed=4)
    held(scenario, cruised(scenario, scenes), scenes)


def test_others_who_crash_do_so_in_lanes_as_anywhere() -> None:
    """Nobody looks back further than a lane does, into what another has left there."""
    text = """
map intersection(approach=80 m)
straight = filter(lambda m: m.type is ManeuverType.STRAIGHT, intersection.maneuvers)[0]
crossing = Uniform(*filter(lambda m: m.type is ManeuverType.STRAIGHT, straight.conflictingManeuvers))
ego = new Car before intersection by 70 m along [straight.startLane], with speed 5 m/s,
    with behavior ExternalBehavior(trajectory=straight)
leader = new Car before intersection by Range(20, 30) m along [straight.startLane], with speed Range(6, 10) m/s,
    with behavior FollowTrajectoryBehavior(8 m/s, straight)
adversary = new Car before intersection by Range(20, 30) m along [crossing.startLane], with speed Range(6, 10) m/s,
    with behavior FollowTrajectoryBehavior(8 m/s, crossing)
terminate after 8 s
"""
    scenario = cx.compile_text(text)
    scenes = scenario.sample(400, seed=4)
    lanes = cruised(scenario, scenes)
    outcomes = scenario.simulate(replace(scenes, actions=lanes.decided(np.arange(len(scenes)))))
    assert np.isfinite(outcomes.others_contact_time).sum() > 100
    held(scenario, lanes, scenes, len(scenes))


def held(scenario: cx.Scenario, lanes: ParallelRuns, scenes: Scenes, most: int = 20) -> None:
    """Lanes against the batch host on the scenes with what was decided in them; so many to their last states."""
    decided = replace(scenes, actions=lanes.decided(np.arange(len(scenes))))
    samples, reasons, valid = lanes.samples.copy(), lanes.reasons.copy(), scenes.valid
    outcomes = scenario.simulate(decided)
    assert np.array_equal(samples[valid], outcomes.steps[valid])
    assert np.array_equal(reasons[valid], outcomes.end_reason[valid])
    for row in np.flatnonzero(valid & ~outcomes.collided)[:most]:
        track = batch.trajectory(scenario.program, decided, int(row), scenario.config.simulation)
        assert np.array_equal(lanes.states[row], track.states[-1])
    same(host.outcomes(lanes.results), outcomes)


def test_blocks_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither the size of a block nor the number of threads changes what a driver of single lanes does."""
    split(monkeypatch)
    scenario = scenario_of("left_turn", "ExternalBehavior(trajectory=egoTrajectory)")
    scenes = scenario.sample(40, seed=5)
    one = Driver(cruising, block=7).drive(scenario.program, scenes, scenario.config.simulation)
    other = Driver(cruising, block=64).drive(scenario.program, scenes, scenario.config.simulation, jobs=2)
    same(one.outcomes, other.outcomes)
    assert np.array_equal(one.scenes.actions, other.scenes.actions)


def split(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have some lanes be stepped and judged in several threads, as thousands are."""
    for module in (host, stepping):
        monkeypatch.setattr(module, "CHUNK", 8)
    monkeypatch.setattr(stepping, "AT_ONCE", 4)


def test_both_hosts_run_driven_scenes_alike() -> None:
    """The world agrees with the batch host on scenes that a controller has driven."""
    scenario = scenario_of("left_turn", "ExternalBehavior(trajectory=egoTrajectory)").driven_by(cruising)
    scenes = scenario.sample(30, seed=6)
    one, other = scenario.simulate(scenes), scenario.simulate(scenes, engine="world")
    assert np.array_equal(one.end_reason, other.end_reason)
    assert np.array_equal(one.steps, other.steps)
    assert np.allclose(one.min_distance, other.min_distance, atol=1e-9, equal_nan=True)


def test_a_brake_above_a_policy() -> None:
    """Where a `try` of the file interrupts the controller, the file drives."""
    text = """
param SPEED = Range(5, 15) m/s
behavior Guarded():
    try:
        do ExternalBehavior()
    interrupt when self.speed > 8 m/s:
        take SetBrakeAction(1)
ego = new Car on road, with speed SPEED, with behavior Guarded()
new Car on road
terminate after 3 s
"""
    scenario = cx.compile_text(text)
    scenes = scenario.sample(8, seed=1)
    flooring = Driver(lambda seen: np.tile([1.0, 0.0, 0.0], (len(seen), 1))).drive(scenario.program, scenes)
    same(flooring.outcomes, batch.simulate(scenario.program, flooring.scenes))
    run = batch.trajectory(scenario.program, flooring.scenes, int(np.flatnonzero(scenes.valid)[0]))
    assert run.states[-1, 0, 3] < 8.5
    assert run.states[:, 0, 7].max() == 1.0


BEHIND_IT = "new Car behind ego by AHEAD, with speed 20 m/s"
OTHERS = {
    "along its lane": ("new Car ahead of ego by AHEAD, with behavior FollowLaneBehavior(5 m/s)", False),
    "parked": ("new Car ahead of ego by AHEAD", False),
    "on foot": ("new Pedestrian ahead of ego by AHEAD, with behavior Walking()", False),
    "both pedals": ("new Car ahead of ego by AHEAD, with behavior Pressing()", True),
    "a set speed": ("new Car ahead of ego by AHEAD, with behavior Pacing()", True),
    "backwards": ("new Car ahead of ego by AHEAD, with behavior Backing()", True),
    "from outside": ("new Car ahead of ego by AHEAD, with behavior ExternalBehavior(every=0.1 s, delay=0.1 s)", False),
    "three": ("new Car ahead of ego by AHEAD\nnew Car ahead of ego by 2 * AHEAD", False),
    "three, with a set speed": ("new Car ahead of ego by AHEAD, with behavior Pacing()\n" + BEHIND_IT, False),
    "others touch": (
        "new Car ahead of ego by AHEAD\n" + BEHIND_IT + ", with behavior FollowLaneBehavior(30 m/s)",
        False,
    ),
    "others leave": ("new Car ahead of ego by AHEAD\n" + BEHIND_IT + ", with behavior Backing()", False),
}
BESIDE = """
map road(lanes=1, length=600 m)
param SPEED = Range(4, 16) m/s
param AHEAD = Range(12, 40) m
behavior Walking():
    while True:
        take SetThrottleAction(0.4), SetSteerAction(0.1)
behavior Pressing():
    while True:
        take SetThrottleAction(0.8), SetBrakeAction(0.3)
behavior Pacing():
    while True:
        take SetSpeedAction(3 m/s)
behavior Backing():
    while True:
        take SetReverseAction(True), SetThrottleAction(0.5)
ego = new Car at (-250, -1.75), with speed SPEED, with behavior ExternalBehavior()
%s
terminate after 6 s
"""


JUDGED = {
    "nothing declared": "",
    "expectations": "expect always ego.speed > 2 m/s\nexpect eventually ego.speed > 11 m/s\n",
    "a requirement": "require always ego.speed < 15.5 m/s\n",
    "numbers": "maximize hidden_time\nminimize least(ego.speed)\nmaximize post_encroachment_time\n",
    "both": "require eventually ego.speed > 7 m/s\nexpect always ego.speed < 12 m/s\nmaximize final(ego.speed)\n",
}


@pytest.mark.parametrize("name", OTHERS)
@pytest.mark.parametrize("declared", JUDGED)
def test_runs_are_judged_on_their_record_or_run_again(
    name: str, declared: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Either way they are those of the batch host; again run only those of two in which more than pedals moves one."""
    other, again = OTHERS[name]
    scenario = cx.compile_text(BESIDE % other + JUDGED[declared])
    scenes, run_again = scenario.sample(20, seed=2), []
    monkeypatch.setattr(stepping, "simulate_rows", lambda *given: run_again.append(simulate_rows(*given)))
    driver = {control.controller: cruising for control in scenario.program.controls}
    every = STORED | Measure.GAPS
    config = scenario.config.simulation
    driven = Driver(driver, block=20).drive(scenario.program, scenes, config, measures=every)
    same(driven.outcomes, batch.simulate(scenario.program, driven.scenes, config, measures=every))
    assert driven.scenes.valid.any()
    assert bool(run_again) == again


def test_driven_scenes_are_not_simulated_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """Changed scenes are, and the results of both are those of the batch host."""
    scenario = cx.compile_text(BESIDE % OTHERS["parked"][0]).driven_by(cruising)
    scenes, simulated = scenario.sample(20, seed=2), []

    def counted(*given: Any) -> Outcomes:
        simulated.append(given)
        return simulate(*given)

    simulate = batch.simulate
    monkeypatch.setattr(batch, "simulate", counted)
    known = scenario.simulate(scenes)
    assert not simulated
    same(known, simulate(scenario.program, scenes, scenario.config.simulation))
    known.end_time[:] = 0.0
    assert scenario.simulate(scenes).end_time.all()
    scenes.actions[0, :, 1] = 1.0
    changed = scenario.simulate(scenes)
    assert len(simulated) == 1
    same(changed, simulate(scenario.program, scenes, scenario.config.simulation))
    slower = replace(
        scenario, config=replace(scenario.config, simulation=SimulationConfig(time_step=0.1, max_time=6.0))
    )
    slower.simulate(scenario.sample(20, seed=2))
    assert len(simulated) == 2


@pytest.mark.parametrize("name", EXAMPLES)
def test_measures_that_are_not_requested_change_no_other_result(name: str) -> None:
    """They have the values of invalid scenes."""
    scenario = scenario_of(name, "FollowTrajectoryBehavior(10 m/s, egoTrajectory)")
    scenes, config = scenario.sample(60, seed=3), scenario.config.simulation
    every = batch.simulate(scenario.program, scenes, config, measures=STORED | Measure.GAPS)
    measured = {
        Measure.SIGHT: ("first_seen", "ttc_at_first_sight", "hidden_time"),
        Measure.GRIP: ("lateral_grip", "combined_grip"),
        Measure.FAULT: ("fault",),
    }
    for chosen in (0, *measured, Measure.GAPS):
        some = batch.simulate(scenario.program, scenes, config, measures=chosen)
        blank = {row.name: row.blank(60, len(scenario.program.actors)) for row in OUTCOMES}
        missing = {name: blank[name] for each, names in measured.items() if each != chosen for name in names}
        same(some, replace(every, **missing, **({} if chosen == Measure.GAPS else {"gaps": np.zeros((60, 0))})))


# -- a driver of the library, written in numpy -------------------------------------------------------------------------

LINE = """
map road(lanes=1, length=600 m)
param SPEED = Range(4, 16) m/s
param LEAD = Range(2, 12) m/s
param AHEAD = Range(10, 60) m
behavior Changing():
    do FollowLaneBehavior(LEAD) for 4 s
    do FollowLaneBehavior(LEAD / 3) for 4 s
    do FollowLaneBehavior(LEAD)
ego = new Car at (-250, -1.75), with speed SPEED, with behavior %s
new Car ahead of ego by AHEAD, with speed LEAD, with behavior Changing()
terminate after 15 s
"""
SEEN = ("speed", "nearest 1: seen", "nearest 1: x", "nearest 1: vx", "nearest 1: length")


def intelligent(seen: Floats) -> Floats:
    """The Intelligent Driver Model of Treiber, Hennecke and Helbing (2000) with its table I, at 12 m/s, as pedals."""
    speed, there, x, opening, length = (seen[:, [name for name, _ in EGOCENTRIC].index(each)] for each in SEEN)
    gap = np.maximum(np.where(there == 1.0, x - length, 1e9), 0.01)
    wanted = 2.0 + np.maximum(0.0, 1.6 * speed - speed * opening / (2.0 * np.sqrt(0.73 * 1.67)))
    asked = np.clip(0.73 * (1.0 - (speed / 12.0) ** 4 - (wanted / gap) ** 2), -8.0, 3.0)
    car = MODELS[ActorKind.CAR]
    pedals = np.maximum(asked, 0.0) / car.max_acceleration, np.maximum(-asked, 0.0) / car.max_braking
    return np.stack([*(np.clip(pedal, 0.0, 1.0) for pedal in pedals), np.zeros(len(seen))], axis=1)


def test_a_model_of_the_library_in_numpy_drives_as_the_library() -> None:
    """The Intelligent Driver Model behind one who slows down: the same ends and steps, states within 1e-9 m."""
    inside = cx.compile_text(LINE % "CarFollowingBehavior(12 m/s)")
    outside = cx.compile_text(LINE % "ExternalBehavior()").driven_by(intelligent)
    one, other = inside.sample(40, seed=1), outside.sample(40, seed=1)
    ours, theirs = inside.simulate(one), outside.simulate(other)
    assert np.array_equal(ours.end_reason, theirs.end_reason)
    assert np.array_equal(ours.steps, theirs.steps)
    for row in np.flatnonzero(one.valid)[:10].tolist():
        mine, its = (batch.trajectory(each.program, scenes, row, each.config.simulation).states
                     for each, scenes in ((inside, one), (outside, other)))  # fmt: skip
        assert np.abs(mine[..., :5] - its[..., :5]).max() < 1e-9


# -- when actions are asked for, and take effect -----------------------------------------------------------------------


class Counting:
    """Remembers what it was asked, and floors the throttle."""

    def __init__(self) -> None:
        self.resets: list[Ints] = []
        self.asked: list[Bools] = []

    def reset(self, lanes: Ints, keys: Ints) -> None:
        assert keys.shape == (len(lanes), 6)
        self.resets.append(lanes)

    def act(self, observations: Floats, active: Bools) -> Floats:
        self.asked.append(active)
        actions = np.full((len(observations), 3), np.nan)
        actions[active] = [1.0, 0.0, 0.0]
        return actions


def stepped(arguments: str) -> tuple[Driven, Counting]:
    text = f"ego = new Car on road, with speed 0, with behavior ExternalBehavior({arguments})\nterminate after 1 s\n"
    scenario = cx.compile_text(text)
    controller = Counting()
    return Driver(controller, block=4).drive(
        scenario.program, scenario.sample(3, seed=1), scenario.config.simulation
    ), controller


def test_every_and_delay() -> None:
    """`every` says how often a controller is asked, `delay` when what it decides takes effect."""
    driven, controller = stepped("every=0.2 s, delay=0.1 s")
    assert len(controller.resets) == 1
    assert len(controller.asked) == 5
    throttle = driven.scenes.actions[0, :, 0]
    assert throttle[:2].tolist() == [0.0, 0.0]
    assert (throttle[2:] == 1.0).all()


def test_an_odd_delay_is_rounded_up() -> None:
    """What would take effect between two steps does so at the later."""
    driven, _ = stepped("delay=0.12 s")
    assert np.flatnonzero(driven.scenes.actions[0, :, 0])[0] == 3


def test_lanes_that_rest_are_not_looked_at() -> None:
    """NaN in a lane that is not active harms nobody: `Counting` gives it there."""
    driven, controller = stepped("")
    assert not controller.asked[0][3]
    assert driven.scenes.valid.all()


def test_actions_stand_one_after_another() -> None:
    """Two controllers have columns of their own."""
    text = """
ego = new Car on road, with behavior ExternalBehavior(actions="speed")
other = new Car on road, with behavior ExternalBehavior()
"""
    program = cx.compile_text(text).program
    assert [control.controller for control in program.controls] == ["ego", "other"]
    assert columns(program.controls) == (slice(0, 2), slice(2, 5))


# -- what goes wrong ---------------------------------------------------------------------------------------------------


def refused(driver: object) -> ControllerError:
    scenario = cx.compile_text("ego = new Car on road, with behavior ExternalBehavior()\nterminate after 1 s\n")
    with pytest.raises(ControllerError) as caught:
        Driver(driver, block=2).drive(scenario.program, scenario.sample(2), scenario.config.simulation)
    return caught.value


def test_wrong_shapes_are_told() -> None:
    error = refused(lambda seen: np.zeros((len(seen), 2)))
    assert error.what == "the controller `ego` gave actions of shape (2, 2); expected (2, 3)"
    assert "throttle [1, 0 .. 1]" in error.cure


def test_nan_is_told() -> None:
    error = refused(lambda seen: np.full((len(seen), 3), np.nan))
    assert error.message == "the controller `ego` gave throttle = nan, in scene 0 at 0.00 s"
    assert error.cure == "throttle lies in 0 .. 1: look for what makes it no number"


def test_out_of_range_is_told() -> None:
    error = refused(lambda seen: np.tile([0.0, 1.5, 0.0], (len(seen), 1)))
    assert error.message == "the controller `ego` gave brake = 1.5, in scene 0 at 0.00 s"
    assert error.cure == "brake lies in 0 .. 1: `numpy.clip` holds it there"


def test_no_numbers_are_told() -> None:
    assert refused(lambda seen: "faster").what == "the controller `ego` gave no numbers, but str"


def test_what_rounds_to_float32_is_within_its_range() -> None:
    """As a policy of that kind clips it, which may be farther out by a digit; no farther."""
    scenario = scenario_of("left_turn", "ExternalBehavior(trajectory=egoTrajectory)")
    (ends,) = {control.actions[2].high for control in scenario.program.controls}

    def steering(end: float) -> Driver:
        return Driver(lambda seen: np.tile([0.5, 0.0, end], (len(seen), 1)), block=8)

    exact, rounded = (
        steering(end).drive(scenario.program, scenario.sample(8, seed=3)) for end in (ends, ends * (1.0 + 5e-7))
    )
    same(exact.outcomes, rounded.outcomes)
    with pytest.raises(ControllerError, match=r"steer = 0\.55101"):
        steering(ends + 1e-5).drive(scenario.program, scenario.sample(8, seed=3))


def test_a_tensor_that_is_no_array_is_told() -> None:
    """Whatever it raises."""

    class Tensor:
        def __array__(self, *_: object, **__: object) -> np.ndarray:
            raise RuntimeError("use tensor.detach().numpy() instead")

    assert "but Tensor: use tensor.detach().numpy() instead" in refused(lambda seen: Tensor()).what


def test_a_controller_may_be_told_what_it_will_be_asked() -> None:
    """As a process is; and of a block it is told only of rows with a scene."""
    scenario = scenario_of("left_turn", "ExternalBehavior(trajectory=egoTrajectory)")
    scenes = scenario.sample(8, seed=3)

    class Curious(Choosy):
        def meet(self, header: dict[str, Any]) -> None:
            self.header = header

        def reset(self, lanes: Ints, keys: Ints) -> None:
            self.lanes = lanes.tolist()
            super().reset(lanes, keys)

    curious = Curious([], raises)
    Driver(curious, block=16).drive(scenario.program, scenes, scenario.config.simulation)
    assert [each["name"] for each in curious.header["actions"]] == ["throttle", "brake", "steer"]
    assert len(curious.header["observations"]) == len(EGOCENTRIC)
    assert curious.lanes == np.flatnonzero(scenes.valid).tolist()


@pytest.mark.parametrize("method", ["reset", "act"])
def test_methods_of_other_arguments_are_told(method: str) -> None:
    driver = Choosy([], raises)
    setattr(driver, method, lambda: None)
    assert f"`{method}` of the controller `ego` cannot be called with" in refused(driver).what


def test_what_a_controller_raises_is_told() -> None:
    def broken(seen: Floats) -> Floats:
        raise RuntimeError("no weights")

    error = refused(broken)
    assert error.message.startswith("the controller `ego` raised RuntimeError in `act`: no weights (")
    assert Path(__file__).name in error.message


def test_a_controller_that_exits_ends_no_command() -> None:
    """`sys.exit` within a planner is a failure of the planner."""

    def quits(seen: Floats) -> Floats:
        raise SystemExit(3)

    assert refused(quits).message.startswith("the controller `ego` raised SystemExit in `act`: 3 (")


def test_a_forgotten_return_is_told() -> None:
    assert refused(lambda seen: None).what == "the controller `ego` gave nothing: it returns None"


@pytest.mark.parametrize(
    ("function", "takes"), [(lambda: None, "()"), (lambda seen, active: seen, "(seen, active)")], ids=["none", "two"]
)
def test_a_function_of_other_arguments_is_told(function: Callable[..., object], takes: str) -> None:
    error = refused(function)
    assert error.message == f"the function for the controller `ego` takes {takes}"
    assert "`act(observations, active)`" in error.cure


def test_a_driver_of_whose_arguments_nothing_is_known_is_asked() -> None:
    """As some that are compiled: what is wrong with it shows when it is called."""

    class Compiled:
        __signature__ = "none"

        def __call__(self, seen: Floats) -> Floats:
            return np.zeros((len(seen), 2))

    assert "gave actions of shape (2, 2); expected (2, 3)" in refused(Compiled()).message


def test_a_driver_of_another_width_is_told_what_it_was_given() -> None:
    error = refused(lambda seen: seen[:, [999]])
    assert "raised IndexError in `act`" in error.message
    assert f"observations of shape (2, {len(EGOCENTRIC)})" in error.cure


# -- one scene, and not the command ------------------------------------------------------------------------------------


class Choosy:
    """Drives all scenes but some, over which it does something else from the sixth question on."""

    def __init__(
        self, bad: Sequence[int], what: Callable[[Floats, Bools], Floats], times: float = math.inf, after: int = 5
    ) -> None:
        self.bad, self.what, self.left, self.after = set(bad), what, times, after
        self.here = list[int]()
        self.questions = 0

    def reset(self, lanes: Ints, keys: Ints) -> None:
        self.here = [lane for lane, key in zip(lanes.tolist(), keys.tolist(), strict=True) if key[4] in self.bad]
        self.questions = 0

    def act(self, observations: Floats, active: Bools) -> Floats:
        self.questions += 1
        bad = np.isin(np.arange(len(active)), self.here) & active
        if self.questions > self.after and bad.any() and self.left > 0:
            self.left -= 1
            return self.what(cruising(observations), bad)
        return cruising(observations)


def raises(actions: Floats, bad: Bools) -> Floats:
    raise ZeroDivisionError("no gap")


def shortened(actions: Floats, bad: Bools) -> Floats:
    return actions[~bad]


def undefined(actions: Floats, bad: Bools) -> Floats:
    return np.where(bad[:, np.newaxis], np.nan, actions)


@pytest.mark.parametrize("what", [raises, shortened, undefined])
def test_the_scene_over_which_a_function_fails_is_found(what: Callable[[Floats, Bools], Floats]) -> None:
    """An exception, a row too few or NaN over some scenes is their verdict; all others are as if nothing had been."""
    scenario = scenario_of("left_turn", "ExternalBehavior(trajectory=egoTrajectory)")
    scenes = scenario.sample(21, seed=3)
    bad = np.flatnonzero(scenes.valid)[[2, 7]]
    done = Driver(Choosy(bad.tolist(), what), block=8).drive(scenario.program, scenes, scenario.config.simulation)
    here = Driver(cruising, block=8).drive(scenario.program, scenes, scenario.config.simulation)
    assert np.flatnonzero(done.outcomes.verdict == Verdict.CONTROLLER).tolist() == bad.tolist()
    assert np.array_equal(done.scenes.verdict == Verdict.CONTROLLER, done.outcomes.verdict == Verdict.CONTROLLER)
    assert done.remarks
    rest = np.delete(np.arange(21), bad)
    same(take(done.outcomes, rest), take(here.outcomes, rest))
    assert np.array_equal(done.scenes.actions[rest], here.scenes.actions[rest])
    assert (scenario.assess(done.outcomes).score[bad] == -1).all()


def test_a_failure_that_does_not_recur_costs_a_remark(caplog: pytest.LogCaptureFixture) -> None:
    scenario = scenario_of("left_turn", "ExternalBehavior(trajectory=egoTrajectory)")
    scenes = scenario.sample(8, seed=3)
    bad = np.flatnonzero(scenes.valid)[:1].tolist()
    done = Driver(Choosy(bad, raises, times=1), block=8).drive(scenario.program, scenes, scenario.config.simulation)
    same(done.outcomes, Driver(cruising, block=8).drive(scenario.program, scenes, scenario.config.simulation).outcomes)
    assert len(done.remarks) == 1
    done.tell()
    assert "raised ZeroDivisionError in `act`: no gap" in caplog.text


def test_a_function_is_asked_about_fewer_scenes_where_it_fails() -> None:
    """Not about all of their runs again, and all that it decides for others is what it would decide anyway."""
    scenario = scenario_of("left_turn", "ExternalBehavior(trajectory=egoTrajectory)")
    scenes, asked = scenario.sample(64, seed=3), [0]

    def picky(seen: Floats) -> Floats:
        asked[0] += 1
        if (seen[:, SPEED] > 15.0).any():
            raise ValueError("too fast")
        return cruising(seen)

    def nan(seen: Floats) -> Floats:
        return np.where(seen[:, [SPEED]] > 15.0, np.nan, cruising(seen))

    done, same_but_nan = (Driver(each, block=64).drive(scenario.program, scenes) for each in (picky, nan))
    same(done.outcomes, same_but_nan.outcomes)
    lost = done.scenes.verdict == Verdict.CONTROLLER
    assert len(done.failures) == lost.sum() > 3
    turns = int(done.outcomes.steps.max())
    assert asked[0] < turns + 20 * lost.sum()


def test_failures_are_told_by_scene_and_in_brief(caplog: pytest.LogCaptureFixture) -> None:
    """Each with its scene; on the way a line for each way of failing."""
    scenario = scenario_of("left_turn", "ExternalBehavior(trajectory=egoTrajectory)")
    scenes = scenario.sample(8, seed=3)
    bad = np.flatnonzero(scenes.valid)[1:4].tolist()
    done = Driver(Choosy(bad, raises), block=8).drive(scenario.program, scenes, scenario.config.simulation).tell()
    said = [f"in scene {number} at " in remark for number, remark in zip(bad, done.remarks, strict=True)]
    assert said == [True] * 3
    assert caplog.text.count("no gap") == 1
    assert "and 2 scenes more" in caplog.text


def test_who_has_answered_is_no_broken_driver() -> None:
    """Who has come to an end of scenes may fail over all later ones; who never does is given up after some."""
    scenario = scenario_of("left_turn", "ExternalBehavior(trajectory=egoTrajectory)")
    scenes, whims = scenario.sample(8, seed=3), list[Callable[[Floats], Floats]]([cruising])
    driver = Driver(lambda seen: whims[0](seen), block=8)
    driver.drive(scenario.program, scenes)
    whims[0] = nothing
    for _ in range(4):
        done = driver.drive(scenario.program, scenes)
        assert (done.scenes.verdict[scenes.valid] == Verdict.CONTROLLER).all()
    with pytest.raises(ControllerError):
        driver.without_history().drive(scenario.program, scenes)
    count, asked = 64, list[int]()

    def answers_once(seen: Floats) -> Floats:
        asked.append(len(seen))
        return cruising(seen) if len(asked) == 1 else nothing(seen)

    with pytest.raises(ControllerError, match="throttle = nan"):
        Driver(answers_once, block=count).drive(scenario.program, scenario.sample(count, seed=1))


def test_one_scene_that_fails_ends_nothing() -> None:
    """Neither the first of all, one at a time, nor the last that runs where many failed and all others have ended."""
    scenario = scenario_of("left_turn", "ExternalBehavior(trajectory=egoTrajectory)")
    scenes = scenario.sample(20, seed=3)
    first = np.flatnonzero(scenes.valid)[:1].tolist()
    done = Driver(Choosy(first, lambda actions, bad: actions * np.nan, after=0), block=1).drive(
        scenario.program, scenes
    )
    assert (done.scenes.verdict == Verdict.CONTROLLER).sum() == 1
    many, calls = scenario.sample(64, seed=3), [0]

    def picky(seen: Floats) -> Floats:
        calls[0] += 1
        active = np.count_nonzero(seen[:, SPEED])
        fast = (seen[:, [SPEED]] > 10.0) if calls[0] == 1 else np.zeros((len(seen), 1), dtype=bool)
        if calls[0] > 2 and active == 1:
            raise ValueError("alone")
        return np.where(fast, np.nan, cruising(seen))

    done = Driver(picky, block=64).drive(scenario.program, many)
    assert (done.scenes.verdict == Verdict.CONTROLLER).sum() >= HOPELESS
    assert done.scenes.valid.any()


def test_what_a_function_fails_over_among_others_is_told() -> None:
    """Though it costs no scene, what was decided is not what it was asked first."""
    scenario = scenario_of("left_turn", "ExternalBehavior(trajectory=egoTrajectory)")

    def crowded(seen: Floats) -> Floats:
        if len(np.unique(seen[:, SPEED])) > 3:
            raise ValueError("too many")
        return cruising(seen)

    done = Driver(crowded, block=16).drive(scenario.program, scenario.sample(16, seed=3))
    assert not done.failures
    assert "too many" in done.remarks[0]
    assert "this did not happen again" in done.remarks[0]


def nothing(seen: Floats) -> Floats:
    return np.full((len(seen), 3), np.nan)


def test_each_of_several_controllers_has_to_drive() -> None:
    """One that never does ends the command, however well the others drive."""
    scenario = cx.compile_text(
        "ego = new Car on road, with behavior ExternalBehavior()\n"
        'lead = new Car ahead of ego by 20 m, with behavior ExternalBehavior("lead")\nterminate after 1 s\n'
    )

    def broken(seen: Floats) -> Floats:
        raise RuntimeError("no weights")

    for driver, told in ((nothing, "`lead` gave throttle = nan"), (broken, "no weights")):
        with pytest.raises(ControllerError, match=told):
            Driver({"ego": lambda seen: seen[:, :3] * 0.0, "lead": driver}).drive(
                scenario.program, scenario.sample(20, seed=1)
            )


def test_a_driver_may_observe_what_is_seen_instead_of_what_is_recorded() -> None:
    """As an environment does, so that a policy drives by what it was trained on."""
    text = scenario_of("left_turn", "ExternalBehavior(trajectory=egoTrajectory)").compiled.source.text
    scenario, widths = cx.compile_text(f'{text}\nrecord ego.speed as "speed"\n'), list[int]()

    def noting(seen: Floats) -> Floats:
        widths.append(seen.shape[1])
        return np.zeros((len(seen), 3))

    for observe in ("records", "egocentric"):
        scenario.driven_by(noting, observe=observe).sample(1, seed=3)
    assert set(widths) == {1, len(EGOCENTRIC)}
    with pytest.raises(cx.CortexError, match="observe"):
        scenario.driven_by(noting, observe="seen")


def test_a_search_looks_for_scenes_over_which_a_controller_fails() -> None:
    """By `controller` such scenes are its finds, and have the most of what is sought; else they are invalid."""
    scenario = scenario_of("left_turn", "ExternalBehavior(trajectory=egoTrajectory)")

    def picky(seen: Floats) -> Floats:
        return np.where(seen[:, [SPEED]] > 15.0, np.nan, cruising(seen))

    for name, best in (("controller", 1.0), ("risk", None)):
        driven = scenario.driven_by(picky, block=16)
        found = driven.search("ga", objective=name, generations=3, population=16, seed=1).evaluations
        lost = found.rollouts.verdict[:, 0] == Verdict.CONTROLLER
        assert lost.any()
        assert np.array_equal(found.found, lost if best else found.collided)
        assert (found.fitness[lost] == best).all() if best else np.isnan(found.fitness[lost]).all()


def test_who_never_drives_ends_the_command() -> None:
    """After some scenes, and not after all."""
    scenario = scenario_of("left_turn", "ExternalBehavior(trajectory=egoTrajectory)")
    asked = 0

    def broken(seen: Floats) -> Floats:
        nonlocal asked
        asked += 1
        raise RuntimeError("no weights")

    with pytest.raises(ControllerError, match="no weights"):
        Driver(broken, block=64).drive(scenario.program, scenario.sample(64, seed=1), scenario.config.simulation)
    assert asked <= 2 * 64 + 2


def test_no_controller_is_told() -> None:
    assert "is not a function" in refused_kind(7)
    assert refused({"eg": cruising}).cure == "did you mean `ego`?"


def test_a_file_without_a_place_for_a_driver_is_told() -> None:
    scenario = cx.load(ROOT / "examples" / "left_turn.scn")
    with pytest.raises(ControllerError, match=r"nobody in .* is driven from outside") as caught:
        scenario.driven_by(cruising).sample(1)
    assert "ExternalBehavior(trajectory=…)` in place of its own" in caught.value.cure


def refused_kind(driver: object) -> str:
    scenario = cx.compile_text("ego = new Car on road, with behavior ExternalBehavior()\n")
    with pytest.raises(cx.CortexError) as caught:
        Driver(driver).drive(scenario.program, scenario.sample(1))
    return str(caught.value)


def test_nobody_drives() -> None:
    """Scenes that nobody has driven cannot be run, and the message says whom to name."""
    scenario = cx.compile_text("ego = new Car on road, with behavior ExternalBehavior()\n", name="mine.scn")
    with pytest.raises(ControllerError, match="mine needs a driver for the controller `ego` of ego") as caught:
        scenario.simulate(scenario.sample(1))
    assert "--ego python:module:function" in caught.value.cure


def test_who_differs_the_second_time_is_marked() -> None:
    """A block that is driven twice shows who does not do the same."""
    scenario = scenario_of("left_turn", "ExternalBehavior(trajectory=egoTrajectory)")
    stream = np.random.default_rng(0)

    def moody(seen: Floats) -> Floats:
        return np.stack([stream.random(len(seen)), np.zeros(len(seen)), np.zeros(len(seen))], axis=1)

    steady, changing = (scenario.driven_by(Driver(who, block=8)) for who in (cruising, moody))
    assert is_reproducible(steady.program, steady.config)
    assert not is_reproducible(changing.program, changing.config)


def test_no_valid_scene_is_no_work() -> None:
    """Scenes none of which is valid are driven by asking nobody."""
    scenario = scenario_of("left_turn", "ExternalBehavior(trajectory=egoTrajectory)")
    scenes = scenario.sample(4)
    nothing = replace(scenes, verdict=np.full(4, 2, dtype=np.int32))
    controller = Counting()
    driven = Driver(controller, block=4).drive(scenario.program, nothing, scenario.config.simulation)
    assert not controller.asked
    assert (driven.outcomes.verdict == 2).all()
