"""Strips: the area a lane covers, from its centre line and width."""

import numpy as np

from engine.road import polygon
from engine.road.paths import PathBook
from engine.road.regions import Shape, shape_of_parts, with_cores
from engine.tables import Floats


def strip(paths: PathBook, path: int, width: float, tolerance: float) -> Shape:
    """The region within half a width to either side of a path, ends cut square; tiled along the path."""
    left, right = borders(paths, path, width, tolerance)
    ring = polygon.anticlockwise(_without_repeats(np.vstack([right, left[::-1]])))
    shape = shape_of_parts(polygon.edges(ring), _tiles(left, right))
    is_rectangle = len(ring) == 4 and np.any(np.abs(left[1] - left[0]) < 1e-9)
    return with_cores(shape, [[*ring.min(axis=0), *ring.max(axis=0)]]) if is_rectangle else shape


def borders(paths: PathBook, path: int, width: float, tolerance: float) -> tuple[Floats, Floats]:
    """(n, 2) left and right border of a path's strip."""
    poses = np.array([paths.pose(path, s) for s in paths.stations(path, tolerance)])
    normal = np.column_stack([-np.sin(poses[:, 2]), np.cos(poses[:, 2])])
    return poses[:, :2] + 0.5 * width * normal, poses[:, :2] - 0.5 * width * normal


def _tiles(left: Floats, right: Floats) -> Floats:
    """Two triangles for each stretch between two stations."""
    lower = np.hstack([right[:-1], right[1:], left[1:]])
    upper = np.hstack([right[:-1], left[1:], left[:-1]])
    return np.vstack([lower, upper])


def _without_repeats(ring: Floats) -> Floats:
    # The inner border of a turn about its own centre is a single point.
    return ring[np.hypot(*(ring - np.roll(ring, 1, axis=0)).T) > 1e-9]
