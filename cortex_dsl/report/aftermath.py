"""What the world shows after contact, as moments of the story: every impact, and where all came to rest."""

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from cortex_dsl.report.motion import speeds
from cortex_dsl.report.speeds import SpeedUnit, speed_unit
from cortex_dsl.report.story import REST, Moment
from engine.program import Program
from engine.scenes import Trajectory

if TYPE_CHECKING:
    from engine.world.impacts import Impact

TOLD_IMPACTS = 4
"""Later ones are a car against the same car again, with hardly any force."""


def aftermath(program: Program, impacts: "Sequence[Impact]", trajectory: Trajectory) -> list[Moment]:
    """Each impact with the change of velocity it gave to both, and who stands still in the end."""
    unit = speed_unit(program)
    told = [moment for impact in impacts[:TOLD_IMPACTS] for moment in _impact(program, impact, unit)]
    return told + list(_rests(trajectory)) if impacts else []


def _impact(program: Program, impact: "Impact", unit: SpeedUnit) -> Iterator[Moment]:
    first, second = impact.actors
    angle = round(abs(math.degrees(impact.impact_angle)))
    speed = unit.text(impact.closing_speed)
    yield Moment(impact.time, -1, "impact", f"impact at {speed}, headings {angle}° apart")
    for actor, other, change, hour in zip(impact.actors, (second, first), impact.delta_v, impact.clock, strict=True):
        text = f"delta-V {unit.text(change)}, struck by {program.actors[other]} at {hour} o'clock"
        yield Moment(impact.time, actor, "impact", text)


def _rests(trajectory: Trajectory) -> Iterator[Moment]:
    """When each actor that the contact set moving, or found moving, stood still for good."""
    if trajectory.contact_sample < 0:
        return
    for actor, speed in enumerate(np.abs(speeds(trajectory)).T):
        moving = np.flatnonzero(speed > REST)
        if len(moving) and trajectory.contact_sample <= moving[-1] < len(speed) - 1:
            yield Moment(float(trajectory.time[moving[-1] + 1]), actor, "rest", "comes to rest")
