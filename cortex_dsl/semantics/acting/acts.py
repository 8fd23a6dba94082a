"""Compile the statements of behaviours to acts of the IR.

`do choose` runs one of several behaviours, `do shuffle` all of them in random order. As in Scenic, only options with
valid guards at that moment take part; the probability of an option is its weight over the sum of the weights. Without a
valid option the run is aborted. Arguments are evaluated once, at the start of the statement.
Source: Scenic 3 reference, "do choose", "do shuffle".
"""

from collections.abc import Callable, Iterator, Mapping, Sequence

from cortex_dsl import ir
from cortex_dsl.semantics.acting import bodies
from cortex_dsl.semantics.acting.bodies import Body, Invocation, Variable, of_same_dimension
from cortex_dsl.semantics.acting.statements import check_called, soft_probability
from cortex_dsl.semantics.acting.yielding import check_handler, check_loop
from cortex_dsl.semantics.errors.names import BARE_EXPRESSION, NOT_ON_FOOT
from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.errors.runs import (
    CANNOT_SET,
    LEAVES_WRITTEN_OUT,
    NO_WEIGHT,
    NOT_A_DRIVER,
    NOT_AN_ACTION,
    OBJECT_CHANGES,
    ONE_OPTION,
    SAME_ACTION,
)
from cortex_dsl.semantics.errors.values import WRONG_KIND
from cortex_dsl.semantics.evaluation import numbers
from cortex_dsl.semantics.evaluation.arguments import items_of
from cortex_dsl.semantics.evaluation.lists import unpack
from cortex_dsl.semantics.evaluation.operators import combine
from cortex_dsl.semantics.evaluation.ranges import in_range
from cortex_dsl.semantics.model.values import (
    ActionCall,
    Actor,
    BuiltinValue,
    DoorCall,
    Effect,
    Quantity,
    Truth,
    Value,
    Weights,
)
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.names.builtins import Kind, names_of
from cortex_dsl.semantics.names.placement import TOP_LEVEL
from cortex_dsl.semantics.names.properties import Domain, all_properties
from cortex_dsl.semantics.names.tree import parts
from cortex_dsl.semantics.quantities.algebra import Term
from cortex_dsl.semantics.quantities.algebra import table as table_entry
from cortex_dsl.semantics.quantities.bounds import closed_value
from cortex_dsl.semantics.quantities.units import PURE, TIME
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes
from engine.frozen import frozen
from engine.vocabulary import ActorKind, Command

# -- properties --------------------------------------------------------------------------------------------------------


SIMULATED: Mapping[str, str] = {
    **dict.fromkeys(("position", "heading", "x", "y"), "the run moves objects: `take` an action, or `do` a behavior"),
    "speed": "it follows from what the object does: `take SetSpeedAction(...)`",
    **dict.fromkeys(("steer", "throttle", "brake"), "an action sets it: `take SetSteerAction(...)` and the like"),
    "behavior": "a scenario changes it: `override x with behavior B()`",
}
"""Properties that the run sets, and the statement by which a file influences each."""


def set_attribute(body: Body, node: nodes.SetAttribute) -> ir.Block:
    """Set a property of the file's own; every later read sees the new value."""
    ev, target, name = body.ev, node.target, node.target.name
    actor = ev.evaluate(target.value)
    if not isinstance(actor, Actor):
        raise WRONG_KIND.mistake(
            target.value.span,
            what="what is assigned",
            expected="a property of an object",
            actual=kind_name(actor),
            cure="",
        )
    before = _may_change(actor, name, target.name_span)
    value = ev.evaluate(node.value)
    if node.operator:
        operation = nodes.Binary(span=node.span, operator=node.operator, left=target, right=node.value)
        value = combine(ev, node.operator, ev.evaluate(target), value, operation)
    cell = actor.cells[name]
    settled = of_same_dimension(name, before, value, node.value.span)
    return (
        ir.SetLocal(node.span, cell.value, settled.expr),
        ir.SetLocal(node.span, cell.assigned, ev.algebra.truth(True)),
    )


