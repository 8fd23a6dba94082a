"""Distance between outlines (oriented rectangles), at an instant and over the continuous motion of one step.

Within a step, centres and headings move linearly, each heading by the shortest turn. Two facts carry the search for
contact. For any unit vector n, the gap between the shadows of two outlines on n never exceeds their distance; and
turning by w about its centre moves the edge of a shadow by at most |w| r, r = half diagonal.

Source of the search for first contact: conservative advancement (Mirtich 1996, "Impulse-based dynamic simulation of
rigid body systems", section 2.3), with the motion bound taken along the direction of the nearest points.
"""

import math
from typing import NamedTuple

from engine.kernels.inline import inlined
from engine.kernels.jit import kernel

TOUCH = 1e-4
"""Outlines nearer than this are in contact [m]."""
FRACTION_AT_START = 1e-9
"""Reported where outlines touch already at the start of a step: contact belongs to (0, 1]."""
MAX_ADVANCES = 4096
"""After so many advances the gap was on average below 1/4096 of the way of one step (1 mm for 4 m): contact."""
CORNERS, SIDE_OF_A, SIDE_OF_B = 0, 1, 2


class Box(NamedTuple):
    """An outline: centre x, y [m], heading [rad, anticlockwise from +x], length along it and width [m]."""

    x: float
    y: float
    heading: float
    length: float
    width: float


class Frame(NamedTuple):
    """A box made ready: centre [m], direction of its heading, half length and half width [m]."""

    x: float
    y: float
    cos: float
    sin: float
    half_length: float
    half_width: float


class Nearest(NamedTuple):
    """Distance [m] and the unit vector from a's nearest point to b's; zeros where the outlines overlap."""

    distance: float
    x: float
    y: float
    owner: int
    """Whose side the direction stands on: `CORNERS`, `SIDE_OF_A`, `SIDE_OF_B`."""


class Motion(NamedTuple):
    """How one pair moves in a step: b's way relative to a [m], both turns [rad], and the bounds that follow."""

    x: float
    y: float
    turn_a: float
    turn_b: float
    swing: float
    """|turn_a| r_a + |turn_b| r_b: the most that turning can bring the outlines nearer [m]."""
    reach: float
    """The largest distance between the centres [m]."""


class Probe(NamedTuple):
    """An instant of a step (`fraction`), looked at: both frames and what is nearest."""

    fraction: float
    a: Frame
    b: Frame
    nearest: Nearest


@kernel
def box_distance(a: Box, b: Box) -> float:
    """Distance between two outlines [m]; 0.0 when they touch or overlap."""
    return nearest_points(frame(a), frame(b)).distance


@kernel
def first_contact(a0: Box, a1: Box, b0: Box, b1: Box) -> float:
    """Fraction in (0, 1] of the step at which the outlines first come within `TOUCH`; -1.0 if they do not."""
    if circles_apart(a0, a1, b0, b1):
        return -1.0
    return _advance_to_contact(a0, a1, b0, b1)


@inlined
def circles_apart(a0: Box, a1: Box, b0: Box, b1: Box) -> bool:
    """Whether the circumscribed circles stay apart during the step: the cheap test that nearly always answers.

    (r1 + r2)^2 is replaced by its bound 2 (r1^2 + r2^2), exact for equal outlines, so that there is no root.
    """
    return centers_apart(a0, a1, b0, b1, 0.5 * (a0.length**2 + a0.width**2 + b0.length**2 + b0.width**2))


@inlined
def centers_apart(a0: Box, a1: Box, b0: Box, b1: Box, reach2: float) -> bool:
    """Whether the squared distance between the centres exceeds `reach2` all through the step."""
    x0, y0 = b0.x - a0.x, b0.y - a0.y
    x1, y1 = b1.x - a1.x, b1.y - a1.y
    way_x, way_y = x1 - x0, y1 - y0
    if x0 * way_x + y0 * way_y >= 0.0:  # moving apart: nearest at the start
        return x0 * x0 + y0 * y0 > reach2
    if x1 * way_x + y1 * way_y <= 0.0:  # still approaching: nearest at the end
        return x1 * x1 + y1 * y1 > reach2
    cross = x0 * way_y - y0 * way_x
    return cross * cross > reach2 * (way_x * way_x + way_y * way_y)


@inlined
def half_diagonal(box: Box) -> float:
    """Radius of the circumscribed circle [m]."""
    return 0.5 * math.sqrt(box.length * box.length + box.width * box.width)


@inlined
def shortest_turn(start: float, end: float) -> float:
    """The turn from one heading to another that is at most half a circle [rad]."""
    turn = end - start
    return turn if -math.pi <= turn <= math.pi else turn - 2.0 * math.pi * math.floor(turn / (2.0 * math.pi) + 0.5)


@inlined
def frame(box: Box) -> Frame:
    """The box as a frame."""
    return Frame(box.x, box.y, math.cos(box.heading), math.sin(box.heading), 0.5 * box.length, 0.5 * box.width)


