"""Contacts of rigid bodies in the plane: where two outlines touch, and what a unit of impulse does there.

Bodies are rows of `Body`, contacts rows of `Contact`. Each contact has three rows of `Row`, 3 c to 3 c + 2: the normal
at each of its points, and the tangent at their middle. What is fixed has no lightness.
"""

import math
from enum import IntEnum
from typing import NamedTuple

from engine.kernels.geometry import Frame
from engine.kernels.jit import inlined, kernel
from engine.tables import Floats

FLAT = 0.01
"""Two corners of a side that lie no further than this apart across the contact touch both: faces meet flat [m]."""


class Body(IntEnum):
    """Columns of a body."""

    X = 0
    """Centre of mass [m]."""
    Y = 1
    VX = 2
    """[m/s]"""
    VY = 3
    SPIN = 4
    """[rad/s]"""
    LIGHTNESS = 5
    """1 / mass [1/kg]; 0: nothing moves it."""
    EASE = 6
    """1 / yaw inertia [1/(kg m^2)]; 0: nothing turns it."""


class Contact(IntEnum):
    """Columns of a contact of two bodies."""

    ONE = 0
    """Row of the body that the normal points away from."""
    OTHER = 1
    NX = 2
    """Unit normal."""
    NY = 3
    POINTS = 4
    """1 or 2."""
    X1 = 5
    """[m]"""
    Y1 = 6
    X2 = 7
    Y2 = 8
    PUSH1 = 9
    """Impulse that the other body gets along the normal at each point … [N s]"""
    PUSH2 = 10
    RUB = 11
    """… and along the tangent (-NY, NX). Filled in by `resolve`."""


class Row(IntEnum):
    """Columns of a law at a contact: along one direction, what a unit of impulse does."""

    X = 0
    Y = 1
    LEVER_ONE = 2
    """Arm x direction [m]."""
    LEVER_OTHER = 3
    RESPONSE = 4
    """How much a unit of impulse changes the relative speed [1/kg]; 0: no such row."""
    SPEED = 5
    """Relative speed before [m/s]."""


BODY, CONTACT, ROW = len(Body), len(Contact), len(Row)
"""Numbers of columns."""


@inlined
def is_fixed(said: float, mass: float) -> bool:
    """Whether nothing moves a body: it is `said` to be fixed (not 0), or its mass is no number above 0."""
    return said != 0.0 or not 0.0 < mass < math.inf


# -- where two outlines touch ------------------------------------------------------------------------------------------


class Touching(NamedTuple):
    """Where two outlines touch, or are nearest: normal from the first to the second, and one or two points."""

    gap: float
    """Between the outlines along the normal [m]; negative where they overlap."""
    nx: float
    ny: float
    points: int
    x1: float
    y1: float
    x2: float
    y2: float


@kernel
def touching(a: Frame, b: Frame) -> Touching:
    """The side that keeps two outlines furthest apart, and what of the other lies on it; of equal ones the first's."""
    along, across, turned = _sides(a, b), _sides(b, a), False
    best = along
    if across[0] > along[0] + 1e-9:
        best, turned = across, True
    if turned:
        return _on_side(b, a, best[0], best[1], best[2], -1.0)
    return _on_side(a, b, best[0], best[1], best[2], 1.0)


@inlined
def wedged(a: Frame, b: Frame) -> Touching:
    """The contact of two that are inside one another too deep for a side: half way between their centres, along the way
    from one to the other. Without such a way its normal is 0.
    """
    x, y = b.x - a.x, b.y - a.y
    apart = math.sqrt(x * x + y * y)
    scale = 1.0 / apart if apart > 0.0 else 0.0
    mid_x, mid_y = 0.5 * (a.x + b.x), 0.5 * (a.y + b.y)
    return Touching(-math.inf, scale * x, scale * y, 1, mid_x, mid_y, mid_x, mid_y)


@inlined
def _sides(owner: Frame, other: Frame) -> tuple[float, float, float]:
    """Of the sides of an outline that which the other is furthest beyond: how far, and its normal in world axes."""
    dx, dy = other.x - owner.x, other.y - owner.y
    ahead, aside = owner.cos * dx + owner.sin * dy, owner.cos * dy - owner.sin * dx
    c = abs(owner.cos * other.cos + owner.sin * other.sin)
    s = abs(owner.cos * other.sin - owner.sin * other.cos)
    gap_ahead = abs(ahead) - owner.half_length - other.half_length * c - other.half_width * s
    gap_aside = abs(aside) - owner.half_width - other.half_length * s - other.half_width * c
    if gap_ahead >= gap_aside:
        sign = 1.0 if ahead >= 0.0 else -1.0
        return gap_ahead, sign * owner.cos, sign * owner.sin
    sign = 1.0 if aside >= 0.0 else -1.0
    return gap_aside, -sign * owner.sin, sign * owner.cos