def _may_change(actor: Actor, name: str, span: Span) -> Quantity | Truth:
    """Return the first value of a property that may change.

    Raises:
        Mistake: the run sets the property, it is settled with the scene, or the object has none.
    """
    if name in SIMULATED:
        raise CANNOT_SET.mistake(span, name=name, reason=SIMULATED[name])
    if name in all_properties():
        raise CANNOT_SET.mistake(span, name=name, reason="it is the same from the first sample to the last")
    if name not in actor.properties:
        raise CANNOT_SET.mistake(span, name=name, reason=f"`{actor.name}` is not made with it: `with {name} 0`")
    first = actor.properties[name]
    if not isinstance(first, Quantity | Truth):
        raise OBJECT_CHANGES.mistake(span, name=name, kind=kind_name(first).split(" ", 1)[-1])
    return first


# -- loops -------------------------------------------------------------------------------------------------------------


def while_(body: Body, node: nodes.While) -> ir.Block:
    condition = body.condition(node.condition, repeated=True)
    if isinstance(condition, ir.Literal) and not condition.value:
        return ()
    acts = body.nested(node.body, repeated=True, looping=True)
    check_loop(body.ev, condition, acts, node.condition.span)
    return (ir.Loop(node.span, condition, acts),)


def for_(body: Body, node: nodes.For) -> ir.Block:
    """Compile `for`: numbers are counted at run time, other items are unrolled."""
    ev, span = body.ev, node.iterable.span
    items = items_of(ev.evaluate(node.iterable), span, "what `for` runs over")
    table = _numbers(items)
    if not items:
        return ()
    if table is not None and len(node.targets) == 1:
        return _counted(body, node, items, table)
    if any(isinstance(each, nodes.Break | nodes.Continue) for each in _own_statements(node.body)):
        raise LEAVES_WRITTEN_OUT.mistake(node.span)
    acts: list[ir.Act] = []
    for item in items:
        ev.file.budget.spend(span)
        body.names.update(unpack(node.targets, item, span))
        body.variables.update({name: Variable(None, body.depth + 1) for name in node.targets})
        acts += body.nested(node.body, repeated=True)
    return tuple(acts)


def _numbers(items: Sequence[Value]) -> list[float] | None:
    """Known numbers of one dimension; None for anything else."""
    if not all(isinstance(item, Quantity) for item in items):
        return None
    found = [closed_value(item.expr) for item in items if isinstance(item, Quantity)]
    alike = len({item.dimension for item in items if isinstance(item, Quantity)}) == 1
    known = [number for number in found if number is not None]
    return known if alike and len(known) == len(items) else None


def _counted(body: Body, node: nodes.For, items: Sequence[Value], numbers_: Sequence[float]) -> ir.Block:
    """A loop with a counter, which goes up before the body, so that `continue` does not repeat a round."""
    ev, span = body.ev, node.span
    (name,), first = node.targets, items[0]
    assert isinstance(first, Quantity)
    counter = ev.algebra.local(index := ev.run.new_local())
    offset = ev.file.pool.offset(tuple(numbers_))
    value = table_entry(counter - 1.0, offset)
    body.variables.pop(name, None)
    bound = body.assign(name, Quantity(value, first.dimension), node.span, local=True)
    acts = body.nested(node.body, repeated=True, looping=True)
    ahead = ir.SetLocal(span, index, counter + 1.0)
    goes_on = counter < float(len(items))
    return (ir.SetLocal(span, index, ev.algebra.literal(0.0)), ir.Loop(span, goes_on, (ahead, *bound, *acts)))


def _own_statements(statements: Sequence[nodes.Statement]) -> Iterator[nodes.Statement]:
    """The statements of a loop, without those of loops in it."""
    for statement in statements:
        yield statement
        if not isinstance(statement, nodes.For | nodes.While):
            yield from _own_statements([part for part in parts(statement) if isinstance(part, nodes.Statement)])
            for part in parts(statement):
                if isinstance(part, nodes.Handler):
                    yield from _own_statements(part.body)


# -- `do choose` and `do shuffle` --------------------------------------------------------------------------------------

WHAT = "a weight"


@frozen
class Candidate:
    """One option as it is written."""

    value: Value
    node: nodes.Expression
    weight: Term


