"""Counterfactuals of collisions, and adapted speed: a second standard beside the reaction of reference drivers.

A driver that only reacts avoids nothing that comes into sight too late; one that approaches so slowly that it can stop
before what it does not see may. `engine.kernels.adapted` has the definitions.
"""

import math
from dataclasses import dataclass

import numpy as np

from engine.avoidability import R157, drive_memory
from engine.config import ContactConfig, SimulationConfig
from engine.dependence import ignores_ego
from engine.host import in_parts, plan, requested, samples_of
from engine.kernels.adapted import counterfactual_rows
from engine.kernels.perception import Driver
from engine.kernels.rows import Window
from engine.program import Program
from engine.scenes import Scenes, weather_sight

DEFAULTS = SimulationConfig()
CONTACT = ContactConfig()


@dataclass(frozen=True)
class Counterfactuals:
    """Values at which one collision would not have happened; NaN if there is none."""

    approach_speed: float
    """Highest speed of the ego before it brakes [m/s], at most that of the case."""
    latest_braking: float
    """Latest instant at which full braking begins [s]."""
    sight: float
    """Least distance at which the other is seen [m]."""
    friction: float
    """Least friction of the road."""
    adapted_speed: bool
    """True if the ego avoids the collision with adapted speed."""


def counterfactuals(
    program: Program,
    scenes: Scenes,
    config: SimulationConfig = DEFAULTS,
    contact: ContactConfig = CONTACT,
    jobs: int = 1,
    driver: Driver = R157,
) -> tuple[Counterfactuals | None, ...]:
    """Return one row per scene; None for a scene without a collision of which the ego is at fault."""
    shared, rows = plan(program, config, contact), requested(program, scenes)
    reach, independent = weather_sight(program, scenes.variant, scenes.values), ignores_ego(program)
    found = np.full((len(scenes), 5), math.nan)

    def drive(window: Window) -> None:
        samples = samples_of(config) + 1
        stored = 0 if independent else samples
        scratch = drive_memory(program, config, samples, independent=independent, stored=stored)
        counterfactual_rows(shared, rows, reach, window, scratch, driver, found)

    in_parts(len(scenes), jobs, drive)
    return tuple(
        None if math.isnan(adapted) else Counterfactuals(*values, adapted_speed=adapted == 1.0)
        for *values, adapted in found.tolist()
    )
