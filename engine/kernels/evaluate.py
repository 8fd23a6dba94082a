"""The interpreter of pure code, one instruction (`Op` below 60) or a segment of them.

A row is `(op, dst, a, b, c, d)`; code is one array of all rows. Register files are float64 arrays; path and region ids
travel as floats.

The scalar instructions are the rows of `engine.operators`: numbers in, number out, Python's meaning. Nothing raises:
dividing by zero gives an infinity or NaN, the root of a negative number NaN.
"""

import math
from collections.abc import Callable, Mapping

import numpy as np

from engine.kernels.geometry import Box, View, box_distance
from engine.kernels.jit import deferred, inlined, kernel
from engine.kernels.nearest_lane import lane_nearest
from engine.kernels.path import path_distance, path_pose, path_project
from engine.kernels.random_numbers import normal_quantile
from engine.kernels.region import (
    region_box_depth,
    region_box_distance,
    region_contains,
    region_contains_box,
    region_depth,
    region_distance,
    region_sample,
)
from engine.kernels.sight import SEEN, Shades, look
from engine.kernels.switch import Scalar, switch
from engine.opcodes import ROW_WIDTH, Op
from engine.operators import OPERATORS
from engine.tables import Floats, Ints, RoadTables

# -- scalar instructions -----------------------------------------------------------------------------------------------

SCALARS: Mapping[Op, Scalar] = {
    **{op: inlined(row.scalar) for op, row in OPERATORS.items()},
    Op.NORMAL_QUANTILE: normal_quantile,
}
wrap_angle = SCALARS[Op.WRAP]
scalar = switch(SCALARS, {op: row.arity for op, row in OPERATORS.items()})
"""Function (op, x, y, z) that executes a scalar instruction."""


# -- the interpreter ---------------------------------------------------------------------------------------------------


@inlined
def operand(code: Ints, row: int, number: int) -> int:
    """Return a number of a row of code; 0 to 5: op, dst, a, b, c, d.

    An unsigned index spares numba's test for counting from the end.
    """
    return int(code[np.uintp(row * ROW_WIDTH + number)])


@inlined
def evaluate(code: Ints, row: int, registers: Floats, pool: Floats, road: RoadTables) -> None:
    """Execute one row of code with `op` < 60 on the registers. Inlined into its caller: call it in one place."""
    op, dst, a, b = operand(code, row, 0), operand(code, row, 1), operand(code, row, 2), operand(code, row, 3)
    c = operand(code, row, 4)
    if op >= Op.PATH_POSE:
        _geometry(op, dst, a, b, c, registers, road)
        return
    result, first, second, third = np.uintp(dst), np.uintp(a), np.uintp(b), np.uintp(c)
    if op == Op.TABLE:
        registers[result] = _option(pool, a, registers[second])
    else:
        registers[result] = scalar(op, registers[first], registers[second], registers[third])


@kernel
def run_segment(code: Ints, start: int, end: int, registers: Floats, pool: Floats, road: RoadTables) -> None:
    """Execute rows `start` to `end` (exclusive) of pure code, up to the first `Op.END`."""
    execute(code, start, end, registers, pool, road)


@inlined
def execute(code: Ints, start: int, end: int, registers: Floats, pool: Floats, road: RoadTables) -> None:
    """Execute rows as `run_segment` does, for hot loops: copied into its caller."""
    for row in range(start, end):
        if operand(code, row, 0) == Op.END:
            return
        evaluate(code, row, registers, pool, road)


@kernel
def _option(pool: Floats, first: int, index: float) -> float:
    """Return numeric option `index` of a discrete choice; limited to the pool for any index."""
    place = first + index
    if not place > 0.0:
        return pool[0]
    return pool[int(min(place, len(pool) - 1.0))]


