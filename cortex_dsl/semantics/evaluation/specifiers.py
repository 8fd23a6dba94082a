"""Where a new object is: each specifier that places it gives a point, and mostly a heading too."""

from collections.abc import Callable
from dataclasses import replace

from cortex_dsl import ir
from cortex_dsl.semantics.errors.scene import (
    EVERYTHING_TOO_FAR,
    NEVER_LEAVES,
    NO_TRAJECTORY,
    NOT_ON_TRAJECTORY,
    NOWHERE_UNSEEN,
    OTHER_SIDE,
    TOO_FAR,
)
from cortex_dsl.semantics.errors.values import WRONG_KIND
from cortex_dsl.semantics.evaluation import geometry, seeing
from cortex_dsl.semantics.evaluation.numbers import ROUNDING, adopt
from cortex_dsl.semantics.evaluation.placements import Extent, Placement, in_area, on_path, somewhere_in, within
from cortex_dsl.semantics.evaluation.ranges import in_range
from cortex_dsl.semantics.evaluation.ranges import within as bounded
from cortex_dsl.semantics.evaluation.relations import follow
from cortex_dsl.semantics.evaluation.trajectories import Trajectory, trajectory
from cortex_dsl.semantics.model.areas import Area
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import Actor, Centerline, Pose, Quantity, Value, Vector
from cortex_dsl.semantics.model.wording import kind_name, option_name, shown
from cortex_dsl.semantics.names.properties import Domain
from cortex_dsl.semantics.quantities.algebra import (
    Term,
    cos,
    maximum,
    sin,
    sqrt,
)
from cortex_dsl.semantics.quantities.bounds import closed_value
from cortex_dsl.semantics.quantities.units import LENGTH, PURE, TIME
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes
from engine.maps import MapFile
from engine.road.network import Intersection, Lane

CONTACT_TOLERANCE = 1e-4
"""Gap between an object and the object next to which it is placed without `by`; Scenic's default [m]."""


Placer = Callable[[Evaluator, nodes.Specifier, Extent], Placement]


def place(ev: Evaluator, specifier: nodes.Specifier, extent: Extent) -> Placement:
    return PLACERS[type(specifier)](ev, specifier, extent)


def _at(ev: Evaluator, node: nodes.At, extent: Extent) -> Placement:
    value = ev.evaluate(node.position)
    pose = geometry.pose_of(ev, value)
    point = geometry.position(ev, value, node.position.span, "what follows `at`")
    # Scenic 3 takes the place alone: a vehicle then heads along the road, all else north. Where the road is known to
    # lead as the point heads, its lane is still known.
    taken = not ev.facts.from_scenic or (extent.faces_road and pose is not None and pose.lane is not None)
    if pose is None or not taken:
        return Placement(point, None)
    return Placement(point, pose.heading, lane=pose.lane)


def _with_position(ev: Evaluator, node: nodes.With, _extent: Extent) -> Placement:
    """`with position P` says nothing of the heading, whatever P is."""
    return Placement(geometry.position(ev, ev.evaluate(node.value), node.value.span, "`position`"), None)


def _in_region(ev: Evaluator, node: nodes.InRegion, _extent: Extent) -> Placement:
    return somewhere_in(ev, ev.evaluate(node.region), node.region.span, node.keyword)


def _offset_by(ev: Evaluator, node: nodes.OffsetBySpecifier, _extent: Extent) -> Placement:
    ego = geometry.ego_of(ev, node.span, "`offset by`")
    offset = geometry.position(ev, ev.evaluate(node.offset), node.offset.span, "an offset")
    return _as_placement(geometry.displaced(ev, ego, offset, node.span))


def _offset_along(ev: Evaluator, node: nodes.OffsetAlongSpecifier, _extent: Extent) -> Placement:
    ego = geometry.ego_of(ev, node.span, "`offset along`")
    direction, offset = ev.evaluate_all((node.direction, node.offset))
    vector = geometry.position(ev, offset, node.offset.span, "an offset")
    return _as_placement(geometry.displaced_along(ev, ego, direction, vector, node))


