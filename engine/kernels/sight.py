"""Visibility of outlines, exact in the plane: a sector of view, without the parts that outlines in between hide. No ray
is sampled.

The target is an outline. Seen from outside, it fills an interval of directions, bounded by those of two of its corners,
or, if the radius of the view cuts it, of points on that circle. This interval is cut to the sector, which leaves at
most two pieces, and the outline is seen unless intervals of other outlines cover every piece.

The order of a pair is decided once, not along a ray. Two disjoint convex outlines are separated by a line along a side
of one of them (the separating axis theorem; Gottschalk, Lin, Manocha 1996, "OBBTree"). Every ray from a point on one
side of it meets the outline on that side first, so that this outline hides the other in all common directions. Outlines
that overlap do not hide each other, only outlines behind both. From inside an outline that hides, only that outline is
seen, and outlines that surround the viewer too.

Directions are unit vectors and their order is the sign of a cross product, so there are no angles to wrap; of two that
are close, the cross product is the angle between them [rad]. The cover of a piece is searched from its right end:
repeatedly to the left end of an outline that hides the current direction, until none does (seen) or the end of the
piece is reached (hidden). That takes no memory, and with n outlines at most n passes of n steps. Outlines outside of
the direction fail one comparison of circles.
"""

import math
from typing import NamedTuple

from engine.kernels.geometry import Box, Frame, View, building, frame
from engine.kernels.jit import inlined, kernel, shared
from engine.tables import SHADE, Floats

OUTSIDE, HIDDEN, SEEN = 0, 1, 2
"""Visibility: outside of the sector or its radius, inside but covered, seen."""

EDGE = 1e-12
"""Directions so little beyond an edge of the sector count as on it [rad]; edges belong to the sector."""
SLIT = 1e-10
"""Angle below which a slit hides what is behind it: outlines that touch leave such a slit by rounding [rad]."""
TOUCH = 1e-9
"""Depth of overlap up to which outlines only touch, so that one of them hides the other [m]."""


class Cone(NamedTuple):
    """Directions from right to left, both ends included, less than half a turn [unit vectors]."""

    right_x: float
    right_y: float
    left_x: float
    left_y: float


class Sight(NamedTuple):
    """Directions of a target, prepared for the search of a cover."""

    verdict: int
    """`OUTSIDE` and `SEEN` (the viewer is in the outline) are final; `HIDDEN`: seen unless the pieces are covered."""
    pieces: int
    """1 or 2."""
    first: Cone
    second: Cone


class Shades(NamedTuple):
    """Outlines of actors that may hide a target."""

    outlines: Floats
    """Outlines of `SHADE` numbers each."""
    start: int
    """Index of the first number of the first outline."""
    number: int
    """Number of the outlines."""
    viewer: int
    """Number of the viewer among the outlines, which is left out; -1: not among them."""
    looked_at: int
    """The same of the target."""


@shared
def look(view: View, target: Box, shades: Shades, buildings: Floats) -> int:
    """Return the visibility of an outline: `OUTSIDE`, `HIDDEN` or `SEEN`.

    `buildings` (n, 5) hide like the outlines of `shades`. A target of no size is a place.
    """
    if not in_reach(view, target):
        return OUTSIDE
    box = frame(target)
    sight = _sight(view, box)
    if sight.verdict != HIDDEN:
        return sight.verdict
    if not _is_covered(view, box, sight.first, shades, buildings):
        return SEEN
    if sight.pieces == 1 or _is_covered(view, box, sight.second, shades, buildings):
        return HIDDEN
    return SEEN


@inlined
def in_reach(view: View, target: Box) -> bool:
    """Return True if a circle around an outline meets that of the view: a cheap test that nearly always answers."""
    dx, dy, reach = target.x - view.x, target.y - view.y, view.distance + 0.5 * (target.length + target.width)
    return dx * dx + dy * dy <= reach * reach  # False for NaN


@inlined
def _cross(ax: float, ay: float, bx: float, by: float) -> float:
    return ax * by - ay * bx


# -- the directions in which an outline lies ---------------------------------------------------------------------------


