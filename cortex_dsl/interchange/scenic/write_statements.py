"""Statements and `new` in Scenic. An inexpressible statement stays in the file as a comment, with a remark.

Every object with a position is placed there by numbers, whatever its specifiers were.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from cortex_dsl.interchange.scenic.scenic_names import (
    LEFT_OUT_PARAMS,
    NO_LONGER,
    NOWHERE,
    Unsaid,
    comments,
    is_comment,
    verbatim,
)
from cortex_dsl.interchange.scenic.write_expressions import Expressions, heading_from_north
from cortex_dsl.semantics.model.values import Actor, Pose, Value
from cortex_dsl.semantics.names.linking import ImportedFile
from cortex_dsl.semantics.names.properties import ACTOR_KINDS
from cortex_dsl.semantics.quantities.bounds import closed_value
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes
from cortex_dsl.syntax.unparse_expressions import Level, write
from engine.errors import InterchangeError
from engine.interchange.recording import Recording
from engine.vocabulary import ActorKind, State

Block = tuple[nodes.Statement, ...]


@dataclass(frozen=True)
class Statements:
    """How each statement of a file is written in Scenic."""

    to: Expressions
    imports: Mapping[Span, ImportedFile]

    def all(self, statements: Iterable[nodes.Statement]) -> Block:
        return tuple(each for statement in statements for each in self.one(statement))

    def one(self, statement: nodes.Statement) -> Block:
        """A statement of Scenic's, several, or a comment."""
        handler = _HANDLERS.get(type(statement))
        try:
            return (self.to.parts(statement),) if handler is None else handler(self, statement)
        except Unsaid as unsaid:
            return self.left_out(statement, f"Scenic has no {unsaid.what}", unsaid.span)

    def left_out(self, statement: nodes.Statement, why: str, place: Span | None = None) -> Block:
        """A statement as a comment, with the reason."""
        self.to.sheet.remark(f"{why}: left out", place or statement.span)
        return comments(f"left out, {why}:\n{self.to.sheet.source.slice(statement.span)}")

    def block(self, statements: Iterable[nodes.Statement], idle: nodes.Statement) -> Block:
        """Return an indented block, which is never empty: `idle` is its only statement if nothing is left."""
        written = self.all(statements)
        return written if any(not is_comment(each) for each in written) else (*written, idle)


WAIT, PASS = nodes.Wait(span=NOWHERE), nodes.Pass(span=NOWHERE)


# -- the top level ----------------------------------------------------------------------------------------------------


def _nothing(_file: Statements, _node: nodes.Statement) -> Block:
    """The head of the file says it."""
    return ()


def _param(file: Statements, node: nodes.Param) -> Block:
    return tuple(each for entry in node.entries for each in _param_entry(file, entry))


def _param_entry(file: Statements, entry: nodes.ParamEntry) -> Block:
    """Write a variable, because Scenic's params are none; and the param, for programs that read a scene's params."""
    if entry.name in LEFT_OUT_PARAMS:
        return ()
    value = file.to(entry.value)
    param = replace(entry, value=verbatim(entry.name) if entry.name.isidentifier() else value)
    written = nodes.Param((param,), span=NOWHERE)
    if not entry.name.isidentifier():
        return (written,)
    unit = isinstance(entry.value, nodes.Number) and entry.value.unit not in (None, "m", "s", "m/s", "rad")
    text = verbatim(f"{write(value)}  # {write(entry.value)}") if unit else value
    return nodes.Assign((entry.name,), text, span=NOWHERE), written


def _lacking(why: str) -> Callable[[Statements, nodes.Statement], Block]:
    """A statement that Scenic has not, whatever it says."""
    return lambda file, node: file.left_out(node, why)


def _import(file: Statements, node: nodes.Import) -> Block:
    raise InterchangeError(
        "an imported file under a name of its own cannot be put into one Scenic file",
        "import the names from it, as in `from cars import Taxi`",
        f"line {file.to.sheet.source.position(node.span.start).line}",
    )


def _import_from(file: Statements, node: nodes.ImportFrom) -> Block:
    """Return the definitions of the imported file in place of the import."""
    if any(each.alias is not None for each in node.names):
        raise InterchangeError(
            "an import under another name cannot be put into one Scenic file",
            "leave `as` out",
            f"line {file.to.sheet.source.position(node.span.start).line}",
        )
    module = file.imports[node.span].module
    return (*comments(f"from {node.path}:"), *file.all(module.statements))