def _as_placement(value: Value) -> Placement:
    if isinstance(value, Pose):
        return Placement(Vector(value.x, value.y), value.heading)
    assert isinstance(value, Vector)
    return Placement(value, None)


def _beside(ev: Evaluator, node: nodes.Beside, extent: Extent) -> Placement:
    """Return the placement next to an edge: the distance is the gap between the outlines."""
    reference = ev.evaluate(node.reference)
    if (pose := geometry.pose_of(ev, reference)) is None:
        # Next to a plain point, the heading of the object itself defines the sides.
        what = f"what something is {node.side} of"
        if isinstance(reference, Lane | Centerline):
            geometry.oriented(ev, reference, node.reference.span, what)
        point = geometry.position(ev, reference, node.reference.span, what)
        pose = Pose(point.x, point.y, extent.heading(None))
    along = node.side in ("ahead", "behind")
    own = extent.length if along else extent.width
    gap, shift = _gap(ev, node, isinstance(reference, Actor))
    half = own * 0.5
    if isinstance(reference, Actor):
        size = geometry.size_of(reference, "length" if along else "width")
        half = half + size * 0.5
    reach = half + gap
    signed = reach if node.side in ("ahead", "right") else -reach
    right, ahead = (shift, signed) if along else (signed, shift)
    return Placement(geometry.moved(Vector(pose.x, pose.y), pose.heading, right, ahead), pose.heading)


def _gap(ev: Evaluator, node: nodes.Beside, between_objects: bool) -> tuple[Term, Term]:
    """Return the gap to the reference, and the shift along its edge [m]: to the right, or ahead."""
    zero = ev.algebra.literal(0.0)
    if node.distance is None:
        return ev.algebra.literal(CONTACT_TOLERANCE if between_objects else 0.0), zero
    value = ev.evaluate(node.distance)
    if isinstance(value, Vector | tuple):
        offset = geometry.position(ev, value, node.distance.span, "an offset")
        return (offset.y, offset.x) if node.side in ("ahead", "behind") else (offset.x, offset.y)
    return adopt(ev, value, LENGTH, node.distance.span, "the distance after `by`"), zero


def _following(ev: Evaluator, node: nodes.Following, _extent: Extent) -> Placement:
    pose = follow(ev, node)
    return Placement(Vector(pose.x, pose.y), pose.heading)


def _beyond(ev: Evaluator, node: nodes.Beyond, _extent: Extent) -> Placement:
    """Displaced in the frame of the line of sight; it heads as the viewer does, as the axes do from a plain point."""
    viewer = geometry.ego_of(ev, node.span, "`beyond`") if node.viewer is None else ev.evaluate(node.viewer)
    value, offset = ev.evaluate_all((node.place, node.offset))
    start = geometry.position(ev, viewer, node.span if node.viewer is None else node.viewer.span)
    point = geometry.position(ev, value, node.place.span)
    if isinstance(offset, Quantity):
        along = adopt(ev, offset, LENGTH, node.offset.span, "the distance after `by`")
        by = Vector(ev.algebra.literal(0.0), along)
    else:
        by = geometry.position(ev, offset, node.offset.span, "an offset")
    place = geometry.moved(point, geometry.bearing(start, point), by.x, by.y)
    pose = geometry.pose_of(ev, viewer)
    return Placement(place, geometry.as_meant(ev, ev.algebra.literal(0.0)) if pose is None else pose.heading)


MEETING_SHARES = (-0.9, 1.9)
"""Shares of the width at which an object is met. An object that is not wider passes by below -0.5 and above 1.5; the
rest is room for the tolerances of tests.
"""
LATEST_MEETING = 1000.0
"""Latest time of a meeting [s]; the object begins the way of this time before the place."""


