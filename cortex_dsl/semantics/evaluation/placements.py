"""Placements: a point with the other values of its specifier; random places in regions and on lines."""

from collections.abc import Callable

from cortex_dsl import ir
from cortex_dsl.semantics.errors.scene import BAD_REGION
from cortex_dsl.semantics.errors.values import WRONG_KIND
from cortex_dsl.semantics.evaluation import geometry, lanes, streets
from cortex_dsl.semantics.evaluation.roads import ROAD, network_of
from cortex_dsl.semantics.model.areas import Area
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import (
    Actor,
    Centerline,
    LaneNow,
    Pose,
    Region,
    Sighted,
    SurfaceNow,
    Value,
    Vector,
)
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.quantities.algebra import Term, path_pose, path_project, region_sample, road_heading
from cortex_dsl.source import Span
from engine.frozen import frozen
from engine.road.network import Lane, Network, Surface, SurfaceKind
from engine.road.sections import LaneSection


@frozen
class Placement:
    """A point and, if the specifier gives one, a heading."""

    point: Vector
    heading: Term | None
    drawn: bool = False
    """Whether the specifier itself sampled it."""
    lane: Lane | LaneNow | None = None
    """Lane along which it lies, if that is known or sampled with the scene."""
    observed: tuple["Actor | Pose | Vector", bool] | None = None
    """Viewer of the placed object, and whether it must see the object or must not."""
    contained: Value = None
    """Region that must contain the whole outline."""


@frozen
class Extent:
    """Size and speed of the placed object, zero for points; and its heading, if its place does not give it."""

    length: Term
    width: Term
    heading: Callable[[Term | None], Term]
    """Heading, with the one that it has if nothing gives it."""
    speed: Callable[[], Term]
    region: Region | None
    """The region that it must lie in anyway."""
    faces_road: bool = False
    """Whether it heads along the road, where nothing says how."""


def at_origin(ev: Evaluator) -> Placement:
    """Return the placement of an object without a place of its own: the middle of the map."""
    zero = ev.algebra.literal(0.0)
    return Placement(Vector(zero, zero), None)


def somewhere_in(ev: Evaluator, value: Value, span: Span, keyword: str) -> Placement:
    if isinstance(value, Sighted):
        placement = somewhere_in(ev, value.region, span, keyword)
        require_place(ev, geometry.in_sector(ev, value, placement.point), span)
        return placement
    if isinstance(value, Network):
        value = ROAD
    if isinstance(value, LaneSection):
        value = value.lane
    if isinstance(value, Centerline):
        return on_centerline(ev, value.lane)
    if isinstance(value, Area):
        return in_area(ev, value, span)
    if isinstance(value, SurfaceNow):
        return on_surface_now(ev, value, span)
    if isinstance(value, Surface) and value.kind is SurfaceKind.CURB:
        return on_path(of_path(ev, value.path), ev.run.new_draw() * value.length, None, drawn=True)
    if isinstance(value, Surface):
        return along(ev, ev.algebra.literal(float(value.region)), of_path(ev, value.path))
    if isinstance(value, LaneNow) and value.drawn:
        return along(ev, lanes.of_each(ev, value, "region"), lanes.of_each(ev, value, "path"))
    if (region := geometry.region_of(value)) is not None:
        return within(ev, region, value if isinstance(value, Lane) else None)
    raise WRONG_KIND.mistake(
        span,
        what=f"what follows `{keyword}`",
        expected="a region or a centre line",
        actual=kind_name(value),
        cure="as in `in lane.centerline`, `on road`",
    )


def of_path(ev: Evaluator, path: int) -> Term:
    return ev.algebra.literal(float(path))


def on_surface_now(ev: Evaluator, surface: SurfaceNow, span: Span) -> Placement:
    """Return a uniform placement on a strip beside the lanes of a group that only the scene knows."""
    region, path, length = streets.found_now(ev, surface)
    if None in surface.options:
        require_place(ev, length > 0.0, span)
    if surface.options[-1] is not None and surface.options[-1].kind is SurfaceKind.CURB:
        return on_path(path, ev.run.new_draw() * length, None, drawn=True)
    return along(ev, region, path)


def in_area(ev: Evaluator, area: Area, span: Span) -> Placement:
    """Uniform over a region of the file's own."""
    if area.draw is None:
        raise BAD_REGION.mistake(span, what=area.name, reason="no place can be drawn in it")
    spot = area.draw(ev.run.new_draw)
    if spot.accepted is not None:
        require_place(ev, spot.accepted, span)
    return Placement(spot.point, spot.heading, drawn=True)


def require_place(ev: Evaluator, condition: Term, span: Span) -> None:
    words = ev.facts.source.words(span)
    ev.file.scene.places[span] = ev.file.scene.places.get(span, False) or ev.interval(condition)[1] > 0.0
    ev.run.built.requirements.append(
        ir.Requirement(condition, 1.0, f"the place lies in `{words}`", ev.facts.line(span))
    )


def on_centerline(ev: Evaluator, lane: Lane | LaneNow | Surface) -> Placement:
    s = ev.run.new_draw() * lanes.of_each(ev, lane, "length")
    return on_path(lanes.of_each(ev, lane, "path"), s, None if isinstance(lane, Surface) else lane, drawn=True)


def on_path(path: Term, s: Term, lane: Lane | LaneNow | None, *, drawn: bool = False) -> Placement:
    x, y, heading = path_pose(path, s)
    return Placement(Vector(x, y), heading, drawn, lane)


def within(ev: Evaluator, region: Region, lane: Lane | None = None) -> Placement:
    """Uniform over a region, heading along the road."""
    network_of(ev)
    identity = ev.algebra.literal(float(region.id))
    if lane is not None:
        return along(ev, identity, ev.algebra.literal(float(lane.path)))
    point = Vector(*region_sample(identity, ev.run.new_draw(), ev.run.new_draw()))
    return Placement(point, road_heading(point.x, point.y), drawn=True)


def along(ev: Evaluator, region: Term, path: Term) -> Placement:
    """Return a uniform placement on a lane, along the direction of the lane.

    Inside an intersection the nearest lane may be another lane.
    """
    point = Vector(*region_sample(region, ev.run.new_draw(), ev.run.new_draw()))
    s = path_project(path, point.x, point.y)
    return Placement(point, path_pose(path, s)[2], drawn=True)
