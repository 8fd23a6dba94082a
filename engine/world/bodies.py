"""Actors as rigid bodies: an outline with mass and yaw inertia, its centre of gravity at the outline's centre.

Before contact, pymunk carries the poses that the shared kernels drive: each step it gets the chord velocity. A body
that slides is rubbed by the road: Coulomb friction at its two axles.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pymunk

from engine.config import ContactConfig
from engine.kernels.bicycle import GRAVITY
from engine.tables import Floats, Ints
from engine.vehicles import MODELS
from engine.vocabulary import ActorKind, Column, State

SOLVER_ITERATIONS = 50
"""Of the contact solver a substep; pymunk's 10 leave a head-on restitution of 0.15 at 0.16."""


@dataclass(frozen=True)
class Axle:
    """Where a body rubs on the road once it slides."""

    offset: float
    """Ahead of the centre [m]."""
    load: float
    """What friction can bear there, mu times the weight on it [N]."""


@dataclass(frozen=True)
class Physique:
    """What contact physics needs to know of an actor. SI units."""

    kind: ActorKind
    length: float
    width: float
    mass: float
    inertia: float
    """About the vertical axis through the centre [kg m^2]."""
    rear_to_center: float
    axles: tuple[Axle, Axle]
    fixed: bool
    """Whether nothing moves it."""

    @property
    def rolls(self) -> bool:
        """Whether it stays on wheels that roll when nobody drives: two-wheelers fall over."""
        return self.kind in (ActorKind.CAR, ActorKind.TRUCK, ActorKind.BUS)


def physiques(kinds: Ints, values: Floats) -> tuple[Physique, ...]:
    """All actors of one scene, from its row of scene values."""
    columns = values[: len(kinds) * len(Column)].reshape(len(kinds), len(Column))
    return tuple(physique(ActorKind(kind), row) for kind, row in zip(kinds, columns.tolist(), strict=True))


def physique(kind: ActorKind, columns: Sequence[float]) -> Physique:
    """One actor from its `Column`s. The kind's inertia grows with mass and size as that of a rectangle does."""
    model = MODELS[kind]
    length, width, mass = columns[Column.LENGTH], columns[Column.WIDTH], columns[Column.MASS]
    size = (length**2 + width**2) / (model.length**2 + model.width**2)
    return Physique(
        kind=kind,
        length=length,
        width=width,
        mass=mass,
        inertia=model.yaw_inertia * mass / model.mass * size,
        rear_to_center=columns[Column.REAR_TO_CENTER],
        axles=_axles(columns),
        fixed=columns[Column.FIXED] != 0.0 or not 0.0 < mass < math.inf,
    )


def wall(length: float, width: float) -> Physique:
    """A building."""
    still = Axle(0.0, 0.0)
    return Physique(ActorKind.OBSTACLE, length, width, math.inf, math.inf, 0.0, (still, still), fixed=True)


def _axles(columns: Sequence[float]) -> tuple[Axle, Axle]:
    """Rear and front axle with their static loads; what has no wheels rubs a quarter of its length from the centre."""
    weight = columns[Column.FRICTION] * columns[Column.MASS] * GRAVITY
    behind, base = columns[Column.REAR_TO_CENTER], columns[Column.WHEELBASE]
    if not 0.0 < behind < base:
        quarter = 0.25 * columns[Column.LENGTH]
        return Axle(-quarter, 0.5 * weight), Axle(quarter, 0.5 * weight)
    return Axle(-behind, weight * (base - behind) / base), Axle(base - behind, weight * behind / base)


def new_space(config: ContactConfig) -> pymunk.Space:
    """An empty plane without gravity or damping.

    Of the two settings, pymunk's own values are wrong for cars: contacts kept for 3 steps replay old impulses, and
    a slop of 0.1 lets outlines rest 10 cm inside one another.
    """
    space = pymunk.Space()
    space.collision_persistence = config.collision_persistence
    space.collision_slop = config.collision_slop
    space.iterations = SOLVER_ITERATIONS
    return space


def carrier(space: pymunk.Space) -> pymunk.Body:
    """A body without a shape: it carries a pose and touches nothing."""
    body = pymunk.Body(1.0, 1.0)
    space.add(body)
    return body


def solid(space: pymunk.Space, actor: Physique, config: ContactConfig) -> pymunk.Body:
    """A body with its outline. pymunk multiplies the coefficients of two shapes, hence the roots."""
    body = pymunk.Body(body_type=pymunk.Body.STATIC) if actor.fixed else pymunk.Body(actor.mass, actor.inertia)
    shape = pymunk.Poly.create_box(body, (actor.length, actor.width))
    shape.elasticity = math.sqrt(config.restitution)
    shape.friction = math.sqrt(config.friction)
    space.add(body, shape)
    return body


