"""Behaviours, inlined: each actor's behaviour with everything that it `do`es becomes one block of acts.

Arguments are evaluated where the behaviour starts. Numbers that a body assigns live in locals; lanes, objects and
other things are bound at compile time and cannot change during the run.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

from cortex_dsl import ir
from cortex_dsl.semantics import errors, library, numbers
from cortex_dsl.semantics.algebra import is_dynamic
from cortex_dsl.semantics.builtins import Kind, names_of
from cortex_dsl.semantics.calls import as_behaviour
from cortex_dsl.semantics.context import Evaluator, Moment
from cortex_dsl.semantics.operators import combine, unpack
from cortex_dsl.semantics.problems import Mistake
from cortex_dsl.semantics.units import dimension_name
from cortex_dsl.semantics.values import (
    POISON,
    ActionCall,
    Actor,
    BehaviourCall,
    BehaviourValue,
    Pose,
    Quantity,
    Truth,
    Value,
    Vector,
    kind_name,
)
from cortex_dsl.semantics.variables import snapshot
from cortex_dsl.semantics.yielding import ever_acts
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes
from engine.config import SimulationConfig
from engine.vocabulary import Command, Op


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


def snapshot(ev: Evaluator, value: Value, span: Span, acts: list[ir.Act]) -> Value:
    """The value with everything that changes during the run copied into fresh locals."""

    def kept(expr: ir.Expr) -> ir.Expr:
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
        case tuple():
            return tuple(snapshot(ev, item, span, acts) for item in value)
    return value


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
        counts = list(_assigned_names(node.body, repeated=False))
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
                acts += _STATEMENTS[type(statement)](self, statement)
            except Mistake as mistake:
                self.ev.report(mistake)
                self._poison(statement)
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


def _assigned_names(statements: Sequence[nodes.Statement], *, repeated: bool) -> Iterator[str]:
    """Every assignment's names; twice where it may run again."""
    for statement in statements:
        match statement:
            case nodes.Assign(targets=targets):
                yield from targets * (2 if repeated else 1)
            case nodes.AugmentedAssign(target=target):
                yield from (target, target)
            case nodes.If(branches=branches, otherwise=otherwise):
                for _, body in branches:
                    yield from _assigned_names(body, repeated=True)
                yield from _assigned_names(otherwise, repeated=True)
            case nodes.While(body=body):
                yield from _assigned_names(body, repeated=True)
            case nodes.Try(body=body, handlers=handlers):
                yield from _assigned_names(body, repeated=True)
                for handler in handlers:
                    yield from _assigned_names(handler.body, repeated=True)


# -- statements -------------------------------------------------------------------------------------------------------


def _assign(body: Body, node: nodes.Assign) -> ir.Block:
    with body.ev.naming(node.targets[0]):
        value = body.ev.evaluate(node.value)
    acts: list[ir.Act] = []
    for name, item in unpack(node.targets, value, node.span).items():
        acts += body.assign(name, item, node.value.span)
    return tuple(acts)


def _augmented(body: Body, node: nodes.AugmentedAssign) -> ir.Block:
    name = nodes.Name(span=node.span, id=node.target)
    operation = nodes.Binary(span=node.span, operator=node.operator, left=name, right=node.value)
    value = combine(body.ev, node.operator, body.ev.evaluate(name), body.ev.evaluate(node.value), operation)
    return body.assign(node.target, value, node.span)


def _expression(body: Body, node: nodes.ExpressionStatement) -> ir.Block:
    value = body.ev.evaluate(node.value)
    if isinstance(value, BehaviourCall | BehaviourValue):
        name = value.name if isinstance(value, BehaviourCall) else value.node.name
        raise errors.CALLED_BEHAVIOUR.mistake(node.span, name=name)
    if not isinstance(value, str):
        body.ev.report(errors.BARE_EXPRESSION.at(node.span))
    return ()


def _do(body: Body, node: nodes.Do) -> ir.Block:
    if node.until is not None:
        condition = body.condition(node.until, repeated=True)
        return _until(body.run(node.behavior), condition, node.span)
    if node.duration is None:
        return body.run(node.behavior)
    ev = body.ev
    start = ev.run.new_local()
    elapsed = ev.algebra.sub(ev.algebra.apply(Op.TIME), ev.algebra.local(start))
    over = ev.algebra.apply(Op.LE, _duration(body, node, node.duration), elapsed)
    return (
        ir.SetLocal(node.span, start, ev.algebra.apply(Op.TIME)),
        *_until(body.run(node.behavior), over, node.span),
    )


def _until(block: ir.Block, condition: ir.Expr, span: Span) -> ir.Block:
    return (ir.TryInterrupt(span, block, ((condition, (ir.Abort(span),)),)),)


def _duration(body: Body, node: nodes.Do, duration: nodes.Expression) -> ir.Expr:
    """[s], a little less than asked for: sums of steps are not exact."""
    ev = body.ev
    value = ev.evaluate(duration)
    if node.in_steps:
        steps = numbers.quantity(value, duration.span, "a number of steps")
        step = ev.file.settings.time_step or SimulationConfig().time_step
        seconds = ev.algebra.mul(steps.expr, ev.algebra.literal(step))
    else:
        seconds = numbers.adopt(ev, value, TIME, duration.span, "the duration after `for`")
        numbers.in_range(ev, seconds, 0.0, float("inf"), TIME, duration.span, "the duration after `for`")
    return ev.algebra.sub(seconds, ev.algebra.literal(CLOCK_TOLERANCE))


