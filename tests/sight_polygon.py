"""What an actor sees, as a polygon to draw: the sector of its view up to the first outline or building in every
direction. `engine.kernels.sight` says whether an outline is seen; a test holds the two together.
"""

import math

import numpy as np

from engine.kernels.geometry import View
from engine.program import Program
from engine.scenes import actor_columns
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import Column, State

ARC = math.radians(2.0)
"""Between the points of the far border where nothing is in the way [rad]."""
APART = 1e-7
"""What touches the eye is kept apart by so much [m]."""
SAME = 1e-12
"""Directions nearer than this are one [rad]."""


def visible_area(program: Program, values: Floats, states: Floats, actor: int) -> Floats:
    """What an actor sees at one sample: (m, 2) corners, anticlockwise; none for an actor that is absent.

    `values` is the scene's row of `Scenes.values`; `states` (actors, len(State)) the sample.
    """
    columns = actor_columns(program, values)
    if states[actor, State.PRESENT] == 0.0:
        return np.zeros((0, 2))
    hides = (states[:, State.PRESENT] != 0.0) & (columns[:, Column.OCCLUDING] != 0.0)
    hides[actor] = False
    poses = states[:, [State.X, State.Y, State.HEADING]]
    outlines = np.hstack([poses, columns[:, [Column.LENGTH, Column.WIDTH]]])[hides]
    x, y, heading = poses[actor].tolist()
    angle, distance = columns[actor, [Column.VIEW_ANGLE, Column.VIEW_DISTANCE]].tolist()
    return visible_sector(View(x, y, heading, angle, distance), np.vstack([outlines, program.road.buildings]))


def visible_sector(view: View, outlines: Floats) -> Floats:
    """The part of a sector that no outline (n, 5) hides: (m, 2) corners, anticlockwise, the apex first unless the view
    is all around. From inside of an outline nothing is left, and there are no corners.
    """
    apex = np.array([view.x, view.y])
    if np.any(_beyond_sides(outlines, apex).max(axis=0, initial=-np.inf) < -1e-9):
        return np.zeros((0, 2))
    starts, ends = _sides(_off(outlines, apex))
    starts, ends = starts - apex, ends - apex
    turns = _turns(view, starts, ends)
    first, second = turns[:-1], turns[1:]
    side, near = _nearest(0.5 * (first + second), starts, ends)
    free = near >= view.distance
    points = np.stack([_met(first, side, free, view.distance, starts, ends),
                       _met(second, side, free, view.distance, starts, ends)], axis=1).reshape(-1, 2)  # fmt: skip
    kept = np.ones(len(points), dtype=bool)
    kept[1:] = np.hypot(*np.diff(points, axis=0).T) > 1e-9
    border = points[kept] + apex
    return border if view.angle >= math.tau else np.vstack([apex, border])


def _sides(outlines: Floats) -> tuple[Floats, Floats]:
    """(4 n, 2) beginnings and ends of all sides."""
    x, y, heading, length, width = outlines.T
    along = 0.5 * length * np.array([np.cos(heading), np.sin(heading)])
    across = 0.5 * width * np.array([-np.sin(heading), np.cos(heading)])
    corners = np.stack([along + across, across - along, -along - across, along - across], axis=1)
    corners = (corners + np.array([x, y])[:, np.newaxis]).transpose(2, 1, 0)
    return corners.reshape(-1, 2), np.roll(corners, -1, axis=1).reshape(-1, 2)


def _in_outlines(outlines: Floats, point: Floats) -> Floats:
    """(2, n): how far a point is ahead of each outline's centre, and to its left."""
    off = point - outlines[:, :2]
    cos, sin = np.cos(outlines[:, 2]), np.sin(outlines[:, 2])
    return np.array([off[:, 0] * cos + off[:, 1] * sin, off[:, 1] * cos - off[:, 0] * sin])


def _beyond_sides(outlines: Floats, point: Floats) -> Floats:
    """(2, n): how far a point is beyond the ends of each outline, and beyond its sides; negative within."""
    return np.abs(_in_outlines(outlines, point)) - 0.5 * outlines[:, 3:].T


