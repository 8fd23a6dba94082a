"""Compile the statements of one behaviour, monitor or `compose`, with its names, to acts.

The module also contains the conditions that abort a run: guards of behaviours, and `require` in behaviours and
monitors.

Numbers that a body assigns are in locals; lanes, objects and other values are bound at compile time and cannot change
during the run.

As in Scenic, preconditions are tested when a behaviour starts, and invariants then and in every sample in which the
behaviour itself continues: not while a `do` is running, but again when that has ended.
Source: Scenic 3 reference, "Behavior Definition".
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

from cortex_dsl import ir
from cortex_dsl.diagnostics import Label
from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.errors.runs import DIMENSION_CHANGES, GUARD_NEVER, OBJECT_CHANGES
from cortex_dsl.semantics.evaluation import numbers
from cortex_dsl.semantics.model.context import Evaluator, Moment
from cortex_dsl.semantics.model.values import (
    POISON,
    BehaviourCall,
    Colour,
    LaneNow,
    MonitorCall,
    Pose,
    Quantity,
    Truth,
    Value,
    Vector,
)
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.names.tree import assigned_names
from cortex_dsl.semantics.quantities.algebra import Term
from cortex_dsl.semantics.quantities.bounds import closed_value, is_dynamic
from cortex_dsl.semantics.quantities.units import dimension_name
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes
from engine.frozen import frozen
from engine.vocabulary import RuleKind

# -- guards ------------------------------------------------------------------------------------------------------------

Condition = Callable[[nodes.Expression], Term]
"""The truth of a condition at every later moment."""


def tested_guards(
    ev: Evaluator, guards: Iterable[nodes.Guard], kind: str, name: str, condition: Condition, call: Span
) -> tuple[tuple[Term, int], ...]:
    """The conditions of guards and the rules that abort the run where they are false; reports those that are none."""
    found = []
    for guard in guards:
        try:
            holds = condition(guard.condition)
        except Mistake as mistake:
            ev.report(mistake)
            continue
        rule = abort_rule(ev, guard.condition.span, f"{kind} of {name}: {ev.facts.source.words(guard.condition.span)}")
        if closed_value(holds) == 0.0:
            where = (Label(call, "started here"),)
            ev.report(GUARD_NEVER.at(guard.condition.span, secondary=where, guard=kind, name=name))
        found.append((holds, rule))
    return tuple(found)


def abort_rule(ev: Evaluator, span: Span, name: str) -> int:
    return ev.file.run.rule(span, name, RuleKind.ABORT)


def demand(
    ev: Evaluator, node: nodes.Require | nodes.Assert, holds: Term, owner: str, probability: float = 1.0
) -> ir.Block:
    """Compile `require` or `assert` in a behaviour or monitor; a soft requirement is sampled at each evaluation."""
    if probability < 1.0:
        spared = probability <= ev.algebra.random()
        holds = spared | holds
    if isinstance(holds, ir.Literal) and holds.value:
        return ()
    word = "assert" if isinstance(node, nodes.Assert) else "require"
    name = node.name or f"{word} in {owner}: {ev.facts.source.words(node.condition.span)}"
    return (ir.Demand(node.span, holds, abort_rule(ev, node.span, name)),)


# -- stored values ----------------------------------------------------------------------------------------------------


def snapshot(ev: Evaluator, value: Value, span: Span, acts: list[ir.Act]) -> Value:
    """The value with everything that changes during the run copied into fresh locals."""

    def kept(expr: Term) -> Term:
        if not is_dynamic(expr):
            return expr
        local = ev.run.new_local()
        acts.append(ir.SetLocal(span, local, expr))
        return ev.algebra.local(local)

    match value:
        case Quantity(expr, dimension):
            return Quantity(kept(expr), dimension)
        case Truth(expr):
            return Truth(kept(expr))
        case Vector(x, y):
            return Vector(kept(x), kept(y))
        case Pose(x, y, heading):
            return Pose(kept(x), kept(y), kept(heading))
        case LaneNow(id):
            return replace(value, id=kept(id))
        case Colour(index):
            return Colour(kept(index))
        case tuple():
            return tuple(snapshot(ev, item, span, acts) for item in value)
    return value


def of_same_dimension(name: str, before: Value, value: Value, span: Span) -> Quantity | Truth:
    """Return the new value of a variable if it has the kind and dimension of the value before.

    Raises:
        Mistake: kind or dimension differ; a missing dimension fits every dimension.
    """
    if isinstance(before, Truth) and isinstance(value, Truth):
        return value
    if isinstance(before, Quantity) and isinstance(value, Quantity):
        if None in (before.dimension, value.dimension):
            return Quantity(value.expr, value.dimension or before.dimension)
        if before.dimension == value.dimension:
            return value
        actual = dimension_name(value.dimension)
        raise DIMENSION_CHANGES.mistake(span, name=name, before=dimension_name(before.dimension), after=actual)
    raise DIMENSION_CHANGES.mistake(span, name=name, before=kind_name(before), after=kind_name(value))


# -- bodies ------------------------------------------------------------------------------------------------------------

Defined = nodes.BehaviorDefinition | nodes.MonitorDefinition

Guards = tuple[tuple[Term, int], ...]
"""Conditions, and the rules that abort the run where they are false."""


@frozen
class Invocation:
    """An operand of `do`: acts to evaluate it, conditions for its start, and its acts."""

    prologue: ir.Block
    acts: ir.Block
    preconditions: Guards = ()
    invariants: Guards = ()
    """Those of the scope in `acts`."""

    def block(self, span: Span) -> ir.Block:
        """All of it, where it must start."""
        demands = (ir.Demand(span, holds, rule) for holds, rule in self.preconditions)
        return (*self.prologue, *demands, *self.acts)

    def allowed(self, ev: Evaluator) -> Term:
        """Return whether it could start now, with its present arguments."""
        result: Term = ev.algebra.truth(True)
        for holds, _ in (*self.preconditions, *self.invariants):
            result = result & holds
        return result


class Invoker(Protocol):
    """Interface of a body to everything outside it."""

    @property
    def ev(self) -> Evaluator:
        """The place of the definition."""
        ...

    @property
    def owner(self) -> str:
        """Return the name of the body that is being inlined."""
        ...

    @property
    def lets_appear(self) -> bool:
        """Return whether its statements may let objects appear: those of monitors only watch."""
        ...

    def act(self, body: "Body", statement: nodes.Statement) -> ir.Block:
        """Return the acts of one statement of a body."""
        ...

    def invocation(self, value: Value, node: nodes.Expression, moment: Moment) -> Invocation:
        """Return the invocation of `do node`."""
        ...

    def together(self, body: "Body", invocations: Sequence[nodes.Expression]) -> ir.Block:
        """Return the acts of `do a, b`."""
        ...

    def mark(self) -> int:
        """How many scenarios have been started so far."""
        ...

    def stopped(self, mark: int, span: Span) -> ir.Block:
        """Acts that stop the scenarios started since."""
        ...

    def over(self, body: "Body", node: nodes.Terminate) -> ir.Block:
        """Return the acts of `terminate`."""
        ...


@dataclass
class Variable:
    """A name of a behaviour that is assigned in it: a local, or a binding that cannot change."""

    local: int | None
    depth: int
    """How deep in branches and loops it was bound."""


@dataclass
class Body:
    """One inlined behaviour or monitor: its names and the acts of its statements."""

    inliner: Invoker
    moment: Moment
    names: dict[str, Value] = field(default_factory=dict)
    variables: dict[str, Variable] = field(default_factory=dict)
    assigned: frozenset[str] = frozenset()
    """Names that the body assigns more than once, or where it may be entered again."""
    scope: int = -1
    depth: int = 0
    invariants: Guards = ()
    marks: list[int] = field(default_factory=list)
    """How many scenarios had been started where each `try` around began."""

    @property
    def ev(self) -> Evaluator:
        return self.inliner.ev.inside(self.names).at_moment(self.moment)

    def inlined(self, call: BehaviourCall | MonitorCall, node: Defined) -> Invocation:
        """The body of a definition. Guards see its parameters, which get their values before."""
        self.scope = self.inliner.ev.run.new_scope(call.span)
        counts = list(assigned_names(node.body, repeated=False))
        self.assigned = frozenset(name for name in counts if counts.count(name) > 1)
        prologue: list[ir.Act] = []
        for parameter in node.parameters:
            self._bind(parameter, call, prologue, parameter.name in counts)
        preconditions, self.invariants = self._guards(node, call.span)
        scope = ir.Scope(call.span, node.name, self.scope, self.block(node.body), self.invariants)
        return Invocation(tuple(prologue), (scope,), preconditions, self.invariants)

    def _guards(self, node: Defined, call: Span) -> tuple[Guards, Guards]:
        if isinstance(node, nodes.MonitorDefinition):
            return (), ()

        def tested(written: Sequence[nodes.Guard], kind: str) -> Guards:
            return tested_guards(self.ev, written, kind, node.name, self._later, call)

        return tested(node.preconditions, "precondition"), tested(node.invariants, "invariant")

    def _later(self, node: nodes.Expression) -> Term:
        return self.condition(node, repeated=True)

    def _bind(
        self, parameter: nodes.Parameter, call: BehaviourCall | MonitorCall, acts: list[ir.Act], changes: bool
    ) -> None:
        if parameter.name in call.arguments:
            value, span = call.arguments[parameter.name], call.spans[parameter.name]
        else:
            assert parameter.default is not None
            value, span = self.ev.evaluate(parameter.default), parameter.default.span
        if changes and isinstance(value, Quantity | Truth):
            acts += self.assign(parameter.name, value, span, local=True)
        else:
            self.names[parameter.name] = snapshot(self.ev, value, span, acts)
            self.variables[parameter.name] = Variable(None, self.depth)

    def returned(self, span: Span) -> ir.Block:
        """Return the acts at the start of a handler: the body resumes there, so its invariants must hold."""
        return tuple(ir.Demand(span, holds, rule) for holds, rule in self.invariants)

    # -- blocks ------------------------------------------------------------------------------------------------------

    def block(self, statements: Sequence[nodes.Statement]) -> ir.Block:
        """Acts of statements; a mistake in one does not hide those in the next."""
        if not statements:
            return ()
        acts: list[ir.Act] = []
        with self.ev.run.depth.nested(statements[0].span):
            for statement in statements:
                acts += self._acts(statement)
        return tuple(acts)

    def _acts(self, statement: nodes.Statement) -> ir.Block:
        try:
            return self.inliner.act(self, statement)
        except Mistake as mistake:
            self.ev.report(mistake)
            self._poison(statement)
            # Replaces an erroneous statement, so that its body does not count as one that never acts.
            return (ir.Wait(statement.span),)

    def _poison(self, statement: nodes.Statement) -> None:
        if isinstance(statement, nodes.Assign):
            self.names.update(dict.fromkeys(statement.targets, POISON))

    def nested(
        self, statements: Sequence[nodes.Statement], *, repeated: bool = False, looping: bool = False
    ) -> ir.Block:
        """A block that may not run, or (`repeated`) run more than once; `looping` says that it is a loop's."""
        before, self.depth = self.moment, self.depth + 1
        if repeated:
            self.moment = replace(self.moment, repeated=True, looping=self.moment.looping or looping)
        acts = self.block(statements)
        self.moment, self.depth = before, self.depth - 1
        return acts

    def condition(self, node: nodes.Expression, *, repeated: bool = False) -> Term:
        ev = self.ev.at_moment(replace(self.moment, repeated=self.moment.repeated or repeated))
        return numbers.truth(ev, ev.evaluate(node), node.span)

    # -- variables ---------------------------------------------------------------------------------------------------

    def assign(self, name: str, value: Value, span: Span, *, local: bool = False) -> ir.Block:
        """Bind a name; numbers that may change get a local."""
        known = self.variables.get(name)
        if isinstance(value, Quantity | Truth):
            needs_local = local or name in self.assigned or self.moment.repeated or is_dynamic(value.expr)
            if needs_local or (known is not None and known.local is not None):
                return self._set_local(name, value, span)
        elif known is not None and self.depth > known.depth:
            raise OBJECT_CHANGES.mistake(span, name=name, kind=kind_name(value).split(" ", 1)[-1])
        acts: list[ir.Act] = []
        self.names[name] = snapshot(self.ev, value, span, acts)
        self.variables[name] = Variable(None, self.depth)
        return tuple(acts)

    def _set_local(self, name: str, value: Quantity | Truth, span: Span) -> ir.Block:
        known = self.variables.get(name)
        if known is None or known.local is None:
            known = self.variables[name] = Variable(self.ev.run.new_local(), self.depth)
        else:
            value = of_same_dimension(name, self.names[name], value, span)
        assert known.local is not None
        self.names[name] = replace(value, expr=self.ev.algebra.local(known.local))
        return (ir.SetLocal(span, known.local, value.expr),)

    def invocation(self, node: nodes.Expression) -> Invocation:
        """Return the invocation of `do node`."""
        return self.inliner.invocation(self.ev.evaluate(node), node, self.moment)

    def option(self, value: Value, node: nodes.Expression) -> Invocation:
        """Return the invocation that `do choose` runs if it selects this value."""
        return self.inliner.invocation(value, node, self.moment)
