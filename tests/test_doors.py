"""Doors of parked vehicles: they turn about their hinge, and contact, distance and sight know them."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cortex_dsl import compile_text
from cortex_dsl.diagnostics import CompileError
from engine import batch, world
from engine.tables import Floats
from engine.vocabulary import State
from tests.laws import examples

TEXT = """
map road(lanes=1, length=300 m, lane_width=4 m)
behavior Opens():
    do IdleBehavior() for 1 s
    take OpenDoorAction({action})
    take OpenDoorAction({action})
ego = new {ego} at ({x} m, {y} m), facing 0 deg, with speed {speed} m/s, with behavior {driver}
parked = new Car at (0 m, -2.6 m), facing {facing} deg, with regionContainedIn None, {more}with behavior Opens()
terminate after {time} s
"""
USUAL = {
    "ego": "Bicycle",
    "x": -30,
    "y": -1.0,
    "speed": 0.0,
    "driver": "BrakeBehavior()",
    "action": '"left"',
    "facing": 0,
    "more": "",
    "time": 4,
}
CAR_LENGTH, CAR_WIDTH = 4.508, 1.61


def states(**given: object) -> Floats:
    """States (samples, actors, columns) of the only scene; both hosts agree on it."""
    scenario = compile_text(TEXT.format(**(USUAL | given)))
    scenes = scenario.sample(1, seed=5)
    assert scenes.valid[0]
    fast = batch.trajectory(scenario.program, scenes, 0, scenario.config.simulation)
    slow = world.run(scenario.program, scenes, 0, scenario.config).trajectory
    pose = [State.X, State.Y, State.HEADING, State.PRESENT]
    np.testing.assert_allclose(slow.states[: len(fast.time), :, pose], fast.states[..., pose], rtol=0.0, atol=1e-9)
    return fast.states


@examples(8, dear=True)
@given(
    side=st.sampled_from(["left", "right"]),
    angle=st.floats(5.0, 90.0),
    time=st.floats(0.3, 2.0),
    length=st.floats(0.5, 1.4),
    facing=st.sampled_from([0, 180, 90]),
)
def test_a_door_turns_about_its_hinge(side: str, angle: float, time: float, length: float, facing: float) -> None:
    """Its front end stays at the side of the car; it opens outwards by the angle within the time, and stays."""
    run = states(action=f'"{side}", {angle} deg, {time} s', more=f"with doorLength {length} m, ", facing=facing)
    assert np.all(run[:20, 2, State.PRESENT] == 0.0)
    shown = run[22:]
    turn, out = math.radians(facing), 1.0 if side == "left" else -1.0
    x, y, heading = shown[:, 2, State.X], shown[:, 2, State.Y] + 2.6, shown[:, 2, State.HEADING]
    hinge = np.stack([x + 0.5 * length * np.cos(heading), y + 0.5 * length * np.sin(heading)])
    ahead = hinge[0] * math.cos(turn) + hinge[1] * math.sin(turn)
    left = -hinge[0] * math.sin(turn) + hinge[1] * math.cos(turn)
    np.testing.assert_allclose(ahead, 0.2 * CAR_LENGTH, atol=2e-3)
    np.testing.assert_allclose(left, out * (0.5 * CAR_WIDTH + 0.06), atol=2e-3)
    opened = np.abs(np.degrees(heading - turn))
    assert opened[-1] == pytest.approx(angle, abs=angle / time * 0.05 + 1e-6)
    assert np.all(np.diff(opened) >= -1e-9)
    assert np.all((y - hinge[1]) * out * math.cos(turn) - (x - hinge[0]) * out * math.sin(turn) >= -1e-9)
    assert len(np.unique(opened[opened.argmax() :])) == 1


@examples(8, dear=True)
@given(angle=st.floats(0.0, 90.0), time=st.floats(0.3, 2.0), pause=st.integers(0, 40))
def test_a_door_opens_once(angle: float, time: float, pause: int) -> None:
    """Whenever the action comes again, and with whatever angle and time, the run is that without it."""
    twice = TEXT.format(**USUAL)
    again = 'take OpenDoorAction("left")\nego'
    assert again in twice
    runs = []
    for later in (f'take OpenDoorAction("left", {angle} deg, {time} s)', "wait"):
        text = twice.replace(again, f"for step in range({pause}):\n        wait\n    {later}\nego")
        scenario = compile_text(text)
        runs.append(
            batch.trajectory(scenario.program, scenario.sample(1, seed=5), 0, scenario.config.simulation).states
        )
    np.testing.assert_array_equal(runs[0], runs[1])


def test_a_cyclist_hits_the_open_door_and_passes_the_closed_one() -> None:
    """Contact knows the door only when it is open; the rider passes the car itself at 0.5 m."""
    results = []
    for angle in ("70 deg", "0 deg"):
        given = {"speed": 6.0, "driver": "ConstantSpeedBehavior(6 m/s)", "time": 8, "action": f'"left", {angle}'}
        text = TEXT.format(**(USUAL | given))
        scenario = compile_text(text)
        scenes = scenario.sample(1, seed=5)
        outcomes = batch.simulate(scenario.program, scenes, scenario.config.simulation)
        results.append((bool(outcomes.collided[0]), float(outcomes.min_distance[0, 0])))
        assert list(scenario.program.actors) == ["ego", "parked", "parked_left_door"]
    assert results[0][0]
    assert not results[1][0]
    assert results[1][1] == pytest.approx(results[0][1], abs=0.5)


def test_drivers_brake_for_an_open_door() -> None:
    """The emergency brake sees it as any other obstacle."""
    run = states(speed=6.0, driver="EmergencyBrakeBehavior(ConstantSpeedBehavior(6 m/s))", time=10, x=-40)
    assert run[-1, 0, State.SPEED] < 0.05
    assert run[-1, 0, State.X] < 0.0


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_door_opens_where_its_car_stands_by_then(side: str) -> None:
    """The car drives about 30 m and stops first; at 0 deg the door lies along its side, in both hosts."""
    driver = f"""