def pick(body: Body, node: nodes.Do) -> ir.Block:
    """The acts of the statement, without its `until` or `for`."""
    candidates = list(_candidates(body, node.invocations))
    if len(candidates) == 1:
        body.ev.report(ONE_OPTION.at(node.span, mode=node.mode))
    if all(closed_value(candidate.weight) == 0.0 for candidate in candidates):
        what = "all weights are 0" if candidates else f"`do {node.mode}` has no options"
        raise NO_WEIGHT.mistake(node.span, what=what, mode=node.mode)
    invocations = _invocations(body, candidates)
    rule = bodies.abort_rule(body.ev, node.span, f"do {node.mode} in {body.inliner.owner}: no option may start")
    options = tuple(
        ir.Option(candidate.weight, invocation.allowed(body.ev), invocation.acts)
        for candidate, invocation in zip(candidates, invocations, strict=True)
    )
    prologue = tuple(act for invocation in invocations for act in invocation.prologue)
    return (*prologue, ir.Pick(node.span, options, node.mode == "shuffle", rule))


def _invocations(body: Body, candidates: Sequence[Candidate]) -> list[Invocation]:
    """Return the invocation of each option; report the mistakes of all options before giving up."""
    found = []
    for candidate in candidates:
        try:
            found.append(body.option(candidate.value, candidate.node))
        except Mistake as mistake:
            body.ev.report(mistake)
    if len(found) < len(candidates):
        raise Mistake
    return found


def _candidates(body: Body, invocations: Sequence[nodes.Expression]) -> Iterator[Candidate]:
    for node in invocations:
        if isinstance(node, nodes.DictDisplay):
            for option, weight in node.entries:
                yield Candidate(body.ev.evaluate(option), option, _weight(body, body.ev.evaluate(weight), weight))
        elif isinstance(node, nodes.Starred):
            for value in items_of(body.ev.evaluate(node.value), node.span, "what `*` unpacks"):
                yield Candidate(value, node, body.ev.algebra.literal(1.0))
        else:
            yield from _named(body, body.ev.evaluate(node), node)


def _named(body: Body, value: Value, node: nodes.Expression) -> Iterator[Candidate]:
    """One behaviour, or a dictionary that has a name."""
    if not isinstance(value, Weights):
        yield Candidate(value, node, body.ev.algebra.literal(1.0))
        return
    for option, weight in value.entries:
        yield Candidate(option, node, _weight(body, weight, node))


def _weight(body: Body, value: Value, node: nodes.Expression) -> Term:
    expr = numbers.adopt(body.ev, value, PURE, node.span, WHAT)
    return in_range(body.ev, expr, Domain(WHAT, PURE), node.span)


# -- the statements ----------------------------------------------------------------------------------------------------

CLOCK_TOLERANCE = 1e-9
"""Slack of `do ... for` and `terminate after`: sums of time steps do not hit a duration exactly [s]."""


Act = Callable[[Body, nodes.Statement], ir.Block]


def _assign(body: Body, node: nodes.Assign) -> ir.Block:
    with body.ev.naming(node.targets[0]):
        value, appearing = _evaluate(body, node.value)
    acts: list[ir.Act] = list(appearing)
    for name, item in unpack(node.targets, value, node.span).items():
        acts += body.assign(name, item, node.value.span)
    return tuple(acts)


def _evaluate(body: Body, node: nodes.Expression) -> tuple[Value, ir.Block]:
    """Return the value of an expression, and the acts of an object that it lets appear."""
    if not isinstance(node, nodes.New) or not body.inliner.lets_appear:
        return body.ev.evaluate(node), ()
    appearing: list[ir.Act] = []
    with body.ev.run.built.collecting(appearing):
        value = body.ev.evaluate(node)
    return value, tuple(appearing)


def _augmented(body: Body, node: nodes.AugmentedAssign) -> ir.Block:
    name = nodes.Name(span=node.span, id=node.target)
    operation = nodes.Binary(span=node.span, operator=node.operator, left=name, right=node.value)
    value = combine(body.ev, node.operator, body.ev.evaluate(name), body.ev.evaluate(node.value), operation)
    return body.assign(node.target, value, node.span)


def _expression(body: Body, node: nodes.ExpressionStatement) -> ir.Block:
    with body.ev.naming(""):
        value, appearing = _evaluate(body, node.value)
    if appearing:
        return appearing
    check_called(value, node.span)
    if isinstance(value, Effect):
        return value.acts
    if not isinstance(value, str):
        body.ev.report(BARE_EXPRESSION.at(node.span, cure=_use_of(body, value, node.span)))
    return ()


def _use_of(body: Body, value: Value, span: Span) -> str:
    """Return a hint on how a line should use its value."""
    if isinstance(value, ActionCall | DoorCall):
        return f"an action is taken: write `take {body.ev.facts.source.slice(span)}`"
    return "assign it, or remove the line"


