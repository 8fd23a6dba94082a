"""Assessment of a recording, of any driver, with the kernels that assess simulated runs: outcomes, risk, every metric.

The ego's first contact is searched over the motion between samples. Up to it, or to the end, all actors are
interpolated at whole steps; the row after the last step holds their states without contact, as in the record of a
simulated run. A recorded run gives its original numbers again. Buildings of the recording are walls; visibility is not
assessed.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from engine.errors import InterchangeError
from engine.host import MAX_SAMPLES, pair_arrays, plain
from engine.interchange.recording import OF_STEPS, SAME_INSTANT, Recording, states_at
from engine.kernels.approach import Touch, search_contact_of
from engine.kernels.fault import fault_of
from engine.kernels.pair import PLACES, measure_pair
from engine.metrics import Body, Metric, measure_trajectory, outlines_of
from engine.outcomes import PAIRS, Outcomes, blank_outcomes
from engine.risk import PROFILES, Risk, assess
from engine.scenes import Trajectory
from engine.tables import A_BUILDING, ROAD_REGION, Floats, RoadTables, no_road
from engine.vehicles import MODELS
from engine.vocabulary import EndReason, State, Verdict


@dataclass(frozen=True)
class Measured:
    """Assessment of a recording."""

    outcomes: Outcomes
    """Outcomes, one row. No rule ends a recording: without contact, its end is a timeout or the completion of all
    actors.
    """
    risk: Risk
    metrics: tuple[Metric, ...]
    trajectory: Trajectory
    """The whole recording on steps of `Recording.step`, including the motion after contact."""
    sudden: bool
    """True if the ego and its partner were never apart: one of them appeared at the contact."""
    not_judged: tuple[str, ...]
    """Data that the recording lacks, so that no number depends on them."""


@dataclass(frozen=True)
class _End:
    """End of the scored part: `part` of a step after sample `last` of the steps, at `time` [s]."""

    time: float
    last: int
    part: float
    states: Floats
    """(actors, len(State)) States at the end."""
    touch: Touch
    """Contact of the ego; indices of buildings follow those of actors."""

    @property
    def met(self) -> int:
        """Return the actor that the ego touches; `A_BUILDING` for a building, and without contact."""
        return self.touch.other if self.touch.other < len(self.states) else A_BUILDING


def measure(recording: Recording, profile: str = "paper") -> Measured:
    """Assess a recording up to the ego's first contact, or to its end. Times count from its first sample.

    Contacts between other actors do not end it.

    Raises:
        InterchangeError: no such profile; the recording is empty, too long, or without motion; the ego overlaps an
            actor from the start.
    """
    if profile not in PROFILES:
        raise InterchangeError(f"there is no risk profile `{profile}`", f"name one of {', '.join(PROFILES)}")
    run = _run(recording)
    metrics = measure_trajectory(run.trajectory, run.outcomes, run.bodies, commands=recording.commands)
    risk = assess(run.outcomes, PROFILES[profile])
    return Measured(run.outcomes, risk, metrics, run.trajectory, run.sudden, tuple(_not_judged(recording)))


def outcomes_of(recording: Recording) -> Outcomes:
    """Return the outcomes alone, as in `measure`."""
    return _run(recording).outcomes


@dataclass(frozen=True)
class _Run:
    """A recording on whole steps, with its outcomes."""

    bodies: tuple[Body, ...]
    trajectory: Trajectory
    outcomes: Outcomes
    sudden: bool


def _run(recording: Recording) -> _Run:
    _check(recording)
    recording = recording.from_zero()
    bodies = _bodies(recording)
    outlines = outlines_of(bodies)
    instants: Floats = np.arange(_steps(recording) + 1, dtype=np.float64) * recording.step
    steps = _with_absences(recording, instants, states_at(recording, instants))
    states = np.ascontiguousarray(recording.states)
    touch = _first(search_contact_of(states, outlines, 0, 1), _search_walls(recording, states, outlines))
    _refuse_overlap(recording, touch)
    end = _end_of(recording, steps, touch)
    others = search_contact_of(states, outlines, 1, len(recording.actors))
    contact = min(end.last, len(steps) - 1) if end.touch.sample >= 0 else -1
    trajectory = Trajectory(instants, steps, outlines[:, :2].copy(), contact)
    outcomes = _outcomes(recording, _judged(steps, end), outlines, end, others)
    return _Run(bodies, trajectory, outcomes, _is_sudden(states, end))


def _with_absences(recording: Recording, instants: Floats, steps: Floats) -> Floats:
    """Return the steps, with an actor absent at the step after an absence shorter than a step.

    So no pair is measured across an absence.
    """
    sample, who = np.nonzero(~recording.there)
    after = np.searchsorted(instants, recording.time[sample] - SAME_INSTANT)
    between = (after > 0) & (after < len(instants))
    after, who = after[between], who[between]
    passed = steps[after - 1, who, State.PRESENT] != 0.0
    steps[after[passed], who[passed], State.PRESENT] = 0.0
    return steps


def _not_judged(recording: Recording) -> Iterator[str]:
    """Yield the limits of the assessment: contact with buildings, and occlusion."""
    if recording.buildings is None:
        yield "whether the ego runs into a building, or one hides an actor, is not judged: no buildings are known"
    elif len(recording.buildings):
        yield "the ego may run into a building; what buildings hide is not judged: nothing says where the ego looks"


def _bodies(recording: Recording) -> tuple[Body, ...]:
    """Return the actors' bodies; recordings contain no friction of the road."""
    return tuple(
        Body(
            actor.kind,
            actor.length,
            actor.width,
            actor.rear_to_center,
            math.inf if actor.mass > MODELS[actor.kind].fixed_above else actor.mass,
            actor.max_acceleration,
            actor.max_braking,
            MODELS[actor.kind].friction,
            actor.max_speed,
        )
        for actor in recording.actors
    )


