"""Distance between outlines (oriented rectangles), at an instant and over the continuous motion of one step.

Within a step, centres and headings move linearly, each heading by the shortest turn. Three facts carry everything
below. For any unit vector n, the gap between the shadows of two outlines on n never exceeds their distance. Turning by
w about its centre moves the edge of a shadow by at most |w| r, r = half diagonal. And while n turns at a steady rate
u, the gap lies above the chord between its end values less the bound of its bend / 8: seen from n, the way p + v t
between the centres has a second derivative of at most u^2 |p| + 2 |u| |v|, a corner one of at most (w - u)^2 r.

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
DISTANCE_TOLERANCE = 1e-5
"""How far above the true minimum over a step the distance found may lie [m]."""
MAX_SPLITS = 256
"""Bound on the work of one search for the closest approach; reached only where motion in a step is absurd."""
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


@kernel
def closest_in_step(a0: Box, a1: Box, b0: Box, b1: Box, best: float) -> tuple[float, float]:
    """Least distance [m] over the step and its fraction, if below `best`; else `(best, -1.0)`.

    The result is a distance that occurs, at most `DISTANCE_TOLERANCE` above the least one.
    """
    reach = best + half_diagonal(a0) + half_diagonal(b0)
    if _centers_apart(a0, a1, b0, b1, reach * reach):
        return best, -1.0
    motion = relative_motion(a0, a1, b0, b1)
    start = _probe(a0, b0, motion, 0.0)
    closing = start.nearest.x * motion.x + start.nearest.y * motion.y
    if start.nearest.distance + min(0.0, closing) - motion.swing >= best:
        return best, -1.0
    return _search_closest(a0, b0, motion, start, best)


@inlined
def circles_apart(a0: Box, a1: Box, b0: Box, b1: Box) -> bool:
    """Whether the circumscribed circles stay apart during the step: the cheap test that nearly always answers.

    (r1 + r2)^2 is replaced by its bound 2 (r1^2 + r2^2), exact for equal outlines, so that there is no root.
    """
    return _centers_apart(a0, a1, b0, b1, 0.5 * (a0.length**2 + a0.width**2 + b0.length**2 + b0.width**2))


@inlined
def _centers_apart(a0: Box, a1: Box, b0: Box, b1: Box, reach2: float) -> bool:
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
def _probe(a0: Box, b0: Box, motion: Motion, fraction: float) -> Probe:
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
        nearest = _probe(a0, b0, motion, fraction).nearest
        if nearest.distance < TOUCH:
            return max(fraction, FRACTION_AT_START)
        rate = max(0.0, -(nearest.x * motion.x + nearest.y * motion.y)) + motion.swing
        # Written so that no motion at all, an infinity and NaN all end the search.
        if not nearest.distance <= rate * (1.0 - fraction):
            return -1.0
        fraction = min(1.0, fraction + nearest.distance / rate)
    return fraction


@kernel
def _search_closest(a0: Box, b0: Box, motion: Motion, start: Probe, best: float) -> tuple[float, float]:
    """Sweep over the step: an interval that cannot hold a distance below `best` is passed, any other is split.

    Relative translation of convex bodies has a convex distance, so the planes at an interval's two ends bound it well
    and their crossing is where to look next; turning only adds the small bend.
    """
    end = _probe(a0, b0, motion, 1.0)
    best, at = _better(end, *_better(start, best, -1.0))
    low, high = start, end
    for _ in range(MAX_SPLITS):
        bound, crossing = _lower_bound(a0, b0, motion, low, high)
        span = high.fraction - low.fraction
        if max(0.0, bound) < best - DISTANCE_TOLERANCE:
            high = _probe(a0, b0, motion, low.fraction + crossing * span)
        elif high.fraction >= 1.0:
            break
        elif high.fraction + 3.0 * span >= 1.0:
            low, high = high, end
        else:
            low, high = high, _probe(a0, b0, motion, high.fraction + 2.0 * span)
        best, at = _better(high, best, at)
    return best, at


@inlined
def _better(probe: Probe, best: float, at: float) -> tuple[float, float]:
    """The lesser of a probe's distance and the best one, each with its fraction."""
    if probe.nearest.distance < best:
        return probe.nearest.distance, probe.fraction
    return best, at


@kernel
def _lower_bound(a0: Box, b0: Box, motion: Motion, low: Probe, high: Probe) -> tuple[float, float]:
    """Lower bound of the distance between two instants [m], and where in between (0..1) it is attained."""
    square = (high.fraction - low.fraction) ** 2
    slack_low = square * _bend(a0, b0, motion, low.nearest.owner) / 8.0
    slack_high = square * _bend(a0, b0, motion, high.nearest.owner) / 8.0
    falling_start, falling_end = low.nearest.distance - slack_low, _gap_later(low, high) - slack_low
    rising_start, rising_end = _gap_later(high, low) - slack_high, high.nearest.distance - slack_high
    left, right = falling_start - rising_start, rising_end - falling_end
    if falling_end >= falling_start or left <= 0.0:
        return min(falling_start, falling_end), 0.5
    if rising_end <= rising_start or right <= 0.0:
        return min(rising_start, rising_end), 0.5
    where = left / (left + right)
    return falling_start + (falling_end - falling_start) * where, min(0.9, max(0.1, where))


@inlined
def _bend(a0: Box, b0: Box, motion: Motion, owner: int) -> float:
    """Bound on the second derivative of the gap along a direction that turns with its owner [m per step^2]."""
    turn = _turn_of(motion, owner)
    way = turn * turn * motion.reach + 2.0 * abs(turn) * math.sqrt(motion.x * motion.x + motion.y * motion.y)
    return way + (motion.turn_a - turn) ** 2 * half_diagonal(a0) + (motion.turn_b - turn) ** 2 * half_diagonal(b0)


@inlined
def _turn_of(motion: Motion, owner: int) -> float:
    """How far the owner of a direction turns in the step [rad]; a direction between corners stands still."""
    if owner == SIDE_OF_A:
        return motion.turn_a
    return motion.turn_b if owner == SIDE_OF_B else 0.0


@inlined
def _gap_later(found: Probe, other: Probe) -> float:
    """Gap between the shadows at another instant, on the nearest direction of the first carried on by its owner [m]."""
    nearest = found.nearest
    if nearest.owner == SIDE_OF_A:
        x, y = _turned(nearest.x, nearest.y, found.a, other.a)
    elif nearest.owner == SIDE_OF_B:
        x, y = _turned(nearest.x, nearest.y, found.b, other.b)
    else:
        x, y = nearest.x, nearest.y
    a, b = other.a, other.b
    return (b.x - a.x) * x + (b.y - a.y) * y - _shadow(a, x, y) - _shadow(b, x, y)


@inlined
def _turned(x: float, y: float, before: Frame, after: Frame) -> tuple[float, float]:
    """A direction fixed to a frame, after that frame has turned."""
    along, across = before.cos * x + before.sin * y, before.cos * y - before.sin * x
    return after.cos * along - after.sin * across, after.sin * along + after.cos * across


@inlined
def _shadow(outline: Frame, x: float, y: float) -> float:
    """Half the length of an outline's shadow on a direction [m]."""
    along, across = outline.cos * x + outline.sin * y, outline.cos * y - outline.sin * x
    return outline.half_length * abs(along) + outline.half_width * abs(across)
