"""Who sees whom: against rays in all intervals of directions, against polygons of shadows, and by hand."""

import math

import numpy as np
import pytest

from engine.kernels.geometry import Box, View
from engine.kernels.sight import HIDDEN, OUTSIDE, SEEN, Shades, look, may_be_hidden
from tests.engine.kernels.sight_reference import BORDER, Scene, agrees, by_rays, drawn, seen_area, table

ALL_AROUND = View(0.0, 0.0, 0.0, math.tau, 50.0)
AHEAD = View(0.0, 0.0, 0.0, math.pi / 2, 50.0)
WALKER = Box(20.0, 0.0, 0.0, 0.5, 0.6)
TRUCK = Box(10.0, 0.0, 0.0, 9.0, 2.5)


def looked(view: View, target: Box, *shades: Box, viewer: int = -1, looked_at: int = -1) -> int:
    """Some of what hides is in the table of actors, some are buildings."""
    listed = max(viewer, looked_at) + 1 or len(shades) // 2
    buildings = np.array(shades[listed:], dtype=np.float64).reshape(-1, 5)
    return look(view, target, Shades(table([*shades[:listed]]), 0, listed, viewer, looked_at), buildings)


@pytest.mark.parametrize("grid", [False, True])
@pytest.mark.parametrize("shades", [0, 1, 2, 5, 20])
def test_agrees_with_rays(shades, grid):
    """Verdicts are those of one ray in each interval of directions, but where less than 1e-9 rad remains."""
    random = np.random.default_rng(shades + 100 * grid)
    for _ in range(300 if shades < 20 else 40):
        scene = drawn(random, shades, grid)
        assert agrees(looked(scene.view, scene.target, *scene.shades), scene), scene


def test_agrees_with_shapely():
    """Seen is what polygons of shadows leave a part of."""
    random = np.random.default_rng(7)
    verdicts = {SEEN: 0, HIDDEN: 0, OUTSIDE: 0}
    for _ in range(400):
        scene = drawn(random, int(random.integers(0, 12)))
        scene = scene._replace(view=scene.view._replace(distance=1e3))
        verdict = looked(scene.view, scene.target, *scene.shades)
        if not 0.0 < by_rays(scene).seen < 1e-6:
            assert (seen_area(scene) > 1e-9) == (verdict == SEEN), scene
        verdicts[verdict] += 1
    assert min(verdicts.values()) > 15


@pytest.mark.parametrize("turn", [0.0, 1.0, -2.5])
def test_moves_with_the_scene(turn):
    """A scene that is turned, shifted or mirrored has the same verdict."""
    random = np.random.default_rng(11)
    cos, sin = math.cos(turn), math.sin(turn)

    def moved(box):
        return box._replace(
            x=3.0 + cos * box.x - sin * box.y, y=-7.0 + sin * box.x + cos * box.y, heading=box.heading + turn
        )

    def mirrored(box):
        return box._replace(y=-box.y, heading=-box.heading)

    for _ in range(200):
        scene = drawn(random, 4)
        if by_rays(scene).seen < BORDER < by_rays(scene).in_sector:
            continue
        verdict = looked(scene.view, scene.target, *scene.shades)
        for image in (moved, mirrored):
            assert looked(image(scene.view), image(scene.target), *map(image, scene.shades)) == verdict, scene


def test_more_that_hides_never_shows_more():
    random = np.random.default_rng(12)
    for _ in range(200):
        scene = drawn(random, 6)
        verdicts = [looked(scene.view, scene.target, *scene.shades[:count]) for count in range(7)]
        assert verdicts == sorted(verdicts, reverse=True)


def test_behind_a_truck():
    assert looked(ALL_AROUND, WALKER, TRUCK) == HIDDEN
    assert looked(ALL_AROUND, TRUCK, WALKER) == SEEN
    assert looked(ALL_AROUND, WALKER._replace(y=6.0), TRUCK) == SEEN
    assert looked(ALL_AROUND, WALKER._replace(x=-20.0), TRUCK) == SEEN
    assert looked(AHEAD, WALKER._replace(x=-20.0), TRUCK) == OUTSIDE


