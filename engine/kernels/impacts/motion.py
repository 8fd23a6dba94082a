"""Motion of bodies in a step with impacts between other actors, and after it.

Bodies are numbered: the actors, then the buildings of the road, which are walls. `Run.segments` stores the motion of
each body through the rest of the step as a straight segment. The first contact of the ego ends the run
(`kernels.rollout`); contacts of other actors are resolved in the order of time. At the instant of a contact, all
bodies that touch receive their velocities from `impacts.solver.resolve`. A body whose velocity changed is released from
its driver: it moves to where `coast` or `roll` places it at the end of the step, and the next contact is searched for
on these segments. The record stores the start and the end of such a step; metrics and contacts of the ego interpolate
linearly in between, as in every step.

A contact is a distance of at most `TOUCH` between two bodies that approach each other. Two bodies that touch and move
apart or rest against each other are examined again `LOOKS` times a step. Two bodies that overlapped when they entered
the scene have no separating side: for them the distance of the centres must not decrease.

Released bodies: an axle without a driver rolls. It resists sideways by Coulomb friction of at most mu times its static
load, and along its heading by rolling resistance. Two-wheelers fall over; they and bodies without wheels slide, and
their two supports resist in every direction. In a substep, friction applies at most the impulse that stops its point,
so it reverses no motion and never adds energy.
"""

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from engine.kernels.approach import TOUCH, circles_apart, probe, relative_motion
from engine.kernels.bicycle import GRAVITY, clip, small_turn, travelled
from engine.kernels.dynamics import WHEEL_RADIUS
from engine.kernels.geometry import Box, building, frame, half_diagonal, nearest_points, shortest_turn
from engine.kernels.impacts.solver import (
    BODY,
    CONTACT,
    FLAT,
    Body,
    Contact,
    add_contact,
    closing,
    contact_geometry,
    is_fixed,
    overlap_contact,
    resolve,
)
from engine.kernels.jit import deferred, inlined, kernel
from engine.kernels.pair import Rate, swung
from engine.kernels.run_state import (
    HOSTED,
    POST_IMPACT,
    Memory,
    Plan,
    Run,
    Status,
    column_of,
    on_one_level,
    outline_of,
)
from engine.tables import SLIDING, Floats
from engine.vocabulary import ActorKind, Column, State


class ImpactRecord(IntEnum):
    """Columns of `Run.impacts`: an impact between two actors other than the ego, the lower actor first."""

    TIME = 0
    """[s]"""
    ONE = 1
    OTHER = 2
    X = 3
    """Middle of the contact [m]."""
    Y = 4
    VX_ONE = 5
    """Velocity of each actor before the impact, and its change during the contact by all impulses [m/s]."""
    VY_ONE = 6
    VX_OTHER = 7
    VY_OTHER = 8
    CHANGE_X_ONE = 9
    CHANGE_Y_ONE = 10
    CHANGE_X_OTHER = 11
    CHANGE_Y_OTHER = 12
    HEADING_ONE = 13
    """[rad]"""
    HEADING_OTHER = 14
    X_ONE = 15
    """Centre of each actor [m]."""
    Y_ONE = 16
    X_OTHER = 17
    Y_OTHER = 18
    LAST = 19
    """Time of the last contact [s]; a later contact within `PAUSE` belongs to the same impact."""


MAX_IMPACTS = 64
"""Maximum number of impacts in the record of a run; later impacts are simulated but not stored."""
PULSE = 0.25
"""Time after the first contact during which impulses count as one impact [s]. Crash pulses of cars are shorter; in a
longer push, the friction of the tyres opposes the impulse.
"""
PAUSE = 0.05
"""Longest separation of two bodies within one impact [s]."""
SUBSTEP = 0.005
"""Time step of sliding [s]."""
STILL = 0.01
"""Speed [m/s] and spin [rad/s] below which a body stands."""
GRIPS = 0.05
"""Lateral speed of an axle at which its tyres grip again [m/s]."""


class Support(NamedTuple):
    """A support of a body on the road."""

    offset: float
    """Position ahead of the centre [m]; negative at the rear."""
    grip: float
    """Limit of the friction: mu g times the share of the weight on the support [m/s^2]."""
    steer: float
    """Angle of its wheels [rad]."""


class GroundContact(NamedTuple):
    """Supports of a body on the road: two axles, or two points that slide; forces per unit of mass."""

    rolls: bool
    """True: the supports are axles; False: they slide in every direction."""
    rear: Support
    front: Support
    rolling: float
    """Deceleration of rolling [m/s^2]."""
    gyration: float
    """Yaw inertia over mass [m^2]."""


class Dimensions(NamedTuple):
    """Length, width, wheelbase, and distance from rear axle to centre of a body [m]."""

    length: float
    width: float
    wheelbase: float
    rear_to_center: float


class RigidMotion(NamedTuple):
    """Pose and velocity of a body in the plane: centre [m] and its velocity [m/s], heading [rad] and spin [rad/s]."""

    x: float
    y: float
    heading: float
    vx: float
    vy: float
    spin: float


