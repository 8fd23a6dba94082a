"""MD, MS, D_MS and TTC_MS of one pair, on motions whose answers are known, and their laws."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from engine.kernels.geometry import Box, box_distance
from engine.kernels.pair import (
    CLOSING_SPEED_TOLERANCE,
    NOISE_FLOOR,
    PairMetrics,
    center_velocity,
    closing_speed,
    measure_pair,
)
from engine.tables import SLIDING, Floats
from engine.vocabulary import Side, State

STEP = 0.05
OUTLINES = np.array([[4.0, 2.0, 0.0], [4.0, 2.0, 0.0]])
CAR = np.array([4.508, 1.610, 1.423])


def arc(x: float, y: float, heading: float, speed: float, yaw_rate: float, samples: int, to_center: float) -> Floats:
    """(samples, len(State)) of a rear axle that drives an arc; the centre is recorded."""
    time = np.arange(samples) * STEP
    turned = heading + yaw_rate * time
    way = speed * time
    if yaw_rate:
        way_x = speed / yaw_rate * (np.sin(turned) - np.sin(heading))
        way_y = -speed / yaw_rate * (np.cos(turned) - np.cos(heading))
    else:
        way_x, way_y = way * math.cos(heading), way * math.sin(heading)
    states = np.zeros((samples, len(State)))
    states[:, State.X] = x + way_x + to_center * np.cos(turned)
    states[:, State.Y] = y + way_y + to_center * np.sin(turned)
    states[:, State.HEADING] = turned
    states[:, State.SPEED] = speed
    states[:, State.PRESENT] = 1.0
    return states


def line(x: float, y: float, heading: float, speed: float, samples: int = 60) -> Floats:
    return arc(x, y, heading, speed, 0.0, samples, 0.0)


def measure(ego: Floats, other: Floats, outlines: Floats = OUTLINES, contacted: bool = False) -> PairMetrics:
    states = np.stack([ego, other], axis=1)
    return measure_pair(states, len(states), STEP, 1, outlines, contacted)


@st.composite
def encounters(draw: st.DrawFn) -> tuple[Floats, Floats]:
    """Two cars on arcs in one place at about the same time."""

    def car() -> Floats:
        place, heading = st.floats(-25.0, 25.0), st.floats(-3.0, 3.0)
        speed, yaw_rate = draw(st.floats(0.5, 20.0)), draw(st.sampled_from([0.0, -0.4, 0.1, 0.7]))
        return arc(draw(place), draw(place), draw(heading), speed, yaw_rate, 60, CAR[2])

    return car(), car()


def test_overtaking_is_nearest_side_by_side() -> None:
    """Two lanes 3 m apart: MD is the gap between the flanks, at the first sample that has it or in between."""
    metrics = measure(line(0, 0, 0, 20), line(20, 3, 0, 10))
    assert metrics.min_distance == pytest.approx(1.0, abs=1e-9)
    assert 1.59 <= metrics.min_distance_time <= 2.41


def test_a_crossing_between_samples_is_seen() -> None:
    """At 1 m a step and a closest approach half-way between two samples, samples alone would give too large a value."""
    ego, other = line(0, 0, 0, 0.0), line(-20.5, 2.5, 0, 20)
    tiny = np.array([[0.01, 0.01, 0.0], [0.01, 0.01, 0.0]])
    metrics = measure(ego, other, tiny)
    assert metrics.min_distance == pytest.approx(2.49, abs=1e-4)
    assert metrics.min_distance_time == pytest.approx(20.5 / 20, abs=0.001)


def test_head_on_closing_speed_is_the_sum_from_the_first_sample_on() -> None:
    """A constant closing speed is reached at once: D_MS and TTC_MS are those of the start."""
    metrics = measure(line(0, 0, 0, 10), line(100, 0, math.pi, 15))
    assert metrics.max_closing_speed == pytest.approx(25.0)
    assert metrics.max_closing_time == 0.0
    assert metrics.distance_at_ms == pytest.approx(96.0)
    assert metrics.ttc_at_ms == pytest.approx(96.0 / 25.0)


def test_the_instant_of_ms_is_the_first_within_the_tolerance() -> None:
    """Of closing speeds that grow by less than 0.01 m/s after a point, that point counts and not the largest."""
    ego, other = line(0, 0, 0, 0.0), line(100, 0, math.pi, 10.0)
    other[:, State.SPEED] = 10.0
    other[20:, State.SPEED] = 12.0
    other[40, State.SPEED] = 12.009
    metrics = measure(ego, other)
    assert metrics.max_closing_speed == pytest.approx(12.009)
    assert metrics.max_closing_time == pytest.approx(20 * STEP)


def test_who_never_approaches_scores_nothing() -> None:
    """With MS <= 0 there is no distance and no time to fear."""
    metrics = measure(line(0, 0, 0, 5), line(20, 0, 0, 10))
    assert metrics.max_closing_speed == pytest.approx(-5.0)
    assert (metrics.distance_at_ms, metrics.ttc_at_ms) == (math.inf, math.inf)
    assert metrics.min_distance == pytest.approx(16.0)


def test_the_centre_swings_out_in_a_turn() -> None:
    """A centre ahead of its rear axle moves sideways while the car turns, and that closes a distance, too."""
    turning = arc(0, 0, 0, 5.0, 1.0, 21, 2.0)
    outlines = np.array([[4.0, 2.0, 2.0], [4.0, 2.0, 0.0]])
    metrics = measure(turning, line(2.0, 50.0, 0, 0.0, 21), outlines)
    end = turning[-1]
    place, heading = end[[State.X, State.Y]], end[State.HEADING]
    velocity = np.array([5 * np.cos(heading) - 2 * np.sin(heading), 5 * np.sin(heading) + 2 * np.cos(heading)])
    way = np.array([2.0, 50.0]) - place
    assert metrics.max_closing_speed == pytest.approx(velocity @ way / np.hypot(*way), abs=1e-9)


def test_nothing_counts_once_one_is_absent() -> None:
    """An actor that leaves the scene takes no part in what would have come."""
    ego, other = line(0, 0, 0, 10), line(40, 0, math.pi, 10)
    other[10:, State.PRESENT] = 0.0
    metrics = measure(ego, other)
    assert metrics.min_distance == pytest.approx(36.0 - 9 * STEP * 20)
    assert metrics.min_distance_time == pytest.approx(9 * STEP)


def test_contact_has_distance_zero_at_its_time() -> None:
    """MD is 0 by definition, at the part of the step where the outlines met."""
    states = np.stack([line(0, 0, 0, 10, 21), line(20, 0, math.pi, 10, 21)], axis=1)
    metrics = measure_pair(states, 17, STEP, 1, OUTLINES, True, 0.4)
    assert (metrics.min_distance, metrics.min_distance_time) == (0.0, pytest.approx(16.4 * STEP))


def test_another_pairs_contact_ends_the_measurement_inside_a_step() -> None:
    """The part of the last step before it still counts, what comes after it does not."""
    states = np.stack([line(0, 0, 0, 10, 12), line(40, 0, math.pi, 10, 12)], axis=1)
    metrics = measure_pair(states, 11, STEP, 1, OUTLINES, False, 0.25)
    assert metrics.min_distance == pytest.approx(36.0 - 10.25 * STEP * 20, abs=1e-6)
    assert metrics.min_distance_time == pytest.approx(10.25 * STEP)


def rotated(states: Floats, turn: float, x: float = 0.0, y: float = 0.0) -> Floats:
    moved = states.copy()
    cos, sin = math.cos(turn), math.sin(turn)
    moved[:, State.X] = cos * states[:, State.X] - sin * states[:, State.Y] + x
    moved[:, State.Y] = sin * states[:, State.X] + cos * states[:, State.Y] + y
    moved[:, State.HEADING] += turn
    return moved


def mirrored(states: Floats) -> Floats:
    return states * np.where(np.isin(np.arange(len(State)), [State.Y, State.HEADING, State.STEER]), -1.0, 1.0)


@given(encounters(), st.floats(-3.0, 3.0), st.floats(-50, 50))
def test_metrics_do_not_depend_on_the_axes(pair: tuple[Floats, Floats], turn: float, shift: float) -> None:
    """Turned, shifted or mirrored, a run has the same metrics; exchanged, its two actors have them, too.

    Left out is what rounding alone decides: the direction between centres that (nearly) coincide, an approach as slow
    as the noise floor, and which of two samples is the instant of MS where both are just about fast enough.
    """
    apart = pair[0][:, [State.X, State.Y]] - pair[1][:, [State.X, State.Y]]
    assume(np.hypot(*apart.T).min() > 0.01)
    outlines = np.stack([CAR, CAR])
    changes: list[Callable[[Floats], Floats]] = [lambda s: rotated(s, turn, shift, -shift), mirrored]
    expected = measure(*pair, outlines)
    fastest = expected.max_closing_speed
    assume(abs(fastest - NOISE_FLOOR) > 1e-11)
    cases = [measure(change(pair[0]), change(pair[1]), outlines) for change in changes]
    for metrics in (*cases, measure(pair[1], pair[0], outlines)):
        assert metrics.min_distance == pytest.approx(expected.min_distance, abs=2e-5)
        assert metrics.max_closing_speed == pytest.approx(fastest, abs=1e-10)
        if metrics.max_closing_time == expected.max_closing_time:
            assert metrics.distance_at_ms == pytest.approx(expected.distance_at_ms, abs=1e-9)
            rounding = 1e-9 + 1e-10 / abs(fastest) if fastest else 0.0
            assert metrics.ttc_at_ms == pytest.approx(expected.ttc_at_ms, rel=rounding, abs=1e-9)


@pytest.mark.parametrize(("noise", "known"), [(1e-12, False), (-1e-12, False), (1e-8, True)])
def test_rounding_noise_is_no_approach(noise: float, known: bool) -> None:
    """Two who keep their distance have no D_MS, whichever way their closing speed was rounded."""
    metrics = measure(line(0, 0, 0, 5.0 + noise), line(20, 0, 0, 5.0))
    assert math.isfinite(metrics.distance_at_ms) == known
    assert math.isfinite(metrics.ttc_at_ms) == known


@given(encounters())
def test_no_instant_is_nearer_than_md(pair: tuple[Floats, Floats]) -> None:
    """Twenty instants in every step are no nearer, and not much farther either."""
    outlines = np.stack([CAR, CAR])
    metrics = measure(*pair, outlines)
    fine = [np.concatenate([s[:-1] + part * np.diff(s, axis=0) for part in np.linspace(0, 1, 21)]) for s in pair]
    least = min(map(box_distance, boxes(fine[0]), boxes(fine[1])))
    assert least - 0.06 <= metrics.min_distance <= least + 1e-5


def boxes(states: Floats) -> list[Box]:
    return [Box(*row, *CAR[:2].tolist()) for row in states[:, :3].tolist()]


def test_how_two_meet_is_measured_at_contact() -> None:
    """An ego at 10 m/s drives its front into the left flank of one that crosses at 6 m/s to its right."""
    states = np.stack([line(0, 0, 0, 10, 21), line(8.0, 1.8, -math.pi / 2, 6.0, 21)], axis=1)
    approach = measure_pair(states, 10, STEP, 1, OUTLINES, True, 0.5)
    apart = np.array([8.0 - 4.75, 1.8 - 2.85])
    closing = -float(apart @ np.array([-10.0, -6.0])) / float(np.hypot(*apart))
    assert (approach.ego_speed, approach.other_speed) == (10.0, 6.0)
    assert approach.approach_angle == pytest.approx(-math.pi / 2)
    assert approach.closing_speed == pytest.approx(closing, abs=0.05)
    assert approach.side == Side.FRONT


@pytest.mark.parametrize(
    ("x", "y", "heading", "side"),
    [
        (5.0, 0.0, 0.0, Side.FRONT),
        (3.0, 2.4, math.pi / 2, Side.FRONT),
        (0.5, 2.2, 0.0, Side.LEFT),
        (0.5, -3.2, math.pi / 2, Side.RIGHT),
        (-4.2, 0.8, 0.0, Side.REAR),
        (-2.9, 0.9, math.pi / 2, Side.REAR),
    ],
)
def test_the_side_is_that_of_the_outline(x: float, y: float, heading: float, side: Side) -> None:
    """Where outlines lie beside each other decides, not where their centres do: a tail may be in front."""
    ego, other = line(0, 0, 0, 0.0, 2), line(x, y, heading, 0.0, 2)
    assert measure(ego, other).side == side


def test_who_never_meets_has_no_approach() -> None:
    """Nothing is known about an instant that never comes."""
    ego, other = line(0, 0, 0, 10), line(40, 0, 0, 10)
    other[:, State.PRESENT] = 0.0
    approach = measure(ego, other)
    assert np.isnan([approach.ego_speed, approach.other_speed, approach.approach_angle, approach.closing_speed]).all()
    assert approach.side == -1


@given(encounters(), st.floats(-3.0, 3.0), st.floats(-50, 50))
def test_how_two_meet_does_not_depend_on_the_axes(pair: tuple[Floats, Floats], turn: float, shift: float) -> None:
    """Turning and shifting change nothing; a mirror turns the angle round and exchanges left and right.

    Left out is what rounding alone decides: which of two equally near instants is the first, the direction between
    centres that nearly coincide, a side at a corner.
    """
    outlines = np.stack([CAR, CAR])
    expected = measure(*pair, outlines)
    turned = measure(*[rotated(s, turn, shift, -shift) for s in pair], outlines=outlines)
    reflected = measure(*map(mirrored, pair), outlines=outlines)
    for metrics, sign, sides in ((turned, 1.0, (0, 1, 2, 3)), (reflected, -1.0, (0, 3, 2, 1))):
        assume(abs(metrics.min_distance_time - expected.min_distance_time) < 1e-7)
        found, wanted = metrics, expected
        assert found.ego_speed == pytest.approx(wanted.ego_speed, abs=1e-6)
        assert found.other_speed == pytest.approx(wanted.other_speed, abs=1e-6)
        assert math.cos(found.approach_angle - sign * wanted.approach_angle) == pytest.approx(1.0)
        if expected.min_distance > 0.01:
            assert found.closing_speed == pytest.approx(wanted.closing_speed, abs=1e-5)
            assert found.side == sides[int(wanted.side)] or _at_a_corner(pair, expected)


def _at_a_corner(pair: tuple[Floats, Floats], metrics: PairMetrics) -> bool:
    """Whether the other is beyond two sides of the ego by nearly as much, so that rounding may take either."""
    steps = metrics.min_distance_time / STEP
    k, part = int(steps), steps - int(steps)
    ego, other = (s[k, :3] + part * (s[min(k + 1, len(s) - 1), :3] - s[k, :3]) for s in pair)
    cos, sin = math.cos(ego[2]), math.sin(ego[2])
    x, y = other[:2] - ego[:2]
    c, s = abs(math.cos(other[2] - ego[2])), abs(math.sin(other[2] - ego[2]))
    length, width = CAR[:2]
    ahead = abs(cos * x + sin * y) - 0.5 * (length + length * c + width * s)
    aside = abs(cos * y - sin * x) - 0.5 * (width + length * s + width * c)
    return abs(ahead - aside) < 1e-5


def test_a_blow_is_in_no_velocity() -> None:
    """Before it a body drives at 20 m/s, after it it slides at 5: never at what lies in between."""
    states = np.zeros((6, 1, len(State)))
    states[:, 0, State.X] = np.cumsum([0.0, 20.0, 20.0, 11.0, 5.0, 5.0]) * STEP  # struck in the third step
    states[:3, 0, State.SPEED], states[3:, 0, State.SPEED] = 20.0, 5.0
    states[:3, 0, State.PRESENT], states[3:, 0, State.PRESENT] = 1.0, SLIDING
    found = [center_velocity(states, 6, k, STEP, 0, 1.4).x for k in range(6)]
    assert found == pytest.approx([20.0, 20.0, 20.0, 5.0, 5.0, 5.0])


@given(steps=st.lists(st.sampled_from([0.0, 0.004, 0.008, 0.02, -0.002, -0.03]), min_size=60, max_size=60))
def test_the_instant_of_ms_is_the_first_of_all(steps: list[float]) -> None:
    """However closing speeds rise and fall, no earlier sample is within the tolerance of the largest."""
    ego, other = line(0, 0, 0, 10.0), line(100, 0, math.pi, 10.0)
    ego[:, State.SPEED] += np.cumsum(steps)
    states = np.stack([ego, other], axis=1)
    speeds = [closing_speed(states, len(states), k, STEP, 1, OUTLINES) for k in range(len(states))]
    first = next(k for k, speed in enumerate(speeds) if speed >= max(speeds) - CLOSING_SPEED_TOLERANCE)
    metrics = measure(ego, other)
    assert metrics.max_closing_speed == max(speeds)
    assert metrics.max_closing_time == first * STEP
