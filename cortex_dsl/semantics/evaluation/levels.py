"""The level on which an object begins, where roads pass over one another: `with level "road39"`."""

from collections.abc import Sequence

from cortex_dsl import ir
from cortex_dsl.semantics.errors.scene import LOWER_LEVEL, NOT_ON_MAP
from cortex_dsl.semantics.errors.values import WRONG_KIND
from cortex_dsl.semantics.evaluation.roads import network_of
from cortex_dsl.semantics.model.areas import Elements
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import Actor, Value, Vector
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.quantities.algebra import (
    Term,
    minimum,
    path_distance,
    path_pose,
    path_project,
    region_distance,
    where,
)
from cortex_dsl.semantics.quantities.bounds import closed_value
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean
from engine.road.network import Lane, Network, Road
from engine.road.sections import LaneSection, road_of
from engine.vocabulary import LEVEL, LEVEL_REACH, HeightColumn


def lanes_of_level(ev: Evaluator, value: Value, span: Span) -> tuple[Lane, ...]:
    """Return the lanes of a road, given itself, by one of its lanes, or by its name.

    Raises:
        Mistake: it is none, or no roads of the map pass over one another.
    """
    network = network_of(ev)
    if not len(network.heights):
        reason, cure = "no road of it passes over another one", "leave `level` out: all objects are on one"
        raise NOT_ON_MAP.mistake(span, name="level", reason=reason, cure=cure)
    named = Elements(network).by_name()
    if isinstance(value, str) and value not in named:
        roads = [each.name for each in (*network.roads, *network.connecting_roads)]
        raise NOT_ON_MAP.mistake(
            span, name=value, reason="`level` names a road of the file", cure=did_you_mean(value, roads)
        )
    element = named[value] if isinstance(value, str) else value
    if isinstance(element, LaneSection):
        element = element.lane
    if isinstance(element, Lane):
        return (element,)
    if isinstance(element, Road):
        return element.lanes
    cure = 'as in `with level "road39"`, or `with level lane`'
    raise WRONG_KIND.mistake(span, what="`level`", expected="a road or a lane", actual=kind_name(element), cure=cure)


def lanes_in(value: Value) -> tuple[Lane, ...]:
    """Return the lanes that a `level` property holds; () without one."""
    return tuple(each for each in value if isinstance(each, Lane)) if isinstance(value, tuple) else ()


def require_level(ev: Evaluator, actor: Actor, span: Span) -> None:
    """Require that an object begins near the road on whose level it is."""
    lanes = lanes_in(actor.properties.get("level"))
    if not lanes:
        return
    near: Term = ev.algebra.truth(False)
    for lane in lanes:
        near = near | (region_distance(float(lane.region), actor.pose.x, actor.pose.y) <= LEVEL_REACH)
    name = f"{actor.name} is not more than {LEVEL_REACH:g} m from the road of its level"
    ev.run.built.requirements.append(ir.Requirement(near, 1.0, name, ev.facts.line(span)))


def lower_lanes(ev: Evaluator, name: str, point: Vector, span: Span) -> tuple[Lane, ...] | None:
    """Return the lanes of the lowest level at a known point below which no other road is; None on a single level."""
    network = network_of(ev)
    x, y = closed_value(point.x), closed_value(point.y)
    if not len(network.heights) or x is None or y is None:
        return None
    there = sorted(_heights_at(network, x, y), key=lambda each: each[1])
    if not there or there[-1][1] - there[0][1] < LEVEL:
        return None
    (lane, lowest), (over, height) = there[0], there[-1]
    lower, upper = ((road_of(each) or each).name for each in (lane, over))
    ev.report(LOWER_LEVEL.at(span, name=name, lower=lower, upper=upper, height=height - lowest))
    return tuple(each for each, height in there if height - lowest < LEVEL)


def along_nearest(ev: Evaluator, lanes: Sequence[Lane], point: Vector) -> Term:
    """Return the heading along the nearest of some lanes [rad]."""
    paths = [ev.algebra.literal(float(lane.path)) for lane in lanes]
    headings = [path_pose(path, path_project(path, point.x, point.y))[2] for path in paths]
    least, heading = path_distance(paths[0], point.x, point.y), headings[0]
    for path, there in zip(paths[1:], headings[1:], strict=True):
        away = path_distance(path, point.x, point.y)
        heading = where(away < least, there, heading)
        least = minimum(away, least)
    return heading


def _heights_at(network: Network, x: float, y: float) -> list[tuple[Lane, float]]:
    """Return the lanes at a point, each with its height there [m]."""
    there = [lane for lane in network.lanes if network.regions.contains(lane.region, x, y)]
    found = []
    for lane in there:
        rows = network.heights[network.heights[:, HeightColumn.LANE] == lane.id]
        if len(rows):
            dx, dy = x - rows[:, HeightColumn.X], y - rows[:, HeightColumn.Y]
            near = (dx**2 + dy**2).argmin()
            heights = rows[:, HeightColumn.HEIGHT] + dx * rows[:, HeightColumn.SLOPE_X]
            found.append((lane, float((heights + dy * rows[:, HeightColumn.SLOPE_Y])[near])))
    return found
