"""Where actors start: as a formula where the file ties their place to a param, else as it was drawn."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cortex_dsl import ir
from cortex_dsl.exports.maneuvers.numbers import Case, UnsayableError, formula_of
from engine.interchange.openscenario.maneuvers import formula
from engine.interchange.openscenario.maneuvers.formula import Formula
from engine.interchange.openscenario.maneuvers.plan import Parameter, Start
from engine.road.network import Lane, LaneRole
from engine.vocabulary import Column, Op

NEAR = 1e-6
"""What is no further from a centre line is on it [m, rad]."""
BESIDE = 0.5
"""Further from a lane's centre line than this part of its width, an actor is on no lane."""
PROBES = 9
"""Places at which a distance is compared with the way that is left."""


@dataclass(frozen=True)
class Placed:
    """A start, and what others may vary of it."""

    start: Start
    parameters: tuple[Parameter, ...] = ()


def start_of(case: Case, actor: int, name: str, lanes: Sequence[Lane]) -> Placed:
    """Where an actor starts, on one of these lanes if it is near one. Places are those of rear axles."""
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
        fits = abs(ahead) < NEAR and abs(offset) < BESIDE * lane.width and abs(turned) < math.pi / 4
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
    """`abs((distance from actor to region) - wanted) <= slack`, where the distance is what is left of the lane."""

    wanted: Formula
    slack: float
    at_start: float
    """Distance at the start of the lane [m]."""


def _tied(case: Case, actor: int, name: str, s: float, tie: _Tie) -> tuple[Formula, tuple[Parameter, ...]]:
    """What the param asks for, and how far off it the draw was: within the slack every shift is allowed."""
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
