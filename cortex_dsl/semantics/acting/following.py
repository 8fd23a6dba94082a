"""Library behaviours that go somewhere: holding speed or pedals, following a lane or trajectory, alone or behind
another actor, and changing lanes.

Car following is the Intelligent Driver Model of Treiber, Hennecke and Helbing (2000), "Congested traffic states in
empirical observations and microscopic simulations", Phys. Rev. E 62, 1805, equations 3 and 4:

    dv/dt = a (1 - (v / v0)^delta - (s* / s)^2)        s* = s0 + max(0, v T + v (v - v_lead) / (2 sqrt(a b)))

with the defaults of its table I for cars: T = 1.6 s, a = 0.73 m/s^2, b = 1.67 m/s^2, delta = 4, s0 = 2 m. s is the gap
between the outlines along the path. (The interaction term is held above 0, as in Treiber and Kesting, "Traffic Flow
Dynamics", 2013, section 11.3, so that a lead that draws away is no reason to brake.)

An actor that changes lanes reduces its offset from the new centre line along a smooth curve. The offset e0 at the
beginning shrinks as the quintic of least jerk, e(u) = e0 (1 - 10 u^3 + 15 u^4 - 6 u^5) for u from 0 to 1 (Flash and
Hogan 1985, J. Neurosci. 5, 1688, equation 6). Its greatest lateral acceleration is 5.77 e0 / T^2: 1.65 m/s^2 for 3.5 m
in the default T = 3.5 s, within the 1 to 16.5 s that drivers take (Toledo and Zohar 2007, Transp. Res. Rec. 1999, 71).
Slow vehicles cannot turn that sharply, so at least four times the offset is driven meanwhile. Steering is the law of
the engine's path follower (`engine.kernels.steering`) around that curve instead of around the centre line, with the
curve's own curvature looked ahead to.

These behaviours are Python, not text of the language: a driver that follows a path changes its target speed in each
step, and the arguments of a behavior are evaluated once, where it starts. Three quarters of the code here also serve
`giving_way`, `choosing_lanes` and `external`, so text of it would be a second definition.
"""

from cortex_dsl import ir
from cortex_dsl.semantics.acting.job import DEFAULT_SPEED, SPEED_GAIN, Job
from cortex_dsl.semantics.errors.runs import WALKS_IN_LANE
from cortex_dsl.semantics.evaluation.alignments import fitting
from cortex_dsl.semantics.evaluation.geometry import current_pose, inside, size_of
from cortex_dsl.semantics.evaluation.lanes import lane_at, looked_up, some_lane
from cortex_dsl.semantics.evaluation.roads import network_of, region_of_intersections
from cortex_dsl.semantics.evaluation.seeing import notice_reach
from cortex_dsl.semantics.evaluation.trajectories import trajectory
from cortex_dsl.semantics.model.values import Alignment, LaneNow, Value
from cortex_dsl.semantics.quantities.algebra import (
    Term,
    atan,
    cos,
    lead_on,
    maximum,
    minimum,
    path_length,
    path_pose,
    path_project,
    sin,
    sqrt,
    wrapped,
)
from engine.frozen import frozen
from engine.opcodes import Op
from engine.road.network import Lane
from engine.road.sections import LaneSection
from engine.vocabulary import ActorKind, Command

TIME_HEADWAY = 1.6
MIN_GAP = 2.0
MAX_ACCELERATION = 0.73
COMFORTABLE_DECELERATION = 1.67
EXPONENT = 4.0
TURNING_SPEED = 6.0
"""Speed of Scenic's `TurnBehavior` [m/s]."""
LEAST_GAP = 0.01
"""Below this gap the model has no value [m]; an actor that is so near brakes fully."""


def follow_trajectory(job: Job) -> ir.Block:
    _warn_walker(job)
    return (job.follow(_trajectory(job), job.target_speed()),)


def turn(job: Job) -> ir.Block:
    """Along a trajectory for as long as all of the outline is in intersections, as Scenic's behaviour for turns."""
    _warn_walker(job)
    ev, span = job.ev, job.call.span
    drive = job.follow(_trajectory(job), job.number("target_speed", TURNING_SPEED))
    return (job.until((drive,), ~inside(ev, job.actor, region_of_intersections(ev, span), span)),)


