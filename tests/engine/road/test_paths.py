"""Laws of paths, over chains of random lines and arcs."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.road import PathBook, Pose, Primitive
from engine.road.paths import STRAIGHT, chord_count
from tests.engine.road.conflict_areas import Strip, conflict_areas
from tests.laws import examples

moderate = st.floats(-100.0, 100.0)
curvatures = st.just(0.0) | st.floats(0.01, 0.3) | st.floats(-0.3, -0.01)


@st.composite
def chains(draw: Callable) -> list[Primitive]:
    """Two to five primitives, each starting where the one before it ends."""
    pose = Pose(draw(moderate), draw(moderate), draw(st.floats(-3.0, 3.0)))
    chain: list[Primitive] = []
    for _ in range(draw(st.integers(2, 5))):
        curvature = draw(curvatures)
        longest = min(30.0, 0.9 * math.pi / abs(curvature)) if curvature else 30.0
        chain.append(Primitive(*pose, curvature, draw(st.floats(0.5, longest))))
        pose = chain[-1].pose(chain[-1].length)
    return chain


@given(st.floats(-0.2, 0.2), st.floats(-0.5, 0.5), st.floats(1.0, 100.0))
def test_lines_are_one_only_where_they_are_one_line(turn: float, aside: float, length: float) -> None:
    """Files have corners and gaps: of a path that turns or jumps, each end stays where it was."""
    first, then = Primitive(0.0, 0.0, 0.0, 0.0, 20.0), Primitive(20.0, aside, turn, 0.0, length)
    book = PathBook(0.5, 0.2)
    path = book.join([book.add([first]), book.add([then])])
    end, wanted = book.pose(path, 20.0 + length), then.pose(length)
    assert math.hypot(end.x - wanted.x, end.y - wanted.y) <= STRAIGHT
    assert book.length(path) == pytest.approx(20.0 + length)


def test_pieces_of_one_line_become_one() -> None:
    pieces = [Primitive(10.0 * i, 1e-5 * i, 1e-6, 0.0, 10.0) for i in range(5)]
    book = PathBook()
    assert [each.length for each in book.primitives(book.add(pieces))] == [50.0]


def book_of(chain: list[Primitive]) -> PathBook:
    book = PathBook()
    book.add(chain)
    return book


@given(chains(), st.floats(0.0, 1.0))
def test_foot_of_a_point_on_the_path_is_that_point(chain: list[Primitive], share: float) -> None:
    """project(pose(s)) leads back to the point, and its distance is 0."""
    book = book_of(chain)
    x, y, _ = book.pose(0, share * book.length(0))
    assert book.distance(0, x, y) == pytest.approx(0.0, abs=1e-9)
    assert book.pose(0, book.project(0, x, y))[:2] == pytest.approx((x, y), abs=1e-7)


@given(chains(), moderate, moderate)
def test_no_point_of_the_path_is_nearer_than_the_foot(chain: list[Primitive], x: float, y: float) -> None:
    """Against a dense sampling; and the foot lies at the distance that is reported."""
    book = book_of(chain)
    distance = book.distance(0, x, y)
    poses = [book.pose(0, s) for s in np.linspace(0.0, book.length(0), 400)]
    assert distance <= min(math.hypot(pose.x - x, pose.y - y) for pose in poses) + 1e-9
    foot = book.pose(0, book.project(0, x, y))
    assert distance == pytest.approx(math.hypot(foot.x - x, foot.y - y), abs=1e-7)


@given(chains(), st.floats(0.0, 1.0))
def test_heading_is_the_direction_of_travel(chain: list[Primitive], share: float) -> None:
    """The central difference of positions points along the heading, at unit speed."""
    book = book_of(chain)
    step = 1e-4
    s = min(max(share * book.length(0), step), book.length(0) - step)
    before, here, after = (book.pose(0, s + d) for d in (-step, 0.0, step))
    assert (after.x - before.x) / (2 * step) == pytest.approx(math.cos(here.heading), abs=1e-4)
    assert (after.y - before.y) / (2 * step) == pytest.approx(math.sin(here.heading), abs=1e-4)


@given(chains(), st.floats(0.002, 0.5))
def test_polyline_stays_within_its_tolerance(chain: list[Primitive], tolerance: float) -> None:
    """The middle of every chord is no farther from the path than was asked."""
    book = book_of(chain)
    points = book.points(0, tolerance)
    middles = 0.5 * (points[:-1] + points[1:])
    assert book.feet(0, middles[:, 0], middles[:, 1]).distance.max() <= tolerance * 1.001


@given(chains(), st.data())
def test_joined_path_is_its_parts_in_a_row(chain: list[Primitive], data: st.DataObject) -> None:
    """Lengths add up, and each arc length leads to the pose of the part it falls in."""
    book = PathBook()
    parts = [book.add([primitive]) for primitive in chain]
    joined = book.join(parts)
    assert book.length(joined) == pytest.approx(sum(map(book.length, parts)))
    index = data.draw(st.integers(0, len(parts) - 1))
    s = data.draw(st.floats(0.0, 1.0)) * book.length(parts[index])
    before = sum(map(book.length, parts[:index]))
    assert book.pose(joined, before + s)[:2] == pytest.approx(book.pose(parts[index], s)[:2], abs=1e-9)


def test_join_is_remembered_and_lines_become_one() -> None:
    """The same parts give the same id; two lines in a row are one primitive; one part is itself."""
    book = PathBook()
    first, second = book.add([Primitive(0, 0, 0.0, 0.0, 5.0)]), book.add([Primitive(5, 0, 0.0, 0.0, 2.0)])
    joined = book.join([first, second])
    assert book.join((first, second)) == joined
    assert book.join([first]) == first
    assert book.primitives(joined) == (Primitive(0, 0, 0.0, 0.0, 7.0),)
    assert (book.parts(joined), book.parts(second)) == ((first, second), (second,))


def test_join_refuses_a_gap() -> None:
    """Neither a jump nor a kink can be driven."""
    book = PathBook()
    first = book.add([Primitive(0, 0, 0.0, 0.0, 5.0)])
    elsewhere, kinked = book.add([Primitive(6, 0, 0.0, 0.0, 5.0)]), book.add([Primitive(5, 0, 0.1, 0.0, 5.0)])
    for other in (elsewhere, kinked):
        assert not book.continues(first, other)
        with pytest.raises(ValueError, match="does not start where"):
            book.join([first, other])


def test_join_of_nothing_is_refused() -> None:
    """An empty trajectory has no path."""
    with pytest.raises(ValueError, match="empty"):
        PathBook().join([])


@examples(20)
@given(st.floats(0.3, 1.5), st.floats(1.0, 4.0), st.floats(1.0, 4.0))
def test_conflict_area_of_oblique_strips(angle: float, first_width: float, second_width: float) -> None:
    """Two lines that cross at an angle: the stretch is symmetric about the crossing and at least the other's width."""
    book = PathBook()
    one = book.add([Primitive(-40.0, 0.0, 0.0, 0.0, 80.0)])
    other = book.add([Primitive(-40.0 * math.cos(angle), -40.0 * math.sin(angle), angle, 0.0, 80.0)])
    ((stretch, opposite),) = conflict_areas(book, Strip(one, first_width), Strip(other, second_width))
    expected = 0.5 * (second_width / math.sin(angle) + first_width / math.tan(angle))
    assert stretch == pytest.approx((40.0 - expected, 40.0 + expected), abs=1e-4)
    assert sum(opposite) == pytest.approx(80.0, abs=1e-4)


@pytest.mark.parametrize("curvature", [5e-324, 1e-300, 1e-15, 1e-9, 1e-3, 0.1, 1.0, 50.0])
def test_chords_of_any_curvature_stay_within_the_tolerance(curvature: float) -> None:
    """The sagitta of a chord is 2 sin(angle / 4) ** 2 / curvature; a nearly straight line is one chord."""
    line = Primitive(0.0, 0.0, 0.0, curvature, min(100.0, math.pi / curvature))
    count = chord_count(line, 0.01)
    angle = curvature * line.length / count
    assert 2.0 * math.sin(0.25 * angle) ** 2 / curvature <= 0.01 * (1.0 + 1e-6)
    assert count == 1 or curvature > 1e-9