def _meeting(ev: Evaluator, node: nodes.Meeting, extent: Extent) -> Placement:
    """Return the placement from which the object reaches a place of another one, if both keep speed and heading.

    At a share of the other's width, from its right edge, the front of the other touches this object, whose centre is on
    the line through that place along the other's heading. At a place in the frame of the other, this object's front
    touches it.
    """
    other, where, after = ev.evaluate_all((node.other, node.place, node.time))
    if not isinstance(other, Actor):
        what, cure = "what follows `meeting`", "as in `meeting ego at 0.5 after 4 s`"
        raise WRONG_KIND.mistake(node.other.span, what=what, expected="an object", actual=kind_name(other), cure=cure)
    what = "the time after `after`"
    time = in_range(ev, adopt(ev, after, TIME, node.time.span, what), Domain(what, TIME), node.time.span)
    bounded(ev, time, Domain(what, TIME, high=LATEST_MEETING), node.time.span, what)
    pose, driven = geometry.current_pose(ev, other), geometry.size_of(other, "speed") * time
    heading = extent.heading(pose.heading)
    if node.way is None:
        way = extent.speed() * time
    else:
        way = adopt(ev, ev.evaluate(node.way), LENGTH, node.way.span, "the distance after `by`")
    if isinstance(where, Quantity):
        what = "the share of the width after `at`"
        share = adopt(ev, where, PURE, node.place.span, what)
        bounded(ev, share, Domain(what, PURE, *MEETING_SHARES), node.place.span, what)
        right = (0.5 - share) * geometry.size_of(other, "width")
        ahead = geometry.size_of(other, "length") * 0.5 + _reach(extent, heading - pose.heading)
    else:
        offset = geometry.position(ev, where, node.place.span, "the place after `at`")
        right, ahead, way = offset.x, offset.y, way + extent.length * 0.5
    meeting_place = geometry.moved(Vector(pose.x, pose.y), pose.heading, right, ahead + driven)
    return Placement(geometry.moved(meeting_place, heading, ev.algebra.literal(0.0), -way), heading)


def _reach(extent: Extent, angle: Term) -> Term:
    """Return the distance [m] from the centre of a rectangle to its outline in a direction."""
    sides = maximum(extent.width * abs(cos(angle)), extent.length * abs(sin(angle)))
    return extent.length * extent.width * 0.5 / maximum(sides, CONTACT_TOLERANCE)


def _in_sight(ev: Evaluator, node: nodes.InSight, extent: Extent) -> Placement:
    """Anywhere in view, or out of view, in the region that the object must lie in anyway."""
    viewer = seeing.observer(ev, node)
    if extent.region is not None:
        return replace(within(ev, extent.region), observed=(viewer, node.seen))
    workspace = ev.find("workspace")
    if isinstance(workspace, Area) and workspace.draw is not None:
        return replace(in_area(ev, workspace, node.span), observed=(viewer, node.seen))
    if not node.seen:
        raise NOWHERE_UNSEEN.mistake(node.span)
    return replace(_in_sector(ev, viewer), observed=(viewer, True))


def _in_sector(ev: Evaluator, viewer: Actor | Pose | Vector) -> Placement:
    """Uniform over the sector of a viewer; the radius is the square root of a uniform share."""
    pose, view = geometry.looking(ev, viewer), geometry.view_of(ev, viewer)
    far, turned = view.reach * sqrt(ev.run.new_draw()), pose.heading + view.opening * (ev.run.new_draw() - 0.5)
    return Placement(Vector(pose.x + far * cos(turned), pose.y + far * sin(turned)), None, drawn=True)


def _contained_in(ev: Evaluator, node: nodes.ContainedIn, _extent: Extent) -> Placement:
    value = ev.evaluate(node.region)
    return replace(somewhere_in(ev, value, node.region.span, "contained in"), contained=value)


def _before(ev: Evaluator, node: nodes.Before, _extent: Extent) -> Placement:
    """The place on a trajectory from which it is so far to the intersection."""
    way, region, trajectory_span = _way_through(ev, node)
    if (entry := way.entry(region)) is None:
        raise NOT_ON_TRAJECTORY.mistake(trajectory_span, region=option_name(region))
    by = _along(ev, node, entry, region)
    lane = way.lanes[0] if entry <= way.lanes[0].length else None
    return on_path(ev.algebra.literal(float(way.path)), entry - by, lane)


