"""The interpreter of pure code: Python's meaning for numbers, the road's own for geometry."""

import itertools
import math
import operator
import os

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from scipy import stats

from engine.kernels.evaluate import geometry_kernels, run_segment
from engine.kernels.geometry import Box, View, box_distance
from engine.kernels.jit import need
from engine.kernels.sight import OUTSIDE, SEEN
from engine.maps import RoadSpec
from engine.opcodes import Op
from engine.operators import OPERATORS
from engine.road import build_network, road_tables
from engine.vocabulary import ManeuverType
from tests.engine.kernels.sight_reference import Scene, agrees
from tests.laws import examples

REGISTERS = 24
numbers = st.floats(allow_nan=False, allow_infinity=False, width=32) | st.integers(-9, 9).map(float)
unit = st.floats(0.0, 1.0, exclude_max=True)
angles = st.floats(-7.0, 7.0)
near = st.floats(-60.0, 60.0)


@pytest.fixture(scope="module")
def network():
    return build_network(RoadSpec())


@pytest.fixture(scope="module")
def calculate(network):
    """A function that runs one instruction on registers 0.. = the given numbers and gives registers 12.. after it."""
    road = road_tables(network)
    pool = np.array([10.0, 20.0, 30.0, 40.0])

    def run(op: Op, *values: float, a: int = 0, b: int = 1, c: int = 2) -> np.ndarray:
        registers = np.zeros(REGISTERS)
        registers[: len(values)] = values
        code = np.array([[op, 12, a, b, c, 0], [Op.END, 0, 0, 0, 0, 0]], dtype=np.int32)
        need(*geometry_kernels(code))
        run_segment(code.ravel(), 0, 2, registers, pool, road)
        return registers[12:]

    return run


BINARY = {
    Op.ADD: operator.add,
    Op.SUB: operator.sub,
    Op.MUL: operator.mul,
    Op.DIV: operator.truediv,
    Op.MOD: operator.mod,
    Op.FLOORDIV: operator.floordiv,
    Op.MIN: min,
    Op.MAX: max,
    Op.ATAN2: math.atan2,
    Op.LT: operator.lt,
    Op.LE: operator.le,
    Op.EQ: operator.eq,
    Op.NE: operator.ne,
    Op.AND: lambda x, y: bool(x and y),
    Op.OR: lambda x, y: bool(x or y),
}
UNARY = {
    Op.MOVE: lambda x: x,
    Op.NEG: operator.neg,
    Op.ABS: abs,
    Op.SIN: math.sin,
    Op.COS: math.cos,
    Op.ATAN: math.atan,
    Op.FLOOR: math.floor,
    Op.CEIL: math.ceil,
    Op.ROUND: round,
    Op.NOT: operator.not_,
}


SPECIAL = [
    0.0,
    -0.0,
    0.5,
    -0.5,
    1.0,
    -1.0,
    2.5,
    -3.0,
    1e-300,
    1e8,
    1e300,
    math.pi,
    -math.pi,
    math.inf,
    -math.inf,
    math.nan,
]


@pytest.mark.parametrize("op", OPERATORS, ids=lambda op: op.name)
def test_the_value_of_a_row_is_that_of_the_kernel(calculate, op):
    """On random and on special numbers; bit for bit where the compiler folds constants."""
    row, rng = OPERATORS[op], np.random.default_rng(int(op))
    drawn = (rng.normal(0.0, 1.0, (500, row.arity)) * 10.0 ** rng.integers(-3, 4, (500, row.arity))).tolist()
    for operands in (*drawn, *itertools.product(SPECIAL, repeat=min(row.arity, 2))):
        operands = (*operands, 7.0)[: row.arity]
        value, computed = row.value(*operands), float(calculate(op, *operands)[0])
        if row.is_exact and not math.isnan(value):
            assert value.hex() == computed.hex(), operands
        assert value == pytest.approx(computed, rel=1e-13, abs=1e-300, nan_ok=True), operands


@pytest.mark.parametrize("op", BINARY)
@given(x=numbers, y=numbers)
def test_binary_operators_mean_what_python_means(calculate, op, x, y):
    """Bit for bit Python's result wherever Python has one."""
    assume(y != 0.0 or op not in (Op.DIV, Op.MOD, Op.FLOORDIV))
    assert calculate(op, x, y)[0] == float(BINARY[op](x, y))


@pytest.mark.parametrize("op", UNARY)
@given(x=numbers)
@example(x=2.5)
@example(x=-0.5)
@example(x=1e300)
def test_unary_operators_mean_what_python_means(calculate, op, x):
    """Rounding goes to even; floor and ceil hold for numbers beyond any integer type."""
    assert calculate(op, x)[0] == pytest.approx(float(UNARY[op](x)), rel=1e-15, abs=1e-300)


