"""`new`: points, and the objects of the scene with all their properties."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from cortex_dsl import ir
from cortex_dsl.diagnostics import Label
from cortex_dsl.semantics.errors.names import NOT_SUPPORTED, UNKNOWN_CLASS, UNKNOWN_PROPERTY
from cortex_dsl.semantics.errors.problems import Mistake, Problem
from cortex_dsl.semantics.errors.scene import (
    NO_HEADING_YET,
    NO_PLACE,
    TWO_HEADINGS,
    TWO_PLACES,
)
from cortex_dsl.semantics.errors.values import BESIDE_THE_ROAD
from cortex_dsl.semantics.evaluation import geometry, relations, seeing
from cortex_dsl.semantics.evaluation.appearing import appear, check_count, refuse_drawn_place
from cortex_dsl.semantics.evaluation.doors import add_doors, opens_door
from cortex_dsl.semantics.evaluation.geometry import as_meant, as_written
from cortex_dsl.semantics.evaluation.levels import along_nearest, lanes_in, lower_lanes, require_level
from cortex_dsl.semantics.evaluation.making import ObjectBuilder, checked, own_class
from cortex_dsl.semantics.evaluation.mutation import mutated, record
from cortex_dsl.semantics.evaluation.numbers import adopt
from cortex_dsl.semantics.evaluation.placements import Extent, Placement, at_origin, within
from cortex_dsl.semantics.evaluation.ranges import in_range
from cortex_dsl.semantics.evaluation.roads import ROAD, network_of
from cortex_dsl.semantics.evaluation.specifiers import place
from cortex_dsl.semantics.evaluation.streets import walkable
from cortex_dsl.semantics.model.areas import Area
from cortex_dsl.semantics.model.context import Evaluator, Moment
from cortex_dsl.semantics.model.values import (
    Actor,
    Cell,
    ClassValue,
    DirectionField,
    Pose,
    Quantity,
    Region,
    Truth,
    Value,
    Vector,
    View,
)
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.names.properties import ACTOR_KINDS, CLASSES, OFF_ROAD, PLACES, PROPERTIES
from cortex_dsl.semantics.quantities.algebra import Term, road_heading
from cortex_dsl.semantics.quantities.units import SPEED
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes
from engine.road.areas import vehicle_region
from engine.road.network import Network
from engine.vocabulary import ActorKind

# -- new ---------------------------------------------------------------------------------------------------------------


@dataclass
class SpecifierGroups:
    """Specifiers of one `new`, grouped by their effect."""

    places: list[nodes.Specifier] = field(default_factory=list)
    facings: list[nodes.Facing] = field(default_factory=list)
    properties: list[nodes.With] = field(default_factory=list)
    sights: list[nodes.InSight] = field(default_factory=list)
    """Specifiers of visibility, if another specifier gives the place."""
    settled: Term | None = None
    """Heading, if it must be known before the place."""


def new(ev: Evaluator, node: nodes.New) -> Value:
    own = own_class(ev, node.class_name)
    if own is None and node.class_name not in CLASSES:
        known = {*CLASSES, *(name for name in ev.known_names() if own_class(ev, name) is not None)}
        raise UNKNOWN_CLASS.mistake(
            node.class_span,
            name=node.class_name,
            suggestion=did_you_mean(node.class_name, known)
            or "as in `new Car`; for something that stands still and is not a vehicle, `new Obstacle`",
        )
    kind = ACTOR_KINDS.get(node.class_name) if own is None else own.kind
    late = ev.run.built.appearing is not None and ev.moment.running and kind is not None
    if (ev.moment.running or ev.moment.later) and not late:
        raise NOT_SUPPORTED.mistake(
            node.span,
            what="no object can be made here during the run",
            reason="in behaviors and in `compose`, `new` is a statement of its own, or what a name is given",
            cure="as in `new Car ahead of self by 10 m`; make places before the run",
        )
    sorted_ = _sorted(node)
    if kind is None:
        return _new_place(ev, node, sorted_)
    builtin = node.class_name if own is None else (own, *own.bases)[-1].node.base
    if late:
        return _new_late(ev, node, sorted_, kind, own, builtin)
    return _new_actor(ev, node, sorted_, ObjectBuilder(ev, kind, own, builtin, sorted_.properties))


def _sorted(node: nodes.New) -> SpecifierGroups:
    result = SpecifierGroups()
    for specifier in node.specifiers:
        if isinstance(specifier, nodes.With) and specifier.property == "heading":
            result.facings.append(nodes.Facing(span=specifier.span, heading=specifier.value, mode=""))
        elif isinstance(specifier, nodes.With) and specifier.property == "position":
            result.places.append(specifier)
        elif isinstance(specifier, nodes.With):
            result.properties.append(specifier)
        elif isinstance(specifier, nodes.Facing):
            result.facings.append(specifier)
        else:
            result.places.append(specifier)
    if len(result.places) > 1:
        # With another specifier of place, as in Scenic, `visible` names the viewer that must see the object there.
        result.sights = [each for each in result.places if isinstance(each, nodes.InSight)]
        others = [each for each in result.places if not isinstance(each, nodes.InSight)]
        result.places = others if others else [*result.sights]
    _at_most_one(TWO_PLACES, node, result.places)
    _at_most_one(TWO_HEADINGS, node, result.facings)
    return result


def _at_most_one(problem: Problem, node: nodes.New, found: Sequence[nodes.Specifier]) -> None:
    if len(found) > 1:
        raise problem.mistake(found[1].span, name=node.class_name, secondary=(Label(found[0].span, "first here"),))


# -- points -----------------------------------------------------------------------------------------------------------


def _new_place(ev: Evaluator, node: nodes.New, found: SpecifierGroups) -> Value:
    view = _own_view(ev, node, found.properties)
    zero = ev.algebra.literal(0.0)
    north = as_meant(ev, zero) if ev.facts.from_scenic else zero
    placement = at_origin(ev)
    if found.places:
        extent = Extent(
            zero,
            zero,
            lambda usual: _own_heading(ev, node, found, north if usual is None else usual),
            lambda: zero,
            None,
        )
        placement = place(ev, found.places[0], extent)
    if node.class_name == "Point":
        if found.facings:
            raise NOT_SUPPORTED.mistake(
                found.facings[0].span, what="a Point has no heading", reason="", cure="make it an `OrientedPoint`"
            )
        pose = Pose(placement.point.x, placement.point.y, zero)
        moved = mutated(ev, ev.run.assigning, node, pose)
        if moved is not None:
            pose, placement = moved, replace(placement, drawn=True, point=Vector(moved.x, moved.y))
        if found.places:
            _record(ev, found.places[0].span, placement, None)
        return replace(placement.point, view=view)
    return replace(_posed(ev, node, found, placement, north, ev.run.assigning), view=view)


def _own_view(ev: Evaluator, node: nodes.New, given: Sequence[nodes.With]) -> View | None:
    """Return the range and angle of view of a place, if `with` sets them; a plain point looks in all directions."""
    known = PLACES[node.class_name]
    for with_ in given:
        if with_.property not in known:
            kind, meant = f"a place (`{node.class_name}`)", did_you_mean(with_.property, known)
            raise UNKNOWN_PROPERTY.mistake(with_.property_span, kind=kind, name=with_.property, suggestion=meant)
    if not given:
        return None
    making = ObjectBuilder(ev, ActorKind.OBSTACLE, None, None, given)
    making.check_doubles()
    values = {
        each.property: in_range(ev, making.number(each.property), PROPERTIES[each.property], each.value.span)
        for each in given
    }
    usual = geometry.view_of(ev, at_origin(ev).point)
    return View(values.get("visibleDistance", usual.reach), values.get("viewAngle", usual.opening))


def _posed(
    ev: Evaluator, node: nodes.New, found: SpecifierGroups, placement: Placement, default: Term, name: str
) -> Pose:
    """Return place and heading with the noise of `mutate` for `name`."""
    heading = default if placement.heading is None else placement.heading
    if found.settled is not None:
        heading = found.settled
    elif found.facings:
        heading = _faced(ev, found.facings[0], placement.point)
    lane = None if found.facings else placement.lane
    pose = Pose(placement.point.x, placement.point.y, heading, lane)
    moved = mutated(ev, name, node, pose)
    if moved is not None:
        written = as_written(ev, moved.heading)
        record(ev, node, found.places, found.facings, replace(moved, heading=written))
        return replace(moved, heading=as_meant(ev, written))
    if not found.places and placement.drawn:
        return _recorded_default(ev, node, found, pose)
    if not found.places or found.facings or not placement.drawn:
        if found.places:
            _record(ev, found.places[0].span, placement, None)
        return pose
    # The copy of a case gives the heading as its file counts it, so it must be made of that number here too.
    written = as_written(ev, heading)
    _record(ev, found.places[0].span, placement, written)
    return replace(pose, heading=as_meant(ev, written))


def _recorded_default(ev: Evaluator, node: nodes.New, found: SpecifierGroups, pose: Pose) -> Pose:
    """A place that no specifier names is said by the copy of a case behind the class."""
    if found.facings:
        ev.run.decisions.draw_sites.append(ir.DrawSite(node.class_span, "point added", "", (pose.x, pose.y)))
        return pose
    written = as_written(ev, pose.heading)
    record(ev, node, found.places, found.facings, replace(pose, heading=written))
    return replace(pose, heading=as_meant(ev, written))


def _record(ev: Evaluator, span: Span, placement: Placement, heading: Term | None) -> None:
    """Record the random values of a specifier, for concrete copies."""
    if placement.drawn:
        values = (placement.point.x, placement.point.y, *(() if heading is None else (heading,)))
        ev.run.decisions.draw_sites.append(ir.DrawSite(span, "point" if heading is None else "pose", "", values))


def _faced(ev: Evaluator, node: nodes.Facing, point: Vector) -> Term:
    if node.mode == "apparent":
        return relations.heading_in_sight(ev, node, point)
    value = ev.evaluate(node.heading)
    if not node.mode:
        return geometry.heading_at(ev, value, point, node.heading.span)
    target = geometry.position(ev, value, node.heading.span, f"what follows `facing {node.mode}`")
    pair = (point, target) if node.mode == "toward" else (target, point)
    return geometry.bearing(*pair)


# -- objects ----------------------------------------------------------------------------------------------------------

OBJECTS = 2
"""Number of existing objects that add the cost of one evaluation to the next object."""


def _new_actor(ev: Evaluator, node: nodes.New, found: SpecifierGroups, making: ObjectBuilder) -> Value:
    own_name, kind = ev.run.assigning, making.kind
    ev.file.budget.spend(node.span, len(ev.run.built.actors) // OBJECTS)
    placed: list[Placement] = []
    making.posed = lambda: _actor_pose(making, node, found, own_name, placed)
    with ev.naming(""):
        properties, pose = making.properties(), _pose_or_anywhere(ev, making, node, placed)
    named = properties.get("name")
    name = named if isinstance(named, str) else own_name or f"{kind.name.lower()}{len(ev.run.built.actors) + 1}"
    actor = Actor(-1, _unique(ev, name), kind, node.span, pose, properties, ev.moment.scenario, plain=making.plain)
    actor.builtin, actor.classes = making.builtin or "Object", making.classes
    _let_change(ev, actor)
    ev.run.built.actors.append(actor)
    add_doors(ev, actor, _unique)
    require_level(ev, actor, node.span)
    _require_of(ev, actor, placed[0], node)
    for sight in found.sights:
        seen = Placement(placed[0].point, None, observed=(seeing.observer(ev, sight), sight.seen))
        _require_of(ev, actor, seen, node)
    return actor


def _new_late(
    ev: Evaluator,
    node: nodes.New,
    found: SpecifierGroups,
    kind: ActorKind,
    own: ClassValue | None,
    builtin: str | None,
) -> Value:
    """Return an object that appears during the run; its place, speed and behavior are those of that moment."""
    named = ev.run.assigning
    if named == "ego" or (ev.moment.repeated and named):
        raise NOT_SUPPORTED.mistake(
            node.span,
            what="the ego appears with the scene" if named == "ego" else "an object of a loop has no name",
            reason="" if named == "ego" else "each time another object appears",
            cure="make it before the run" if named == "ego" else "write `new` alone, and `with behavior` what it does",
        )
    if found.sights:
        raise NOT_SUPPORTED.mistake(
            node.span,
            what="an object that appears cannot have a place and `visible`",
            reason="",
            cure="remove one of them",
        )
    then = {each.property: each for each in found.properties if each.property in ("speed", "behavior")}
    settled = ev.at_moment(Moment(scenario=ev.moment.scenario, later=True))
    others = [each for each in found.properties if each.property not in then]

    def make() -> tuple[Actor, Pose, Term]:
        making = ObjectBuilder(settled, kind, own, builtin, others)
        zero = ev.algebra.literal(0.0)
        making.posed = lambda: Pose(zero, zero, zero)
        with ev.naming(""):
            properties = dict(making.properties())
        if "behavior" in then:
            value = ev.evaluate(then["behavior"].value)
            span = then["behavior"].value.span
            properties["behavior"] = checked(ev, "behavior", value, span, may_act=making.may_act)
        if opens_door(ev, properties.get("behavior")):
            reason = "its doors would have to appear with it"
            cure = "place it before the run, or in the setup of a scenario"
            raise NOT_SUPPORTED.mistake(
                node.span, what="an object that appears opens no door", reason=reason, cure=cure
            )
        speed = making.number("speed")
        if "speed" in then:
            span = then["speed"].value.span
            speed = in_range(
                ev, adopt(ev, ev.evaluate(then["speed"].value), SPEED, span, "`speed`"), PROPERTIES["speed"], span
            )
        placing = ObjectBuilder(ev, kind, own, builtin, others)
        placing.values = {**properties, "speed": speed}
        placed: list[Placement] = []
        drawn = ev.run.decisions.draw_count
        pose = _actor_pose(placing, node, replace(found, properties=others), "", placed)
        refuse_drawn_place(ev, drawn, node.span)
        properties["speed"] = zero
        actor = _late_actor(ev, node, named or f"{kind.name.lower()}", kind, properties, making)
        actor.pose = Pose(zero, zero, zero)
        _require_of(ev, actor, placed[0], node)
        return actor, pose, speed

    anywhere = ObjectBuilder(settled, kind, own, builtin, others).lies_anywhere()
    return appear(ev, node, make, on_road=kind not in OFF_ROAD and not anywhere)


def _late_actor(
    ev: Evaluator, node: nodes.New, name: str, kind: ActorKind, properties: dict[str, Value], making: ObjectBuilder
) -> Actor:
    """Return the actor of a `new`: a further actor, or that of the same `new` when behaviours were written before."""
    built = ev.run.built
    if built.late_met < len(built.late):
        actor = built.late[built.late_met]
        assert actor.span == node.span
        actor.properties = properties
    else:
        check_count(node.span, built.late)
        zero = ev.algebra.literal(0.0)
        index, built.numbered = built.numbered, built.numbered + 1
        actor = Actor(index, _unique(ev, name), kind, node.span, Pose(zero, zero, zero), properties, plain=making.plain)
        actor.builtin, actor.classes, actor.late = making.builtin or "Object", making.classes, True
        _let_change(ev, actor)
        built.actors.append(actor)
        built.late.append(actor)
        if ev.moment.scenario is not None:
            ev.moment.scenario.actors.append(actor)
    built.late_met += 1
    return actor


def _pose_or_anywhere(ev: Evaluator, making: ObjectBuilder, node: nodes.New, placed: list[Placement]) -> Pose:
    """Return the pose of an object; after a mistake, report it and return the middle of the map.

    With that pose the mistakes in the behaviour of the object are found too.
    """
    try:
        return making.pose(node.span)
    except Mistake as mistake:
        ev.report(mistake)
        placed.append(at_origin(ev))
        return Pose(placed[-1].point.x, placed[-1].point.y, ev.algebra.literal(0.0))


def _let_change(ev: Evaluator, actor: Actor) -> None:
    """Give every property of the file's own that a behaviour assigns a place to change in."""
    for name in sorted(ev.facts.attributes_set & actor.properties.keys()):
        if isinstance(actor.properties[name], Quantity | Truth):
            cell = actor.cells[name] = Cell(ev.run.new_local(), ev.run.new_local())
            ev.run.built.zeroed |= {cell.assigned, cell.value}


