"""From first contact on: those who touched are free bodies, the others go on behaving until they are struck, too.

Nothing here is scored. A free body's velocity is never set again: it is what impulses and friction make of it.

All substeps are equally long and end with the samples. pymunk starts each from the impulses of the one before, scaled
by the ratio of their lengths, but books them unscaled: after a short substep in contact, a longer one would add up to
several times the impulse again. So physics starts at the last substep boundary before contact. An `Impact` is what a
meeting of two bodies did to them.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import pymunk

from engine.config import Config
from engine.kernels.rollout import advance
from engine.kernels.stage import Plan, Run, Slot, Status
from engine.tables import Floats
from engine.vocabulary import ActorKind, State
from engine.world.bodies import REST_SPEED, Physique, new_space, rub, solid

# -- impacts -----------------------------------------------------------------------------------------------------------

LEAST_CHANGE = 0.01
"""Of a velocity, for a touch to be told as an impact [m/s]."""
PAUSE = 0.05
"""Two bodies that part and meet again sooner than this are still in the same impact [s]."""


@dataclass(frozen=True)
class Impact:
    """One impact between two actors. Pairs of values belong to the lower actor and to the other."""

    time: float
    """When the bodies met [s]."""
    actors: tuple[int, int]
    point: tuple[float, float]
    """Where they met, x, y [m]."""
    delta_v: tuple[float, float]
    """Change of each one's velocity by the impulses of this impact, as a magnitude [m/s]; 0 for what is fixed."""
    direction: tuple[float, float]
    """Direction of each change in the body's frame when they met [rad, anticlockwise from its heading]."""
    closing_speed: float
    """Magnitude of the difference between the centres' velocities when they met [m/s]."""
    impact_angle: float
    """Heading of the other seen from the lower actor's, in [-pi, pi) [rad]; 0: the same way, pi: head on."""
    clock: tuple[int, int]
    """Where on each outline: the direction from its centre, as on a dial with 12 straight ahead and 3 to the right."""


@dataclass
class Meeting:
    """An impact that may still be going on. `impulse` is what the other body has received so far [N s]."""

    time: float
    last: float
    pair: tuple[int, int]
    point: tuple[float, float]
    poses: tuple[tuple[float, float, float], tuple[float, float, float]]
    velocity: tuple[float, float]
    """Of the other body relative to the lower one, before [m/s]."""
    impulse: list[float] = field(default_factory=lambda: [0.0, 0.0])


class Recorder:
    """Notes all impacts of a space. Bodies are known by their order, which is that of the actors.

    pymunk prints an exception raised inside a callback and goes on; so callbacks keep the first one, and `check`
    raises it after the step.
    """

    def __init__(self, space: pymunk.Space, bodies: list[pymunk.Body]) -> None:
        self.time = 0.0
        self.struck: set[int] = set()
        """Actors that have been touched by anything."""
        self._number = {body: number for number, body in enumerate(bodies)}
        self._open: dict[tuple[int, int], Meeting] = {}
        self._closed: list[Meeting] = []
        self._failure: Exception | None = None
        space.on_collision(begin=self._guarded(self._begin), post_solve=self._guarded(self._post_solve))

    def check(self) -> None:
        """Raise what went wrong in a callback of the last step."""
        if self._failure is not None:
            raise self._failure

    def impacts(self, masses: tuple[float, ...], least_change: float = LEAST_CHANGE) -> tuple[Impact, ...]:
        """All impacts so far, in the order of time; touches that change no velocity by `least_change` are none."""
        meetings = [*self._closed, *self._open.values()]
        told = (_impact(meeting, masses) for meeting in sorted(meetings, key=lambda m: (m.time, m.pair)))
        return tuple(impact for impact in told if max(impact.delta_v) >= least_change)

    def _guarded(self, callback: Callable[[pymunk.Arbiter], None]) -> Callable[..., None]:
        def call(arbiter: pymunk.Arbiter, _space: pymunk.Space, _data: object) -> None:
            try:
                callback(arbiter)
            except Exception as failure:
                self._failure = self._failure or failure

        return call

    def _pair(self, arbiter: pymunk.Arbiter) -> tuple[int, int, bool]:
        """Lower actor, other actor, and whether pymunk has them the other way round."""
        one, other = (self._number[body] for body in arbiter.bodies)
        return (one, other, False) if one < other else (other, one, True)

    def _begin(self, arbiter: pymunk.Arbiter) -> None:
        low, high, swapped = self._pair(arbiter)
        self.struck |= {low, high}
        earlier = self._open.get((low, high))
        if earlier is not None:
            if self.time - earlier.last <= PAUSE:
                return
            self._closed.append(earlier)
        bodies = arbiter.bodies[::-1] if swapped else arbiter.bodies
        points = [point.point_a for point in arbiter.contact_point_set.points]
        velocity = bodies[1].velocity - bodies[0].velocity
        self._open[low, high] = Meeting(
            time=self.time,
            last=self.time,
            pair=(low, high),
            point=(sum(p.x for p in points) / len(points), sum(p.y for p in points) / len(points)),
            poses=(_pose(bodies[0]), _pose(bodies[1])),
            velocity=(velocity.x, velocity.y),
        )

    def _post_solve(self, arbiter: pymunk.Arbiter) -> None:
        low, high, swapped = self._pair(arbiter)
        meeting = self._open[low, high]
        x, y = arbiter.total_impulse  # what the first of `arbiter.bodies` received
        sign = 1.0 if swapped else -1.0
        meeting.impulse[0] += sign * x
        meeting.impulse[1] += sign * y
        meeting.last = self.time


