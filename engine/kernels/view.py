"""Who sees whom: a sector of a given angle and radius at the viewer's centre, against another's outline."""

import math
from typing import NamedTuple

from engine.kernels.geometry import Box
from engine.kernels.jit import kernel


class View(NamedTuple):
    """A field of view: apex x, y [m], axis heading [rad], full opening angle [rad], radius [m]."""

    x: float
    y: float
    heading: float
    angle: float
    distance: float


@kernel
def sees(view: View, outline: Box) -> bool:
    """Whether a corner or the centre of the outline lies in the viewer's sector (edges of the sector count)."""
    dx, dy = outline.x - view.x, outline.y - view.y
    half_diagonal = 0.5 * math.hypot(outline.length, outline.width)
    if dx * dx + dy * dy > (view.distance + half_diagonal) ** 2:
        return False
    cos_view, sin_view = math.cos(view.heading), math.sin(view.heading)
    # In the viewer's frame the axis is +x, so a point is inside when its x is at least r cos(angle / 2).
    ahead, aside = dx * cos_view + dy * sin_view, dy * cos_view - dx * sin_view
    cos_half = -2.0 if view.angle >= 2.0 * math.pi else math.cos(0.5 * view.angle)
    if _in_sector(ahead, aside, cos_half, view.distance):
        return True
    turn = outline.heading - view.heading
    cos_turn, sin_turn = math.cos(turn), math.sin(turn)
    for corner in range(4):
        along = 0.5 * outline.length if corner < 2 else -0.5 * outline.length
        across = 0.5 * outline.width if corner % 2 == 0 else -0.5 * outline.width
        x = ahead + along * cos_turn - across * sin_turn
        y = aside + along * sin_turn + across * cos_turn
        if _in_sector(x, y, cos_half, view.distance):
            return True
    return False


@kernel
def _in_sector(x: float, y: float, cos_half: float, radius: float) -> bool:
    """Whether a point in the viewer's frame is in the sector; the apex itself is."""
    distance = math.sqrt(x * x + y * y)
    return distance <= radius and x >= distance * cos_half