@inlined
def _sight(view: View, box: Frame) -> Sight:
    """Return the directions in which the sector contains a part of the outline, without outlines in between."""
    dx, dy = view.x - box.x, view.y - box.y
    x, y = box.cos * dx + box.sin * dy, box.cos * dy - box.sin * dx  # the viewer in the outline's frame
    cone = _nothing()
    beyond_x, beyond_y = max(0.0, abs(x) - box.half_length), max(0.0, abs(y) - box.half_width)
    nearest = beyond_x * beyond_x + beyond_y * beyond_y
    if not nearest <= view.distance * view.distance or not abs(x) + abs(y) >= 0.0 or not view.distance >= 0.0:
        return Sight(OUTSIDE, 0, cone, cone)
    if nearest <= TOUCH * TOUCH:
        return Sight(SEEN, 0, cone, cone)
    cone = _silhouette(x, y, box.half_length, box.half_width, 0.0)
    far_x, far_y = abs(x) + box.half_length, abs(y) + box.half_width
    if far_x * far_x + far_y * far_y > view.distance * view.distance:
        cone = _within_radius(cone, x, y, box.half_length, box.half_width, view.distance)
    return _in_sector(view, _unit(_turned(cone, box.cos, box.sin)))


@inlined
def _nothing() -> Cone:
    return Cone(1.0, 0.0, 1.0, 0.0)


@inlined
def _silhouette(x: float, y: float, half_length: float, half_width: float, slack: float) -> Cone:
    """Return the vectors from (x, y) to the corners that bound an axis-parallel box about the origin, seen from
    outside.

    A place nearer than `slack` to a side counts as beyond it.
    """
    side_x, side_y = 0.0, 0.0
    if abs(x) > half_length - slack:
        side_x = 1.0 if x > 0.0 else -1.0
    if abs(y) > half_width - slack:
        side_y = 1.0 if y > 0.0 else -1.0
    # A viewer before a side sees its ends to the right and left; a viewer before a corner, the two adjacent corners.
    if side_x == 0.0:
        right_x, left_x = -side_y, side_y
        right_y = left_y = side_y
    elif side_y == 0.0:
        right_y, left_y = side_x, -side_x
        right_x = left_x = side_x
    elif side_x == side_y:
        right_x, right_y, left_x, left_y = -side_x, side_y, side_x, -side_y
    else:
        right_x, right_y, left_x, left_y = side_x, -side_y, -side_x, side_y
    return Cone(right_x * half_length - x, right_y * half_width - y, left_x * half_length - x, left_y * half_width - y)


@inlined
def _turned(cone: Cone, cos: float, sin: float) -> Cone:
    return Cone(
        cos * cone.right_x - sin * cone.right_y,
        sin * cone.right_x + cos * cone.right_y,
        cos * cone.left_x - sin * cone.left_y,
        sin * cone.left_x + cos * cone.left_y,
    )


@inlined
def _unit(cone: Cone) -> Cone:
    right = math.sqrt(cone.right_x * cone.right_x + cone.right_y * cone.right_y)
    left = math.sqrt(cone.left_x * cone.left_x + cone.left_y * cone.left_y)
    return Cone(cone.right_x / right, cone.right_y / right, cone.left_x / left, cone.left_y / left)


@kernel
def _within_radius(cone: Cone, x: float, y: float, half_length: float, half_width: float, radius: float) -> Cone:
    """Return the silhouette of the part of an axis-parallel box about the origin within `radius` of (x, y).

    It is convex, so its ends are corners of the box, or intersections of a side and the circle.
    """
    square = radius * radius
    right = cone.right_x * cone.right_x + cone.right_y * cone.right_y
    left = cone.left_x * cone.left_x + cone.left_y * cone.left_y
    if right <= square and left <= square:
        return cone
    # The nearest point is within the radius.
    near_x = min(max(x, -half_length), half_length) - x
    near_y = min(max(y, -half_width), half_width) - y
    found = Cone(near_x, near_y, near_x, near_y)
    for side in (-1.0, 1.0):
        for end in (-1.0, 1.0):
            corner_x, corner_y = side * half_length - x, end * half_width - y
            if corner_x * corner_x + corner_y * corner_y <= square:
                found = _widened(found, corner_x, corner_y)
            rest = square - corner_x * corner_x
            across = end * math.sqrt(max(0.0, rest))
            if rest >= 0.0 and abs(y + across) <= half_width:
                found = _widened(found, corner_x, across)
            corner_y = side * half_width - y
            rest = square - corner_y * corner_y
            along = end * math.sqrt(max(0.0, rest))
            if rest >= 0.0 and abs(x + along) <= half_length:
                found = _widened(found, along, corner_y)
    return found


@inlined
def _widened(cone: Cone, x: float, y: float) -> Cone:
    """Return the cone extended to another direction; all directions are within half a turn."""
    if _cross(cone.right_x, cone.right_y, x, y) < 0.0:
        return Cone(x, y, cone.left_x, cone.left_y)
    if _cross(cone.left_x, cone.left_y, x, y) > 0.0:
        return Cone(cone.right_x, cone.right_y, x, y)
    return cone


