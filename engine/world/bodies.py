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
from engine.kernels.impacts.motion import (
    Dimensions,
    GroundContact,
    RigidMotion,
    after_friction,
    ground_contact,
    has_axles,
)
from engine.kernels.impacts.solver import is_fixed
from engine.tables import Floats, Ints
from engine.vehicles import MODELS
from engine.vocabulary import ActorKind, Column, State

SOLVER_ITERATIONS = 50
"""Iterations of the contact solver per substep; pymunk's 10 give a head-on restitution of 0.16 for 0.15."""


@dataclass(frozen=True)
class Physique:
    """Properties of an actor for contact physics. SI units."""

    kind: ActorKind
    length: float
    width: float
    mass: float
    inertia: float
    """Moment of inertia about the vertical axis through the centre [kg m^2]."""
    rear_to_center: float
    supports: GroundContact
    """Contact with the road while it slides, with braked wheels."""
    fixed: bool
    """True for an immovable body."""

    @property
    def rolls(self) -> bool:
        """Return True if it stays on wheels that roll without a driver."""
        return has_axles(int(self.kind))


def physiques(kinds: Ints, values: Floats) -> tuple[Physique, ...]:
    """Return all actors of one scene, from its row of scene values."""
    columns = values[: len(kinds) * len(Column)].reshape(len(kinds), len(Column))
    return tuple(physique(ActorKind(kind), row) for kind, row in zip(kinds, columns.tolist(), strict=True))


def physique(kind: ActorKind, columns: Sequence[float]) -> Physique:
    """Return one actor from its `Column`s. The kind's inertia scales with mass and size as that of a rectangle."""
    length, width, mass = columns[Column.LENGTH], columns[Column.WIDTH], columns[Column.MASS]
    behind, base, friction = (columns[each] for each in (Column.REAR_TO_CENTER, Column.WHEELBASE, Column.FRICTION))
    supports = ground_contact(False, Dimensions(length, width, base, behind), friction, 0.0, 0.0, MODELS[kind].gyration)
    return Physique(
        kind=kind,
        length=length,
        width=width,
        mass=mass,
        inertia=mass * supports.gyration,
        rear_to_center=behind,
        supports=supports,
        fixed=is_fixed(columns[Column.FIXED], mass),
    )


def wall(length: float, width: float) -> Physique:
    """Return a building."""
    still = ground_contact(False, Dimensions(length, width, 0.0, 0.0), 0.0, 0.0, 0.0, 1.0)
    return Physique(ActorKind.OBSTACLE, length, width, math.inf, math.inf, 0.0, still, fixed=True)


def new_space(config: ContactConfig) -> pymunk.Space:
    """Return an empty plane without gravity or damping.

    pymunk's own values of two settings are wrong for cars: contacts stored for 3 steps replay old impulses, and a slop
    of 0.1 lets outlines rest 10 cm inside each other.
    """
    space = pymunk.Space()
    space.collision_persistence = config.collision_persistence
    space.collision_slop = config.collision_slop
    space.iterations = SOLVER_ITERATIONS
    return space


def carrier(space: pymunk.Space) -> pymunk.Body:
    """Add and return a body without a shape: it carries a pose and touches nothing."""
    body = pymunk.Body(1.0, 1.0)
    space.add(body)
    return body


def solid(space: pymunk.Space, actor: Physique, config: ContactConfig) -> pymunk.Body:
    """Add and return a body with its outline. pymunk multiplies the coefficients of two shapes, hence the roots."""
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
"""Largest error of pymunk's final pose [m, rad]; the usual error is about 1e-13."""


def carry(space: pymunk.Space, bodies: Sequence[pymunk.Body], states: Floats, samples: int, time_step: float) -> None:
    """Move the bodies through the poses of the first `samples` rows of `states`, which then become pymunk's own poses.

    Velocities are only written; the resulting poses are read afterwards.
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


def rub(
    body: pymunk.Body, actor: Physique, duration: float, steer: float | None = None, resistance: float = 0.0
) -> bool:
    """Apply the friction of a time [s] to a free body, as `kernels.impacts.motion` does; return True if it stands.

    With the angle `steer` of the front wheels, wheels roll with a `resistance`, a share of the weight; without it they
    are braked.
    """
    rolls = steer is not None
    front = actor.supports.front._replace(steer=steer or 0.0)
    supports = actor.supports._replace(rolls=rolls, front=front, rolling=resistance * GRAVITY)
    (x, y), velocity = body.position, body.velocity
    after = after_friction(
        RigidMotion(x, y, body.angle, velocity.x, velocity.y, body.angular_velocity), supports, duration
    )
    body.velocity, body.angular_velocity = (after.vx, after.vy), after.spin
    return after.vx == 0.0 and after.vy == 0.0 and after.spin == 0.0
