"""The edges of a large road by square cells, so that a place is looked up among a few: an index, which decides nothing.

Each cell has a point of which it is known whether it lies in the road. Whoever stands in the cell is inside or outside
as that point is, turned round by each edge between the two (`kernels.region`).
"""

import math
from typing import Any

import numpy as np

from engine.tables import Floats, Ints

MANY = 64
"""Edges of a road from which on it has cells."""
SIDE = 8.0
"""Of a cell [m] …"""
MOST_CELLS = 1 << 16
"""… which is larger where there would be more of them …"""
MOST_PAIRS = 1 << 22
"""… or more pairs of an edge and a cell of its bounding box."""
MARGIN = 1e-6
"""By which an edge may pass a cell and is in it [m]."""
LINE = 0.4877
"""Where in its cell a point lies, as a share of the side: northwards …"""
ALONG = (0.5123, 0.2791, 0.7639)
"""… and eastwards, whichever is farther from the edges. Not round, as the corners of roads are."""


def cells_of(edges: Floats) -> dict[str, Any]:
    """The fields of `RoadTables` that are an index of these edges."""
    if len(edges) < MANY:
        return {}
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


def _boxes(edges: Floats, low: Floats, side: float) -> tuple[Ints, Ints]:
    """(n, 2) column and row of the first cell of each edge's bounding box, and how many it has of both."""
    ends = edges.reshape(-1, 2, 2)
    first, last = (
        np.floor((end - low) / side).astype(np.int64) + 1
        for end in (ends.min(axis=1) - MARGIN, ends.max(axis=1) + MARGIN)
    )
    return first, last - first + 1


def _spread(counts: Ints) -> tuple[Ints, Ints]:
    """For so many of each: whose each one is, and its number among its like."""
    owner = np.repeat(np.arange(len(counts)), counts)
    return owner, np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)


def _pairs(edges: Floats, corner: Floats, side: float, columns: int, first: Ints, reach: Ints) -> tuple[Ints, Ints]:
    """Every edge with every cell that it reaches into: those of its bounding box that its line does not pass."""
    edge, number = _spread(reach.prod(axis=1))
    place = first[edge] + np.column_stack([number % reach[edge, 0], number // reach[edge, 0]])
    begin, way = edges[edge, :2], edges[edge, 2:] - edges[edge, :2]
    to = corner + (place + 0.5) * side - begin
    across = np.abs(to[:, 0] * way[:, 1] - to[:, 1] * way[:, 0])
    near = across <= (0.5 * side + MARGIN) * np.abs(way).sum(axis=1)
    return edge[near], (place[:, 1] * columns + place[:, 0])[near]


def _points(edges: Floats, listed: Floats, cell: Ints, corner: Floats, side: float, columns: int, rows: int) -> Floats:
    """Rows of `RoadTables.cell_points`; `listed` are the edges of the cells `cell`."""
    x = corner[0] + (np.arange(columns)[:, None] + np.array(ALONG)) * side
    y = corner[1] + (np.arange(rows) + LINE) * side
    apart = np.full((rows * columns, len(ALONG)), np.inf)
    for candidate in range(len(ALONG)):
        np.minimum.at(apart[:, candidate], cell, _off(listed, x[cell % columns, candidate], y[cell // columns]))
    best, at = apart.argmax(axis=1), np.arange(rows * columns)
    places = np.column_stack([x[at % columns, best], y[at // columns]])
    return np.column_stack([places, _inside(edges, places, y, at // columns)])


def _off(edges: Floats, x: Floats, y: Floats) -> Floats:
    """Squared distance of each point from its edge."""
    way, to = edges[:, 2:] - edges[:, :2], np.column_stack([x, y]) - edges[:, :2]
    along = np.clip((to * way).sum(axis=1) / (way * way).sum(axis=1), 0.0, 1.0)
    return ((to - along[:, None] * way) ** 2).sum(axis=1)


def _inside(edges: Floats, places: Floats, y: Floats, row: Ints) -> Floats:
    """By the even-odd rule: how many edges cross the line of a point's row east of it."""
    low: Floats = edges[:, 1::2].min(axis=1)
    high: Floats = edges[:, 1::2].max(axis=1)
    first, last = np.searchsorted(y, low), np.searchsorted(y, high)
    edge, number = _spread(last - first)
    line = first[edge] + number
    x1, y1, x2, y2 = edges[edge].T
    crossing = x1 + (y[line] - y1) * (x2 - x1) / (y2 - y1)
    order = np.lexsort([crossing, line])
    begin = np.searchsorted(line[order], np.arange(len(y) + 1))
    inside = np.zeros(len(places))
    for each in range(len(y)):
        crossings = crossing[order[begin[each] : begin[each + 1]]]
        here = row == each
        inside[here] = (len(crossings) - np.searchsorted(crossings, places[here, 0])) % 2
    return inside
