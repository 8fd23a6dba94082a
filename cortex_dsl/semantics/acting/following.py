"""Library behaviours that go somewhere: holding speed or pedals, following a lane or trajectory, alone or behind
somebody, and changing lanes.

Car following is the Intelligent Driver Model of Treiber, Hennecke and Helbing (2000), "Congested traffic states in
empirical observations and microscopic simulations", Phys. Rev. E 62, 1805, equations 3 and 4:

    dv/dt = a (1 - (v / v0)^delta - (s* / s)^2)        s* = s0 + max(0, v T + v (v - v_lead) / (2 sqrt(a b)))

with the defaults of its table I for cars: T = 1.6 s, a = 0.73 m/s^2, b = 1.67 m/s^2, delta = 4, s0 = 2 m. s is the gap
between the outlines along the path. (The interaction term is held above 0, as in Treiber and Kesting, "Traffic Flow
Dynamics", 2013, section 11.3, so that a lead that draws away is no reason to brake.)

Who changes lanes takes the offset from the new lane's centre line away along a smooth curve. The offset e0 at the
beginning shrinks as the quintic of least jerk, e(u) = e0 (1 - 10 u^3 + 15 u^4 - 6 u^5) for u from 0 to 1 (Flash and
Hogan 1985, J. Neurosci. 5, 1688, equation 6). Its greatest lateral acceleration is 5.77 e0 / T^2: 1.65 m/s^2 for 3.5 m
in the default T = 3.5 s, within the 1 to 16.5 s that drivers take (Toledo and Zohar 2007, Transp. Res. Rec. 1999, 71).
Slow vehicles cannot turn that sharply, so at least four times the offset is driven meanwhile. Steering is the law of
the engine's path follower (`engine.kernels.steering`) around that curve instead of around the centre line, with the
curve's own curvature looked ahead to.
"""

from cortex_dsl import ir
from cortex_dsl.semantics.acting.job import SPEED_GAIN, Job
from cortex_dsl.semantics.errors.behaviours import WALKS_IN_LANE
from cortex_dsl.semantics.evaluation.geometry import current_pose, size_of
from cortex_dsl.semantics.evaluation.lanes import lane_at, looked_up, some_lane, trajectory
from cortex_dsl.semantics.evaluation.roads import network_of
from cortex_dsl.semantics.model.values import LaneNow, Value
from engine.frozen import frozen
from engine.road.network import Lane
from engine.road.sections import LaneSection
from engine.vocabulary import ActorKind, Command, Op

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
        job.ev.report(WALKS_IN_LANE.at(job.call.span, behaviour=job.call.name))


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


# -- changing lanes ----------------------------------------------------------------------------------------------------

DURATION = 3.5
"""[s]"""
LEAST_WAY = 4.0
"""Way driven at least, as a multiple of the offset."""
SETTLED_OFFSET = 0.1
"""From the centre line, as in Scenic [m] …"""
SETTLED_ANGLE = 0.02
"""… and from its direction [rad]."""
PREVIEW = 0.2
MIN_LOOK_AHEAD = 3.0
LOOK_AHEAD = 0.4
OFFSET_SHARE = 0.35
"""Of the engine's path follower [s, m, s, 1]; a test compares them."""
BRAKING_LIMIT = 8.0
"""Of the engine's speed controller [m/s^2]."""


def change_lane(job: Job) -> ir.Block:
    """Move over to a lane; ends when settled in it, or at the end of the path."""
    job.must_steer()
    span = job.call.span
    lane = some_lane(
        job.ev, job.given("laneSectionToSwitch"), job.call.spans["laneSectionToSwitch"], "`laneSectionToSwitch`"
    )
    acts, path = settled_path(job, lane, against=job.flag("is_oppositeTraffic"))
    place = _Place.of(job, path)
    shift = _Shift.begun(job, place)
    over = job.ev.algebra.apply(Op.LE, job.ev.algebra.literal(1.0), shift.progress)
    at_end = job.ev.algebra.apply(Op.LE, job.ev.algebra.apply(Op.PATH_LENGTH, path), place.ahead(job))
    settled = place.settled(job)
    moving = ir.Loop(span, job.ev.algebra.truth(True), (*shift.advance(job), _steer(job, place, shift)))
    follow = ir.Follow(span, path, job.target_speed(), job.max_lateral(), job.ev.run.new_local())
    stop = job.ev.algebra.apply(Op.OR, over, job.ev.algebra.apply(Op.OR, at_end, settled))
    return (*acts, *shift.beginning, job.until((moving,), stop), job.until((follow,), settled))


