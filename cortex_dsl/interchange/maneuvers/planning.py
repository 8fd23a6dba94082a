"""From one scene of a compiled scenario to a neutral plan of all its actors: start, route, and ends of the run.

A start is a formula if the file ties its place to a param, else the sampled place.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from cortex_dsl import ir
from cortex_dsl.api.scenario import Scenario
from cortex_dsl.interchange.maneuvers.formulas import Case, UnsayableError, formula_of, settled, varied_params
from cortex_dsl.interchange.maneuvers.intentions import Drive, Reader, refuse_wide
from cortex_dsl.interchange.maneuvers.triggers import trigger_of
from engine.interchange.openscenario.document import unique_names
from engine.interchange.openscenario.maneuvers import formula
from engine.interchange.openscenario.maneuvers.formula import Formula
from engine.interchange.openscenario.maneuvers.maneuver_plan import (
    ActorPlan,
    Bend,
    Change,
    Condition,
    End,
    ManeuverPlan,
    Measure,
    Parameter,
    Start,
    Way,
    phases_of,
)
from engine.interchange.recording import Recording
from engine.opcodes import Op
from engine.road.network import Lane, LaneRole
from engine.scenes import Scenes
from engine.vocabulary import ActorKind, Column, RuleKind

# -- where actors start ------------------------------------------------------------------------------------------------

NEAR = 1e-6
"""Distance and angle up to which a pose is on a centre line [m, rad]."""
MAX_LANE_OFFSET = 0.5
"""Further from a lane's centre line than this part of its width, an actor is on no lane."""
PROBES = 9
"""Places at which a distance is compared with the way that is left."""


@dataclass(frozen=True)
class Placed:
    """A start, and the parameters that vary it."""

    start: Start
    parameters: tuple[Parameter, ...] = ()


def start_of(case: Case, actor: int, name: str, lanes: Sequence[Lane]) -> Placed:
    """Return the start of an actor, relative to one of these lanes if it is near one.

    Positions are those of rear axles.
    """
    x, y, heading = (case.column(actor, column) for column in (Column.X, Column.Y, Column.HEADING))
    back = case.column(actor, Column.REAR_TO_CENTER)
    pose = (x - back * math.cos(heading), y - back * math.sin(heading), heading)
    found = _lane_of(lanes, pose)
    if found is None:
        return Placed(Start(pose))
    lane, s, offset, turned = found
    if abs(offset) > NEAR or abs(turned) > NEAR:
        return Placed(Start(pose, lane.id, formula.number(s), offset, turned))
    along, parameters = _along(case, actor, name, lane, s)
    return Placed(Start(pose, lane.id, along), parameters)


def _lane_of(lanes: Sequence[Lane], pose: tuple[float, float, float]) -> tuple[Lane, float, float, float] | None:
    """The nearest lane that runs the way of a pose: with arc length, offset to the left, and turn against it."""
    x, y, heading = pose
    best = None
    for lane in lanes:
        paths = lane.network.paths
        s = paths.project(lane.path, x, y)
        foot = paths.pose(lane.path, s)
        ahead = (x - foot.x) * math.cos(foot.heading) + (y - foot.y) * math.sin(foot.heading)
        offset = (y - foot.y) * math.cos(foot.heading) - (x - foot.x) * math.sin(foot.heading)
        turned = math.remainder(heading - foot.heading, math.tau)
        fits = abs(ahead) < NEAR and abs(offset) < MAX_LANE_OFFSET * lane.width and abs(turned) < math.pi / 4
        if fits and (best is None or abs(offset) < abs(best[2])):
            best = (lane, s, offset, turned)
    return best


def _along(case: Case, actor: int, name: str, lane: Lane, s: float) -> tuple[Formula, tuple[Parameter, ...]]:
    """Arc length of the rear axle on the lane."""
    given = _given(case, actor, lane)
    if given is not None and not given.plain:
        back = formula.number(case.column(actor, Column.REAR_TO_CENTER))
        return formula.subtract(given, back), ()
    for tie in (_tie(case, actor, lane, each) for each in case.variant.requirements):
        if tie is not None:
            return _tied(case, actor, name, s, tie)
    drawn = _free(case, f"{name}_start")
    return formula.parameter(drawn), (Parameter(drawn, s, 0.0, lane.length, is_drawn=False),)


