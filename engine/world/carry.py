"""Before contact, pymunk carries the poses that the shared kernels drive: each step it gets the chord velocity."""

from collections.abc import Sequence

import numpy as np
import pymunk

from engine.tables import Floats
from engine.vocabulary import State

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
