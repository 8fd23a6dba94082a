"""What behaviours may ask about others: who leads along a path, and the time to collision."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine import batch
from engine.config import SimulationConfig
from engine.kernels.conflict import snapshot, time_to_collision
from engine.opcodes import Op
from engine.scenes import Trajectory
from engine.tables import SLIDING
from engine.vocabulary import ActorKind, Column, Command, ManeuverType, RuleKind, State
from tests.laws import examples

CAR = ActorKind.CAR
SIZE = (4.508, 1.610)
ROUTE = ("south", ManeuverType.LEFT_TURN)
compiled = examples(60)


@pytest.fixture(scope="module")
def driven(hand):
    """A function of starts (x, y, heading, speed, steer) to a run of 0.5 s in which everybody holds its steering, with
    TTC of every pair, of actor 0 to all, and its leader on the way from the south to the west watched. Nobody hides
    anybody: these may overlap.
    """

    def drive(*starts: tuple[float, float, float, float, float]) -> Trajectory:
        code = hand.assembler(*[CAR] * len(starts))
        asked = [
            *((Op.TTC, 0, other) for other in (*range(1, len(starts)), -1)),
            (Op.LEAD, 0, hand.literal(hand.route(*ROUTE)), hand.literal(math.inf)),
        ]
        for op, *operands in asked:
            code.rule(hand.temporary(0), RuleKind.WATCH)
            code.emit(op, hand.temporary(0), *operands)
            code.emit(Op.END)
        code.rule(hand.temporary(1), RuleKind.WATCH)
        code.emit(Op.LEAD, hand.temporary(0), *asked[-1][1:])
        code.emit(Op.END)
        for actor, (*_, steer) in enumerate(starts):
            code.behaviour(actor)
            code.emit(Op.COMMAND, 0, int(Command.STEER), hand.literal(steer))
            code.emit(Op.HALT)
        scene = hand.scenes([hand.placed(CAR, *start[:4], occluding=0.0) for start in starts])
        return batch.trajectory(code.program(hand.road()), scene, 0, SimulationConfig(max_time=0.5))

    return drive


def driven_samples(trajectory: Trajectory) -> int:
    """Samples before anybody slides: `test_pair` has the velocity of who was struck."""
    slides = (trajectory.states[:, :, State.PRESENT] == SLIDING).any(axis=1)
    return min(len(trajectory.watched), int(np.argmax(slides)) if slides.any() else len(slides))


def place() -> st.SearchStrategy[float]:
    return st.floats(-30.0, 30.0)


STARTS = st.lists(
    st.tuples(place(), place(), st.floats(-3.1, 3.1), st.floats(0.0, 20.0), st.sampled_from([0.0, 0.2, -0.4])),
    min_size=3,
    max_size=3,
)


@compiled
@given(starts=STARTS)
def test_ttc_is_that_of_the_metrics(driven, hand, starts) -> None:
    """At every sample as the metrics have it of a run that ends there; asked of all, the least."""
    trajectory = driven(*starts)
    to_center = hand.placed(CAR, 0, 0, 0, 0)[Column.REAR_TO_CENTER]
    outlines = np.column_stack([trajectory.outlines, np.full(len(starts), to_center)])
    for k in range(driven_samples(trajectory)):
        run = trajectory.states[: k + 1]
        expected = [
            time_to_collision(snapshot(run, k + 1, k, 0.0, 0.05, other, outlines)) for other in range(1, len(starts))
        ]
        assert list(trajectory.watched[k, : len(expected)]) == expected
        assert trajectory.watched[k, len(expected)] == min(expected)


def ahead(hand, states: np.ndarray, path: int) -> tuple[float, float]:
    """The leader of actor 0 by the corners of the outlines."""
    paths = hand.network.paths

    def along(state: np.ndarray) -> tuple[float, float, float, float]:
        """Foot point's arc length, distance to it, direction of the path there and of the outline."""
        s = float(paths.project(path, state[State.X], state[State.Y]))
        pose = paths.pose(path, s)
        return s, math.hypot(state[State.X] - pose.x, state[State.Y] - pose.y), pose.heading, state[State.HEADING]

    def reach(path_heading: float, heading: float, side: float) -> float:
        """How far the outline's corners reach along (side = 0) or across the path."""
        corners = [(x * SIZE[0] / 2, y * SIZE[1] / 2) for x in (-1, 1) for y in (-1, 1)]
        turn = heading - path_heading - side
        return max(x * math.cos(turn) - y * math.sin(turn) for x, y in corners)

    mine = along(states[0])
    found = (math.inf, 0.0)
    for state in states[1:]:
        s, aside, path_heading, heading = along(state)
        if s > mine[0] and aside < SIZE[1] / 2 + reach(path_heading, heading, math.pi / 2):
            gap = max(0.0, s - reach(path_heading, heading, 0.0) - mine[0] - reach(mine[2], mine[3], 0.0))
            found = min(found, (gap, state[State.SPEED] * math.cos(heading - path_heading)), key=lambda f: f[0])
    return found


LANE = st.tuples(
    st.floats(-25.0, 5.0), st.floats(-60.0, 10.0), st.floats(-3.1, 3.1), st.floats(0.0, 20.0), st.just(0.0)
)


@compiled
@given(starts=st.lists(LANE, min_size=3, max_size=3))
def test_the_leader_is_the_nearest_ahead_in_my_strip(driven, hand, starts) -> None:
    """The gap along the path between the outlines, and the leader's speed along the path."""
    trajectory = driven(*starts)
    path = hand.route(*ROUTE)
    for k in range(driven_samples(trajectory)):
        gap, speed = ahead(hand, trajectory.states[k], path)
        assert trajectory.watched[k, -2] == pytest.approx(gap, abs=1e-9)
        assert trajectory.watched[k, -1] == pytest.approx(speed, abs=1e-9)


def test_the_leader_on_a_straight_road(driven) -> None:
    """Behind one car at 6 m/s, 20 m from centre to centre, with another abreast and one coming back."""
    south = math.pi / 2
    trajectory = driven((1.75, -40, south, 10, 0), (1.75, -20, south, 6, 0), (-1.75, -30, -south, 5, 0))
    assert trajectory.watched[0, -2] == pytest.approx(20 - SIZE[0])
    assert trajectory.watched[0, -1] == pytest.approx(6.0)
    alone = driven((1.75, -40, south, 10, 0), (1.75, -50, south, 6, 0), (-1.75, -30, -south, 5, 0))
    assert (alone.watched[0, -2], alone.watched[0, -1]) == (math.inf, 0.0)
    oncoming = driven((1.75, -40, south, 10, 0), (1.75, -20, -south, 6, 0), (30, 30, 0, 5, 0))
    assert oncoming.watched[0, -1] == pytest.approx(-6.0)
    assert oncoming.watched[0, 0] == pytest.approx((20 - SIZE[0]) / 16)
