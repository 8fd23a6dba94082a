"""A run as moments in time: braking, closest approach, contacts, the end and its reason, and events after contact."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from cortex_dsl.report.blocks import KeyMoment
from cortex_dsl.report.findings.readable import KM_H, SpeedUnit, fixed, percent, speed_unit
from engine.outcomes import Outcomes
from engine.program import Program, Rule
from engine.scenes import Trajectory
from engine.tables import A_BUILDING, SLIDING, Floats, Ints
from engine.vocabulary import EndReason, Fault, State

if TYPE_CHECKING:
    from engine.scenes import Impact


PEDAL = 0.01
"""Brake pedal from which an actor is said to brake."""
PAUSE = 0.3
"""A shorter pause in braking does not count [s]."""
REST = 0.05
"""Speed below which an actor stands [m/s]."""
MOST_BRAKINGS = 3
"""Brakings of one actor that the story has."""


ORDER = ("start", "left_road", "fastest", "brake", "closest", "rest", "contact", "impact", "end")
"""Kinds of moments, in the order in which those of one time stand."""


class Cast(Protocol):
    """The actors and rules that a story refers to: those of a program, or of a recording from elsewhere."""

    @property
    def actors(self) -> Sequence[str]: ...
    @property
    def rules(self) -> Sequence[Rule]: ...
    @property
    def step_lines(self) -> Ints: ...
    def place(self, line: int) -> str: ...


@dataclass(frozen=True)
class Moment:
    """One line of the story."""

    time: float
    """[s]"""
    actor: int
    """-1: not of one actor."""
    kind: str
    """Kind of moment, a member of `ORDER`."""
    text: str


def story_of(
    program: Cast, outcomes: Outcomes, trajectory: Trajectory, row: int = 0, pair: int = 0, unit: SpeedUnit = KM_H
) -> list[Moment]:
    """The story of one scored run, in the order of time. `pair`: the pair (ego, pair + 1) that decided the risk."""
    contact_time = float(outcomes.end_time[row])
    moments = [
        *_starts(program, trajectory, unit),
        *(m for actor in range(len(program.actors)) for m in _of_actor(trajectory, actor, contact_time, unit)),
        *_left_road(trajectory, outcomes, row),
        *_others_contact(program, outcomes, row),
        *_of_pair(program, outcomes, row, pair, unit),
        end_of(program, outcomes, row),
    ]
    return in_order(moments)


def in_order(moments: Iterable[Moment]) -> list[Moment]:
    """Return the moments in order of time; moments at one time are in order from causes to effects."""
    return sorted(moments, key=lambda moment: (moment.time, ORDER.index(moment.kind)))


def end_of(program: Cast, outcomes: Outcomes, row: int) -> Moment:
    """Return the reason of the end of the run."""
    time, reason = float(outcomes.end_time[row]), EndReason(int(outcomes.end_reason[row]))
    if reason == EndReason.COLLISION:
        first, second = (program.actors[int(actor)] for actor in outcomes.contact_actors[row])
        return Moment(time, -1, "contact", f"contact: {first} and {second}{_struck(program, outcomes, row)}")
    if reason == EndReason.BUILDING:
        return Moment(time, -1, "contact", f"contact: {program.actors[0]} and a building")
    return Moment(time, -1, "end", end_text(program, reason, int(outcomes.end_rule[row])))


STRUCK = {Fault.STRUCK_FROM_BEHIND: "from behind", Fault.STRUCK_STANDING: "while standing"}


def _struck(program: Cast, outcomes: Outcomes, row: int) -> str:
    """`; ego was struck from behind, which is not its failure`, where it was."""
    how = STRUCK.get(Fault(max(0, int(outcomes.fault[row, int(outcomes.contact_actors[row, 1]) - 1]))))
    return f"; {program.actors[0]} was struck {how}, which is not its failure" if how else ""


def end_text(program: Cast, reason: EndReason, rule: int) -> str:
    """The reason of an end in words; a rule with its line."""
    if reason in RULE_TEXTS and 0 <= rule < len(program.rules):
        name, line = program.rules[rule].name, program.rules[rule].line
        return f"{RULE_TEXTS[reason]} {name if '`' in name else f'`{name}`'} (line {program.place(line)})"
    if reason == EndReason.STUCK and 0 <= rule < len(program.step_lines):
        return f"a behaviour was stuck (line {program.place(int(program.step_lines[rule]))})"
    return END_TEXTS[reason]


END_TEXTS = {
    EndReason.COLLISION: "collision",
    EndReason.RULE: "ended by a rule",
    EndReason.TIMEOUT: "time is up",
    EndReason.ALL_DONE: "every actor is done",
    EndReason.STUCK: "a behaviour was stuck",
    EndReason.BROKEN: "a state became NaN",
    EndReason.ABORTED: "invalid: a requirement on the run broke",
    EndReason.BUILDING: "the ego ran into a building",
}
RULE_TEXTS = {EndReason.RULE: "ended by", EndReason.ABORTED: "invalid, for it broke"}


def _starts(program: Cast, trajectory: Trajectory, unit: SpeedUnit) -> Iterator[Moment]:
    """Yield the start of each actor, at the time at which it becomes present."""
    for actor in range(len(program.actors)):
        here = np.flatnonzero(trajectory.states[:, actor, State.PRESENT] > 0.5)
        if len(here):
            speed = float(trajectory.states[here[0], actor, State.SPEED])
            verb = "starts" if here[0] == 0 else "comes in"
            text = f"{verb} at {unit.text(speed)}" if speed > REST else f"{verb} at rest"
            yield Moment(float(trajectory.time[here[0]]), actor, "start", text)


def _of_actor(trajectory: Trajectory, actor: int, end: float, unit: SpeedUnit) -> Iterator[Moment]:
    """Brakings, and coming to rest, up to the end of the scored run."""
    scored = trajectory.time <= end + 1e-9
    states, time = trajectory.states[scored, actor], trajectory.time[scored]
    for start, stop in list(_stretches(time, states[:, State.BRAKE] > PEDAL))[:MOST_BRAKINGS]:
        pedal = float(np.max(states[start:stop, State.BRAKE]))
        before, after = (float(states[i, State.SPEED]) for i in (max(0, start - 1), stop - 1))
        yield Moment(
            float(time[max(0, start - 1)]),
            actor,
            "brake",
            f"brakes, pedal {percent(pedal, 0)}, {unit.number(before)} to {unit.text(after)}",
        )
    moving = np.flatnonzero(states[:, State.SPEED] > REST)
    if len(moving) and moving[-1] + 1 < len(states) and states[moving[-1] + 1, State.PRESENT] > 0.5:
        yield Moment(float(time[moving[-1] + 1]), actor, "rest", "stands still")


def _stretches(time: NDArray[np.float64], on: NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """Half-open runs of samples where `on` holds, those with short pauses joined."""
    start = stop = -1
    for index in np.flatnonzero(on):
        if start >= 0 and time[index] - time[stop - 1] > PAUSE:
            yield start, stop
            start = -1
        start = int(index) if start < 0 else start
        stop = int(index) + 1
    if start >= 0:
        yield start, stop


def _left_road(trajectory: Trajectory, outcomes: Outcomes, row: int) -> Iterator[Moment]:
    """Yield when each actor is first off the road: when it leaves the road, or when it becomes present."""
    for actor, time in enumerate(outcomes.left_road_time[row]):
        if np.isfinite(time):
            before = trajectory.states[trajectory.time < time - 1e-9, actor, State.PRESENT]
            beginning = "starts off the road" if len(before) == 0 else "comes in off the road"
            text = "leaves the road" if np.any(before > 0.5) else beginning
            yield Moment(float(time), actor, "left_road", text)


def _others_contact(program: Cast, outcomes: Outcomes, row: int) -> Iterator[Moment]:
    time = float(outcomes.others_contact_time[row])
    if np.isfinite(time):
        first, second = (program.actors[int(actor)] for actor in outcomes.others_contact_actors[row])
        yield Moment(time, -1, "contact", f"contact: {first} and {second}; the run goes on")


def _of_pair(program: Cast, outcomes: Outcomes, row: int, pair: int, unit: SpeedUnit) -> Iterator[Moment]:
    """Fastest closing and closest approach of the deciding pair."""
    if outcomes.min_distance.shape[1] == 0:
        return
    other = program.actors[pair + 1]
    closing = float(outcomes.max_closing_speed[row, pair])
    if closing > 0:
        apart = fixed(float(outcomes.distance_at_ms[row, pair]), 2)
        text = f"closing fastest on {other}: {unit.text(closing)}, {apart} m apart"
        yield Moment(float(outcomes.max_closing_time[row, pair]), 0, "fastest", text)
    distance = float(outcomes.min_distance[row, pair])
    if 0.0 < distance < np.inf:
        yield Moment(
            float(outcomes.min_distance_time[row, pair]),
            0,
            "closest",
            f"closest to {other}: {fixed(distance, 2)} m apart",
        )


# -- the moment that a picture shows -----------------------------------------------------------------------------------


def moment_of(outcomes: Outcomes, trajectory: Trajectory, pair: int) -> KeyMoment | None:
    """Return contact, else the closest approach of a pair: the mark lies between the two outlines' centres."""
    contact = int(outcomes.contact_actors[0, 0]) >= 0
    if not contact and outcomes.min_distance.shape[1] == 0:
        return None
    time = float(outcomes.end_time[0] if contact else outcomes.min_distance_time[0, pair])
    if not np.isfinite(time):
        return None
    first, second = outcomes.contact_actors[0].tolist() if contact else (0, pair + 1)
    sample = int(np.argmin(np.abs(trajectory.time - time)))
    met = [first, second] if second >= 0 else [first]  # a building is no actor
    centres = trajectory.states[sample, met][:, [State.X, State.Y]]
    x, y = centres.mean(axis=0)
    return KeyMoment(sample, contact, (float(x), float(y)))


