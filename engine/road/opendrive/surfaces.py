"""Surfaces of a file's lanes: strips between their borders, and true unions of overlapping strips.

Unions need shapely, which is imported here and in `levels` only; results are arrays.
"""

import math
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
import shapely as shapely_with_types

from engine.errors import Signal
from engine.road.junction import CHORD_TOLERANCE
from engine.road.opendrive.fitting import Stretch
from engine.road.paths import Primitive, chord_count
from engine.road.regions import Shape, area, ring_edges, shape_area, shape_of_parts, triangle_areas
from engine.tables import Floats

shapely: Any = shapely_with_types
"""Its own types leave most results unknown."""
APART = 2.0
"""Distance between points of a border that is neither straight nor an arc [m]."""
GAP = 0.05
"""Half of the distance between strips up to which there is no gap between them [m]."""
SMOOTH = 1e-4
"""Distance from the outline within which corners of a union are removed [m]: from 1 mm on, areas depend on the pose."""
PRECISION = 1e-6
"""Grid of the corners of a union [m]: nearly equal corners cannot be triangulated."""
TILED = 1e-6
"""Greatest share by which the area of triangles may differ from that of the union that they tile."""
SPECK = 0.1
"""Area below which a part of a union is omitted [m^2]."""
LEAST_WIDTH = 0.1
"""Width of the strip of a lane without a width [m]."""
NOTHING = 1e-9


class NoSurface(Signal):
    """Lanes without a width cover nothing; or the surface of a part (a shapely polygon) cannot be computed."""

    def __init__(self, part: Any = None) -> None:
        super().__init__()
        self.part = part


def places(row: Stretch) -> list[float]:
    """Return the places of a stretch's border points, without its end [m]."""
    length = row.end - row.start
    if row.is_plain:
        widest = Primitive(0.0, 0.0, 0.0, row.piece.curvature or 0.0, length)
        count = chord_count(widest, 0.5 * CHORD_TOLERANCE)
    else:
        count = max(1, round(length / APART))
    return [row.start + length * i / count for i in range(count)]


def border(rows: Sequence[Stretch], *, outer: bool) -> Floats:
    """Return (n, 2) one border of a lane, in the direction of the reference line."""
    points = [row.beside(s, row.border(s, outer=outer)) for row in rows for s in (*places(row), row.end)]
    return np.array(points)


def strip_between(inner: Floats, outer: Floats) -> Shape:
    """Return the region between two borders with equal numbers of points."""
    if _is_thread(inner, outer):
        outer = inner + _normals(inner) * LEAST_WIDTH
    lower = np.hstack([inner[:-1], inner[1:], outer[1:]])
    upper = np.hstack([inner[:-1], outer[1:], outer[:-1]])
    triangles = np.vstack([lower, upper])
    ring = ring_of(inner, outer)
    return shape_of_parts(ring_edges(ring), triangles[triangle_areas(triangles) > NOTHING])


def _is_thread(inner: Floats, outer: Floats) -> bool:
    return float(np.hypot(*(outer - inner).T).max()) < LEAST_WIDTH


def _normals(line: Floats) -> Floats:
    ways = np.gradient(line, axis=0)
    lengths = np.maximum(np.hypot(ways[:, 0], ways[:, 1]), NOTHING)
    return np.column_stack([-ways[:, 1], ways[:, 0]]) / lengths[:, None]


def ring_of(inner: Floats, outer: Floats) -> Floats:
    """Return the outline between two borders, anticlockwise, without repeated points."""
    ring = np.vstack([inner, outer[::-1]])
    sides = ring - np.roll(ring, 1, axis=0)
    ring = ring[np.hypot(sides[:, 0], sides[:, 1]) > 1e-6]
    return ring if area(ring) > 0.0 else ring[::-1]


def outline(inner: Floats, outer: Floats) -> Any:
    """Return the polygon between two borders, empty without a width.

    If its outline crosses itself, as in a tight curve, it is the union of its tiles.
    """
    ring = ring_of(inner, outer)
    polygon = shapely.Polygon(None if len(ring) < 3 or _is_thread(inner, outer) else ring)
    if polygon.is_valid:
        return polygon
    tiles = shapely.polygons(strip_between(inner, outer).triangles.reshape(-1, 3, 2))
    with _named([polygon]):
        return shapely.union_all(tiles, grid_size=PRECISION)


def union(outlines: Sequence[Any]) -> tuple[Shape, tuple[Floats, ...]]:
    """Return everything that these outlines cover, and its closed outlines, each (n, 2) [m].

    Raises:
        NoSurface: no outline has an area, or the union of some cannot be computed.
    """
    grown = [_grown(each) for each in outlines if each.area > 0.0]
    # Separate parts of the union are processed one by one, as GEOS would compare each with all others; sorted, so that
    # the order is defined.
    with _named(grown):
        whole = sorted(_parts(shapely.disjoint_subset_union_all(grown)), key=lambda each: each.bounds)
    shrunk = (_shrunk(each) for each in whole)
    polygons = [each for part in shrunk for each in _parts(part) if each.area > SPECK]
    if not polygons:
        raise NoSurface
    return _shape_of(polygons)


