"""Regions: inside, distance, containment of an outline, uniform sampling.

A region is a set of edges; inside is decided by the even-odd rule. Rectangles known to lie inside (`RoadTables.cores`)
answer most questions first: nearly all of a road is two bands that cross. Rows of `RoadTables.hull` are `x1, y1, x2,
y2, shared, ux, uy, length`: an edge of the convex hull, whether the region has it too, its unit direction and length.
Functions called in inner loops are copied into their callers: passing an array costs more than the computation.
"""

import math
from typing import NamedTuple

from engine.kernels.geometry import Box, Frame, frame
from engine.kernels.jit import inlined, kernel
from engine.tables import ROAD_REGION, Floats, Ints, RoadTables

X1, Y1, X2, Y2, SHARED, UX, UY, LENGTH = range(8)
"""Columns of a hull edge; a region edge has the first four."""
WEST, SOUTH, SIZE, COLUMNS, ROWS = range(5)
"""Entries of `RoadTables.cell_frame`."""
INSIDE = 2
"""Column of `RoadTables.cell_points`."""


class RegionPoint(NamedTuple):
    x: float
    y: float


@inlined
def region_contains(road: RoadTables, region: int, x: float, y: float) -> bool:
    """Return True if (x, y) is in the region."""
    if _in_core(road.cores, road.core_start[region], road.core_start[region + 1], x, y, 0.0, 0.0):
        return True
    if region == ROAD_REGION and len(road.cell_start) > 1:
        return _contains_in_cell(road.cell_edges, road.cell_start, road.cell_points, road.cell_frame, x, y)
    return _contains(road.edges, road.region_start[region], road.region_start[region + 1], x, y)


@inlined
def region_distance(road: RoadTables, region: int, x: float, y: float) -> float:
    """Return the distance from (x, y) to the region [m]; 0 inside.

    The hull contains the region, so no part of the region is nearer than the hull. If the hull's nearest point is on an
    edge that both share, it is the region's nearest point too. That holds for a car in the approach of a junction: the
    stop line is such an edge. Otherwise every edge is tested.
    """
    distance = _hull_distance(road.hull, road.hull_start[region], road.hull_start[region + 1], x, y)
    if distance >= 0.0:
        return distance
    if _in_core(road.cores, road.core_start[region], road.core_start[region + 1], x, y, 0.0, 0.0):
        return 0.0
    return _polygon_distance(road.edges, road.region_start[region], road.region_start[region + 1], x, y)


@inlined
def region_contains_box(road: RoadTables, region: int, box: Box) -> bool:
    """Return True if the whole outline is in the region."""
    it = frame(box)
    reach_x = 0.5 * (box.length * abs(it.cos) + box.width * abs(it.sin))
    reach_y = 0.5 * (box.length * abs(it.sin) + box.width * abs(it.cos))
    if _in_core(road.cores, road.core_start[region], road.core_start[region + 1], it.x, it.y, reach_x, reach_y):
        return True
    if region == ROAD_REGION and len(road.cell_start) > 1:
        edges, starts, cells = road.cell_edges, road.cell_start, road.cell_frame
        inside = _contains_in_cell(edges, starts, road.cell_points, cells, it.x, it.y)
        return inside and not _is_entered_in_cells(edges, starts, cells, it, reach_x, reach_y)
    return _contains_box(road.edges, road.region_start[region], road.region_start[region + 1], it)


@inlined
def region_box_distance(road: RoadTables, region: int, box: Box) -> float:
    """Return the distance between the region and an outline [m]; 0 if they touch or overlap."""
    return _box_distance(road.edges, road.region_start[region], road.region_start[region + 1], box)


@kernel
def region_depth(road: RoadTables, region: int, x: float, y: float) -> float:
    """Return the depth of (x, y) in the region: its distance to the boundary, negative outside [m]."""
    edges, start, end = road.edges, road.region_start[region], road.region_start[region + 1]
    best = math.inf
    for i in range(start, end):
        best = min(best, _off_segment(x, y, edges[i, X1], edges[i, Y1], edges[i, X2], edges[i, Y2]))
    return math.sqrt(best) if region_contains(road, region, x, y) else -math.sqrt(best)


@kernel
def region_box_depth(road: RoadTables, region: int, box: Box) -> float:
    """Return the depth of an outline in the region: its distance to the boundary, or minus the largest distance of its
    corners outside [m]; 0 if an edge leaves the region between two corners that are inside.
    """
    edges, start, end = road.edges, road.region_start[region], road.region_start[region + 1]
    if region_contains_box(road, region, box):
        return _edges_off_box(edges, start, end, box)
    cos, sin, a, b = math.cos(box.heading), math.sin(box.heading), 0.5 * box.length, 0.5 * box.width
    farthest = 0.0
    for along, aside in ((a, b), (a, -b), (-a, b), (-a, -b)):
        x, y = box.x + along * cos - aside * sin, box.y + along * sin + aside * cos
        farthest = min(farthest, region_depth(road, region, x, y))
    return farthest


