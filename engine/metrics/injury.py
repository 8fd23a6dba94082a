"""How likely somebody dies of an impact; only from coefficients that are known exactly, so for people on foot alone.

Rosen and Sander (2009), "Pedestrian fatality risk as a function of car impact speed", Accident Analysis and Prevention
41(3): 490 adults on foot, struck by the front of a passenger car in Germany from 1999 to 2007, give the risk of death
1 / (1 + exp(6.9 - 0.090 v)), v in km/h. By its abstract the risk at 50 km/h is more than twice that at 40 km/h and more
than five times that at 30 km/h, which holds of these coefficients.
"""

import math

from engine.kernels.conflict import Snapshot
from engine.vocabulary import ActorKind

KM_H = 3.6
"""Of a metre per second."""
INTERCEPT, SLOPE = 6.9, 0.090


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