@inlined
def relative_motion(a0: Box, a1: Box, b0: Box, b1: Box) -> Motion:
    """Motion of the pair over the step."""
    turn_a, turn_b = shortest_turn(a0.heading, a1.heading), shortest_turn(b0.heading, b1.heading)
    radius_a, radius_b = half_diagonal(a0), half_diagonal(b0)
    return Motion(
        (b1.x - b0.x) - (a1.x - a0.x),
        (b1.y - b0.y) - (a1.y - a0.y),
        turn_a,
        turn_b,
        abs(turn_a) * radius_a + abs(turn_b) * radius_b,
        math.sqrt(max((b0.x - a0.x) ** 2 + (b0.y - a0.y) ** 2, (b1.x - a1.x) ** 2 + (b1.y - a1.y) ** 2)),
    )


@kernel
def nearest_points(a: Frame, b: Frame) -> Nearest:
    """Separating axes decide on overlap; else the least of the eight distances from a corner to the other box."""
    dx, dy = b.x - a.x, b.y - a.y
    cos, sin = a.cos * b.cos + a.sin * b.sin, a.cos * b.sin - a.sin * b.cos
    bx, by = a.cos * dx + a.sin * dy, a.cos * dy - a.sin * dx  # b's centre in a's frame
    ax, ay = -b.cos * dx - b.sin * dy, b.sin * dx - b.cos * dy  # a's centre in b's frame
    c, s = abs(cos), abs(sin)
    if (
        abs(bx) <= a.half_length + b.half_length * c + b.half_width * s
        and abs(by) <= a.half_width + b.half_length * s + b.half_width * c
        and abs(ax) <= b.half_length + a.half_length * c + a.half_width * s
        and abs(ay) <= b.half_width + a.half_length * s + a.half_width * c
    ):
        return Nearest(0.0, 0.0, 0.0, CORNERS)
    square_b, b_x, b_y = _nearest_corner(a.half_length, a.half_width, bx, by, cos, sin, b.half_length, b.half_width)
    square_a, a_x, a_y = _nearest_corner(b.half_length, b.half_width, ax, ay, cos, -sin, a.half_length, a.half_width)
    if square_b <= square_a:
        return _in_world(square_b, b_x, b_y, a.cos, a.sin, SIDE_OF_A)
    return _in_world(square_a, -a_x, -a_y, b.cos, b.sin, SIDE_OF_B)


@inlined
def _in_world(square: float, x: float, y: float, cos: float, sin: float, owner: int) -> Nearest:
    """The offset (x, y) seen in the owner's frame, as a `Nearest`; one along an axis stands on a side."""
    distance = math.sqrt(square)
    if distance == 0.0:
        return Nearest(0.0, 0.0, 0.0, CORNERS)
    owner = owner if x == 0.0 or y == 0.0 else CORNERS
    return Nearest(distance, (cos * x - sin * y) / distance, (sin * x + cos * y) / distance, owner)


@inlined
def _nearest_corner(
    half_length: float, half_width: float, x: float, y: float, cos: float, sin: float, length: float, width: float
) -> tuple[float, float, float]:
    """Squared distance and offset from a box at the origin to the nearest corner of another.

    The other has its centre at (x, y), is turned by (cos, sin) and has half sizes `length` and `width`.
    """
    lx, ly, wx, wy = length * cos, length * sin, -width * sin, width * cos
    best, best_x, best_y = math.inf, 0.0, 0.0
    for along, across in ((1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)):
        corner_x, corner_y = x + along * lx + across * wx, y + along * ly + across * wy
        off_x = corner_x - min(half_length, max(-half_length, corner_x))
        off_y = corner_y - min(half_width, max(-half_width, corner_y))
        square = off_x * off_x + off_y * off_y
        if square < best:
            best, best_x, best_y = square, off_x, off_y
    return best, best_x, best_y


@inlined
def _moved(box: Box, x: float, y: float, turn: float) -> Frame:
    """The box's frame after a shift and a turn."""
    heading = box.heading + turn
    return Frame(box.x + x, box.y + y, math.cos(heading), math.sin(heading), 0.5 * box.length, 0.5 * box.width)


@kernel
def probe(a0: Box, b0: Box, motion: Motion, fraction: float) -> Probe:
    """The pair at a fraction of the step, in axes that move with a's centre."""
    a = _moved(a0, 0.0, 0.0, fraction * motion.turn_a)
    b = _moved(b0, fraction * motion.x, fraction * motion.y, fraction * motion.turn_b)
    return Probe(fraction, a, b, nearest_points(a, b))


@kernel
def _advance_to_contact(a0: Box, a1: Box, b0: Box, b1: Box) -> float:
    """Conservative advancement: t += d / (approach along the nearest direction + swing), until d < `TOUCH`."""
    motion = relative_motion(a0, a1, b0, b1)
    fraction = 0.0
    for _ in range(MAX_ADVANCES):
        nearest = probe(a0, b0, motion, fraction).nearest
        if nearest.distance < TOUCH:
            return max(fraction, FRACTION_AT_START)
        rate = max(0.0, -(nearest.x * motion.x + nearest.y * motion.y)) + motion.swing
        # Written so that no motion at all, an infinity and NaN all end the search.
        if not nearest.distance <= rate * (1.0 - fraction):
            return -1.0
        fraction = min(1.0, fraction + nearest.distance / rate)
    return fraction
