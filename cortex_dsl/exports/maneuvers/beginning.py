"""What expressions of a behaviour are worth at the instant at which a run begins."""

import math
from collections.abc import Iterator

from cortex_dsl import ir
from cortex_dsl.exports.maneuvers.numbers import VALUES, Case, UnsayableError, formula_of
from engine.interchange.openscenario.maneuvers.formula import Formula, number
from engine.road.network import Network
from engine.vocabulary import Column, Op, State

DYNAMIC = (Op.STATE, Op.TIME, Op.RANDOM, Op.WITHIN, Op.LEAD, Op.TTC, Op.IS_RUNNING)
"""Operations that ask the running simulation."""
AT_START = {State.X: Column.X, State.Y: Column.Y, State.HEADING: Column.HEADING, State.SPEED: Column.SPEED}


def value_at_start(case: Case, expression: ir.Expr) -> float:
    """A number that a behaviour remembers before it does anything.

    Raises:
        UnsayableError: only a simulator works it out.
    """
    if isinstance(expression, ir.Apply):
        found = _applied(case, expression)
        if found is not None:
            return found
    if isinstance(expression, ir.Item) and (part := _pose(case, expression)) is not None:
        return part
    return formula_of(case, expression).value(
        dict(zip(case.names, case.scenes.genomes[case.row].tolist(), strict=True))
    )


def settled(case: Case, expression: ir.Expr) -> Formula:
    """A formula over the params, or else the number that an expression has in this scene from its beginning to its end.

    Raises:
        UnsayableError: it depends on the running simulation, or only a simulator works it out.
    """
    try:
        return formula_of(case, expression)
    except UnsayableError:
        if any(each.op in DYNAMIC for each in _operations(expression)):
            raise
        return number(value_at_start(case, expression))


def _operations(expression: ir.Expr) -> Iterator[ir.Apply]:
    if isinstance(expression, ir.Apply):
        yield expression
    parts: tuple[ir.Expr, ...] = ()
    if isinstance(expression, ir.Apply):
        parts = expression.arguments
    elif isinstance(expression, ir.Pack):
        parts = expression.items
    elif isinstance(expression, ir.Item):
        parts = (expression.bundle,)
    for part in parts:
        yield from _operations(part)


def _pose(case: Case, expression: ir.Item) -> float | None:
    """A part of a pose on a path."""
    bundle = expression.bundle
    if not isinstance(bundle, ir.Apply) or bundle.op != Op.PATH_POSE:
        return None
    path, s = (value_at_start(case, each) for each in bundle.arguments)
    return case.whole.network.paths.pose(int(path), s)[expression.index]


def _applied(case: Case, expression: ir.Apply) -> float | None:
    """None where this is nothing that depends on the run."""
    if expression.op == Op.TIME:
        return 0.0
    if expression.op == Op.STATE:
        return _state(case, expression)
    if expression.op in (Op.LANE_NEAREST, Op.LANE_ROUTE) and isinstance(expression.arguments[0], ir.Pack):
        x, y, heading = (value_at_start(case, item) for item in expression.arguments[0].items)
        lane = nearest_lane(case.whole.network, x, y, heading)
        return float(lane if expression.op == Op.LANE_NEAREST else case.whole.network.lanes[lane].default_route)
    if expression.op == Op.TABLE:
        index = int(value_at_start(case, expression.arguments[0]))
        return case.whole.pool[expression.immediates[0] + index]
    if expression.op in VALUES:
        return float(VALUES[expression.op](*(value_at_start(case, each) for each in expression.arguments)))
    return None


def _state(case: Case, expression: ir.Apply) -> float:
    actor, column = expression.immediates
    if State(column) not in AT_START:
        raise UnsayableError("a state that it remembers", expression.span)
    return case.column(actor, AT_START[State(column)])


def nearest_lane(network: Network, x: float, y: float, heading: float) -> int:
    """The lane that an actor at a pose is on, as `engine.kernels.region.lane_nearest` has it."""

    def cost(lane: int) -> float:
        element = network.lanes[lane]
        away = network.paths.distance(element.path, x, y)
        if math.isnan(heading):
            return away
        along = network.paths.pose(element.path, network.paths.project(element.path, x, y)).heading
        return away + element.width * (1.0 - math.cos(along - heading))

    return min(range(len(network.lanes)), key=cost)
