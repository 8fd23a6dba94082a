"""Regions: areas bounded by straight edges, the polygons that they are made of, and the strips that lanes cover.

Polygons are simple: (n, 2) rings of vertices, anticlockwise, without a repeated last vertex. Metres. Inside a region is
decided by the even-odd rule over all its edges. A strip is made from the lane's centre line and width.
"""

from collections.abc import Sequence
from dataclasses import field, replace
from functools import lru_cache

import numpy as np

from engine.frozen import frozen
from engine.road.paths import PathBook, Primitive
from engine.tables import Floats

# -- polygons ----------------------------------------------------------------------------------------------------------


def area(ring: Floats) -> float:
    """Return the signed area, positive if the ring is anticlockwise [m^2]."""
    x, y = (ring - ring[0]).T
    return 0.5 * float((x * np.roll(y, -1)).sum() - (y * np.roll(x, -1)).sum())


def anticlockwise(ring: Floats) -> Floats:
    return ring if area(ring) > 0.0 else ring[::-1]


def ring_edges(ring: Floats) -> Floats:
    """Return (n, 4) x1, y1, x2, y2 of each edge."""
    return np.hstack([ring, np.roll(ring, -1, axis=0)])


def convex_hull(points: Floats) -> Floats:
    """Return the corners of the hull, anticlockwise (monotone chain), without points on its edges."""
    ordered = sorted({(float(x), float(y)) for x, y in points})
    lower, upper = _chain(ordered), _chain(ordered[::-1])
    return np.array(lower[:-1] + upper[:-1])


def _chain(ordered: list[tuple[float, float]]) -> list[tuple[float, float]]:
    chain: list[tuple[float, float]] = []
    for point in ordered:
        while len(chain) >= 2 and _turn(chain[-2], chain[-1], point) <= 0.0:
            chain.pop()
        chain.append(point)
    return chain


