"""`distance from … to …` and `intersects`: between places, outlines, lines and regions."""

from cortex_dsl.semantics.errors.names import NOT_SUPPORTED
from cortex_dsl.semantics.evaluation.geometry import between, ego_of, outline, position, region_of
from cortex_dsl.semantics.evaluation.lanes import of_each
from cortex_dsl.semantics.model.areas import Area
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import Actor, Centerline, Quantity, Truth, Value
from cortex_dsl.semantics.quantities.algebra import (
    Term,
    box_distance,
    path_distance,
    region_box_distance,
    region_distance,
    where,
)
from cortex_dsl.semantics.quantities.units import LENGTH
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes


def distance(ev: Evaluator, node: nodes.Distance) -> Value:
    """Centre to centre, or centre to region; with `minimum` from outline to outline, or outline to region."""
    origin = ev.evaluate(node.origin) if node.origin is not None else ego_of(ev, node.span, "a `distance to`")
    target = ev.evaluate(node.target)
    origin_span = node.span if node.origin is None else node.origin.span
    if _is_area(origin) and not _is_area(target):
        origin, target, origin_span = target, origin, node.target.span
    if node.between_outlines:
        return Quantity(_gap(ev, origin, target, node), LENGTH)
    start = position(ev, origin, origin_span)
    if isinstance(target, Area):
        if target.distance is None:
            raise NOT_SUPPORTED.mistake(node.target.span, what=f"the distance to {target.name}", reason="", cure="")
        return Quantity(target.distance(start), LENGTH)
    if isinstance(target, Centerline):
        path = of_each(ev, target.lane, "path")
        return Quantity(path_distance(path, start.x, start.y), LENGTH)
    if (region := region_of(target)) is not None:
        return Quantity(region_distance(float(region.id), start.x, start.y), LENGTH)
    end = position(ev, target, node.target.span)
    return Quantity(between(start, end), LENGTH)


def _is_area(value: Value) -> bool:
    return isinstance(value, Centerline | Area) or region_of(value) is not None


def _gap(ev: Evaluator, origin: Value, target: Value, node: nodes.Distance) -> Term:
    if _is_area(target):
        return _gap_to_region(ev, origin, target, node.target.span, "`minimum distance`")
    return _between_outlines(ev, origin, target, node.span, node.target.span)


def _between_outlines(ev: Evaluator, one: Value, other: Value, one_span: Span, other_span: Span) -> Term:
    """Return the distance of two outlines [m]; in contact rules, 0 between the ego and an actor that it touched."""
    gap = box_distance(outline(ev, one, one_span), outline(ev, other, other_span))
    if ev.moment.judged and isinstance(one, Actor) and isinstance(other, Actor) and ev.run.ego in (one, other):
        return where(ev.algebra.touches((other if one is ev.run.ego else one).index), 0.0, gap)
    return gap


def _gap_to_region(ev: Evaluator, item: Value, area: Value, span: Span, what: str) -> Term:
    """Distance between the outline of an object, or a point, and a region; 0 where they overlap."""
    region = region_of(area)
    if region is None or _is_area(item):
        raise NOT_SUPPORTED.mistake(
            span,
            what=f"{what} is between two objects, or an object and a region",
            reason="a centerline is a line and no region" if region is None else "",
            cure="write `distance from x to lane.centerline`, from the centre of x" if region is None else "",
        )
    box = outline(ev, item, span)
    return region_box_distance(float(region.id), box)


def intersects(ev: Evaluator, node: nodes.Intersects) -> Value:
    """Return whether two outlines, or an outline and a region, have a common point."""
    left, right = ev.evaluate_all((node.left, node.right))
    if _is_area(left) or _is_area(right):
        item, area = (right, left) if _is_area(left) else (left, right)
        gap = _gap_to_region(ev, item, area, node.span, "`intersects`")
    else:
        gap = _between_outlines(ev, left, right, node.left.span, node.right.span)
    touching = gap <= 0.0
    ev.run.compared.setdefault(touching, LENGTH)
    return Truth(touching)