def starts_on_road(actor: Actor) -> bool:
    """Return whether the whole outline of an object must lie on the road, up to its kerbs, at the start."""
    return actor.kind not in OFF_ROAD and not isinstance(actor.properties.get("regionContainedIn", actor), Area | None)


OFF_THE_ROAD = ("curb", "sidewalk", "curbRegion", "sidewalkRegion")
"""Names of regions that do not contain the middle of an outline between the kerbs."""


def _warn_of_kerb(ev: Evaluator, actor: Actor, node: nodes.New) -> None:
    """Warn of an object that must lie on the road, at a place on a kerb or a sidewalk."""
    for each in node.specifiers:
        region = each.region if isinstance(each, nodes.InRegion) else None
        while isinstance(region, nodes.VisiblePart):
            region = region.region
        word = region.id if isinstance(region, nodes.Name) else getattr(region, "name", "")
        if region is not None and word in OFF_THE_ROAD and not ev.has(word):
            ev.report(BESIDE_THE_ROAD.at(region.span, name=actor.name, word=ev.facts.source.slice(region.span)))


def _require_of(ev: Evaluator, actor: Actor, placement: Placement, node: nodes.New) -> None:
    """Add the requirements of an object's specifiers: the region that contains it, and its visibility."""
    if starts_on_road(actor):
        _warn_of_kerb(ev, actor, node)
    line = ev.facts.line(node.span)
    own = None if placement.observed is not None else actor.properties.get("regionContainedIn")
    if starts_on_road(actor) and (between := vehicle_region(network_of(ev))) != ROAD.id:
        inside = geometry.inside(ev, actor, Region(between, "between the kerbs"), node.span)
        ev.run.built.requirements.append(ir.Requirement(inside, 1.0, f"{actor.name} lies between the kerbs", line))
    for region in (placement.contained, own):
        if region is not None:
            inside = geometry.inside(ev, actor, ROAD if isinstance(region, Network) else region, node.span)
            name = f"{actor.name} lies in {kind_name(region).removeprefix('a ')}"
            ev.run.built.requirements.append(ir.Requirement(inside, 1.0, name, line))
    if placement.observed is not None:
        viewer, seen = placement.observed
        sight = seeing.sees(ev, viewer, actor)
        who = viewer.name if isinstance(viewer, Actor) else "a point"
        name = f"{actor.name} is {'visible' if seen else 'not visible'} from {who}"
        ev.run.built.requirements.append(ir.Requirement(sight if seen else ~sight, 1.0, name, line))


