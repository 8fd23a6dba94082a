"""The table of metrics of single runs: of pairs of the ego and another actor, and of one actor.

A row is a `Measure`. Reports, pages, JSON, the API, `measure` of recordings and the page of the reference take metrics
from here, after those rows of `engine.outcomes` that have a symbol, which every batch of runs yields, too. A new metric
is its kernel, a row, and a test. The kernels' docstrings have the definitions and their reasons.
"""

import math
from collections.abc import Callable
from functools import partial
from typing import Generic, ParamSpec

import numpy as np

from engine.frozen import frozen
from engine.kernels.conflict import relative_speed, required_deceleration, time_gap, time_headway
from engine.metrics.encounters import Encounter
from engine.metrics.values import (
    CRITICAL_TTC,
    braking_over_run,
    change_of_velocity,
    fatality,
    largest,
    least,
    least_ttc,
    least_wttc,
    left_to_brake,
    left_to_kick_down,
    left_to_react,
    left_to_steer,
    over_run,
    pet_by_area,
    pet_by_shift,
    share,
    swerving_over_run,
    time_exposed,
    time_in_area,
    time_in_danger,
    time_integrated,
    ttc_at_md,
    worst_injury,
)
from engine.tables import Floats
from engine.vocabulary import State

HAYWARD = (
    'Hayward (1972), "Near-miss determination through use of a scale of danger"; outlines as in Laureshyn et al. (2010)'
)
HILLENBRAND = 'Hillenbrand, Spieker and Kroschel (2006), "A multilevel collision mitigation approach"'
JANSSON = 'Jansson (2005), "Collision avoidance theory", PhD thesis, Linkoping'
MINDERHOUD = 'Minderhoud and Bovy (2001), "Extended time-to-collision measures for road traffic safety assessment"'
ALLEN = 'Allen, Shin and Cooper (1978), "Analysis of traffic conflicts and collisions"'
PAPER = "CORTEX-AVD, Table 1"


Given = ParamSpec("Given")


@frozen
class Measure(Generic[Given]):
    """One metric of a pair, or of an actor."""

    symbol: str
    title: str
    """Its name in words."""
    unit: str
    """SI unit word, "" for pure numbers."""
    meaning: str
    """Text of a report next to the value."""
    formula: str
    source: str
    value: Callable[Given, float | None]
    """Function of an `Encounter`, or of an actor's states and the time step; None if it does not apply."""
    remark: str = ""
    """Remark on the page of the reference."""
    of_commands: bool = False
    """True for a metric of wheel and pedals, which some recordings lack."""


# -- the table ---------------------------------------------------------------------------------------------------------