@inlined
def region_sample(road: RoadTables, region: int, u1: float, u2: float) -> RegionPoint:
    """Return a point that is uniform by area, from two uniform numbers in [0, 1)."""
    return _sample(road.triangles, road.triangle_start[region], road.triangle_start[region + 1], u1, u2)


@kernel
def _contains(edges: Floats, start: int, end: int, x: float, y: float) -> bool:
    inside = False
    for i in range(start, end):
        y1, y2 = edges[i, Y1], edges[i, Y2]
        if (y1 > y) != (y2 > y) and edges[i, X1] + (y - y1) * (edges[i, X2] - edges[i, X1]) / (y2 - y1) > x:
            inside = not inside
    return inside


@inlined
def _in_core(cores: Floats, start: int, end: int, x: float, y: float, reach_x: float, reach_y: float) -> bool:
    """Return True if a rectangle contains all points within the reaches of (x, y)."""
    for i in range(start, end):
        wide = cores[i, X1] <= x - reach_x and x + reach_x <= cores[i, X2]
        if wide and cores[i, Y1] <= y - reach_y and y + reach_y <= cores[i, Y2]:
            return True
    return False


@inlined
def _hull_distance(hull: Floats, start: int, end: int, x: float, y: float) -> float:
    """Return the distance to the hull if the nearest point is on a shared edge, else -1.

    The nearest point of a convex area to a point on the outer normal of an edge is on that edge, and no other edge need
    be tested; shared edges come first.
    """
    for i in range(start, end):
        if hull[i, SHARED] == 0.0:
            break
        dx, dy = x - hull[i, X1], y - hull[i, Y1]
        out = dx * hull[i, UY] - dy * hull[i, UX]
        along = dx * hull[i, UX] + dy * hull[i, UY]
        if out >= 0.0 and 0.0 <= along <= hull[i, LENGTH]:
            return out
    return -1.0


@kernel
def _polygon_distance(edges: Floats, start: int, end: int, x: float, y: float) -> float:
    if _contains(edges, start, end, x, y):
        return 0.0
    best = math.inf
    for i in range(start, end):
        best = min(best, _off_segment(x, y, edges[i, X1], edges[i, Y1], edges[i, X2], edges[i, Y2]))
    return math.sqrt(best)


@kernel
def _contains_in_cell(edges: Floats, start: Ints, points: Floats, frame: Floats, x: float, y: float) -> bool:
    """Return True if (x, y) is inside: each edge between it and the known point of its cell reverses the answer."""
    column, row = (x - frame[WEST]) / frame[SIZE], (y - frame[SOUTH]) / frame[SIZE]
    if not (0.0 <= column < frame[COLUMNS] and 0.0 <= row < frame[ROWS]):
        return False
    cell = int(row) * int(frame[COLUMNS]) + int(column)
    inside = points[cell, INSIDE] != 0.0
    dx, dy = points[cell, 0] - x, points[cell, 1] - y
    for i in range(start[cell], start[cell + 1]):
        x1, y1 = edges[i, X1] - x, edges[i, Y1] - y
        x2, y2 = edges[i, X2] - x, edges[i, Y2] - y
        if (dx * y1 - dy * x1 > 0.0) != (dx * y2 - dy * x2 > 0.0):
            ex, ey = x2 - x1, y2 - y1
            if (ey * x1 - ex * y1 > 0.0) != (ex * (dy - y1) - ey * (dx - x1) > 0.0):
                inside = not inside
    return inside


@inlined
def _held(place: float, count: float) -> int:
    """Return a column or row index, limited to the first and last; 0 for NaN."""
    if not place > 0.0:
        return 0
    return int(count) - 1 if place >= count - 1.0 else int(place)


@kernel
def _is_entered_in_cells(edges: Floats, start: Ints, cells: Floats, box: Frame, reach_x: float, reach_y: float) -> bool:
    """Return the result of `_is_entered`, from the edges of the cells that the box overlaps."""
    size, columns, rows = cells[SIZE], cells[COLUMNS], cells[ROWS]
    west, east = box.x - reach_x - cells[WEST], box.x + reach_x - cells[WEST]
    south, north = box.y - reach_y - cells[SOUTH], box.y + reach_y - cells[SOUTH]
    for row in range(_held(south / size, rows), _held(north / size, rows) + 1):
        for column in range(_held(west / size, columns), _held(east / size, columns) + 1):
            cell = row * int(columns) + column
            if _is_entered(edges, start[cell], start[cell + 1], box):
                return True
    return False


