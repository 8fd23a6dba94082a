"""Whose failure a collision is: on scenes and motions where it is plain."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cortex_dsl import compile_text, load
from engine.host import plain
from engine.interchange.measuring import measure
from engine.interchange.recording import recorded_run
from engine.kernels.approach import search_contact_of
from engine.kernels.fault import fault_of
from engine.kernels.pair import measure_pair
from engine.tables import no_road
from engine.vocabulary import Fault, Side, State
from engine.world import run

EXAMPLE = Path(__file__).parents[2] / "examples" / "left_turn.scn"


def fault(text: str) -> Fault:
    """Of the ego's collision with the other."""
    scenario = compile_text(text)
    outcomes = scenario.simulate(scenario.sample(1))
    assert outcomes.collided[0]
    return Fault(int(outcomes.fault[0, 0]))


def test_who_is_struck_from_behind_has_not_failed() -> None:
    """The ego drives slowly on, another runs into its rear; the same the other way round is the ego's."""
    text = """
map intersection(ways=4, lanes=1)
ego = new Car at ({0}, -1.75), facing 0 deg, with speed {1} m/s
other = new Car at ({2}, -1.75), facing 0 deg, with speed {3} m/s
terminate after 12 s
"""
    assert fault(text.format(-30, 3, -50, 12)) is Fault.STRUCK_FROM_BEHIND
    assert fault(text.format(-50, 12, -30, 3)) is Fault.EGO


@pytest.mark.parametrize("behind", ["Car", "Obstacle"])
def test_who_backs_into_another_has_failed(behind: str) -> None:
    """A car that stands, or a wall, behind an ego in reverse is no other who runs into it."""
    text = f"""
map intersection(ways=4, lanes=1)
behavior Back():
    take SetReverseAction(True)
    while True:
        take SetThrottleAction(0.5)
ego = new Car at (-25, -1.75), facing 0 deg, with behavior Back()
other = new {behind} at (-40, -1.75), facing 0 deg, with mass 2000 kg
terminate after 12 s
"""
    assert fault(text) is Fault.EGO


@pytest.mark.parametrize(
    ("place", "facing", "expected"),
    [
        ((-30.0, -1.75), 0.0, Fault.STRUCK_STANDING),
        ((-30.0, -1.75), 4.0, Fault.STRUCK_STANDING),
        ((0.0, -1.75), 0.0, Fault.EGO),
        ((-30.0, 1.75), 0.0, Fault.EGO),
        ((-30.0, 0.0), 90.0, Fault.EGO),
        ((-30.0, 0.0), 0.0, Fault.EGO),
    ],
)
def test_who_stands_where_one_may_stand_has_not_failed(
    place: tuple[float, float], facing: float, expected: Fault
) -> None:
    """In its lane before an intersection, but not in the middle of it, in the oncoming lane, or across the road."""
    x, y = place
    text = f"""
map intersection(ways=4, lanes=1)
ego = new Car at ({x}, {y}), facing {facing} deg
other = new Car at ({x + 25}, {y}), facing 180 deg, with speed 10 m/s
terminate after 12 s
"""
    assert fault(text) is expected


# -- on motions made by hand ------------------------------------------------------------------------------------------

TIME = np.arange(0.0, 12.0, 0.05)
Motion = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


def of_motions(ego: Motion, other: Motion) -> Fault:
    """Of the first contact of two cars 4.5 m by 1.8 m whose centres move so, each along its heading."""
    states = np.zeros((len(TIME), 2, len(State)))
    states[:, :, State.PRESENT] = 1.0
    for actor, motion in enumerate((ego, other)):
        x, y = motion(TIME)
        vx, vy = np.gradient(x, TIME), np.gradient(y, TIME)
        states[:, actor, State.X], states[:, actor, State.Y] = x, y
        states[:, actor, State.HEADING] = np.unwrap(np.arctan2(vy, vx))
        states[:, actor, State.SPEED] = np.hypot(vx, vy)
    outlines = np.array([[4.5, 1.8, 0.0], [4.5, 1.8, 0.0]])
    touch = search_contact_of(states, outlines, 0, 1)
    met = measure_pair(states, touch.sample + 1, 0.05, 1, outlines, True, touch.part)
    assert met.side == Side.REAR
    return Fault(fault_of(states, touch.sample, 0.05, 1, outlines, met, plain(no_road()), 0))


def straight(start: float, speed: float, aside: float = 0.0) -> Motion:
    return lambda time: (start + speed * time, np.full_like(time, aside))


def merging(start: float, speed: float, begin: float) -> Motion:
    """From the next lane, within one second."""

    def motion(time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        done = np.clip(time - begin, 0.0, 1.0)
        return start + speed * time, 3.5 * (1.0 - done * done * (3.0 - 2.0 * done))

    return motion


def circling(start: float, speed: float) -> Motion:
    """On a circle with a radius of 15 m."""

    def motion(time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        angle = (start + speed * time) / 15.0
        return 15.0 * np.sin(angle), 15.0 - 15.0 * np.cos(angle)

    return motion


def turning_in(speed: float, begin: float) -> Motion:
    """Out of a side street at x = 0, along a quarter of a circle of 6 m that ends on the x axis."""

    def motion(time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        way = speed * (time - begin)
        angle = np.clip(way / 6.0, 0.0, 0.5 * np.pi)
        beyond = np.maximum(0.0, way - 3.0 * np.pi)
        return 6.0 - 6.0 * np.cos(angle) + beyond, 6.0 * np.sin(angle) - 6.0 + np.minimum(0.0, way)

    return motion


def test_who_is_followed_for_a_second_is_struck() -> None:
    """On a straight road and on a narrow curve, and long after a change of lanes."""
    assert of_motions(straight(0.0, 5.0), straight(-40.0, 15.0)) is Fault.STRUCK_FROM_BEHIND
    assert of_motions(circling(0.0, 4.0), circling(-20.0, 9.0)) is Fault.STRUCK_FROM_BEHIND
    assert of_motions(merging(0.0, 10.0, 0.5), straight(-30.0, 15.0)) is Fault.STRUCK_FROM_BEHIND


def test_who_cuts_in_is_not_struck() -> None:
    """The other reaches the ego's rear half a second after the ego has left the next lane."""
    assert of_motions(merging(0.0, 10.0, 4.0), straight(-30.0, 15.0)) is Fault.EGO


def test_who_turns_in_is_not_struck() -> None:
    """Out of a side street, with somebody on the road who cannot stop."""
    assert of_motions(turning_in(5.0, 1.0), straight(-45.0, 15.0)) is Fault.EGO


# -- everywhere alike -------------------------------------------------------------------------------------------------


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


def test_without_a_road_one_may_stand_anywhere() -> None:
    """A recording that does not say where it was has no intersections and no lanes."""
    scenario = compile_text("""
map intersection(ways=4, lanes=1)
ego = new Car at (0, -1.75), facing 0 deg
other = new Car at (25, -1.75), facing 180 deg, with speed 10 m/s
terminate after 12 s
""")
    scenes = scenario.sample(1)
    ran = run(scenario.program, scenes, 0, scenario.config)
    recording = recorded_run(scenario.program, scenes, ran, row=0, step=0.05)
    assert measure(recording).outcomes.fault[0, 0] == Fault.EGO
    assert measure(replace(recording, road=None)).outcomes.fault[0, 0] == Fault.STRUCK_STANDING