def _after(ev: Evaluator, node: nodes.After, _extent: Extent) -> Placement:
    """The place on a trajectory that lies so far beyond the intersection."""
    way, region, trajectory_span = _way_through(ev, node)
    if (leaving := way.leaving(region)) is None:
        raise NEVER_LEAVES.mistake(trajectory_span, region=option_name(region))
    rest = way.length - leaving
    by = _along(ev, node, rest, region)
    lane = way.lanes[-1] if rest <= way.lanes[-1].length + ROUNDING else None
    return on_path(ev.algebra.literal(float(way.path)), leaving + by, lane)


def _way_through(ev: Evaluator, node: nodes.Before) -> tuple[Trajectory, Intersection, Span]:
    """The trajectory, the intersection, and where the former is written."""
    if node.trajectory is None:
        raise NO_TRAJECTORY.mistake(node.span, word=_word(node))
    region, along = ev.evaluate_all((node.region, node.trajectory))
    if not isinstance(region, Intersection):
        raise WRONG_KIND.mistake(
            node.region.span,
            what=f"what follows `{_word(node)}`",
            expected="an intersection",
            actual=kind_name(region),
            cure=f"as in `{_word(node)} intersection by 20 m along trajectory`",
        )
    return trajectory(along, node.trajectory.span), region, node.trajectory.span


def _word(node: nodes.Before) -> str:
    return "after" if isinstance(node, nodes.After) else "before"


def _along(ev: Evaluator, node: nodes.Before, available: float, place: Intersection) -> Term:
    """The distance from the intersection: an error if the way surely is too short for it, else a requirement."""
    what = f"the distance {_word(node)} the intersection"
    span = node.distance.span
    by = adopt(ev, ev.evaluate(node.distance), LENGTH, span, what)
    if ev.interval(by)[1] < 0.0:
        raise OTHER_SIDE.mistake(
            span, word=_word(node), other="before" if _word(node) == "after" else "after",
            region=ev.facts.source.slice(node.region.span), distance=shown(-ev.interval(by)[1], LENGTH),
        )  # fmt: skip
    by = in_range(ev, by, Domain(what, LENGTH), span)
    _keep_on_way(ev, node, by, available, place)
    return by


def _keep_on_way(ev: Evaluator, node: nodes.Before, by: Term, available: float, place: Intersection) -> None:
    """There is no place beyond the trajectory: an error where it surely lies there, a requirement where it may."""
    region, limit, word = ev.facts.source.slice(node.region.span), shown(available, LENGTH), _word(node)
    bounds, sooner = ("ends", "later") if word == "after" else ("starts", "earlier")
    of_file = isinstance(place.network.spec, MapFile)
    remedy = f"a trajectory that {bounds} {sooner}" if of_file else "a longer `approach` in `map`"
    greatest, value = ev.interval(by)[1], closed_value(by)
    if value is not None and value > available:
        actual = shown(value, LENGTH)
        raise TOO_FAR.mistake(
            node.distance.span, actual=actual, word=word, region=region, bounds=bounds, available=limit, remedy=remedy
        )
    if value is not None or greatest <= available:
        return
    if greatest < float("inf"):
        actual = shown(greatest, LENGTH)
        ev.report(
            EVERYTHING_TOO_FAR.at(
                node.distance.span,
                actual=actual,
                word=word,
                region=region,
                bounds=bounds,
                available=limit,
                remedy=remedy,
            )
        )
    condition = by <= available
    text = ev.facts.source.words(node.span)
    ev.run.built.requirements.append(
        ir.Requirement(condition, 1.0, f"`{text}` lies on the road", ev.facts.line(node.span))
    )


PLACERS: dict[type, Placer] = {
    nodes.At: _at,
    nodes.With: _with_position,
    nodes.InRegion: _in_region,
    nodes.OffsetBySpecifier: _offset_by,
    nodes.OffsetAlongSpecifier: _offset_along,
    nodes.Beside: _beside,
    nodes.Following: _following,
    nodes.Beyond: _beyond,
    nodes.Meeting: _meeting,
    nodes.InSight: _in_sight,
    nodes.ContainedIn: _contained_in,
    nodes.Before: _before,
    nodes.After: _after,
}  # type: ignore[assignment]
