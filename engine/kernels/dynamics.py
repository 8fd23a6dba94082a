"""A car whose tyres slip: the single-track drift model (STD), with load transfer and saturating tyres.

Source: Althoff, Koschi, Manzinger, "CommonRoad: Composable benchmarks for motion planning on roads", IV 2017, with
Althoff and Würsching, "CommonRoad: Vehicle Models" (2020); tyres: `engine.kernels.tyres`. With v the speed of the
centre of gravity, beta its slip angle, r the yaw rate, omega the speed of a wheel, u the speed of its hub in its own
plane, a and b the distances from the centre to the axles:

    m v' = -F_yf sin(delta - beta) + F_yr sin(beta) + F_xr cos(beta) + F_xf cos(delta - beta)
    I r' = a (F_yf cos(delta) + F_xf sin(delta)) - b F_yr
    beta' = -r + (F_yf cos(delta - beta) + F_yr cos(beta) - F_xr sin(beta) + F_xf sin(delta - beta)) / (m v)
    I_w omega' = T - R F_x          slip s = 1 - R omega / u          F_z of an axle: static, and a_x h / L moved along

Below 0.2 m/s the model fades into the kinematic bicycle, by tanh over 0.05 m/s, as STD does. Beyond STD, which is
written for a car that goes forwards: where a spin turns the car by more than a right angle, tyres still oppose the
motion (those of STD then drive it on); and a car that stops stands.

Wheels are stiff (1 / 0.1 ms at walking pace), so a substep is one of ROS2 (Verwer, Spee, Blom, Hundsdorfer, "A
second-order Rosenbrock method applied to photochemical dispersion problems", SIAM J. Sci. Comput. 20, 1999): second
order whatever matrix it is given, and stable where that holds the stiff part. Here it holds each wheel's own slope.
"""

import math
from typing import NamedTuple

from engine.kernels.bicycle import GRAVITY, clip
from engine.kernels.jit import inlined, kernel
from engine.kernels.tyres import tyre_across, tyre_along

COMMAND_STEP = 0.005
"""Time for which a steering rate and an acceleration are held [s]."""
SUBSTEP = 0.00025
"""Time step of the integration [s]; with 1 ms the place of a stop is off by about 2 mm, and at times by 2 cm."""
CRAWLING_SPEED = 1.0
"""Speed below which a wheel's slip changes so fast that a substep could jump over the peak of its tyre's curve, after
which it would spin [m/s].
"""
CRAWLING_PARTS = 4
"""Number of parts of a substep below that speed."""
STAGE_WEIGHT = 1.0 - math.sqrt(0.5)
"""gamma of ROS2 for which it is L-stable."""
FADE_SPEED = 0.2
"""Speed at which the model is half kinematic [m/s]."""
FADE_WIDTH = 0.05
"""Width of the transition to the kinematic model [m/s]."""
LEAST_SPEED = 0.5 * FADE_SPEED
"""Below it, slips are shares of this speed [m/s]."""
WHEEL_LAG = 0.02
"""Time in which a wheel takes up the speed of the road in the kinematic part [s]."""
WHEEL_RADIUS = 0.344
"""[m]; CommonRoad, vehicles 1 to 3, as the next."""
WHEEL_INERTIA = 1.7
"""[kg m^2]"""
MOST_ACCELERATION = 11.5
"""Largest acceleration that a pedal may demand in either direction [m/s^2]; CommonRoad, vehicles 1 to 3."""
LEAST_FRICTION = 1e-6
"""Below it the tyre curves would be steps."""
LEAST_LOAD = 1.0
"""Load that an axle retains when it would lift [N]."""
NUDGE = 1e-6
"""Change of a wheel's speed over which its slope is taken, as a share of that speed."""