OF_PAIRS: tuple[Measure[[Encounter]], ...] = (
    Measure(
        "V_MD",
        "relative speed at MD",
        "m/s",
        "relative speed at the instant of MD",
        "|v_other - v_ego|",
        PAPER,
        lambda pair: relative_speed(pair.nearest),
    ),
    Measure(
        "TTC_MD",
        "time to collision at MD",
        "s",
        "TTC at the instant of MD",
        "TTC, taken at MD; 0 on contact",
        PAPER,
        ttc_at_md,
    ),
    Measure(
        "TTC",
        "time to collision",
        "s",
        "least TTC of the run",
        "the first t >= 0 at which the outlines touch if both keep velocity and heading; 0 on contact",
        HAYWARD,
        least_ttc,
        "Other tools take centres, or lanes: the same left turn has 4.25 s, 4.06 s, 1.96 s or infinity.",
    ),
    Measure(
        "TET",
        "time exposed to a small TTC",
        "s",
        f"time with a TTC of at most {CRITICAL_TTC:g} s",
        "number of samples with TTC <= 3 s, times the time step",
        MINDERHOUD,
        time_exposed,
        "The threshold of 3 s is cortexc's choice.",
    ),
    Measure(
        "TIT",
        "time integrated TTC",
        "s^2",
        f"how far TTC was below {CRITICAL_TTC:g} s, integrated over time",
        "sum of max(0, 3 s - TTC) over samples, times the time step",
        MINDERHOUD,
        time_integrated,
        "The threshold of 3 s is cortexc's choice.",
    ),
    Measure(
        "WTTC",
        "worst time to collision",
        "s",
        "least time to contact if both do the worst possible",
        "the first t with |p + v t| = r_ego + r_other + (a_ego + a_other) t^2 / 2; r: half diagonals, a: grip",
        'Wachenfeld et al. (2016), "The worst-time-to-collision metric for situation identification"',
        least_wttc,
        "CriMe's circles have the radius of a third of the outline, which does not cover it.",
    ),
    Measure(
        "DRAC",
        "deceleration rate to avoid a crash",
        "m/s^2",
        "largest deceleration needed to avoid contact",
        "|v|^2 / (2 |v| TTC) of the relative motion",
        'Cooper and Ferguson (1976), "Traffic studies at T-junctions"',
        partial(over_run, required_deceleration, largest),
        "It belongs to the pair: behind another actor it is what the follower needs; where paths cross it belongs to "
        "neither. In a collision it grows without bound: it then shows only how near to contact the last sample is.",
    ),
    Measure(
        "a_req",
        "deceleration that the ego needs",
        "m/s^2",
        "largest deceleration that the ego alone needs to avoid contact",
        "the least a such that braking by a to a stop avoids contact; behind a slower actor dv^2 / (2 gap)",
        f"{JANSSON}, section 5.3.5",
        lambda pair: largest(braking_over_run(pair)),
    ),
    Measure(
        "BTN",
        "brake threat number",
        "",
        "largest share of its possible braking that the ego needs",
        "a_req / min(brakes, grip)",
        'Brannstrom, Sjoberg and Coelingh (2008), "A situation and threat assessment algorithm"',
        lambda pair: share(braking_over_run(pair), pair.ego.braking),
        "Above 1, braking alone does not avoid contact.",
    ),
    Measure(
        "a_lat_req",
        "lateral acceleration that the ego needs",
        "m/s^2",
        "largest lateral acceleration that the ego alone needs to avoid contact",
        "the least a such that swerving by a avoids contact; straight behind 2 d / TTC^2, d: lateral distance needed",
        f"{JANSSON}, section 5.3.8",
        lambda pair: largest(swerving_over_run(pair)),
    ),
    Measure(
        "STN",
        "steer threat number",
        "",
        "largest share of its grip that the ego needs to swerve",
        "a_lat_req / grip",
        'Brannstrom, Sjoberg and Coelingh (2008), "A situation and threat assessment algorithm"',
        lambda pair: share(swerving_over_run(pair), pair.ego.grip),
        "Above 1, steering alone does not avoid contact.",
    ),
    Measure(
        "TTB",
        "time to brake",
        "s",
        "least time left to begin braking",
        "the latest t <= TTC from which full braking avoids contact; behind a slower actor TTC - dv / (2 a)",
        HILLENBRAND,
        lambda pair: least(left_to_brake(pair)),
        "Minus infinity: it was too late to brake.",
    ),
    Measure(
        "TTS",
        "time to steer",
        "s",
        "least time left to begin swerving",
        "the latest t <= TTC from which swerving with all grip avoids contact; straight behind TTC - sqrt(2 d / a)",
        HILLENBRAND,
        lambda pair: least(left_to_steer(pair)),
        "The outline moves sideways without turning, as a point mass: a real car is slower.",
    ),
    Measure(
        "TTK",
        "time to kick down",
        "s",
        "least time left to begin speeding up",
        "the latest t <= TTC from which full throttle avoids contact",
        HILLENBRAND,
        lambda pair: least(left_to_kick_down(pair)),
    ),
    Measure(
        "TTR",
        "time to react",
        "s",
        "least time left to begin any of these",
        "max(TTB, TTS, TTK) at each sample",
        HILLENBRAND,
        lambda pair: least(left_to_react(pair)),
    ),
    Measure(
        "THW",
        "time headway",
        "s",
        "least headway behind a leader, front to front",
        "(front of the leader - front of the ego) / speed of the ego",
        'Vogel (2003), "A comparison of headway and time to collision as safety indicators"',
        partial(over_run, time_headway, least),
        "It counts the leader's length. CriMe's THW is the time gap.",
    ),
    Measure(
        "time gap",
        "time gap",
        "s",
        "least time until the ego is where the leader's rear is",
        "(rear of the leader - front of the ego) / speed of the ego",
        'SAE J2944 (2015), "Operational definitions of driving performance measures and statistics"',
        partial(over_run, time_gap, least),
        "CriMe shifts outlines along x and y at once: its headways are right only for roads that lead east.",
    ),
    Measure(
        "PET",
        "post-encroachment time, by shift",
        "s",
        "least time between both being at the same place, negative if the other was first",
        "the least shift of one motion in time by which the two would have touched; 0 on contact",
        f"{ALLEN}, of every place that both outlines cover",
        pet_by_shift,
    ),
    Measure(
        "PET_area",
        "post-encroachment time, by conflict area",
        "s",
        "time from one leaving the conflict area to the other entering it, negative if the other was first",
        "enter(second) - leave(first); 0 on contact, infinite without such an area, none if both are in it at once",
        ALLEN,
        pet_by_area,
        "The conflict area is what both outlines sweep. CriMe's is made of lanes.",
    ),
    Measure(
        "ET",
        "encroachment time",
        "s",
        "how long the ego was in the conflict area",
        "leave(ego) - enter(ego); no number without a conflict area",
        ALLEN,
        lambda pair: time_in_area(pair.stays[0], pair.step),
    ),
    Measure(
        "RSS",
        "time in a dangerous situation",
        "s",
        "time with less distance than responsibility-sensitive safety demands",
        "number of samples nearer than both safe distances, along and across the ego's heading, times the time step",
        'Shalev-Shwartz, Shammah and Shashua (2017), "On a formal model of safe and scalable self-driving cars"',
        time_in_danger,
        "For two on one road; two that cross have 0. Parameters as CARLA sets ad-rss-lib: response 1 s, speeding up by "
        "3.5 m/s^2, braking by 4 (3 in its own lane) to 8 m/s^2, sideways 0.2 and 0.8 m/s^2, margin 0.1 m.",
    ),
    Measure(
        "dV_ego",
        "delta-V to expect, of the ego",
        "m/s",
        "change of the ego's velocity in a collision with the velocities at MD",
        "|v| m_other / (m_ego + m_other) at the instant of MD",
        'Laureshyn et al. (2017), "In search of the severity dimension of traffic events", its Delta-V0',
        lambda pair: change_of_velocity(pair.nearest, pair.ego, pair.other),
        "For a central impact without rebound. CriMe adds velocities where they must be subtracted.",
    ),
    Measure(
        "dV_other",
        "delta-V to expect, of the other",
        "m/s",
        "change of the other's velocity in a collision with the velocities at MD",
        "|v| m_ego / (m_ego + m_other) at the instant of MD",
        'Laureshyn et al. (2017), "In search of the severity dimension of traffic events", its Delta-V0',
        lambda pair: change_of_velocity(pair.nearest, pair.other, pair.ego),
    ),
    Measure(
        "P_fatal",
        "risk of death of a pedestrian",
        "",
        "risk of death of an adult pedestrian, struck by a car's front",
        "1 / (1 + exp(6.9 - 0.090 v)), v: speed of the car at contact in km/h",
        'Rosen and Sander (2009), "Pedestrian fatality risk as a function of car impact speed"',
        fatality,
        "Only for such a contact.",
    ),
    Measure(
        "P_serious",
        "risk of serious injury",
        "",
        "risk of an injury of AIS 3 or more, or of death, for a person who meets a car's front; the larger of both",
        "1 / (1 + exp(-(a + b v + c age))), v: relative speed at contact in km/h; on foot -6.190, 0.078, 0.038, 46 "
        "years; on a bicycle -7.467, 0.079, 0.047, 39; in a car -7.654, 0.041, 0.021, 39",
        'Lubbe, Wu and Jeppsson (2022), "Safe speeds: fatality and injury risks of pedestrians, cyclists, '
        "motorcyclists, and car drivers impacting the front of another passenger car as a function of closing speed "
        'and age"',
        worst_injury,
        "Ages are the medians of the source's data; with these, the risk is 10 % at 29, 44 and 112 km/h. There is no "
        "value for motorcycles, as no coefficients could be checked, nor for trucks and buses.",
    ),
)
"""Metrics in the order of reports."""


