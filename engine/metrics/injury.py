"""How likely somebody dies of an impact, or is seriously injured; only from coefficients that are known exactly.

Rosen and Sander (2009), "Pedestrian fatality risk as a function of car impact speed", Accident Analysis and Prevention
41(3): 490 adults on foot, struck by the front of a passenger car in Germany from 1999 to 2007, give the risk of death
1 / (1 + exp(6.9 - 0.090 v)), v in km/h. By its abstract the risk at 50 km/h is more than twice that at 40 km/h and more
than five times that at 30 km/h, which holds of these coefficients.

Lubbe, Wu and Jeppsson (2022), "Safe speeds: fatality and injury risks of pedestrians, cyclists, motorcyclists, and car
drivers impacting the front of another passenger car as a function of closing speed and age", Traffic Safety Research 2,
000006: accidents in Germany from 1999 to 2020 give the risk of an injury of AIS 3 or more, or of death (MAIS3+F), 1 /
(1 + exp(-(a + b v + c age))), v the relative speed of the two in km/h; tables 2, 3 and 5, to three decimals, as others
have copied them. By its abstract the risk is 10 % at 29 km/h on foot, at 44 km/h on a bicycle and at 112 km/h in a car,
which holds of these coefficients, within their rounding, at the median ages of those in the data: 46, 39 and 39 years.
The coefficients of motorcyclists could not be checked, and of trucks, buses and who strikes an obstacle there are none.
"""

import math
from typing import NamedTuple

from engine.kernels.conflict import Snapshot
from engine.kernels.pair import side_of
from engine.vocabulary import ActorKind, Side

KM_H = 3.6
"""Of a metre per second."""
INTERCEPT, SLOPE = 6.9, 0.090


class Curve(NamedTuple):
    """Risk of serious injury, 1 / (1 + exp(-(constant + per_km_h v + per_year age)))."""

    constant: float
    per_km_h: float
    per_year: float
    age: float
    """The median of those in the data [years]."""


SERIOUS = {
    ActorKind.PEDESTRIAN: Curve(-6.190, 0.078, 0.038, 46.0),
    ActorKind.BICYCLE: Curve(-7.467, 0.079, 0.047, 39.0),
    ActorKind.CAR: Curve(-7.654, 0.041, 0.021, 39.0),
}
"""Of who meets the front of a car."""


def pedestrian_fatality(speed: float) -> float:
    """Risk of death of an adult on foot who is struck by the front of a car at a speed [m/s]."""
    return 1.0 / (1.0 + math.exp(INTERCEPT - SLOPE * KM_H * max(speed, 0.0)))


def striking_car(now: Snapshot, ego: ActorKind, other: ActorKind) -> int | None:
    """Which of the two, ego (0) or other (1), is a car whose front touches the one on foot; None: neither is."""
    if (ego, other) == (ActorKind.CAR, ActorKind.PEDESTRIAN):
        number, car, walker = 0, now.ego, now.other
    elif (ego, other) == (ActorKind.PEDESTRIAN, ActorKind.CAR):
        number, car, walker = 1, now.other, now.ego
    else:
        return None
    cos, sin = math.cos(car.heading), math.sin(car.heading)
    x, y = walker.x - car.x, walker.y - car.y
    ahead, aside = cos * x + sin * y, cos * y - sin * x
    reach = 0.5 * math.hypot(walker.length, walker.width)
    in_front = ahead > 0.0 and abs(aside) <= 0.5 * car.width + reach and ahead >= 0.5 * car.length - reach
    return number if in_front else None


def serious_injury(kind: ActorKind, speed: float) -> float | None:
    """Risk of an injury of AIS 3 or more, or of death, of who meets a car's front at a relative speed [m/s]."""
    if kind not in SERIOUS:
        return None
    curve = SERIOUS[kind]
    return 1.0 / (1.0 + math.exp(-(curve.constant + curve.per_km_h * KM_H * speed + curve.per_year * curve.age)))


def before_a_front(now: Snapshot, ego: ActorKind, other: ActorKind) -> tuple[ActorKind, ...]:
    """What those of the two are who touch the front of a car, which the other is."""
    struck = (other, now.ego, now.other, ego), (ego, now.other, now.ego, other)
    return tuple(
        kind for kind, car, body, striker in struck if striker is ActorKind.CAR and side_of(car, body) == Side.FRONT
    )
