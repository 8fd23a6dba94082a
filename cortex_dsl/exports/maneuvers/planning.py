"""From one scene of a compiled scenario to a neutral plan of all its actors."""

from collections.abc import Iterator, Sequence

from cortex_dsl.api.scenario import Scenario
from cortex_dsl.exports.maneuvers.beginning import settled
from cortex_dsl.exports.maneuvers.driving import Drive, Reader
from cortex_dsl.exports.maneuvers.numbers import Case, UnsayableError
from cortex_dsl.exports.maneuvers.starts import Placed, start_of
from cortex_dsl.exports.maneuvers.triggers import trigger_of
from engine.interchange.openscenario.maneuvers import formula
from engine.interchange.openscenario.maneuvers.bends import Bend, Way, phases_of
from engine.interchange.openscenario.maneuvers.formula import Formula
from engine.interchange.openscenario.maneuvers.plan import (
    ActorPlan,
    Change,
    Condition,
    End,
    ManeuverPlan,
    Measure,
    Parameter,
)
from engine.interchange.openscenario.names import unique_names
from engine.road.network import Lane
from engine.scenes import Scenes
from engine.vocabulary import ActorKind, Column, Distribution, GeneKind, RuleKind


def maneuver_plan(scenario: Scenario, scenes: Scenes, row: int = 0) -> ManeuverPlan:
    """What the actors of one scene intend, and in `remarks` what of it cannot be said."""
    case = Case(scenario, scenes, row)
    names = unique_names(actor.name for actor in case.actors)
    readers = [Reader(case, names, index) for index in range(len(names))]
    planned = [_planned(reader) for reader in readers]
    actors = tuple(plan for plan, _, _ in planned)
    ends = (*_rule_ends(case, names, readers[0]), *_behaviour_ends(case, planned), *_other_ends(case, names))
    starts = tuple(parameter for _, placed, _ in planned for parameter in placed.parameters)
    plan = ManeuverPlan(actors, (*_genes(case), *starts), ends)
    used = plan.used()
    remarks = [remark for reader in readers for remark in reader.remarks]
    remarks += [*_left_out(case), *_unused(case, used)]
    parameters = tuple(each for each in plan.parameters if each.name in used)
    return ManeuverPlan(actors, parameters, ends, tuple(dict.fromkeys(remarks)))


# -- actors -----------------------------------------------------------------------------------------------------------


def _planned(reader: Reader) -> tuple[ActorPlan, Placed, Drive | None]:
    case, actor, name = reader.case, reader.actor, reader.names[reader.actor]
    try:
        if not case.actors[actor].present:
            raise UnsayableError("that it comes in later", case.actors[actor].span)
        drive = reader.drive()
        lanes = _route_lanes(case, drive)
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
    """In the simulation, who only keeps a speed goes straight on; readers keep it in its lane."""
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


# -- parameters -------------------------------------------------------------------------------------------------------


def _genes(case: Case) -> Iterator[Parameter]:
    for index, (gene, name) in enumerate(zip(case.whole.genes, case.names, strict=True)):
        if gene.kind == GeneKind.INDEX:
            continue
        value = float(case.scenes.genomes[case.row, index])
        bell = gene.distribution in (Distribution.NORMAL, Distribution.TRUNCATED_NORMAL)
        normal = (gene.mean, gene.deviation) if bell else None
        yield Parameter(name, value, gene.low, gene.high, normal, gene.kind == GeneKind.INTEGER, unit=gene.unit)


# -- remarks ----------------------------------------------------------------------------------------------------------


def _unused(case: Case, used: frozenset[str]) -> Iterator[str]:
    idle = [gene.name for gene, name in zip(case.whole.genes, case.names, strict=True) if name not in used]
    if idle:
        yield f"nothing in the file depends on {', '.join(idle)}: what they decide is as in this case"


def _left_out(case: Case) -> Iterator[str]:
    """What belongs to no single actor."""
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
