"""Changing lanes: the actor's offset from the new lane's centre line is taken away along a smooth curve.

The offset e0 at the beginning shrinks as the quintic of least jerk, e(u) = e0 (1 - 10 u^3 + 15 u^4 - 6 u^5) for u from
0 to 1 (Flash and Hogan 1985, J. Neurosci. 5, 1688, equation 6). Its greatest lateral acceleration is 5.77 e0 / T^2:
1.65 m/s^2 for 3.5 m in the default T = 3.5 s, within the 1 to 16.5 s that drivers take (Toledo and Zohar 2007, Transp.
Res. Rec. 1999, 71). Slow vehicles cannot turn that sharply, so at least four times the offset is driven meanwhile.

Steering is the law of the engine's path follower (`engine.kernels.steering`) around that curve instead of around the
centre line, with the curve's own curvature looked ahead to.
"""

from cortex_dsl import ir
from cortex_dsl.semantics.acting.library.following import settled_path
from cortex_dsl.semantics.acting.library.job import SPEED_GAIN, Job
from cortex_dsl.semantics.evaluation.motion import current_pose, size
from cortex_dsl.semantics.road.lanes import some_lane
from engine.frozen import frozen
from engine.vocabulary import Command, Op

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
        back = size(job.actor, "rearToCenter")
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
        return job.ev.algebra.add(self.s, size(job.actor, "rearToCenter"))

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
    angle = algebra.apply(Op.ATAN, algebra.mul(size(job.actor, "wheelbase"), curvature))
    wanted = algebra.mul(number(SPEED_GAIN), algebra.sub(job.target_speed(), job.speed()))
    braking = algebra.apply(Op.MAX, wanted, number(-BRAKING_LIMIT))
    return ir.Take(job.call.span, ((Command.STEER, angle), *job.pedals(braking)))


def _clipped(job: Job, value: ir.Expr, most: ir.Expr) -> ir.Expr:
    algebra = job.ev.algebra
    return algebra.apply(Op.MIN, most, algebra.apply(Op.MAX, algebra.apply(Op.NEG, most), value))
