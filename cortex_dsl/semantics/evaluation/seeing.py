"""Visibility: `can see`, the perception of drivers, `requireVisible`, and what `environment` takes from it."""

import math

from cortex_dsl.semantics.errors.names import DUPLICATE, NOT_SUPPORTED, UNKNOWN_ARGUMENT
from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.errors.scene import ENVIRONMENT_LATE, ENVIRONMENT_TWICE
from cortex_dsl.semantics.evaluation import geometry, numbers
from cortex_dsl.semantics.evaluation.arguments import Given, evaluate_arguments
from cortex_dsl.semantics.evaluation.ranges import within
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.state import Environment
from cortex_dsl.semantics.model.values import Actor, Pose, Sighted, Truth, Value, Vector
from cortex_dsl.semantics.names.properties import ENVIRONMENT, Domain
from cortex_dsl.semantics.quantities.algebra import Term, minimum
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes

# -- the `environment` statement ---------------------------------------------------------------------------------------


def set_environment(ev: Evaluator, node: nodes.Environment) -> None:
    """`environment(...)`: the weather of the whole run."""
    if ev.run.built.environment is not None:
        raise ENVIRONMENT_TWICE.mistake(node.span)
    ev.run.built.environment = Environment({}, node.span)
    if ev.run.built.actors:
        raise ENVIRONMENT_LATE.mistake(node.span, name=ev.run.built.actors[0].name)
    values: dict[str, Term] = {}
    for argument in evaluate_arguments(ev, node.arguments):
        try:
            name = _name(argument, values)
            values[name] = _value(ev, argument, ENVIRONMENT[name])
        except Mistake as mistake:
            ev.report(mistake)
    ev.run.built.environment = Environment(values, node.span)


def _name(argument: Given, seen: dict[str, Term]) -> str:
    name = argument.name
    if name is None:
        what = "`environment` takes its arguments by name"
        raise NOT_SUPPORTED.mistake(argument.span, what=what, reason="", cure="as in `friction=0.4`")
    if name not in ENVIRONMENT:
        suggestion = did_you_mean(name, ENVIRONMENT)
        raise UNKNOWN_ARGUMENT.mistake(argument.place, function="environment", name=name, suggestion=suggestion)
    if name in seen:
        raise DUPLICATE.mistake(argument.place, what="the argument", name=name)
    return name


def _value(ev: Evaluator, argument: Given, spec: Domain) -> Term:
    what = f"the {spec.name} of the environment"
    expr = numbers.adopt(ev, argument.value, spec.dimension, argument.span, what)
    return within(ev, expr, spec, argument.span, what)


def in_environment(ev: Evaluator, name: str, value: Term) -> Term:
    """Return a property of an object under the conditions of the environment."""
    given = {} if ev.run.built.environment is None else ev.run.built.environment.values
    if name == "friction" and "friction" in given:
        return value * given["friction"]
    if name == "visibleDistance":
        value = value * given["light"] if "light" in given else value
        return minimum(value, given["sight"]) if "sight" in given else value
    return value


def sees(ev: Evaluator, viewer: Value, other: Actor) -> Term:
    """Return whether an object, or an oriented point, sees a part of another outline."""
    return _seen(ev, viewer, other, ev.algebra.span, ev.algebra.span)


def unhidden(ev: Evaluator, viewer: Actor, other: Actor) -> Term:
    """Return whether no object hides one object from another, in any direction: the perception of library drivers."""
    return ev.algebra.notices(viewer.index, other.index, notice_reach(ev))


def notice_reach(ev: Evaluator) -> Term:
    """Return the range within which drivers of the library notice other actors: the visibility of the weather [m]."""
    weather, unlimited = ev.run.built.environment, ev.algebra.literal(math.inf)
    return unlimited if weather is None else weather.values.get("sight", unlimited)


def _seen(ev: Evaluator, viewer: Value, target: Value, viewer_span: Span, target_span: Span) -> Term:
    """Return whether a part of an outline, or a place, is visible to an object, or from a point in any direction."""
    if not ev.moment.running:
        view, outline = _view(ev, viewer, viewer_span), geometry.outline(ev, target, target_span)
        return ev.algebra.look(view, outline, len(ev.run.built.actors))
    nothing = ev.algebra.literal(0.0)
    one, view = (viewer.index, nothing) if isinstance(viewer, Actor) else (-1, _view(ev, viewer, viewer_span))
    if isinstance(target, Actor):
        return ev.algebra.sees(one, target.index, view, nothing)
    return ev.algebra.sees(one, -1, view, geometry.outline(ev, target, target_span))


def _view(ev: Evaluator, viewer: Value, span: Span) -> Term:
    """Return a view packed as x, y, heading, opening angle and reach, and the number of the viewer."""
    looks = geometry.viewer(ev, viewer, span)
    pose, view = geometry.looking(ev, looks), geometry.view_of(ev, looks)
    number = ev.algebra.number_of(looks) if isinstance(looks, Actor) else ev.algebra.literal(-1.0)
    reach = in_environment(ev, "visibleDistance", view.reach)
    return ev.algebra.pack(pose.x, pose.y, pose.heading, view.opening, reach, number)


def can_see(ev: Evaluator, node: nodes.CanSee) -> Value:
    viewer, target = ev.evaluate_all((node.viewer, node.target))
    return Truth(_seen(ev, viewer, target, node.viewer.span, node.target.span))


def observer(ev: Evaluator, node: nodes.InSight | nodes.VisiblePart) -> Actor | Pose | Vector:
    """Return the viewer: the ego, or the operand after `from`."""
    if node.viewer is None:
        return geometry.ego_of(ev, node.span, "what is visible")
    return geometry.viewer(ev, ev.evaluate(node.viewer), node.viewer.span)


def visible_part(ev: Evaluator, node: nodes.VisiblePart) -> Value:
    """Return the part of a region that the ego, or the operand after `from`, sees or does not see.

    Occlusion is ignored, as in Scenic.
    """
    return Sighted(ev.evaluate(node.region), observer(ev, node), node.seen)
