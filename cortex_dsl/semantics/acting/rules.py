"""Requirements on the start and on the run, and `record`.

Temporal requirements are `always`, `eventually`, `next`, `until` and `implies` over the samples of a run. A condition
on one moment becomes an atom, evaluated in every sample; the rest is the same formula in all variants. `require always
c` is evaluated in every sample itself, so that it ends the run at once. Records are stored values of the running
simulation, each a column of numbers.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import reduce
from typing import NamedTuple

from cortex_dsl import ir
from cortex_dsl.diagnostics import Label
from cortex_dsl.semantics.errors.names import (
    ALWAYS_FALSE,
    DUPLICATE,
    NEVER_CHANGES,
    NO_END,
    RECORD_VARIES,
    SOFT_TEMPORAL,
    TEMPORAL_HOLDS,
    UNRECORDABLE,
)
from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.evaluation import numbers, seeing
from cortex_dsl.semantics.evaluation.numbers import ROUNDING
from cortex_dsl.semantics.evaluation.random_values import DISTRIBUTIONS
from cortex_dsl.semantics.evaluation.ranges import at_most, inside, require
from cortex_dsl.semantics.model.context import SCENE, Evaluator
from cortex_dsl.semantics.model.state import FileContext, FileFacts, RuleKey
from cortex_dsl.semantics.model.values import Actor, Pose, Quantity, Truth, Value, Vector
from cortex_dsl.semantics.model.wording import kind_name, spoken_unit
from cortex_dsl.semantics.names.properties import ENVIRONMENT, PROPERTIES
from cortex_dsl.semantics.names.tree import always_condition, atoms, everything_in, is_timed, subformulas
from cortex_dsl.semantics.quantities.algebra import Operation, Term, where
from cortex_dsl.semantics.quantities.bounds import folded, interval, is_dynamic, margin_of, truth_of
from cortex_dsl.semantics.quantities.units import ANGLE, LENGTH, PURE, dimension_name
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes
from engine.config import SimulationConfig
from engine.opcodes import Op
from engine.vocabulary import RuleKind, State, TemporalOp

# -- requirements on the start of a run, by rules and domains ----------------------------------------------------------


SUFFIX = " (at the start)"


class _Said(NamedTuple):
    """Of a part of a formula at sample 0."""

    may_hold: Term
    holds: Term


def require_start(ev: Evaluator, node: nodes.Require, name: str) -> None:
    """Require that a temporal requirement, after evaluation of its atoms, may still hold at the start of the scene."""
    try:
        condition = _Start(ev).of(node.condition).may_hold
    except Mistake:  # a chain of operations as long as there may be: the run decides
        return
    if ev.truth_of(condition)[0] > 0.0:
        return
    margin = margin_of(condition, ev.run.compared)
    unit = spoken_unit(node.condition, condition, margin[1], ev.file.genes.infos)
    required = ir.Requirement(condition, 1.0, name + SUFFIX, ev.facts.line(node.span), *margin, unit)
    ev.run.built.requirements.append(required)


class _Start:
    """Formulas at the first sample of the run."""

    def __init__(self, ev: Evaluator) -> None:
        self.ev = ev
        self.true, self.false = ev.algebra.truth(True), ev.algebra.truth(False)
        self.unknown = _Said(self.true, self.false)
        self.actors = {actor.index: actor for actor in ev.run.built.actors}
        self.states = {index: _states(ev, actor) for index, actor in self.actors.items()}

    def of(self, node: nodes.Expression) -> _Said:
        if not is_timed(node):
            key: RuleKey = (node.span, RuleKind.WATCH)
            return self._condition(self.ev.run.built.rule_conditions[key])
        operator = node.operator if isinstance(node, nodes.Temporal | nodes.BoolOp) else "not"
        first, *others = [self.of(part) for part in subformulas(node)]
        match operator:
            case "not":
                return _Said(~first.holds, ~first.may_hold)
            case "always":
                return _Said(first.may_hold, self.false)
            case "eventually":
                return _Said(self.true, first.holds)
            case "next":
                return self.unknown
            case "until":
                return _Said(first.may_hold | others[0].may_hold, others[0].holds)
            case "implies":
                return _Said(~first.holds | others[0].may_hold, ~first.may_hold | others[0].holds)
        for other in others:
            first = _and(first, other) if operator == "and" else _or(first, other)
        return first

    def _condition(self, condition: Term) -> _Said:
        """Return the truth values of an atom, or of a logical combination."""
        match condition:
            case Operation(op=Op.AND, arguments=(one, other)):
                return _and(self._condition(one), self._condition(other))
            case Operation(op=Op.OR, arguments=(one, other)):
                return _or(self._condition(one), self._condition(other))
            case Operation(op=Op.NOT, arguments=(inner,)):
                said = self._condition(inner)
                return _Said(~said.holds, ~said.may_hold)
        known = folded(condition, self._worth)
        return self.unknown if known is None else _Said(known, known)

    def _worth(self, part: ir.Expr, operands: list[Term | None]) -> Term | None:
        """An expression at the start; None where the scene does not decide."""
        assert isinstance(part, Term)
        if isinstance(part, ir.Local) and part.index in self.ev.run.built.zeroed:
            return self.ev.algebra.literal(0.0)
        if isinstance(part, ir.Local | ir.Running) or None in operands:
            return None
        known = [operand for operand in operands if operand is not None]
        make = self.ev.algebra.apply
        match part:
            case Operation(op=Op.STATE, immediates=(actor, column)):
                return self.states[actor].get(State(column))
            case Operation(op=Op.TIME):
                return self.ev.algebra.literal(0.0)
            case Operation(op=Op.SEES, immediates=(one, other)) if one >= 0 <= other and all(
                map(_is_here, self.actors.values())
            ):
                return seeing.sees(self.ev.at_moment(SCENE), self.actors[one], self.actors[other])
            case Operation(op=op) if op > Op.STATE:
                return None
            case Operation(op=op, immediates=immediates, width=width):
                made = make(op, *known, immediates=immediates, width=width)
                self._compare(part, made)
                return made
            case ir.Pack():
                return self.ev.algebra.pack(*known)
            case ir.Item(index=index):
                return self.ev.algebra.items(known[0], index + 1)[index]
        return part

    def _compare(self, part: Term, made: Term) -> None:
        """Copy the dimension of a compared part to the comparison that replaces it."""
        if part in self.ev.run.compared:
            self.ev.run.compared.setdefault(made, self.ev.run.compared[part])


def _and(one: _Said, other: _Said) -> _Said:
    return _Said(one.may_hold & other.may_hold, one.holds & other.holds)


def _or(one: _Said, other: _Said) -> _Said:
    return _Said(one.may_hold | other.may_hold, one.holds | other.holds)


def _states(ev: Evaluator, actor: Actor) -> dict[State, Term]:
    """Return the state values of an actor at sample 0."""
    speed = actor.properties["speed"]
    assert isinstance(speed, Term)
    still = dict.fromkeys((State.STEER, State.ACCELERATION, State.THROTTLE, State.BRAKE), ev.algebra.literal(0.0))
    pose = {State.X: actor.pose.x, State.Y: actor.pose.y, State.HEADING: actor.pose.heading}
    return {**still, **pose, State.SPEED: speed, State.PRESENT: ev.algebra.truth(_is_here(actor))}


def _is_here(actor: Actor) -> bool:
    """Return whether an actor is present from the start."""
    return actor.present


# -- domains of random values ------------------------------------------------------------------------------------------


def require_domains(ev: Evaluator, actors: Iterable[Actor]) -> None:
    """Require of the scene that unbounded values lie in their domain."""
    found = [*_of_environment(ev)]
    for actor in actors:
        found.extend(_of_actor(ev, actor))
    for condition, what, span in found:
        require(ev, condition, f"{what} within its domain", span)


_Found = tuple[Term, str, Span]


def _of_environment(ev: Evaluator) -> Iterator[_Found]:
    if (environment := ev.run.built.environment) is not None:
        for name, value in environment.values.items():
            if (condition := inside(ev, value, ENVIRONMENT[name])) is not None:
                yield condition, f"{name} of the environment", environment.span


def _of_actor(ev: Evaluator, actor: Actor) -> Iterator[_Found]:
    for name, spec in PROPERTIES.items():
        value = actor.properties[name]
        assert isinstance(value, Term)
        condition = inside(ev, value, spec)
        if name == "speed":
            condition = _below_top(ev, actor, value, condition)
        if condition is not None:
            yield condition, f"{name} of {actor.name}", actor.span


def _below_top(ev: Evaluator, actor: Actor, speed: Term, condition: Term | None) -> Term | None:
    """Add the top speed to a condition if it may be less: it is random, or another scenario overrides it."""
    top = actor.properties["topSpeed"]
    assert isinstance(top, Term)
    if ev.interval(speed)[1] <= ev.interval(top)[0] * (1.0 + ROUNDING):
        return condition
    return at_most(speed, top) if condition is None else condition & at_most(speed, top)


# -- records -----------------------------------------------------------------------------------------------------------

Column = tuple[str, Term, ir.Dimension]
"""Suffix of the record's name, the number, and its dimension."""


