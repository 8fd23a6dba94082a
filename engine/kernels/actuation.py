"""Steering rate and wheel torques of a car with slipping tyres, from its driver's demand.

Steering moves at its fastest rate to the demanded angle. Pedals act through an ideal anti-lock and traction control, as
in every new car (UN Regulation 13-H, annex 6): the torque is the largest that holds the slip of either axle at
`SLIP_TARGET`, given its load and slip angle; a wheel with more slip is brought back. Both are updated every 5 ms.
"""

import math
from typing import NamedTuple

from engine.kernels.bicycle import GRAVITY, Demand, Motion, Vehicle, clip
from engine.kernels.dynamics import (
    COMMAND_STEP,
    LEAST_FRICTION,
    SUBSTEP,
    WHEEL_INERTIA,
    WHEEL_LAG,
    WHEEL_RADIUS,
    Chassis,
    Drift,
    Held,
    hold,
    wheels_of,
)
from engine.kernels.jit import deferred, inlined
from engine.kernels.run_state import Memory
from engine.kernels.tyres import tyre_along
from engine.tables import Floats

SLIP_TARGET = 0.12
"""Slip just below that of the largest force on a dry road; multiplied by the friction on others."""
BMW = Chassis(1.1561957064, 1.4227170936, 1093.2952334674046, 1791.5995300122856, 0.61373004, 0.66, 0.0, 7.319, 1.0)
"""Vehicle 2 of CommonRoad, a BMW 320i."""


@inlined
def chassis_of(mass: float, wheelbase: float, rear: float, friction: float) -> Chassis:
    """Return a car like the BMW, with another mass [kg] and distance from rear axle to centre [m]: its yaw inertia is
    proportional to mass and to the product of the distances from the centre to both axles; the height of the centre is
    the same.
    """
    front = wheelbase - rear
    share = mass * front * rear / (BMW.mass * BMW.front * BMW.rear)
    return Chassis(
        front,
        rear,
        mass,
        BMW.yaw_inertia * share,
        BMW.height,
        BMW.brake_split,
        BMW.drive_split,
        BMW.power_speed,
        max(friction, LEAST_FRICTION),
    )


@deferred()
def slide(
    motion: Motion, demand: Demand, vehicle: Vehicle, mass: float, rear: float, memory: Floats, time: float
) -> Motion:
    """Return the motion of a car with slipping tyres after `time` [s].

    `memory` is the actor's row of `Run.actors`, `rear` the distance from rear axle to centre [m].
    """
    chassis = chassis_of(mass, vehicle.wheelbase, rear, vehicle.grip / GRAVITY)
    car = driven(_taken(motion, chassis, memory), demand, vehicle, chassis, time)
    memory[Memory.DRIFT_SPEED], memory[Memory.DRIFT_ANGLE] = car.speed, car.slip
    memory[Memory.YAW_RATE] = car.yaw_rate
    memory[Memory.FRONT_WHEEL], memory[Memory.REAR_WHEEL] = car.front_wheel, car.rear_wheel
    cos, sin = math.cos(car.heading), math.sin(car.heading)
    x, y = car.x - rear * cos, car.y - rear * sin
    return Motion(x, y, car.heading, cos, sin, car.speed * math.cos(car.slip), car.steer)


@inlined
def _taken(motion: Motion, chassis: Chassis, memory: Floats) -> Drift:
    """Return the car as the previous step left it; a freely rolling car at first, and after its speed was set."""
    speed, slip = memory[Memory.DRIFT_SPEED], memory[Memory.DRIFT_ANGLE]
    front, rear = memory[Memory.FRONT_WHEEL], memory[Memory.REAR_WHEEL]
    if motion.speed != speed * math.cos(slip):
        slip = clip(slip, -1.4, 1.4)
        speed = motion.speed / math.cos(slip)
        front = rear = motion.speed / WHEEL_RADIUS
    x, y = motion.x + chassis.rear * motion.cos, motion.y + chassis.rear * motion.sin
    return Drift(x, y, motion.heading, speed, slip, memory[Memory.YAW_RATE], motion.steer, front, rear)


@inlined
def driven(car: Drift, demand: Demand, vehicle: Vehicle, chassis: Chassis, time: float) -> Drift:
    """Return a car after `time` [s] with a constant demand of its driver."""
    commands = math.ceil(time / COMMAND_STEP - 1e-9)
    held = time / commands
    substeps = math.ceil(held / SUBSTEP - 1e-9)
    target = clip(demand.steer, -vehicle.max_steer, vehicle.max_steer)
    for _ in range(commands):
        rate = clip((target - car.steer) / held, -vehicle.steer_rate, vehicle.steer_rate)
        car = hold(car, Held(rate, eased(car, demand.acceleration, chassis)), chassis, held, substeps)
    return car


# -- anti-lock ---------------------------------------------------------------------------------------------------------


class Axle(NamedTuple):
    """An axle under brake or throttle."""

    share: float
    """Share of the car's torque."""
    load: float
    """Load at rest, over the car's mass [m/s^2]."""
    gain: float
    """Load gained per acceleration, over the car's mass."""
    force: float
    """Current load [N]."""
    slip: float
    angle: float
    """Slip angle [rad]."""
    hub: float
    """Speed of its hub [m/s]."""
    wheel: float
    """[rad/s]"""


@inlined
def eased(car: Drift, demand: float, chassis: Chassis) -> float:
    """Return the demanded acceleration, reduced until both axles transmit their shares at `SLIP_TARGET` [m/s^2]."""
    if demand == 0.0:
        return demand
    wheels = wheels_of(car, demand, chassis)
    split = chassis.brake_split if demand < 0.0 else chassis.drive_split
    wheelbase = chassis.front + chassis.rear
    front, rear = GRAVITY * chassis.rear / wheelbase, GRAVITY * chassis.front / wheelbase
    # Load moves to the front under brake, to the rear under throttle.
    moved = -math.copysign(chassis.height / wheelbase, demand)
    most = abs(demand)
    for axle in range(2):
        if axle == 0:
            slip, angle, hub = wheels.front_slip, wheels.front_angle, wheels.front_hub
            one = Axle(split, front, moved, wheels.front_load, slip, angle, hub, car.front_wheel)
        else:
            slip, angle, hub = wheels.rear_slip, wheels.rear_angle, wheels.rear_hub
            one = Axle(1.0 - split, rear, -moved, wheels.rear_load, slip, angle, hub, car.rear_wheel)
        if one.share > 0.0:
            most = min(most, _axle_limit(one, math.copysign(1.0, demand), chassis))
    return math.copysign(most, demand)


@inlined
def _axle_limit(axle: Axle, way: float, chassis: Chassis) -> float:
    """Return the largest acceleration [m/s^2] of which an axle transmits its share; `way`: 1 driving, -1 braking."""
    target = -way * SLIP_TARGET * min(chassis.friction, 1.0)
    held = abs(tyre_along(target, axle.angle, axle.force, chassis.friction)) / axle.force
    rest = axle.share - held * axle.gain
    limit = held * axle.load / rest if rest > 0.0 else math.inf
    if way * axle.slip < way * target:
        wanted = axle.hub * (1.0 - target) / WHEEL_RADIUS
        now = abs(tyre_along(axle.slip, axle.angle, axle.force, chassis.friction))
        back = WHEEL_INERTIA * abs(wanted - axle.wheel) / (WHEEL_LAG * WHEEL_RADIUS)
        limit = min(limit, max(0.0, now - back) / (chassis.mass * axle.share))
    return limit