@kernel
def _contains_box(edges: Floats, start: int, end: int, box: Frame) -> bool:
    """Return True if the centre is inside and no boundary edge enters the box."""
    return not _is_entered(edges, start, end, box) and _contains(edges, start, end, box.x, box.y)


@kernel
def _is_entered(edges: Floats, start: int, end: int, box: Frame) -> bool:
    """Return True if an edge has a point inside the box."""
    for i in range(start, end):
        dx1, dy1 = edges[i, X1] - box.x, edges[i, Y1] - box.y
        dx2, dy2 = edges[i, X2] - box.x, edges[i, Y2] - box.y
        x1, y1 = dx1 * box.cos + dy1 * box.sin, dy1 * box.cos - dx1 * box.sin
        x2, y2 = dx2 * box.cos + dy2 * box.sin, dy2 * box.cos - dx2 * box.sin
        if _segment_enters(x1, y1, x2, y2, box.half_length, box.half_width):
            return True
    return False


@kernel
def _box_distance(edges: Floats, start: int, end: int, box: Box) -> float:
    """Return the distance [m]: without an edge inside, the box is inside the region if its centre is."""
    if _contains(edges, start, end, box.x, box.y):
        return 0.0
    return _edges_off_box(edges, start, end, box)


@kernel
def _edges_off_box(edges: Floats, start: int, end: int, box: Box) -> float:
    """Return the distance between boundary edges and an outline [m]; 0 if an edge enters."""
    cos, sin, a, b = math.cos(box.heading), math.sin(box.heading), 0.5 * box.length, 0.5 * box.width
    best = math.inf
    for i in range(start, end):
        dx1, dy1 = edges[i, X1] - box.x, edges[i, Y1] - box.y
        dx2, dy2 = edges[i, X2] - box.x, edges[i, Y2] - box.y
        x1, y1 = dx1 * cos + dy1 * sin, dy1 * cos - dx1 * sin
        x2, y2 = dx2 * cos + dy2 * sin, dy2 * cos - dx2 * sin
        if _segment_enters(x1, y1, x2, y2, a, b):
            return 0.0
        best = min(best, _off_box(x1, y1, a, b), _off_box(x2, y2, a, b))
        for x, y in ((a, b), (a, -b), (-a, b), (-a, -b)):
            best = min(best, _off_segment(x, y, x1, y1, x2, y2))
    return math.sqrt(best)


@inlined
def _off_box(x: float, y: float, a: float, b: float) -> float:
    """Return the squared distance of a point from the box |x| <= a, |y| <= b."""
    return max(abs(x) - a, 0.0) ** 2 + max(abs(y) - b, 0.0) ** 2


@inlined
def _off_segment(x: float, y: float, x1: float, y1: float, x2: float, y2: float) -> float:
    """Return the squared distance of a point from a segment of positive length."""
    ex, ey, dx, dy = x2 - x1, y2 - y1, x - x1, y - y1
    along = min(max((dx * ex + dy * ey) / (ex * ex + ey * ey), 0.0), 1.0)
    return (dx - along * ex) ** 2 + (dy - along * ey) ** 2


@inlined
def _segment_enters(x1: float, y1: float, x2: float, y2: float, a: float, b: float) -> bool:
    """Return True if a segment has a point inside the box |x| < a, |y| < b (separating axes; touching is outside)."""
    if min(x1, x2) >= a or max(x1, x2) <= -a or min(y1, y2) >= b or max(y1, y2) <= -b:
        return False
    dx, dy = x2 - x1, y2 - y1
    return abs(x1 * dy - y1 * dx) < a * abs(dy) + b * abs(dx)


@inlined
def _sample(triangles: Floats, start: int, end: int, u1: float, u2: float) -> RegionPoint:
    """Return a point of the triangle selected by `u1`; the rest of `u1` and `u2` place the point in it."""
    low, high = start, end - 1
    while low < high:
        middle = (low + high) // 2
        if u1 < triangles[middle, 0]:
            high = middle
        else:
            low = middle + 1
    before = triangles[low - 1, 0] if low > start else 0.0
    a, b = (u1 - before) / (triangles[low, 0] - before), u2
    if a + b > 1.0:  # the far half of the parallelogram, folded back
        a, b = 1.0 - a, 1.0 - b
    x, y = triangles[low, 1], triangles[low, 2]
    return RegionPoint(
        x + a * (triangles[low, 3] - x) + b * (triangles[low, 5] - x),
        y + a * (triangles[low, 4] - y) + b * (triangles[low, 6] - y),
    )