def keep_record(ev: Evaluator, node: nodes.Record, going: Term | None = None) -> None:
    """A record, at a running moment; `going`: while this holds, such as that a scenario runs.

    Each scenario that runs the same statement adds the values of its own time.
    """
    name = node.name or f"{node.when} {ev.facts.source.words(node.value.span)}".lstrip()
    conditions, during, earlier = ev.run.built.rule_conditions, -1, None
    if going is not None:
        key = Span(node.span.start, node.span.start), RuleKind.WATCH
        during, earlier = ev.file.run.rule(key[0], f"{name}: while it is recorded", key[1]), conditions.get(key)
        conditions[key] = going if earlier is None else earlier | going
    for i, (suffix, value, dimension) in enumerate(_columns(ev.evaluate(node.value), node.value.span)):
        # Rules are known by their places: each column of one value gets a place of its own.
        place = Span(node.value.span.start, node.value.span.start + i)
        watch = ev.file.run.rule(place, name + suffix, RuleKind.WATCH)
        before = conditions.get((place, RuleKind.WATCH))
        if going is None or earlier is None or before is None:
            conditions[place, RuleKind.WATCH] = value
        else:
            conditions[place, RuleKind.WATCH] = where(going, value, before)
        made = ir.Record(name + suffix, node.when or "series", watch, dimension, ev.facts.line(node.span), during)
        _keep_column(ev, node, made)