# -- metrics of one actor ----------------------------------------------------------------------------------------------

STEERING_DEAD_BAND = 0.01
"""Steering rate below which a change has no sign [rad/s]."""


def steering_oscillation(states: Floats, step: float) -> float:
    """Return sign changes of the steering rate per second; rates within the dead band are ignored. NaN without a step.

    `states` (samples, len(State)) of one actor. As a command metric: Table 1 of the CORTEX-AVD paper.
    """
    rate = np.diff(states[:, State.STEER]) / step
    return _changes_a_second(np.sign(rate[np.abs(rate) > STEERING_DEAD_BAND]), len(states) - 1, step)


def pedal_oscillation(states: Floats, step: float) -> float:
    """Return switches between throttle and brake per second; coasting in between is ignored, brake has priority."""
    pedal = np.where(states[1:, State.BRAKE] > 0.0, -1.0, np.sign(states[1:, State.THROTTLE]))
    return _changes_a_second(pedal[pedal != 0.0], len(states) - 1, step)


def _changes_a_second(signs: Floats, steps: int, step: float) -> float:
    return float(np.count_nonzero(np.diff(signs))) / (steps * step) if steps > 0 else math.nan


def hardest_braking(states: Floats, step: float) -> float:
    """Return the largest recorded deceleration along the heading [m/s^2]; 0 if the actor never slowed down.

    Backwards driving counts, too; a step with a change of direction is ignored, as it shows no braking.
    """
    speed = states[:, State.SPEED]
    slower = -np.diff(np.abs(speed))[speed[1:] * speed[:-1] >= 0.0] / step
    return float(np.max(slower, initial=0.0)) if len(states) > 1 else math.nan


