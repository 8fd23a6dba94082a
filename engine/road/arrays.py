"""`road_tables`: a network as arrays for the kernels."""

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from itertools import chain
from typing import Any

import numpy as np

from engine.road.network import Network
from engine.road.paths import PathBook
from engine.road.regions import Shape, triangle_areas
from engine.tables import ROAD_REGION, Floats, Ints, RoadTables

MANY = 64
"""Edges of a road from which on it has cells."""
SIDE = 8.0
"""Side of a cell [m]."""
MOST_CELLS = 1 << 16
"""Maximum number of cells; the side grows to keep it."""
MOST_PAIRS = 1 << 22
"""Maximum number of pairs of an edge and a cell of its bounding box; the side grows to keep it."""
MARGIN = 1e-6
"""Distance from a cell within which an edge counts as in it [m]."""
LINE = 0.4877
"""Northward position of a cell's reference point, as a share of the side."""
ALONG = (0.5123, 0.2791, 0.7639)
"""Candidates for its eastward position; the farthest from the edges is chosen. They are not round, unlike road corners.
"""


def road_tables(network: Network) -> RoadTables:
    """Return all paths (also those joined after the network was built), lanes and regions."""
    shapes = [network.regions.shape(region) for region in range(len(network.regions))]
    lanes = network.lanes
    return RoadTables(
        primitives=_primitive_rows(network.paths),
        path_start=_offsets([len(network.paths.primitives(path)) for path in range(len(network.paths))]),
        path_length=np.array([network.paths.length(path) for path in range(len(network.paths))]),
        lane_path=np.array([lane.path for lane in lanes], dtype=np.int32),
        lane_route=np.array([lane.default_route for lane in lanes], dtype=np.int32),
        lane_width=np.array([lane.width for lane in lanes]),
        edges=np.vstack([shape.edges for shape in shapes]),
        region_start=_offsets([len(shape.edges) for shape in shapes]),
        hull=np.vstack([shape.hull for shape in shapes]),
        hull_start=_offsets([len(shape.hull) for shape in shapes]),
        triangles=_with_shares(shapes),
        triangle_start=_offsets([len(shape.triangles) for shape in shapes]),
        cores=np.vstack([shape.cores for shape in shapes]),
        core_start=_offsets([len(shape.cores) for shape in shapes]),
        buildings=network.buildings,
        **cells_of(shapes[ROAD_REGION].edges),
        **levels_of(network.heights),
    )


def _primitive_rows(paths: PathBook) -> Floats:
    every = range(len(paths))
    starts = np.fromiter(chain.from_iterable(paths.starts(path)[:-1] for path in every), np.float64)
    values = chain.from_iterable(chain.from_iterable(map(paths.primitives, every)))
    primitives = np.fromiter(values, np.float64).reshape(len(starts), -1)
    # Kernels may compute cosine and sine of a heading again: they are those of `math`, as numpy's may differ in a bit.
    turned = [(math.cos(heading), math.sin(heading)) for heading in primitives[:, 2].tolist()]
    return np.column_stack([starts, primitives, np.array(turned).reshape(-1, 2)])


def _offsets(counts: Sequence[int]) -> Ints:
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)


def _with_shares(shapes: Sequence[Shape]) -> Floats:
    """Return (n, 7) the triangles of all shapes, each after the cumulative share of its shape's area."""
    triangles = np.vstack([shape.triangles for shape in shapes])
    areas, first = triangle_areas(triangles), 0
    for shape in shapes:
        own = areas[first : first + len(shape.triangles)]
        np.cumsum(own, out=own)
        own /= own[-1]
        first += len(own)
    return np.column_stack([areas, triangles])


# -- the edges of a large road by square cells -------------------------------------------------------------------------


def cells_of(edges: Floats) -> dict[str, Any]:
    """Return the fields of `RoadTables` that index these edges, so that a look-up tests a few edges only.

    The index has no influence on results. Each cell has a reference point with known containment. A place in the cell
    is inside or outside like that point, reversed by each edge between the two (`kernels.region`).
    """
    return {} if len(edges) < MANY else dict(_cells(np.ascontiguousarray(edges).tobytes()))


@lru_cache(maxsize=16)
def _cells(content: bytes) -> Mapping[str, Any]:
    """Return the index of edges (n, 4), given as bytes. The files of a folder share roads."""
    edges = np.frombuffer(content).reshape(-1, 4).copy()
    low, high = edges.reshape(-1, 2).min(axis=0), edges.reshape(-1, 2).max(axis=0)
    wide, deep = (high - low + 2.0 * SIDE).tolist()
    side = max(SIDE, math.sqrt(wide * deep / MOST_CELLS))
    first, reach = _boxes(edges, low, side)
    while int(reach.prod(axis=1).sum()) > MOST_PAIRS:
        side *= 2.0
        first, reach = _boxes(edges, low, side)
    columns, rows = (int(number) for number in (first + reach).max(axis=0) + 1)
    edge, cell = _pairs(edges, low - side, side, columns, first, reach)
    order = np.argsort(cell, kind="stable")
    edge, cell = edge[order], cell[order]
    start = np.searchsorted(cell, np.arange(columns * rows + 1)).astype(np.int32)
    return {
        "cell_edges": edges[edge],
        "cell_start": start,
        "cell_points": _points(edges, edges[edge], cell, low - side, side, columns, rows),
        "cell_frame": np.array([*(low - side), side, columns, rows]),
    }