def _keep_column(ev: Evaluator, node: nodes.Record, made: ir.Record) -> None:
    """Declare the column, which is the same in all variants, and refuse a second one of its name.

    Raises:
        Mistake: another record has the name.
    """
    first, known = ev.file.run.records.setdefault(made.name, (node.span, made))
    if known.watch != made.watch:
        where = (Label(first, "first here"),)
        raise DUPLICATE.mistake(node.span, secondary=where, what="the record", name=made.name)
    if known.dimension != made.dimension:
        here, there = dimension_name(known.dimension), dimension_name(made.dimension)
        raise RECORD_VARIES.mistake(node.value.span, here=here, there=there)


def _columns(value: Value, span: Span) -> Iterator[Column]:
    match value:
        case Quantity(expr, dimension):
            yield "", expr, dimension or PURE
        case Truth(expr):
            yield "", expr, PURE
        case Vector(x, y):
            yield from ((".x", x, LENGTH), (".y", y, LENGTH))
        case Pose(x, y, heading):
            yield from ((".x", x, LENGTH), (".y", y, LENGTH), (".heading", heading, ANGLE))
        case Actor():
            cure = "record one of its numbers: `.position`, `.speed`, `.heading`"
            raise UNRECORDABLE.mistake(span, actual=kind_name(value), cure=cure)
        case tuple():
            raise UNRECORDABLE.mistake(span, actual="a list", cure="write one `record` for each item")
        case _:
            raise UNRECORDABLE.mistake(span, actual=kind_name(value), cure="record a number that it decides")


