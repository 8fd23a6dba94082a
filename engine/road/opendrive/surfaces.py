"""What lanes of a file cover: strips between their borders, and true unions of those that overlap.

Unions need shapely (extra `maps`), which is imported here alone; what is made are arrays.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from engine.errors import Signal
from engine.extras import needed
from engine.road.junction import CHORD_TOLERANCE
from engine.road.opendrive.fitting import Stretch
from engine.road.paths import Primitive, chord_count
from engine.road.regions import Shape, area, ring_edges, shape_of_parts, triangle_areas
from engine.tables import Floats

APART = 2.0
"""Between two points of a border that is neither straight nor an arc [m]."""
GAP = 0.05
"""Strips nearer to one another than twice this have no gap between them [m]."""
SMOOTH = 0.005
"""How far the corners of a union may be left out [m]."""
PRECISION = 1e-4
"""Of the corners of a union [m]: nearly equal ones cannot be triangulated."""
SPECK = 0.1
"""Part of a union that is smaller is left out [m^2]."""
LEAST_WIDTH = 0.1
"""Of a strip of a lane that has no width [m]."""
NOTHING = 1e-9


class NoSurface(Signal):
    """Lanes without a width cover nothing."""


def places(row: Stretch) -> list[float]:
    """Where the borders of a stretch have their points, its end left out [m]."""
    length = row.end - row.start
    if row.is_plain:
        widest = Primitive(0.0, 0.0, 0.0, row.piece.curvature or 0.0, length)
        count = chord_count(widest, 0.5 * CHORD_TOLERANCE)
    else:
        count = max(1, round(length / APART))
    return [row.start + length * i / count for i in range(count)]


def border(rows: Sequence[Stretch], *, outer: bool) -> Floats:
    """(n, 2) one border of a lane, in the direction of the reference line."""
    points = [row.beside(s, row.border(s, outer=outer)) for row in rows for s in (*places(row), row.end)]
    return np.array(points)


def strip_between(inner: Floats, outer: Floats) -> Shape:
    """The region between two borders with as many points each."""
    across = outer - inner
    if float(np.hypot(across[:, 0], across[:, 1]).max()) < LEAST_WIDTH:
        outer = inner + _normals(inner) * LEAST_WIDTH
    lower = np.hstack([inner[:-1], inner[1:], outer[1:]])
    upper = np.hstack([inner[:-1], outer[1:], outer[:-1]])
    triangles = np.vstack([lower, upper])
    ring = ring_of(inner, outer)
    return shape_of_parts(ring_edges(ring), triangles[triangle_areas(triangles) > NOTHING])


def _normals(line: Floats) -> Floats:
    ways = np.gradient(line, axis=0)
    lengths = np.maximum(np.hypot(ways[:, 0], ways[:, 1]), NOTHING)
    return np.column_stack([-ways[:, 1], ways[:, 0]]) / lengths[:, None]


def ring_of(inner: Floats, outer: Floats) -> Floats:
    """The outline between two borders, anticlockwise, without repeated points."""
    ring = np.vstack([inner, outer[::-1]])
    sides = ring - np.roll(ring, 1, axis=0)
    ring = ring[np.hypot(sides[:, 0], sides[:, 1]) > 1e-6]
    return ring if area(ring) > 0.0 else ring[::-1]


def union(rings: Sequence[Floats]) -> tuple[Shape, tuple[Floats, ...]]:
    """Everything that these outlines cover, and its closed outlines, each (n, 2)."""
    shapely: Any = needed("shapely", "roads of OpenDRIVE files need", "maps")
    parts = [shapely.Polygon(ring).buffer(GAP, join_style="mitre") for ring in rings if len(ring) > 2]
    # what the union leaves apart goes on one by one, as GEOS would compare each with all others; in an order of its own
    whole = sorted(_parts(shapely.disjoint_subset_union_all(parts)), key=lambda each: each.bounds)
    apart = (each.buffer(-GAP, join_style="mitre").simplify(SMOOTH) for each in whole)
    polygons = [each for part in apart for each in _parts(rounded(part)) if each.area > SPECK]
    if not polygons:
        raise NoSurface
    lines = [np.array(line.coords) for each in polygons for line in (each.exterior, *each.interiors)]
    tiles = shapely.constrained_delaunay_triangles(shapely.MultiPolygon(polygons))
    triangles = np.array([np.array(each.exterior.coords)[:3].ravel() for each in tiles.geoms])
    edges = np.vstack([np.hstack([line[:-1], line[1:]]) for line in lines])
    edges = edges[np.hypot(edges[:, 2] - edges[:, 0], edges[:, 3] - edges[:, 1]) > NOTHING]
    return shape_of_parts(edges, triangles[triangle_areas(triangles) > NOTHING]), tuple(lines)


def _parts(surface: Any) -> Sequence[Any]:
    return getattr(surface, "geoms", [surface])


def rounded(surface: Any) -> Any:
    """To `PRECISION`; one whose outline meets itself, as that of narrow borders may, is made whole before."""
    shapely: Any = needed("shapely", "roads of OpenDRIVE files need", "maps")
    return shapely.set_precision(surface if surface.is_valid else shapely.make_valid(surface), PRECISION)


def overlap(one: Shape, other: Shape) -> float:
    """What two surfaces have in common [m^2]."""
    (low, high), (least, most) = (
        (corners.min(axis=0), corners.max(axis=0)) for corners in (one.edges[:, :2], other.edges[:, :2])
    )
    if (low > most).any() or (least > high).any():
        return 0.0
    shapely: Any = needed("shapely", "roads of OpenDRIVE files need", "maps")
    first, second = (shapely.union_all(shapely.polygons(each.triangles.reshape(-1, 3, 2))) for each in (one, other))
    return float(first.intersection(second).area)