def contact_moment(trajectory: Trajectory, pair: int) -> KeyMoment | None:
    """Return the contact of a pair in a run that ended with it; None if the run has no contact."""
    sample = trajectory.contact_sample
    if sample < 0 or pair < 0:
        return None
    x, y = trajectory.states[sample, [0, pair + 1]][:, [State.X, State.Y]].mean(axis=0)
    return KeyMoment(sample, True, (float(x), float(y)))


# -- how fast all actors move, also after contact, where bodies slide sideways and spin --------------------------------


def speeds(trajectory: Trajectory) -> Floats:
    """Return the speeds (samples, actors) [m/s]; NaN while an actor is not in the scene.

    Up to contact, or to an earlier impact of its own, it is the speed that the actor drives, negative backwards. From
    then on it is the speed of its centre in any direction, over the step after a sample, so that no value mixes speeds
    before and after the impact; the last sample continues the braking before it.
    """
    there, loose = trajectory.states[..., State.PRESENT] > 0.5, trajectory.states[..., State.PRESENT] == SLIDING
    found = np.where(there, trajectory.states[..., State.SPEED], np.nan)
    first = trajectory.contact_sample + 1
    if 0 < first < len(found) - 1:
        loose[first:] = there[first:]
    if loose.any() and len(found) > 2:
        from engine.metrics import time_step

        x, y = trajectory.states[..., State.X], trajectory.states[..., State.Y]
        moved = np.hypot(np.diff(x, axis=0), np.diff(y, axis=0)) / time_step(trajectory)
        last = np.maximum(0.0, 2.0 * moved[-1:] - moved[-2:-1] if len(found) - first > 2 else moved[-1:])
        found = np.where(loose, np.concatenate([moved, last]), found)
    return found