# -- before contact ----------------------------------------------------------------------------------------------------

POSE = [State.X, State.Y, State.HEADING]
# pymunk checks the name at every `body.name = value`, which costs as much as the rest of a write; setters do not.
set_velocity = pymunk.Body.__dict__["velocity"].fset
set_spin = pymunk.Body.__dict__["angular_velocity"].fset

LANDING = 1e-9
"""How far pymunk may land from where it was sent [m, rad]; it lands within some 1e-13."""


def carry(space: pymunk.Space, bodies: Sequence[pymunk.Body], states: Floats, samples: int, time_step: float) -> None:
    """Take the bodies through the poses of the first `samples` rows of `states`; then those are pymunk's own poses.

    Velocities are only written: what pymunk makes of them is read when it has landed.
    """
    driven = states[:samples, :, POSE]
    chords = np.diff(driven, axis=0) / time_step
    for body, (x, y, heading) in zip(bodies, driven[0].tolist(), strict=True):
        body.position, body.angle = (x, y), heading
    landed: list[tuple[float, float, float]] = []
    step, note = space.step, landed.append
    for chord in chords.tolist():
        for body, (vx, vy, turn) in zip(bodies, chord, strict=True):
            set_velocity(body, (vx, vy))
            set_spin(body, turn)
        step(time_step)
        for body in bodies:
            position = body.position
            note((position.x, position.y, body.angle))
    poses = np.array(landed).reshape(len(chords), len(bodies), 3)
    if not np.all(np.abs(poses - driven[1:]) <= LANDING):
        raise RuntimeError(f"pymunk left the driven path by {np.abs(poses - driven[1:]).max():.3g}")
    states[1:samples, :, POSE] = poses


# -- friction of the road ----------------------------------------------------------------------------------------------

REST_SPEED = 0.01
"""A body slower than this stands still [m/s]; so does one that turns no faster, in rad/s."""


def rub(
    body: pymunk.Body, actor: Physique, duration: float, steer: float | None = None, resistance: float = 0.0
) -> bool:
    """Slow a free body down for a time [s]; whether it stands still afterwards.

    Each axle in turn gets an impulse against its own motion, at most its load times the duration and at most what
    stops it there, so that friction never reverses a motion and energy never rises. Of one whose wheels roll, with the
    front ones at the angle `steer`, it is against the motion across the wheels; along them there is the resistance of
    rolling, a share of the weight (`kernels.coasting`).
    """
    (vx, vy), spin = body.velocity, body.angular_velocity
    cos, sin = math.cos(body.angle), math.sin(body.angle)
    for axle, turned in zip(actor.axles, (0.0, steer or 0.0), strict=True):
        motion, friction = (vx, vy, spin), axle.load * duration
        if steer is None:
            vx, vy, spin = _resist(axle, actor, (cos, sin), None, motion, friction)
        else:
            wheel = cos * math.cos(turned) - sin * math.sin(turned), sin * math.cos(turned) + cos * math.sin(turned)
            motion = _resist(axle, actor, (cos, sin), (-wheel[1], wheel[0]), motion, friction)
            rolling = 0.5 * resistance * actor.mass * GRAVITY * duration
            vx, vy, spin = _resist(axle, actor, (cos, sin), wheel, motion, rolling)
    still = vx * vx + vy * vy < REST_SPEED**2 and abs(spin) < REST_SPEED
    body.velocity, body.angular_velocity = ((0.0, 0.0), 0.0) if still else ((vx, vy), spin)
    return still


def _resist(
    axle: Axle,
    actor: Physique,
    heading: tuple[float, float],
    along: tuple[float, float] | None,
    motion: tuple[float, float, float],
    limit: float,
) -> tuple[float, float, float]:
    """Velocity and spin after an impulse at an axle against its motion along a direction (None: all of its motion), at
    most what stops it there and at most the limit [N s].
    """
    vx, vy, spin = motion
    arm_x, arm_y = axle.offset * heading[0], axle.offset * heading[1]
    x, y = vx - spin * arm_y, vy + spin * arm_x
    if along is not None:
        speed, (x, y) = x * along[0] + y * along[1], along
    elif speed := math.hypot(x, y):
        x, y = x / speed, y / speed
    lever = arm_x * y - arm_y * x
    stopping = speed / (1.0 / actor.mass + lever * lever / actor.inertia)
    impulse = min(limit, max(-limit, stopping))
    return vx - impulse * x / actor.mass, vy - impulse * y / actor.mass, spin - impulse * lever / actor.inertia
