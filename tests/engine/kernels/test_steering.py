"""Bars of the path follower: offsets in turns and on straights, no overshoot, slow enough in time."""

import math

import numpy as np
import pytest

from engine.maps import RoadSpec
from engine.opcodes import Op
from engine.road import Primitive, build_network, road_tables
from engine.vehicles import MODELS
from engine.vocabulary import ActorKind, State

CAR, PEDESTRIAN = ActorKind.CAR, ActorKind.PEDESTRIAN


class Track:
    """A path alone in the world, and an actor that follows it from a start 40 m (or 0 m) before a bend."""

    def __init__(self, hand, *pieces: tuple[float, float]) -> None:
        """`pieces`: curvature and length of each."""
        self.hand, self.network = hand, build_network(RoadSpec())
        chain: list[Primitive] = []
        x, y, heading = 0.0, 0.0, 0.0
        for curvature, length in pieces:
            chain.append(Primitive(x, y, heading, curvature, length))
            x, y, heading = chain[-1].pose(length)
        self.path = self.network.paths.add(chain)

    def follow(self, speed: float, target: float, *, left: float = 0.0, kind=CAR, lateral: float = 3.0, **settings):
        """States of the actor on its way to the end of the path."""
        code = self.hand.assembler(kind)
        code.follow(
            code.behaviour(0), self.hand.literal(self.path), self.hand.literal(target), self.hand.literal(lateral)
        )
        code.emit(Op.HALT)
        scene = self.hand.scenes([self.hand.placed(kind, MODELS[kind].rear_to_center, left, 0, speed)])
        return self.hand.states(code.program(road_tables(self.network)), scene, **settings)[:, 0]

    def rear_axle(self, states, kind=CAR):
        """Arc length and distance from the path of the rear axle at each sample."""
        heading = states[:, State.HEADING]
        to_center = MODELS[kind].rear_to_center
        x = states[:, State.X] - to_center * np.cos(heading)
        y = states[:, State.Y] - to_center * np.sin(heading)
        return self.network.paths.feet(self.path, x, y)

    def offsets(self, states, kind=CAR):
        """Arc length of the rear axle and its offset to the left of the path at each sample."""
        s, offset = self.rear_axle(states, kind)
        to_center = MODELS[kind].rear_to_center
        for k, (station, state) in enumerate(zip(s, states, strict=True)):
            foot, heading = self.network.paths.pose(self.path, station), state[State.HEADING]
            x, y = state[State.X] - to_center * math.cos(heading), state[State.Y] - to_center * math.sin(heading)
            offset[k] = math.copysign(
                offset[k], (y - foot.y) * math.cos(foot.heading) - (x - foot.x) * math.sin(foot.heading)
            )
        return s, offset


@pytest.fixture(scope="module")
def straight(hand) -> Track:
    return Track(hand, (0.0, 400.0))


@pytest.mark.parametrize("radius", [6.0, 8.0, 10.0, 14.0])
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("speed", [4.0, 9.0, 14.0])
@pytest.mark.parametrize("phase", [0.0, 0.07, 0.14])
def test_turns_are_met_at_the_planned_speed(hand, radius: float, sign: float, speed: float, phase: float) -> None:
    """The rear axle stays within 0.20 m in the turn and settles within 0.02 m, wherever samples fall; so does speed."""
    start, end = 50 + phase, 50 + phase + radius * math.pi / 2
    track = Track(hand, (0.0, start), (sign / radius, end - start), (0.0, 60.0))
    states = track.follow(speed, speed)
    s, offset = track.rear_axle(states)
    assert offset.max() <= 0.20
    assert offset[s > end + 25].max() <= 0.02
    planned = min(speed, math.sqrt(3.0 * radius))
    turning = (s >= start) & (s <= end)
    assert states[turning, State.SPEED].max() <= planned + 0.15
    assert states[turning, State.SPEED].min() >= planned - 0.15
    assert states[-1, State.SPEED] == pytest.approx(speed, abs=0.3)


@pytest.mark.parametrize("speed", [2.0, 5.0, 8.0, 12.0, 17.0, 22.0])
@pytest.mark.parametrize("offset", [-2.0, -1.0, 0.3, 1.0, 2.0])
def test_no_overshoot_from_offsets(straight: Track, speed: float, offset: float) -> None:
    """From up to 2 m aside the car comes back to the path and never crosses it by more than 0.02 m."""
    states = straight.follow(speed, speed, left=offset, max_time=16.0)
    heading = states[:, State.HEADING]
    rear = (states[:, State.Y] - MODELS[CAR].rear_to_center * np.sin(heading)) * np.sign(offset)
    assert rear.min() >= -0.02
    assert abs(rear[-1]) <= 0.02