def follow_lane(job: Job, speed: float = DEFAULT_SPEED) -> ir.Block:
    """Follow the lane given, or the lane the actor is on when this begins, and its default continuation.

    `speed`: the target speed of a call that gives none [m/s].
    """
    _warn_walker(job)
    acts, path = lane_route(job, "laneToFollow", against=job.flag("is_oppositeTraffic"))
    return (*acts, job.follow(path, job.target_speed(speed)))


def _warn_walker(job: Job) -> None:
    if job.actor.kind is ActorKind.PEDESTRIAN:
        job.ev.report(WALKS_IN_LANE.at(job.call.span, behaviour=job.call.name))


def lane_route(job: Job, argument: str, *, against: bool = False) -> tuple[ir.Block, Term]:
    """Return the path of a driver that follows a lane; with `against`, in reverse to the beginning of the lane."""
    lane = job.given(argument)
    if lane is None:
        lane = lane_at(job.ev, job.actor.pose if job.at_start else current_pose(job.ev, job.actor))
    span = job.call.spans.get(argument, job.call.span)
    index = some_lane(job.ev, lane, span, f"`{argument}`")
    return settled_path(job, index, against=against, surely=isinstance(lane, LaneNow) and bool(lane.drawn))


def settled_path(job: Job, index: Term, *, against: bool, surely: bool = False) -> tuple[ir.Block, Term]:
    """Return the path of a lane, stored if the lane is known only at run time; with `surely`, the lane exists."""
    network = network_of(job.ev)
    is_there = index >= 0.0
    surely = surely or (isinstance(index, ir.Apply) and index.op is Op.LANE_NEAREST)
    demand = () if surely else job.abort_unless(is_there, f"{job.call.name} has a lane to go to")
    routes = [network.paths.reverse(lane.path) if against else lane.default_route for lane in network.lanes]
    route = looked_up(job.ev, index, routes, missing=0.0)
    if isinstance(route, ir.Literal):
        return demand, route
    act, path = job.kept(route)
    return (*demand, act), path


def follow_car(job: Job) -> ir.Block:
    """Follow a trajectory or a lane, no faster than the car ahead allows."""
    acts, path = path_to_follow(job)
    return (*acts, job.follow(path, _idm_target(job, path)))


def path_to_follow(job: Job) -> tuple[ir.Block, Term]:
    """The path of `trajectory`: a `Path`, or that of lanes, of one lane, or of the lane it is on."""
    way = job.given("trajectory")
    return lane_route(job, "trajectory") if way is None or _is_lane_now(way) else ((), _path_of(job, way))


def _is_lane_now(value: Value) -> bool:
    return isinstance(value, LaneNow | LaneSection)


def _path_of(job: Job, way: Value) -> Term:
    if isinstance(way, Lane):
        return job.ev.algebra.literal(float(way.default_route))
    return _trajectory(job)


def _trajectory(job: Job) -> Term:
    """Return the path of connected lanes, or a `Path`."""
    way, span = job.given("trajectory"), job.call.spans["trajectory"]
    if isinstance(way, Alignment):
        return fitting(job.ev, job.actor, way, span)
    return job.ev.algebra.literal(float(trajectory(way, span).path))


def _idm_target(job: Job, path: Term) -> Term:
    """The target speed by which the speed controller gives the model's acceleration."""
    return job.speed() + idm_acceleration(job, path) / SPEED_GAIN


def idm_acceleration(
    job: Job, path: Term, acceleration: float = MAX_ACCELERATION, deceleration: float = COMFORTABLE_DECELERATION
) -> Term:
    """dv/dt = a (1 - (v / v0)^delta - (s* / s)^2) of the actor along `path` [m/s^2]; a and b where none are given."""
    gap, lead = lead_on(path, job.actor.index, notice_reach(job.ev))
    pair = job.number("max_acceleration", acceleration), job.number("comfortable_deceleration", deceleration)
    return idm(job, job.speed(), job.target_speed(), gap, lead, pair)


def idm(job: Job, speed: Term, target: Term, gap: Term, lead: Term, pair: tuple[Term, Term]) -> Term:
    """Return the acceleration [m/s^2] behind an actor of speed `lead` at this gap; `pair`: a and b."""
    wanted = _wanted_gap(job, speed, pair, lead)
    # A target speed of 0 wants standstill: the quotient is then infinite, or undefined at rest, so it is held above.
    free = (speed / maximum(target, 0.1)) ** job.number("exponent", EXPONENT)
    share = wanted / maximum(gap, LEAST_GAP)
    return pair[0] * (1.0 - free - share * share)


