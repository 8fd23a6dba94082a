"""How much of the grip a drive uses, as a share of mu g: sideways, and in both directions together.

    sideways   v_m |psi'| / (mu g)          together   sqrt(a^2 + (v_m psi')^2) / (mu g)

over each step of a run, with a its acceleration, psi' its yaw rate and v_m the speed at its middle. The run's are the
largest; steps in which somebody is loose after an impact are left out. Above `MODEL_RANGE` the kinematic bicycle is no
fair model of a car: see `engine.outcomes`.
"""

import math
from typing import NamedTuple

from engine.kernels.jit import inlined
from engine.tables import SLIDING, Floats
from engine.vocabulary import State


class Used(NamedTuple):
    """The largest uses of grip in a run, as shares."""

    sideways: float
    together: float


@inlined
def grip_used(states: Floats, last: int, time_step: float, actor: int, grip: float) -> Used:
    """Of one actor, over the steps up to sample `last`; `grip` is mu g [m/s^2]. 0 for who never makes a step."""
    # Without friction nothing is used: there is no acceleration either.
    grip = max(grip, 1e-9)
    sideways, together = 0.0, 0.0
    for k in range(last):
        before, after = states[k, actor, State.PRESENT], states[k + 1, actor, State.PRESENT]
        if before == 0.0 or after == 0.0 or after == SLIDING:
            continue
        along = states[k + 1, actor, State.ACCELERATION]
        speed = states[k + 1, actor, State.SPEED] - 0.5 * time_step * along
        across = speed * (states[k + 1, actor, State.HEADING] - states[k, actor, State.HEADING]) / time_step
        sideways = max(sideways, across * across)
        together = max(together, along * along + across * across)
    return Used(math.sqrt(sideways) / grip, math.sqrt(together) / grip)