# -- temporal requirements ---------------------------------------------------------------------------------------------

OPERATORS: Mapping[str, TemporalOp] = {
    "always": TemporalOp.ALWAYS,
    "eventually": TemporalOp.EVENTUALLY,
    "next": TemporalOp.NEXT,
    "until": TemporalOp.UNTIL,
    "implies": TemporalOp.IMPLIES,
    "and": TemporalOp.AND,
    "or": TemporalOp.OR,
    "not": TemporalOp.NOT,
}


def require_over_run(ev: Evaluator, node: nodes.Require) -> None:
    """A temporal requirement, at a running moment: the conditions of its atoms."""
    if node.probability is not None:
        raise SOFT_TEMPORAL.mistake(node.probability.span)
    conditions = ev.run.built.rule_conditions
    for atom in atoms(node.condition):
        conditions[atom.span, RuleKind.WATCH] = numbers.truth(ev, ev.evaluate(atom), atom.span)
    ev.file.run.temporals[node.span] = node
    require_start(ev, node, name_of(ev.facts, node))
    if (condition := always_condition(node.condition)) is not None:
        broken = ~conditions.pop((condition.span, RuleKind.WATCH))
        conditions[node.span, RuleKind.ABORT] = broken
        ev.file.run.rule(node.span, name_of(ev.facts, node), RuleKind.ABORT)


def name_of(facts: FileFacts, node: nodes.Require) -> str:
    return node.name or facts.source.words(node.condition.span)


# -- all variants together --------------------------------------------------------------------------------------------

Conditions = Sequence[Mapping[RuleKey, Term]]
"""Conditions of the rules, one mapping per variant."""


def temporal_requirements(file: FileContext, conditions: Conditions, *, has_end: bool) -> tuple[ir.Temporal, ...]:
    """The temporal requirements that are judged when the run is over; reports those that decide nothing.

    `has_end` says that the file limits the time of a run.
    """
    folder = Folder(file, conditions)
    found = []
    for node in file.run.temporals.values():
        if always_condition(node.condition) is not None:
            broken = folder.known((node.span, RuleKind.ABORT))
            formula = None if broken is None else not broken
        else:
            formula = folder.formula(node.condition)
        if formula is False and file.settings.given.stream is not None:
            formula = folder.never(node.condition)  # its run is invalid, as that of which it is the concrete copy
        _report(file, node, formula, conditions, has_end=has_end)
        if isinstance(formula, ir.Formula):
            found.append(ir.Temporal(formula, file.run.rule(node.span, name_of(file.facts, node), RuleKind.ABORT)))
    return tuple(found)


def _report(
    file: FileContext, node: nodes.Require, formula: ir.Formula | bool | None, conditions: Conditions, *, has_end: bool
) -> None:
    span = node.condition.span
    if formula is False:
        file.findings.add(ALWAYS_FALSE.at(span))
    elif file.is_pinned:
        return
    elif formula is True:
        file.findings.add(TEMPORAL_HOLDS.at(span))
    elif not any(is_dynamic(each) for each in seen(node, conditions)):
        file.findings.add(NEVER_CHANGES.at(span))
    elif not has_end and (waiting := waiting_part(node.condition)) is not None:
        file.findings.add(NO_END.at(waiting.span, limit=SimulationConfig().max_time))