def _off(outlines: Floats, point: Floats) -> Floats:
    """The same, but those that touch a point are moved off it a little: they hide the half of the world behind them."""
    beyond, signs = _beyond_sides(outlines, point), -np.sign(_in_outlines(outlines, point))
    lengthways = beyond[0] > beyond[1]
    way = APART * np.where(np.array([lengthways, ~lengthways]), signs, 0.0) * (beyond.max(axis=0) <= APART)
    cos, sin = np.cos(outlines[:, 2]), np.sin(outlines[:, 2])
    moved = outlines.copy()
    moved[:, :2] += np.array([way[0] * cos - way[1] * sin, way[0] * sin + way[1] * cos]).T
    return moved


def _turns(view: View, starts: Floats, ends: Floats) -> Floats:
    """All directions at which what is nearest may change, from the right edge of the sector to the left [rad]."""
    right, width = view.heading - 0.5 * min(view.angle, math.tau), min(view.angle, math.tau)
    points = np.vstack([starts, _on_circle(starts, ends, view.distance), _crossings(starts, ends)])
    turns = np.mod(np.arctan2(points[:, 1], points[:, 0]) - right, math.tau)
    arc = np.linspace(0.0, width, max(2, math.ceil(width / ARC) + 1))
    turns = np.sort(np.concatenate([arc, turns[turns < width]]))
    return right + turns[np.concatenate([[True], np.diff(turns) > SAME])]


def _on_circle(starts: Floats, ends: Floats, radius: float) -> Floats:
    """Where sides cross a circle about the origin."""
    way = ends - starts
    square, half = (way**2).sum(axis=1), (way * starts).sum(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        root = np.sqrt(half**2 - square * ((starts**2).sum(axis=1) - radius**2))
        parts = np.stack([(-half - root) / square, (-half + root) / square])
    valid = (parts >= 0.0) & (parts <= 1.0)
    return np.vstack([starts[each] + parts[k, each, np.newaxis] * way[each] for k, each in enumerate(valid)])


def _crossings(starts: Floats, ends: Floats) -> Floats:
    """Where sides cross one another."""
    way = ends - starts
    between = starts[np.newaxis] - starts[:, np.newaxis]
    with np.errstate(invalid="ignore", divide="ignore"):
        turn = _cross(way[:, np.newaxis], way[np.newaxis])
        mine, theirs = _cross(between, way[np.newaxis]) / turn, _cross(between, way[:, np.newaxis]) / turn
        met = (mine > 0.0) & (mine < 1.0) & (theirs > 0.0) & (theirs < 1.0)
    one, _ = np.nonzero(met)
    return starts[one] + mine[met][:, np.newaxis] * way[one]


def _cross(a: Floats, b: Floats) -> Floats:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _nearest(turns: Floats, starts: Floats, ends: Floats) -> tuple[Ints, Floats]:
    """For each direction the side that a ray meets first, and how far off; infinity where it meets none."""
    if len(starts) == 0:
        return np.zeros(len(turns), dtype=np.intp), np.full(len(turns), np.inf)
    ray = np.stack([np.cos(turns), np.sin(turns)], axis=1)[:, np.newaxis]
    one, other = _cross(ray, starts[np.newaxis]), _cross(ray, ends[np.newaxis])
    with np.errstate(invalid="ignore", divide="ignore"):
        along = _cross(starts, ends)[np.newaxis] / _cross(ray, (ends - starts)[np.newaxis])
    along = np.where(((one > 0.0) != (other > 0.0)) & (along > 1e-9), along, np.inf)
    side = along.argmin(axis=1)
    return side, along[np.arange(len(turns)), side]


def _met(turns: Floats, side: Ints, free: Bools, radius: float, starts: Floats, ends: Floats) -> Floats:
    """Points at which rays end: on the line of a side, or on the circle where they are free."""
    ray = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    reach = np.full(len(turns), radius)
    if not free.all():
        start, end = starts[side[~free]], ends[side[~free]]
        reach[~free] = _cross(start, end) / _cross(ray[~free], end - start)
    return reach[:, np.newaxis] * ray