@kernel
def coast(body: RigidMotion, ground: GroundContact, duration: float) -> RigidMotion:
    """Return the motion of a sliding body after a time [s]."""
    count = max(1, math.ceil(duration / SUBSTEP - 1e-9))
    step = duration / count
    for _ in range(count):
        after = _apply_friction(body, ground, step)
        body = RigidMotion(
            body.x + 0.5 * step * (body.vx + after.vx),
            body.y + 0.5 * step * (body.vy + after.vy),
            body.heading + 0.5 * step * (body.spin + after.spin),
            after.vx,
            after.vy,
            after.spin,
        )
        if body.vx == 0.0 and body.vy == 0.0 and body.spin == 0.0:
            break
    return body


@kernel
def after_friction(body: RigidMotion, ground: GroundContact, step: float) -> RigidMotion:
    """Return the velocities after the friction of a step, for a host that moves bodies itself."""
    return _apply_friction(body, ground, step)


@inlined
def _apply_friction(body: RigidMotion, ground: GroundContact, step: float) -> RigidMotion:
    """Return the velocities after the friction of both supports; 0 below `STILL`."""
    cos, sin = math.cos(body.heading), math.sin(body.heading)
    if ground.rolls:
        body = _apply_axle_friction(body, ground, ground.rear, cos, sin, step)
        body = _apply_axle_friction(body, ground, ground.front, cos, sin, step)
    else:
        body = _apply_sliding_friction(body, ground, ground.rear, cos, sin, step)
        body = _apply_sliding_friction(body, ground, ground.front, cos, sin, step)
    if body.vx * body.vx + body.vy * body.vy < STILL * STILL and abs(body.spin) < STILL:
        return RigidMotion(body.x, body.y, body.heading, 0.0, 0.0, 0.0)
    return body


@inlined
def _apply_axle_friction(
    body: RigidMotion, ground: GroundContact, axle: Support, cos: float, sin: float, step: float
) -> RigidMotion:
    """Apply the lateral friction of an axle, and its rolling resistance along the wheels."""
    turned_cos, turned_sin = math.cos(axle.steer), math.sin(axle.steer)
    x, y = cos * turned_cos - sin * turned_sin, sin * turned_cos + cos * turned_sin
    arm_x, arm_y = axle.offset * cos, axle.offset * sin
    body = _apply_limited_impulse(body, ground, arm_x, arm_y, -y, x, axle.grip * step)
    return _apply_limited_impulse(body, ground, arm_x, arm_y, x, y, 0.5 * ground.rolling * step)


@inlined
def _apply_sliding_friction(
    body: RigidMotion, ground: GroundContact, support: Support, cos: float, sin: float, step: float
) -> RigidMotion:
    """Apply the friction of a support that slides, against its motion."""
    x, y = body.vx - body.spin * support.offset * sin, body.vy + body.spin * support.offset * cos
    slide = math.hypot(x, y)
    if slide == 0.0:
        return body
    arm_x, arm_y = support.offset * cos, support.offset * sin
    return _apply_limited_impulse(body, ground, arm_x, arm_y, x / slide, y / slide, support.grip * step)


@inlined
def _apply_limited_impulse(
    body: RigidMotion, ground: GroundContact, arm_x: float, arm_y: float, x: float, y: float, limit: float
) -> RigidMotion:
    """Apply the impulse per mass that stops the motion of a point along a unit vector, bounded by the limit."""
    speed = (body.vx - body.spin * arm_y) * x + (body.vy + body.spin * arm_x) * y
    lever = arm_x * y - arm_y * x
    impulse = clip(speed / (1.0 + lever * lever / ground.gyration), -limit, limit)
    return RigidMotion(
        body.x,
        body.y,
        body.heading,
        body.vx - impulse * x,
        body.vy - impulse * y,
        body.spin - impulse * lever / ground.gyration,
    )


# -- grip --------------------------------------------------------------------------------------------------------------


@kernel
def wheels_grip(body: RigidMotion, ground: GroundContact) -> bool:
    """Return True if both axles move along their wheels and their grip holds the curvature at this speed."""
    if not ground.rolls:
        return False
    cos, sin = math.cos(body.heading), math.sin(body.heading)
    ahead, aside = body.vx * cos + body.vy * sin, body.vy * cos - body.vx * sin
    rear, steer = aside + body.spin * ground.rear.offset, ground.front.steer
    front = (aside + body.spin * ground.front.offset) * math.cos(steer) - ahead * math.sin(steer)
    bend = ahead * ahead * abs(_curvature(ground))
    return abs(rear) <= GRIPS and abs(front) <= GRIPS and bend <= ground.rear.grip + ground.front.grip


@inlined
def _curvature(ground: GroundContact) -> float:
    return math.tan(ground.front.steer) / (ground.front.offset - ground.rear.offset)