class Chassis(NamedTuple):
    """Properties of a car, except for its tyres, which are the same for all."""

    front: float
    """Distance a from the centre of gravity to the front axle [m]."""
    rear: float
    """Distance b from the centre of gravity to the rear axle [m]."""
    mass: float
    """[kg]"""
    yaw_inertia: float
    """[kg m^2]"""
    height: float
    """Height of the centre of the sprung mass, by which load moves [m]."""
    brake_split: float
    """Share of the brake torque on the front axle."""
    drive_split: float
    """Share of the engine's torque on the front axle."""
    power_speed: float
    """Above this speed the engine, not the tyre, limits the acceleration [m/s]."""
    friction: float
    """Factor on the peaks of the tyre curves."""


class Drift(NamedTuple):
    """State of a car with slipping tyres."""

    x: float
    """Centre of gravity [m]."""
    y: float
    heading: float
    """Heading, not wrapped [rad]."""
    speed: float
    """Speed of the centre of gravity, in the direction of its motion [m/s]."""
    slip: float
    """Angle from the heading to that direction, beta [rad]."""
    yaw_rate: float
    """[rad/s]"""
    steer: float
    """[rad]"""
    front_wheel: float
    """[rad/s]"""
    rear_wheel: float


class Held(NamedTuple):
    """Command: rate of the steering angle [rad/s] and acceleration, as torques over m R [m/s^2]."""

    steer_rate: float
    acceleration: float


# -- motion ------------------------------------------------------------------------------------------------------------


class Wheels(NamedTuple):
    """The two axles as one wheel each: slip, slip angle [rad] and load [N]; and the direction of motion, 1 or -1."""

    front_slip: float
    rear_slip: float
    front_angle: float
    rear_angle: float
    front_load: float
    rear_load: float
    front_hub: float
    """Speed of the hub in the wheel's plane, not negative [m/s]."""
    rear_hub: float
    way: float


@inlined
def wheels_of(car: Drift, acceleration: float, chassis: Chassis) -> Wheels:
    """Return the slips and loads of both axles; the commanded `acceleration` moves load from axle to axle."""
    ahead, aside = car.speed * math.cos(car.slip), car.speed * math.sin(car.slip)
    way = -1.0 if ahead < 0.0 else 1.0
    front_aside, length = aside + car.yaw_rate * chassis.front, max(abs(ahead), 1e-9)
    moves = car.speed > LEAST_SPEED
    front_angle = math.atan(front_aside / length) - way * car.steer if moves else 0.0
    rear_angle = math.atan((aside - car.yaw_rate * chassis.rear) / length) if moves else 0.0
    front_hub = max(0.0, way * (ahead * math.cos(car.steer) + front_aside * math.sin(car.steer)))
    rear_hub, wheelbase = max(0.0, way * ahead), chassis.front + chassis.rear
    moved, scale = acceleration * chassis.height, chassis.mass / wheelbase
    return Wheels(
        1.0 - WHEEL_RADIUS * car.front_wheel / max(front_hub, LEAST_SPEED),
        1.0 - WHEEL_RADIUS * car.rear_wheel / max(rear_hub, LEAST_SPEED),
        front_angle,
        rear_angle,
        max(scale * (GRAVITY * chassis.rear - moved), LEAST_LOAD),
        max(scale * (GRAVITY * chassis.front + moved), LEAST_LOAD),
        front_hub,
        rear_hub,
        way,
    )


