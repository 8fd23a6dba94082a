"""Two other ways to say who sees whom: one ray in each interval between all directions at which anything can change, in
plain Python; and shapely's polygons of shadows. Also scenes to try them on.
"""

import math
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import shapely

from engine.kernels.geometry import Box, View
from engine.kernels.sight import HIDDEN, OUTSIDE, SEEN
from engine.tables import SHADE, Floats

BORDER = 1e-9
"""Where less than this remains, either answer is right [rad]."""

Point = tuple[float, float]


class Scene(NamedTuple):
    view: View
    target: Box
    shades: list[Box]


def corners(box: Box) -> list[Point]:
    """Anticlockwise."""
    cos, sin = math.cos(box.heading), math.sin(box.heading)
    return [
        (
            box.x + 0.5 * (a * box.length * cos - b * box.width * sin),
            box.y + 0.5 * (a * box.length * sin + b * box.width * cos),
        )
        for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1))
    ]


def table(shades: list[Box]) -> Floats:
    """What the kernel reads."""
    return np.array([(*box, 1.0) for box in shades] or [(0.0,) * SHADE], dtype=np.float64).ravel()


# -- by rays -----------------------------------------------------------------------------------------------------------


def depth_inside(box: Box, x: float, y: float) -> float:
    """How deep a point lies in an outline [m]; negative outside."""
    cos, sin = math.cos(box.heading), math.sin(box.heading)
    along, across = cos * (x - box.x) + sin * (y - box.y), cos * (y - box.y) - sin * (x - box.x)
    return min(0.5 * box.length - abs(along), 0.5 * box.width - abs(across))


def overlap_area(first: Box, second: Box) -> float:
    """Of two outlines [m^2]: one clipped by the sides of the other (Sutherland and Hodgman 1974)."""
    kept = corners(first)
    sides = corners(second)
    for (ax, ay), (bx, by) in zip(sides, sides[1:] + sides[:1], strict=True):
        levels = [(bx - ax) * (y - ay) - (by - ay) * (x - ax) for x, y in kept]
        clipped: list[Point] = []
        for k, (point, level) in enumerate(zip(kept, levels, strict=True)):
            before, before_level = kept[k - 1], levels[k - 1]
            if (level > 0.0) != (before_level > 0.0):
                part = before_level / (before_level - level)
                clipped.append((before[0] + part * (point[0] - before[0]), before[1] + part * (point[1] - before[1])))
            if level > 0.0:
                clipped.append(point)
        kept = clipped
        if not kept:
            return 0.0
    return 0.5 * abs(sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(kept, kept[1:] + kept[:1], strict=True)))


def entry(outline: list[Point], x: float, y: float, direction: float) -> float:
    """Distance at which a ray from outside or the border first meets an outline [m]; infinite if it does not."""
    cos, sin = math.cos(direction), math.sin(direction)
    ahead_x, ahead_y = x + 1e-6 * cos, y + 1e-6 * sin
    sides = list(zip(outline, outline[1:] + outline[:1], strict=True))
    if all((bx - ax) * (ahead_y - ay) - (by - ay) * (ahead_x - ax) > 0.0 for (ax, ay), (bx, by) in sides):
        return 0.0
    nearest = math.inf
    for (ax, ay), (bx, by) in sides:
        a, b = cos * (ay - y) - sin * (ax - x), cos * (by - y) - sin * (bx - x)
        if (a > 0.0) != (b > 0.0):
            part = a / (a - b)
            along = cos * (ax + part * (bx - ax) - x) + sin * (ay + part * (by - ay) - y)
            if along > 1e-9:
                nearest = min(nearest, along)
    return nearest


def crossings(outline: list[Point], view: View) -> list[Point]:
    """Where the sides of an outline cross the circle of the view."""
    found: list[Point] = []
    for (ax, ay), (bx, by) in zip(outline, outline[1:] + outline[:1], strict=True):
        way_x, way_y, off_x, off_y = bx - ax, by - ay, ax - view.x, ay - view.y
        square, half = way_x**2 + way_y**2, way_x * off_x + way_y * off_y
        rest = half**2 - square * (off_x**2 + off_y**2 - view.distance**2)
        if square > 0.0 and rest >= 0.0:
            parts = ((-half - math.sqrt(rest)) / square, (-half + math.sqrt(rest)) / square)
            found += [(ax + part * way_x, ay + part * way_y) for part in parts if 0.0 <= part <= 1.0]
    return found


class Widths(NamedTuple):
    """The widest interval of directions [rad] in which the target is in the sector, and in which it is seen, too."""

    in_sector: float
    seen: float