@kernel
def roll(body: RigidMotion, ground: GroundContact, duration: float) -> RigidMotion:
    """Return the motion of a rolling body after a time [s], along the arc of its wheels (`bicycle.drive`)."""
    cos, sin = math.cos(body.heading), math.sin(body.heading)
    speed = body.vx * cos + body.vy * sin
    way, slower = travelled(abs(speed), -ground.rolling, duration)
    way, slower = math.copysign(way, speed), math.copysign(slower, speed)
    curvature = _curvature(ground)
    sinc, half_sin, half_cos = small_turn(0.5 * way * curvature)
    heading = body.heading + way * curvature
    x, y = body.x + ground.rear.offset * cos, body.y + ground.rear.offset * sin
    x += way * sinc * (cos * half_cos - sin * half_sin)
    y += way * sinc * (sin * half_cos + cos * half_sin)
    cos, sin = math.cos(heading), math.sin(heading)
    spin = slower * curvature
    swing = -ground.rear.offset * spin
    return RigidMotion(
        x - ground.rear.offset * cos,
        y - ground.rear.offset * sin,
        heading,
        slower * cos - swing * sin,
        slower * sin + swing * cos,
        spin,
    )


@inlined
def has_axles(kind: int) -> bool:
    """Return True for kinds that roll on their wheels without a driver; two-wheelers fall over."""
    return kind == ActorKind.CAR or kind == ActorKind.TRUCK or kind == ActorKind.BUS


@inlined
def ground_contact(
    rolls: bool, body: Dimensions, friction: float, steer: float, rolling: float, gyration: float
) -> GroundContact:
    """Return the axles with their static loads; supports of bodies without wheels are length / 4 from the centre."""
    grip = friction * GRAVITY
    inertia = gyration * (body.length * body.length + body.width * body.width)
    if not (0.0 < body.rear_to_center < body.wheelbase):
        at, half = 0.25 * body.length, 0.5 * grip
        return GroundContact(False, Support(-at, half, 0.0), Support(at, half, 0.0), 0.0, inertia)
    ahead = body.wheelbase - body.rear_to_center
    rear = Support(-body.rear_to_center, grip * ahead / body.wheelbase, 0.0)
    front = Support(ahead, grip * body.rear_to_center / body.wheelbase, steer)
    return GroundContact(rolls, rear, front, rolling * GRAVITY, inertia)


class MotionSegment(IntEnum):
    """Columns of `Run.segments`: the linear motion of a body through the rest of a step."""

    BEGIN = 0
    """Fraction of the step at which the segment begins; it ends at 1."""
    X0 = 1
    """Centre [m] and heading [rad] at the beginning (0) and at the end (1) of the segment."""
    Y0 = 2
    HEADING0 = 3
    X1 = 4
    Y1 = 5
    HEADING1 = 6
    VX0 = 7
    """Velocity of the centre [m/s] and spin [rad/s] at the beginning and at the end."""
    VY0 = 8
    SPIN0 = 9
    VX1 = 10
    VY1 = 11
    SPIN1 = 12
    ROLLING = 13
    """1 once the wheels of a released body grip again: it rolls along them."""
    STRUCK = 14
    """1 for a body whose velocity an impact has changed in this step."""
    NEAR_WALL = 15
    """1 if the segment may lead into a building."""


TO_END = MotionSegment.X1 - MotionSegment.X0
"""Columns from a value at the beginning of a segment to the same value at its end."""


@inlined
def bodies_of(plan: Plan) -> int:
    """Return the number of bodies: actors and buildings."""
    return len(plan.kinds) + len(plan.road.buildings)


@inlined
def write_segment(plan: Plan, run: Run, sample: int, actor: int) -> None:
    """Write the segment of a driven body: its step, with the velocity of its centre at both ends."""
    segment = run.segments[actor]
    segment[MotionSegment.BEGIN] = segment[MotionSegment.STRUCK] = segment[MotionSegment.ROLLING] = 0.0
    states, step = run.states, plan.layout.time_step
    turn = shortest_turn(states[sample, actor, State.HEADING], states[sample + 1, actor, State.HEADING]) / step
    if plan.kinds[actor] == ActorKind.PEDESTRIAN:
        turn = 0.0  # a pedestrian turns at once, which is no spin
    swing = turn * column_of(plan, run, actor, Column.REAR_TO_CENTER)
    before, after = states[sample, actor], states[sample + 1, actor]
    segment[MotionSegment.X0], segment[MotionSegment.Y0] = before[State.X], before[State.Y]
    segment[MotionSegment.X1], segment[MotionSegment.Y1] = after[State.X], after[State.Y]
    segment[MotionSegment.HEADING0], segment[MotionSegment.HEADING1] = before[State.HEADING], after[State.HEADING]
    start, end = (
        swung(before[State.HEADING], before[State.SPEED], swing),
        swung(after[State.HEADING], after[State.SPEED], swing),
    )
    segment[MotionSegment.VX0], segment[MotionSegment.VY0] = start.x, start.y
    segment[MotionSegment.VX1], segment[MotionSegment.VY1] = end.x, end.y
    segment[MotionSegment.SPIN0] = segment[MotionSegment.SPIN1] = turn


