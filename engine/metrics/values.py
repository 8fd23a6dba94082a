"""The values of the table's rows: what a run has of a measure that the kernels know at an instant."""

import math
from collections.abc import Callable

import numpy as np

from engine.kernels.conflict import Snapshot, post_encroachment_time, relative_speed, time_to_collision
from engine.kernels.encroachment import Stay, encroachment_gap
from engine.kernels.evasion import (
    braking_needed,
    swerving_needed,
    time_to_brake,
    time_to_kick_down,
    time_to_steer,
)
from engine.kernels.safe_distance import Responsibility, is_dangerous, worst_time_to_collision
from engine.metrics.bodies import Body
from engine.metrics.encounters import Encounter
from engine.metrics.injury import before_a_front, pedestrian_fatality, serious_injury, striking_car
from engine.tables import Floats

CRITICAL_TTC = 3.0
"""Threshold of TET and TIT [s]; *ours*, within the 1.5 to 4 s in use."""
RESPONSIBILITY = Responsibility(1.0, 3.5, 8.0, 4.0, 3.0, 0.2, 0.8, 0.1)
"""As CARLA sets Intel's ad-rss-lib by default; the paper names the parameters and leaves their values to regulators."""


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


# -- what it would still take ------------------------------------------------------------------------------------------


def braking_over_run(pair: Encounter) -> Floats:
    return pair.on_course(braking_needed, 0.0)


def swerving_over_run(pair: Encounter) -> Floats:
    return pair.on_course(swerving_needed, 0.0)


def share(needed: Floats, available: float) -> float:
    """Of what is needed in what there is; whoever has none needs nothing or infinitely much."""
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


# -- who was where first -----------------------------------------------------------------------------------------------


def pet_by_shift(pair: Encounter) -> float:
    if pair.touched:
        return 0.0
    return post_encroachment_time(pair.states, pair.span[1], pair.step, pair.number, pair.outlines)


def pet_by_area(pair: Encounter) -> float:
    return 0.0 if pair.touched else encroachment_gap(*pair.stays) * pair.step


def time_in_area(stay: Stay, step: float) -> float:
    return (stay.leave - stay.enter) * step if stay.enter < math.inf else math.nan


# -- what it would come to ---------------------------------------------------------------------------------------------


def change_of_velocity(now: Snapshot, own: Body, other: Body) -> float:
    """Of a body that strikes another centrally and stays with it [m/s]: nobody moves on alone."""
    return relative_speed(now) / (1.0 + own.mass / other.mass)


def fatality(pair: Encounter) -> float | None:
    car = striking_car(pair.nearest, pair.ego.kind, pair.other.kind) if pair.touched else None
    return None if car is None else pedestrian_fatality(pair.outcome(("ego_speed", "other_speed")[car]))


def worst_injury(pair: Encounter) -> float | None:
    """Of whom it is likelier for, by the relative speed at contact."""
    if not pair.touched:
        return None
    ego, other, angle = (pair.outcome(name) for name in ("ego_speed", "other_speed", "approach_angle"))
    speed = math.hypot(ego - other * math.cos(angle), other * math.sin(angle))
    kinds = before_a_front(pair.nearest, pair.ego.kind, pair.other.kind)
    return max((risk for kind in kinds if (risk := serious_injury(kind, speed)) is not None), default=None)


def time_in_danger(pair: Encounter) -> float:
    return sum(is_dangerous(now, RESPONSIBILITY) for now in pair.samples) * pair.step