def _shape_of(polygons: Sequence[Any]) -> tuple[Shape, tuple[Floats, ...]]:
    """Return polygons without common area as one region, and their closed outlines."""
    lines = [np.array(line.coords) for each in polygons for line in (each.exterior, *each.interiors)]
    edges = np.vstack([np.hstack([line[:-1], line[1:]]) for line in lines])
    edges = edges[np.hypot(edges[:, 2] - edges[:, 0], edges[:, 3] - edges[:, 1]) > NOTHING]
    return shape_of_parts(edges, _triangles(polygons)), tuple(lines)


def shape_of_outline(inner: Floats, outer: Floats) -> Shape | None:
    """Return the region between two borders with equal numbers of points; None without an area.

    Raises:
        NoSurface: it cannot be computed.
    """
    polygon = outline(inner, outer)
    if polygon.area < SPECK:
        return None
    is_plain = shapely.Polygon(ring_of(inner, outer)).is_valid
    return strip_between(inner, outer) if is_plain else shape_of_polygon(polygon)


def shape_of_polygon(polygon: Any) -> Shape:
    """Return the region of a polygon, whose outline may cross itself, or of several."""
    return _shape_of([each for each in _parts(rounded(polygon)) if each.geom_type == "Polygon"])[0]


def merged(shapes: Sequence[Shape]) -> Shape:
    """Return everything that some regions cover, as one region without borders inside it."""
    return shape_of_polygon(shapely.union_all([_polygon_of(each) for each in shapes], grid_size=PRECISION))


def _polygon_of(shape: Shape) -> Any:
    """Return a region as a polygon, from its boundary, else from its tiles."""
    polygon = shapely.build_area(shapely.multilinestrings(shape.edges.reshape(-1, 2, 2)))
    if abs(polygon.area - shape_area(shape)) <= TILED * polygon.area and polygon.is_valid:
        return polygon
    return shapely.union_all(shapely.polygons(shape.triangles.reshape(-1, 3, 2)), grid_size=PRECISION)


def _grown(polygon: Any) -> Any:
    """Return a polygon widened by `GAP`. GEOS loses some mitred outlines; it never loses round ones."""
    grown = polygon.buffer(GAP, join_style="mitre")
    return grown if grown.area > polygon.area else polygon.buffer(GAP)


def _shrunk(part: Any) -> Any:
    """Return a part of the union without its outermost `GAP`, its corners rounded.

    The strip along the outline is subtracted: GEOS computes a mitred `buffer(-GAP)` of an outline with an acute corner
    wrongly in about one of a hundred positions, and then loses all of it.

    Raises:
        NoSurface: more is lost than an outline of this length can lose.
    """
    strip = part.boundary.buffer(GAP, quad_segs=1)
    with _named([part]):
        shrunk = part.difference(strip)
    # An inner parallel outline is not longer than the outline itself, except for 2 pi r at each hole (Steiner); GEOS
    # simplifies buffered outlines by 1 % of the distance.
    holes = sum(len(each.interiors) for each in _parts(part))
    _check_loss(part, shrunk, 1.01 * (part.length * GAP + math.pi * GAP**2 * holes))
    with _named([part]):
        final = rounded(shrunk.simplify(SMOOTH))
    _check_loss(shrunk, final, shrunk.length * SMOOTH)
    return final


def _check_loss(before: Any, after: Any, most: float) -> None:
    """Raise NoSurface if more than `most` [m^2] of a polygon is lost."""
    if before.area - after.area > most + NOTHING * before.area:
        raise NoSurface(before)


@contextmanager
def _named(parts: Sequence[Any]) -> Generator[None]:
    """Raise NoSurface with the first of some parts where rounding defeats GEOS."""
    try:
        yield
    except shapely.errors.GEOSException:
        raise NoSurface(parts[0]) from None


def _triangles(polygons: Sequence[Any]) -> Floats:
    """Return (n, 6) tiles of polygons."""
    with _named(polygons):
        tiles = shapely.constrained_delaunay_triangles(shapely.MultiPolygon(polygons))
    triangles: Floats = np.array([np.array(each.exterior.coords)[:3].ravel() for each in tiles.geoms]).reshape(-1, 6)
    areas = triangle_areas(triangles)
    if abs(areas.sum() - sum(each.area for each in polygons)) > TILED * areas.sum():
        raise NoSurface(polygons[0])
    return triangles[areas > NOTHING]


def _parts(surface: Any) -> Sequence[Any]:
    return getattr(surface, "geoms", [surface])


def rounded(surface: Any) -> Any:
    """Return the surface rounded to `PRECISION`; an outline that crosses itself, as of narrow borders, is repaired
    before.
    """
    return shapely.set_precision(surface if surface.is_valid else shapely.make_valid(surface), PRECISION)


def overlap(one: Shape, other: Shape) -> float:
    """Return the common area of two surfaces [m^2]."""
    (low, high), (least, most) = (
        (corners.min(axis=0), corners.max(axis=0)) for corners in (one.edges[:, :2], other.edges[:, :2])
    )
    if (low > most).any() or (least > high).any():
        return 0.0
    first, second = (shapely.union_all(shapely.polygons(each.triangles.reshape(-1, 3, 2))) for each in (one, other))
    return float(first.intersection(second).area)
