"""A recording judged with the kernels that judge our own runs, whoever drove: outcomes, risk, every metric.

First contact is searched over the motion between samples. Up to it, or to the end, everybody is put on whole steps; the
row after the last of them holds where everybody would be had nothing touched, as in the record of a run of ours. What
was such a run has the same numbers again.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from engine.host import MAX_SAMPLES
from engine.interchange.errors import InterchangeError
from engine.interchange.recording import SAME_INSTANT, Recording
from engine.interchange.resampling import OF_STEPS, states_at
from engine.kernels.approach import Touch, search_contact
from engine.kernels.pair import PairMetrics, measure_pair
from engine.metrics import Metric, measure_trajectory
from engine.risk import PROFILES, Risk, assess
from engine.scenes import Outcomes, Trajectory
from engine.tables import ROAD_REGION, Floats
from engine.vocabulary import EndReason, State, Verdict

COMMANDS = frozenset({"steering oscillation", "pedal oscillation"})
"""Metrics of wheel and pedals, which not every recording tells."""


@dataclass(frozen=True)
class Measured:
    """What a recording comes to."""

    outcomes: Outcomes
    """One row. A recording tells no rule that ended it: without contact, time is up or all are done."""
    risk: Risk
    metrics: tuple[Metric, ...]
    trajectory: Trajectory
    """The whole recording on steps of `Recording.step`, with what follows contact."""


@dataclass(frozen=True)
class _End:
    """Where what is scored ends: `part` of a step after sample `last` of the steps, at `time` [s]."""

    time: float
    last: int
    part: float
    states: Floats
    """(actors, len(State)) then."""
    touch: Touch


def measure(recording: Recording, profile: str = "paper") -> Measured:
    """Judge a recording up to first contact of any two, or to its end. Times count from its first sample.

    Raises:
        InterchangeError: no such profile; a recording that is empty, too long, or no motion.
    """
    if profile not in PROFILES:
        raise InterchangeError(f"there is no risk profile `{profile}`", f"name one of {', '.join(PROFILES)}")
    _check(recording)
    recording = recording.from_zero()
    outlines = np.array([[actor.length, actor.width, actor.rear_to_center] for actor in recording.actors])
    instants: Floats = np.arange(_steps(recording) + 1, dtype=np.float64) * recording.step
    steps = states_at(recording, instants)
    end = _end_of(recording, steps, search_contact(np.ascontiguousarray(recording.states), outlines))
    contact = min(end.last, len(steps) - 1) if end.touch.sample >= 0 else -1
    trajectory = Trajectory(instants, steps, outlines[:, :2].copy(), contact)
    outcomes = _outcomes(recording, _judged(steps, end), outlines, end)
    metrics = measure_trajectory(trajectory, outcomes, rear_to_center=outlines[:, 2].tolist())
    told = tuple(metric for metric in metrics if recording.commands or metric.name not in COMMANDS)
    return Measured(outcomes, assess(outcomes, PROFILES[profile]), told, trajectory)


# -- what can be measured ---------------------------------------------------------------------------------------------


def _check(recording: Recording) -> None:
    """Raises InterchangeError where there is nothing to measure, or too much."""
    recording.refuse_broken()
    if not (math.isfinite(recording.step) and recording.step > 0.0):
        raise InterchangeError(f"a time step of {recording.step} s", "take a positive number of seconds")
    span = float(recording.time[-1] - recording.time[0])
    if len(recording) > 2 * MAX_SAMPLES or span / recording.step > MAX_SAMPLES:
        raise InterchangeError(
            f"`{recording.name}`: {len(recording):,} samples over {span:g} s, every {recording.step:g} s, are too many",
            f"measure a part of it, or with a longer step: at most {MAX_SAMPLES:,} steps",
        )


def _steps(recording: Recording) -> int:
    """Whole steps of the recording."""
    return math.floor((recording.time[-1] + SAME_INSTANT) / recording.step)


# -- the end ----------------------------------------------------------------------------------------------------------


def _end_of(recording: Recording, steps: Floats, touch: Touch) -> _End:
    """Contact at the very sample of a step belongs to the step before, as in a run of ours; an end there does not."""
    step = recording.step
    if touch.sample < 0:
        time, last = float(recording.time[-1]), len(steps) - 1
        return _End(time, last, _part(time, last, step), recording.states[-1], touch)
    time, states = _moment(recording, touch)
    last = min(max(0, math.ceil((time - SAME_INSTANT) / step) - 1), len(steps) - 1)
    both = [touch.one, touch.other]
    if not (steps[last, both, State.PRESENT] != 0.0).all():  # they came in where they touch
        return _End(time, last + 1, 0.0, states, touch)
    return _End(time, last, _part(time, last, step), states, touch)


def _part(time: float, last: int, step: float) -> float:
    """The part of a step that came after the sample `last`; 0 at that sample itself."""
    after = time - last * step
    return min(after / step, 1.0) if after > SAME_INSTANT else 0.0


def _moment(recording: Recording, touch: Touch) -> tuple[float, Floats]:
    """The instant of contact [s], and everybody's state then."""
    time, states, k = recording.time, recording.states, touch.sample
    if touch.part == 0.0:
        return float(time[k]), states[k]
    now = states[k] + touch.part * (states[k + 1] - states[k])
    now[:, OF_STEPS] = states[k + 1][:, OF_STEPS]
    now[:, State.PRESENT] = (states[k, :, State.PRESENT] != 0.0) & (states[k + 1, :, State.PRESENT] != 0.0)
    return float(time[k] + touch.part * (time[k + 1] - time[k])), now