# -- the sector --------------------------------------------------------------------------------------------------------


@inlined
def _in_sector(view: View, cone: Cone) -> Sight:
    """Return the directions inside the sector: all, none, one piece, or two pieces on both sides of the gap behind."""
    if view.angle >= 2.0 * math.pi:
        return Sight(HIDDEN, 1, cone, cone)
    ahead_x, ahead_y = math.cos(view.heading), math.sin(view.heading)
    cos, sin = math.cos(0.5 * view.angle), math.sin(0.5 * view.angle)
    # The sector from its right edge to its left; more than half a turn if it is that wide.
    sector = Cone(
        cos * ahead_x + sin * ahead_y,
        cos * ahead_y - sin * ahead_x,
        cos * ahead_x - sin * ahead_y,
        cos * ahead_y + sin * ahead_x,
    )
    wide = view.angle > math.pi
    right = _opens_to(sector, wide, cone.right_x, cone.right_y)
    left = _opens_to(sector, wide, cone.left_x, cone.left_y)
    from_right = Cone(cone.right_x, cone.right_y, sector.left_x, sector.left_y)
    to_left = Cone(sector.right_x, sector.right_y, cone.left_x, cone.left_y)
    if right and left:
        split = wide and _holds(cone, -ahead_x, -ahead_y, -EDGE)
        return Sight(HIDDEN, 2, from_right, to_left) if split else Sight(HIDDEN, 1, cone, cone)
    if right:
        return Sight(HIDDEN, 1, from_right, cone)
    if left:
        return Sight(HIDDEN, 1, to_left, cone)
    if _holds(cone, ahead_x, ahead_y, 0.0) and not wide:
        return Sight(HIDDEN, 1, sector, cone)
    return Sight(OUTSIDE, 0, cone, cone)


@inlined
def _opens_to(sector: Cone, wide: bool, x: float, y: float) -> bool:
    """Return True if a direction is in the sector, its edges included."""
    if wide:
        behind = Cone(sector.left_x, sector.left_y, sector.right_x, sector.right_y)
        return not _holds(behind, x, y, -EDGE)
    return _holds(sector, x, y, EDGE)


@inlined
def _holds(cone: Cone, x: float, y: float, slack: float) -> bool:
    """Return True if a direction is between the ends of a cone, within `slack` [rad]."""
    return (
        _cross(cone.right_x, cone.right_y, x, y) >= -slack
        and _cross(x, y, cone.left_x, cone.left_y) >= -slack
        and x * (cone.right_x + cone.left_x) + y * (cone.right_y + cone.left_y) >= -SLIT
    )


# -- outlines in between -----------------------------------------------------------------------------------------------


class Corridor(NamedTuple):
    """The strip from a viewer to a target that contains all lines between them."""

    x: float
    """Direction from the viewer to the centre of the target."""
    y: float
    distance: float
    """Distance of that centre [m]."""
    radius: float
    """Radius of the circumscribed circle of the target [m]."""


@inlined
def _corridor(view: View, x: float, y: float, half_length: float, half_width: float) -> Corridor:
    dx, dy = x - view.x, y - view.y
    distance = math.sqrt(dx * dx + dy * dy)
    return Corridor(
        dx / distance, dy / distance, distance, math.sqrt(half_length * half_length + half_width * half_width)
    )


@inlined
def _is_beside(corridor: Corridor, off_x: float, off_y: float, reach: float) -> bool:
    """Return True if an outline with its centre at an offset from the viewer cannot reach into the corridor."""
    aside = abs(_cross(corridor.x, corridor.y, off_x, off_y))
    along = corridor.x * off_x + corridor.y * off_y
    beyond = corridor.distance + corridor.radius + reach
    return aside > reach + corridor.radius or along < -reach or along > beyond


@inlined
def _is_left_out(shades: Shades, number: int) -> bool:
    """Return True if an outline is that of the viewer or of the target, or hides nothing."""
    is_one = number == shades.viewer or number == shades.looked_at
    return is_one or shades.outlines[shades.start + number * SHADE + 5] == 0.0


@inlined
def _hiding_outline(shades: Shades, buildings: Floats, number: int) -> Box:
    """Return one of all outlines: those of the shades, then the buildings."""
    if number >= shades.number:
        return building(buildings, number - shades.number)
    outlines, at = shades.outlines, shades.start + number * SHADE
    return Box(outlines[at], outlines[at + 1], outlines[at + 2], outlines[at + 3], outlines[at + 4])


