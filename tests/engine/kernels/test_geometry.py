"""Distance and contact of outlines, held against plain polygons and against dense sampling."""

import importlib.util
import itertools
import math
import sys
from pathlib import Path
from types import ModuleType

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.kernels.approach import DISTANCE_TOLERANCE, TOUCH, closest_in_step, first_contact
from engine.kernels.geometry import Box, box_distance

"""The first call compiles."""

ANGLES = st.floats(-4.0, 4.0)
PLACES = st.floats(-8.0, 8.0)
SIZES = st.floats(0.3, 12.0)


@st.composite
def boxes(draw: st.DrawFn) -> Box:
    return Box(draw(PLACES), draw(PLACES), draw(ANGLES), draw(SIZES), draw(SIZES))


@st.composite
def motions(draw: st.DrawFn) -> tuple[Box, Box]:
    """An outline at the start and at the end of a step."""
    box = draw(boxes())
    way, turn = st.floats(-2.0, 2.0), draw(st.floats(-0.3, 0.3))
    return box, box._replace(x=box.x + draw(way), y=box.y + draw(way), heading=box.heading + turn)


def box(x: float, y: float, heading: float, length: float, width: float) -> Box:
    """A box of floats: integers would compile the kernels anew."""
    return Box(float(x), float(y), float(heading), float(length), float(width))


def corners(box: Box) -> list[complex]:
    turn = complex(math.cos(box.heading), math.sin(box.heading))
    half = complex(box.length, box.width) / 2
    around = (half, complex(-half.real, half.imag), -half, complex(half.real, -half.imag))
    return [complex(box.x, box.y) + turn * corner for corner in around]


def edges(box: Box) -> list[tuple[complex, complex]]:
    points = corners(box)
    return list(itertools.pairwise([*points, points[0]]))


def point_to_segment(p: complex, a: complex, b: complex) -> float:
    t = ((p - a) * (b - a).conjugate()).real / abs(b - a) ** 2
    return abs(p - (a + min(1.0, max(0.0, t)) * (b - a)))


def turns_left(a: complex, b: complex, c: complex) -> float:
    return ((b - a).conjugate() * (c - a)).imag


def cross(s: tuple[complex, complex], t: tuple[complex, complex]) -> bool:
    return turns_left(*s, t[0]) * turns_left(*s, t[1]) < 0 and turns_left(*t, s[0]) * turns_left(*t, s[1]) < 0


def inside(point: complex, box: Box) -> bool:
    return all(turns_left(*edge, point) >= 0 for edge in edges(box))


def polygon_distance(a: Box, b: Box) -> float:
    """Distance of two rectangles by edges and points, in no way like the kernel's."""
    if any(inside(p, b) for p in corners(a)) or any(inside(p, a) for p in corners(b)):
        return 0.0
    if any(cross(s, t) for s in edges(a) for t in edges(b)):
        return 0.0
    near = [point_to_segment(p, *edge) for p in corners(a) for edge in edges(b)]
    return min(near + [point_to_segment(p, *edge) for p in corners(b) for edge in edges(a)])


def at(start: Box, end: Box, part: float) -> Box:
    return Box(*(s + part * (e - s) for s, e in zip(start, end, strict=True)))


def sampled(a: tuple[Box, Box], b: tuple[Box, Box], count: int = 200) -> list[float]:
    return [box_distance(at(*a, k / count), at(*b, k / count)) for k in range(count + 1)]


def fastest(a: tuple[Box, Box], b: tuple[Box, Box]) -> float:
    """The most that the distance can change in the step [m]."""
    return sum(
        math.hypot(end.x - start.x, end.y - start.y)
        + abs(end.heading - start.heading) * math.hypot(start.length, start.width) / 2
        for start, end in (a, b)
    )


@given(boxes(), boxes())
def test_distance_is_that_of_the_polygons(a: Box, b: Box) -> None:
    """Eight corner distances and four axes say what all edges and points say."""
    assert box_distance(a, b) == pytest.approx(polygon_distance(a, b), abs=1e-9)


@given(boxes(), boxes(), PLACES, PLACES, ANGLES)
def test_distance_keeps_under_motion_mirror_and_swap(a: Box, b: Box, x: float, y: float, turn: float) -> None:
    """Where the world's axes lie, which hand it has and who is named first changes no distance."""

    def moved(box: Box) -> Box:
        place = complex(box.x, box.y) * complex(math.cos(turn), math.sin(turn)) + complex(x, y)
        return Box(place.real, place.imag, box.heading + turn, box.length, box.width)

    def mirrored(box: Box) -> Box:
        return box._replace(y=-box.y, heading=-box.heading)

    distance = box_distance(a, b)
    assert box_distance(moved(a), moved(b)) == pytest.approx(distance, abs=1e-9)
    assert box_distance(mirrored(a), mirrored(b)) == pytest.approx(distance, abs=1e-9)
    assert box_distance(b, a) == pytest.approx(distance, abs=1e-12)


def test_corner_to_corner_is_not_cut_short() -> None:
    """Between two corners the distance is that of the corners, which no axis shows in full."""
    assert box_distance(box(0, 0, 0, 2, 2), box(5, 6, 0, 2, 2)) == pytest.approx(5.0)


