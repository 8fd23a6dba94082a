"""The driver from outside of the suite of rare failures, and the files that it drives."""

from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cortex_dsl as cx
from benchmarks.suite import scenarios
from benchmarks.suite.highway_driver import EGO, LANES, MODULE, PLACE, WIDTH, IdmMobil, lanes_of, pedals
from benchmarks.suite.scenarios import DRIVEN, FOLDERS, named
from engine.driving.observations import observed
from engine.extras import MissingExtraError, is_installed

FILES = [FOLDERS[DRIVEN] / f"{name}.scn" for name in named(DRIVEN)]
EVERY_FILE = pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
WITH_PACKAGE = pytest.mark.skipif(not is_installed(MODULE), reason="highway-env is not installed")
STEP, STEPS = 0.05, 4
"""Time step [s], and steps from one decision to the next."""
OVERTAKING = {"BEHIND": 120, "OTHER_SPEED": 25, "AFTER": 10, "DURATION": 3, "CLEAR": 20}
"""Params of the file with a truck by which no other actor is near the ego."""


@EVERY_FILE
def test_a_file_records_what_the_driver_needs(file: Path) -> None:
    """Place, heading and speed of each actor, its wish and its phase; no column is left over."""
    program = cx.load(file).program
    assert program.actors[0] == EGO
    needed = [each.format(actor) for actor in program.actors for each in PLACE]
    assert sorted(name for name, _ in observed(program, True)) == sorted([*needed, "target speed", "phase"])
    assert [control.every for control in program.controls] == [STEP * STEPS]


@EVERY_FILE
def test_the_road_of_a_file_is_the_road_of_the_driver(file: Path) -> None:
    """All actors start in the middle of a lane, as the driver knows them, and face along the road."""
    made = cx.load(file)
    scenes = made.environment(8)
    seen, names = scenes.reset(seed=1), [name for name, _ in scenes.observations]
    for actor in made.program.actors:
        x, y, heading, _ = (seen[:, names.index(each.format(actor))] for each in PLACE)
        assert (np.abs(x) < 1500.0).all()
        assert np.abs((lanes_of(-y) + 0.5) * WIDTH + y).max() < 1e-6
        assert np.abs(heading).max() < 1e-9


@given(st.floats(-5.0, LANES * WIDTH + 5.0))
def test_the_lane_is_that_of_the_nearest_centre_line(right: float) -> None:
    """Also for a place off the road."""
    middles = (np.arange(LANES) + 0.5) * WIDTH
    assert abs(middles[lanes_of(np.array([right]))[0]] - right) <= abs(middles - right).min() + 1e-9


@given(st.floats(-6.0, 6.0), st.floats(-1.0, 1.0))
def test_pedals_give_the_acceleration(acceleration: float, steering: float) -> None:
    """One pedal at most is pressed, within its range, and the wheels turn to the other side of the mirrored frame."""
    throttle, brake, turn = pedals(acceleration, steering, 6.0)
    assert min(throttle, brake) == 0.0
    assert max(throttle, brake) <= 1.0
    assert 6.0 * (throttle - brake) == pytest.approx(acceleration)
    assert turn == -steering


def test_without_the_package_files_are_left_out(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """With the reason and the cure; their programs are still compiled."""
    monkeypatch.setattr(scenarios, "is_installed", lambda _: False)
    assert scenarios.runnable(["cut_in", *named(DRIVEN)]) == ["cut_in"]
    told = capsys.readouterr().err
    assert "highway-env is not installed" in told
    assert "[bench]" in told
    assert scenarios.scenario(named(DRIVEN)[0]).config.driver is None
    if not is_installed(MODULE):
        with pytest.raises(MissingExtraError, match="which is not installed"):
            IdmMobil()


@WITH_PACKAGE
@pytest.mark.parametrize(
    ("wish", "ahead", "truck", "phase"), [(30, 60, 20, 0.3), (26, 90, 21, 0.9), (22, 150, 25, 0.5)]
)
def test_it_moves_as_in_the_simulator_of_the_package(wish: float, ahead: float, truck: float, phase: float) -> None:
    """It overtakes a truck along the same way at the same speed, and stays behind one that is faster."""
    params: dict[str, Any] = {**OVERTAKING, "EGO_SPEED": wish, "AHEAD": ahead, "TRUCK_SPEED": truck, "PHASE": phase}
    file = FOLDERS[DRIVEN] / "outside_merge.scn"
    made = cx.load(file, **params).driven_by(IdmMobil())
    here = made.watch(made.sample(1, seed=1)).trajectory.states[:, :, :4]
    there = simulated_by_the_package(here, wish, phase)
    assert np.abs(there[:, :2] - here[:, 0, :2]).max() < 0.25
    assert np.abs(there[:, 2:] - here[:, 0, 2:]).max() < 0.1
    assert (here[-1, 0, 1] > -LANES * WIDTH + WIDTH) == (wish > truck)


def simulated_by_the_package(states: np.ndarray, wish: float, phase: float) -> np.ndarray:
    """Return (samples, 4) x, y, heading and speed of the ego in a `Road` of the package, where others move as here."""
    behavior, road_module, lane_module = (
        import_module(f"highway_env.{name}") for name in ("vehicle.behavior", "road.road", "road.lane")
    )
    network = road_module.RoadNetwork()
    for number in range(LANES):
        middle = (number + 0.5) * WIDTH
        network.add_lane("0", "1", lane_module.StraightLane((-1e4, middle), (1e4, middle), WIDTH, speed_limit=None))
    road = road_module.Road(network)
    mirrored = states * (1.0, -1.0, -1.0, 1.0)
    cars = [behavior.IDMVehicle(road, state[:2], state[2], state[3], timer=phase) for state in mirrored[0]]
    ego, others = cars[0], cars[1:]
    ego.target_speed, road.vehicles = wish, cars
    moved = [[*ego.position, ego.heading, ego.speed]]
    for step, after in enumerate(mirrored[1:]):
        if step % STEPS == 0:
            ego.act()
        ego.step(STEP)
        for car, state in zip(others, after[1:], strict=True):
            car.position, car.heading, car.speed = state[:2].copy(), state[2], state[3]
            car.target_speed = car.speed
            car.on_state_update()
        moved.append([*ego.position, ego.heading, ego.speed])
    return np.array(moved) * (1.0, -1.0, -1.0, 1.0)


@WITH_PACKAGE
def test_rows_do_not_depend_on_one_another() -> None:
    """Scenes in one block, or in many: the same decisions to the bit, and a second run repeats them."""
    made = scenarios.scenario("outside_merge")
    first, again, apart = (made.driven_by(IdmMobil(), block=block).sample(40, seed=3).actions for block in (40, 40, 7))
    assert np.abs(first).max() > 0.0
    assert np.array_equal(first, again)
    assert np.array_equal(first, apart)
