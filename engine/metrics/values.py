"""Values of the table's rows: measures over a run from the kernels' measures at an instant."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from engine.kernels.conflict import Snapshot, post_encroachment_time, relative_speed, time_to_collision
from engine.kernels.encroachment import OccupancyInterval, encroachment_gap
from engine.kernels.evasion import (
    braking_needed,
    swerving_needed,
    time_to_brake,
    time_to_kick_down,
    time_to_steer,
)
from engine.kernels.pair import side_of
from engine.kernels.safe_distance import Responsibility, is_dangerous, worst_time_to_collision
from engine.metrics.bodies import Body
from engine.metrics.encounters import Encounter
from engine.tables import Floats
from engine.vocabulary import ActorKind, Side

CRITICAL_TTC = 3.0
"""Threshold of TET and TIT [s]; a choice of cortexc, within the 1.5 to 4 s in use."""
RESPONSIBILITY = Responsibility(1.0, 3.5, 8.0, 4.0, 3.0, 0.2, 0.8, 0.1)
"""Defaults of CARLA for Intel's ad-rss-lib; the paper names the parameters and leaves their values to regulators."""


# -- values of a run from those of an instant --------------------------------------------------------------------------


def least(now: Floats) -> float:
    return float(now.min())


def largest(now: Floats) -> float:
    return float(now.max())


def least_ttc(pair: Encounter) -> float:
    return 0.0 if pair.touched else least(pair.ttc)


def ttc_at_md(pair: Encounter) -> float:
    return 0.0 if pair.touched else time_to_collision(pair.nearest)


def over_run(measure: Callable[[Snapshot], float], take: Callable[[Floats], float], pair: Encounter) -> float:
    return take(np.array([measure(now) for now in pair.samples]))


def time_exposed(pair: Encounter) -> float:
    return float(np.count_nonzero(pair.ttc <= CRITICAL_TTC)) * pair.step


def time_integrated(pair: Encounter) -> float:
    return float(np.maximum(CRITICAL_TTC - pair.ttc, 0.0).sum()) * pair.step


def least_wttc(pair: Encounter) -> float:
    agility = pair.ego.grip + pair.other.grip
    return 0.0 if pair.touched else min(worst_time_to_collision(now, agility) for now in pair.samples)


def time_in_danger(pair: Encounter) -> float:
    return sum(is_dangerous(now, RESPONSIBILITY) for now in pair.samples) * pair.step


# -- what it would still take ------------------------------------------------------------------------------------------


def braking_over_run(pair: Encounter) -> Floats:
    return pair.on_course(braking_needed, 0.0)


def swerving_over_run(pair: Encounter) -> Floats:
    return pair.on_course(swerving_needed, 0.0)


def share(needed: Floats, available: float) -> float:
    """Return the largest need as a share of the available amount; 0 or infinite if none is available."""
    most = largest(needed)
    return most / available if available > 0.0 else math.inf if most > 0.0 else 0.0


def left_to_brake(pair: Encounter) -> Floats:
    return pair.on_course(lambda now: time_to_brake(now, pair.ego.braking), math.inf)


def left_to_steer(pair: Encounter) -> Floats:
    return pair.on_course(lambda now: time_to_steer(now, pair.ego.grip), math.inf)


def left_to_kick_down(pair: Encounter) -> Floats:
    body = pair.ego
    return pair.on_course(lambda now: time_to_kick_down(now, body.acceleration, body.top_speed), math.inf)


def left_to_react(pair: Encounter) -> Floats:
    return np.maximum(np.maximum(left_to_brake(pair), left_to_steer(pair)), left_to_kick_down(pair))


# -- order of arrival --------------------------------------------------------------------------------------------------


def pet_by_shift(pair: Encounter) -> float:
    if pair.touched:
        return 0.0
    return post_encroachment_time(pair.states, pair.span[1], pair.step, pair.number, pair.outlines)


def pet_by_area(pair: Encounter) -> float:
    return 0.0 if pair.touched else encroachment_gap(*pair.stays) * pair.step


def time_in_area(stay: OccupancyInterval, step: float) -> float:
    return (stay.leave - stay.enter) * step if stay.enter < math.inf else math.nan


# -- what it would come to ---------------------------------------------------------------------------------------------


def change_of_velocity(now: Snapshot, own: Body, other: Body) -> float:
    """Return the delta-V of a body that strikes another centrally and stays in contact with it [m/s]."""
    return relative_speed(now) / (1.0 + own.mass / other.mass)