def _require(file: Statements, node: nodes.Require) -> Block:
    """Scenic takes a probability as a number only."""
    probability = None if node.probability is None else file.to(node.probability)
    if probability is not None and not isinstance(probability, nodes.Number):
        raise Unsaid("probability that is computed", node.span)
    return (replace(node, condition=file.to(node.condition), probability=probability),)


def _class(file: Statements, node: nodes.ClassDefinition) -> Block:
    base = node.base or "Object"
    file.to.declare(base)
    return (replace(file.to.parts(node), base=base),)


def _terminate_after(file: Statements, node: nodes.TerminateAfter) -> Block:
    return (replace(node, amount=_seconds(file, node.amount, node.in_steps)),)


def _seconds(file: Statements, amount: nodes.Expression, in_steps: bool) -> nodes.Expression:
    """Scenic wants a word behind every time."""
    written = file.to(amount)
    bare = isinstance(written, nodes.Number) and written.unit is None
    return written if in_steps or bare else verbatim(f"{write(written, Level.OR)} seconds")


# -- blocks -----------------------------------------------------------------------------------------------------------


def _behaviour(file: Statements, node: nodes.BehaviorDefinition) -> Block:
    return (
        replace(
            node,
            parameters=tuple(map(file.to.parts, node.parameters)),
            preconditions=_guards(file, node.preconditions),
            invariants=_guards(file, node.invariants),
            body=file.block(node.body, WAIT),
        ),
    )


def _guards(file: Statements, guards: Iterable[nodes.Guard]) -> tuple[nodes.Guard, ...]:
    return tuple(file.to.parts(guard) for guard in guards)


def _monitor(file: Statements, node: nodes.MonitorDefinition) -> Block:
    return (replace(node, parameters=tuple(map(file.to.parts, node.parameters)), body=file.block(node.body, WAIT)),)


def _scenario(file: Statements, node: nodes.ScenarioDefinition) -> Block:
    return (
        replace(
            node,
            parameters=tuple(map(file.to.parts, node.parameters)),
            preconditions=_guards(file, node.preconditions),
            invariants=_guards(file, node.invariants),
            setup=file.block(node.setup, PASS) if node.setup else (),
            compose=file.block(node.compose, WAIT) if node.compose else (),
        ),
    )


def _lasting(file: Statements, node: nodes.Do | nodes.Wait) -> Block:
    written = file.to.parts(replace(node, duration=None))
    if node.duration is None:
        return (written,)
    return (replace(written, duration=_seconds(file, node.duration, node.in_steps)),)


def _try(file: Statements, node: nodes.Try) -> Block:
    """Return a `try`; an interrupt with an inexpressible condition is left out alone."""
    handlers, comments = [], ()
    for handler in node.handlers:
        try:
            condition = file.to(handler.condition)
        except Unsaid as unsaid:
            lost = nodes.ExpressionStatement(handler.condition, span=handler.span)
            comments += file.left_out(lost, f"Scenic has no {unsaid.what}", unsaid.span)
            continue
        handlers.append(replace(handler, condition=condition, body=file.block(handler.body, WAIT)))
    body = file.block(node.body, WAIT)
    return (*comments, replace(node, body=body, handlers=tuple(handlers))) if handlers else (*comments, *body)


def _if(file: Statements, node: nodes.If) -> Block:
    branches = tuple((file.to(condition), file.block(body, PASS)) for condition, body in node.branches)
    return (replace(node, branches=branches, otherwise=file.block(node.otherwise, PASS) if node.otherwise else ()),)


def _while(file: Statements, node: nodes.While) -> Block:
    return (replace(node, condition=file.to(node.condition), body=file.block(node.body, WAIT)),)


_HANDLERS: Mapping[type, Callable[[Statements, Any], Block]] = {
    nodes.Map: _nothing,
    nodes.Model: _nothing,
    nodes.Simulation: _nothing,
    nodes.Mutate: _nothing,
    nodes.Signals: _lacking("traffic lights, which Scenic's driving library does not have"),
    nodes.Environment: _lacking("the environment: Scenic's driving library knows neither grip nor fog"),
    nodes.Expect: _lacking("Scenic has no `expect`"),
    nodes.Optimize: _lacking("Scenic has neither `maximize` nor `minimize`"),
    nodes.Domain: _lacking("Scenic has no `domain`"),
    nodes.Param: _param,
    nodes.Import: _import,
    nodes.ImportFrom: _import_from,
    nodes.Require: _require,
    nodes.ClassDefinition: _class,
    nodes.TerminateAfter: _terminate_after,
    nodes.BehaviorDefinition: _behaviour,
    nodes.MonitorDefinition: _monitor,
    nodes.ScenarioDefinition: _scenario,
    nodes.Do: _lasting,
    nodes.Wait: _lasting,
    nodes.Try: _try,
    nodes.If: _if,
    nodes.While: _while,
}