@pytest.mark.parametrize(
    ("op", "function", "domain"),
    [
        (Op.SQRT, math.sqrt, (0.0, 1e9)),
        (Op.TAN, math.tan, (-1.5, 1.5)),
        (Op.ASIN, math.asin, (-1.0, 1.0)),
        (Op.ACOS, math.acos, (-1.0, 1.0)),
        (Op.EXP, math.exp, (-50.0, 50.0)),
        (Op.LOG, math.log, (1e-9, 1e9)),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_functions(calculate, op, function, domain):
    """Functions of the mathematics library, over their domains."""
    low, high = domain
    for x in np.linspace(low, high, 101):
        assert calculate(op, x)[0] == pytest.approx(function(x), rel=1e-14, abs=1e-14)


@given(x=st.floats(0.01, 100.0), y=st.floats(-5.0, 5.0))
def test_power_and_hypotenuse(calculate, x, y):
    """`**` and `hypot`."""
    assert calculate(Op.POW, x, y)[0] == pytest.approx(x**y, rel=1e-14)
    assert calculate(Op.HYPOT, x, y)[0] == pytest.approx(math.hypot(x, y), rel=1e-15)


@pytest.mark.skipif(os.environ.get("NUMBA_DISABLE_JIT", "0") != "0", reason="plain Python does raise")
@pytest.mark.parametrize(
    ("op", "x", "y", "expected"),
    [
        (Op.DIV, 1.0, 0.0, math.inf),
        (Op.DIV, -1.0, 0.0, -math.inf),
        (Op.DIV, 0.0, 0.0, math.nan),
        (Op.FLOORDIV, 1.0, 0.0, math.inf),
        (Op.MOD, 1.0, 0.0, math.nan),
        (Op.SQRT, -1.0, 0.0, math.nan),
        (Op.LOG, 0.0, 0.0, -math.inf),
        (Op.LOG, -1.0, 0.0, math.nan),
        (Op.ASIN, 2.0, 0.0, math.nan),
        (Op.POW, -8.0, 0.5, math.nan),
        (Op.EXP, 1000.0, 0.0, math.inf),
        (Op.FLOOR, math.inf, 0.0, math.inf),
    ],
)
def test_nothing_raises(calculate, op, x, y, expected):
    """Where Python raises, the result is an infinity or NaN."""
    assert calculate(op, x, y)[0] == pytest.approx(expected, nan_ok=True)


@given(angle=st.floats(-1e6, 1e6))
@example(angle=math.pi)
@example(angle=-math.pi)
@example(angle=np.nextafter(-math.pi, -4.0))
@example(angle=np.nextafter(3 * math.pi, 0.0))
def test_wrap(calculate, angle):
    """The same direction, in [-pi, pi); an angle already there is not touched."""
    wrapped = calculate(Op.WRAP, angle)[0]
    assert -math.pi <= wrapped < math.pi
    assert math.cos(wrapped - angle) == pytest.approx(1.0, abs=1e-12)
    assert calculate(Op.WRAP, wrapped)[0] == wrapped


def test_select_and_table(calculate):
    """A conditional expression, and the options of a discrete choice, which no index can leave."""
    assert calculate(Op.SELECT, 1.0, 5.0, 7.0)[0] == 5.0
    assert calculate(Op.SELECT, 0.0, 5.0, 7.0)[0] == 7.0
    assert [calculate(Op.TABLE, index, a=1, b=0)[0] for index in (0.0, 2.9, 99.0, math.nan)] == [20.0, 40.0, 40.0, 10.0]


def test_normal_family(calculate):
    """Quantile and cumulative function of the standard normal distribution."""
    assert calculate(Op.NORMAL_QUANTILE, 0.975)[0] == pytest.approx(1.959963984540054, rel=1e-15)
    assert calculate(Op.NORMAL_CDF, 1.0)[0] == pytest.approx(0.8413447460685429, rel=1e-15)


@given(share=st.floats(-0.1, 1.1))
def test_path_operations(calculate, network, share):
    """Poses, lengths, projections and distances agree with the road's own."""
    turn = next(m for m in network.maneuvers if m.type is ManeuverType.LEFT_TURN)
    path = turn.connecting_lane.path
    s = share * network.paths.length(path)
    x, y, heading = calculate(Op.PATH_POSE, path, s)[:3]
    assert (x, y, heading) == pytest.approx(tuple(network.paths.pose(path, s)), abs=1e-12)
    assert calculate(Op.PATH_LENGTH, path)[0] == pytest.approx(network.paths.length(path))
    inside = min(max(s, 0.0), network.paths.length(path))
    assert calculate(Op.PATH_PROJECT, path, x, y)[0] == pytest.approx(inside, abs=1e-9)
    left_x, left_y = x - 2.0 * math.sin(heading), y + 2.0 * math.cos(heading)
    assert calculate(Op.PATH_DISTANCE, path, left_x, left_y)[0] == pytest.approx(2.0, abs=1e-9)


@given(x=near, y=near)
def test_region_operations(calculate, network, x, y):
    """Distance and containment agree with the road's own and with one another."""
    region = network.intersections[0].region
    inside, distance = (calculate(op, region, x, y)[0] for op in (Op.REGION_CONTAINS, Op.REGION_DISTANCE))
    assert inside == network.regions.contains(region, x, y)
    assert distance == pytest.approx(network.regions.distance(region, x, y), abs=1e-9)


def test_region_sample(calculate, network):
    """Points drawn from a region lie in it."""
    region = network.intersections[0].region
    for u, v in np.random.default_rng(1).random((200, 2)):
        x, y = calculate(Op.REGION_SAMPLE, region, u, v)[:2]
        assert network.regions.distance(region, x, y) == pytest.approx(0.0, abs=1e-9)


def test_outline_in_region(calculate, network):
    """A car fits into the junction and does not fit where it would stick out."""
    region = float(network.intersections[0].region)
    car = [0.0, 0.0, 0.3, 4.5, 1.8]
    assert calculate(Op.REGION_CONTAINS_BOX, region, *car)[0] == 1.0
    assert calculate(Op.REGION_CONTAINS_BOX, region, 8.5, *car[1:])[0] == 0.0


def test_distance_from_outline_to_region(calculate, network):
    """From the outline, where `REGION_DISTANCE` starts at a point."""
    region = float(network.intersections[0].region)
    away = calculate(Op.REGION_DISTANCE, region, 0.0, -20.0)[0]
    assert calculate(Op.REGION_BOX_DISTANCE, region, 0.0, -20.0, math.pi / 2, 4.0, 1.8)[0] == pytest.approx(away - 2.0)
    assert calculate(Op.REGION_BOX_DISTANCE, region, 0.0, -20.0 + away, 0.0, 4.0, 1.8)[0] == 0.0


@given(x=near, y=near, heading=angles)
def test_distance_between_outlines(calculate, x, y, heading):
    """Packed operands are x, y, heading, length, width."""
    first, second = (0.0, 0.0, 0.3, 4.5, 1.8), (x, y, heading, 12.0, 2.5)
    assert calculate(Op.BOX_DISTANCE, *first, *second, b=5)[0] == box_distance(Box(*first), Box(*second))


def can_see(calculate, viewer, outline):
    """With nobody in between: a view and -1, an outline, no outline that hides."""
    return calculate(Op.CAN_SEE, *viewer, -1.0, *outline, 0.0, b=6, c=11)[0]


@examples(300)
@given(
    viewer=st.tuples(near, near, angles, st.floats(0.1, 6.5), st.floats(1.0, 80.0)),
    outline=st.tuples(near, near, angles, st.just(4.5), st.just(1.8)),
)
def test_can_see(calculate, viewer, outline):
    """Seen is who has a part in the sector, by one ray in each interval of directions."""
    scene = Scene(View(*viewer), Box(*outline), [])
    assert agrees(SEEN if can_see(calculate, viewer, outline) else OUTSIDE, scene)


def test_can_see_what_surrounds_the_viewer(calculate):
    """The apex belongs to the sector, and a full circle has no blind spot."""
    assert can_see(calculate, (0, 0, 1.0, 0.1, 1.0), (0, 0, 0, 4.5, 1.8)) == 1.0
    assert can_see(calculate, (0, 0, 0.0, math.tau, 50.0), (-20, 0, 0, 4.5, 1.8)) == 1.0
    assert can_see(calculate, (0, 0, 0.0, math.pi, 50.0), (-20, 0, 0, 4.5, 1.8)) == 0.0


@given(share=st.floats(0.05, 0.9), offset=st.floats(-1.5, 1.5), by=st.floats(0.0, 40.0))
def test_following_the_road(calculate, network, share, offset, by):
    """The pose reached lies on the lane's default route as far on, at the same lateral offset."""
    lane = network.intersections[0].incoming_lanes[0]
    s = share * lane.length
    start, end = (network.paths.pose(lane.default_route, at) for at in (s, s + by))
    x, y = start[0] - offset * math.sin(start[2]), start[1] + offset * math.cos(start[2])
    expected = (end[0] - offset * math.sin(end[2]), end[1] + offset * math.cos(end[2]), end[2])
    assert tuple(calculate(Op.ROAD_FOLLOW, x, y, by)[:3]) == pytest.approx(expected, abs=1e-9)
    assert calculate(Op.ROAD_HEADING, x, y)[0] == pytest.approx(start[2])
    assert calculate(Op.LANE_ROUTE, x, y, start[2])[0] == lane.default_route
    assert network.lanes[int(calculate(Op.LANE_NEAREST, x, y, start[2])[0])].path == lane.path


def test_wide_results_and_segments(calculate, network):
    """A segment stops at its first END, and rows before it see one another's results."""
    road, registers = road_tables(network), np.array([2.0, 3.0, 0.0, 0.0])
    end = [Op.END, 0, 0, 0, 0, 0]
    rows = [[Op.MUL, 2, 0, 1, 0, 0], [Op.ADD, 3, 2, 2, 0, 0], end, [Op.MOVE, 3, 0, 0, 0, 0], end]
    run_segment(np.array(rows, dtype=np.int32).ravel(), 0, 5, registers, np.zeros(0), road)
    assert registers.tolist() == [2.0, 3.0, 6.0, 12.0]


def test_quantile_turns_uniform_into_normal(calculate):
    """Uniform numbers through the quantile pass a test of normality."""
    draws = [calculate(Op.NORMAL_QUANTILE, u)[0] for u in (np.arange(500) + 0.5) / 500]
    assert stats.kstest(draws, "norm").statistic < 0.002
