"""`new`: points, and the objects of the scene with all their properties."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from cortex_dsl import ir
from cortex_dsl.diagnostics import Label
from cortex_dsl.semantics import errors, geometry, numbers
from cortex_dsl.semantics.calls import as_behaviour
from cortex_dsl.semantics.classes import (
    ACTOR_KINDS,
    CLASSES,
    FLAGS,
    IGNORED,
    MODEL_FIELDS,
    OFF_ROAD,
    PROPERTIES,
    all_properties,
)
from cortex_dsl.semantics.context import Evaluator
from cortex_dsl.semantics.functions import known_truth
from cortex_dsl.semantics.problems import Mistake, Problem
from cortex_dsl.semantics.specifiers import Extent, Placement, place
from cortex_dsl.semantics.values import POISON, Actor, Pose, Value, Vector, kind_name
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes
from engine.vehicles import MODELS, ActorModel
from engine.vocabulary import ActorKind, Op


@dataclass
class Sorted:
    """The specifiers of one `new` by what they say."""

    places: list[nodes.Specifier] = field(default_factory=list)
    facings: list[nodes.Facing] = field(default_factory=list)
    properties: list[nodes.With] = field(default_factory=list)


def new(ev: Evaluator, node: nodes.New) -> Value:
    if node.class_name not in CLASSES:
        raise errors.UNKNOWN_CLASS.mistake(
            node.class_span, name=node.class_name, suggestion=did_you_mean(node.class_name, CLASSES)
        )
    if ev.moment.running:
        raise errors.NOT_SUPPORTED.mistake(
            node.span, what="objects cannot be made during the run", reason="", cure="make it outside the behavior"
        )
    sorted_ = _sorted(node)
    kind = ACTOR_KINDS.get(node.class_name)
    return _new_place(ev, node, sorted_) if kind is None else _new_actor(ev, node, kind, sorted_)


def _sorted(node: nodes.New) -> Sorted:
    result = Sorted()
    for specifier in node.specifiers:
        if isinstance(specifier, nodes.With):
            result.properties.append(specifier)
        elif isinstance(specifier, nodes.Facing):
            result.facings.append(specifier)
        else:
            result.places.append(specifier)
    _at_most_one(errors.TWO_PLACES, node, result.places)
    _at_most_one(errors.TWO_HEADINGS, node, result.facings)
    return result


def _at_most_one(problem: Problem, node: nodes.New, found: Sequence[nodes.Specifier]) -> None:
    if len(found) > 1:
        raise problem.mistake(found[1].span, name=node.class_name, secondary=(Label(found[0].span, "first here"),))


# -- points -----------------------------------------------------------------------------------------------------------


def _new_place(ev: Evaluator, node: nodes.New, found: Sorted) -> Value:
    for with_ in found.properties:
        raise errors.UNKNOWN_PROPERTY.mistake(
            with_.property_span, kind=f"a place (`{node.class_name}`)", name=with_.property, suggestion=""
        )
    if not found.places:
        raise errors.NO_PLACE.mistake(node.span, name=node.class_name)
    zero = ev.algebra.literal(0.0)
    placement = place(ev, found.places[0], Extent(zero, zero))
    if node.class_name == "Point":
        if found.facings:
            raise errors.NOT_SUPPORTED.mistake(
                found.facings[0].span, what="a Point has no heading", reason="", cure="make it an `OrientedPoint`"
            )
        _record(ev, found.places[0].span, placement, None)
        return placement.point
    return _posed(ev, found, placement, zero)


def _posed(ev: Evaluator, found: Sorted, placement: Placement, default: ir.Expr) -> Pose:
    """Place and heading together."""
    if found.facings:
        heading = _faced(ev, found.facings[0], placement.point)
        _record(ev, found.places[0].span, placement, None)
        return Pose(placement.point.x, placement.point.y, heading)
    heading = placement.heading or default
    _record(ev, found.places[0].span, placement, heading)
    return Pose(placement.point.x, placement.point.y, heading, placement.lane)


def _record(ev: Evaluator, span: Span, placement: Placement, heading: ir.Expr | None) -> None:
    """Note down what a specifier drew, for concrete copies."""
    if placement.drawn:
        values = (placement.point.x, placement.point.y, *(() if heading is None else (heading,)))
        ev.run.draw_sites.append(ir.DrawSite(span, "point" if heading is None else "pose", "", values))


def _faced(ev: Evaluator, node: nodes.Facing, point: Vector) -> ir.Expr:
    value = ev.evaluate(node.heading)
    if not node.mode:
        return geometry.heading_at(ev, value, point, node.heading.span)
    target = geometry.position(ev, value, node.heading.span, f"what follows `facing {node.mode}`")
    pair = (point, target) if node.mode == "toward" else (target, point)
    return geometry.bearing(ev, *pair)


# -- objects ----------------------------------------------------------------------------------------------------------


def _new_actor(ev: Evaluator, node: nodes.New, kind: ActorKind, found: Sorted) -> Value:
    own_name = ev.run.assigning
    if not found.places:
        raise errors.NO_PLACE.mistake(node.span, name=node.class_name)
    with ev.naming(""):
        properties = _properties(ev, kind, found.properties)
        placement = _actor_placement(ev, found, properties)
        default = ev.algebra.literal(0.0) if kind in OFF_ROAD else geometry.road_heading(ev, placement.point)
        pose = _posed(ev, found, placement, default)
    named = properties.get("name")
    name = named if isinstance(named, str) else own_name or f"{kind.name.lower()}{len(ev.run.actors) + 1}"
    actor = Actor(len(ev.run.actors), _unique(ev, name), kind, node.span, pose, properties)
    ev.run.actors.append(actor)
    return actor


def _unique(ev: Evaluator, name: str) -> str:
    taken = {actor.name for actor in ev.run.actors}
    number = 2
    unique = name
    while unique in taken:
        unique, number = f"{name}{number}", number + 1
    return unique


def _actor_placement(ev: Evaluator, found: Sorted, properties: dict[str, Value]) -> Placement:
    length, width = properties["length"], properties["width"]
    assert isinstance(length, ir.Expr)
    assert isinstance(width, ir.Expr)
    return place(ev, found.places[0], Extent(length, width))


def _properties(ev: Evaluator, kind: ActorKind, given: Sequence[nodes.With]) -> dict[str, Value]:
    """Every property of an object: those given, then the defaults of its kind."""
    properties: dict[str, Value] = {}
    seen: dict[str, Span] = {}
    broken = False
    for with_ in given:
        if with_.property in seen:
            first = Label(seen[with_.property], "first here")
            raise errors.PROPERTY_TWICE.mistake(with_.property_span, name=with_.property, secondary=(first,))
        seen[with_.property] = with_.property_span
        value = ev.tolerate(lambda with_=with_: _property(ev, kind, with_))
        broken = broken or value is POISON
        properties[with_.property] = value
    if broken:
        raise Mistake
    return _with_defaults(ev, MODELS[kind], properties)


def _property(ev: Evaluator, kind: ActorKind, node: nodes.With) -> Value:
    name, span = node.property, node.value.span
    if name in IGNORED:
        ev.evaluate(node.value)
        return None
    if name not in PROPERTIES and name not in FLAGS:
        raise errors.UNKNOWN_PROPERTY.mistake(
            node.property_span,
            kind=f"a {kind.name.capitalize()}",
            name=name,
            suggestion=did_you_mean(name, all_properties()),
        )
    with ev.naming(f"{name}"):
        value = ev.evaluate(node.value)
    if name in FLAGS:
        return _flag(ev, kind, name, value, span)
    spec = PROPERTIES[name]
    expr = numbers.adopt(ev, value, spec.dimension, span, f"`{name}`")
    return numbers.in_range(ev, expr, spec.low, spec.high, spec.dimension, span, f"`{name}`", above=spec.above)


def _flag(ev: Evaluator, kind: ActorKind, name: str, value: Value, span: Span) -> Value:
    if name == "behavior":
        return _behaviour(kind, value, span)
    if name == "allowCollisions":
        return known_truth(ev, value, span, "`allowCollisions`")
    if name == "name" and not isinstance(value, str):
        raise errors.WRONG_KIND.mistake(span, what="`name`", expected="text", actual=kind_name(value), cure="")
    return value


def _behaviour(kind: ActorKind, value: Value, span: Span) -> Value:
    if value is None:
        return None
    behaviour = as_behaviour(value, span)
    if behaviour is None:
        raise errors.WRONG_KIND.mistake(
            span, what="`behavior`", expected="a behavior", actual=kind_name(value), cure="as in `FollowLaneBehavior()`"
        )
    if kind == ActorKind.OBSTACLE:
        raise errors.OBSTACLE_BEHAVIOUR.mistake(span)
    return behaviour


def _with_defaults(ev: Evaluator, model: ActorModel, given: dict[str, Value]) -> dict[str, Value]:
    """Fill in what was not given; a longer car has its axles further apart."""
    result = dict(given)
    algebra = ev.algebra
    result.setdefault("speed", algebra.literal(0.0))
    for name, column in MODEL_FIELDS.items():
        default: ir.Expr = algebra.literal(float(getattr(model, column)))
        if name in ("wheelbase", "rearToCenter") and "length" in given:
            length = result["length"]
            assert isinstance(length, ir.Expr)
            scale = algebra.apply(Op.DIV, length, algebra.literal(model.length))
            default = algebra.mul(default, scale)
        result.setdefault(name, default)
    return result