# -- `new` -------------------------------------------------------------------------------------------------------------

SIZES = ("width", "length")


@dataclass(frozen=True)
class Stand:
    """Where something stood: metres, and the heading from the east [rad]."""

    x: float
    y: float
    heading: float

    def specifiers(self) -> list[nodes.Specifier]:
        """Scenic's headings are measured from the north."""
        place, heading = f"({self.x!r}, {self.y!r})", repr(self.heading - math.pi / 2.0)
        return [nodes.At(verbatim(place), span=NOWHERE), nodes.Facing(verbatim(heading), span=NOWHERE)]


def made(to: Expressions, node: nodes.New) -> nodes.New:
    """Return a `new` translated to Scenic."""
    to.declare(node.class_name)
    value = to.value(node)
    stand = _stand(value, to.recording)
    given = [each for each in node.specifiers if isinstance(each, nodes.With)]
    given_properties = (each for with_ in given for each in _property(to, with_))
    placed = stand.specifiers() if stand else list(map(partial(_placing, to), _placings(node)))
    added = _sizes(value, to.recording, given) if isinstance(value, Actor) else []
    return replace(node, specifiers=(*placed, *given_properties, *added, *_free(to, node)))


def _free(to: Expressions, node: nodes.New) -> Iterator[nodes.Specifier]:
    """Yield specifiers that free an object from the road and from the ego's view at the start.

    Scenic requires both of every `Object` except those of its driving library.
    """
    if node.class_name in ("Point", "OrientedPoint"):
        return
    yield _with("regionContainedIn", "everywhere")
    seen = {to.recording.actors[each.index].kind for each in to.known_values(node.span) if isinstance(each, Actor)}
    if ActorKind.OBSTACLE in (seen or {ACTOR_KINDS.get(node.class_name)}):
        yield _with("requireVisible", "False")


def _stand(value: Value, recording: Recording) -> Stand | None:
    """Return the first pose of an object, or the pose of a place; None if it is not unique."""
    if isinstance(value, Actor):
        return _first_seen(value.index, recording)
    if isinstance(value, Pose):
        x, y, heading = map(closed_value, (value.x, value.y, value.heading))
        if x is not None and y is not None and heading is not None:
            return Stand(x, y, heading)
    return None


def _first_seen(actor: int, recording: Recording) -> Stand | None:
    for first, _ in recording.stretches(actor):
        state = recording.states[first, actor]
        return Stand(float(state[State.X]), float(state[State.Y]), float(state[State.HEADING]))
    return None


def _placings(node: nodes.New) -> Iterator[nodes.Specifier]:
    return (each for each in node.specifiers if not isinstance(each, nodes.With))


def _placing(to: Expressions, specifier: nodes.Specifier) -> nodes.Specifier:
    """Return the specifier of an object that has no unique place."""
    if isinstance(specifier, nodes.Before):
        raise Unsaid(f"`{'after' if isinstance(specifier, nodes.After) else 'before'} … by`", specifier.span)
    if isinstance(specifier, nodes.Facing) and not specifier.mode:
        return replace(specifier, heading=heading_from_north(to, specifier.heading))
    return to.parts(specifier)


def _property(to: Expressions, specifier: nodes.With) -> Iterator[nodes.Specifier]:
    """A property, unless every object gets it, or its value cannot be said."""
    if specifier.property in NO_LONGER:
        return
    try:
        yield to.parts(specifier)
    except Unsaid as unsaid:
        remark = f"Scenic has no {unsaid.what}: `with {specifier.property}` is left out"
        to.sheet.remark(remark, unsaid.span)


def _sizes(actor: Actor, recording: Recording, given: Sequence[nodes.With]) -> list[nodes.Specifier]:
    """Length and width, unless the author gives them."""
    recorded = recording.actors[actor.index]
    said = {specifier.property for specifier in given}
    return [_with(name, repr(float(getattr(recorded, name)))) for name in SIZES if name not in said]


def _with(name: str, value: str) -> nodes.Specifier:
    return nodes.With(name, verbatim(value), span=NOWHERE, property_span=NOWHERE)
