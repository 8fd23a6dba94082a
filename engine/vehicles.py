"""Models of all kinds of actors: one row of `MODELS` each, with its source. SI units, angles in radians.

Sources by the short names used below:

- CommonRoad: Althoff, Koschi, Manzinger (2017), "CommonRoad: Composable benchmarks for motion planning on roads", IV
  2017; parameters of vehicle 2 (BMW 320i). Its centre of gravity is taken as the centre of its outline.
- AASHTO: "A Policy on Geometric Design of Highways and Streets" (2011), tables 2-1 and 2-2: design vehicles P
  (passenger car), SU-30 (truck) and CITY-BUS. The steering limit is asin(wheelbase / centre-line turning radius).
- R13, R78: UN Regulations 13 (mean fully developed deceleration of trucks and buses, 5.0 m/s^2) and 78 (motorcycles).
- ISO 4210: stopping distance of a bicycle, 7 m from 25 km/h on a dry road, hence 3.4 m/s^2.
- Fruin (1971), "Pedestrian Planning and Design": the body ellipse, 24 x 18 inches, as a rectangle.
- 92/6/EEC: Council Directive on speed limiters, as amended by 2002/85/EC: trucks (N2, N3) 90 km/h, buses (M2, M3) 100
  km/h.
- SUMO: Lopez et al. (2018), "Microscopic Traffic Simulation using SUMO", ITSC 2018; table of vehicle type defaults:
  maximum speed of a motorcycle 200 km/h, of a bicycle 50 km/h.
- Wilson (2004), "Bicycling Science", 3rd ed., ch. 4 and 5: an upright rider on a utility bicycle, rolling resistance
  0.005 and drag area 0.5 m^2, slows at 0.13 m/s^2 at 5 m/s.

A value without such a source is marked *ours*: a round figure within the range usual for its kind.
"""

import math
from collections.abc import Mapping
from types import MappingProxyType

from engine.frozen import frozen
from engine.vocabulary import ActorKind

STEER_RATE = 0.7
"""Largest rate of any steering angle [rad/s]; CommonRoad's truck (vehicle 4: 0.71); in a car, with a limit of 0.4
there, fast hands.
"""
AIR_BRAKE_TIME = 0.8
"""Time from no pedal to full pedal with air brakes [s]; R13, annex 6: 75 % of the pressure after 0.6 s."""
VIEW_ANGLE = math.pi / 2
"""Opening angle of the sector in which actors are noticed, for every kind [rad]."""
VIEW_DISTANCE = 50.0
"""Radius of that sector [m]."""
DRY_FRICTION = 1.0
"""Friction coefficient of a tyre on a dry road."""


@frozen
class ActorModel:
    """Properties of one kind; those that `vocabulary.Column` names are defaults that a scene may override."""

    length: float
    """Length of the outline, along the heading [m]."""
    width: float
    wheelbase: float
    """Front to rear axle [m]; no meaning (1.0) for kinds without wheels."""
    rear_to_center: float
    """Distance of the outline's centre ahead of the rear axle [m]; 0 for kinds without wheels."""
    mass: float
    """[kg]; for a motorcycle or bicycle with its rider."""
    yaw_inertia: float
    """Yaw inertia about the vertical axis through the outline's centre [kg m^2]; for contact physics."""
    max_steer: float
    """Largest steering angle of the (middle of the) front axle, either way [rad]."""
    max_acceleration: float
    """Acceleration at full throttle, and limit of the speed controller [m/s^2]."""
    max_braking: float
    """Deceleration at full pedal [m/s^2]."""
    top_speed: float
    """[m/s]"""
    occluding: bool = False
    """True if the body hides actors behind it from a driver."""
    fixed_above: float = math.inf
    """Mass above which no impact moves the body [kg]."""
    friction: float = DRY_FRICTION
    view_angle: float = VIEW_ANGLE
    view_distance: float = VIEW_DISTANCE
    steer_rate: float = STEER_RATE
    pedal_time: float = 0.0
    """Time from no pedal to full pedal [s]; *ours* if it is 0: pedals act at once, as in the simulator of the paper."""
    drag: float = 0.0
    """Deceleration while rolling without pedals [m/s^2]; *ours* if it is 0: the speed stays constant without pedals."""

    @property
    def gyration(self) -> float:
        """Return the yaw inertia over mass times the squared diagonal of the outline."""
        return self.yaw_inertia / (self.mass * (self.length**2 + self.width**2))

    @property
    def fixed(self) -> bool:
        """Return True if no impact moves a body of this mass."""
        return self.mass > self.fixed_above