def test_two_that_hide_together():
    """Neither covers the wall behind; both do, unless there is a slit between."""
    wall = Box(20.0, 0.0, 0.0, 0.5, 8.0)
    left, right = Box(10.0, 2.5, 0.0, 1.0, 5.0), Box(10.0, -2.5, 0.0, 1.0, 5.0)
    assert looked(ALL_AROUND, wall, left) == looked(ALL_AROUND, wall, right) == SEEN
    assert looked(ALL_AROUND, wall, left, right) == looked(ALL_AROUND, wall, right, left) == HIDDEN
    assert looked(ALL_AROUND, wall, left, right._replace(y=-2.5 - 1e-6)) == SEEN


def test_the_middle_of_a_side():
    """Seen though neither a corner nor the centre lies in the sector."""
    narrow = AHEAD._replace(angle=0.1)
    assert looked(narrow, Box(10.0, 3.0, math.pi / 2, 9.0, 2.0)) == SEEN
    assert looked(narrow, Box(10.0, 6.0, math.pi / 2, 9.0, 2.0)) == OUTSIDE


def test_what_the_radius_leaves():
    """Of a long wall along the line of sight only the near end lies in the radius, and a box hides that."""
    wall = Box(30.0, 4.0, 0.0, 50.0, 1.0)
    near = ALL_AROUND._replace(distance=10.0)
    post = Box(3.0, 1.8, 0.0, 1.0, 1.6)
    assert looked(near, wall) == SEEN
    assert looked(near, wall, post) == HIDDEN
    assert looked(ALL_AROUND, wall, post) == SEEN


@pytest.mark.parametrize("angle", [0.0, 1e-9, math.pi / 2, math.pi, math.tau, 7.0])
def test_no_radius(angle):
    """At radius 0 only what surrounds the viewer is seen."""
    blind = View(0.0, 0.0, 0.3, angle, 0.0)
    assert looked(blind, Box(0.5, 0.0, 0.0, 4.0, 2.0)) == SEEN
    assert looked(blind, Box(5.0, 0.0, 0.0, 4.0, 2.0)) == OUTSIDE


def test_a_single_direction():
    line = AHEAD._replace(angle=0.0)
    assert looked(line, WALKER) == SEEN
    assert looked(line, WALKER._replace(x=-20.0)) == OUTSIDE
    assert looked(line, WALKER, TRUCK) == HIDDEN


def test_edges_of_the_sector_count():
    place = Box(10.0, 10.0, 0.0, 0.0, 0.0)
    assert looked(AHEAD, place) == SEEN
    assert looked(AHEAD._replace(distance=math.hypot(10.0, 10.0)), place) == SEEN
    assert looked(AHEAD, place._replace(y=10.0001)) == OUTSIDE


def test_inside_of_what_hides():
    """Nothing else is seen, unless it surrounds the viewer, too."""
    around = Box(0.5, 0.0, 0.0, 4.0, 3.0)
    assert looked(ALL_AROUND, around) == SEEN
    assert looked(ALL_AROUND, WALKER, around) == HIDDEN
    assert looked(ALL_AROUND, Box(2.0, 0.0, 0.0, 2.0, 2.0), around) == HIDDEN
    assert looked(ALL_AROUND, Box(0.0, 0.0, 1.0, 2.0, 2.0), around) == SEEN
    assert looked(AHEAD, Box(0.0, 0.0, 1.0, 2.0, 2.0), around) == SEEN


def test_viewer_and_target_do_not_hide():
    mine, theirs = Box(0.0, 0.0, 0.0, 4.5, 1.8), Box(20.0, 0.0, 0.0, 4.5, 1.8)
    assert looked(ALL_AROUND, theirs, mine, theirs) == HIDDEN
    assert looked(ALL_AROUND, theirs, mine, theirs, viewer=0, looked_at=1) == SEEN
    assert looked(ALL_AROUND, theirs, mine, theirs, TRUCK, viewer=0, looked_at=1) == HIDDEN


