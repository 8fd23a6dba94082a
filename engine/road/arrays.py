"""`road_tables`: a network as arrays for the kernels."""

from collections.abc import Sequence
from itertools import chain

import numpy as np

from engine.road.cells import cells_of
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
        triangles=_with_shares(shapes),
        triangle_start=_offsets([len(shape.triangles) for shape in shapes]),
        cores=np.vstack([shape.cores for shape in shapes]),
        core_start=_offsets([len(shape.cores) for shape in shapes]),
        buildings=network.buildings,
        **cells_of(shapes[ROAD_REGION].edges),
    )


def _primitive_rows(paths: PathBook) -> Floats:
    every = range(len(paths))
    starts = np.fromiter(chain.from_iterable(paths.starts(path)[:-1] for path in every), np.float64)
    values = chain.from_iterable(chain.from_iterable(map(paths.primitives, every)))
    primitives = np.fromiter(values, np.float64).reshape(len(starts), -1)
    heading = primitives[:, 2]
    return np.column_stack([starts, primitives, np.cos(heading), np.sin(heading)])


def _offsets(counts: Sequence[int]) -> Ints:
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)


def _with_shares(shapes: Sequence[Shape]) -> Floats:
    """(n, 7): the triangles of all shapes, each behind the share of its shape's area up to its end."""
    triangles = np.vstack([shape.triangles for shape in shapes])
    areas, first = triangle_areas(triangles), 0
    for shape in shapes:
        own = areas[first : first + len(shape.triangles)]
        np.cumsum(own, out=own)
        own /= own[-1]
        first += len(own)
    return np.column_stack([areas, triangles])
