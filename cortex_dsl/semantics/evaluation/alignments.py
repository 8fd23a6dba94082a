"""Paths that a file makes of lines, arcs and clothoids: `Path(start, [10 m, Arc(9 m, angle=90 deg)])`."""

import math
from collections.abc import Callable, Mapping

from cortex_dsl.semantics.errors.scene import BAD_SEGMENT, TOO_SHARP
from cortex_dsl.semantics.errors.values import WRONG_KIND
from cortex_dsl.semantics.evaluation import geometry
from cortex_dsl.semantics.evaluation.arguments import Given, items_of, number_for
from cortex_dsl.semantics.evaluation.functions import Meaning
from cortex_dsl.semantics.evaluation.numbers import adopt
from cortex_dsl.semantics.evaluation.ranges import in_range
from cortex_dsl.semantics.evaluation.roads import network_of
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import Actor, Alignment, Closure, Pose, Quantity, Value
from cortex_dsl.semantics.model.wording import kind_name, shown
from cortex_dsl.semantics.names.builtins import BUILTINS, LONGEST_PATH
from cortex_dsl.semantics.names.properties import Domain
from cortex_dsl.semantics.quantities.algebra import Term, path_length, path_pose, tan, where
from cortex_dsl.semantics.quantities.bounds import closed_value
from cortex_dsl.semantics.quantities.units import LENGTH
from cortex_dsl.source import Span
from engine.opendrive import curves
from engine.road.alignment import Segment, aligned
from engine.vocabulary import ActorKind

MOST_SEGMENTS = 100
MOST_TURN = 10.0 * math.tau
"""Largest turn of a clothoid [rad]: arcs that stand for it are short where it is sharp."""
ROUNDING = 1e-9
"""Relative excess over the largest curvature that is a rounding error."""
_AS_IN = "as in `Path(start, [10 m, Clothoid(none, 9 m, angle=20 deg), Arc(9 m, angle=50 deg)])`"


# -- segments ----------------------------------------------------------------------------------------------------------


def _arc(ev: Evaluator, radius: Given, angle: Given | None, length: Given | None, span: Span) -> Value:
    curvature = _curvature(ev, "Arc", "radius", radius)
    return _segment(ev, "Arc", (curvature, curvature), angle, length, span)


def _clothoid(ev: Evaluator, start: Given, end: Given, angle: Given | None, length: Given | None, span: Span) -> Value:
    ends = _curvature(ev, "Clothoid", "start_radius", start), _curvature(ev, "Clothoid", "end_radius", end)
    made = _segment(ev, "Clothoid", ends, angle, length, span)
    if 0.5 * (abs(ends[0]) + abs(ends[1])) * made.length > MOST_TURN:
        reason = f"it turns by more than {MOST_TURN / math.tau:.0f} circles"
        raise BAD_SEGMENT.mistake(span, word="Clothoid", reason=reason, cure="give larger radii or less of it")
    return made


def _segment(
    ev: Evaluator, word: str, ends: tuple[float, float], angle: Given | None, length: Given | None, span: Span
) -> Segment:
    """Return a segment between two curvatures [1/m] by its angle or its length.

    Raises:
        Mistake: both or neither are given, or its angle does not say how long it is.
    """
    if (angle is None) == (length is None):
        reason = f"it has {'neither an angle nor a length' if angle is None else 'both an angle and a length'}"
        raise BAD_SEGMENT.mistake(
            span, word=word, reason=reason, cure="give one of them: `angle=45 deg` or `length=7 m`"
        )
    if length is not None:
        return Segment(_number(ev, word, "length", length), *ends)
    assert angle is not None
    mean = 0.5 * abs(ends[0] + ends[1])
    turned = _number(ev, word, "angle", angle)
    if ends[0] * ends[1] < 0.0 or mean == 0.0:
        reason = "its angle does not say how long it is: it bends to both sides, or not at all"
        raise BAD_SEGMENT.mistake(span, word=word, reason=reason, cure="give its length: `length=7 m`")
    if turned / mean > LONGEST_PATH:
        reason = f"it would be {shown(turned / mean, LENGTH)} long, and {shown(LONGEST_PATH, LENGTH)} is the most"
        raise BAD_SEGMENT.mistake(span, word=word, reason=reason, cure="give a smaller radius or angle")
    return Segment(turned / mean, *ends)


def _curvature(ev: Evaluator, word: str, name: str, given: Given) -> float:
    """Return the curvature of a radius [1/m]; 0 of `none`."""
    if given.value is None:
        return 0.0
    radius = _number(ev, word, name, given)
    if radius == 0.0:
        reason = "its radius is 0: it is a corner"
        raise BAD_SEGMENT.mistake(given.span, word=word, reason=reason, cure="give a radius, negative to the right")
    return 1.0 / radius