# -- what can be measured ---------------------------------------------------------------------------------------------


def _check(recording: Recording) -> None:
    """Raise InterchangeError for an empty or too long recording."""
    recording.refuse_broken()
    if not (math.isfinite(recording.step) and recording.step > 0.0):
        raise InterchangeError(f"a time step of {recording.step} s", "take a positive number of seconds")
    span = float(recording.time[-1] - recording.time[0])
    if len(recording) > 2 * MAX_SAMPLES or span / recording.step > MAX_SAMPLES:
        raise InterchangeError(
            f"`{recording.name}`: {len(recording):,} samples over {span:g} s, every {recording.step:g} s, are too many",
            f"measure a part of it, or with a longer step: at most {MAX_SAMPLES:,} steps",
        )


def _refuse_overlap(recording: Recording, touch: Touch) -> None:
    """Raise InterchangeError if the recording begins with an overlap."""
    if touch.sample == 0 and touch.part == 0.0:
        names = [*(actor.name for actor in recording.actors), "a building"]
        one, other = names[0], names[min(touch.other, len(recording.actors))]
        raise InterchangeError(
            f"`{recording.name}`: {one} and {other} overlap in the first sample: nothing led to it",
            "cut the recording so that it begins before they touch, or check the sizes of both",
        )


def _steps(recording: Recording) -> int:
    """Return the number of whole steps of the recording."""
    return math.floor((recording.time[-1] + SAME_INSTANT) / recording.step)


# -- the end ----------------------------------------------------------------------------------------------------------


def _search_walls(recording: Recording, states: Floats, outlines: Floats) -> Touch:
    """Return the ego's first contact with a building, treated as a standing actor."""
    touch = Touch(-1, 0.0, -1, -1)
    there = states[recording.there[:, 0], 0, : State.Y + 1]
    if not len(there) or recording.buildings is None:
        return touch
    pair = np.zeros((len(states), 2, len(State)))
    pair[:, 0], pair[:, 1, State.PRESENT] = states[:, 0], 1.0
    low, high, radius = there.min(axis=0), there.max(axis=0), math.hypot(*outlines[0, :2])
    for number, wall in enumerate(recording.buildings):
        reach = radius + math.hypot(*wall[3:])
        if np.all(wall[:2] > low - reach) and np.all(wall[:2] < high + reach):
            pair[:, 1, : State.HEADING + 1] = wall[:3]
            found = search_contact_of(pair, np.array([outlines[0, :2], wall[3:]]), 0, 1)
            touch = _first(touch, found._replace(other=len(recording.actors) + number))
    return touch


def _first(one: Touch, other: Touch) -> Touch:
    """Return the earlier of two contacts; at equal times the first."""
    earlier = (other.sample, other.part) < (one.sample, one.part)
    return other if other.sample >= 0 and (one.sample < 0 or earlier) else one


def _is_sudden(states: Floats, end: _End) -> bool:
    """Return True if the ego and its partner have no earlier sample in common."""
    if end.met == A_BUILDING or end.touch.part > 0.0:
        return False
    return not (states[: end.touch.sample, [0, end.met], State.PRESENT] != 0.0).all(axis=1).any()


