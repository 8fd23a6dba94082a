"""Properties of an actor that metrics need: size, mass, pedals, grip."""

import math
from dataclasses import dataclass

import numpy as np

from engine.kernels.bicycle import GRAVITY
from engine.program import Program
from engine.scenes import actor_columns
from engine.tables import Floats
from engine.vehicles import MODELS, ActorModel
from engine.vocabulary import ActorKind, Column

WITHOUT_WHEELS = (ActorKind.PEDESTRIAN, ActorKind.OBSTACLE)


@dataclass(frozen=True)
class Body:
    """One actor. SI units."""

    kind: ActorKind
    length: float
    width: float
    rear_to_center: float
    """Distance of the centre ahead of the rear axle [m]."""
    mass: float
    """[kg]; infinite for a fixed body."""
    max_acceleration: float
    """Acceleration at full throttle [m/s^2]."""
    max_braking: float
    """Deceleration at full pedal [m/s^2]."""
    friction: float
    """Coefficient of friction between tyre and road."""
    top_speed: float

    @property
    def grip(self) -> float:
        """Return the largest acceleration that its tyres can transmit in any direction [m/s^2]; its legs, for a
        pedestrian.
        """
        if self.kind in WITHOUT_WHEELS:
            return max(self.max_acceleration, self.max_braking)
        return self.friction * GRAVITY

    @property
    def braking(self) -> float:
        """Return the hardest braking that brakes and tyres allow [m/s^2]."""
        return min(self.max_braking, self.grip)

    @property
    def acceleration(self) -> float:
        """Return the hardest acceleration that motor and tyres allow [m/s^2]."""
        return min(self.max_acceleration, self.grip)


def bodies_of(program: Program, values: Floats) -> tuple[Body, ...]:
    """Return all actors of one scene; `values` is its row of scene values."""
    kinds: list[int] = program.code.actor_kind.tolist()
    return tuple(_body(ActorKind(kind), row) for kind, row in zip(kinds, actor_columns(program, values), strict=True))


def _body(kind: ActorKind, row: Floats) -> Body:
    return Body(
        kind,
        float(row[Column.LENGTH]),
        float(row[Column.WIDTH]),
        float(row[Column.REAR_TO_CENTER]),
        math.inf if row[Column.FIXED] != 0.0 else float(row[Column.MASS]),
        float(row[Column.MAX_ACCELERATION]),
        float(row[Column.MAX_BRAKING]),
        float(row[Column.FRICTION]),
        float(row[Column.TOP_SPEED]),
    )


def usual_body(kind: ActorKind, length: float, width: float) -> Body:
    """Return a body with the usual properties of its kind and size; its centre moves along its heading."""
    model: ActorModel = MODELS[kind]
    return Body(
        kind,
        length,
        width,
        0.0,
        model.mass,
        model.max_acceleration,
        model.max_braking,
        model.friction,
        model.top_speed,
    )


def outlines_of(bodies: tuple[Body, ...]) -> Floats:
    """Return (actors, 3) length, width, distance from rear axle to centre [m], as kernels read them."""
    return np.array([[body.length, body.width, body.rear_to_center] for body in bodies])