def _wanted_gap(job: Job, speed: Term, pair: tuple[Term, Term], lead: Term) -> Term:
    """s* = s0 + max(0, v T + v (v - v_lead) / (2 sqrt(a b))) [m]."""
    closing = speed * (speed - lead) / (2.0 * sqrt(pair[0] * pair[1]))
    return job.number("min_gap", MIN_GAP) + maximum(0.0, speed * job.number("time_headway", TIME_HEADWAY) + closing)


# -- changing lanes ----------------------------------------------------------------------------------------------------

DURATION = 3.5
"""[s]"""
LEAST_WAY = 4.0
"""Way driven at least, as a multiple of the offset."""
SETTLED_OFFSET = 0.1
"""Largest distance from the centre line of an actor that has settled, as in Scenic [m]."""
SETTLED_ANGLE = 0.02
"""Largest angle to the direction of the centre line of an actor that has settled, as in Scenic [rad]."""
PREVIEW = 0.2
MIN_LOOK_AHEAD = 3.0
LOOK_AHEAD = 0.4
OFFSET_SHARE = 0.35
"""Constants of the engine's path follower, from `PREVIEW` to here [s, m, s, 1]; a test compares them."""
BRAKING_LIMIT = 8.0
"""Hardest braking of the engine's speed controller [m/s^2]."""


def change_lane(job: Job) -> ir.Block:
    """Move over to a lane; ends when settled in it, or at the end of the path."""
    job.must_steer()
    lane = some_lane(
        job.ev, job.given("laneSectionToSwitch"), job.call.spans["laneSectionToSwitch"], "`laneSectionToSwitch`"
    )
    acts, path = settled_path(job, lane, against=job.flag("is_oppositeTraffic"))
    return (*acts, *move_over(job, path, job.target_speed()))


def move_over(job: Job, path: Term, speed: Term) -> ir.Block:
    """Move over to the path of a lane, at a target speed."""
    span = job.call.span
    place = _Place.of(job, path)
    shift = _Shift.begun(job, place)
    over = shift.progress >= 1.0
    at_end = path_length(path) <= place.ahead(job)
    settled = place.settled()
    moving = ir.Loop(span, job.ev.algebra.truth(True), (*shift.advance(job), _steer(job, place, shift, speed)))
    follow = ir.Follow(span, path, speed, job.max_lateral(), job.ev.run.new_local(), aside=job.aside())
    stop = over | (at_end | settled)
    return (*shift.beginning, job.until((moving,), stop), job.until((follow,), settled))


@frozen
class _Place:
    """Position of the rear axle relative to the path of the new lane."""

    path: Term
    s: Term
    offset: Term
    """Offset to the left of the path, or of the line beside it that the call asks for [m]."""
    direction: Term
    """Heading of the actor against that of the path [rad]."""

    @staticmethod
    def of(job: Job, path: Term) -> "_Place":
        pose, back = current_pose(job.ev, job.actor), size_of(job.actor, "rearToCenter")
        x = pose.x - back * cos(pose.heading)
        y = pose.y - back * sin(pose.heading)
        s = path_project(path, x, y)
        foot_x, foot_y, heading = path_pose(path, s)
        left = (y - foot_y) * cos(heading)
        right = (x - foot_x) * sin(heading)
        turned = wrapped(pose.heading - heading)
        aside = job.aside()
        offset = left - right if aside is None else left - right - aside
        return _Place(path, s, offset, turned)

    def ahead(self, job: Job) -> Term:
        """Arc length at the middle of the outline."""
        return self.s + size_of(job.actor, "rearToCenter")

    def settled(self) -> Term:
        return (abs(self.offset) < SETTLED_OFFSET) & (abs(self.direction) < SETTLED_ANGLE)