def _end_of(recording: Recording, steps: Floats, touch: Touch) -> _End:
    """Return the end; a contact at a step's sample belongs to the step before, as in a simulated run."""
    step = recording.step
    if touch.sample < 0:
        time, last = float(recording.time[-1]), len(steps) - 1
        return _End(time, last, _part(time, last, step), recording.states[-1], touch)
    time, states = _moment(recording, touch)
    last = min(max(0, math.ceil((time - SAME_INSTANT) / step) - 1), len(steps) - 1)
    both = [actor for actor in (touch.one, touch.other) if actor < len(recording.actors)]
    if not (steps[last, both, State.PRESENT] != 0.0).all():  # an actor appeared at the contact
        return _End(time, last + 1, 0.0, states, touch)
    return _End(time, last, _part(time, last, step), states, touch)


def _part(time: float, last: int, step: float) -> float:
    """Return the part of a step after the sample `last`; 0 at that sample itself."""
    after = time - last * step
    return min(after / step, 1.0) if after > SAME_INSTANT else 0.0


def _moment(recording: Recording, touch: Touch) -> tuple[float, Floats]:
    """Return the instant of contact [s], and the state of each actor then."""
    time, states, k = recording.time, recording.states, touch.sample
    if touch.part == 0.0:
        return float(time[k]), states[k]
    now = states[k] + touch.part * (states[k + 1] - states[k])
    now[:, OF_STEPS] = states[k + 1][:, OF_STEPS]
    now[:, State.PRESENT] = (states[k, :, State.PRESENT] != 0.0) & (states[k + 1, :, State.PRESENT] != 0.0)
    return float(time[k] + touch.part * (time[k + 1] - time[k])), now


def _judged(steps: Floats, end: _End) -> Floats:
    """Return the scored samples, and the extrapolated end of the last step; the end itself if it is a sample."""
    if end.part == 0.0:
        return np.concatenate([steps[: end.last], end.states[np.newaxis]])
    before = steps[end.last]
    beyond = before + (end.states - before) / end.part
    beyond[:, State.PRESENT] = end.states[:, State.PRESENT]
    return np.concatenate([steps[: end.last + 1], beyond[np.newaxis]])


# -- outcomes ---------------------------------------------------------------------------------------------------------


def _outcomes(recording: Recording, judged: Floats, outlines: Floats, end: _End, among: Touch) -> Outcomes:
    samples = len(judged) - (1 if end.part > 0.0 else 0)
    touched = end.met
    others = range(1, len(recording.actors))
    motions = [
        measure_pair(judged, samples, recording.step, other, outlines, other == touched, end.part) for other in others
    ]
    pairs = np.tile(np.array([row.fill for row in PAIRS], dtype=np.float64), (1, len(others), 1))
    for pair, motion in enumerate(motions):
        pairs[0, pair, list(PLACES)] = motion
    arrays = pair_arrays(pairs + 0.0)  # -0.0 is 0
    if touched > 0:
        road, intersections = _road(recording)
        met = motions[touched - 1]
        arrays["fault"][0, touched - 1] = fault_of(
            judged, samples - 1, recording.step, touched, outlines, met, road, intersections
        )
    return blank_outcomes(
        1,
        len(recording.actors),
        verdict=_row(int(Verdict.VALID)),
        collided=np.array([touched >= 0]),
        end_reason=_row(int(_reason(end))),
        end_time=np.array([end.time]),
        steps=_row(end.last + (1 if end.part > 0.0 else 0)),
        **arrays,
        left_road_time=_left_road(recording, judged),
        contact_actors=_row(end.touch.one, touched).reshape(1, 2),
        **_among_others(recording, end, among),
    )


def _road(recording: Recording) -> tuple[RoadTables, int]:
    """Return the road and its number of intersections; an empty road if the recording has none."""
    if recording.road is None:
        return no_road(), 0
    from engine.road import build_network
    from engine.road.arrays import road_tables

    network = build_network(recording.road)
    return plain(road_tables(network)), len(network.intersections)


def _among_others(recording: Recording, end: _End, touch: Touch) -> dict[str, np.ndarray]:
    """Return time and actors of the first contact between two others, if it is before the end."""
    time = _moment(recording, touch)[0] if touch.sample >= 0 else math.inf
    if time > end.time:
        return {}
    return {
        "others_contact_time": np.array([time]),
        "others_contact_actors": _row(touch.one, touch.other).reshape(1, 2),
    }


def _row(*values: int) -> np.ndarray:
    return np.array(values, dtype=np.int32)


def _reason(end: _End) -> EndReason:
    if end.touch.sample >= 0:
        return EndReason.COLLISION if end.met >= 0 else EndReason.BUILDING
    there = np.count_nonzero(end.states[:, State.PRESENT])
    return EndReason.TIMEOUT if there >= min(2, len(end.states)) else EndReason.ALL_DONE


def _left_road(recording: Recording, judged: Floats) -> Floats:
    """Return (1, actors) the time at which each centre first was off the road, at samples with a following sample; NaN:
    never.
    """
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
