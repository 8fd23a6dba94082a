"""Following a lane or a trajectory, alone or behind somebody.

Car following is the Intelligent Driver Model of Treiber, Hennecke and Helbing (2000), "Congested traffic states in
empirical observations and microscopic simulations", Phys. Rev. E 62, 1805, equations 3 and 4:

    dv/dt = a (1 - (v / v0)^delta - (s* / s)^2)        s* = s0 + max(0, v T + v (v - v_lead) / (2 sqrt(a b)))

with the defaults of its table I for cars: T = 1.6 s, a = 0.73 m/s^2, b = 1.67 m/s^2, delta = 4, s0 = 2 m. s is the gap
between the outlines along the path. (The interaction term is held above 0, as in Treiber and Kesting, "Traffic Flow
Dynamics", 2013, section 11.3, so that a lead that draws away is no reason to brake.)
"""

from cortex_dsl import ir
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.acting.library.job import SPEED_GAIN, Job
from cortex_dsl.semantics.evaluation.motion import current_pose
from cortex_dsl.semantics.road.lanes import lane_at, looked_up, some_lane
from cortex_dsl.semantics.road.roads import network_of
from cortex_dsl.semantics.road.trajectories import trajectory
from cortex_dsl.semantics.values import LaneNow, Value
from engine.road.network import Lane
from engine.road.sections import LaneSection
from engine.vocabulary import ActorKind, Op

TIME_HEADWAY = 1.6
MIN_GAP = 2.0
MAX_ACCELERATION = 0.73
COMFORTABLE_DECELERATION = 1.67
EXPONENT = 4.0
LEAST_GAP = 0.01
"""Below this gap the model has no value [m]; who is so near brakes fully."""


def follow_trajectory(job: Job) -> ir.Block:
    _warn_walker(job)
    way = trajectory(job.call.arguments["trajectory"], job.call.spans["trajectory"])
    return (job.follow(job.ev.algebra.literal(float(way.path)), job.target_speed()),)


def follow_lane(job: Job) -> ir.Block:
    """The lane given, or the lane the actor is on when this begins, and its default continuation."""
    _warn_walker(job)
    acts, path = lane_route(job, "laneToFollow", against=job.flag("is_oppositeTraffic"))
    return (*acts, job.follow(path, job.target_speed()))


def _warn_walker(job: Job) -> None:
    if job.actor.kind is ActorKind.PEDESTRIAN:
        job.ev.report(errors.WALKS_IN_LANE.at(job.call.span, behaviour=job.call.name))


def lane_route(job: Job, argument: str, *, against: bool = False) -> tuple[ir.Block, ir.Expr]:
    """Path of a driver who follows a lane; `against` its direction, back to where it begins."""
    lane = job.given(argument)
    if lane is None:
        lane = lane_at(job.ev, job.actor.pose if job.at_start else current_pose(job.ev, job.actor))
    span = job.call.spans.get(argument, job.call.span)
    index = some_lane(job.ev, lane, span, f"`{argument}`")
    return settled_path(job, index, against=against)


def settled_path(job: Job, index: ir.Expr, *, against: bool) -> tuple[ir.Block, ir.Expr]:
    """The path of a lane, remembered where only the run knows the lane."""
    network = network_of(job.ev)
    is_there = job.ev.algebra.apply(Op.LE, job.ev.algebra.literal(0.0), index)
    surely = isinstance(index, ir.Apply) and index.op is Op.LANE_NEAREST
    demand = () if surely else job.abort_unless(is_there, f"{job.call.name} has a lane to go to")
    routes = [network.paths.reverse(lane.path) if against else lane.default_route for lane in network.lanes]
    route = looked_up(job.ev, index, routes, missing=0.0)
    if isinstance(route, ir.Literal):
        return demand, route
    act, path = job.kept(route)
    return (*demand, act), path


def follow_car(job: Job) -> ir.Block:
    """A trajectory or a lane, no faster than the car ahead lets one go."""
    way = job.given("trajectory")
    acts, path = lane_route(job, "trajectory") if way is None or _is_lane_now(way) else ((), _path_of(job, way))
    return (*acts, job.follow(path, _idm_target(job, path)))


def _is_lane_now(value: Value) -> bool:
    return isinstance(value, LaneNow | LaneSection)


def _path_of(job: Job, way: Value) -> ir.Expr:
    if isinstance(way, Lane):
        return job.ev.algebra.literal(float(way.default_route))
    return job.ev.algebra.literal(float(trajectory(way, job.call.spans["trajectory"]).path))


def _idm_target(job: Job, path: ir.Expr) -> ir.Expr:
    """The target speed by which the speed controller gives the model's acceleration."""
    algebra = job.ev.algebra
    by = algebra.apply(Op.DIV, idm_acceleration(job, path), algebra.literal(SPEED_GAIN))
    return algebra.add(job.speed(), by)


def idm_acceleration(job: Job, path: ir.Expr) -> ir.Expr:
    """dv/dt of the model for who drives along `path` [m/s^2]."""
    algebra, speed, one = job.ev.algebra, job.speed(), job.ev.algebra.literal(1.0)
    a = job.number("max_acceleration", MAX_ACCELERATION)
    gap, lead = algebra.items(algebra.apply(Op.LEAD, path, immediates=(job.actor.index,), width=2), 2)
    wanted = _wanted_gap(job, a, lead)
    # A target speed of 0 wants standstill: the quotient is then infinite, or undefined at rest, so it is held above.
    desired = algebra.apply(Op.MAX, job.target_speed(), algebra.literal(0.1))
    free = algebra.apply(Op.POW, algebra.apply(Op.DIV, speed, desired), job.number("exponent", EXPONENT))
    share = algebra.apply(Op.DIV, wanted, algebra.apply(Op.MAX, gap, algebra.literal(LEAST_GAP)))
    return algebra.mul(a, algebra.sub(algebra.sub(one, free), algebra.mul(share, share)))


def _wanted_gap(job: Job, a: ir.Expr, lead: ir.Expr) -> ir.Expr:
    """s* [m]"""
    algebra, speed = job.ev.algebra, job.speed()
    b = job.number("comfortable_deceleration", COMFORTABLE_DECELERATION)
    root = algebra.apply(Op.SQRT, algebra.mul(a, b))
    approach = algebra.mul(speed, algebra.sub(speed, lead))
    closing = algebra.apply(Op.DIV, approach, algebra.mul(algebra.literal(2.0), root))
    moving = algebra.add(algebra.mul(speed, job.number("time_headway", TIME_HEADWAY)), closing)
    return algebra.add(job.number("min_gap", MIN_GAP), algebra.apply(Op.MAX, algebra.literal(0.0), moving))