# -- probability of death or serious injury in an impact, from published coefficients only -----------------------------

KM_H = 3.6
"""km/h per m/s."""
INTERCEPT, SLOPE = 6.9, 0.090
"""Coefficients of a pedestrian's risk of death. Rosen and Sander (2009), "Pedestrian fatality risk as a function of car
impact speed", Accident Analysis and Prevention 41(3): 490 adults on foot, struck by the front of a passenger car in
Germany from 1999 to 2007, give the risk of death 1 / (1 + exp(6.9 - 0.090 v)), v in km/h. By its abstract the risk at
50 km/h is more than twice that at 40 km/h and more than five times that at 30 km/h, which these coefficients satisfy.
"""


class Curve(NamedTuple):
    """Risk of serious injury, 1 / (1 + exp(-(constant + per_km_h v + per_year age)))."""

    constant: float
    per_km_h: float
    per_year: float
    age: float
    """Median age in the data [years]."""


SERIOUS = {
    ActorKind.PEDESTRIAN: Curve(-6.190, 0.078, 0.038, 46.0),
    ActorKind.BICYCLE: Curve(-7.467, 0.079, 0.047, 39.0),
    ActorKind.CAR: Curve(-7.654, 0.041, 0.021, 39.0),
}
"""Curves of persons struck by the front of a car.

Lubbe, Wu and Jeppsson (2022), "Safe speeds: fatality and injury risks of pedestrians, cyclists, motorcyclists, and car
drivers impacting the front of another passenger car as a function of closing speed and age", Traffic Safety Research 2,
000006: accidents in Germany from 1999 to 2020 give the risk of an injury of AIS 3 or more, or of death (MAIS3+F), 1 /
(1 + exp(-(a + b v + c age))), v the relative speed of the two in km/h; tables 2, 3 and 5, to three decimals, as copied
in later publications. By its abstract the risk is 10 % at 29 km/h on foot, at 44 km/h on a bicycle and at 112 km/h in a
car, which these coefficients satisfy, within their rounding, at the median ages in the data: 46, 39 and 39 years. The
coefficients of motorcyclists could not be checked; for trucks, buses and collisions with an obstacle there are none.
"""


def pedestrian_fatality(speed: float) -> float:
    """Return the risk of death of an adult pedestrian struck by the front of a car at a speed [m/s]."""
    return 1.0 / (1.0 + math.exp(INTERCEPT - SLOPE * KM_H * max(speed, 0.0)))


def striking_car(now: Snapshot, ego: ActorKind, other: ActorKind) -> int | None:
    """Return 0 if the ego's front strikes a pedestrian, 1 if the other's does, None if neither."""
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
    """Return the risk of an injury of AIS 3 or more, or of death, in an impact of a car's front at a relative speed
    [m/s].
    """
    if kind not in SERIOUS:
        return None
    curve = SERIOUS[kind]
    return 1.0 / (1.0 + math.exp(-(curve.constant + curve.per_km_h * KM_H * speed + curve.per_year * curve.age)))


def before_a_front(pair: Encounter) -> tuple[ActorKind, ...]:
    """Return the kinds of the actors that were struck by the front of a car."""
    now, ego, other = pair.contact, pair.ego.kind, pair.other.kind
    ahead_of_ego = pair.outcome("side") == Side.FRONT
    ahead_of_other = side_of(now.other, now.ego) == Side.FRONT
    struck = (other, ego, ahead_of_ego), (ego, other, ahead_of_other)
    return tuple(kind for kind, striker, ahead in struck if striker is ActorKind.CAR and ahead)


def fatality(pair: Encounter) -> float | None:
    car = striking_car(pair.contact, pair.ego.kind, pair.other.kind) if pair.touched else None
    return None if car is None else pedestrian_fatality(pair.outcome(("ego_speed", "other_speed")[car]))


def worst_injury(pair: Encounter) -> float | None:
    """Return the larger risk of serious injury of the two actors, by the relative speed at contact; None without a
    curve.
    """
    if not pair.touched:
        return None
    ego, other, angle = (pair.outcome(name) for name in ("ego_speed", "other_speed", "approach_angle"))
    speed = math.hypot(ego - other * math.cos(angle), other * math.sin(angle))
    risks = (serious_injury(kind, speed) for kind in before_a_front(pair))
    return max((risk for risk in risks if risk is not None), default=None)