def _judged(steps: Floats, end: _End) -> Floats:
    """The samples that are scored, and where the last step would have led; the end itself where it is a sample."""
    if end.part == 0.0:
        return np.concatenate([steps[: end.last], end.states[np.newaxis]])
    before = steps[end.last]
    beyond = before + (end.states - before) / end.part
    beyond[:, State.PRESENT] = end.states[:, State.PRESENT]
    return np.concatenate([steps[: end.last + 1], beyond[np.newaxis]])


# -- outcomes ---------------------------------------------------------------------------------------------------------


def _outcomes(recording: Recording, judged: Floats, outlines: Floats, end: _End) -> Outcomes:
    samples = len(judged) - (1 if end.part > 0.0 else 0)
    touched = end.touch.other if end.touch.one == 0 else -1
    pairs = [
        measure_pair(judged, samples, recording.step, other, outlines, other == touched, end.part)
        for other in range(1, len(recording.actors))
    ]
    return Outcomes(
        verdict=_row(int(Verdict.VALID)),
        collided=np.array([end.touch.one == 0]),
        end_reason=_row(int(_reason(end))),
        end_rule=_row(-1),
        end_time=np.array([end.time]),
        steps=_row(end.last + (1 if end.part > 0.0 else 0)),
        **_of_pairs(pairs),
        left_road_time=_left_road(recording, judged),
        contact_actors=_row(end.touch.one, end.touch.other).reshape(1, 2),
    )


def _row(*values: int) -> np.ndarray:
    return np.array(values, dtype=np.int32)


def _reason(end: _End) -> EndReason:
    if end.touch.sample >= 0:
        return EndReason.COLLISION if end.touch.one == 0 else EndReason.OTHER_COLLISION
    there = np.count_nonzero(end.states[:, State.PRESENT])
    return EndReason.TIMEOUT if there >= min(2, len(end.states)) else EndReason.ALL_DONE


def _of_pairs(pairs: Sequence[PairMetrics]) -> dict[str, np.ndarray]:
    """The columns of outcomes that hold a number for each pair."""
    met = [pair.approach for pair in pairs]
    return {
        "min_distance": _line(pair.min_distance for pair in pairs),
        "min_distance_time": _line(pair.min_distance_time for pair in pairs),
        "max_closing_speed": _line(pair.max_closing_speed for pair in pairs),
        "max_closing_time": _line(pair.max_closing_time for pair in pairs),
        "distance_at_ms": _line(pair.distance_at_ms for pair in pairs),
        "ttc_at_ms": _line(pair.ttc_at_ms for pair in pairs),
        "ego_speed": _line(approach.ego_speed for approach in met),
        "other_speed": _line(approach.other_speed for approach in met),
        "approach_angle": _line(approach.angle for approach in met),
        "closing_speed": _line(approach.closing_speed for approach in met),
        "side": _row(*(approach.side for approach in met)).reshape(1, -1),
    }


def _line(values: Iterable[float]) -> Floats:
    """(1, pairs); -0.0 is 0."""
    return np.array(list(values), dtype=np.float64).reshape(1, -1) + 0.0


def _left_road(recording: Recording, judged: Floats) -> Floats:
    """(1, actors): when each centre was first outside one of our roads, at the samples from which it went on."""
    times = np.full((1, len(recording.actors)), math.nan)
    if recording.road is None:
        return times
    from engine.road import build_network

    regions = build_network(recording.road).regions
    there = judged[:, :, State.PRESENT] != 0.0
    for actor in range(len(recording.actors)):
        for sample in np.flatnonzero(there[:-1, actor] & there[1:, actor]).tolist():
            if not regions.contains(ROAD_REGION, *judged[sample, actor, [State.X, State.Y]].tolist()):
                times[0, actor] = sample * recording.step
                break
    return times