# -- events after contact: every impact, and the final positions -------------------------------------------------------

MOST_IMPACTS = 4
"""Maximum number of impacts that are listed; later ones repeat the same pair of vehicles with hardly any force."""


def aftermath(program: Program, impacts: "Sequence[Impact]", trajectory: Trajectory) -> list[Moment]:
    """Return each impact with the change of velocity of both bodies, and the actors that stand still in the end."""
    unit = speed_unit(program)
    shown = [moment for impact in impacts[:MOST_IMPACTS] for moment in _impact(program, impact, unit)]
    return shown + list(_rests(trajectory)) if impacts else []


def _impact(program: Program, impact: "Impact", unit: SpeedUnit) -> Iterator[Moment]:
    first, second = impact.actors
    angle = round(abs(math.degrees(impact.impact_angle)))
    apart = "" if second == A_BUILDING else f", headings {angle}° apart"
    yield Moment(impact.time, -1, "impact", f"impact at {unit.text(impact.closing_speed)}{apart}")
    for actor, other, change, hour in zip(impact.actors, (second, first), impact.delta_v, impact.clock, strict=True):
        by = "a building" if other == A_BUILDING else program.actors[other]
        if actor != A_BUILDING:
            text = f"delta-V {unit.text(change)}, struck by {by} at {hour} o'clock"
            yield Moment(impact.time, actor, "impact", text)


def _rests(trajectory: Trajectory) -> Iterator[Moment]:
    """Yield the time at which each actor stood still for good, for actors in motion at or after contact."""
    if trajectory.contact_sample < 0:
        return
    for actor, speed in enumerate(np.abs(speeds(trajectory)).T):
        moving = np.flatnonzero(speed > REST)
        if len(moving) and trajectory.contact_sample <= moving[-1] < len(speed) - 1:
            yield Moment(float(trajectory.time[moving[-1] + 1]), actor, "rest", "comes to rest")