def by_rays(scene: Scene) -> Widths:
    view, target, shades = scene
    if depth_inside(target, view.x, view.y) >= 0.0:
        return Widths(math.tau, math.tau)
    around = any(depth_inside(box, view.x, view.y) > 1e-9 for box in shades)
    outlines = [corners(box) for box in shades if overlap_area(box, target) < 1e-8]
    mine = corners(target)
    points = [*mine, *crossings(mine, view), *(point for outline in outlines for point in outline)]
    directions = [math.atan2(y - view.y, x - view.x) for x, y in points]
    directions += [view.heading - 0.5 * view.angle, view.heading + 0.5 * view.angle]
    turns = sorted(math.remainder(direction, math.tau) for direction in directions)
    turns.append(turns[0] + math.tau)
    in_sector = seen = 0.0
    run_sector = run_seen = 0.0
    for low, high in [*pairwise(turns), *pairwise(turns)]:  # twice around: an interval may span the start
        middle = 0.5 * (low + high)
        at = entry(mine, view.x, view.y, middle)
        open_to = abs(math.remainder(middle - view.heading, math.tau)) < 0.5 * view.angle or view.angle >= math.tau
        looks = open_to and at <= view.distance
        free = looks and not around and all(entry(each, view.x, view.y, middle) >= at for each in outlines)
        if high - low > 1e-15:
            run_sector, run_seen = (run_sector + high - low) * looks, (run_seen + high - low) * free
        in_sector, seen = max(in_sector, run_sector), max(seen, run_seen)
    return Widths(in_sector, seen)


def agrees(verdict: int, scene: Scene) -> bool:
    """Whether a verdict is that of the rays, or theirs hangs on less than `BORDER`."""
    widths = by_rays(scene)
    if widths.seen > BORDER:
        return verdict == SEEN
    if widths.in_sector > BORDER:
        return verdict == HIDDEN or (verdict == SEEN and widths.seen > 0.0)
    if verdict == OUTSIDE:
        return True
    view = scene.view
    wider = view._replace(angle=view.angle + 2.0 * BORDER, distance=view.distance + BORDER)
    return by_rays(scene._replace(view=wider)).in_sector > 0.0


# -- by polygons -------------------------------------------------------------------------------------------------------

FAR = 1e4


def shadow(view: View, box: Box) -> Any:
    """An outline, and all that is behind it."""
    near = corners(box)
    far = [(view.x + FAR * (x - view.x), view.y + FAR * (y - view.y)) for x, y in near]
    return shapely.MultiPoint(near + far).convex_hull


def seen_area(scene: Scene) -> float:
    """What polygons of shadows leave of a target [m^2], for views that reach far beyond everything."""
    view, target, shades = scene
    if depth_inside(target, view.x, view.y) >= 0.0:
        return math.inf
    if any(depth_inside(box, view.x, view.y) > 0.0 for box in shades):
        return 0.0
    left = shapely.Polygon(corners(target))
    if view.angle < math.tau:
        count = max(2, math.ceil(view.angle / 1.0) + 1)
        turns = np.linspace(view.heading - 0.5 * view.angle, view.heading + 0.5 * view.angle, count)
        rim = [(view.x + FAR * math.cos(turn), view.y + FAR * math.sin(turn)) for turn in turns]
        left = left.intersection(shapely.Polygon([(view.x, view.y), *rim]))
    for box in shades:
        if shapely.Polygon(corners(box)).intersection(shapely.Polygon(corners(target))).area < 1e-8:
            left = left.difference(shadow(view, box))
    return left.area


# -- scenes ------------------------------------------------------------------------------------------------------------

SIZES = ((4.5, 1.6), (9.1, 2.4), (12.2, 2.6), (0.5, 0.6), (1.8, 0.6), (30.0, 12.0), (15.0, 0.2))


def drawn(random: np.random.Generator, shades: int, grid: bool = False) -> Scene:
    """A scene of boxes at random, on a grid of metres and right angles or not."""

    def number(low: float, high: float) -> float:
        value = random.uniform(low, high)
        return float(round(value) if grid else value)

    def box() -> Box:
        length, width = SIZES[random.integers(len(SIZES))]
        if grid:
            length, width = float(random.integers(1, 7)), float(random.integers(1, 7))
        heading = 0.5 * math.pi * random.integers(4) if grid else random.uniform(-4.0, 4.0)
        return Box(number(-30.0, 30.0) / (3.0 if grid else 1.0), number(-30.0, 30.0), heading, length, width)

    angle = (math.pi / 2, math.pi, math.tau, 0.02, random.uniform(0.0, math.tau), 1.5 * math.pi)[random.integers(6)]
    distance = (50.0, number(0.0, 45.0), 1e3)[random.integers(3)]
    heading = 0.25 * math.pi * random.integers(8) if grid else random.uniform(-4.0, 4.0)
    view = View(number(-15.0, 15.0), number(-15.0, 15.0), float(heading), float(angle), distance)
    return Scene(view, box(), [box() for _ in range(shades)])