def rectangle_inertia(mass: float, length: float, width: float) -> float:
    """Return the yaw inertia of a uniform rectangle about its centre [kg m^2]."""
    return mass * (length**2 + width**2) / 12.0


CAR = ActorModel(
    length=4.508,
    width=1.610,
    wheelbase=2.579,
    rear_to_center=1.423,
    mass=1093.0,
    yaw_inertia=1792.0,
    max_steer=0.551,
    max_acceleration=3.0,
    max_braking=8.0,
    top_speed=50.8,
    occluding=True,
)
"""CommonRoad; steering AASHTO P (asin 3.35 / 6.40: CommonRoad's 61 degrees turn no real car); pedals *ours*."""

TRUCK = ActorModel(
    length=9.14,
    width=2.44,
    wheelbase=6.10,
    rear_to_center=2.74,
    mass=10_000.0,
    yaw_inertia=rectangle_inertia(10_000.0, 9.14, 2.44),
    max_steer=0.555,
    max_acceleration=1.2,
    max_braking=5.0,
    top_speed=25.0,
    pedal_time=AIR_BRAKE_TIME,
    occluding=True,
)
"""AASHTO SU-30 (rear overhang 1.83 m, turning radius 11.58 m); braking R13; top speed 92/6/EEC; rest *ours*."""

BUS = ActorModel(
    length=12.20,
    width=2.59,
    wheelbase=7.62,
    rear_to_center=3.66,
    mass=14_000.0,
    yaw_inertia=rectangle_inertia(14_000.0, 12.20, 2.59),
    max_steer=0.723,
    max_acceleration=1.2,
    max_braking=5.0,
    top_speed=27.78,
    pedal_time=AIR_BRAKE_TIME,
    occluding=True,
)
"""AASHTO CITY-BUS (rear overhang 2.44 m, turning radius 11.52 m); braking R13; top speed 92/6/EEC; rest *ours*."""

MOTORCYCLE = ActorModel(
    length=2.1,
    width=0.8,
    wheelbase=1.4,
    rear_to_center=0.7,
    mass=275.0,
    yaw_inertia=rectangle_inertia(275.0, 2.1, 0.8),
    max_steer=0.6,
    max_acceleration=4.0,
    max_braking=7.0,
    top_speed=55.56,
)
"""*Ours*; braking above the 5.1 m/s^2 that R78 requires, as a practised rider reaches it; top speed SUMO."""

BICYCLE = ActorModel(
    length=1.8,
    width=0.6,
    wheelbase=1.05,
    rear_to_center=0.525,
    mass=90.0,
    yaw_inertia=rectangle_inertia(90.0, 1.8, 0.6),
    max_steer=0.7,
    max_acceleration=1.0,
    max_braking=3.4,
    top_speed=13.89,
    drag=0.13,
)
"""Braking ISO 4210; top speed SUMO; drag Wilson; the rest *ours*."""

PEDESTRIAN = ActorModel(
    length=0.46,
    width=0.61,
    wheelbase=1.0,
    rear_to_center=0.0,
    mass=75.0,
    yaw_inertia=rectangle_inertia(75.0, 0.46, 0.61),
    max_steer=math.pi,
    max_acceleration=2.0,
    max_braking=3.0,
    top_speed=5.0,
)
"""Outline Fruin, faces along the short side; the rest *ours* (5 m/s is a hard run)."""

OBSTACLE = ActorModel(
    length=1.0,
    width=1.0,
    wheelbase=1.0,
    rear_to_center=0.0,
    mass=200.0,
    yaw_inertia=rectangle_inertia(200.0, 1.0, 1.0),
    max_steer=0.0,
    max_acceleration=0.0,
    max_braking=0.0,
    top_speed=0.0,
    occluding=True,
    fixed_above=1000.0,
)
"""*Ours*: an object that never moves by itself."""

MODELS: Mapping[ActorKind, ActorModel] = MappingProxyType(
    {
        ActorKind.CAR: CAR,
        ActorKind.TRUCK: TRUCK,
        ActorKind.BUS: BUS,
        ActorKind.MOTORCYCLE: MOTORCYCLE,
        ActorKind.BICYCLE: BICYCLE,
        ActorKind.PEDESTRIAN: PEDESTRIAN,
        ActorKind.OBSTACLE: OBSTACLE,
    }
)