@inlined
def velocity_of(run: Run, sample: int, actor: int) -> Rate:
    """Return the velocity of the rear axle [m/s]; for a body that slides, of its centre at the end of its segment."""
    row = run.states[sample, actor]
    if row[State.PRESENT] == SLIDING:
        return Rate(run.segments[actor, MotionSegment.VX1], run.segments[actor, MotionSegment.VY1])
    return Rate(row[State.SPEED] * math.cos(row[State.HEADING]), row[State.SPEED] * math.sin(row[State.HEADING]))


@inlined
def spin_of(plan: Plan, run: Run, sample: int, actor: int) -> float:
    """Return the yaw rate [rad/s, anticlockwise]; 0 for pedestrians, who turn at once."""
    if run.states[sample, actor, State.PRESENT] == SLIDING:
        return run.segments[actor, MotionSegment.SPIN1]
    before = max(sample - 1, 0)
    if plan.kinds[actor] == ActorKind.PEDESTRIAN or run.states[before, actor, State.PRESENT] == 0.0:
        return 0.0
    turn = shortest_turn(run.states[before, actor, State.HEADING], run.states[sample, actor, State.HEADING])
    return turn / plan.layout.time_step


@inlined
def segment_fraction(run: Run, actor: int, part: float) -> float:
    """Return the fraction of the segment of an actor that is complete at a part of the step."""
    begin = run.segments[actor, MotionSegment.BEGIN]
    return (part - begin) / (1.0 - begin) if begin < 1.0 else 1.0


@inlined
def segment_value(run: Run, actor: int, column: int, along: float) -> float:
    """Return a value interpolated between its columns at the beginning (X0 to SPIN0) and the end of the segment."""
    start = run.segments[actor, column]
    return start + along * (run.segments[actor, column + TO_END] - start)


@inlined
def outline_on_segment(plan: Plan, run: Run, actor: int, part: float) -> Box:
    """Return the outline of a body at a part of the step."""
    if actor >= len(plan.kinds):
        return building(plan.road.buildings, actor - len(plan.kinds))
    along = segment_fraction(run, actor, part)
    return Box(
        segment_value(run, actor, MotionSegment.X0, along),
        segment_value(run, actor, MotionSegment.Y0, along),
        segment_value(run, actor, MotionSegment.HEADING0, along),
        column_of(plan, run, actor, Column.LENGTH),
        column_of(plan, run, actor, Column.WIDTH),
    )


@inlined
def write_body_state(plan: Plan, run: Run, actor: int, part: float, bodies: Floats) -> None:
    """Write the row of `Body` of a body at a part of the step."""
    bodies[actor] = 0.0
    if actor >= len(plan.kinds):
        wall = building(plan.road.buildings, actor - len(plan.kinds))
        bodies[actor, Body.X], bodies[actor, Body.Y] = wall.x, wall.y
        return
    along = segment_fraction(run, actor, part)
    bodies[actor, Body.X] = segment_value(run, actor, MotionSegment.X0, along)
    bodies[actor, Body.Y] = segment_value(run, actor, MotionSegment.Y0, along)
    bodies[actor, Body.VX] = segment_value(run, actor, MotionSegment.VX0, along)
    bodies[actor, Body.VY] = segment_value(run, actor, MotionSegment.VY0, along)
    bodies[actor, Body.SPIN] = segment_value(run, actor, MotionSegment.SPIN0, along)
    mass = column_of(plan, run, actor, Column.MASS)
    if not is_fixed(column_of(plan, run, actor, Column.FIXED), mass):
        length, width = column_of(plan, run, actor, Column.LENGTH), column_of(plan, run, actor, Column.WIDTH)
        bodies[actor, Body.INVERSE_MASS] = 1.0 / mass
        bodies[actor, Body.INVERSE_INERTIA] = 1.0 / (plan.gyration[actor] * mass * (length * length + width * width))


@inlined
def is_impact_body(run: Run, sample: int, actor: int) -> bool:
    """Return True if impacts act on a body: it is present, and no host moves it."""
    if actor >= len(run.actors):
        return True
    return run.states[sample + 1, actor, State.PRESENT] != 0.0 and run.actors[actor, Memory.FREE] != HOSTED


@inlined
def _may_meet(plan: Plan, run: Run, sample: int, one: int, other: int) -> bool:
    """Return True if impacts act on a body, a building or an actor on the level of actor `one`."""
    return is_impact_body(run, sample, other) and (other >= len(plan.kinds) or on_one_level(run, one, other))


@inlined
def mark_reachable_walls(plan: Plan, run: Run, actor: int) -> None:
    """Store whether the segment of an actor may lead into a building; most segments need no further test."""
    begin = run.segments[actor, MotionSegment.BEGIN]
    before, after = outline_on_segment(plan, run, actor, begin), outline_on_segment(plan, run, actor, 1.0)
    run.segments[actor, MotionSegment.NEAR_WALL] = 0.0
    for wall in range(len(plan.road.buildings)):
        if not beside(building(plan.road.buildings, wall), before, after):
            run.segments[actor, MotionSegment.NEAR_WALL] = 1.0