@inlined
def _rates(car: Drift, held: Held, chassis: Chassis) -> Drift:
    """Return the time derivative of each number of a state."""
    acceleration = _engine_limit(held.acceleration, car.speed, chassis)
    wheels = wheels_of(car, acceleration, chassis)
    front_x = wheels.way * tyre_along(wheels.front_slip, wheels.front_angle, wheels.front_load, chassis.friction)
    rear_x = wheels.way * tyre_along(wheels.rear_slip, wheels.rear_angle, wheels.rear_load, chassis.friction)
    front_y = tyre_across(wheels.front_slip, wheels.front_angle, wheels.front_load, chassis.friction)
    rear_y = tyre_across(wheels.rear_slip, wheels.rear_angle, wheels.rear_load, chassis.friction)
    torque = chassis.mass * WHEEL_RADIUS * acceleration
    split = chassis.drive_split if acceleration > 0.0 else chassis.brake_split
    front_spin = _spin(split * torque, wheels.way * front_x, car.front_wheel)
    rear_spin = _spin((1.0 - split) * torque, wheels.way * rear_x, car.rear_wheel)
    cos, sin, turned = math.cos(car.slip), math.sin(car.slip), car.steer - car.slip
    cos_turned, sin_turned = math.cos(turned), math.sin(turned)
    along = (-front_y * sin_turned + rear_y * sin + rear_x * cos + front_x * cos_turned) / chassis.mass
    across = (front_y * cos_turned + rear_y * cos - rear_x * sin + front_x * sin_turned) / chassis.mass
    front_arm = front_y * math.cos(car.steer) + front_x * math.sin(car.steer)
    turning = (chassis.front * front_arm - chassis.rear * rear_y) / chassis.yaw_inertia
    slipping = across / car.speed - car.yaw_rate if car.speed > LEAST_SPEED else 0.0
    # The kinematic car, and how much of it there is.
    rolling = _kinematic(car, held.steer_rate, acceleration, chassis)
    part = 0.5 * (math.tanh((car.speed - FADE_SPEED) / FADE_WIDTH) + 1.0)
    rest = 1.0 - part
    return Drift(
        car.speed * math.cos(car.slip + car.heading),
        car.speed * math.sin(car.slip + car.heading),
        part * car.yaw_rate + rest * rolling.heading,
        part * along + rest * acceleration,
        part * slipping + rest * rolling.slip,
        part * turning + rest * rolling.yaw_rate,
        held.steer_rate,
        part * front_spin + rest * (wheels.front_hub / WHEEL_RADIUS - car.front_wheel) / WHEEL_LAG,
        part * rear_spin + rest * (wheels.rear_hub / WHEEL_RADIUS - car.rear_wheel) / WHEEL_LAG,
    )


@inlined
def _engine_limit(acceleration: float, speed: float, chassis: Chassis) -> float:
    """Return the acceleration that brakes or engine can produce (model KS of CommonRoad, section 5) [m/s^2]."""
    most = MOST_ACCELERATION
    if speed > chassis.power_speed:
        most *= chassis.power_speed / speed
    return clip(acceleration, -MOST_ACCELERATION, most)


@inlined
def _spin(torque: float, along: float, wheel: float) -> float:
    """Return the angular acceleration of a wheel [rad/s^2]; brakes stop it, and never turn it backwards."""
    spin = (torque - WHEEL_RADIUS * along) / WHEEL_INERTIA
    return 0.0 if wheel <= 0.0 and spin < 0.0 else spin


class Rolling(NamedTuple):
    """Rates of the kinematic car: of heading, yaw rate and slip angle."""

    heading: float
    yaw_rate: float
    slip: float


@inlined
def _kinematic(car: Drift, steer_rate: float, acceleration: float, chassis: Chassis) -> Rolling:
    """Return the rates by the equations of CommonRoad, unchanged, though the derivative of atan(share tan(steer)) has
    (share tan)^2; both are nearly equal where this model counts, at walking pace with slowly turning wheels.
    """
    wheelbase = chassis.front + chassis.rear
    tan, cos = math.tan(car.steer), math.cos(car.steer)
    share = chassis.rear / wheelbase
    slip = share * steer_rate / (cos * cos * (1.0 + (tan * tan * share) ** 2))
    turning = acceleration * math.cos(car.slip) * tan - car.speed * math.sin(car.slip) * slip * tan
    turning += car.speed * math.cos(car.slip) * steer_rate / (cos * cos)
    return Rolling(car.speed * math.cos(math.atan(tan * share)) * tan / wheelbase, turning / wheelbase, slip)


@inlined
def _moved(car: Drift, by: Drift, share: float) -> Drift:
    """Return a state plus a share of another."""
    return Drift(
        car.x + share * by.x,
        car.y + share * by.y,
        car.heading + share * by.heading,
        car.speed + share * by.speed,
        car.slip + share * by.slip,
        car.yaw_rate + share * by.yaw_rate,
        car.steer + share * by.steer,
        car.front_wheel + share * by.front_wheel,
        car.rear_wheel + share * by.rear_wheel,
    )