def test_speed_comes_from_above_and_from_below(straight: Track) -> None:
    """A target is reached within its limits -8 .. +3 m/s^2 and without overshoot."""
    for start, target in ((0.0, 12.0), (20.0, 5.0)):
        states = straight.follow(start, target, max_time=8.0)
        speed, acceleration = states[:, State.SPEED], states[:, State.ACCELERATION]
        assert speed[-1] == pytest.approx(target, abs=1e-3)
        assert min(start, target) <= speed.min() <= speed.max() <= max(start, target) + 1e-9
        assert acceleration.min() >= -8 - 1e-9
        assert acceleration.max() <= 3 + 1e-9


def test_without_a_lateral_limit_the_target_speed_is_kept(hand) -> None:
    """`max_lateral=none` is an infinity: no plan, the car enters the bend at its target speed and runs wide."""
    track = Track(hand, (0.0, 30.0), (1 / 8.0, 12.0), (0.0, 60.0))
    states = track.follow(15.0, 15.0, lateral=math.inf)
    s, offset = track.rear_axle(states)
    assert states[s <= 30, State.SPEED].min() == pytest.approx(15.0)
    assert offset.max() > 1.0


def test_a_late_start_brakes_as_hard_as_it_can(hand) -> None:
    """20 m before a bend at 14 m/s there is no comfortable plan: full braking first, and the bend is met."""
    track = Track(hand, (0.0, 22.0), (1 / 8.0, 12.0), (0.0, 60.0))
    states = track.follow(14.0, 14.0)
    s, offset = track.rear_axle(states)
    assert states[1, State.ACCELERATION] == pytest.approx(-8.0)
    assert states[(s >= 22) & (s <= 34), State.SPEED].max() <= math.sqrt(3.0 * 8.0) + 0.8
    assert offset.max() <= 0.25


def test_a_pedestrian_follows_corners_closely(hand) -> None:
    """A walker comes onto the path from aside without crossing it and stays within a hand's breadth of a bend."""
    track = Track(hand, (0.0, 20.0), (0.5, math.pi), (0.0, 20.0))
    states = track.follow(1.4, 1.4, left=1.0, kind=PEDESTRIAN)
    s, offset = track.rear_axle(states, PEDESTRIAN)
    assert states[:, State.Y][s < 15].min() >= -1e-3
    assert offset[s > 12].max() <= 0.1
    assert states[:, State.SPEED] == pytest.approx(np.full(len(states), 1.4))


def test_the_route_ends_where_the_centre_reaches_its_end(straight: Track) -> None:
    """The last sample of a follower is the first with its centre at or behind the end of the path."""
    states = straight.follow(20.0, 20.0)
    assert states[-1, State.X] >= 400.0
    assert states[-2, State.X] < 400.0


QUINTIC = np.polynomial.Polynomial([0, 0, 0, 10, -15, 6])
WHEELS = (CAR, ActorKind.TRUCK, ActorKind.BUS, ActorKind.BICYCLE, ActorKind.MOTORCYCLE)


@pytest.mark.parametrize("kind", WHEELS)
@pytest.mark.parametrize("curvature", [0.0, 1 / 20, -1 / 20, 1 / 40, -1 / 100])
@pytest.mark.parametrize("offsets", [(0.0, 0.6), (0.7, -0.8), (-1.2, -1.2), (0.3, 2.5)])
@pytest.mark.parametrize("speed", [3.0, 8.0, 14.0])
def test_an_offset_is_approached_along_the_quintic(hand, kind, curvature: float, offsets, speed: float) -> None:
    """On straights and arcs the rear axle stays within 5 cm of the curve, while the offset changes and after it."""
    begin, end = offsets
    speed = min(speed, math.sqrt(2.5 / abs(curvature)) if curvature else speed)
    track = Track(hand, (curvature, min(140.0, 3.0 / abs(curvature)) if curvature else 140.0))
    code = hand.assembler(kind)
    block, (path, target) = code.behaviour(0), map(hand.literal, (track.path, speed))
    settled = track.network.paths.add([Primitive(0.0, 0.0, 0.0, curvature, 30.0)])
    code.follow(block, hand.literal(settled), target, aside=hand.literal(begin))
    code.follow(block, path, target, progress=1, aside=hand.literal(end))
    code.emit(Op.HALT)
    scene = hand.scenes([hand.placed(kind, MODELS[kind].rear_to_center, begin, 0, speed)])
    states = hand.states(code.program(road_tables(track.network)), scene, max_time=50.0)[:, 0]
    s, offset = track.offsets(states, kind)
    first = np.argmax(s > 30.0 - MODELS[kind].rear_to_center)
    last = first + np.argmax(s[first:] >= track.network.paths.length(track.path) - 5.0)
    s, offset, length = s[first:last], offset[first:last], max(math.sqrt(115.6 * abs(end - begin)), 3.5 * speed, 1.0)
    curve = begin + (end - begin) * QUINTIC(np.clip((s - s[0]) / length, 0, 1))
    assert np.abs(offset - curve).max() <= 0.05
