"""Every metric of one run by name, with its unit: what a report shows and an export writes.

MD, MS, D_MS and TTC_MS decide the risk and come with the outcomes; the others are told beside them. Each metric is one
function; the definitions and sources of those of a pair stand in `engine.kernels.pair` and `.conflict`. Beside them is
what a file asks to be recorded: the values of each `record` over time, or at one end of it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from engine.kernels.conflict import (
    Snapshot,
    post_encroachment_time,
    relative_speed,
    required_deceleration,
    snapshot,
    time_headway,
    time_to_collision,
)
from engine.outcomes import PAIRS, Outcomes
from engine.program import Program
from engine.scenes import Trajectory
from engine.tables import Floats
from engine.vocabulary import State

if TYPE_CHECKING:
    from engine.world.aftermath import Impact


STEERING_DEAD_BAND = 0.01
"""A slower turn of the wheels has no sign [rad/s]."""


@dataclass(frozen=True)
class Metric:
    """One number of a run."""

    name: str
    actors: tuple[int, ...]
    """Whom it is about: a pair (ego, other), or one actor."""
    value: float
    """Infinite where the danger that it measures is not there; NaN where it is not defined."""
    unit: str
    meaning: str


def measure_trajectory(
    trajectory: Trajectory, outcomes: Outcomes, row: int = 0, rear_to_center: Sequence[float] = ()
) -> tuple[Metric, ...]:
    """All metrics of one run: those of each pair (ego, other) that meets, then the command metrics of each actor.

    `rear_to_center`: how far ahead of its rear axle each actor's centre lies [m], for the swing of centres in turns;
    without it centres are taken to move along the heading.
    """
    actors = trajectory.states.shape[1]
    behind = np.asarray(rear_to_center, dtype=np.float64) if len(rear_to_center) else np.zeros(actors)
    outlines = np.column_stack([trajectory.outlines[:, :2], behind])
    pairs = [metric for other in range(1, actors) for metric in _of_pair(trajectory, outlines, outcomes, row, other)]
    return (*pairs, *(metric for actor in range(actors) for metric in _of_actor(trajectory, outcomes, row, actor)))


def _of_pair(trajectory: Trajectory, outlines: Floats, outcomes: Outcomes, row: int, other: int) -> tuple[Metric, ...]:
    first, together = span_together(trajectory, other)
    if together == 0:
        return ()
    states, step = trajectory.states[first:], time_step(trajectory)
    pair, who = other - 1, (0, other)
    touched = bool(outcomes.collided[row]) and int(outcomes.contact_actors[row, 1]) == other
    run = [snapshot(states, together, k, 0.0, step, other, outlines) for k in range(together)]
    nearest_time = float(outcomes.min_distance_time[row, pair]) - first * step
    nearest = _at_time(states, together, nearest_time, step, other, outlines)
    pet = 0.0 if touched else post_encroachment_time(states, together, step, other, outlines)
    return (
        *(
            Metric(each.symbol, who, float(getattr(outcomes, each.name)[row, pair]), each.unit, each.meaning)
            for each in PAIRS
            if each.symbol
        ),
        Metric("V_MD", who, relative_speed(nearest), "m/s", "relative speed at the instant of MD"),
        Metric("TTC_MD", who, 0.0 if touched else time_to_collision(nearest), "s", "TTC at the instant of MD"),
        Metric("TTC", who, 0.0 if touched else min(map(time_to_collision, run)), "s", "least TTC of the run"),
        Metric("DRAC", who, max(map(required_deceleration, run)), "m/s^2", "largest deceleration needed"),
        Metric("THW", who, min(map(time_headway, run)), "s", "least headway behind a leader"),
        Metric("PET", who, pet, "s", "post-encroachment time, negative where the other was first"),
    )


def _at_time(states: Floats, together: int, time: float, step: float, other: int, outlines: Floats) -> Snapshot:
    """The pair at an instant; one after the last sample counts as the last."""
    steps = min(max(time / step, 0.0), together - 1.0)
    return snapshot(states, together, int(steps), steps - int(steps), step, other, outlines)


def _of_actor(trajectory: Trajectory, outcomes: Outcomes, row: int, actor: int) -> tuple[Metric, ...]:
    return (*_of_grip(outcomes, row, actor), *_of_commands(trajectory, actor))


def _of_grip(outcomes: Outcomes, row: int, actor: int) -> tuple[Metric, ...]:
    """Of who has tyres, where the friction is known."""
    lateral, combined = float(outcomes.lateral_grip[row, actor]), float(outcomes.combined_grip[row, actor])
    if math.isnan(combined):
        return ()
    return (
        Metric("lateral grip", (actor,), lateral, "", "largest use of grip sideways, as a share of mu g"),
        Metric("combined grip", (actor,), combined, "", "the same, of acceleration and turning together"),
    )


def _of_commands(trajectory: Trajectory, actor: int) -> tuple[Metric, ...]:
    states = trajectory.states[: scored_samples(trajectory), actor]
    first, present = _stretch(states[:, State.PRESENT] != 0.0)
    states, step = states[first : first + present], time_step(trajectory)
    steering, pedals = steering_oscillation(states, step), pedal_oscillation(states, step)
    return (
        Metric("steering oscillation", (actor,), steering, "1/s", "sign changes of the steering rate"),
        Metric("pedal oscillation", (actor,), pedals, "1/s", "switches between throttle and brake"),
    )


def measure_impacts(impacts: "Sequence[Impact]") -> tuple[Metric, ...]:
    """The largest delta-V of each actor that was struck: the change of its velocity by the impulses of one impact."""
    struck = sorted({actor for impact in impacts for actor in impact.actors})
    return tuple(
        Metric("delta-V", (actor,), max(_delta_v(impact, actor) for impact in impacts), "m/s", "of the hardest impact")
        for actor in struck
    )


def _delta_v(impact: "Impact", actor: int) -> float:
    return impact.delta_v[impact.actors.index(actor)] if actor in impact.actors else 0.0


def steering_oscillation(states: Floats, step: float) -> float:
    """Sign changes of the steering rate a second; rates within the dead band are passed over. NaN without a step.

    `states` (samples, len(State)) of one actor. As a command metric: Table 1 of the CORTEX-AVD paper.
    """
    rate = np.diff(states[:, State.STEER]) / step
    return _changes_a_second(np.sign(rate[np.abs(rate) > STEERING_DEAD_BAND]), len(states) - 1, step)


def pedal_oscillation(states: Floats, step: float) -> float:
    """Switches between throttle and brake a second; coasting in between is passed over, and brake beats throttle."""
    pedal = np.where(states[1:, State.BRAKE] > 0.0, -1.0, np.sign(states[1:, State.THROTTLE]))
    return _changes_a_second(pedal[pedal != 0.0], len(states) - 1, step)


def _changes_a_second(signs: Floats, steps: int, step: float) -> float:
    return float(np.count_nonzero(np.diff(signs))) / (steps * step) if steps > 0 else math.nan


def scored_samples(trajectory: Trajectory) -> int:
    """Samples up to the end of the scored run; what contact physics shows afterwards is left out."""
    return trajectory.contact_sample + 1 if trajectory.contact_sample >= 0 else len(trajectory.time)


def span_together(trajectory: Trajectory, other: int) -> tuple[int, int]:
    """The first scored sample at which the ego and another are both present, and at how many they are from then on."""
    present = trajectory.states[: scored_samples(trajectory), [0, other], State.PRESENT] != 0.0
    return _stretch(present.all(axis=1))


def time_step(trajectory: Trajectory) -> float:
    """Time between two samples [s]; of a single sample, any."""
    return float(trajectory.time[1] - trajectory.time[0]) if len(trajectory.time) > 1 else 1.0


def _stretch(flags: np.ndarray) -> tuple[int, int]:
    """The first flag that holds, and how many do without a gap; 0, 0 where none does."""
    if not flags.any():
        return 0, 0
    first = int(np.argmax(flags))
    rest = flags[first:]
    return first, len(rest) if rest.all() else int(np.argmin(rest))


# -- records -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Recorded:
    """The values of one `record` in one run. SI units."""

    name: str
    when: str
    """`series`, or `initial` or `final`: then there is one value."""
    unit: str
    """SI unit word, "" for pure numbers and truths."""
    line: int
    time: Floats
    """(n,) [s]"""
    values: Floats
    """(n,) truths as 1 and 0."""


def recorded(program: Program, trajectory: Trajectory) -> tuple[Recorded, ...]:
    """All records of a program, in the order of the file, from the first sample to the end of the scored run."""
    parts = {"series": slice(None), "initial": slice(None, 1), "final": slice(-1, None)}
    time = trajectory.time[: len(trajectory.watched)]
    return tuple(
        Recorded(
            record.name,
            record.when,
            record.unit,
            record.line,
            time[parts[record.when]],
            trajectory.watched[parts[record.when], record.rule],
        )
        for record in program.records
    )