@frozen
class _Place:
    """Where the rear axle is beside the path of the new lane."""

    path: ir.Expr
    s: ir.Expr
    offset: ir.Expr
    """To the left of the path [m]."""
    direction: ir.Expr
    """Heading of the actor against that of the path [rad]."""

    @staticmethod
    def of(job: Job, path: ir.Expr) -> "_Place":
        algebra, pose = job.ev.algebra, current_pose(job.ev, job.actor)
        back = size_of(job.actor, "rearToCenter")
        x = algebra.sub(pose.x, algebra.mul(back, algebra.apply(Op.COS, pose.heading)))
        y = algebra.sub(pose.y, algebra.mul(back, algebra.apply(Op.SIN, pose.heading)))
        s = algebra.apply(Op.PATH_PROJECT, path, x, y)
        foot_x, foot_y, heading = algebra.items(algebra.apply(Op.PATH_POSE, path, s, width=3), 3)
        left = algebra.mul(algebra.sub(y, foot_y), algebra.apply(Op.COS, heading))
        right = algebra.mul(algebra.sub(x, foot_x), algebra.apply(Op.SIN, heading))
        turned = algebra.apply(Op.WRAP, algebra.sub(pose.heading, heading))
        return _Place(path, s, algebra.sub(left, right), turned)

    def ahead(self, job: Job) -> ir.Expr:
        """Arc length at the middle of the outline."""
        return job.ev.algebra.add(self.s, size_of(job.actor, "rearToCenter"))

    def settled(self, job: Job) -> ir.Expr:
        algebra = job.ev.algebra
        near = algebra.apply(Op.LT, algebra.apply(Op.ABS, self.offset), algebra.literal(SETTLED_OFFSET))
        along = algebra.apply(Op.LT, algebra.apply(Op.ABS, self.direction), algebra.literal(SETTLED_ANGLE))
        return algebra.apply(Op.AND, near, along)