def levels_of(heights: Floats) -> dict[str, Any]:
    """Return the fields of `RoadTables` that hold heights, sorted by cells."""
    if not len(heights):
        return {}
    low, high = heights[:, :2].min(axis=0), heights[:, :2].max(axis=0)
    wide, deep = (high - low + SIDE).tolist()
    side = max(SIDE, math.sqrt(wide * deep / MOST_CELLS))
    place = np.floor((heights[:, :2] - low) / side).astype(np.int64)
    columns, rows = (int(number) + 1 for number in place.max(axis=0))
    cell = place[:, 1] * columns + place[:, 0]
    order = np.argsort(cell, kind="stable")
    return {
        "heights": np.ascontiguousarray(heights[order]),
        "height_start": np.searchsorted(cell[order], np.arange(columns * rows + 1)).astype(np.int32),
        "height_frame": np.array([*low, side, columns, rows]),
    }


def _boxes(edges: Floats, low: Floats, side: float) -> tuple[Ints, Ints]:
    """Return (n, 2) column and row of the first cell of each edge's bounding box, and the number of both."""
    ends = edges.reshape(-1, 2, 2)
    first, last = (
        np.floor((end - low) / side).astype(np.int64) + 1
        for end in (ends.min(axis=1) - MARGIN, ends.max(axis=1) + MARGIN)
    )
    return first, last - first + 1


def _spread(counts: Ints) -> tuple[Ints, Ints]:
    """Expand counts into (owner, index within owner) for every element."""
    owner = np.repeat(np.arange(len(counts)), counts)
    return owner, np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)


def _pairs(edges: Floats, corner: Floats, side: float, columns: int, first: Ints, reach: Ints) -> tuple[Ints, Ints]:
    """Return pairs of edges and cells that they intersect: cells of the bounding box that the edge's line does not
    miss.
    """
    edge, number = _spread(reach.prod(axis=1))
    place = first[edge] + np.column_stack([number % reach[edge, 0], number // reach[edge, 0]])
    begin, way = edges[edge, :2], edges[edge, 2:] - edges[edge, :2]
    to = corner + (place + 0.5) * side - begin
    across = np.abs(to[:, 0] * way[:, 1] - to[:, 1] * way[:, 0])
    near = across <= (0.5 * side + MARGIN) * np.abs(way).sum(axis=1)
    return edge[near], (place[:, 1] * columns + place[:, 0])[near]


def _points(edges: Floats, listed: Floats, cell: Ints, corner: Floats, side: float, columns: int, rows: int) -> Floats:
    """Return rows of `RoadTables.cell_points`; `listed` are the edges of the cells `cell`."""
    x = corner[0] + (np.arange(columns)[:, None] + np.array(ALONG)) * side
    y = corner[1] + (np.arange(rows) + LINE) * side
    apart = np.full((rows * columns, len(ALONG)), np.inf)
    for candidate in range(len(ALONG)):
        np.minimum.at(apart[:, candidate], cell, _off(listed, x[cell % columns, candidate], y[cell // columns]))
    best, at = apart.argmax(axis=1), np.arange(rows * columns)
    places = np.column_stack([x[at % columns, best], y[at // columns]])
    return np.column_stack([places, _inside(edges, places, y)])


def _off(edges: Floats, x: Floats, y: Floats) -> Floats:
    """Return the squared distance of each point from its edge [m^2]."""
    way, to = edges[:, 2:] - edges[:, :2], np.column_stack([x, y]) - edges[:, :2]
    along = np.clip((to * way).sum(axis=1) / (way * way).sum(axis=1), 0.0, 1.0)
    return ((to - along[:, None] * way) ** 2).sum(axis=1)


def _inside(edges: Floats, places: Floats, y: Floats) -> Floats:
    """Return containment by the even-odd rule, from the edges that cross a point's row east of it; places are row by
    row.
    """
    low: Floats = edges[:, 1::2].min(axis=1)
    high: Floats = edges[:, 1::2].max(axis=1)
    first, last = np.searchsorted(y, low), np.searchsorted(y, high)
    edge, number = _spread(last - first)
    line = first[edge] + number
    x1, y1, x2, y2 = edges[edge].T
    crossing = x1 + (y[line] - y1) * (x2 - x1) / (y2 - y1)
    order = np.lexsort([crossing, line])
    begin = np.searchsorted(line[order], np.arange(len(y) + 1))
    inside, columns = np.zeros(len(places)), len(places) // len(y)
    for each in range(len(y)):
        crossings = crossing[order[begin[each] : begin[each + 1]]]
        here = slice(each * columns, (each + 1) * columns)
        inside[here] = (len(crossings) - np.searchsorted(crossings, places[here, 0])) % 2
    return inside