@inlined
def reachable_bodies_end(plan: Plan, run: Run, actor: int) -> int:
    """Return the end (exclusive) of the range of bodies that an actor can reach on its segment."""
    return bodies_of(plan) if run.segments[actor, MotionSegment.NEAR_WALL] != 0.0 else len(plan.kinds)


@inlined
def cannot_reach(plan: Plan, run: Run, before: Box, after: Box, other: int, part: float, until: float) -> bool:
    """Return True if an actor that moves from `before` to `after` in a part of the step stays clear of a body.

    The test is cheap and conservative; it decides nearly all pairs.
    """
    if other >= len(plan.kinds):
        return beside(building(plan.road.buildings, other - len(plan.kinds)), before, after)
    start, end = outline_on_segment(plan, run, other, part), outline_on_segment(plan, run, other, until)
    return circles_apart(before, after, start, end)


@inlined
def beside(wall: Box, before: Box, after: Box) -> bool:
    """Return True if the circumscribed circle of a body stays beyond one side of a wall through its step.

    A circle about the wall, which is as long as a street, would contain most vehicles that drive along it.
    """
    cos, sin = 1.0, 0.0
    if wall.heading != 0.0:  # walls of a grid are parallel to its axes, and the test runs for every wall in every step
        cos, sin = math.cos(wall.heading), math.sin(wall.heading)
    x0, y0, x1, y1 = before.x - wall.x, before.y - wall.y, after.x - wall.x, after.y - wall.y
    ahead0, ahead1 = cos * x0 + sin * y0, cos * x1 + sin * y1
    aside0, aside1 = cos * y0 - sin * x0, cos * y1 - sin * x1
    radius = half_diagonal(before) + 2.0 * TOUCH
    length, width = 0.5 * wall.length + radius, 0.5 * wall.width + radius
    return (
        min(ahead0, ahead1) > length
        or max(ahead0, ahead1) < -length
        or min(aside0, aside1) > width
        or max(aside0, aside1) < -width
    )


@deferred()
def step_post_impact(plan: Plan, run: Run, sample: int, actor: int) -> None:
    """Write the next sample of a released body; return it to its driver if the setting says so."""
    segment = run.segments[actor]
    segment[MotionSegment.BEGIN] = segment[MotionSegment.STRUCK] = 0.0
    segment[MotionSegment.X0], segment[MotionSegment.Y0] = (
        run.states[sample, actor, State.X],
        run.states[sample, actor, State.Y],
    )
    segment[MotionSegment.HEADING0] = run.states[sample, actor, State.HEADING]
    segment[MotionSegment.VX0], segment[MotionSegment.VY0] = segment[MotionSegment.VX1], segment[MotionSegment.VY1]
    segment[MotionSegment.SPIN0] = segment[MotionSegment.SPIN1]
    integrate_segment(plan, run, actor, run.states[sample, actor, State.STEER], plan.layout.time_step)
    write_post_impact(plan, run, sample, actor)


@inlined
def integrate_segment(plan: Plan, run: Run, actor: int, steer: float, duration: float) -> None:
    """Integrate the motion of a released body from the beginning of its segment, and write the end."""
    segment = run.segments[actor]
    body = RigidMotion(
        segment[MotionSegment.X0],
        segment[MotionSegment.Y0],
        segment[MotionSegment.HEADING0],
        segment[MotionSegment.VX0],
        segment[MotionSegment.VY0],
        segment[MotionSegment.SPIN0],
    )
    if body.vx != 0.0 or body.vy != 0.0 or body.spin != 0.0:
        ground = ground_contact(
            has_axles(plan.kinds[actor]),
            Dimensions(
                column_of(plan, run, actor, Column.LENGTH),
                column_of(plan, run, actor, Column.WIDTH),
                column_of(plan, run, actor, Column.WHEELBASE),
                column_of(plan, run, actor, Column.REAR_TO_CENTER),
            ),
            column_of(plan, run, actor, Column.FRICTION),
            steer,
            plan.layout.rolling,
            plan.gyration[actor],
        )
        if segment[MotionSegment.ROLLING] != 0.0 or wheels_grip(body, ground):
            body = roll(body, ground, duration)
            segment[MotionSegment.ROLLING] = 1.0
        else:
            body = coast(body, ground, duration)
    segment[MotionSegment.X1], segment[MotionSegment.Y1], segment[MotionSegment.HEADING1] = body.x, body.y, body.heading
    segment[MotionSegment.VX1], segment[MotionSegment.VY1], segment[MotionSegment.SPIN1] = body.vx, body.vy, body.spin


