"""The world host: one scene after another. The shared kernels drive; pymunk carries the poses and computes contacts.

`simulate` scores, so each scene ends at the ego's first contact; `run` continues through it to rest. Metrics are those
of the poses that pymunk carried, by the definitions of `engine.kernels.pair`. The timeline lists the events of a run
and the reason of its end.
"""

import math
from dataclasses import dataclass, fields
from enum import StrEnum

import numpy as np
import pymunk

from engine.config import Config
from engine.errors import ArgumentError
from engine.host import empty_results, memory, outcomes, outlines, plan, requested, samples_of
from engine.kernels.rollout import advance, begin
from engine.kernels.rows import Requested, Results, measure_run, note_end, note_objectives
from engine.kernels.run_state import Plan, Run, Status
from engine.metrics import Recorded, recorded
from engine.outcomes import Outcomes
from engine.program import Program
from engine.scenes import Impact, Scenes, Trajectory
from engine.tables import Floats
from engine.vocabulary import EndReason, State, Verdict
from engine.world.aftermath import follow_contact
from engine.world.bodies import carrier, carry, new_space, physiques
from engine.world.impacts import impacts_among_others

# -- the timeline of a run ---------------------------------------------------------------------------------------------

PEDAL = 0.01
"""Brake pedal from which on an actor brakes."""


class EventKind(StrEnum):
    """Kinds of events, with the content of `Event.value` in brackets."""

    BRAKE = "brake"
    """An actor touches its brake for the first time [its speed, m/s]."""
    CLOSEST = "closest"
    """The ego and another actor are nearest [MD, m]."""
    CONTACT = "contact"
    """The ego's first contact [0]; with a building, the ego is the only actor."""
    IMPACT = "impact"
    """Two bodies met [the larger delta-V, m/s]."""
    REST = "rest"
    """A struck actor has come to rest [0]."""
    LEFT_ROAD = "left_road"
    """An actor's centre left the road [its speed, m/s]."""
    END = "end"
    """End of the scored run [`EndReason`]."""


@dataclass(frozen=True)
class Event:
    """One event of a run."""

    time: float
    """[s]"""
    kind: EventKind
    actors: tuple[int, ...]
    value: float


def timeline(
    outcomes: Outcomes, trajectory: Trajectory, impacts: tuple[Impact, ...], rest: dict[int, float]
) -> tuple[Event, ...]:
    """Return all events of one run (row 0 of the outcomes), in the order of time."""
    end = float(outcomes.end_time[0])
    events = [
        *_brakes(trajectory, end),
        *_closest(outcomes),
        *_left_road(outcomes, trajectory),
        *(Event(i.time, EventKind.IMPACT, i.actors, max(i.delta_v)) for i in impacts),
        *(Event(time, EventKind.REST, (actor,), 0.0) for actor, time in rest.items()),
        _end(outcomes, end),
    ]
    return tuple(sorted(events, key=lambda event: event.time))


def _brakes(trajectory: Trajectory, end: float) -> list[Event]:
    """Return the first braking of each actor; a pedal recorded at sample k was pressed during the step that ended
    there.
    """
    events: list[Event] = []
    for actor in range(trajectory.states.shape[1]):
        pressed = np.flatnonzero(trajectory.states[:, actor, State.BRAKE] > PEDAL)
        if len(pressed) and trajectory.time[first := max(0, int(pressed[0]) - 1)] <= end:
            speed = float(trajectory.states[first, actor, State.SPEED])
            events.append(Event(float(trajectory.time[first]), EventKind.BRAKE, (actor,), speed))
    return events


def _closest(outcomes: Outcomes) -> list[Event]:
    return [
        Event(float(time), EventKind.CLOSEST, (0, pair + 1), float(distance))
        for pair, (time, distance) in enumerate(
            zip(outcomes.min_distance_time[0], outcomes.min_distance[0], strict=True)
        )
        if distance > 0.0 and np.isfinite(time)
    ]


def _left_road(outcomes: Outcomes, trajectory: Trajectory) -> list[Event]:
    events: list[Event] = []
    times: list[float] = outcomes.left_road_time[0].tolist()
    for actor, time in enumerate(times):
        if np.isfinite(time):
            sample = min(int(np.searchsorted(trajectory.time, time - 1e-9)), len(trajectory.time) - 1)
            speed = float(trajectory.states[sample, actor, State.SPEED])
            events.append(Event(time, EventKind.LEFT_ROAD, (actor,), speed))
    return events


def _end(outcomes: Outcomes, end: float) -> Event:
    reason = EndReason(int(outcomes.end_reason[0]))
    if reason is EndReason.COLLISION:
        one, other = (int(actor) for actor in outcomes.contact_actors[0])
        return Event(end, EventKind.CONTACT, (one, other), 0.0)
    if reason is EndReason.BUILDING:
        return Event(end, EventKind.CONTACT, (0,), 0.0)
    return Event(end, EventKind.END, (), float(reason))


# -- the host ----------------------------------------------------------------------------------------------------------

DEFAULTS = Config()