@inlined
def _on_side(owner: Frame, other: Frame, gap: float, nx: float, ny: float, sign: float) -> Touching:
    """The nearest side of `other`, cut to the owner's side with normal (nx, ny); `sign` -1 turns the normal round."""
    face = abs(nx * owner.cos + ny * owner.sin) > 0.5  # front or rear; else left or right
    depth, reach = (owner.half_length, owner.half_width) if face else (owner.half_width, owner.half_length)
    start, end = _facing_side(other, nx, ny)
    first = _cut(owner, nx, ny, start, end, reach)
    second = _cut(owner, nx, ny, end, start, reach)
    if second[0] < first[0]:
        first, second = second, first
    count = 1 if second[0] - first[0] > FLAT or abs(second[1] - first[1]) < FLAT else 2
    x1, y1 = _in_world(owner, nx, ny, 0.5 * (depth + first[0]), first[1])
    x2, y2 = _in_world(owner, nx, ny, 0.5 * (depth + second[0]), second[1])
    return Touching(gap, sign * nx, sign * ny, count, x1, y1, x2, y2)


@inlined
def _facing_side(box: Frame, nx: float, ny: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """The two corners of the side that looks most against a direction."""
    along, across = nx * box.cos + ny * box.sin, ny * box.cos - nx * box.sin
    lx, ly = box.half_length * box.cos, box.half_length * box.sin
    wx, wy = -box.half_width * box.sin, box.half_width * box.cos
    if abs(along) >= abs(across):
        sign = -1.0 if along >= 0.0 else 1.0
        x, y = box.x + sign * lx, box.y + sign * ly
        return (x + wx, y + wy), (x - wx, y - wy)
    sign = -1.0 if across >= 0.0 else 1.0
    x, y = box.x + sign * wx, box.y + sign * wy
    return (x + lx, y + ly), (x - lx, y - ly)


@inlined
def _cut(
    owner: Frame, nx: float, ny: float, point: tuple[float, float], towards: tuple[float, float], reach: float
) -> tuple[float, float]:
    """A point, or where the way from it to another first lies beside the owner: (ahead along n, aside along t)."""
    x, y = point[0] - owner.x, point[1] - owner.y
    ahead, aside = x * nx + y * ny, y * nx - x * ny
    way_x, way_y = towards[0] - point[0], towards[1] - point[1]
    way_ahead, way_aside = way_x * nx + way_y * ny, way_y * nx - way_x * ny
    held = min(reach, max(-reach, aside))
    if held != aside and way_aside != 0.0:
        part = min(1.0, max(0.0, (held - aside) / way_aside))
        return ahead + part * way_ahead, min(reach, max(-reach, aside + part * way_aside))
    return ahead, held


@inlined
def _in_world(owner: Frame, nx: float, ny: float, ahead: float, aside: float) -> tuple[float, float]:
    return owner.x + ahead * nx - aside * ny, owner.y + ahead * ny + aside * nx


@inlined
def add_contact(contacts: Floats, count: int, one: int, other: int, found: Touching) -> None:
    """Write a contact into row `count`."""
    contacts[count, Contact.ONE], contacts[count, Contact.OTHER] = one, other
    contacts[count, Contact.NX], contacts[count, Contact.NY] = found.nx, found.ny
    contacts[count, Contact.POINTS] = found.points
    contacts[count, Contact.X1], contacts[count, Contact.Y1] = found.x1, found.y1
    contacts[count, Contact.X2], contacts[count, Contact.Y2] = found.x2, found.y2


@inlined
def closing(bodies: Floats, contacts: Floats, contact: int) -> float:
    """The fastest that the bodies approach at a point of their contact [m/s]; negative where they part."""
    fastest = -math.inf
    for point in range(int(contacts[contact, Contact.POINTS])):
        x, y = contacts[contact, Contact.X1 + 2 * point], contacts[contact, Contact.Y1 + 2 * point]
        one, other = int(contacts[contact, Contact.ONE]), int(contacts[contact, Contact.OTHER])
        vx = _velocity_x(bodies, other, y) - _velocity_x(bodies, one, y)
        vy = _velocity_y(bodies, other, x) - _velocity_y(bodies, one, x)
        fastest = max(fastest, -(vx * contacts[contact, Contact.NX] + vy * contacts[contact, Contact.NY]))
    return fastest


@inlined
def _velocity_x(bodies: Floats, body: int, y: float) -> float:
    return bodies[body, Body.VX] - bodies[body, Body.SPIN] * (y - bodies[body, Body.Y])


@inlined
def _velocity_y(bodies: Floats, body: int, x: float) -> float:
    return bodies[body, Body.VY] + bodies[body, Body.SPIN] * (x - bodies[body, Body.X])


# -- rows: directions at contacts --------------------------------------------------------------------------------------


@inlined
def lay_out(bodies: Floats, contacts: Floats, contact: int, rows: Floats) -> None:
    """The rows of a contact: the normal at each of its points, and the tangent at their middle."""
    nx, ny = contacts[contact, Contact.NX], contacts[contact, Contact.NY]
    x1, y1 = contacts[contact, Contact.X1], contacts[contact, Contact.Y1]
    x, y = x1, y1
    _lay(bodies, contacts, contact, rows, 3 * contact, nx, ny, x1, y1)
    if contacts[contact, Contact.POINTS] > 1.0:
        x2, y2 = contacts[contact, Contact.X2], contacts[contact, Contact.Y2]
        x, y = 0.5 * (x1 + x2), 0.5 * (y1 + y2)
        _lay(bodies, contacts, contact, rows, 3 * contact + 1, nx, ny, x2, y2)
    _lay(bodies, contacts, contact, rows, 3 * contact + 2, -ny, nx, x, y)


@inlined
def _lay(
    bodies: Floats, contacts: Floats, contact: int, rows: Floats, row: int, nx: float, ny: float, x: float, y: float
) -> None:
    """A row: a direction at a point of a contact."""
    one, other = int(contacts[contact, Contact.ONE]), int(contacts[contact, Contact.OTHER])
    lever_one = (x - bodies[one, Body.X]) * ny - (y - bodies[one, Body.Y]) * nx
    lever_other = (x - bodies[other, Body.X]) * ny - (y - bodies[other, Body.Y]) * nx
    rows[row, Row.X], rows[row, Row.Y] = nx, ny
    rows[row, Row.LEVER_ONE], rows[row, Row.LEVER_OTHER] = lever_one, lever_other
    rows[row, Row.RESPONSE] = (
        bodies[one, Body.LIGHTNESS]
        + bodies[other, Body.LIGHTNESS]
        + lever_one * lever_one * bodies[one, Body.EASE]
        + lever_other * lever_other * bodies[other, Body.EASE]
    )
    rows[row, Row.SPEED] = speed_along(bodies, contacts, rows, row)


@inlined
def speed_along(bodies: Floats, contacts: Floats, rows: Floats, row: int) -> float:
    """Relative speed along a row's direction [m/s]."""
    one, other = int(contacts[row // 3, Contact.ONE]), int(contacts[row // 3, Contact.OTHER])
    return (
        (bodies[other, Body.VX] - bodies[one, Body.VX]) * rows[row, Row.X]
        + (bodies[other, Body.VY] - bodies[one, Body.VY]) * rows[row, Row.Y]
        + bodies[other, Body.SPIN] * rows[row, Row.LEVER_OTHER]
        - bodies[one, Body.SPIN] * rows[row, Row.LEVER_ONE]
    )


@inlined
def push(bodies: Floats, contacts: Floats, rows: Floats, row: int, impulse: float) -> None:
    """Give the other body an impulse along a row's direction, and the one body its opposite."""
    one, other = int(contacts[row // 3, Contact.ONE]), int(contacts[row // 3, Contact.OTHER])
    x, y = impulse * rows[row, Row.X], impulse * rows[row, Row.Y]
    bodies[one, Body.VX] -= x * bodies[one, Body.LIGHTNESS]
    bodies[one, Body.VY] -= y * bodies[one, Body.LIGHTNESS]
    bodies[one, Body.SPIN] -= impulse * rows[row, Row.LEVER_ONE] * bodies[one, Body.EASE]
    bodies[other, Body.VX] += x * bodies[other, Body.LIGHTNESS]
    bodies[other, Body.VY] += y * bodies[other, Body.LIGHTNESS]
    bodies[other, Body.SPIN] += impulse * rows[row, Row.LEVER_OTHER] * bodies[other, Body.EASE]