@inlined
def write_post_impact(plan: Plan, run: Run, sample: int, actor: int) -> None:
    """Write the end of the segment of a released body as the next sample, marked `SLIDING`.

    A driver who continues to drive keeps the steering angle if the tyres still grip after the contact.
    """
    segment, row = run.segments[actor], run.states[sample + 1, actor]
    cos, sin = math.cos(segment[MotionSegment.HEADING1]), math.sin(segment[MotionSegment.HEADING1])
    speed = segment[MotionSegment.VX1] * cos + segment[MotionSegment.VY1] * sin
    row[State.X], row[State.Y], row[State.HEADING] = (
        segment[MotionSegment.X1],
        segment[MotionSegment.Y1],
        segment[MotionSegment.HEADING1],
    )
    continues = plan.layout.drivers_go_on != 0 and _is_drivable(plan, segment, actor, speed)
    if not (continues and run.actors[actor, Memory.FREE] == 0.0):
        row[State.STEER] = run.states[sample, actor, State.STEER]
    row[State.SPEED] = speed
    row[State.ACCELERATION] = (speed - run.states[sample, actor, State.SPEED]) / plan.layout.time_step
    row[State.THROTTLE] = row[State.BRAKE] = 0.0
    row[State.PRESENT] = SLIDING
    run.actors[actor, Memory.FREE] = POST_IMPACT
    if continues:
        to_center = column_of(plan, run, actor, Column.REAR_TO_CENTER)
        run.actors[actor, Memory.REAR_X], run.actors[actor, Memory.REAR_Y] = (
            segment[MotionSegment.X1] - to_center * cos,
            segment[MotionSegment.Y1] - to_center * sin,
        )
        run.actors[actor, Memory.COS], run.actors[actor, Memory.SIN] = cos, sin
        run.actors[actor, Memory.FREE] = 0.0
        row[State.SPEED] = speed if abs(speed) >= STILL else max(0.0, speed)
        _let_tyres_roll(
            run.actors[actor], segment, speed, segment[MotionSegment.VY1] * cos - segment[MotionSegment.VX1] * sin
        )


@inlined
def _let_tyres_roll(memory: Floats, segment: Floats, ahead: float, aside: float) -> None:
    """Set the slip state of a car to the motion of its body, with wheels that roll."""
    memory[Memory.DRIFT_SPEED], memory[Memory.DRIFT_ANGLE] = math.hypot(ahead, aside), math.atan2(aside, ahead)
    memory[Memory.YAW_RATE] = segment[MotionSegment.SPIN1]
    memory[Memory.FRONT_WHEEL] = memory[Memory.REAR_WHEEL] = ahead / WHEEL_RADIUS


@inlined
def _is_drivable(plan: Plan, segment: Floats, actor: int, speed: float) -> bool:
    """Return True if the driver can control the body again: its wheels roll forwards, or it stands."""
    if plan.slides[actor] != 0 and speed < -STILL:
        return False
    stands = segment[MotionSegment.VX1] == 0.0 and segment[MotionSegment.VY1] == 0.0
    return has_axles(plan.kinds[actor]) and (segment[MotionSegment.ROLLING] != 0.0 or stands)


MAX_INSTANTS = 64
"""Maximum number of contact instants that one step resolves; the next step resolves the rest."""
LOOKS = 10
"""Number of tests in a step of two bodies that touch already."""
MAX_LOOKS = 512
"""Maximum number of iterations of the search for a contact."""
NEVER = 2.0
UNKNOWN = -1.0


# -- a step in which others touch --------------------------------------------------------------------------------------