@frozen
class _Shift:
    """How far the change has come: locals, and the acts that set them."""

    offset: Term
    """Offset at the beginning [m]."""
    progress: Term
    """Share of the change that is done: u, from 0 to 1."""
    way: Term
    """Length of the whole change at the present speed [m]."""
    clock: Term
    """Time of the latest progress [s]."""
    locals: tuple[int, int]
    beginning: ir.Block

    @staticmethod
    def begun(job: Job, place: _Place) -> "_Shift":
        algebra, span = job.ev.algebra, job.call.span
        keep, offset = job.kept(place.offset)
        numbers = (job.ev.run.new_local(), job.ev.run.new_local())
        progress, clock = (algebra.local(number) for number in numbers)
        # A metre keeps the quotient finite for an actor that is in the lane already.
        least = maximum(LEAST_WAY * abs(offset), 1.0)
        way = maximum(least, job.speed() * job.number("duration", DURATION))
        beginning = (
            keep,
            ir.SetLocal(span, numbers[0], algebra.literal(0.0)),
            ir.SetLocal(span, numbers[1], algebra.time()),
        )
        return _Shift(offset, progress, way, clock, numbers, beginning)

    def advance(self, job: Job) -> ir.Block:
        """Return the acts that advance the progress by the step since the latest call."""
        now = job.ev.algebra.time()
        driven = job.speed() * (now - self.clock)
        further = self.progress + driven / self.way
        return (
            ir.SetLocal(job.call.span, self.locals[0], further),
            ir.SetLocal(job.call.span, self.locals[1], now),
        )

    def curve(self, u: Term) -> tuple[Term, Term, Term]:
        """Offset [m], slope and curvature [1/m] of the curve at `u`: e, e' and e'' of

        e(u) = e0 (1 - u^3 (10 - 15 u + 6 u^2)), e'(u) = -30 e0 u^2 (1 - u)^2, e''(u) = -60 e0 u (1 - u) (1 - 2 u).
        """
        u = minimum(1.0, u)
        rest, square = 1.0 - u, u * u
        quintic = 10.0 + u * (6.0 * u - 15.0)
        offset = self.offset * (1.0 - square * u * quintic)
        slope = -30.0 * (square * (rest * rest))
        bend = -60.0 * (u * rest * (rest - u))
        per_metre = self.offset / self.way
        return offset, slope * per_metre, bend * (per_metre / self.way)


def _steer(job: Job, place: _Place, shift: _Shift, speed: Term) -> ir.Act:
    """One step along the curve, at a target speed."""
    look_ahead = maximum(MIN_LOOK_AHEAD, LOOK_AHEAD * job.speed())
    offset, slope, _ = shift.curve(shift.progress)
    # The wheel keeps up with a smooth curve, so that looking ahead overshoots; without an offset, runs keep their bits.
    preview = (PREVIEW if job.aside() is None else 0.0) * job.speed() / shift.way
    _, _, bend = shift.curve(shift.progress + preview)
    turn = sin(atan(slope) - place.direction)
    most = OFFSET_SHARE * look_ahead
    off = minimum(most, maximum(-most, place.offset - offset))
    back = off / (look_ahead * look_ahead)
    heading = 2.0 * turn / look_ahead
    curvature = bend + heading - back
    angle = atan(size_of(job.actor, "wheelbase") * curvature)
    wanted = SPEED_GAIN * (speed - job.speed())
    braking = maximum(wanted, -BRAKING_LIMIT)
    return ir.Take(job.call.span, ((Command.STEER, angle), *job.pedals(braking)))


# -- looking at nothing ------------------------------------------------------------------------------------------------


def constant_speed(job: Job) -> ir.Block:
    return (ir.HoldSpeed(job.call.span, job.number("speed")),)


def constant_throttle(job: Job) -> ir.Block:
    forward = (Command.REVERSE, job.ev.algebra.truth(False))
    return (job.forever(ir.Take(job.call.span, ((Command.THROTTLE, job.number("x")), forward))),)


def brake(job: Job) -> ir.Block:
    return (job.forever(job.braking(job.number("pedal", 1.0))),)


def idle(job: Job) -> ir.Block:
    """Return the acts of an actor that presses no pedal; pedals that keep their position are released in each step."""
    if not job.ev.file.settings.given.pedals_stay:
        return (job.forever(ir.Wait(job.call.span)),)
    loose = tuple((pedal, job.ev.algebra.literal(0.0)) for pedal in (Command.THROTTLE, Command.BRAKE))
    return (job.forever(ir.Take(job.call.span, loose)),)
