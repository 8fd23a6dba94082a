"""Expressions of a scenario as formulas over its params, with all other values as in one scene.

Expressions of a behaviour take their values at the start of a run.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial

from cortex_dsl import ir
from cortex_dsl.api.scenario import Scenario
from cortex_dsl.lowering.code_tables import group_variants
from cortex_dsl.semantics.quantities.bounds import is_dynamic
from cortex_dsl.source import Span
from engine.errors import Signal
from engine.interchange.openscenario.document import unique_names
from engine.interchange.openscenario.maneuvers import formula
from engine.interchange.openscenario.maneuvers.formula import Formula, number
from engine.interchange.openscenario.maneuvers.maneuver_plan import Parameter
from engine.opcodes import Op
from engine.operators import OPERATORS
from engine.road.network import Network
from engine.scenes import Scenes, actor_columns
from engine.tables import Floats
from engine.vocabulary import Column, Distribution, GeneKind, State

SAID: Mapping[Op, Callable[..., Formula]] = {
    Op.MOVE: lambda a: a,
    Op.ADD: formula.add,
    Op.SUB: formula.subtract,
    Op.MUL: formula.multiply,
    Op.DIV: formula.divide,
    Op.NEG: lambda a: formula.subtract(formula.ZERO, a),
    Op.MIN: formula.least,
    Op.MAX: formula.most,
    Op.ABS: lambda a: formula.most(a, formula.subtract(formula.ZERO, a)),
    **{op: partial(formula.applied, row.formula) for op, row in OPERATORS.items() if row.formula},
}
"""Operations of OpenSCENARIO's expressions; any other operation on sampled or chosen values is evaluated here."""


class UnsayableError(Signal):
    """A part of a scenario that OpenSCENARIO cannot express, and its place."""

    def __init__(self, what: str, span: Span) -> None:
        super().__init__(what)
        self.what = what
        self.span = span


