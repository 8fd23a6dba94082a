"""Visibility: `can see`, the perception of drivers of the library, and `requireVisible`."""

import math

from cortex_dsl.semantics.evaluation import geometry
from cortex_dsl.semantics.evaluation.surroundings import in_environment
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import Actor, Pose, Sighted, Truth, Value, Vector
from cortex_dsl.semantics.quantities.algebra import Term
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes


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
