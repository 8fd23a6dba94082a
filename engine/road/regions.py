"""Regions: areas bounded by straight edges. Inside is decided by the even-odd rule over all edges of a region."""

from collections.abc import Sequence
from dataclasses import field, replace

import numpy as np

from engine.frozen import frozen
from engine.road import polygon
from engine.tables import Floats


@frozen
class Shape:
    """One region in every form that is needed to answer questions about it."""

    edges: Floats
    """(n, 4): x1, y1, x2, y2; the whole boundary, in any order."""
    hull: Floats
    """(m, 8): x1, y1, x2, y2 of the convex hull's edges, the region on their left; 1.0 where it is a boundary edge too
    (these first), else 0.0; unit direction x, y; length."""
    triangles: Floats
    """(k, 6): tiles of the region."""
    cores: Floats = field(default_factory=lambda: np.zeros((0, 4)))
    """(j, 4): least x, least y, greatest x, greatest y of rectangles that lie in the region: a quick yes."""

    def moved(self, dx: float, dy: float) -> "Shape":
        hull = self.hull.copy()
        hull[:, :4] += (dx, dy, dx, dy)
        return Shape(self.edges + (dx, dy) * 2, hull, self.triangles + (dx, dy) * 3, self.cores + (dx, dy) * 2)


def shape_of(ring: Floats) -> Shape:
    """The shape of one simple polygon."""
    ring = polygon.anticlockwise(np.asarray(ring, dtype=np.float64))
    return shape_of_parts(polygon.edges(ring), polygon.triangulate(ring))


def shape_of_parts(edges: Floats, triangles: Floats) -> Shape:
    """A shape from its boundary and a tiling of it, for regions of several polygons."""
    return Shape(edges, _hull_rows(edges), triangles)


def with_cores(shape: Shape, cores: Sequence[Sequence[float]]) -> Shape:
    """The same shape with rectangles (least x, least y, greatest x, greatest y) known to lie in it."""
    return replace(shape, cores=np.array(cores, dtype=np.float64).reshape(-1, 4))


class RegionBook:
    """All regions of a network, by id. Region 0 is the whole drivable road."""

    def __init__(self) -> None:
        self._shapes: list[Shape] = []

    def __len__(self) -> int:
        return len(self._shapes)

    def add(self, shape: Shape | Sequence[Sequence[float]] | Floats) -> int:
        """A new region from a shape or from the ring of a simple polygon."""
        self._shapes.append(shape if isinstance(shape, Shape) else shape_of(np.array(shape)))
        return len(self._shapes) - 1

    def shape(self, region: int) -> Shape:
        return self._shapes[region]

    def area(self, region: int) -> float:
        """[m^2]"""
        return float(triangle_areas(self._shapes[region].triangles).sum())

    def contains(self, region: int, x: float, y: float) -> bool:
        """Whether the point lies inside: a ray in +x crosses the boundary an odd number of times."""
        x1, y1, x2, y2 = self._shapes[region].edges.T
        spans = (y1 > y) != (y2 > y)
        crossing = x1[spans] + (y - y1[spans]) * (x2[spans] - x1[spans]) / (y2[spans] - y1[spans])
        return bool(np.count_nonzero(crossing > x) % 2)

    def distance(self, region: int, x: float, y: float) -> float:
        """Distance from the point to the region, 0 inside; over the whole boundary, without any shortcut."""
        if self.contains(region, x, y):
            return 0.0
        x1, y1, x2, y2 = self._shapes[region].edges.T
        dx, dy = x2 - x1, y2 - y1
        along = np.clip(((x - x1) * dx + (y - y1) * dy) / (dx * dx + dy * dy), 0.0, 1.0)
        return float(np.hypot(x1 + along * dx - x, y1 + along * dy - y).min())


def triangle_areas(triangles: Floats) -> Floats:
    x1, y1, x2, y2, x3, y3 = triangles.T
    return 0.5 * np.abs((x2 - x1) * (y3 - y1) - (y2 - y1) * (x3 - x1))


def _hull_rows(edges: Floats) -> Floats:
    hull = polygon.edges(polygon.convex_hull(edges[:, :2]))
    both_ways = {tuple(edge) for edge in np.vstack([edges, np.roll(edges, 2, axis=1)]).tolist()}
    shared = np.array([[float(tuple(edge) in both_ways)] for edge in hull.tolist()])
    direction = hull[:, 2:] - hull[:, :2]
    length = np.hypot(direction[:, 0], direction[:, 1])[:, None]
    rows = np.hstack([hull, shared, direction / length, length])
    return rows[np.argsort(-shared[:, 0], kind="stable")]