@inlined
def may_be_hidden(view: View, target: Box, shades: Shades, buildings: Floats) -> bool:
    """Return False if `look` is certainly not `HIDDEN`, as nothing that hides is in between: a cheap test."""
    if not in_reach(view, target):
        return False
    corridor = _corridor(view, target.x, target.y, 0.5 * target.length, 0.5 * target.width)
    for number in range(shades.number + len(buildings)):
        if number >= shades.number or not _is_left_out(shades, number):
            box = _hiding_outline(shades, buildings, number)
            if not _is_beside(corridor, box.x - view.x, box.y - view.y, 0.5 * (box.length + box.width)):
                return True
    return False


@kernel
def _is_covered(view: View, target: Frame, piece: Cone, shades: Shades, buildings: Floats) -> bool:
    """Return True if outlines that hide the target cover a piece of its directions."""
    count = shades.number
    number_of_all = count + len(buildings)
    if number_of_all == 0:
        return False
    corridor = _corridor(view, target.x, target.y, target.half_length, target.half_width)
    x, y = piece.right_x, piece.right_y
    for _ in range(number_of_all + 1):
        walked = False
        for number in range(number_of_all):
            if number < count and _is_left_out(shades, number):
                continue
            box = _hiding_outline(shades, buildings, number)
            off_x, off_y = box.x - view.x, box.y - view.y
            if _is_beside(corridor, off_x, off_y, 0.5 * (box.length + box.width)):
                continue
            shade = frame(box)
            off_x, off_y = shade.cos * off_x + shade.sin * off_y, shade.cos * off_y - shade.sin * off_x
            beyond = max(abs(off_x) - shade.half_length, abs(off_y) - shade.half_width)
            if beyond < -TOUCH:
                return True
            if not _is_nearer(view, shade, target, -off_x, -off_y):
                continue
            slack = TOUCH if beyond <= TOUCH else 0.0
            cone = _silhouette(-off_x, -off_y, shade.half_length, shade.half_width, slack)
            cone = _unit(_turned(cone, shade.cos, shade.sin))
            if _holds(cone, x, y, SLIT):
                if _cross(cone.left_x, cone.left_y, piece.left_x, piece.left_y) <= SLIT:
                    return True
                if _cross(x, y, cone.left_x, cone.left_y) > 0.0:
                    x, y, walked = cone.left_x, cone.left_y, True
        if not walked:
            return False
    return False


@inlined
def _is_nearer(view: View, shade: Frame, target: Frame, x: float, y: float) -> bool:
    """Return True if a line separates both, with the viewer, at (x, y) in the shade's frame, on the shade's side."""
    dx, dy = target.x - shade.x, target.y - shade.y
    turn_cos = abs(shade.cos * target.cos + shade.sin * target.sin)
    turn_sin = abs(shade.cos * target.sin - shade.sin * target.cos)
    there_x, there_y = shade.cos * dx + shade.sin * dy, shade.cos * dy - shade.sin * dx
    extent_x = target.half_length * turn_cos + target.half_width * turn_sin
    extent_y = target.half_length * turn_sin + target.half_width * turn_cos
    gap_x, gap_y = abs(there_x) - extent_x - shade.half_length, abs(there_y) - extent_y - shade.half_width
    # Seen from the target: its own sides.
    off_x, off_y = -target.cos * dx - target.sin * dy, target.sin * dx - target.cos * dy
    reach_x = shade.half_length * turn_cos + shade.half_width * turn_sin
    reach_y = shade.half_length * turn_sin + shade.half_width * turn_cos
    room_x, room_y = abs(off_x) - reach_x - target.half_length, abs(off_y) - reach_y - target.half_width
    widest = max(gap_x, gap_y, room_x, room_y)
    if not widest >= -TOUCH:
        return False
    # Along the axis of the widest gap, as a coordinate that grows from the shade to the target.
    if widest == gap_x:
        return (x if there_x > 0.0 else -x) <= abs(there_x) - extent_x
    if widest == gap_y:
        return (y if there_y > 0.0 else -y) <= abs(there_y) - extent_y
    mine_x, mine_y = view.x - target.x, view.y - target.y
    own_x, own_y = target.cos * mine_x + target.sin * mine_y, target.cos * mine_y - target.sin * mine_x
    if widest == room_x:
        return (own_x if off_x > 0.0 else -own_x) >= target.half_length
    return (own_y if off_y > 0.0 else -own_y) >= target.half_width
