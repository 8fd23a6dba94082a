"""Behaviours, inlined: each actor's behaviour with everything that it `do`es becomes one block of acts.

Arguments are evaluated where the behaviour starts. Numbers that a body assigns live in locals; lanes, objects and
other things are bound at compile time and cannot change during the run.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from cortex_dsl import ir
from cortex_dsl.semantics import errors, library, numbers
from cortex_dsl.semantics.algebra import is_dynamic
from cortex_dsl.semantics.builtins import Kind, names_of
from cortex_dsl.semantics.calls import as_behaviour
from cortex_dsl.semantics.context import Evaluator, Moment
from cortex_dsl.semantics.problems import Mistake
from cortex_dsl.semantics.units import dimension_name
from cortex_dsl.semantics.values import (
    POISON,
    Actor,
    BehaviourCall,
    BehaviourValue,
    Quantity,
    Truth,
    Value,
    kind_name,
)
from cortex_dsl.semantics.variables import assigned_names, snapshot
from cortex_dsl.semantics.yielding import ever_acts
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes


def actor_behaviour(ev: Evaluator, actor: Actor) -> ir.Block | None:
    """All that an actor does; None without behaviour."""
    call = actor.properties.get("behavior")
    if not isinstance(call, BehaviourCall):
        return None
    running = ev.at_moment(Moment(running=True, actor=actor))
    return Inliner(running, actor).started(call)


@dataclass(frozen=True)
class Inliner:
    """Turns behaviour calls into blocks; `stack` holds the behaviours that are being inlined."""

    ev: Evaluator
    actor: Actor
    stack: tuple[BehaviourValue, ...] = ()

    def started(self, call: BehaviourCall) -> ir.Block:
        """The actor's own behaviour, which begins with the run."""
        return self.block(call, self.ev.moment, at_start=True)

    def block(self, call: BehaviourCall, moment: Moment, *, at_start: bool = False) -> ir.Block:
        ev = self.ev.at_moment(moment)
        if not isinstance(call.behaviour, BehaviourValue):
            prologue, fixed = _settled(ev, call)
            return (*prologue, *library.acts(library.Job(ev, fixed, self.actor, at_start)))
        self._check_cycle(call.behaviour, call.span)
        return Body(replace(self, stack=(*self.stack, call.behaviour)), moment).inlined(call, call.behaviour.node)

    def _check_cycle(self, behaviour: BehaviourValue, span: Span) -> None:
        if any(behaviour.node is running.node for running in self.stack):
            names = [running.node.name for running in (*self.stack, behaviour)]
            first = names.index(behaviour.node.name)
            raise errors.RECURSIVE.mistake(span, name=behaviour.node.name, cycle=" -> ".join(names[first:]))


def _settled(ev: Evaluator, call: BehaviourCall) -> tuple[ir.Block, BehaviourCall]:
    """A call whose arguments keep the values that they have when it starts."""
    acts: list[ir.Act] = []
    arguments = {name: snapshot(ev, value, call.spans[name], acts) for name, value in call.arguments.items()}
    return tuple(acts), replace(call, arguments=arguments)


@dataclass
class Variable:
    """A name of a behaviour that is assigned in it: a local, or a binding that cannot change."""

    local: int | None
    depth: int
    """How deep in branches and loops it was bound."""