@inlined
def standing(car: Drift, turn: float, chassis: Chassis) -> Drift:
    """Return the car at rest in its place, its wheels turned [rad], its slip angle that of a kinematic car."""
    steer = car.steer + turn
    slip = math.atan(math.tan(steer) * chassis.rear / (chassis.front + chassis.rear))
    return Drift(car.x, car.y, car.heading, 0.0, slip, 0.0, steer, 0.0, 0.0)


@kernel
def hold(car: Drift, held: Held, chassis: Chassis, time: float, substeps: int) -> Drift:
    """Return a car after `time` [s] with one command; after a stop it stands, unless the command is to go."""
    if car.speed <= 0.0 and held.acceleration <= 0.0:
        return standing(car, held.steer_rate * time, chassis)
    if car.speed < CRAWLING_SPEED:
        substeps *= CRAWLING_PARTS
    step = time / substeps
    here = first = car
    front_gain = rear_gain = 1.0
    for evaluation in range(3 * substeps):
        # Three evaluations per substep, in one loop because the code is copied to its place of call: at the state, with
        # slightly faster wheels, and one step later.
        stage = evaluation % 3
        point = car
        if stage == 1:
            point = _nudged(car)
        elif stage == 2:
            point = _rolled(_moved(car, first, step))
        rates = _rates(point, held, chassis)
        if stage == 0:
            here = rates
        elif stage == 1:
            front_gain = _gain(here.front_wheel, rates.front_wheel, point.front_wheel - car.front_wheel, step)
            rear_gain = _gain(here.rear_wheel, rates.rear_wheel, point.rear_wheel - car.rear_wheel, step)
            first = _solved(car, here, front_gain, rear_gain, chassis)
        else:
            second = _solved(car, _moved(rates, first, -2.0), front_gain, rear_gain, chassis)
            car = _rolled(_moved(_moved(car, first, 1.5 * step), second, 0.5 * step))
            if car.speed <= 0.0 and held.acceleration <= 0.0:
                return standing(car, held.steer_rate * step * (substeps - 1 - evaluation // 3), chassis)
    return car


@inlined
def _nudged(car: Drift) -> Drift:
    return _with_wheels(
        car, car.front_wheel + NUDGE * (1.0 + car.front_wheel), car.rear_wheel + NUDGE * (1.0 + car.rear_wheel)
    )


@inlined
def _with_wheels(car: Drift, front: float, rear: float) -> Drift:
    return Drift(car.x, car.y, car.heading, car.speed, car.slip, car.yaw_rate, car.steer, front, rear)


@inlined
def _gain(here: float, nudged: float, by: float, step: float) -> float:
    """Return 1 / (1 - gamma h J) of a wheel with the slope J of its rate; 1 for a rate that grows."""
    return 1.0 / (1.0 - STAGE_WEIGHT * step * min((nudged - here) / by, 0.0))


@inlined
def _solved(car: Drift, right: Drift, front_gain: float, rear_gain: float, chassis: Chassis) -> Drift:
    """Return k of (1 - gamma h J) k = right, where J contains only the attraction of a wheel to its hub's speed."""
    cos, sin = math.cos(car.slip), math.sin(car.slip)
    ahead = right.speed * cos - car.speed * sin * right.slip
    aside = right.speed * sin + car.speed * cos * right.slip + chassis.front * right.yaw_rate
    front, rear = ahead * math.cos(car.steer) + aside * math.sin(car.steer), ahead
    return _with_wheels(
        right,
        front_gain * right.front_wheel + (1.0 - front_gain) * front / WHEEL_RADIUS,
        rear_gain * right.rear_wheel + (1.0 - rear_gain) * rear / WHEEL_RADIUS,
    )


@inlined
def _rolled(car: Drift) -> Drift:
    """Return the car with wheel speeds of at least 0."""
    return _with_wheels(car, max(0.0, car.front_wheel), max(0.0, car.rear_wheel))
