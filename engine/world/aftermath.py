"""From first contact on: those who touched are free bodies, the others go on behaving until they are struck, too.

Nothing here is scored. A free body's velocity is never set again: it is what impulses and friction make of it.
"""

import math
from typing import NamedTuple

import numpy as np

from engine.config import Config
from engine.kernels.rollout import advance
from engine.kernels.stage import Plan, Run, Slot, Status
from engine.tables import Floats
from engine.vocabulary import State
from engine.world.bodies import Physique, new_space, solid
from engine.world.friction import rub
from engine.world.impacts import Impact, Recorder


class Aftermath(NamedTuple):
    """What followed a contact; the states themselves are in the run's record."""

    samples: int
    """Recorded samples, from the start of the run."""
    impacts: tuple[Impact, ...]
    rest: dict[int, float]
    """When each struck actor came to rest for good [s]."""


class Stage:
    """The bodies of one run after its first contact, and who of them is free."""

    def __init__(self, actors: tuple[Physique, ...], config: Config) -> None:
        self.actors = actors
        self.space = new_space(config.contact)
        self.bodies = [solid(self.space, actor, config.contact) for actor in actors]
        self.recorder = Recorder(self.space, self.bodies)
        self.substep = config.contact.substep
        self.free: set[int] = set()
        self.rest: dict[int, float] = {}

    def place(self, actor: int, pose: Floats) -> None:
        """Put a body where its actor is."""
        body = self.bodies[actor]
        body.position, body.angle = (float(pose[0]), float(pose[1])), float(pose[2])
        self.space.reindex_shapes_for_body(body)

    def release(self, actor: int) -> None:
        """Hand a body over to physics; what is fixed stays where it is."""
        if not self.actors[actor].fixed:
            self.free.add(actor)

    def drive(self, actor: int, chord: Floats) -> None:
        """Send a body that still behaves along a chord: vx, vy [m/s], turn [rad/s]."""
        body = self.bodies[actor]
        if not self.actors[actor].fixed:
            body.velocity, body.angular_velocity = (float(chord[0]), float(chord[1])), float(chord[2])

    def remove(self, actor: int) -> None:
        """Take an actor that has left the scene out of the space."""
        if self.bodies[actor] in self.space.bodies:
            self.space.remove(self.bodies[actor], *self.bodies[actor].shapes)

    def go(self, start: float, end: float) -> None:
        """Let physics run from one time to another [s], in equal substeps no longer than the chosen one."""
        count = max(1, math.ceil((end - start) / self.substep - 1e-9))
        duration = (end - start) / count
        for k in range(count):
            self.recorder.time = start + (k + 1) * duration
            self.space.step(duration)
            self.recorder.check()
            for actor in self.recorder.struck - self.free:
                self.release(actor)
            for actor in sorted(self.free):
                self._rub(actor, duration)

    def _rub(self, actor: int, duration: float) -> None:
        if rub(self.bodies[actor], self.actors[actor], duration):
            self.rest.setdefault(actor, self.recorder.time)
        else:
            self.rest.pop(actor, None)

    @property
    def at_rest(self) -> bool:
        """Whether every free body stands still."""
        return self.free <= self.rest.keys()


def follow_contact(plan: Plan, run: Run, actors: tuple[Physique, ...], config: Config) -> Aftermath:
    """Go on from first contact until all that were struck stand still, or for the configured time."""
    step, contact = plan.layout.time_step, float(run.end[0])
    stage = _at_contact(run, actors, step, config)
    run.actors[sorted(stage.free), Slot.FREE] = 1.0
    start, sample = contact, int(run.status[Status.SAMPLE])
    last = min(len(run.states) - 1, math.ceil((contact + config.contact.aftermath) / step))
    while True:
        stage.go(start, sample * step)
        _record(run, stage, sample, step)
        if sample >= last or stage.at_rest:
            break
        advance(plan, run, sample + 1, False)
        start, sample = sample * step, sample + 1
        _send(run, stage, sample, step)
    masses = tuple(math.inf if actor.fixed else actor.mass for actor in actors)
    return Aftermath(sample + 1, stage.recorder.impacts(masses), dict(stage.rest))


def _at_contact(run: Run, actors: tuple[Physique, ...], step: float, config: Config) -> Stage:
    """All bodies where they are at the instant of contact; the two that touch with their true velocities."""
    stage = Stage(actors, config)
    sample, part = int(run.status[Status.SAMPLE]), float(run.end[1])
    before, after = run.states[sample - 1], run.states[sample]
    poses, chords = before[:, :3] + part * (after[:, :3] - before[:, :3]), (after[:, :3] - before[:, :3]) / step
    pair = {int(run.status[Status.CONTACT_ONE]), int(run.status[Status.CONTACT_OTHER])}
    for actor in range(len(actors)):
        stage.place(actor, poses[actor])
        if after[actor, State.PRESENT] == 0.0:
            stage.remove(actor)
        elif actor in pair:
            speed = before[actor, State.SPEED] + part * (after[actor, State.SPEED] - before[actor, State.SPEED])
            stage.drive(actor, true_velocity(poses[actor, 2], speed, chords[actor, 2], actors[actor].rear_to_center))
            stage.release(actor)
        else:
            stage.drive(actor, chords[actor])
    return stage


def true_velocity(heading: float, speed: float, turn: float, rear_to_center: float) -> Floats:
    """Velocity of the centre and yaw rate: vx, vy, turn; `speed` is the rear axle's."""
    cos, sin, swing = math.cos(heading), math.sin(heading), rear_to_center * turn
    return np.array([speed * cos - swing * sin, speed * sin + swing * cos, turn])


def _record(run: Run, stage: Stage, sample: int, step: float) -> None:
    """Write the free bodies into the record; the others have been written by the kernels."""
    for actor in stage.free:
        run.actors[actor, Slot.FREE] = 1.0
        body, row = stage.bodies[actor], run.states[sample, actor]
        before = run.states[sample - 1, actor]
        row[:] = before
        row[State.X], row[State.Y], row[State.HEADING] = body.position.x, body.position.y, body.angle
        row[State.SPEED] = body.velocity.x * math.cos(body.angle) + body.velocity.y * math.sin(body.angle)
        row[State.ACCELERATION] = (row[State.SPEED] - before[State.SPEED]) / step
        row[State.THROTTLE] = row[State.BRAKE] = 0.0
        row[State.PRESENT] = 1.0


def _send(run: Run, stage: Stage, sample: int, step: float) -> None:
    """Send the bodies that still behave to their next sample."""
    before, after = run.states[sample - 1], run.states[sample]
    for actor in range(len(stage.actors)):
        if actor in stage.free:
            continue
        if after[actor, State.PRESENT] == 0.0:
            stage.remove(actor)
        else:
            stage.drive(actor, (after[actor, :3] - before[actor, :3]) / step)
