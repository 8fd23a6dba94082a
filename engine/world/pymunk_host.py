"""The world host: one scene after another. The shared kernels drive; pymunk carries the poses and computes contacts.

`simulate` scores, so each scene ends at the ego's first contact; `run` continues through it to rest. Metrics are those
of the poses that pymunk carried, by the definitions of `engine.kernels.pair`. The timeline lists the events of a run
and the reason of its end.

After the ego's contact nothing is scored. Struck actors are free bodies; all other actors behave until they are struck,
too. A free body's velocity is never set again: it follows from impulses and friction. During an impact, the wheels of
its bodies roll, as in impacts between other actors; then they are braked until the body stands. A body that was free
before, from an impact between other actors, continues to roll.

All substeps of a step are equally long and end with its sample. In the step of contact they are `FIRST`: within a
longer substep a corner sinks so far into the other outline that pymunk takes the wrong face for the struck face. pymunk
starts each substep from the impulses of the substep before, scaled by the ratio of their lengths, but records them
unscaled; so they are discarded before the substeps become longer.
"""

import math
from dataclasses import dataclass, fields
from enum import StrEnum
from typing import NamedTuple

import numpy as np
import pymunk

from engine.config import Config
from engine.display import counted
from engine.errors import ArgumentError
from engine.host import empty_results, heights_of, memory, outcomes, outlines, plan, requested, samples_of
from engine.kernels.impacts.motion import PULSE, STILL, MotionSegment
from engine.kernels.pair import swung
from engine.kernels.rollout import advance, begin
from engine.kernels.rows import Requested, Results, note_results
from engine.kernels.run_state import HOSTED, POST_IMPACT, Memory, Plan, Run, Status
from engine.metrics import Recorded, recorded
from engine.outcomes import Outcomes
from engine.program import Program
from engine.scenes import Impact, Scenes, Trajectory
from engine.tables import Floats
from engine.vocabulary import LEVEL, ActorKind, EndReason, State
from engine.world.bodies import Physique, carrier, carry, new_space, physiques, rub, solid, wall
from engine.world.impacts import Recorder, impacts_among_others

# -- after the first contact -------------------------------------------------------------------------------------------

FIRST = 1e-4
"""Length of substeps in the step of contact [s]."""


class Aftermath(NamedTuple):
    """Result of the motion after a contact; the states themselves are in the run's record."""

    samples: int
    """Recorded samples, from the start of the run."""
    impacts: tuple[Impact, ...]
    rest: dict[int, float]
    """Time at which each struck actor came to rest for good [s]."""


