"""Whose failure a contact of the ego is, as far as motion and road say: it may have been struck.

Two contacts are no failure of the ego. Another runs into it from behind: contact is at the ego's rear, and the other
is the faster of the two along the ego's heading. Or the ego stands where one may stand: it has stood for the last
second, or since the run began, and no part of it is in an intersection.
"""

import math

from engine.kernels.jit import inlined, kernel
from engine.kernels.region import region_contains
from engine.tables import Floats, RoadTables
from engine.vocabulary import Fault, Side, State

STANDING = 0.1
"""Who is slower stands [m/s]."""
SETTLED = 1.0
"""For how long it must have stood [s]; *ours*: as long as another takes to see it and to begin to brake."""
EGO, FROM_BEHIND, WHILE_STANDING = map(int, Fault)
REAR = int(Side.REAR)


@kernel
def fault_of(
    states: Floats,
    last: int,
    time_step: float,
    length: float,
    width: float,
    road: RoadTables,
    intersections: int,
    side: float,
    ego_speed: float,
    other_speed: float,
    angle: float,
) -> int:
    """The `Fault` of a contact in the step after sample `last`, where the ego is actor 0.

    Its outline [m]; the road's regions 1 to `intersections` are intersections; `side`, speeds [m/s] and `angle` [rad]
    as `pair.measure_pair` has them at contact.
    """
    if int(side) == REAR and other_speed * math.cos(angle) > ego_speed:
        return FROM_BEHIND
    if _stood(states, last, time_step) and not _is_in_the_way(states, last, length, width, road, intersections):
        return WHILE_STANDING
    return EGO


@inlined
def _stood(states: Floats, last: int, time_step: float) -> bool:
    first = max(0, last - math.ceil(SETTLED / time_step))
    for k in range(first, last + 1):
        if abs(states[k, 0, State.SPEED]) >= STANDING or states[k, 0, State.PRESENT] == 0.0:
            return False
    return True


@inlined
def _is_in_the_way(
    states: Floats, last: int, length: float, width: float, road: RoadTables, intersections: int
) -> bool:
    """Whether the ego's centre, or a corner, lies in an intersection."""
    x, y, heading = states[last, 0, State.X], states[last, 0, State.Y], states[last, 0, State.HEADING]
    cos, sin = math.cos(heading), math.sin(heading)
    for region in range(1, min(intersections, len(road.region_start) - 2) + 1):
        for place in range(5):
            along = 0.0 if place == 4 else 0.5 * length * (1.0 if place < 2 else -1.0)
            across = 0.0 if place == 4 else 0.5 * width * (1.0 if place % 2 == 0 else -1.0)
            if region_contains(road, region, x + along * cos - across * sin, y + along * sin + across * cos):
                return True
    return False