@given(motions(), motions())
def test_contact_is_found_when_outlines_touch_and_not_before(a: tuple[Box, Box], b: tuple[Box, Box]) -> None:
    """No sample overlaps before the contact found; at it the outlines are within the tolerance."""
    part = first_contact(*a, *b)
    distances = sampled(a, b)
    if part < 0.0:
        assert min(distances) > 0.0
        return
    assert 0.0 < part <= 1.0
    assert box_distance(at(*a, part), at(*b, part)) < TOUCH + 1e-9
    assert all(distance > 0.0 for k, distance in enumerate(distances) if k / 200 < part - 1e-6)


@given(motions(), motions())
def test_contact_search_does_not_mind_who_is_first(a: tuple[Box, Box], b: tuple[Box, Box]) -> None:
    """Both orders agree on contact but for pairs that pass within the tolerance."""
    one, other = first_contact(*a, *b), first_contact(*b, *a)
    if (one < 0.0) == (other < 0.0):
        assert one == pytest.approx(other, abs=1e-2)
    else:
        assert closest_in_step(*a, *b, math.inf)[0] < TOUCH


def test_contact_of_two_that_meet_head_on_is_exact() -> None:
    """A gap of 1 m closed at 4 m a step is closed at a quarter of it."""
    a, b = box(0, 0, 0, 4, 2), box(5, 0.3, math.pi, 4, 2)
    assert first_contact(a, a._replace(x=2.0), b, b._replace(x=3.0)) == pytest.approx(0.25, abs=TOUCH)


def test_a_turn_alone_can_make_contact() -> None:
    """A bar that turns by its centre hits a box beside it."""
    bar, post = box(0, 0, 0, 10, 0.2), box(0, 4, 0, 1, 1)
    part = first_contact(bar, bar._replace(heading=1.5), post, post)
    assert 0.0 < part < 1.0
    assert first_contact(bar, bar._replace(heading=0.5), post, post) == -1.0


def test_a_heading_turns_the_short_way() -> None:
    """From 3.1 to -3.1 rad is a small turn, which does not sweep what lies to the side."""
    bar, post = box(0, 0, 3.1, 10, 0.2), box(0, 4, 0, 1, 1)
    assert first_contact(bar, bar._replace(heading=-3.1), post, post) == -1.0


def test_outlines_that_touch_from_the_start_are_in_contact() -> None:
    """Contact belongs to (0, 1], so it is reported just after the start."""
    a = box(0, 0, 0, 4, 2)
    assert 0.0 < first_contact(a, a, a, a) < 1e-6


def test_sliding_past_within_a_hair_ends() -> None:
    """Sliding along one another a little outside the tolerance, turning or not, is no contact and no endless search."""
    a, b = box(0, 0, 0, 40, 2), box(-30, 2 + 1.5 * TOUCH, 0, 40, 2)
    assert first_contact(a, a, b, b._replace(x=30.0)) == -1.0
    assert first_contact(a, a, b, b._replace(x=30.0, heading=1e-7)) == -1.0


@pytest.mark.parametrize("broken", [math.nan, math.inf])
def test_broken_numbers_end_the_search(broken: float) -> None:
    """NaN and infinity are nobody's contact; the rollout reports them."""
    a, b = box(0, 0, 0, 4, 2), box(3, 1, 1, 4, 2)
    assert first_contact(a, a, b._replace(x=8.0), b._replace(x=broken)) == -1.0


@given(motions(), motions())
def test_closest_approach_is_a_distance_of_the_step_and_the_least(a: tuple[Box, Box], b: tuple[Box, Box]) -> None:
    """It occurs at the returned fraction, and no sample lies lower but for the tolerance."""
    distance, part = closest_in_step(*a, *b, math.inf)
    assert distance == pytest.approx(box_distance(at(*a, part), at(*b, part)), abs=1e-9)
    assert distance <= min(sampled(a, b)) + DISTANCE_TOLERANCE + 1e-9
    assert distance >= min(sampled(a, b)) - fastest(a, b) / 200


@given(motions(), motions(), st.floats(0.0, 20.0))
def test_closest_approach_is_returned_only_if_it_beats_the_best(
    a: tuple[Box, Box], b: tuple[Box, Box], best: float
) -> None:
    """A search that starts from a good value gives the least of that value and the true minimum."""
    least, _ = closest_in_step(*a, *b, math.inf)
    distance, part = closest_in_step(*a, *b, best)
    assert distance == pytest.approx(min(best, least), abs=2 * DISTANCE_TOLERANCE)
    assert (part < 0.0) == (distance == best)


def test_two_that_stand_still_have_their_distance() -> None:
    """Without motion the distance is that of the start."""
    a, b = box(0, 0, 0, 4, 2), box(7, 0, 0, 4, 2)
    assert closest_in_step(a, a, b, b, math.inf) == (3.0, 0.0)


@pytest.fixture(scope="module")
def benchmark() -> ModuleType:
    """`benchmarks/missed_contacts.py`, which is no package."""
    path = Path(__file__).parents[3] / "benchmarks" / "missed_contacts.py"
    spec = importlib.util.spec_from_file_location("missed_contacts", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["missed_contacts"] = module
    spec.loader.exec_module(module)
    return module


def test_no_collision_is_missed_in_crossing_pairs(benchmark: ModuleType) -> None:
    """Against samples every 0.1 ms; the steps alone would miss some. The benchmark runs 10,000 pairs."""
    result = benchmark.missed_contacts(400, seed=3)
    assert result.contacts > 200
    assert (result.missed, result.false) == (0, 0)
    assert result.sampled_at_steps > 0
