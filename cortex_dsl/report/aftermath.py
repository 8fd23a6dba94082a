"""What the world shows after contact, as moments of the story: every impact, and where all came to rest."""

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from cortex_dsl.report.numbers import fixed
from cortex_dsl.report.story import REST, Moment
from engine.program import Program
from engine.scenes import Trajectory
from engine.vocabulary import State

if TYPE_CHECKING:
    from engine.world.impacts import Impact

TOLD_IMPACTS = 4
"""Later ones are a car against the same car again, with hardly any force."""


def aftermath(program: Program, impacts: "Sequence[Impact]", trajectory: Trajectory) -> list[Moment]:
    """Each impact with the change of velocity it gave to both, and who stands still in the end."""
    told = [moment for impact in impacts[:TOLD_IMPACTS] for moment in _impact(program, impact)]
    return told + list(_rests(trajectory)) if impacts else []


def _impact(program: Program, impact: "Impact") -> Iterator[Moment]:
    first, second = impact.actors
    angle = round(abs(math.degrees(impact.impact_angle)))
    speed = fixed(3.6 * impact.closing_speed, 1)
    yield Moment(impact.time, -1, "impact", f"impact at {speed} km/h, headings {angle}° apart")
    for actor, other, change, hour in zip(impact.actors, (second, first), impact.delta_v, impact.clock, strict=True):
        text = f"delta-V {fixed(3.6 * change, 1)} km/h, struck by {program.actors[other]} at {hour} o'clock"
        yield Moment(impact.time, actor, "impact", text)


def _rests(trajectory: Trajectory) -> Iterator[Moment]:
    """When each actor that the contact set moving, or found moving, stood still for good."""
    if trajectory.contact_sample < 0:
        return
    for actor in range(len(trajectory.outlines)):
        speed = np.abs(trajectory.states[:, actor, State.SPEED])
        moving = np.flatnonzero(speed > REST)
        if len(moving) and trajectory.contact_sample <= moving[-1] < len(speed) - 1:
            yield Moment(float(trajectory.time[moving[-1] + 1]), actor, "rest", "comes to rest")