class FreeBodies:
    """The bodies of one run after its first contact, with the set of free bodies."""

    def __init__(self, actors: tuple[Physique, ...], buildings: Floats, config: Config) -> None:
        self.actors = actors
        """Their bodies come first; those of the buildings follow."""
        # Substeps per step of the simulation, each not longer than the configured length.
        self.substeps = max(1, math.ceil(config.simulation.time_step / config.contact.substep - 1e-9))
        self.resistance = config.contact.rolling_resistance
        self.space = new_space(config.contact)
        walls = [wall(length, width) for length, width in buildings[:, 3:].tolist()]
        self.bodies = [solid(self.space, body, config.contact) for body in (*actors, *walls)]
        self.recorder = Recorder(self.space, self.bodies)
        self.free: set[int] = set()
        self.steer: dict[int, float] = {}
        """Steering angles of bodies on wheels [rad]."""
        self.rolls_until: dict[int, float] = {}
        """Times at which the wheels of free bodies are braked [s]."""
        self.rest: dict[int, float] = {}
        for number, building in enumerate(buildings, len(actors)):
            self.place(number, building)

    def place(self, actor: int, pose: Floats) -> None:
        """Put a body where its actor is."""
        body = self.bodies[actor]
        body.position, body.angle = (float(pose[0]), float(pose[1])), float(pose[2])
        self.space.reindex_shapes_for_body(body)

    def separate(self, actor: int, heights: Floats) -> None:
        """Let a body pass those of actors on other levels; `heights` [m] of all actors."""
        apart = np.flatnonzero(np.abs(heights - heights[actor]) >= LEVEL).tolist()
        self.recorder.apart |= {(min(actor, each), max(actor, each)) for each in apart}

    def turn_wheels(self, actor: int, steer: float) -> None:
        """Note where the wheels of a body point; two-wheelers fall over."""
        if self.actors[actor].rolls:
            self.steer[actor] = steer

    def release(self, actor: int, until: float) -> None:
        """Release a body to physics; its wheels roll until a time [s]. A fixed body stays in place."""
        if actor < len(self.actors) and not self.actors[actor].fixed:
            self.free.add(actor)
            self.rolls_until[actor] = until

    def drive(self, actor: int, chord: Floats) -> None:
        """Send a body that still behaves along a chord: vx, vy [m/s], turn [rad/s]."""
        body = self.bodies[actor]
        if not self.actors[actor].fixed:
            body.velocity, body.angular_velocity = (float(chord[0]), float(chord[1])), float(chord[2])

    def remove(self, actor: int) -> None:
        """Take an actor that has left the scene out of the space."""
        if self.bodies[actor] in self.space.bodies:
            self.space.remove(self.bodies[actor], *self.bodies[actor].shapes)

    def forget(self) -> None:
        """Let all contacts begin anew, with no impulses of the substep before."""
        for body in self.space.bodies:
            shapes = list(body.shapes)
            self.space.remove(*shapes)
            self.space.add(*shapes)

    def go(self, start: float, count: int, substep: float) -> None:
        """Let physics run for a number of substeps from a time on [s]."""
        for k in range(count):
            self.recorder.time = start + (k + 1) * substep
            self.space.step(substep)
            self.recorder.check()
            for actor in self.recorder.struck - self.free:
                self.release(actor, self.recorder.time + PULSE)
            for actor in sorted(self.free):
                self._rub(actor, substep)

    def _rub(self, actor: int, substep: float) -> None:
        steer = self.steer.get(actor) if self.recorder.time <= self.rolls_until[actor] else None
        if rub(self.bodies[actor], self.actors[actor], substep, steer, self.resistance):
            self.rest.setdefault(actor, self.recorder.time)
        else:
            self.rest.pop(actor, None)

    @property
    def at_rest(self) -> bool:
        """Return True if every free body stands."""
        return self.free <= self.rest.keys()


def follow_contact(plan: Plan, run: Run, actors: tuple[Physique, ...], config: Config) -> Aftermath:
    """Continue from first contact until all struck bodies stand, or for the configured time."""
    step, contact, sample = plan.layout.time_step, float(run.end[0]), int(run.status[Status.SAMPLE])
    stage = FreeBodies(actors, plan.road.buildings, config)
    short = max(stage.substeps, math.ceil(step / FIRST - 1e-9))
    done = min(math.floor(float(run.end[1]) * short), short - 1)
    _set_up(run, stage, sample, done / short, step)
    last = min(len(run.states) - 1, math.ceil((contact + config.contact.aftermath) / step))
    stage.go((sample - 1 + done / short) * step, short - done, step / short)
    stage.forget()
    _record(run, stage, sample, step)
    while sample < last and not (stage.at_rest and _others_stand(run, stage, sample)):
        advance(plan, run, sample + 1, False)
        sample += 1
        _send(run, stage, sample, step)
        stage.go((sample - 1) * step, stage.substeps, step / stage.substeps)
        _record(run, stage, sample, step)
    masses = tuple(math.inf if actor.fixed else actor.mass for actor in actors)
    return Aftermath(sample + 1, stage.recorder.impacts(masses), dict(stage.rest))


def _others_stand(run: Run, stage: FreeBodies, sample: int) -> bool:
    """Return True if no behaving actor moves, so that no further impact is possible."""
    others = [actor for actor in range(len(stage.actors)) if actor not in stage.free]
    states = run.states[sample, others]
    return not np.any((states[:, State.PRESENT] != 0.0) & (np.abs(states[:, State.SPEED]) > STILL))