@frozen
class _Shift:
    """How far the change has come: locals, and the acts that set them."""

    offset: ir.Expr
    """At the beginning [m]."""
    progress: ir.Expr
    """u, from 0 to 1."""
    way: ir.Expr
    """Way of the whole change at the speed of the moment [m]."""
    clock: ir.Expr
    """When progress was made last [s]."""
    locals: tuple[int, int]
    beginning: ir.Block

    @staticmethod
    def begun(job: Job, place: _Place) -> "_Shift":
        algebra, span = job.ev.algebra, job.call.span
        keep, offset = job.kept(place.offset)
        numbers = (job.ev.run.new_local(), job.ev.run.new_local())
        progress, clock = (algebra.local(number) for number in numbers)
        least = algebra.mul(algebra.literal(LEAST_WAY), algebra.apply(Op.ABS, offset))
        # A metre keeps the quotient finite for who is in the lane already.
        least = algebra.apply(Op.MAX, least, algebra.literal(1.0))
        way = algebra.apply(Op.MAX, least, algebra.mul(job.speed(), job.number("duration", DURATION)))
        beginning = (
            keep,
            ir.SetLocal(span, numbers[0], algebra.literal(0.0)),
            ir.SetLocal(span, numbers[1], algebra.apply(Op.TIME)),
        )
        return _Shift(offset, progress, way, clock, numbers, beginning)

    def advance(self, job: Job) -> ir.Block:
        """What the step since the last turn has brought."""
        algebra, now = job.ev.algebra, job.ev.algebra.apply(Op.TIME)
        driven = algebra.mul(job.speed(), algebra.sub(now, self.clock))
        further = algebra.add(self.progress, algebra.apply(Op.DIV, driven, self.way))
        return (
            ir.SetLocal(job.call.span, self.locals[0], further),
            ir.SetLocal(job.call.span, self.locals[1], now),
        )

    def curve(self, job: Job, u: ir.Expr) -> tuple[ir.Expr, ir.Expr, ir.Expr]:
        """Offset [m], slope and curvature [1/m] of the curve at `u`."""
        algebra, number = job.ev.algebra, job.ev.algebra.literal
        one = number(1.0)
        u = algebra.apply(Op.MIN, one, u)
        rest, square = algebra.sub(one, u), algebra.mul(u, u)
        quintic = algebra.add(number(10.0), algebra.mul(u, algebra.sub(algebra.mul(number(6.0), u), number(15.0))))
        offset = algebra.mul(self.offset, algebra.sub(one, algebra.mul(algebra.mul(square, u), quintic)))
        slope = algebra.mul(number(-30.0), algebra.mul(square, algebra.mul(rest, rest)))
        bend = algebra.mul(number(-60.0), algebra.mul(algebra.mul(u, rest), algebra.sub(rest, u)))
        per_metre = algebra.apply(Op.DIV, self.offset, self.way)
        return offset, algebra.mul(slope, per_metre), algebra.mul(bend, algebra.apply(Op.DIV, per_metre, self.way))


def _steer(job: Job, place: _Place, shift: _Shift) -> ir.Act:
    """One step along the curve, at the target speed."""
    algebra, number = job.ev.algebra, job.ev.algebra.literal
    look_ahead = algebra.apply(Op.MAX, number(MIN_LOOK_AHEAD), algebra.mul(number(LOOK_AHEAD), job.speed()))
    offset, slope, _ = shift.curve(job, shift.progress)
    preview = algebra.apply(Op.DIV, algebra.mul(number(PREVIEW), job.speed()), shift.way)
    _, _, bend = shift.curve(job, algebra.add(shift.progress, preview))
    turn = algebra.apply(Op.SIN, algebra.sub(algebra.apply(Op.ATAN, slope), place.direction))
    most = algebra.mul(number(OFFSET_SHARE), look_ahead)
    off = _clipped(job, algebra.sub(place.offset, offset), most)
    back = algebra.apply(Op.DIV, off, algebra.mul(look_ahead, look_ahead))
    heading = algebra.apply(Op.DIV, algebra.mul(number(2.0), turn), look_ahead)
    curvature = algebra.sub(algebra.add(bend, heading), back)
    angle = algebra.apply(Op.ATAN, algebra.mul(size_of(job.actor, "wheelbase"), curvature))
    wanted = algebra.mul(number(SPEED_GAIN), algebra.sub(job.target_speed(), job.speed()))
    braking = algebra.apply(Op.MAX, wanted, number(-BRAKING_LIMIT))
    return ir.Take(job.call.span, ((Command.STEER, angle), *job.pedals(braking)))


def _clipped(job: Job, value: ir.Expr, most: ir.Expr) -> ir.Expr:
    algebra = job.ev.algebra
    return algebra.apply(Op.MIN, most, algebra.apply(Op.MAX, algebra.apply(Op.NEG, most), value))


# -- looking at nothing ------------------------------------------------------------------------------------------------


def constant_speed(job: Job) -> ir.Block:
    return (ir.HoldSpeed(job.call.span, job.number("speed")),)


def constant_throttle(job: Job) -> ir.Block:
    return (job.forever(ir.Take(job.call.span, ((Command.THROTTLE, job.number("x")),))),)


def brake(job: Job) -> ir.Block:
    return (job.forever(ir.Take(job.call.span, ((Command.BRAKE, job.number("pedal", 1.0)),))),)


def idle(job: Job) -> ir.Block:
    return (job.forever(ir.Wait(job.call.span)),)
