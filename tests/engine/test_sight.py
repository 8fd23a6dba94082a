"""The polygon of what is seen: every place in it is seen, no place beyond it is."""

import math

import numpy as np
import pytest
import shapely

from engine.kernels.geometry import Box, View
from engine.kernels.sight import SEEN, Shades, look
from tests.engine.kernels.sight_reference import drawn, table
from tests.sight_polygon import visible_sector

NO_BUILDINGS = np.zeros((0, 5))


def sees_place(view, shades, x, y):
    boxes = [box for box in shades if not shapely.Point(x, y).within(polygon_of(box).buffer(1e-3))]
    if len(boxes) < len(shades):
        return None  # a place inside of an outline is not hidden by it
    return look(view, Box(x, y, 0.0, 0.0, 0.0), Shades(table(shades), 0, len(shades), -1, -1), NO_BUILDINGS) == SEEN


def polygon_of(box):
    cos, sin = 0.5 * math.cos(box.heading), 0.5 * math.sin(box.heading)
    return shapely.Polygon(
        [
            (box.x + a * box.length * cos - b * box.width * sin, box.y + a * box.length * sin + b * box.width * cos)
            for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1))
        ]
    )


@pytest.mark.parametrize("shades", [0, 1, 3, 8])
def test_holds_the_places_that_are_seen(shades):
    random = np.random.default_rng(shades)
    asked = 0
    for _ in range(40):
        scene = drawn(random, shades)
        view = scene.view._replace(distance=min(scene.view.distance, 60.0))
        corners = visible_sector(view, np.array(scene.shades, dtype=float).reshape(-1, 5))
        area = shapely.Polygon(corners) if len(corners) > 2 else shapely.Polygon()
        assert area.is_valid
        for x, y in random.uniform(-40.0, 40.0, (20, 2)):
            # The arc has corners every two degrees.
            if area.boundary.distance(shapely.Point(x, y)) < 0.02:
                continue
            seen = sees_place(view, scene.shades, x, y)
            if seen is not None:
                asked += 1
                assert area.contains(shapely.Point(x, y)) == seen, (scene, x, y)
    assert asked > 300


def test_area_of_an_open_view():
    """A quarter of a circle, but for the chords of its arc."""
    corners = visible_sector(View(3.0, 4.0, 1.0, math.pi / 2, 10.0), NO_BUILDINGS)
    assert tuple(corners[0]) == (3.0, 4.0)
    assert shapely.Polygon(corners).area == pytest.approx(25.0 * math.pi, rel=3e-4)


def test_shadow_of_a_wall():
    """The wall takes what lies behind it, and the area up to it is left."""
    wall = np.array([[5.0, 0.0, 0.0, 1e-6, 100.0]])
    corners = visible_sector(View(0.0, 0.0, 0.0, math.pi / 2, 50.0), wall)
    assert shapely.Polygon(corners).area == pytest.approx(25.0, rel=1e-6)


def test_from_inside_nothing_is_left():
    assert len(visible_sector(View(0.0, 0.0, 0.0, 1.0, 50.0), np.array([[0.0, 0.0, 0.3, 4.0, 2.0]]))) == 0