def _pose(body: pymunk.Body) -> tuple[float, float, float]:
    return body.position.x, body.position.y, body.angle


def _impact(meeting: Meeting, masses: tuple[float, ...]) -> Impact:
    low, high = meeting.pair
    headings = meeting.poses[0][2], meeting.poses[1][2]
    x, y = meeting.impulse
    size = math.hypot(x, y)
    received = math.atan2(-y, -x), math.atan2(y, x)
    return Impact(
        time=meeting.time,
        actors=meeting.pair,
        point=meeting.point,
        delta_v=(size / masses[low], size / masses[high]),
        direction=(_wrap(received[0] - headings[0]), _wrap(received[1] - headings[1])),
        closing_speed=math.hypot(*meeting.velocity),
        impact_angle=_wrap(headings[1] - headings[0]),
        clock=(clock_position(meeting.point, meeting.poses[0]), clock_position(meeting.point, meeting.poses[1])),
    )


def clock_position(point: tuple[float, float], pose: tuple[float, float, float]) -> int:
    """Direction of a point from a body's centre as an hour, 12 straight ahead and 3 to the right."""
    angle = math.atan2(point[1] - pose[1], point[0] - pose[0]) - pose[2]
    return (round(-angle / (math.pi / 6.0)) - 1) % 12 + 1


def _wrap(angle: float) -> float:
    """The angle brought into [-pi, pi)."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


# -- free bodies -------------------------------------------------------------------------------------------------------


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
        # So many to a step of the simulation, each no longer than the configured length.
        self.substeps = max(1, math.ceil(config.simulation.time_step / config.contact.substep - 1e-9))
        self.substep = config.simulation.time_step / self.substeps
        self.space = new_space(config.contact)
        self.bodies = [solid(self.space, actor, config.contact) for actor in actors]
        self.recorder = Recorder(self.space, self.bodies)
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

    def go(self, start: float, count: int) -> None:
        """Let physics run for a number of substeps from a time on [s]."""
        for k in range(count):
            self.recorder.time = start + (k + 1) * self.substep
            self.space.step(self.substep)
            self.recorder.check()
            for actor in self.recorder.struck - self.free:
                self.release(actor)
            for actor in sorted(self.free):
                self._rub(actor)

    def _rub(self, actor: int) -> None:
        if rub(self.bodies[actor], self.actors[actor], self.substep):
            self.rest.setdefault(actor, self.recorder.time)
        else:
            self.rest.pop(actor, None)

    @property
    def at_rest(self) -> bool:
        """Whether every free body stands still."""
        return self.free <= self.rest.keys()


def follow_contact(plan: Plan, run: Run, actors: tuple[Physique, ...], config: Config) -> Aftermath:
    """Go on from first contact until all that were struck stand still, or for the configured time."""
    step, contact, sample = plan.layout.time_step, float(run.end[0]), int(run.status[Status.SAMPLE])
    stage = Stage(actors, config)
    done = min(math.floor(float(run.end[1]) * stage.substeps), stage.substeps - 1)
    _set_up(run, stage, sample, done / stage.substeps, step)
    last = min(len(run.states) - 1, math.ceil((contact + config.contact.aftermath) / step))
    stage.go((sample - 1) * step + done * stage.substep, stage.substeps - done)
    _record(run, stage, sample, step)
    while sample < last and not (stage.at_rest and _others_stand(run, stage, sample)):
        advance(plan, run, sample + 1, False)
        sample += 1
        _send(run, stage, sample, step)
        stage.go((sample - 1) * step, stage.substeps)
        _record(run, stage, sample, step)
    masses = tuple(math.inf if actor.fixed else actor.mass for actor in actors)
    return Aftermath(sample + 1, stage.recorder.impacts(masses), dict(stage.rest))


def _others_stand(run: Run, stage: Stage, sample: int) -> bool:
    """Whether nobody who still behaves is on the move, so that nothing more can happen."""
    others = [actor for actor in range(len(stage.actors)) if actor not in stage.free]
    states = run.states[sample, others]
    return not np.any((states[:, State.PRESENT] != 0.0) & (states[:, State.SPEED] > REST_SPEED))


def _set_up(run: Run, stage: Stage, sample: int, part: float, step: float) -> None:
    """All bodies where they are a part of a step after the last sample before contact; the two that are about to
    touch get their true velocities and are free.
    """
    actors, before, after = stage.actors, run.states[sample - 1], run.states[sample]
    poses, chords = before[:, :3] + part * (after[:, :3] - before[:, :3]), (after[:, :3] - before[:, :3]) / step
    pair = {int(run.status[Status.CONTACT_ONE]), int(run.status[Status.CONTACT_OTHER])}
    for actor in range(len(actors)):
        stage.place(actor, poses[actor])
        if after[actor, State.PRESENT] == 0.0:
            stage.remove(actor)
        elif actor in pair:
            speed = before[actor, State.SPEED] + part * (after[actor, State.SPEED] - before[actor, State.SPEED])
            # Walkers turn at once, so the chord of their heading is no rate that they carry on with.
            turn = 0.0 if actors[actor].kind is ActorKind.PEDESTRIAN else chords[actor, 2]
            stage.drive(actor, true_velocity(poses[actor, 2], speed, turn, actors[actor].rear_to_center))
            stage.release(actor)
        else:
            stage.drive(actor, chords[actor])
    run.actors[sorted(stage.free), Slot.FREE] = 1.0


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
