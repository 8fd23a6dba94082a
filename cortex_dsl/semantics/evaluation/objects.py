"""`new`: points, and the objects of the scene with all their properties; `mutate`: normal noise on the pose of what is
made under a name.

`mutate` stands below the objects, but what is placed relative to a mutated object sees the mutated pose. So the
statements of a scope are known before its objects are made. (Scenic adds the noise when all has been placed. Here a
pose is the same wherever it is read, so that a concrete copy, which writes it down, places all others where they were.)
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from cortex_dsl import ir
from cortex_dsl.diagnostics import Label
from cortex_dsl.semantics.errors.names import UNKNOWN_CLASS, UNKNOWN_PROPERTY
from cortex_dsl.semantics.errors.objects import CANNOT_MUTATE, MUTATED_ALIAS, NO_PLACE, TWO_HEADINGS, TWO_PLACES
from cortex_dsl.semantics.errors.problems import Problem
from cortex_dsl.semantics.errors.statements import NOT_SUPPORTED
from cortex_dsl.semantics.evaluation import geometry, numbers
from cortex_dsl.semantics.evaluation.geometry import as_meant, as_written
from cortex_dsl.semantics.evaluation.making import Making, own_class
from cortex_dsl.semantics.evaluation.random_values import SMALLEST_UNIFORM
from cortex_dsl.semantics.evaluation.specifiers import Extent, Placement, place
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import Actor, Pose, Value, Vector
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.names.builtins import ACTOR_KINDS, CLASSES, OFF_ROAD
from cortex_dsl.semantics.quantities.algebra import Term, maximum, normal_quantile, road_heading
from cortex_dsl.semantics.quantities.units import PURE
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes

# -- noise -------------------------------------------------------------------------------------------------------------

POSITION_DEVIATION = 1.0
"""Standard deviation of x and of y at scale 1, as in Scenic [m]."""
HEADING_DEVIATION = math.radians(5.0)
"""Of the heading, as in Scenic [rad]."""


def announce(ev: Evaluator, statements: Sequence[nodes.Statement]) -> None:
    """Remember what a scope will mutate, before its statements run."""
    ev.run.built.mutations[ev.scope_name] = [s for s in statements if isinstance(s, nodes.Mutate)]


def mutated(ev: Evaluator, name: str, node: nodes.New, pose: Pose) -> Pose | None:
    """The pose with its noise; None where nothing mutates what is called `name`."""
    statement = _statement(ev, name, node)
    if statement is None:
        return None
    if name:
        ev.run.built.mutated.add((ev.scope_name, name))
    scale = _scale(ev, statement)
    x, y, heading = (
        _noisy(ev, number, scale, deviation)
        for number, deviation in (
            (pose.x, POSITION_DEVIATION),
            (pose.y, POSITION_DEVIATION),
            (pose.heading, HEADING_DEVIATION),
        )
    )
    return Pose(x, y, heading)


def _statement(ev: Evaluator, name: str, node: nodes.New) -> nodes.Mutate | None:
    """The last one that means this object; without names it means all objects above it."""
    found = None
    for statement in ev.run.built.mutations.get(ev.scope_name, ()):
        everything = not statement.targets and node.span.start < statement.span.start
        if name in statement.targets or (everything and node.class_name not in ("Point", "OrientedPoint")):
            found = statement
    return found


def _scale(ev: Evaluator, node: nodes.Mutate) -> Term:
    if node.amount is None:
        return ev.algebra.literal(1.0)
    scale = numbers.adopt(ev, ev.evaluate(node.amount), PURE, node.amount.span, "the scale of `mutate`")
    return numbers.in_range(ev, scale, 0.0, math.inf, PURE, node.amount.span, "the scale of `mutate`")


def _noisy(ev: Evaluator, number: Term, scale: Term, deviation: float) -> Term:
    positive = maximum(ev.run.new_draw(), SMALLEST_UNIFORM)
    noise = deviation * normal_quantile(positive)
    return number + scale * noise


def record(
    ev: Evaluator,
    node: nodes.New,
    places: Sequence[nodes.Specifier],
    facings: Sequence[nodes.Facing],
    pose: Pose,
) -> None:
    """Note down the mutated pose where a concrete copy will say it."""
    point, heading = (pose.x, pose.y), (pose.heading,)
    site = places[0].span if places else node.class_span
    suffix = "" if places else " added"
    if not facings:
        ev.run.decisions.draw_sites.append(ir.DrawSite(site, f"pose{suffix}", "", (*point, *heading)))
        return
    ev.run.decisions.draw_sites.append(ir.DrawSite(site, f"point{suffix}", "", point))
    ev.run.decisions.draw_sites.append(ir.DrawSite(facings[0].span, "heading", "", heading))


def mutate(ev: Evaluator, node: nodes.Mutate) -> None:
    """The statement itself: its objects must have been made under these names."""
    for name in node.targets:
        value = ev.lookup(name, node.span)
        if not isinstance(value, Actor | Pose):
            cure = did_you_mean(name, _objects(ev))
            raise CANNOT_MUTATE.mistake(node.span, name=name, actual=kind_name(value), cure=cure)
        if (ev.scope_name, name) not in ev.run.built.mutated:
            raise MUTATED_ALIAS.mistake(node.span, name=name)


def _objects(ev: Evaluator) -> list[str]:
    return [name for name, value in ev.scope.items() if isinstance(value, Actor | Pose)]


# -- new ---------------------------------------------------------------------------------------------------------------


@dataclass
class Sorted:
    """The specifiers of one `new` by what they say."""

    places: list[nodes.Specifier] = field(default_factory=list)
    facings: list[nodes.Facing] = field(default_factory=list)
    properties: list[nodes.With] = field(default_factory=list)


def new(ev: Evaluator, node: nodes.New) -> Value:
    own = own_class(ev, node.class_name)
    if own is None and node.class_name not in CLASSES:
        known = {*CLASSES, *(name for name in ev.known_names() if own_class(ev, name) is not None)}
        raise UNKNOWN_CLASS.mistake(
            node.class_span,
            name=node.class_name,
            suggestion=did_you_mean(node.class_name, known)
            or "as in `new Car`; for what stands still and is no vehicle, `new Obstacle`",
        )
    if ev.moment.running or ev.moment.later:
        raise NOT_SUPPORTED.mistake(
            node.span,
            what="objects cannot be made during the run",
            reason="",
            cure="make it outside the behavior, at the top level or in a `setup`",
        )
    sorted_ = _sorted(node)
    kind = ACTOR_KINDS.get(node.class_name) if own is None else own.kind
    if kind is None:
        return _new_place(ev, node, sorted_)
    builtin = node.class_name if own is None else (own, *own.bases)[-1].node.base
    return _new_actor(ev, node, sorted_, Making(ev, kind, own, builtin, sorted_.properties))


def _sorted(node: nodes.New) -> Sorted:
    result = Sorted()
    for specifier in node.specifiers:
        if isinstance(specifier, nodes.With) and specifier.property == "heading":
            result.facings.append(nodes.Facing(span=specifier.span, heading=specifier.value, mode=""))
        elif isinstance(specifier, nodes.With):
            result.properties.append(specifier)
        elif isinstance(specifier, nodes.Facing):
            result.facings.append(specifier)
        else:
            result.places.append(specifier)
    _at_most_one(TWO_PLACES, node, result.places)
    _at_most_one(TWO_HEADINGS, node, result.facings)
    return result


def _at_most_one(problem: Problem, node: nodes.New, found: Sequence[nodes.Specifier]) -> None:
    if len(found) > 1:
        raise problem.mistake(found[1].span, name=node.class_name, secondary=(Label(found[0].span, "first here"),))


# -- points -----------------------------------------------------------------------------------------------------------


def _new_place(ev: Evaluator, node: nodes.New, found: Sorted) -> Value:
    for with_ in found.properties:
        raise UNKNOWN_PROPERTY.mistake(
            with_.property_span, kind=f"a place (`{node.class_name}`)", name=with_.property, suggestion=""
        )
    if not found.places:
        raise NO_PLACE.mistake(node.span, name=node.class_name)
    zero = ev.algebra.literal(0.0)
    placement = place(ev, found.places[0], Extent(zero, zero))
    if node.class_name == "Point":
        if found.facings:
            raise NOT_SUPPORTED.mistake(
                found.facings[0].span, what="a Point has no heading", reason="", cure="make it an `OrientedPoint`"
            )
        pose = Pose(placement.point.x, placement.point.y, zero)
        moved = mutated(ev, ev.run.assigning, node, pose)
        if moved is not None:
            pose, placement = moved, replace(placement, drawn=True, point=Vector(moved.x, moved.y))
        _record(ev, found.places[0].span, placement, None)
        return placement.point
    return _posed(ev, node, found, placement, zero, ev.run.assigning)


def _posed(ev: Evaluator, node: nodes.New, found: Sorted, placement: Placement, default: Term, name: str) -> Pose:
    """Place and heading together, with the noise that `mutate` puts on what is called `name`."""
    heading = default if placement.heading is None else placement.heading
    if found.facings:
        heading = _faced(ev, found.facings[0], placement.point)
    lane = None if found.facings else placement.lane
    pose = Pose(placement.point.x, placement.point.y, heading, lane)
    moved = mutated(ev, name, node, pose)
    if moved is not None:
        written = as_written(ev, moved.heading)
        record(ev, node, found.places, found.facings, replace(moved, heading=written))
        return replace(moved, heading=as_meant(ev, written))
    if not found.places or found.facings or not placement.drawn:
        if found.places:
            _record(ev, found.places[0].span, placement, None)
        return pose
    # The copy of a case gives the heading as its file counts it, so it must be made of that number here too.
    written = as_written(ev, heading)
    _record(ev, found.places[0].span, placement, written)
    return replace(pose, heading=as_meant(ev, written))


def _record(ev: Evaluator, span: Span, placement: Placement, heading: Term | None) -> None:
    """Note down what a specifier drew, for concrete copies."""
    if placement.drawn:
        values = (placement.point.x, placement.point.y, *(() if heading is None else (heading,)))
        ev.run.decisions.draw_sites.append(ir.DrawSite(span, "point" if heading is None else "pose", "", values))


def _faced(ev: Evaluator, node: nodes.Facing, point: Vector) -> Term:
    value = ev.evaluate(node.heading)
    if not node.mode:
        return geometry.heading_at(ev, value, point, node.heading.span)
    target = geometry.position(ev, value, node.heading.span, f"what follows `facing {node.mode}`")
    pair = (point, target) if node.mode == "toward" else (target, point)
    return geometry.bearing(*pair)


# -- objects ----------------------------------------------------------------------------------------------------------


def _new_actor(ev: Evaluator, node: nodes.New, found: Sorted, making: Making) -> Value:
    own_name, kind = ev.run.assigning, making.kind
    if not found.places and not making.declares("position"):
        raise NO_PLACE.mistake(node.span, name=node.class_name)
    making.posed = lambda: _actor_pose(making, node, found, own_name)
    with ev.naming(""):
        properties, pose = making.properties(), making.pose(node.span)
    named = properties.get("name")
    name = named if isinstance(named, str) else own_name or f"{kind.name.lower()}{len(ev.run.built.actors) + 1}"
    actor = Actor(-1, _unique(ev, name), kind, node.span, pose, properties, ev.moment.scenario)
    ev.run.built.actors.append(actor)
    return actor


def _actor_pose(making: Making, node: nodes.New, found: Sorted, name: str) -> Pose:
    ev = making.ev
    placement = _actor_placement(making, found)
    if (heading := making.default_heading(placement.point)) is not None:
        placement = replace(placement, heading=heading, lane=None)
    off_road = making.kind in OFF_ROAD
    default = ev.algebra.literal(0.0) if off_road else road_heading(placement.point.x, placement.point.y)
    return _posed(ev, node, found, placement, default, name)


def _unique(ev: Evaluator, name: str) -> str:
    taken = {actor.name for actor in ev.run.built.actors}
    number = 2
    unique = name
    while unique in taken:
        unique, number = f"{name}{number}", number + 1
    return unique


def _actor_placement(making: Making, found: Sorted) -> Placement:
    if not found.places:
        return making.default_place()
    length, width = making.get("length"), making.get("width")
    assert isinstance(length, Term)
    assert isinstance(width, Term)
    return place(making.ev, found.places[0], Extent(length, width))
