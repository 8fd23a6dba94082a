"""The interval version of every geometry instruction, and what each reads and gives.

Path and region ids are known numbers in nearly every program; where one is not, nothing is said.
"""

from collections.abc import Callable, Mapping, Sequence

from engine.feasibility import outline_bounds, path_bounds, region_bounds
from engine.feasibility.intervals import Interval, between, everything
from engine.tables import RoadTables
from engine.vocabulary import Op

Geometry = Callable[[RoadTables, Sequence[Interval]], Sequence[Interval]]


def _one_of(count: Callable[[RoadTables], int]) -> Geometry:
    return lambda road, operands: [between(0.0, count(road) - 1.0, len(operands[0].low))]


def _any(width: int) -> Geometry:
    return lambda _road, operands: [everything(len(operands[0].low)) for _ in range(width)]


GEOMETRY: Mapping[Op, Geometry] = {
    Op.PATH_POSE: path_bounds.path_pose,
    Op.PATH_LENGTH: path_bounds.path_length_of,
    Op.PATH_DISTANCE: path_bounds.distance_to_path,
    Op.PATH_PROJECT: path_bounds.projection,
    Op.REGION_SAMPLE: region_bounds.sampled,
    Op.REGION_DISTANCE: region_bounds.distance_to_region,
    Op.REGION_CONTAINS: region_bounds.contains,
    Op.REGION_CONTAINS_BOX: region_bounds.contains_outline,
    Op.REGION_BOX_DISTANCE: region_bounds.outline_to_region,
    Op.BOX_DISTANCE: outline_bounds.between_outlines,
    Op.CAN_SEE: outline_bounds.sees,
    Op.ROAD_HEADING: _any(1),
    Op.ROAD_FOLLOW: _any(3),
    Op.LANE_ROUTE: _one_of(lambda road: len(road.path_length)),
    Op.LANE_NEAREST: _one_of(lambda road: len(road.lane_path)),
}
OPERANDS: Mapping[Op, tuple[int, ...]] = {
    Op.PATH_POSE: (1, 1),
    Op.PATH_LENGTH: (1,),
    Op.PATH_DISTANCE: (1, 1, 1),
    Op.PATH_PROJECT: (1, 1, 1),
    Op.REGION_SAMPLE: (1, 1, 1),
    Op.REGION_DISTANCE: (1, 1, 1),
    Op.REGION_CONTAINS: (1, 1, 1),
    Op.REGION_CONTAINS_BOX: (1, 5),
    Op.REGION_BOX_DISTANCE: (1, 5),
    Op.BOX_DISTANCE: (5, 5),
    Op.CAN_SEE: (5, 5),
    Op.ROAD_HEADING: (1, 1),
    Op.ROAD_FOLLOW: (1, 1, 1),
    Op.LANE_ROUTE: (3,),
    Op.LANE_NEAREST: (3,),
}
"""How many consecutive registers each operand names."""
RESULTS: Mapping[Op, int] = {Op.PATH_POSE: 3, Op.REGION_SAMPLE: 2, Op.ROAD_FOLLOW: 3}
"""Numbers that an instruction gives, where more than one."""