@dataclass
class Body:
    """One inlined behaviour: its names and the acts of its statements."""

    inliner: Inliner
    moment: Moment
    names: dict[str, Value] = field(default_factory=dict)
    variables: dict[str, Variable] = field(default_factory=dict)
    assigned: frozenset[str] = frozenset()
    """Names that the body assigns more than once, or where it may be entered again."""
    scope: int = -1
    depth: int = 0

    @property
    def ev(self) -> Evaluator:
        return self.inliner.ev.inside(self.names).at_moment(self.moment)

    def inlined(self, call: BehaviourCall, node: nodes.BehaviorDefinition) -> ir.Block:
        self.scope = self.inliner.ev.run.new_scope()
        counts = list(assigned_names(node.body, repeated=False))
        self.assigned = frozenset(name for name in counts if counts.count(name) > 1)
        acts: list[ir.Act] = []
        for parameter in node.parameters:
            self._bind(parameter, call, acts, parameter.name in counts)
        acts += self.block(node.body)
        return (ir.Scope(call.span, node.name, self.scope, tuple(acts)),)

    def _bind(self, parameter: nodes.Parameter, call: BehaviourCall, acts: list[ir.Act], changes: bool) -> None:
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

    # -- blocks ------------------------------------------------------------------------------------------------------

    def block(self, statements: Sequence[nodes.Statement]) -> ir.Block:
        """Acts of statements; a mistake in one does not hide those in the next."""
        acts: list[ir.Act] = []
        for statement in statements:
            try:
                acts += ACTS[type(statement)](self, statement)
            except Mistake as mistake:
                self.ev.report(mistake)
                self._poison(statement)
                # Stands for what could not be understood, so that nothing is said to never act.
                acts.append(ir.Wait(statement.span))
        return tuple(acts)

    def _poison(self, statement: nodes.Statement) -> None:
        if isinstance(statement, nodes.Assign):
            self.names.update(dict.fromkeys(statement.targets, POISON))

    def nested(self, statements: Sequence[nodes.Statement], *, repeated: bool = False) -> ir.Block:
        """A block that may not run, or (`repeated`) run more than once."""
        before, self.depth = self.moment, self.depth + 1
        if repeated:
            self.moment = replace(self.moment, repeated=True)
        acts = self.block(statements)
        self.moment, self.depth = before, self.depth - 1
        return acts

    def condition(self, node: nodes.Expression, *, repeated: bool = False) -> ir.Expr:
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
            raise errors.OBJECT_CHANGES.mistake(span, name=name, kind=kind_name(value).split(" ", 1)[-1])
        acts: list[ir.Act] = []
        self.names[name] = snapshot(self.ev, value, span, acts)
        self.variables[name] = Variable(None, self.depth)
        return tuple(acts)

    def _set_local(self, name: str, value: Quantity | Truth, span: Span) -> ir.Block:
        known = self.variables.get(name)
        if known is None or known.local is None:
            known = self.variables[name] = Variable(self.ev.run.new_local(), self.depth)
        else:
            value = self._of_same_dimension(name, value, span)
        assert known.local is not None
        self.names[name] = replace(value, expr=self.ev.algebra.local(known.local))
        return (ir.SetLocal(span, known.local, value.expr),)

    def _of_same_dimension(self, name: str, value: Quantity | Truth, span: Span) -> Quantity | Truth:
        before = self.names[name]
        if isinstance(before, Truth) and isinstance(value, Truth):
            return value
        if isinstance(before, Quantity) and isinstance(value, Quantity):
            if None in (before.dimension, value.dimension):
                return Quantity(value.expr, value.dimension or before.dimension)
            if before.dimension == value.dimension:
                return value
            actual = dimension_name(value.dimension)
            raise errors.DIMENSION_CHANGES.mistake(
                span, name=name, before=dimension_name(before.dimension), after=actual
            )
        raise errors.DIMENSION_CHANGES.mistake(span, name=name, before=kind_name(before), after=kind_name(value))

    def run(self, node: nodes.Expression) -> ir.Block:
        """What `do node` does."""
        value = self.ev.evaluate(node)
        call = as_behaviour(value, node.span)
        if call is None:
            cure = did_you_mean(node.id, names_of(Kind.BEHAVIOUR)) if isinstance(node, nodes.Name) else ""
            raise errors.NOT_A_BEHAVIOUR.mistake(node.span, actual=kind_name(value), cure=cure)
        return self.inliner.block(call, self.moment)


Act = Callable[[Body, nodes.Statement], ir.Block]
ACTS: dict[type, Act] = {}
"""What each statement of a behaviour does; `acts` fills it."""


def warn_if_idle(ev: Evaluator, actor: Actor, block: ir.Block) -> None:
    """A behaviour that does nothing at all is hardly meant."""
    call = actor.properties["behavior"]
    assert isinstance(call, BehaviourCall)
    if isinstance(call.behaviour, BehaviourValue) and not ever_acts(block):
        ev.report(errors.IDLE_BEHAVIOUR.at(call.span, name=call.name))