def jerk(states: Floats, step: float) -> float:
    """Return the largest rate of the acceleration along the heading [m/s^3]; NaN with fewer than three samples.

    The acceleration is that of the recorded speeds, step by step, so an immediate change gives a jerk over one step.
    """
    return _largest_rate(np.diff(states[:, State.SPEED]) / step, step)


def lateral_jerk(states: Floats, step: float) -> float:
    """Return the largest rate of the acceleration across the heading: speed times yaw rate, at mid-step [m/s^3]."""
    turn = np.diff(np.unwrap(states[:, State.HEADING]))
    speed = 0.5 * (states[1:, State.SPEED] + states[:-1, State.SPEED])
    return _largest_rate(speed * turn / step, step)


def _largest_rate(values: Floats, step: float) -> float:
    return float(np.abs(np.diff(values)).max()) / step if len(values) > 1 else math.nan


OF_ACTORS: tuple[Measure[[Floats, float]], ...] = (
    Measure(
        "braking",
        "hardest braking",
        "m/s^2",
        "largest deceleration",
        "max of -d|v| / dt, step by step",
        "the motion itself",
        hardest_braking,
    ),
    Measure(
        "jerk",
        "jerk along the heading",
        "m/s^3",
        "largest change of acceleration a second",
        "max |d2v / dt2|, step by step",
        "the motion itself",
        jerk,
        "Pedals act at once here, so each change of a pedal is a jerk over one time step.",
    ),
    Measure(
        "lateral jerk",
        "jerk across the heading",
        "m/s^3",
        "largest change of lateral acceleration a second",
        "max |d(v yaw rate) / dt|, step by step",
        "the motion itself",
        lateral_jerk,
    ),
    Measure(
        "steering oscillation",
        "oscillation of steering",
        "1/s",
        "sign changes of the steering rate",
        "sign changes of the steering rate a second, without rates below 0.01 rad/s",
        PAPER,
        steering_oscillation,
        of_commands=True,
    ),
    Measure(
        "pedal oscillation",
        "oscillation of pedals",
        "1/s",
        "switches between throttle and brake",
        "switches between throttle and brake a second",
        PAPER,
        pedal_oscillation,
        of_commands=True,
    ),
)
"""Metrics in the order of reports; values are functions of an actor's states (samples, len(State)) and the time step.
"""