@inlined
def _geometry(op: int, dst: int, a: int, b: int, c: int, registers: Floats, road: RoadTables) -> None:
    """Execute `Op.PATH_POSE` to `Op.REGION_BOX_DEPTH`. For a NaN position all results are NaN except the nearest lane.

    The two most frequent ones are executed here. The others are families of functions, compiled for programs that use
    them.
    """
    if op == Op.PATH_POSE:
        x, y, heading = path_pose(road, int(registers[a]), registers[b])
        registers[dst], registers[dst + 1] = x, y
        registers[dst + 2] = math.nan if math.isnan(registers[b]) else heading
    elif op == Op.REGION_DISTANCE:
        distance = region_distance(road, int(registers[a]), registers[b], registers[c])
        registers[dst] = math.nan if math.isnan(registers[b]) or math.isnan(registers[c]) else distance
    elif op == Op.PATH_LENGTH or op == Op.PATH_DISTANCE or op == Op.PATH_PROJECT:
        path_instruction(op, dst, a, b, c, registers, road)
    elif op == Op.REGION_CONTAINS or op == Op.REGION_DEPTH or op == Op.REGION_SAMPLE:
        place_instruction(op, dst, a, b, c, registers, road)
    elif op == Op.CAN_SEE:
        sight_instruction(dst, a, b, c, registers, road)
    elif op == Op.LANE_ROUTE or op == Op.LANE_NEAREST or op == Op.ROAD_HEADING or op == Op.ROAD_FOLLOW:
        lane_instruction(op, dst, a, b, c, registers, road)
    else:
        outline_instruction(op, dst, a, b, registers, road)


@deferred()
def path_instruction(op: int, dst: int, a: int, b: int, c: int, registers: Floats, road: RoadTables) -> None:
    """Execute `Op.PATH_LENGTH`, `PATH_DISTANCE` or `PATH_PROJECT`."""
    path, y, z = int(registers[a]), registers[b], registers[c]
    if op == Op.PATH_LENGTH:
        registers[dst] = road.path_length[path]
    elif math.isnan(y) or math.isnan(z):
        registers[dst] = math.nan
    elif op == Op.PATH_DISTANCE:
        registers[dst] = path_distance(road, path, y, z)
    else:
        registers[dst] = path_project(road, path, y, z)


@deferred()
def place_instruction(op: int, dst: int, a: int, b: int, c: int, registers: Floats, road: RoadTables) -> None:
    """Execute `Op.REGION_SAMPLE`, `REGION_DEPTH` or `REGION_CONTAINS`: points and regions."""
    region, y, z = int(registers[a]), registers[b], registers[c]
    if op == Op.REGION_SAMPLE:
        registers[dst], registers[dst + 1] = region_sample(road, region, y, z)
    elif math.isnan(y) or math.isnan(z):
        registers[dst] = math.nan
    elif op == Op.REGION_DEPTH:
        registers[dst] = region_depth(road, region, y, z)
    else:
        registers[dst] = 1.0 if region_contains(road, region, y, z) else 0.0


@deferred()
def outline_instruction(op: int, dst: int, a: int, b: int, registers: Floats, road: RoadTables) -> None:
    """Execute `Op.BOX_DISTANCE`, `REGION_CONTAINS_BOX`, `REGION_BOX_DISTANCE` or `REGION_BOX_DEPTH`."""
    if has_nan(registers, b, 5) or (op == Op.BOX_DISTANCE and has_nan(registers, a, 5)):
        registers[dst] = math.nan
    elif op == Op.REGION_BOX_DEPTH:
        registers[dst] = region_box_depth(road, int(registers[a]), _box(registers, b))
    elif op == Op.BOX_DISTANCE:
        registers[dst] = box_distance(_box(registers, a), _box(registers, b))
    elif op == Op.REGION_BOX_DISTANCE:
        registers[dst] = region_box_distance(road, int(registers[a]), _box(registers, b))
    else:
        registers[dst] = 1.0 if region_contains_box(road, int(registers[a]), _box(registers, b)) else 0.0