def test_overlapping_outlines():
    """Two that overlap do not hide each other; they hide what is behind both."""
    assert looked(ALL_AROUND, WALKER._replace(x=14.4), TRUCK) == SEEN
    assert looked(ALL_AROUND, WALKER._replace(x=14.75), TRUCK) == HIDDEN  # touches
    other = TRUCK._replace(y=2.0)
    assert looked(ALL_AROUND, WALKER._replace(y=3.0), TRUCK, other) == HIDDEN


@pytest.mark.parametrize("y", [0.0, 1.25, -1.25])
def test_on_the_border_of_what_hides(y):
    """From a side, all that lies beyond it is hidden; from a corner, a quarter."""
    touching = Box(4.5, y, 0.0, 9.0, 2.5)
    assert looked(ALL_AROUND, WALKER._replace(y=1.6 * y), touching) == HIDDEN
    assert looked(ALL_AROUND, WALKER._replace(x=-20.0), touching) == SEEN
    assert looked(ALL_AROUND, WALKER._replace(x=0.0, y=-20.0 if y >= 0.0 else 20.0), touching) == SEEN


def test_on_a_corner_by_rounding():
    """A corner that rounding puts a bit beyond one side of it hides a quarter, and no more."""
    view = View(-8.0, -6.0, 0.0, math.tau, 50.0)
    corner, beside = Box(-5.0, -3.0, math.pi, 6.0, 6.0), Box(-26.0 / 3.0, -1.0, math.pi / 2, 6.0, 1.0)
    assert looked(view, beside, corner) == SEEN
    assert looked(view, Box(5.0, 0.0, 0.0, 1.0, 1.0), corner) == HIDDEN


def test_a_place():
    """A place is a target without size; one inside of an outline is not hidden by it."""
    place = Box(20.0, 0.0, 0.0, 0.0, 0.0)
    assert looked(ALL_AROUND, place) == SEEN
    assert looked(ALL_AROUND, place, TRUCK) == HIDDEN
    assert looked(ALL_AROUND, place._replace(x=10.0), TRUCK) == SEEN
    assert looked(ALL_AROUND, place._replace(x=0.0)) == SEEN


def test_a_hundred_that_hide():
    """A fence of a hundred pales leaves no gap, until one is taken out."""
    fence = [Box(10.0, -10.0 + 0.2 * k, 0.0, 0.1, 0.2) for k in range(101)]
    wall = Box(20.0, 0.0, 0.0, 0.5, 12.0)
    assert looked(ALL_AROUND, wall, *fence) == looked(ALL_AROUND, wall, *fence[::-1]) == HIDDEN
    assert looked(ALL_AROUND, wall, *fence[:50], *fence[51:]) == SEEN


@pytest.mark.parametrize("field", ["x", "y", "length", "heading"])
def test_what_is_nowhere_is_not_seen(field):
    assert looked(ALL_AROUND, WALKER._replace(**{field: math.nan})) == OUTSIDE


def test_scenes_have_every_verdict():
    random = np.random.default_rng(1)
    counts = [0, 0, 0]
    for _ in range(300):
        scene: Scene = drawn(random, 5)
        counts[looked(scene.view, scene.target, *scene.shades)] += 1
    assert min(counts) > 20


def test_the_cheap_test_never_denies_that_something_hides():
    """What is hidden may be hidden, and for many that are seen the cheap test is enough."""
    random, spared = np.random.default_rng(13), 0
    for _ in range(600):
        scene = drawn(random, int(random.integers(0, 6)))
        shades = Shades(table(scene.shades), 0, len(scene.shades), -1, -1)
        verdict = look(scene.view, scene.target, shades, np.zeros((0, 5)))
        may_be = may_be_hidden(scene.view, scene.target, shades, np.zeros((0, 5)))
        assert may_be or verdict != HIDDEN, scene
        spared += verdict == SEEN and not may_be
    assert spared > 30