@dataclass(frozen=True)
class WorldRun:
    """Complete run of one scene."""

    outcomes: Outcomes
    """Outcomes, one row."""
    trajectory: Trajectory
    """Through contact to rest."""
    impacts: tuple[Impact, ...]
    """Impacts between other actors first, from the kernels; then those after the ego's contact, from pymunk."""
    events: tuple[Event, ...]
    records: tuple[Recorded, ...]
    """Records of the file, up to contact or the end."""
    touching: Floats | None = None
    """(actors, len(State)) at the very instant of the ego's contact, between two samples; None without contact."""

    def __repr__(self) -> str:
        """Return one line, for notebooks."""
        end = EndReason(int(self.outcomes.end_reason[0])).name.lower().replace("_", " ")
        scored = f"{end} after {float(self.outcomes.end_time[0]):.2f} s"
        return f"WorldRun({scored}; {len(self.trajectory.time)} samples, {len(self.impacts)} impacts)"


@dataclass(frozen=True)
class Host:
    """Data that all scenes of one program share, created once."""

    plan: Plan
    memory: Run
    space: pymunk.Space
    bodies: tuple[pymunk.Body, ...]
    scenes: Requested
    results: Results


def simulate(program: Program, scenes: Scenes, config: Config = DEFAULTS, jobs: int = 1) -> Outcomes:
    """Score all valid scenes; rows of invalid scenes have their verdict and NaN / -1.

    One core works for any `jobs`: a step of pymunk from Python is too short for threads to gain time.
    """
    del jobs
    host = _host(program, scenes, config, extra_samples=0)
    for row in np.flatnonzero(scenes.valid).tolist():
        _score(host, row)
    return outcomes(host.results)


def run(program: Program, scenes: Scenes, row: int = 0, config: Config = DEFAULTS) -> WorldRun:
    """Run one valid scene to its end and, after contact, until all struck bodies stand."""
    if not scenes.valid[row]:
        raise ArgumentError(f"scene {row} is not valid; only a valid one can be run", "`scenes.valid` tells which are")
    after = math.ceil(config.contact.aftermath / config.simulation.time_step) + 1
    host = _host(program, _one(scenes, row), config, extra_samples=after)
    scored_samples = samples = _score(host, 0)
    contact = host.memory.status[Status.CONTACT_ONE] >= 0
    scored, impacts, rest = outcomes(host.results), impacts_among_others(host.memory), {}
    last = samples - 1 if contact else -1
    touching = _touching(host.memory, last) if contact else None
    if contact:
        actors = physiques(host.plan.kinds, host.scenes.values[0])
        samples, later, rest = follow_contact(host.plan, host.memory, actors, config)
        impacts = (*impacts, *later)
    trajectory = Trajectory(
        time=np.arange(samples, dtype=np.float64) * config.simulation.time_step,
        states=host.memory.states[:samples].copy(),
        outlines=outlines(program, host.scenes.values[0]),
        contact_sample=last,
        watched=host.memory.watched[:scored_samples].copy(),
    )
    events = timeline(scored, trajectory, impacts, rest)
    return WorldRun(scored, trajectory, impacts, events, recorded(program, trajectory), touching)


def _touching(run: Run, sample: int) -> Floats:
    """Return the states of all actors at first contact, in the step after a sample: motion in a step is linear."""
    before, after = run.states[sample], run.states[sample + 1]
    touching = before + run.end[1] * (after - before)
    touching[:, State.PRESENT] = np.where(after[:, State.PRESENT] != 0.0, before[:, State.PRESENT], 0.0)
    return touching


def _host(program: Program, scenes: Scenes, config: Config, extra_samples: int) -> Host:
    rows, space = requested(program, scenes), new_space(config.contact)
    return Host(
        plan=plan(program, config.simulation, config.contact),
        memory=memory(program, samples_of(config.simulation) + 1 + extra_samples),
        space=space,
        bodies=tuple(carrier(space) for _ in program.actors),
        scenes=rows,
        results=empty_results(program, rows),
    )


def _score(host: Host, row: int) -> int:
    """Run one scene to first contact or its end and fill its row; return the number of samples up to then."""
    scenes, record = host.scenes, host.memory
    begin(host.plan, record, int(scenes.variant[row]), scenes.values[row], scenes.keys[row], scenes.actions[row])
    advance(host.plan, record, host.plan.layout.last_sample + 1, True)
    valid = note_end(record, row, host.results)
    samples = int(record.status[Status.SAMPLE]) + (0 if record.status[Status.CONTACT_ONE] >= 0 else 1)
    if host.results.verdict[row] == Verdict.ERROR:
        return samples
    carry(host.space, host.bodies, record.states, samples, host.plan.layout.time_step)
    if valid:
        outlines = np.zeros((len(host.bodies), 3))
        measure_run(host.plan, record, row, outlines, host.results)
        if len(host.plan.objective_root):
            note_objectives(host.plan, record, row, outlines, host.results)
    return samples


def _one(scenes: Scenes, row: int) -> Scenes:
    """Return the scenes with one row only."""
    return Scenes(**{field.name: getattr(scenes, field.name)[row : row + 1] for field in fields(Scenes)})