@deferred(allocates=True)
def resolve_other_impacts(plan: Plan, run: Run, sample: int, part: float, one: int, other: int) -> None:
    """Resolve the contacts of other actors in a step in the order of time; rewrite the next sample of struck actors."""
    actors, count = len(plan.kinds), bodies_of(plan)
    if other < actors:
        _store_first_contact(plan, run, sample + part, one, other)
    _mark_overlaps(plan, run, sample)
    for actor in range(1, actors):
        if run.states[sample + 1, actor, State.PRESENT] != 0.0 and run.actors[actor, Memory.FREE] == 0.0:
            write_segment(plan, run, sample, actor)
        mark_reachable_walls(plan, run, actor)
    bodies = np.zeros((count, BODY))
    contacts = np.zeros((count * (count - 1) // 2, CONTACT))
    due = np.full((actors, count), UNKNOWN)
    for _ in range(MAX_INSTANTS):
        if not part <= 1.0:
            break
        meeting = contacts[: _approaching_contacts(plan, run, sample, part, bodies, contacts)]
        if len(meeting) > 0:
            before = bodies.copy()
            resolve(bodies, meeting, plan.layout.restitution, plan.layout.contact_friction)
            _release_bodies(plan, run, sample, part, before, bodies, meeting)
        part = _next_contact(plan, run, sample, part, due, bodies, contacts)
    for actor in range(1, actors):
        if run.states[sample + 1, actor, State.PRESENT] != 0.0 and run.segments[actor, MotionSegment.STRUCK] != 0.0:
            write_post_impact(plan, run, sample, actor)


@inlined
def _approaching_contacts(plan: Plan, run: Run, sample: int, part: float, bodies: Floats, contacts: Floats) -> int:
    """Write all bodies at a part of the step and the contacts of those that touch and approach; return their number."""
    actors, count = len(plan.kinds), 0
    for body in range(1, len(bodies)):
        if is_impact_body(run, sample, body):
            write_body_state(plan, run, body, part, bodies)
    for one in range(1, actors):
        if not is_impact_body(run, sample, one):
            continue
        here = outline_on_segment(plan, run, one, part)
        for other in range(one + 1, reachable_bodies_end(plan, run, one)):
            if not _may_meet(plan, run, sample, one, other) or cannot_reach(plan, run, here, here, other, part, part):
                continue
            if _is_approaching(plan, run, Encounter(part, one, other), bodies, contacts, count):
                count += 1
    return count


class Encounter(NamedTuple):
    """Two bodies at a part of the step."""

    part: float
    one: int
    other: int


@inlined
def _is_approaching(plan: Plan, run: Run, encounter: Encounter, bodies: Floats, contacts: Floats, row: int) -> bool:
    """Return True if two bodies touch and approach; write their contact into a row in either case."""
    part, one, other = encounter
    first, second = frame(outline_on_segment(plan, run, one, part)), frame(outline_on_segment(plan, run, other, part))
    # Slightly more than the distance at which the search stops, which rounds the same positions differently.
    if nearest_points(first, second).distance > 1.5 * TOUCH:
        return False
    if bodies[one, Body.INVERSE_MASS] + bodies[other, Body.INVERSE_MASS] == 0.0:
        return False
    found = contact_geometry(first, second)
    add_contact(contacts, row, one, other, found)
    if closing(bodies, contacts, row) > STILL:
        return True
    if found.gap >= -FLAT or other >= len(plan.kinds):
        return False
    add_contact(contacts, row, one, other, overlap_contact(first, second))
    came_so = run.actors[one, Memory.INSIDE] != 0.0 and run.actors[other, Memory.INSIDE] != 0.0
    return came_so and closing(bodies, contacts, row) > STILL


@kernel
def _mark_overlaps(plan: Plan, run: Run, sample: int) -> None:
    """Store for all actors that entered the scene since the last contact of others whether they overlap another actor.

    Actors that overlap when they enter are in contact from the first step in which one of them moves.
    """
    for one in range(1, len(plan.kinds)):
        if run.actors[one, Memory.INSIDE] >= 0.0 or run.states[sample, one, State.PRESENT] == 0.0:
            continue
        run.actors[one, Memory.INSIDE] = 0.0
        for other in range(1, len(plan.kinds)):
            there_too = run.states[sample, other, State.PRESENT] != 0.0
            if other != one and there_too and on_one_level(run, one, other):
                here, there = outline_of(plan, run, sample, one), outline_of(plan, run, sample, other)
                if contact_geometry(frame(here), frame(there)).gap < -FLAT:
                    run.actors[one, Memory.INSIDE] = run.actors[other, Memory.INSIDE] = 1.0


@inlined
def _release_bodies(
    plan: Plan, run: Run, sample: int, part: float, before: Floats, bodies: Floats, contacts: Floats
) -> None:
    """Store the resolved contacts of an instant; release the bodies whose velocity changed, and integrate them."""
    time = (sample + part) * plan.layout.time_step
    for contact in range(len(contacts)):
        _store_impact(plan, run, time, part, before, contacts[contact])
        one, other = int(contacts[contact, Contact.ONE]), int(contacts[contact, Contact.OTHER])
        if other < len(plan.kinds):
            _store_first_contact(plan, run, sample + part, one, other)
    for number in range(run.status[Status.IMPACTS]):
        _add_changes(run.impacts[number], time, before, bodies)
    for actor in range(1, len(plan.kinds)):
        if (
            bodies[actor, Body.VX] != before[actor, Body.VX]
            or bodies[actor, Body.VY] != before[actor, Body.VY]
            or bodies[actor, Body.SPIN] != before[actor, Body.SPIN]
        ):
            along, segment = segment_fraction(run, actor, part), run.segments[actor]
            for column in (MotionSegment.X0, MotionSegment.Y0, MotionSegment.HEADING0):
                segment[column] = segment_value(run, actor, column, along)
            segment[MotionSegment.VX0], segment[MotionSegment.VY0] = bodies[actor, Body.VX], bodies[actor, Body.VY]
            segment[MotionSegment.SPIN0] = bodies[actor, Body.SPIN]
            segment[MotionSegment.BEGIN], segment[MotionSegment.STRUCK], segment[MotionSegment.ROLLING] = part, 1.0, 0.0
            steer = run.states[sample, actor, State.STEER]
            integrate_segment(plan, run, actor, steer, (1.0 - part) * plan.layout.time_step)
            mark_reachable_walls(plan, run, actor)


@inlined
def _store_first_contact(plan: Plan, run: Run, samples: float, one: int, other: int) -> None:
    """Store time and actors of the first contact of other actors; `samples` counts from the start."""
    if math.isnan(run.end[2]):
        run.end[2] = samples * plan.layout.time_step
        run.status[Status.OTHERS_ONE], run.status[Status.OTHERS_OTHER] = one, other


@inlined
def _store_impact(plan: Plan, run: Run, time: float, part: float, before: Floats, row: Floats) -> None:
    """Store the impact of two bodies, unless it continues a stored impact or the record is full."""
    one, other = int(row[Contact.ONE]), int(row[Contact.OTHER])
    for number in range(run.status[Status.IMPACTS]):
        impact = run.impacts[number]
        lasts = time - impact[ImpactRecord.TIME] <= PULSE or time - impact[ImpactRecord.LAST] <= PAUSE
        if impact[ImpactRecord.ONE] == one and impact[ImpactRecord.OTHER] == other and lasts:
            impact[ImpactRecord.LAST] = time
            return
    number = run.status[Status.IMPACTS]
    if number >= MAX_IMPACTS:
        return
    run.status[Status.IMPACTS] = number + 1
    impact = run.impacts[number]
    impact[:] = 0.0
    impact[ImpactRecord.TIME] = impact[ImpactRecord.LAST] = time
    impact[ImpactRecord.ONE], impact[ImpactRecord.OTHER] = one, other
    second = 0.5 if row[Contact.POINTS] > 1.0 else 0.0
    for axis in range(2):
        first = row[Contact.X1 + axis]
        impact[ImpactRecord.X + axis] = first + second * (row[Contact.X2 + axis] - first)
    for side in range(2):
        actor = other if side else one
        for axis in range(2):
            impact[ImpactRecord.VX_ONE + 2 * side + axis] = before[actor, Body.VX + axis]
            impact[ImpactRecord.X_ONE + 2 * side + axis] = before[actor, Body.X + axis]
        impact[ImpactRecord.HEADING_ONE + side] = outline_on_segment(plan, run, actor, part).heading


@inlined
def _add_changes(impact: Floats, time: float, before: Floats, after: Floats) -> None:
    """Add the changes of velocity of an instant to an impact that has not ended."""
    if time - impact[ImpactRecord.TIME] > PULSE:
        return
    for side in range(2):
        actor = int(impact[ImpactRecord.ONE + side])
        for axis in range(2):
            change = after[actor, Body.VX + axis] - before[actor, Body.VX + axis]
            impact[ImpactRecord.CHANGE_X_ONE + 2 * side + axis] += change


# -- the next contact --------------------------------------------------------------------------------------------------


@inlined
def _next_contact(
    plan: Plan, run: Run, sample: int, part: float, due: Floats, bodies: Floats, contacts: Floats
) -> float:
    """Return the part of the step at which two bodies next touch and approach, or `NEVER`. Overwrites a contact.

    `due` (actors, bodies) stores the part for each pair; it is computed again only for bodies struck at this instant.
    """
    first = NEVER
    for one in range(1, len(plan.kinds)):
        if not is_impact_body(run, sample, one):
            continue
        before, after = outline_on_segment(plan, run, one, part), outline_on_segment(plan, run, one, 1.0)
        for other in range(one + 1, reachable_bodies_end(plan, run, one)):
            if due[one, other] <= part or _is_struck_at(plan, run, one, part) or _is_struck_at(plan, run, other, part):
                due[one, other] = NEVER
                meets = _may_meet(plan, run, sample, one, other)
                if meets and not cannot_reach(plan, run, before, after, other, part, 1.0):
                    due[one, other] = _next_approach(plan, run, part, one, other, bodies, contacts)
            first = min(first, due[one, other])
    return first


@inlined
def _is_struck_at(plan: Plan, run: Run, body: int, part: float) -> bool:
    """Return True if the segment of a body begins with an impact at this part of the step."""
    return (
        body < len(plan.kinds)
        and run.segments[body, MotionSegment.STRUCK] != 0.0
        and run.segments[body, MotionSegment.BEGIN] == part
    )


@inlined
def _next_approach(plan: Plan, run: Run, part: float, one: int, other: int, bodies: Floats, contacts: Floats) -> float:
    """Return when two bodies next touch and approach: by conservative advancement while apart, else by sampling."""
    a0, a1 = outline_on_segment(plan, run, one, part), outline_on_segment(plan, run, one, 1.0)
    b0, b1 = outline_on_segment(plan, run, other, part), outline_on_segment(plan, run, other, 1.0)
    motion = relative_motion(a0, a1, b0, b1)
    fraction = 0.0
    for _ in range(MAX_LOOKS):
        nearest = probe(motion, fraction).nearest
        if nearest.distance < TOUCH:
            now = part + fraction * (1.0 - part)
            write_body_state(plan, run, one, now, bodies)
            write_body_state(plan, run, other, now, bodies)
            if _is_approaching(plan, run, Encounter(now, one, other), bodies, contacts, 0):
                return now
            if fraction >= 1.0:
                return NEVER
            fraction = min(1.0, fraction + 1.0 / LOOKS)
            continue
        rate = max(0.0, -(nearest.x * motion.x + nearest.y * motion.y)) + motion.swing
        if not nearest.distance <= rate * (1.0 - fraction):
            return NEVER
        fraction = min(1.0, fraction + nearest.distance / rate)
    return NEVER