behavior Opens():
    do ConstantSpeedBehavior(10 m/s) for 3 s
    do BrakeBehavior() for 3 s
    take OpenDoorAction("{side}", 0 deg)
"""
    text = TEXT.format(**(USUAL | {"more": "with speed 10 m/s, ", "time": 8}))
    begin, end = text.index("\nbehavior Opens"), text.index("ego =")
    scenario = compile_text(text[:begin] + driver + text[end:])
    scenes = scenario.sample(1, seed=5)
    fast = batch.trajectory(scenario.program, scenes, 0, scenario.config.simulation)
    slow = world.run(scenario.program, scenes, 0, scenario.config).trajectory
    out = (0.5 * CAR_WIDTH + 0.06) * (1.0 if side == "left" else -1.0)
    for states in (fast.states, slow.states[: len(fast.time)]):
        car, door = states[-1, 1], states[-1, 2]
        assert car[State.X] > 30.0
        assert door[State.PRESENT] == 1.0
        assert door[State.X] - car[State.X] == pytest.approx(0.2 * CAR_LENGTH - 0.5, abs=2e-3)
        assert door[State.Y] - car[State.Y] == pytest.approx(out, abs=2e-3)
        assert door[State.HEADING] == pytest.approx(car[State.HEADING], abs=1e-9)


def test_a_door_of_a_moving_car_aborts_the_run() -> None:
    """Only a vehicle that stands may open one."""
    text = TEXT.format(**(USUAL | {"more": "with speed 3 m/s, "}))
    scenario = compile_text(text)
    outcomes = batch.simulate(scenario.program, scenario.sample(1, seed=5), scenario.config.simulation)
    assert outcomes.verdict[0] != 0


@pytest.mark.parametrize(
    ("given", "code"),
    [
        ({"action": '"top"'}, "SCN3"),
        ({"action": "3"}, "SCN3"),
        ({"action": '"left", 120 deg'}, "SCN4"),
        ({"action": '"left", 60 deg, 0 s'}, "SCN4"),
        ({"more": "with doorLength 9 m, "}, "SCN4"),
        ({"more": "with doorLength 9 s, "}, "SCN3"),
    ],
)
def test_doors_that_cannot_be_are_refused(given: dict[str, object], code: str) -> None:
    with pytest.raises(CompileError) as caught:
        compile_text(TEXT.format(**(USUAL | given)))
    assert any(each.code.startswith(code) for each in caught.value.diagnostics)


def test_an_object_without_doors_says_so() -> None:
    """Bicycles have none, and a behavior that is put in later comes too late."""
    text = TEXT.format(**USUAL).replace("new Car at", "new Bicycle at")
    with pytest.raises(CompileError, match="has no door"):
        compile_text(text)


def test_only_the_doors_that_are_opened_are_made() -> None:
    """Others keep their programs: a file without the action has no further actors."""
    text = TEXT.format(**USUAL).replace('"left"', '"right"')
    assert list(compile_text(text).program.actors) == ["ego", "parked", "parked_right_door"]
    nested = text.replace("behavior Opens", "behavior Inner").replace(
        "ego =", "behavior Opens():\n    do Inner()\nego ="
    )
    assert len(compile_text(nested).program.actors) == 3
    plain = text.replace('take OpenDoorAction("right")', "wait")
    assert len(compile_text(plain).program.actors) == 2
