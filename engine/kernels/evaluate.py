"""The interpreter of pure code: one arithmetic or geometry instruction (`Op` below 60), or a segment of them.

A row is `(op, dst, a, b, c, d)`. Register files are float64 arrays; path and region ids travel as floats.
"""

import math

import numpy as np

from engine.kernels.geometry import Box, box_distance
from engine.kernels.inline import inlined
from engine.kernels.jit import kernel
from engine.kernels.path import path_distance, path_pose, path_project
from engine.kernels.region import (
    lane_nearest,
    region_box_distance,
    region_contains,
    region_contains_box,
    region_distance,
    region_sample,
)
from engine.kernels.scalar import arithmetic, comparison, distribution, function
from engine.kernels.view import View, sees
from engine.tables import Floats, Ints, RoadTables
from engine.vocabulary import Op


@inlined
def evaluate(op: int, dst: int, a: int, b: int, c: int, registers: Floats, pool: Floats, road: RoadTables) -> None:
    """Execute one instruction with `op` < 60 on the registers. Inlined into its caller: call it in one place."""
    if op >= Op.PATH_POSE:
        _geometry(op, dst, a, b, c, registers, road)
        return
    # An unsigned index spares numba's test for counting from the end.
    result, first, second, third = np.uintp(dst), np.uintp(a), np.uintp(b), np.uintp(c)
    if op == Op.TABLE:
        registers[result] = _option(pool, a, registers[second])
    elif op < Op.SQRT:
        registers[result] = arithmetic(op, registers[first], registers[second])
    elif op < Op.LT:
        registers[result] = function(op, registers[first], registers[second])
    elif op < Op.TABLE:
        registers[result] = comparison(op, registers[first], registers[second], registers[third])
    else:
        registers[result] = distribution(op, registers[first])


@kernel
def run_segment(code: Ints, start: int, end: int, registers: Floats, pool: Floats, road: RoadTables) -> None:
    """Execute rows `start` to `end` (exclusive) of pure code, up to the first `Op.END`."""
    execute(code, start, end, registers, pool, road)


@inlined
def execute(code: Ints, start: int, end: int, registers: Floats, pool: Floats, road: RoadTables) -> None:
    """`run_segment` for hot loops: copied into its caller."""
    for row in range(start, end):
        op = code[row, 0]
        if op == Op.END:
            return
        evaluate(op, code[row, 1], code[row, 2], code[row, 3], code[row, 4], registers, pool, road)


@kernel
def _option(pool: Floats, first: int, index: float) -> float:
    """Numeric option `index` of a discrete choice; held inside the pool, whatever the index became."""
    place = first + index
    if not place > 0.0:
        return pool[0]
    return pool[int(min(place, len(pool) - 1.0))]


@inlined
def _geometry(op: int, dst: int, a: int, b: int, c: int, registers: Floats, road: RoadTables) -> None:
    """`Op.PATH_POSE` to `Op.LANE_NEAREST`."""
    if op < Op.REGION_SAMPLE or op == Op.PATH_PROJECT:
        _path(op, dst, int(registers[a]), registers[b], registers[c], registers, road)
    elif op < Op.BOX_DISTANCE:
        _region(op, dst, int(registers[a]), b, registers[b], registers[c], registers, road)
    elif op == Op.BOX_DISTANCE:
        registers[dst] = box_distance(_box(registers, a), _box(registers, b))
    elif op == Op.REGION_BOX_DISTANCE:
        registers[dst] = region_box_distance(road, int(registers[a]), _box(registers, b))
    elif op == Op.CAN_SEE:
        view = View(registers[a], registers[a + 1], registers[a + 2], registers[a + 3], registers[a + 4])
        registers[dst] = 1.0 if sees(view, _box(registers, b)) else 0.0
    elif op == Op.LANE_ROUTE or op == Op.LANE_NEAREST:
        lane = lane_nearest(road, registers[a], registers[a + 1], registers[a + 2])
        registers[dst] = road.lane_route[lane] if op == Op.LANE_ROUTE else lane
    else:
        _along_road(op, dst, registers[a], registers[b], registers[c], registers, road)


@inlined
def _path(op: int, dst: int, path: int, y: float, z: float, registers: Floats, road: RoadTables) -> None:
    if op == Op.PATH_POSE:
        registers[dst], registers[dst + 1], registers[dst + 2] = path_pose(road, path, y)
    elif op == Op.PATH_LENGTH:
        registers[dst] = road.path_length[path]
    elif op == Op.PATH_DISTANCE:
        registers[dst] = path_distance(road, path, y, z)
    else:
        registers[dst] = path_project(road, path, y, z)


@inlined
def _region(op: int, dst: int, region: int, b: int, y: float, z: float, registers: Floats, road: RoadTables) -> None:
    if op == Op.REGION_DISTANCE:
        registers[dst] = region_distance(road, region, y, z)
    elif op == Op.REGION_SAMPLE:
        registers[dst], registers[dst + 1] = region_sample(road, region, y, z)
    elif op == Op.REGION_CONTAINS:
        registers[dst] = 1.0 if region_contains(road, region, y, z) else 0.0
    else:
        box = _box(registers, b)
        inside = region_contains_box(road, region, box.x, box.y, box.heading, box.length, box.width)
        registers[dst] = 1.0 if inside else 0.0


@kernel
def _along_road(op: int, dst: int, x: float, y: float, by: float, registers: Floats, road: RoadTables) -> None:
    """`Op.ROAD_HEADING`, and `Op.ROAD_FOLLOW` along the nearest lane's default route, which it does not leave."""
    lane = lane_nearest(road, x, y, math.nan)
    path = road.lane_path[lane]
    s = path_project(road, path, x, y)
    foot_x, foot_y, heading = path_pose(road, path, s)
    if op == Op.ROAD_HEADING:
        registers[dst] = heading
        return
    left = (y - foot_y) * math.cos(heading) - (x - foot_x) * math.sin(heading)
    end_x, end_y, heading = path_pose(road, road.lane_route[lane], s + by)
    registers[dst] = end_x - left * math.sin(heading)
    registers[dst + 1] = end_y + left * math.cos(heading)
    registers[dst + 2] = heading


@kernel
def _box(registers: Floats, first: int) -> Box:
    """The outline packed at `first`: x, y, heading, length, width."""
    return Box(registers[first], registers[first + 1], registers[first + 2], registers[first + 3], registers[first + 4])