def _set_up(run: Run, stage: FreeBodies, sample: int, part: float, step: float) -> None:
    """Place all bodies at a part of a step after the last sample before contact.

    The two that are about to touch get their true velocities and are free.
    """
    actors, before, after = stage.actors, run.states[sample - 1], run.states[sample]
    poses, chords = before[:, :3] + part * (after[:, :3] - before[:, :3]), (after[:, :3] - before[:, :3]) / step
    braked = float(run.end[0]) + PULSE
    pair = {int(run.status[Status.CONTACT_ONE]), int(run.status[Status.CONTACT_OTHER])}  # -1: a building
    for actor in range(len(actors)):
        stage.place(actor, poses[actor])
        stage.turn_wheels(actor, float(before[actor, State.STEER]))
        stage.separate(actor, run.actors[:, Memory.HEIGHT])
        if after[actor, State.PRESENT] == 0.0:
            stage.remove(actor)
        elif run.actors[actor, Memory.FREE] == POST_IMPACT:
            stage.drive(actor, run.segments[actor, MotionSegment.VX1 : MotionSegment.SPIN1 + 1])
            stage.release(actor, braked if actor in pair else math.inf)
        elif actor in pair:
            speed = before[actor, State.SPEED] + part * (after[actor, State.SPEED] - before[actor, State.SPEED])
            # Walkers turn at once, so the chord of their heading is no rate that they carry on with.
            turn = 0.0 if actors[actor].kind is ActorKind.PEDESTRIAN else chords[actor, 2]
            stage.drive(actor, np.array([*swung(poses[actor, 2], speed, actors[actor].rear_to_center * turn), turn]))
            stage.release(actor, braked)
        else:
            stage.drive(actor, chords[actor])
    run.actors[sorted(stage.free), Memory.FREE] = HOSTED


def _record(run: Run, stage: FreeBodies, sample: int, step: float) -> None:
    """Write the free bodies into the record; the kernels have written all other actors."""
    for actor in stage.free:
        run.actors[actor, Memory.FREE] = HOSTED
        body, row = stage.bodies[actor], run.states[sample, actor]
        before = run.states[sample - 1, actor]
        row[:] = before
        row[State.X], row[State.Y], row[State.HEADING] = body.position.x, body.position.y, body.angle
        row[State.SPEED] = body.velocity.x * math.cos(body.angle) + body.velocity.y * math.sin(body.angle)
        row[State.ACCELERATION] = (row[State.SPEED] - before[State.SPEED]) / step
        row[State.THROTTLE] = row[State.BRAKE] = 0.0
        row[State.PRESENT] = 1.0


def _send(run: Run, stage: FreeBodies, sample: int, step: float) -> None:
    """Send the bodies that still behave to their next sample."""
    before, after = run.states[sample - 1], run.states[sample]
    for actor in range(len(stage.actors)):
        if actor in stage.free:
            continue
        if after[actor, State.PRESENT] == 0.0:
            stage.remove(actor)
        else:
            stage.drive(actor, (after[actor, :3] - before[actor, :3]) / step)
            stage.turn_wheels(actor, float(before[actor, State.STEER]))


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
        if 0.0 < distance < np.inf and np.isfinite(time)
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
        samples, impacts = counted(len(self.trajectory.time), "sample"), counted(len(self.impacts), "impact")
        return f"WorldRun({scored}; {samples}, {impacts})"


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
        heights=heights_of(host.plan.road, host.plan.kinds, host.memory.states[:samples]),
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
    note_results(host.plan, record, row, np.zeros((len(host.bodies), 3)), host.results)
    samples = int(record.status[Status.SAMPLE]) + (0 if record.status[Status.CONTACT_ONE] >= 0 else 1)
    if record.status[Status.END] not in (EndReason.BROKEN, EndReason.STUCK):
        carry(host.space, host.bodies, record.states, samples, host.plan.layout.time_step)
    return samples


def _one(scenes: Scenes, row: int) -> Scenes:
    """Return the scenes with one row only."""
    return Scenes(**{field.name: getattr(scenes, field.name)[row : row + 1] for field in fields(Scenes)})
