"""Motion after the ego's contact: struck actors are free bodies, all other actors behave until they are struck, too.

Nothing here is scored. A free body's velocity is never set again: it follows from impulses and friction. During an
impact, the wheels of its bodies roll, as in impacts between other actors; then they are braked until the body stands. A
body that was free before, from an impact between other actors, continues to roll.

All substeps of a step are equally long and end with its sample. In the step of contact they are `FIRST`: within a
longer substep a corner sinks so far into the other outline that pymunk takes the wrong face for the struck face. pymunk
starts each substep from the impulses of the substep before, scaled by the ratio of their lengths, but records them
unscaled; so they are discarded before the substeps become longer.
"""

import math
from typing import NamedTuple

import numpy as np

from engine.config import Config
from engine.kernels.impacts.motion import PULSE, STILL, MotionSegment
from engine.kernels.pair import swung
from engine.kernels.rollout import advance
from engine.kernels.run_state import HOSTED, POST_IMPACT, Memory, Plan, Run, Status
from engine.scenes import Impact
from engine.tables import Floats
from engine.vocabulary import ActorKind, State
from engine.world.bodies import Physique, new_space, rub, solid, wall
from engine.world.impacts import Recorder

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