def _do(body: Body, node: nodes.Do) -> ir.Block:
    if node.until is not None:
        until = node.until
        return _until(body, node, lambda: body.condition(until, repeated=True))
    if node.duration is None:
        return _run(body, node)
    ev = body.ev
    start = ev.run.new_local()
    elapsed = ev.algebra.time() - ev.algebra.local(start)
    over = _duration(body, node, node.duration) <= elapsed
    return (
        ir.SetLocal(node.span, start, ev.algebra.time()),
        *_until(body, node, lambda: over),
    )


def _run(body: Body, node: nodes.Do) -> ir.Block:
    if node.mode:
        return pick(body, node)
    first, *others = node.invocations
    return body.inliner.together(body, node.invocations) if others else body.invocation(first).block(node.span)


def _until(body: Body, node: nodes.Do, condition: Callable[[], Term]) -> ir.Block:
    """The condition may speak of the scenario that is started."""
    mark, span = body.inliner.mark(), node.span
    block = _run(body, node)
    left = (*body.returned(span), *body.inliner.stopped(mark, span), ir.Abort(span))
    return (ir.TryInterrupt(span, block, ((condition(), left),)),)


def _duration(body: Body, node: nodes.Do | nodes.Wait, duration: nodes.Expression) -> Term:
    """Return a duration [s], slightly shorter than the given one, since sums of steps are inexact."""
    ev, dimension = body.ev, PURE if node.in_steps else TIME
    domain = Domain("the number of steps after `for`" if node.in_steps else "the duration after `for`", dimension)
    number = numbers.adopt(ev, ev.evaluate(duration), dimension, duration.span, domain.name)
    number = in_range(ev, number, domain, duration.span)
    seconds = number * ev.file.settings.time_step if node.in_steps else number
    return seconds - CLOCK_TOLERANCE


def _take(body: Body, node: nodes.Take) -> ir.Block:
    commands: list[tuple[Command, Term]] = []
    demands: list[ir.Act] = []
    plain = body.ev.moment.actor is not None and body.ev.moment.actor.plain
    before: list[ir.Act] = []
    for action in node.actions:
        value = body.ev.evaluate(action)
        if isinstance(value, DoorCall):
            before += value.acts
            continue
        if plain and not isinstance(value, ActionCall | BuiltinValue):
            continue  # nothing in the language moves an `Object`: its actions only end its turn
        for each in value if isinstance(value, tuple) else (value,):
            commands.append(_action(body, each, action))
            if isinstance(each, ActionCall) and each.fits is not None:
                name = f"{body.inliner.owner}: {each.name} along the heading"
                demands.append(ir.Demand(action.span, each.fits, bodies.abort_rule(body.ev, action.span, name)))
    known = [command for command, _ in commands]
    for command in known:
        if known.count(command) > 1:
            raise SAME_ACTION.mistake(node.span, command=command.name.lower())
    if not commands:
        return (*before, ir.Wait(node.span))
    return (*before, *demands, ir.Take(node.span, tuple(commands)))


def _action(body: Body, value: Value, node: nodes.Expression) -> tuple[Command, Term]:
    if isinstance(value, ActionCall):
        if body.ev.moment.actor is not None and body.ev.moment.actor.plain:
            actual = kind_name(body.ev.moment.actor)
            raise NOT_A_DRIVER.mistake(node.span, behaviour=value.name, actual=actual)
        _must_be_able(body, value, node)
        return value.command, value.value
    if isinstance(value, BuiltinValue) and value.name in names_of(Kind.ACTION):
        suggestion = f"give it a value, as in `{value.name}(1)`"
    else:
        suggestion = did_you_mean(kind_name(value).strip("`"), names_of(Kind.ACTION))
    raise NOT_AN_ACTION.mistake(node.span, actual=kind_name(value), suggestion=suggestion)


WALKING = frozenset({"SetWalkingDirectionAction", "SetWalkingSpeedAction"})


def _must_be_able(body: Body, action: ActionCall, node: nodes.Expression) -> None:
    """Refuse the reverse gear for a pedestrian, unless it is released, and walking for all other actors."""
    actor, off = body.ev.moment.actor, isinstance(action.value, ir.Literal) and not action.value.value
    if actor is None:
        return
    walks = actor.kind is ActorKind.PEDESTRIAN
    if walks and action.command is Command.REVERSE and not off:
        raise NOT_A_DRIVER.mistake(node.span, behaviour=action.name, actual=kind_name(actor))
    if not walks and action.name in WALKING:
        raise NOT_ON_FOOT.mistake(node.span, behaviour=action.name, actual=kind_name(actor))