def _turn(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    """Return twice the signed area of a triangle: positive if the way a, b, c turns left."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def triangulate(ring: Floats) -> Floats:
    """Return (n - 2, 6) triangles x1, y1, x2, y2, x3, y3 that tile a simple anticlockwise ring, by ear clipping."""
    left = [(float(x), float(y)) for x, y in ring]
    triangles: list[tuple[float, ...]] = []
    while len(left) > 3:
        index = _best_ear(left)
        triangles.append((*left[index - 1], *left[index], *left[(index + 1) % len(left)]))
        del left[index]
    triangles.append((*left[0], *left[1], *left[2]))
    return np.array(triangles)


def _best_ear(ring: list[tuple[float, float]]) -> int:
    """Return the first convex vertex whose triangle contains no other vertex; else, after rounding, the flattest."""
    for index in range(len(ring)):
        a, b, c = ring[index - 1], ring[index], ring[(index + 1) % len(ring)]
        if _turn(a, b, c) > 0.0 and not any(_inside(a, b, c, point) for point in ring if point not in (a, b, c)):
            return index
    return min(range(len(ring)), key=lambda i: abs(_turn(ring[i - 1], ring[i], ring[(i + 1) % len(ring)])))


def _inside(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float], point: tuple[float, float]) -> bool:
    """Return True if a point is in the anticlockwise triangle or on its boundary."""
    return _turn(a, b, point) >= 0.0 and _turn(b, c, point) >= 0.0 and _turn(c, a, point) >= 0.0


# -- regions -----------------------------------------------------------------------------------------------------------


@frozen
class Shape:
    """One region in all forms that queries need."""

    edges: Floats
    """(n, 4): x1, y1, x2, y2; the whole boundary, in any order."""
    hull: Floats
    """(m, 8): x1, y1, x2, y2 of the convex hull's edges, with the region on their left; 1.0 if it is a boundary edge,
    too (these first), else 0.0; unit direction x, y; length.
    """
    triangles: Floats
    """(k, 6): tiles of the region."""
    cores: Floats = field(default_factory=lambda: np.zeros((0, 4)))
    """(j, 4): least x, least y, greatest x, greatest y of rectangles inside the region, for a quick positive test."""

    def moved(self, dx: float, dy: float) -> "Shape":
        hull = self.hull.copy()
        hull[:, :4] += (dx, dy, dx, dy)
        return Shape(self.edges + (dx, dy) * 2, hull, self.triangles + (dx, dy) * 3, self.cores + (dx, dy) * 2)


def shape_of(ring: Floats) -> Shape:
    """Return the shape of one simple polygon."""
    ring = anticlockwise(np.asarray(ring, dtype=np.float64))
    return shape_of_parts(ring_edges(ring), triangulate(ring))


def shape_of_parts(edges: Floats, triangles: Floats) -> Shape:
    """Return a shape from its boundary and a tiling of it, for regions of several polygons."""
    return Shape(edges, _hull_rows(edges), triangles)


def with_cores(shape: Shape, cores: Sequence[Sequence[float]]) -> Shape:
    """Return the shape with rectangles (least x, least y, greatest x, greatest y) that are inside it."""
    return replace(shape, cores=np.array(cores, dtype=np.float64).reshape(-1, 4))


class RegionBook:
    """All regions of a network, by id. Region 0 is the whole drivable road."""

    def __init__(self) -> None:
        self._shapes: list[Shape] = []

    def __len__(self) -> int:
        return len(self._shapes)

    def add(self, shape: Shape | Sequence[Sequence[float]] | Floats) -> int:
        """Add a region from a shape or from the ring of a simple polygon, and return its id."""
        self._shapes.append(shape if isinstance(shape, Shape) else shape_of(np.array(shape)))
        return len(self._shapes) - 1

    def shape(self, region: int) -> Shape:
        return self._shapes[region]

    def area(self, region: int) -> float:
        """Return the area [m^2]."""
        return shape_area(self._shapes[region])

    def contains(self, region: int, x: float, y: float) -> bool:
        """Return True if the point is inside."""
        return contains(self._shapes[region], x, y)

    def distance(self, region: int, x: float, y: float) -> float:
        """Return the distance from the point to the region, 0 inside [m]; from the whole boundary."""
        return distance(self._shapes[region], x, y)


def contains(shape: Shape, x: float, y: float) -> bool:
    """Return True if the point is inside: a ray in +x crosses the boundary an odd number of times."""
    x1, y1, x2, y2 = shape.edges.T
    spans = (y1 > y) != (y2 > y)
    crossing = x1[spans] + (y - y1[spans]) * (x2[spans] - x1[spans]) / (y2[spans] - y1[spans])
    return bool(np.count_nonzero(crossing > x) % 2)


def distance(shape: Shape, x: float, y: float) -> float:
    """Return the distance from the point to a region, 0 inside [m]; from the whole boundary."""
    if contains(shape, x, y):
        return 0.0
    x1, y1, x2, y2 = shape.edges.T
    dx, dy = x2 - x1, y2 - y1
    along = np.clip(((x - x1) * dx + (y - y1) * dy) / (dx * dx + dy * dy), 0.0, 1.0)
    return float(np.hypot(x1 + along * dx - x, y1 + along * dy - y).min())


def shape_area(shape: Shape) -> float:
    """Return the area of a region [m^2]."""
    return float(triangle_areas(shape.triangles).sum())


def triangle_areas(triangles: Floats) -> Floats:
    x1, y1, x2, y2, x3, y3 = triangles.T
    return 0.5 * np.abs((x2 - x1) * (y3 - y1) - (y2 - y1) * (x3 - x1))


def _hull_rows(edges: Floats) -> Floats:
    hull = ring_edges(convex_hull(edges[:, :2]))
    both_ways = {tuple(edge) for edge in np.vstack([edges, np.roll(edges, 2, axis=1)]).tolist()}
    shared = np.array([[float(tuple(edge) in both_ways)] for edge in hull.tolist()])
    direction = hull[:, 2:] - hull[:, :2]
    length = np.hypot(direction[:, 0], direction[:, 1])[:, None]
    rows = np.hstack([hull, shared, direction / length, length])
    return rows[np.argsort(-shared[:, 0], kind="stable")]


# -- strips ------------------------------------------------------------------------------------------------------------


def strip(paths: PathBook, path: int, width: float, tolerance: float) -> Shape:
    """Return the region within half a width to either side of a path, with square ends; tiled along the path."""
    return _strip(np.array(paths.primitives(path), dtype=np.float64).tobytes(), width, tolerance)


@lru_cache(maxsize=1024)
def _strip(primitives: bytes, width: float, tolerance: float) -> Shape:
    """Return the strip of primitives, given as bytes, which tell -0.0 from 0.0. The files of a folder share lanes."""
    paths = PathBook()
    path = paths.add([Primitive(*row) for row in np.frombuffer(primitives).reshape(-1, 5).tolist()])
    left, right = borders(paths, path, width, tolerance)
    return between(left, right)


def between(left: Floats, right: Floats) -> Shape:
    """Return the region between two borders, each (n, 2)."""
    ring = anticlockwise(_without_repeats(np.vstack([right, left[::-1]])))
    shape = shape_of_parts(ring_edges(ring), _tiles(left, right))
    is_rectangle = len(ring) == 4 and np.any(np.abs(left[1] - left[0]) < 1e-9)
    return with_cores(shape, [[*ring.min(axis=0), *ring.max(axis=0)]]) if is_rectangle else shape


def borders(paths: PathBook, path: int, width: float, tolerance: float) -> tuple[Floats, Floats]:
    """Return (n, 2) left and right border of a path's strip."""
    poses = np.array([paths.pose(path, s) for s in paths.stations(path, tolerance)])
    normal = np.column_stack([-np.sin(poses[:, 2]), np.cos(poses[:, 2])])
    return poses[:, :2] + 0.5 * width * normal, poses[:, :2] - 0.5 * width * normal


def _tiles(left: Floats, right: Floats) -> Floats:
    """Return two triangles for each stretch between two stations."""
    lower = np.hstack([right[:-1], right[1:], left[1:]])
    upper = np.hstack([right[:-1], left[1:], left[:-1]])
    return np.vstack([lower, upper])


def _without_repeats(ring: Floats) -> Floats:
    # The inner border of a turn about its own centre is a single point.
    return ring[np.hypot(*(ring - np.roll(ring, 1, axis=0)).T) > 1e-9]