def _free(case: Case, name: str) -> str:
    """A name that no param has."""
    while name in case.names:
        name += "_drawn"
    return name


def _given(case: Case, actor: int, lane: Lane) -> Formula | None:
    """Arc length of the centre, where the file puts it on this very lane."""
    columns = case.actors[actor].columns
    x, y, heading = (columns[column] for column in (Column.X, Column.Y, Column.HEADING))
    parts = [each.bundle if isinstance(each, ir.Item) else None for each in (x, y, heading)]
    bundle = parts[0]
    if not isinstance(bundle, ir.Apply) or bundle.op != Op.PATH_POSE or not (bundle is parts[1] is parts[2]):
        return None
    path, along = bundle.arguments
    paths = lane.network.paths
    parts = paths.parts(int(path.value)) if isinstance(path, ir.Literal) else ()
    if lane.path not in parts:
        return None
    before = sum(paths.length(part) for part in parts[: parts.index(lane.path)])
    try:
        return formula.subtract(formula_of(case, along), formula.number(before))
    except UnsayableError:
        return None


# -- a start that a `require` ties to a param -------------------------------------------------------------------------


@dataclass(frozen=True)
class _Tie:
    """`abs((distance from actor to region) - wanted) <= slack`, if the distance is the remainder of the lane."""

    wanted: Formula
    slack: float
    at_start: float
    """Distance at the start of the lane [m]."""


def _tied(case: Case, actor: int, name: str, s: float, tie: _Tie) -> tuple[Formula, tuple[Parameter, ...]]:
    """Return the start position that the params give, with a shift parameter for the offset of the draw.

    Shifts are allowed within the slack of the tie.
    """
    shift, back = _free(case, f"{name}_shift"), case.column(actor, Column.REAR_TO_CENTER)
    genome = dict(zip(case.names, case.scenes.genomes[case.row].tolist(), strict=True))
    base = formula.subtract(formula.number(tie.at_start - back), tie.wanted)
    here = Parameter(shift, s - base.value(genome), -tie.slack, tie.slack, is_drawn=False)
    return formula.add(base, formula.parameter(shift)), (here,)


def _tie(case: Case, actor: int, lane: Lane, requirement: ir.Requirement) -> _Tie | None:
    condition = requirement.condition
    if not isinstance(condition, ir.Apply) or condition.op not in (Op.LE, Op.LT) or lane.role is LaneRole.CONNECTING:
        return None
    window, slack = condition.arguments
    if not (isinstance(window, ir.Apply) and window.op == Op.ABS and isinstance(slack, ir.Literal)):
        return None
    inner = window.arguments[0]
    if not (isinstance(inner, ir.Apply) and inner.op == Op.SUB):
        return None
    for distance, wanted in (inner.arguments, inner.arguments[::-1]):
        region = _own_region(case, actor, distance)
        if region is not None and (start := _falls(lane, region)) is not None:
            return _wanted(case, wanted, slack.value, start)
    return None


def _wanted(case: Case, wanted: ir.Expr, slack: float, start: float) -> _Tie | None:
    try:
        formula_wanted = formula_of(case, wanted)
    except UnsayableError:
        return None
    return None if formula_wanted.plain else _Tie(formula_wanted, slack, start)


def _own_region(case: Case, actor: int, distance: ir.Expr) -> int | None:
    """The region from which the distance of an actor's start is taken."""
    if not (isinstance(distance, ir.Apply) and distance.op == Op.REGION_DISTANCE):
        return None
    region, x, y = distance.arguments
    columns = case.actors[actor].columns
    own = x is columns[Column.X] and y is columns[Column.Y]
    return int(region.value) if own and isinstance(region, ir.Literal) else None