def _actor_pose(
    making: ObjectBuilder, node: nodes.New, found: SpecifierGroups, name: str, placed: list[Placement]
) -> Pose:
    """The heading of its place comes before that of its class, and this before that of its kind."""
    ev = making.ev
    walks_anywhere = not found.places and not making.declares("position") and making.kind is ActorKind.PEDESTRIAN
    if walks_anywhere and not ev.facts.from_scenic:
        raise NO_PLACE.mistake(node.span, name=node.class_name)
    off_road = as_meant(ev, ev.algebra.literal(0.0)) if making.kind in OFF_ROAD else None
    if walks_anywhere:
        placement = _on_foot(ev, node, with_heading=not found.facings and not making.declares("heading"))
    else:
        placement = _actor_placement(making, node, found, off_road)
    placed.append(placement)
    if placement.heading is None or not found.places:
        heading = making.default_heading(placement.point) if found.settled is None else None
        if heading is not None:
            placement = replace(placement, heading=heading, lane=None)
    if off_road is None:
        placement = _on_level(making, node, found, placement, name or node.class_name)
    default = road_heading(placement.point.x, placement.point.y) if off_road is None else off_road
    return _posed(ev, node, found, placement, default, name)


def _on_level(
    making: ObjectBuilder, node: nodes.New, found: SpecifierGroups, placement: Placement, name: str
) -> Placement:
    """Head a vehicle along the road of its level. Without a heading of its own it takes the lower one of two."""
    free = not found.facings and found.settled is None
    if making.has("level"):
        lanes = lanes_in(making.get("level"))
    elif free and placement.heading is None:
        lanes = making.values["level"] = lower_lanes(making.ev, name, placement.point, node.span)
    else:
        return placement
    if not lanes or not free or placement.lane is not None or not (placement.drawn or placement.heading is None):
        return placement
    return replace(placement, heading=along_nearest(making.ev, lanes, placement.point))