def seen(node: nodes.Require | nodes.Expect, conditions: Conditions) -> Iterator[Term]:
    """Yield all terms of a requirement or an expectation, in all variants."""
    keys = [(node.span, RuleKind.ABORT), *((atom.span, RuleKind.WATCH) for atom in atoms(node.condition))]
    return (each[key] for each in conditions for key in keys if key in each)


def waiting_part(node: nodes.Expression) -> nodes.Expression | None:
    """The first part that must come true some day."""
    if isinstance(node, nodes.Temporal) and node.operator in ("eventually", "until"):
        return node
    return next((found for part in subformulas(node) if (found := waiting_part(part)) is not None), None)


@dataclass
class Folder:
    """Formulas without the parts that are known, which must be so in all variants."""

    file: FileContext
    conditions: Conditions
    places: dict[nodes.Expression, Span] = field(default_factory=dict)
    """First place of each atom; equal atoms are evaluated once."""

    def formula(self, node: nodes.Expression) -> ir.Formula | bool:
        if not is_timed(node):
            known = self.known((node.span, RuleKind.WATCH))
            return self._atom(node) if known is None else known
        operator = node.operator if isinstance(node, nodes.Temporal | nodes.BoolOp) else "not"
        parts = [self.formula(part) for part in subformulas(node)]
        if operator == "next" and parts[0] is True:
            atom = self._atom(next(atoms(node)))
            parts = [ir.Formula(TemporalOp.OR, (atom, ir.Formula(TemporalOp.NOT, (atom,))))]
        return _joined(operator, parts)

    def never(self, node: nodes.Expression) -> ir.Formula:
        """Return a formula that is false in every run."""
        atom = self._atom(next(atoms(node)))
        return ir.Formula(TemporalOp.AND, (atom, ir.Formula(TemporalOp.NOT, (atom,))))

    def known(self, key: RuleKey) -> bool | None:
        """Return the value of a condition if it is the same in all runs of all variants; None otherwise."""
        bounds = self.file.genes.bounds
        truths = {truth_of(each[key], lambda part: interval(part, bounds)) for each in self.conditions if key in each}
        return {(1.0, 1.0): True, (0.0, 0.0): False}.get(truths.pop()) if len(truths) == 1 else None

    def _atom(self, node: nodes.Expression) -> ir.Formula:
        span = node.span if _draws(node) else self.places.setdefault(node, node.span)
        name = self.file.facts.source.words(span)
        return ir.Formula(TemporalOp.ATOM, watch=self.file.run.rule(span, name, RuleKind.WATCH))


def _draws(node: nodes.Expression) -> bool:
    """Return whether each evaluation gives another number."""
    return any(isinstance(part, nodes.Name) and part.id in DISTRIBUTIONS for part in everything_in(node))


def _joined(operator: str, parts: Sequence[ir.Formula | bool]) -> ir.Formula | bool:
    """The formula of an operator, without operands that are known."""
    match operator, *parts:
        case "not", bool(known):
            return not known
        case "and" | "or", *_:
            return _chained(operator, parts)
        case "implies", premise, conclusion if any(isinstance(part, bool) for part in parts):
            return _chained("or", [_joined("not", [premise]), conclusion])
        case "always" | "eventually" | "next", bool(known):
            return known
        case "until", _, bool(known):
            return known
        case "until", True, then:
            return _joined("eventually", [then])
        case "until", False, then:
            return then
    return ir.Formula(OPERATORS[operator], tuple(part for part in parts if isinstance(part, ir.Formula)))


def _chained(operator: str, parts: Sequence[ir.Formula | bool]) -> ir.Formula | bool:
    """`a and b and c`, two at a time."""
    decisive = operator == "or"
    if decisive in parts:
        return decisive
    formulas = [part for part in parts if isinstance(part, ir.Formula)]
    if not formulas:
        return not decisive
    return reduce(lambda left, right: ir.Formula(OPERATORS[operator], (left, right)), formulas)