@deferred()
def sight_instruction(dst: int, a: int, b: int, c: int, registers: Floats, road: RoadTables) -> None:
    """Execute `Op.CAN_SEE`."""
    if has_nan(registers, a, 5) or has_nan(registers, b, 5):
        registers[dst] = math.nan
        return
    view = View(registers[a], registers[a + 1], registers[a + 2], registers[a + 3], registers[a + 4])
    shades = Shades(registers, c + 1, int(registers[c]), int(registers[a + 5]), -1)
    verdict = look(view, _box(registers, b), shades, road.buildings)
    registers[dst] = 1.0 if verdict == SEEN else 0.0


@deferred()
def lane_instruction(op: int, dst: int, a: int, b: int, c: int, registers: Floats, road: RoadTables) -> None:
    """Execute `Op.LANE_ROUTE`, `LANE_NEAREST`, `ROAD_HEADING` or `ROAD_FOLLOW`.

    The last follows the default route of the nearest lane, and not beyond its ends.
    """
    if op == Op.LANE_ROUTE or op == Op.LANE_NEAREST:
        lane = lane_nearest(road, registers[a], registers[a + 1], registers[a + 2])
        registers[dst] = road.lane_route[lane] if op == Op.LANE_ROUTE else lane
        return
    x, y, by = registers[a], registers[b], registers[c]
    lane = lane_nearest(road, x, y, math.nan)
    path = road.lane_path[lane]
    s = path_project(road, path, x, y)
    foot_x, foot_y, heading = path_pose(road, path, s)
    if op == Op.ROAD_HEADING:
        registers[dst] = math.nan if math.isnan(x) or math.isnan(y) else heading
        return
    left = (y - foot_y) * math.cos(heading) - (x - foot_x) * math.sin(heading)
    end_x, end_y, heading = path_pose(road, road.lane_route[lane], s + by)
    registers[dst] = end_x - left * math.sin(heading)
    registers[dst + 1] = end_y + left * math.cos(heading)
    registers[dst + 2] = math.nan if math.isnan(x) or math.isnan(y) or math.isnan(by) else heading


@inlined
def has_nan(registers: Floats, first: int, count: int) -> bool:
    """Return True if one of `count` registers from `first` on is NaN."""
    found = False
    for register in range(first, first + count):
        found |= math.isnan(registers[register])
    return found


@inlined
def _box(registers: Floats, first: int) -> Box:
    """Return the outline packed at `first`: x, y, heading, length, width."""
    return Box(registers[first], registers[first + 1], registers[first + 2], registers[first + 3], registers[first + 4])


DEFERRED: dict[Op, Callable[..., None]] = {
    Op.PATH_LENGTH: path_instruction,
    Op.PATH_DISTANCE: path_instruction,
    Op.PATH_PROJECT: path_instruction,
    Op.REGION_SAMPLE: place_instruction,
    Op.REGION_CONTAINS: place_instruction,
    Op.REGION_DEPTH: place_instruction,
    Op.BOX_DISTANCE: outline_instruction,
    Op.REGION_CONTAINS_BOX: outline_instruction,
    Op.REGION_BOX_DISTANCE: outline_instruction,
    Op.REGION_BOX_DEPTH: outline_instruction,
    Op.CAN_SEE: sight_instruction,
    Op.LANE_ROUTE: lane_instruction,
    Op.LANE_NEAREST: lane_instruction,
    Op.ROAD_HEADING: lane_instruction,
    Op.ROAD_FOLLOW: lane_instruction,
}
"""The kernel of each instruction of geometry that `_geometry` does not execute itself."""


def geometry_kernels(code: Ints) -> set[Callable[..., None]]:
    """Return the deferred kernels that rows of code (n, 6) need."""
    return {DEFERRED[op] for op in set(code[:, 0].tolist()) & DEFERRED.keys()}