def _on_foot(ev: Evaluator, node: nodes.New, *, with_heading: bool) -> Placement:
    """Return a random place on sidewalks and crossings, with any heading, as in Scenic."""
    region = walkable(ev, node.span)
    assert isinstance(region, Region)
    placement = within(ev, region)
    return replace(placement, heading=ev.run.new_draw() * math.tau if with_heading else None)


def _own_heading(ev: Evaluator, node: nodes.New, found: SpecifierGroups, default: Term | None) -> Term:
    """Return the heading of an object before it has a place.

    Raises:
        Mistake: that follows from its place.
    """
    if found.settled is None and found.facings:
        facing = found.facings[0]
        value = None if facing.mode else ev.evaluate(facing.heading)
        if not facing.mode and not isinstance(value, DirectionField):
            found.settled = geometry.heading_at(ev, value, Vector(*[ev.algebra.literal(0.0)] * 2), facing.heading.span)
    elif found.settled is None and not found.facings:
        found.settled = default
    if found.settled is None:
        raise NO_HEADING_YET.mistake(node.span, name=node.class_name)
    return found.settled


def _unique(ev: Evaluator, name: str) -> str:
    taken = ev.run.built.actor_names
    number = 2
    unique = name
    while unique in taken:
        unique, number = f"{name}{number}", number + 1
    taken.add(unique)
    return unique


def _actor_placement(making: ObjectBuilder, node: nodes.New, found: SpecifierGroups, heading: Term | None) -> Placement:
    ev = making.ev
    region = None if making.kind in OFF_ROAD or making.lies_anywhere() else ROAD
    if not found.places and making.declares("position"):
        return making.default_place()
    if not found.places:
        # As in Scenic: an object with a region of its own is anywhere in it, any other object in the middle of the map.
        return at_origin(ev) if making.builtin in (None, "Object") else within(ev, ROAD)
    length, width = making.get("length"), making.get("width")
    assert isinstance(length, Term)
    assert isinstance(width, Term)

    def own_heading(usual: Term | None) -> Term:
        return _own_heading(ev, node, found, heading if usual is None else usual)

    extent = Extent(length, width, own_heading, lambda: making.number("speed"), region, heading is None)
    return place(ev, found.places[0], extent)