def _take(body: Body, node: nodes.Take) -> ir.Block:
    commands = []
    for action in node.actions:
        value = body.ev.evaluate(action)
        for each in value if isinstance(value, tuple) else (value,):
            commands.append(_action(each, action))
    known = [command for command, _ in commands]
    for command in known:
        if known.count(command) > 1:
            raise errors.SAME_ACTION.mistake(node.span, command=command.name.lower())
    return (ir.Take(node.span, tuple(commands)),)


def _action(value: Value, node: nodes.Expression) -> tuple[Command, ir.Expr]:
    if isinstance(value, ActionCall):
        return value.command, value.value
    suggestion = did_you_mean(kind_name(value).strip("`"), names_of(Kind.ACTION))
    raise errors.NOT_AN_ACTION.mistake(node.span, actual=kind_name(value), suggestion=suggestion)


def _wait(_body: Body, node: nodes.Wait) -> ir.Block:
    return (ir.Wait(node.span),)


def _try(body: Body, node: nodes.Try) -> ir.Block:
    inner = body.nested(node.body, repeated=body.moment.repeated)
    handlers = []
    for handler in node.handlers:
        condition = body.condition(handler.condition, repeated=True)
        acts = body.nested(handler.body, repeated=True)
        check_handler(body.ev, condition, acts, handler.condition.span)
        handlers.append((condition, acts))
    return (ir.TryInterrupt(node.span, inner, tuple(handlers)),)


def _abort(_body: Body, node: nodes.Abort) -> ir.Block:
    return (ir.Abort(node.span),)


def _terminate(body: Body, node: nodes.Terminate) -> ir.Block:
    name = f"`terminate` in {body.inliner.stack[-1].node.name}"
    return (ir.Terminate(node.span, body.ev.file.rule(node.span, name)),)


def _if(body: Body, node: nodes.If) -> ir.Block:
    return _branches(body, list(node.branches), node)


def _branches(
    body: Body, branches: Sequence[tuple[nodes.Expression, tuple[nodes.Statement, ...]]], node: nodes.If
) -> ir.Block:
    """What is decided at compile time leaves no branch behind."""
    if not branches:
        return body.block(node.otherwise)
    (test, statements), rest = branches[0], branches[1:]
    condition = body.condition(test)
    if isinstance(condition, ir.Literal):
        return body.block(statements) if condition.value else _branches(body, rest, node)
    then = body.nested(statements)
    body.depth += 1
    otherwise = _branches(body, rest, node)
    body.depth -= 1
    return (ir.Branch(test.span, condition, then, otherwise),)


def _while(body: Body, node: nodes.While) -> ir.Block:
    condition = body.condition(node.condition, repeated=True)
    if isinstance(condition, ir.Literal) and not condition.value:
        return ()
    acts = body.nested(node.body, repeated=True)
    check_loop(body.ev, condition, acts, node.condition.span)
    return (ir.Loop(node.span, condition, acts),)


def _leave(kind: str) -> "Act":
    def act(body: Body, node: nodes.Statement) -> ir.Block:
        return (ir.Leave(node.span, kind, body.scope),)

    return act


def _nothing(_body: Body, _node: nodes.Statement) -> ir.Block:
    return ()


def _misplaced(_body: Body, _node: nodes.Statement) -> ir.Block:
    """The scope check has said already that this statement stands in the wrong place."""
    raise Mistake


Act = Callable[[Body, nodes.Statement], ir.Block]

_STATEMENTS: dict[type, Act] = {
    nodes.Assign: _assign,
    nodes.AugmentedAssign: _augmented,
    nodes.ExpressionStatement: _expression,
    nodes.Do: _do,
    nodes.Take: _take,
    nodes.Wait: _wait,
    nodes.Try: _try,
    nodes.Abort: _abort,
    nodes.Terminate: _terminate,
    nodes.If: _if,
    nodes.While: _while,
    nodes.Break: _leave("break"),
    nodes.Continue: _leave("continue"),
    nodes.Return: _leave("return"),
    nodes.Pass: _nothing,
    **dict.fromkeys(
        (
            nodes.Map,
            nodes.Simulation,
            nodes.Model,
            nodes.Param,
            nodes.Require,
            nodes.TerminateWhen,
            nodes.TerminateAfter,
            nodes.BehaviorDefinition,
        ),
        _misplaced,
    ),
}  # type: ignore[dict-item]


def warn_if_idle(ev: Evaluator, actor: Actor, block: ir.Block) -> None:
    """A behaviour that does nothing at all is hardly meant."""
    call = actor.properties["behavior"]
    assert isinstance(call, BehaviourCall)
    if isinstance(call.behaviour, BehaviourValue) and not ever_acts(block):
        ev.report(errors.IDLE_BEHAVIOUR.at(call.span, name=call.name))