def _number(ev: Evaluator, word: str, name: str, given: Given) -> float:
    """Return a number of a segment, which is known before the run."""
    parameter = BUILTINS[word].parameter(name)
    assert parameter.dimension is not None
    value = ev.constant(Quantity(number_for(ev, parameter, given), parameter.dimension), given.span, f"`{name}`")
    if name != "radius" and not name.endswith("_radius") and value <= 0.0:
        reason = f"its {name} is {shown(value, parameter.dimension)}"
        raise BAD_SEGMENT.mistake(given.span, word=word, reason=reason, cure="give one above 0")
    return value


# -- paths -------------------------------------------------------------------------------------------------------------


def _path(ev: Evaluator, start: Given, segments: Given, _span: Span) -> Value:
    if not isinstance(start.value, Pose):
        cure = "make a point with a heading: `new OrientedPoint at (0, 0), facing 90 deg`"
        actual = kind_name(start.value)
        raise WRONG_KIND.mistake(start.span, what="`start`", expected="an oriented point", actual=actual, cure=cure)
    x, y = (
        ev.constant(Quantity(each, LENGTH), start.span, "the start of a path")
        for each in (start.value.x, start.value.y)
    )
    heading = ev.constant(Quantity(start.value.heading, None), start.span, "the heading of a path")
    items = items_of(segments.value, segments.span, "`segments`")
    if not 1 <= len(items) <= MOST_SEGMENTS:
        reason = f"a path has 1 to {MOST_SEGMENTS} segments, and this one {len(items)}"
        raise BAD_SEGMENT.mistake(segments.span, word="Path", reason=reason, cure=_AS_IN)
    known = [_line_or(ev, each, segments.span) for each in items]
    path = network_of(ev).paths.draw(aligned(curves.Pose(x, y, heading), known))
    sharpest = max(segment.sharpest for segment in known)
    return Alignment(ev.algebra.literal(float(path)), ev.algebra.literal(sharpest))


def _line_or(ev: Evaluator, item: Value, span: Span) -> Segment:
    """Return a segment; a length is a line."""
    if isinstance(item, Segment):
        return item
    if not isinstance(item, Quantity):
        expected = "a length, an `Arc` or a `Clothoid`"
        raise WRONG_KIND.mistake(span, what="a segment", expected=expected, actual=kind_name(item), cure=_AS_IN)
    what = "the length of a line"
    value = in_range(ev, adopt(ev, item, LENGTH, span, what), Domain(what, LENGTH, 0.0, LONGEST_PATH, above=True), span)
    return Segment(ev.constant(Quantity(value, LENGTH), span, what))


def select(condition: Term, then: Alignment, otherwise: Alignment) -> Alignment:
    """Return the path that a condition chooses."""
    return Alignment(where(condition, then.path, otherwise.path), where(condition, then.sharpest, otherwise.sharpest))


def fitting(ev: Evaluator, actor: Actor, path: Alignment, span: Span) -> Term:
    """Return the id of a path that an actor can steer along.

    Raises:
        Mistake: it bends more sharply than the actor can.
    """
    if actor.kind not in (ActorKind.PEDESTRIAN, ActorKind.OBSTACLE):
        sharpest = ev.interval(path.sharpest)[1]
        tightest = geometry.size_of(actor, "wheelbase") / tan(geometry.size_of(actor, "maxSteer"))
        least = closed_value(tightest)
        if least is not None and sharpest * least > 1.0 + ROUNDING:
            name, radii = actor.kind.name.capitalize(), (shown(1.0 / sharpest, LENGTH), shown(least, LENGTH))
            raise TOO_SHARP.mistake(span, name=name, radius=radii[0], least=radii[1])
    return path.path


def _pose(ev: Evaluator, path: Alignment, s: Term) -> Pose:
    """Return the pose at a length along a path; known before the run if path and length are."""
    which, length = closed_value(path.path), closed_value(s)
    if which is None or length is None:
        return Pose(*path_pose(path.path, s))
    known = network_of(ev).paths.pose(int(which), length)
    literal = ev.algebra.literal
    return Pose(literal(known.x), literal(known.y), literal(known.heading))


def _pose_at(ev: Evaluator, path: Alignment) -> Closure:
    def at(distance: Value) -> Value:
        return _pose(ev, path, adopt(ev, distance, LENGTH, ev.algebra.span, "the distance along the path"))

    return Closure(("distance",), at)


def _length(ev: Evaluator, path: Alignment) -> Term:
    which = closed_value(path.path)
    return path_length(path.path) if which is None else ev.algebra.literal(network_of(ev).paths.length(int(which)))


OF_PATH: Mapping[str, Callable[[Evaluator, Alignment], Value]] = {
    "length": lambda ev, path: Quantity(_length(ev, path), LENGTH),
    "start": lambda ev, path: _pose(ev, path, ev.algebra.literal(0.0)),
    "end": lambda ev, path: _pose(ev, path, _length(ev, path)),
    "poseAt": _pose_at,
}
"""Attributes of a path."""

MEANINGS: Mapping[str, Meaning] = {"Arc": _arc, "Clothoid": _clothoid, "Path": _path}