@dataclass(frozen=True)
class Case:
    """One scene of a scenario: its variant, and its sampled values."""

    scenario: Scenario
    scenes: Scenes
    row: int = 0
    remembered: Mapping[int, Formula] = field(default_factory=dict)
    """Numbers that the behaviour being read remembers from its beginning on, by local."""

    @property
    def whole(self) -> ir.Scenario:
        return self.scenario.compiled.scenario

    @cached_property
    def variant(self) -> ir.Variant:
        return group_variants(self.whole).variants[int(self.scenes.variant[self.row])]

    @property
    def actors(self) -> Sequence[ir.Actor]:
        return self.variant.actors

    @cached_property
    def columns(self) -> Floats:
        """Return the columns (actors, len(Column)) of this scene."""
        return actor_columns(self.scenario.program, self.scenes.values[self.row])

    @property
    def may_hide(self) -> bool:
        """Return whether an actor may be hidden by another actor or by a building."""
        third = len(self.columns) > 2 and bool(self.columns[:, Column.OCCLUDING].any())
        return third or len(self.scenario.program.road.buildings) > 0

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Return unique names of the params that other formats accept."""
        return unique_names(gene.name for gene in self.whole.genes)

    @cached_property
    def known(self) -> Mapping[int, float]:
        """Properties of the actors in this scene, by the identity of their expression."""
        table = self.columns.tolist()
        pairs = ((id(actor.columns[c]), table[i][c]) for i, actor in enumerate(self.actors) for c in Column)
        return dict(pairs)

    def place(self, span: Span) -> str:
        """`line 12`, or with the name of an imported file."""
        return f"line {self.scenario.program.place(self.whole.source.row(span.start))}"

    def column(self, actor: int, column: Column) -> float:
        return float(self.columns[actor, column])


def formula_of(case: Case, expression: ir.Expr) -> Formula:
    """Return an expression as a formula over the params.

    Raises:
        UnsayableError: it depends on the running simulation, or on a value that only a simulator computes.
    """
    if isinstance(expression, ir.Literal):
        return formula.number(expression.value)
    if isinstance(expression, ir.Gene):
        return _gene(case, expression.index)
    if isinstance(expression, ir.Draw):
        return formula.number(float(case.scenes.draws[case.row, expression.index]))
    if isinstance(expression, ir.Local) and expression.index in case.remembered:
        return case.remembered[expression.index]
    if isinstance(expression, ir.Apply) and (said := _applied(case, expression)) is not None:
        return said
    if id(expression) in case.known:
        return formula.number(case.known[id(expression)])
    raise UnsayableError(_words(expression), expression.span)


def _gene(case: Case, index: int) -> Formula:
    gene = case.whole.genes[index]
    if gene.kind == GeneKind.INDEX:
        return formula.number(float(case.scenes.genomes[case.row, index]))
    return formula.scaled(formula.parameter(case.names[index]), gene.scale)


def _applied(case: Case, expression: ir.Apply) -> Formula | None:
    """None where this is no arithmetic; then it may still be known of the scene."""
    if expression.op == Op.TABLE:
        index = formula_of(case, expression.arguments[0])
        return formula.number(case.whole.pool[expression.immediates[0] + int(index.number)]) if index.plain else None
    if expression.op not in OPERATORS:
        return None
    operands = [formula_of(case, argument) for argument in expression.arguments]
    if all(operand.plain for operand in operands):
        return formula.number(OPERATORS[expression.op].value(*(operand.number for operand in operands)))
    return SAID[expression.op](*operands) if expression.op in SAID else None


def _words(expression: ir.Expr) -> str:
    if isinstance(expression, ir.Local):
        return "a number that it remembers"
    if isinstance(expression, ir.Running):
        return "whether a monitor runs"
    if isinstance(expression, ir.Apply):
        return WORDS.get(expression.op, f"the operation {expression.op.name.lower()}")
    return _words(expression.bundle) if isinstance(expression, ir.Item) else "several numbers at once"


WORDS: Mapping[Op, str] = {
    Op.ACTION: "what a controller decides",
    Op.RANDOM: "a number drawn while it runs",
    Op.STATE: "the state of an actor in a calculation",
    Op.VELOCITY: "the state of an actor in a calculation",
    Op.LEAD: "the gap to the actor ahead",
    Op.CROSSING: "where its way crosses another's",
    Op.SELECT: "a choice between two numbers",
    Op.CAN_SEE: "`can see`",
    Op.SEES: "`can see`",
    Op.NOTICES: "whether another actor is hidden",
    Op.WITHIN: "`withinDistanceToAnyObjs` in a calculation",
    Op.TTC: "a time to collision in a calculation",
    Op.PATH_PROJECT: "a place along a lane",
    Op.LANE_NEAREST: "the lane it happens to be on",
    Op.BOX_DISTANCE: "the gap between two outlines",
    Op.REGION_CONTAINS: "whether it is in a region",
    Op.PATH_POSE: "a pose on a path",
    Op.REGION_SAMPLE: "a point that is drawn from a region",
    Op.ROAD_FOLLOW: "a pose further along the road",
    Op.REGION_DISTANCE: "its distance from a region",
}


def varied_params(case: Case) -> Iterator[Parameter]:
    """The params that a search chooses, as parameters of the file: value in this scene, range and law."""
    for index, (gene, name) in enumerate(zip(case.whole.genes, case.names, strict=True)):
        if gene.kind == GeneKind.INDEX:
            continue
        value = float(case.scenes.genomes[case.row, index])
        bell = gene.distribution in (Distribution.NORMAL, Distribution.TRUNCATED_NORMAL)
        normal = (gene.mean, gene.deviation) if bell else None
        yield Parameter(name, value, gene.low, gene.high, normal, gene.kind == GeneKind.INTEGER, unit=gene.unit)


# -- at the instant at which a run begins ------------------------------------------------------------------------------

AT_START = {State.X: Column.X, State.Y: Column.Y, State.HEADING: Column.HEADING, State.SPEED: Column.SPEED}


def value_at_start(case: Case, expression: ir.Expr) -> float:
    """A number that a behaviour remembers before it does anything.

    Raises:
        UnsayableError: only a simulator works it out.
    """
    if isinstance(expression, ir.Apply):
        found = _settled_call(case, expression)
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
        if is_dynamic(expression):
            raise
        return number(value_at_start(case, expression))


def _pose(case: Case, expression: ir.Item) -> float | None:
    """A part of a pose on a path."""
    bundle = expression.bundle
    if not isinstance(bundle, ir.Apply) or bundle.op != Op.PATH_POSE:
        return None
    path, s = (value_at_start(case, each) for each in bundle.arguments)
    return case.whole.network.paths.pose(int(path), s)[expression.index]


def _settled_call(case: Case, expression: ir.Apply) -> float | None:
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
    if expression.op in OPERATORS:
        return OPERATORS[expression.op].value(*(value_at_start(case, each) for each in expression.arguments))
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