def _falls(lane: Lane, region: int) -> float | None:
    """Distance of the lane's start from a region, if it falls by a metre for each metre along the lane."""
    network = lane.network
    at_start = None
    for s in np.linspace(0.0, lane.length, PROBES).tolist():
        pose = network.paths.pose(lane.path, s)
        distance = network.regions.distance(region, pose.x, pose.y)
        at_start = distance if at_start is None else at_start
        if abs(distance - (at_start - s)) > NEAR:
            return None
    return at_start


# -- the plan ----------------------------------------------------------------------------------------------------------


def maneuver_plan(scenario: Scenario, scenes: Scenes, row: int = 0, run: Recording | None = None) -> ManeuverPlan:
    """Return the intended maneuvers of the actors of one scene; `remarks` lists inexpressible ones.

    With `run`, an actor that leaves its lanes in a bend is inexpressible.
    """
    case = Case(scenario, scenes, row)
    names = unique_names(actor.name for actor in case.actors)
    readers = [Reader(case, names, index) for index in range(len(names))]
    planned = [_planned(reader, run) for reader in readers]
    actors = tuple(plan for plan, _, _ in planned)
    ends = (*_rule_ends(case, names, readers[0]), *_behaviour_ends(case, planned), *_other_ends(case, names))
    starts = tuple(parameter for _, placed, _ in planned for parameter in placed.parameters)
    plan = ManeuverPlan(actors, (*varied_params(case), *starts), ends)
    used = plan.used()
    remarks = [remark for reader in readers for remark in reader.remarks]
    remarks += [*_left_out(case), *_unused(case, used)]
    parameters = tuple(each for each in plan.parameters if each.name in used)
    return ManeuverPlan(actors, parameters, ends, tuple(dict.fromkeys(remarks)))


# -- actors -----------------------------------------------------------------------------------------------------------


def _planned(reader: Reader, run: Recording | None) -> tuple[ActorPlan, Placed, Drive | None]:
    case, actor, name = reader.case, reader.actor, reader.names[reader.actor]
    try:
        if not case.actors[actor].present:
            raise UnsayableError("that it comes in later", case.actors[actor].span)
        drive = reader.drive()
        lanes = _route_lanes(case, drive)
        refuse_wide(case, actor, drive, run)
        placed = _placed(case, actor, name, lanes)
        return _actor_plan(case, reader, drive, placed, lanes), placed, drive
    except UnsayableError as error:
        words = f"`{name}` goes along its recorded trajectory, for no maneuver says {error.what}"
        reader.remarks.append(f"{words} ({case.place(error.span if error.span.end else case.actors[actor].span)})")
        placed = Placed(start_of(case, actor, name, ()).start)
        speed = formula.number(case.column(actor, Column.SPEED))
        return ActorPlan(name, placed.start, speed, exact=True), placed, None


def _route_lanes(case: Case, drive: Drive) -> Sequence[Lane]:
    """The lanes of a path, in order.

    Raises:
        UnsayableError: the path runs along no lanes, as one against the traffic.
    """
    if drive.path is None:
        return ()
    by_path = {lane.path: lane for lane in case.whole.network.lanes}
    parts = case.whole.network.paths.parts(drive.path)
    if not all(part in by_path for part in parts):
        raise UnsayableError("a way against the traffic", case.actors[0].span)
    return tuple(by_path[part] for part in parts)


def _placed(case: Case, actor: int, name: str, lanes: Sequence[Lane]) -> Placed:
    if case.actors[actor].kind == ActorKind.OBSTACLE:
        return Placed(start_of(case, actor, name, ()).start)
    return start_of(case, actor, name, lanes or case.whole.network.lanes)


def _actor_plan(case: Case, reader: Reader, drive: Drive, placed: Placed, lanes: Sequence[Lane]) -> ActorPlan:
    actor, name, start = reader.actor, reader.names[reader.actor], placed.start
    speed = settled(case, case.actors[actor].columns[Column.SPEED])
    free = Change(drive.target, drive.rate)
    if not lanes:
        _check_keeps_to_lane(reader, start.lane, free, speed)
        return ActorPlan(name, start, speed, (), phases_of(Way(), speed, free), drive.reactions)
    if start.lane is None or drive.path is None:
        raise UnsayableError("how it gets to its way from where it starts", case.actors[actor].span)
    first = next(i for i, lane in enumerate(lanes) if lane.id == start.lane)
    way = _way(case, actor, drive, lanes[: first + 1], start.s)
    end = case.whole.network.paths.length(drive.path) - case.column(actor, Column.REAR_TO_CENTER)
    leaves = formula.subtract(formula.number(end), way.along)
    route = tuple(lane.id for lane in lanes[first:])
    return ActorPlan(name, start, speed, route, phases_of(way, speed, free), drive.reactions, leaves)


