"""`road_tables`: a network as arrays for the kernels."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from engine.road.network import Network
from engine.road.paths import PathBook
from engine.road.regions import Shape, triangle_areas
from engine.tables import ROAD_REGION, Floats, Ints, RoadTables


def road_tables(network: Network) -> RoadTables:
    """All paths (also those joined since the network was built), lanes and regions."""
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
        triangles=np.vstack([_shares(shape) for shape in shapes]),
        triangle_start=_offsets([len(shape.triangles) for shape in shapes]),
        cores=np.vstack([shape.cores for shape in shapes]),
        core_start=_offsets([len(shape.cores) for shape in shapes]),
        buildings=network.buildings,
        **_bands(shapes[ROAD_REGION].edges),
    )


MANY = 64
"""Edges of a road from which on it has bands."""
FEW = 4
"""So many edges begin in a band, on average …"""
MOST_BANDS = 4096
"""… but there are no more bands."""


def _bands(edges: Floats) -> dict[str, Any]:
    """The edges of the road by bands of y: a ray to the east crosses only edges of its own band.

    Both here and in the kernels a band is found by the same arithmetic, which grows with y; so none is missed.
    """
    if len(edges) < MANY:
        return {}
    low, high = float(edges[:, 1::2].min()), float(edges[:, 1::2].max())
    count = min(MOST_BANDS, max(1, len(edges) // FEW))
    height = (high - low) / count
    first, last = (
        np.minimum((end - low) / height, count - 1).astype(np.int64)
        for end in (edges[:, 1::2].min(axis=1), edges[:, 1::2].max(axis=1))
    )
    reach = last - first + 1
    edge = np.repeat(np.arange(len(edges)), reach)
    band = np.repeat(first, reach) + np.arange(len(edge)) - np.repeat(np.cumsum(reach) - reach, reach)
    order = np.argsort(band, kind="stable")
    counts = np.bincount(band, minlength=count)
    frame = np.array([low, height, high])
    return {"band_edges": edges[edge[order]], "band_start": _offsets(counts.tolist()), "band_frame": frame}


def _primitive_rows(paths: PathBook) -> Floats:
    rows = [
        (start, *primitive)
        for path in range(len(paths))
        for start, primitive in zip(paths.starts(path), paths.primitives(path), strict=False)
    ]
    primitives = np.array(rows)
    heading = primitives[:, 3]
    return np.column_stack([primitives, np.cos(heading), np.sin(heading)])


def _offsets(counts: Sequence[int]) -> Ints:
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)


def _shares(shape: Shape) -> Floats:
    areas = np.cumsum(triangle_areas(shape.triangles))
    return np.column_stack([areas / areas[-1], shape.triangles])