def _wait(body: Body, node: nodes.Wait) -> ir.Block:
    """Wait for one step; until a condition holds, which is tested first; or for a duration."""
    waits, ev = (ir.Wait(node.span),), body.ev
    if node.until is not None:
        return (ir.Loop(node.span, ~body.condition(node.until, repeated=True), waits),)
    if node.duration is None:
        return waits
    start = ev.run.new_local()
    over = _duration(body, node, node.duration) <= ev.algebra.time() - ev.algebra.local(start)
    return (ir.SetLocal(node.span, start, ev.algebra.time()), ir.Loop(node.span, ~over, waits))


def _assert(body: Body, node: nodes.Assert) -> ir.Block:
    """The run is aborted where it does not hold."""
    return bodies.demand(body.ev, node, body.condition(node.condition), body.inliner.owner)


def _try(body: Body, node: nodes.Try) -> ir.Block:
    body.marks.append(body.inliner.mark())
    inner = body.nested(node.body, repeated=body.moment.repeated)
    handlers = []
    for handler in node.handlers:
        condition = body.condition(handler.condition, repeated=True)
        acts = body.nested(handler.body, repeated=True)
        check_handler(body.ev, condition, acts, handler.condition.span)
        handlers.append((condition, (*body.returned(handler.span), *acts)))
    body.marks.pop()
    return (ir.TryInterrupt(node.span, inner, tuple(handlers)),)


def _abort(body: Body, node: nodes.Abort) -> ir.Block:
    return (*body.inliner.stopped(body.marks[-1] if body.marks else 0, node.span), ir.Abort(node.span))


def _terminate(body: Body, node: nodes.Terminate) -> ir.Block:
    return body.inliner.over(body, node)


def _require(body: Body, node: nodes.Require) -> ir.Block:
    probability = soft_probability(body.ev, node.probability)
    return bodies.demand(body.ev, node, body.condition(node.condition), body.inliner.owner, probability)


def _if(body: Body, node: nodes.If) -> ir.Block:
    return _branches(body, list(node.branches), node)


def _branches(
    body: Body, branches: Sequence[tuple[nodes.Expression, tuple[nodes.Statement, ...]]], node: nodes.If
) -> ir.Block:
    """Return the block of an `if`; a branch whose condition is known at compile time is resolved here."""
    if not branches:
        return body.block(node.otherwise)
    (test, statements), rest = branches[0], branches[1:]
    condition = body.condition(test)
    if isinstance(condition, ir.Literal):
        return body.block(statements) if condition.value else _branches(body, rest, node)
    then = body.nested(statements)
    body.depth += 1
    with body.ev.run.depth.nested(test.span, otherwise=True):
        otherwise = _branches(body, rest, node)
    body.depth -= 1
    return (ir.Branch(test.span, condition, then, otherwise),)


def _leave(kind: str) -> Act:
    def act(body: Body, node: nodes.Statement) -> ir.Block:
        return (ir.Leave(node.span, kind, body.scope),)

    return act


def _nothing(_body: Body, _node: nodes.Statement) -> ir.Block:
    return ()


def _misplaced(_body: Body, _node: nodes.Statement) -> ir.Block:
    """Return nothing: the scope check has reported this misplaced statement."""
    raise Mistake


ACTS: Mapping[type, Act] = {
    nodes.Assign: _assign,
    nodes.AugmentedAssign: _augmented,
    nodes.SetAttribute: set_attribute,
    nodes.ExpressionStatement: _expression,
    nodes.Do: _do,
    nodes.Take: _take,
    nodes.Wait: _wait,
    nodes.Try: _try,
    nodes.Abort: _abort,
    nodes.Terminate: _terminate,
    nodes.If: _if,
    nodes.While: while_,
    nodes.For: for_,
    nodes.Assert: _assert,
    nodes.Break: _leave("break"),
    nodes.Continue: _leave("continue"),
    nodes.Return: _leave("return"),
    nodes.Pass: _nothing,
    nodes.Require: _require,
    **dict.fromkeys((*TOP_LEVEL, nodes.Override), _misplaced),
}  # type: ignore[dict-item]
"""Function that compiles each statement of a behaviour."""