def _way(case: Case, actor: int, drive: Drive, begun: Sequence[Lane], s: Formula) -> Way:
    """The path of an actor; `begun` are its lanes up to the one on which the actor starts, at arc length `s`."""
    assert drive.path is not None
    paths = case.whole.network.paths
    before = sum(lane.length for lane in begun[:-1])
    parts = zip(paths.starts(drive.path), paths.primitives(drive.path), strict=False)
    bends = tuple(Bend(at, at + each.length, abs(each.curvature)) for at, each in parts if each.curvature != 0.0)
    along = formula.add(s, formula.number(before))
    return Way(bends, along, before + begun[-1].length, drive.lateral, case.column(actor, Column.MAX_BRAKING))


def _check_keeps_to_lane(reader: Reader, lane: int | None, free: Change, speed: Formula) -> None:
    """In the simulation an actor that only keeps a speed goes straight on; readers keep it in its lane."""
    if free.speed == speed == formula.ZERO:
        return
    if lane is None:
        raise UnsayableError("its way off the lanes", reader.case.actors[reader.actor].span)
    reader.remarks.append(f"`{reader.names[reader.actor]}` keeps to its lane; in the simulation it goes straight on")


# -- ends -------------------------------------------------------------------------------------------------------------


def _rule_ends(case: Case, names: tuple[str, ...], reader: Reader) -> Iterator[End]:
    for rule in case.variant.rules:
        if rule.kind is not RuleKind.TERMINATE or rule.condition is None:
            continue
        try:
            yield End(rule.name, trigger_of(case, names, rule.condition))
        except UnsayableError as error:
            line = case.scenario.program.place(rule.line)
            reader.remarks.append(f"the end of the run `{rule.name}` needs {error.what} and is left out (line {line})")


def _behaviour_ends(case: Case, planned: Sequence[tuple[ActorPlan, Placed, Drive | None]]) -> Iterator[End]:
    for plan, _, drive in planned:
        if drive is not None and not plan.exact:
            for trigger, rule in drive.ends:
                yield End(case.variant.rules[rule].name, trigger)


def _other_ends(case: Case, names: tuple[str, ...]) -> Iterator[End]:
    """First contact of any two, and the time limit."""
    pairs = [(one, other) for i, one in enumerate(names) for other in names[i + 1 :]]
    touching = tuple((Condition(Measure.COLLISION, formula.ZERO, True, one, other),) for one, other in pairs)
    if touching:
        yield End("first contact", touching)
    limit = formula.number(case.scenario.config.simulation.max_time)
    yield End("the time is over", ((Condition(Measure.TIME, limit, below=False),),))


# -- remarks ----------------------------------------------------------------------------------------------------------


def _unused(case: Case, used: frozenset[str]) -> Iterator[str]:
    idle = [gene.name for gene, name in zip(case.whole.genes, case.names, strict=True) if name not in used]
    if idle:
        yield f"nothing in the file depends on {', '.join(idle)}: what they decide is as in this case"


def _left_out(case: Case) -> Iterator[str]:
    """Yield remarks on omitted parts that belong to no single actor."""
    place = case.scenario.program.place
    for requirement in case.variant.rules:
        if requirement.kind is RuleKind.ABORT and requirement.condition is not None:
            yield f"`{requirement.name}` is not watched (line {place(requirement.line)})"
    for monitor in case.variant.monitors:
        yield f"what `{monitor.name}` does is left out ({case.place(monitor.span)})"
    if case.whole.temporals:
        yield "temporal requirements are not watched"
    if case.whole.records:
        yield "nothing is recorded of what the file asks to record"
