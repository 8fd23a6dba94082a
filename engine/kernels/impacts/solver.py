"""Impacts of rigid bodies in the plane: geometry of contacts, and the velocities after all contacts of an instant.

Bodies are rows of `Body`, contacts rows of `Contact`. Each contact has three rows of `Row`, 3 c to 3 c + 2: the normal
at each of its points, and the tangent at their middle. A fixed body has the inverse mass 0.

Laws at each contact point, with the closing speed w (negative: approaching) along the normal n and the slip u along the
tangent:

    w+ >= -e min(w, 0),   p >= 0,   p (w+ + e min(w, 0)) = 0      Newton's restitution e, impulse p on the normal
    |q| <= mu p,   u+ = 0 or q = -mu p sign(u+)                    Coulomb's friction mu on the final slip

All contacts of an instant are solved together, so that a body between two others receives impulses of both. Two flat
faces have two contact points and one line of friction. Newton's law may add energy where friction reverses the slip
(Kane and Levinson 1985, "Dynamics: Theory and Applications", section 5.8). There the restitution is reduced until no
energy is added; without restitution, contacts never add energy.

Source: Stronge 2018, "Impact Mechanics", 2nd ed., chapters 3 and 8; the sweeps are projected Gauss-Seidel (Moreau 1999,
"Numerical aspects of the sweeping process"), and their limit is solved as a system of linear equations.
"""

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from engine.kernels.geometry import Frame
from engine.kernels.jit import allocating, inlined, kernel
from engine.tables import Floats

FLAT = 0.01
"""Largest difference in depth of two corners that touch together: the faces meet flat [m]."""


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
    INVERSE_MASS = 5
    """[1/kg]; 0 for a fixed body."""
    INVERSE_INERTIA = 6
    """Inverse yaw inertia [1/(kg m^2)]; 0 for a fixed body."""


class Contact(IntEnum):
    """Columns of a contact of two bodies."""

    ONE = 0
    """Row of the body from which the normal points away."""
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
    IMPULSE1 = 9
    """Impulse on the other body along the normal at the first point [N s]; written by `resolve`."""
    IMPULSE2 = 10
    FRICTION = 11
    """Impulse on the other body along the tangent (-NY, NX) [N s]."""


class Row(IntEnum):
    """Columns of a constraint at a contact: a direction and the response to a unit of impulse along it."""

    X = 0
    Y = 1
    LEVER_ONE = 2
    """Arm x direction [m]."""
    LEVER_OTHER = 3
    RESPONSE = 4
    """Change of the relative speed by a unit of impulse [1/kg]; 0: unused row."""
    SPEED = 5
    """Relative speed before the impact [m/s]."""


BODY, CONTACT, ROW = len(Body), len(Contact), len(Row)
"""Numbers of columns."""


@inlined
def is_fixed(declared: float, mass: float) -> bool:
    """Return True for a body that is declared fixed (`declared` is not 0) or whose mass is not a positive number."""
    return declared != 0.0 or not 0.0 < mass < math.inf


# -- where two outlines touch ------------------------------------------------------------------------------------------


class ContactGeometry(NamedTuple):
    """Contact of two outlines, or their nearest points: normal from the first to the second, and one or two points."""

    gap: float
    """Distance between the outlines along the normal [m]; negative for an overlap."""
    nx: float
    ny: float
    points: int
    x1: float
    y1: float
    x2: float
    y2: float


@kernel
def contact_geometry(a: Frame, b: Frame) -> ContactGeometry:
    """Return the contact at the side with the largest separation; of equal sides, that of the first outline."""
    along, across, turned = _sides(a, b), _sides(b, a), False
    best = along
    if across[0] > along[0] + 1e-9:
        best, turned = across, True
    if turned:
        return _on_side(b, a, best[0], best[1], best[2], -1.0)
    return _on_side(a, b, best[0], best[1], best[2], 1.0)


@inlined
def overlap_contact(a: Frame, b: Frame) -> ContactGeometry:
    """Return the contact of two outlines that overlap too deeply for a separating side.

    The contact is midway between the centres, along the line that joins them; for equal centres the normal is 0.
    """
    x, y = b.x - a.x, b.y - a.y
    apart = math.sqrt(x * x + y * y)
    scale = 1.0 / apart if apart > 0.0 else 0.0
    mid_x, mid_y = 0.5 * (a.x + b.x), 0.5 * (a.y + b.y)
    return ContactGeometry(-math.inf, scale * x, scale * y, 1, mid_x, mid_y, mid_x, mid_y)


@inlined
def _sides(owner: Frame, other: Frame) -> tuple[float, float, float]:
    """Return the side of an outline with the largest separation: (distance [m], normal x, normal y) in world axes."""
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
def _on_side(owner: Frame, other: Frame, gap: float, nx: float, ny: float, sign: float) -> ContactGeometry:
    """Return the nearest side of `other`, clipped to the side of the owner with normal (nx, ny).

    `sign` -1 reverses the normal.
    """
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
    return ContactGeometry(gap, sign * nx, sign * ny, count, x1, y1, x2, y2)


@inlined
def _facing_side(box: Frame, nx: float, ny: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the two corners of the side that faces a direction most."""
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
    """Clip a point on the line towards another to the extent of the owner: (along normal, along tangent) [m]."""
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
def add_contact(contacts: Floats, count: int, one: int, other: int, found: ContactGeometry) -> None:
    """Write a contact into row `count`."""
    contacts[count, Contact.ONE], contacts[count, Contact.OTHER] = one, other
    contacts[count, Contact.NX], contacts[count, Contact.NY] = found.nx, found.ny
    contacts[count, Contact.POINTS] = found.points
    contacts[count, Contact.X1], contacts[count, Contact.Y1] = found.x1, found.y1
    contacts[count, Contact.X2], contacts[count, Contact.Y2] = found.x2, found.y2


@inlined
def closing(bodies: Floats, contacts: Floats, contact: int) -> float:
    """Return the largest closing speed of two bodies at a point of their contact [m/s]; negative if they separate."""
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


class Direction(NamedTuple):
    """A unit vector at a point [m]."""

    x: float
    y: float
    at_x: float
    at_y: float


@inlined
def write_rows(bodies: Floats, contacts: Floats, contact: int, rows: Floats) -> None:
    """Write the rows of a contact: the normal at each of its points, and the tangent at their middle."""
    nx, ny = contacts[contact, Contact.NX], contacts[contact, Contact.NY]
    x1, y1 = contacts[contact, Contact.X1], contacts[contact, Contact.Y1]
    x, y = x1, y1
    _write_row(bodies, contacts, rows, 3 * contact, Direction(nx, ny, x1, y1))
    if contacts[contact, Contact.POINTS] > 1.0:
        x2, y2 = contacts[contact, Contact.X2], contacts[contact, Contact.Y2]
        x, y = 0.5 * (x1 + x2), 0.5 * (y1 + y2)
        _write_row(bodies, contacts, rows, 3 * contact + 1, Direction(nx, ny, x2, y2))
    _write_row(bodies, contacts, rows, 3 * contact + 2, Direction(-ny, nx, x, y))


@inlined
def _write_row(bodies: Floats, contacts: Floats, rows: Floats, row: int, way: Direction) -> None:
    """Write a row: a direction at a point of a contact."""
    one, other = int(contacts[row // 3, Contact.ONE]), int(contacts[row // 3, Contact.OTHER])
    lever_one = (way.at_x - bodies[one, Body.X]) * way.y - (way.at_y - bodies[one, Body.Y]) * way.x
    lever_other = (way.at_x - bodies[other, Body.X]) * way.y - (way.at_y - bodies[other, Body.Y]) * way.x
    rows[row, Row.X], rows[row, Row.Y] = way.x, way.y
    rows[row, Row.LEVER_ONE], rows[row, Row.LEVER_OTHER] = lever_one, lever_other
    rows[row, Row.RESPONSE] = (
        bodies[one, Body.INVERSE_MASS]
        + bodies[other, Body.INVERSE_MASS]
        + lever_one * lever_one * bodies[one, Body.INVERSE_INERTIA]
        + lever_other * lever_other * bodies[other, Body.INVERSE_INERTIA]
    )
    rows[row, Row.SPEED] = speed_along(bodies, contacts, rows, row)


@inlined
def speed_along(bodies: Floats, contacts: Floats, rows: Floats, row: int) -> float:
    """Return the relative speed along the direction of a row [m/s]."""
    one, other = int(contacts[row // 3, Contact.ONE]), int(contacts[row // 3, Contact.OTHER])
    return (
        (bodies[other, Body.VX] - bodies[one, Body.VX]) * rows[row, Row.X]
        + (bodies[other, Body.VY] - bodies[one, Body.VY]) * rows[row, Row.Y]
        + bodies[other, Body.SPIN] * rows[row, Row.LEVER_OTHER]
        - bodies[one, Body.SPIN] * rows[row, Row.LEVER_ONE]
    )


@inlined
def push(bodies: Floats, contacts: Floats, rows: Floats, row: int, impulse: float) -> None:
    """Apply an impulse along the direction of a row to the second body, and its opposite to the first."""
    one, other = int(contacts[row // 3, Contact.ONE]), int(contacts[row // 3, Contact.OTHER])
    x, y = impulse * rows[row, Row.X], impulse * rows[row, Row.Y]
    bodies[one, Body.VX] -= x * bodies[one, Body.INVERSE_MASS]
    bodies[one, Body.VY] -= y * bodies[one, Body.INVERSE_MASS]
    bodies[one, Body.SPIN] -= impulse * rows[row, Row.LEVER_ONE] * bodies[one, Body.INVERSE_INERTIA]
    bodies[other, Body.VX] += x * bodies[other, Body.INVERSE_MASS]
    bodies[other, Body.VY] += y * bodies[other, Body.INVERSE_MASS]
    bodies[other, Body.SPIN] += impulse * rows[row, Row.LEVER_OTHER] * bodies[other, Body.INVERSE_INERTIA]


LEAST_RESTITUTION_SPEED = 0.1
"""Closing speed below which bodies do not bounce [m/s], so that the number of bounces is finite."""
ROUNDS = 8
"""Maximum number of rounds of sweeps; each has twice as many as the last and is followed by a direct solution."""
FIRST_SWEEPS = 20
SETTLED = 1e-14
"""Change of a sweep, relative to the largest closing speed, at which the sweeps have converged."""
HOLDS = 1e-10
"""Tolerance of the laws for a direct solution, relative to the largest closing speed."""
SINGULAR = 1e-11
"""Pivot, relative to the first, at which the remaining equations depend on the others; their unknowns are 0."""


# -- velocities after all contacts of an instant -----------------------------------------------------------------------


@allocating
def resolve(bodies: Floats, contacts: Floats, restitution: float, friction: float) -> None:
    """Write the velocities of all bodies after the impact, and the impulses of all contacts."""
    rows = np.zeros((3 * len(contacts), ROW))
    for contact in range(len(contacts)):
        write_rows(bodies, contacts, contact, rows)
    before = bodies[:, Body.VX : Body.SPIN + 1].copy()
    impulses = np.zeros(len(rows))
    _solve(bodies, contacts, rows, impulses, restitution, friction)
    if _work(contacts, rows, impulses, bodies) > 0.0:
        bouncing = impulses.copy()
        _set_velocities(bodies, before)
        _solve(bodies, contacts, rows, impulses, 0.0, friction)
        _reduce_restitution(bodies, contacts, rows, impulses, bouncing, before)
    for contact in range(len(contacts)):
        for part in range(3):
            contacts[contact, Contact.IMPULSE1 + part] = impulses[3 * contact + part]


@inlined
def _set_velocities(bodies: Floats, velocities: Floats) -> None:
    """Copy `velocities` to the bodies; a loop, because an assigned slice takes half a second to compile."""
    for body in range(len(bodies)):
        for part in range(3):
            bodies[body, Body.VX + part] = velocities[body, part]


@inlined
def _copy(source: Floats, target: Floats) -> None:
    for i in range(len(source)):
        target[i] = source[i]


@inlined
def _target(rows: Floats, row: int, restitution: float) -> float:
    """Return the least speed along a normal after the impact [m/s]."""
    speed = rows[row, Row.SPEED]
    return -restitution * speed if speed < -LEAST_RESTITUTION_SPEED else 0.0


@kernel
def _solve(
    bodies: Floats, contacts: Floats, rows: Floats, impulses: Floats, restitution: float, friction: float
) -> None:
    """Sweep over all rows until the laws hold; the laws that hold as equations are solved directly."""
    impulses[:] = 0.0
    scale = 0.0
    for row in range(len(rows)):
        scale = max(scale, abs(rows[row, Row.SPEED]))
    sweeps = FIRST_SWEEPS
    for _ in range(ROUNDS):
        for _ in range(sweeps):
            change = _sweep(bodies, contacts, rows, impulses, restitution, friction)
            if not change > SETTLED * scale:
                return
        if _solve_equations(bodies, contacts, rows, impulses, restitution, friction, HOLDS * scale):
            return
        sweeps *= 2


@inlined
def _sweep(
    bodies: Floats, contacts: Floats, rows: Floats, impulses: Floats, restitution: float, friction: float
) -> float:
    """Correct each row in turn to satisfy its law; return the largest change of a relative speed [m/s]."""
    largest = 0.0
    for row in range(len(rows)):
        response = rows[row, Row.RESPONSE]
        if response == 0.0:
            continue
        speed, impulse = speed_along(bodies, contacts, rows, row), impulses[row]
        if row % 3 == 2:
            held = friction * (impulses[row - 2] + impulses[row - 1])
            wanted = min(held, max(-held, impulse - speed / response))
        else:
            wanted = max(0.0, impulse + (_target(rows, row, restitution) - speed) / response)
        if wanted != impulse:
            push(bodies, contacts, rows, row, wanted - impulse)
            impulses[row] = wanted
            largest = max(largest, abs(wanted - impulse) * response)
    return largest


# -- the equations that hold in the end --------------------------------------------------------------------------------


@allocating
def _solve_equations(
    bodies: Floats,
    contacts: Floats,
    rows: Floats,
    impulses: Floats,
    restitution: float,
    friction: float,
    tolerance: float,
) -> bool:
    """Solve for the active normals and the sticking tangents; return True if the solution satisfies all laws.

    The impulse of a slipping tangent is that of its normals times the friction, so it is not an unknown.
    """
    size = len(rows)
    slips = np.zeros(size)
    unknown = np.full(size, -1)
    count = 0
    for row in range(size):
        if row % 3 == 2:
            held = friction * (impulses[row - 2] + impulses[row - 1])
            slips[row] = friction * math.copysign(1.0, impulses[row]) if abs(impulses[row]) >= held else 0.0
        if rows[row, Row.RESPONSE] > 0.0 and impulses[row] != 0.0 and slips[row] == 0.0:
            unknown[count] = row
            count += 1
    if count == 0:
        return False
    trial = bodies.copy()
    for row in range(size):
        push(trial, contacts, rows, row, -impulses[row])
    matrix, wanted = np.zeros((count, count)), np.zeros(count)
    base = trial[:, Body.VX : Body.SPIN + 1].copy()
    for column in range(count):
        trial[:, Body.VX : Body.SPIN + 1] = 0.0
        _push_with_slip(trial, contacts, rows, slips, unknown[column], 1.0)
        for line in range(count):
            matrix[line, column] = speed_along(trial, contacts, rows, unknown[line])
    for line in range(count):
        row = unknown[line]
        wanted[line] = (0.0 if row % 3 == 2 else _target(rows, row, restitution)) - rows[row, Row.SPEED]
    _eliminate(matrix, wanted)
    found = np.zeros(size)
    _set_velocities(trial, base)
    for column in range(count):
        row = unknown[column]
        found[row] = wanted[column]
        _push_with_slip(trial, contacts, rows, slips, row, wanted[column])
    for row in range(2, size, 3):
        if slips[row] != 0.0:
            found[row] = slips[row] * (found[row - 2] + found[row - 1])
    if not _laws_hold(trial, contacts, rows, found, restitution, friction, tolerance):
        return False
    _set_velocities(bodies, trial[:, Body.VX : Body.SPIN + 1])
    _copy(found, impulses)
    return True


@inlined
def _push_with_slip(bodies: Floats, contacts: Floats, rows: Floats, slips: Floats, row: int, impulse: float) -> None:
    """Apply an impulse along a row, and the friction that belongs to it if the contact slips."""
    push(bodies, contacts, rows, row, impulse)
    tangent = row - row % 3 + 2
    if slips[tangent] != 0.0:
        push(bodies, contacts, rows, tangent, slips[tangent] * impulse)


@allocating
def _eliminate(matrix: Floats, wanted: Floats) -> None:
    """Solve in place by Gaussian elimination with full pivoting; dependent unknowns are 0."""
    size = len(wanted)
    order = np.arange(size)
    rank, first = 0, 0.0
    for step in range(size):
        best, line, column = 0.0, step, step
        for i in range(step, size):
            for j in range(step, size):
                if abs(matrix[i, j]) > best:
                    best, line, column = abs(matrix[i, j]), i, j
        first = max(first, best)
        if not best > SINGULAR * first:
            break
        for j in range(size):
            matrix[step, j], matrix[line, j] = matrix[line, j], matrix[step, j]
        wanted[step], wanted[line] = wanted[line], wanted[step]
        for i in range(size):
            matrix[i, step], matrix[i, column] = matrix[i, column], matrix[i, step]
        order[step], order[column] = order[column], order[step]
        for i in range(step + 1, size):
            factor = matrix[i, step] / matrix[step, step]
            for j in range(step, size):
                matrix[i, j] -= factor * matrix[step, j]
            wanted[i] -= factor * wanted[step]
        rank += 1
    found = np.zeros(size)
    for step in range(rank - 1, -1, -1):
        value = wanted[step]
        for j in range(step + 1, rank):
            value -= matrix[step, j] * found[order[j]]
        found[order[step]] = value / matrix[step, step]
    _copy(found, wanted)


@kernel
def _laws_hold(
    bodies: Floats,
    contacts: Floats,
    rows: Floats,
    impulses: Floats,
    restitution: float,
    friction: float,
    tolerance: float,
) -> bool:
    """Return True if velocities and impulses satisfy all laws within a tolerance of speed [m/s]."""
    for row in range(len(rows)):
        response, impulse = rows[row, Row.RESPONSE], impulses[row]
        if response == 0.0:
            continue
        speed = speed_along(bodies, contacts, rows, row)
        if row % 3 == 2:
            held = friction * (impulses[row - 2] + impulses[row - 1])
            if not abs(impulse) * response <= held * response + tolerance:
                return False
            if abs(impulse) * response < held * response - tolerance and not abs(speed) <= tolerance:
                return False
            if abs(speed) > tolerance and impulse * speed > 0.0:
                return False
        else:
            missing = _target(rows, row, restitution) - speed
            if not (impulse * response >= -tolerance and missing <= tolerance):
                return False
            if impulse * response > tolerance and not missing >= -tolerance:
                return False
    return True


# -- energy ------------------------------------------------------------------------------------------------------------


@kernel
def _work(contacts: Floats, rows: Floats, impulses: Floats, bodies: Floats) -> float:
    """Return the energy that the impulses add [J]: each times the mean of the speeds along it before and after."""
    work = 0.0
    for row in range(len(rows)):
        if rows[row, Row.RESPONSE] > 0.0 and impulses[row] != 0.0:
            work += 0.5 * impulses[row] * (rows[row, Row.SPEED] + speed_along(bodies, contacts, rows, row))
    return work


@allocating
def _reduce_restitution(
    bodies: Floats, contacts: Floats, rows: Floats, impulses: Floats, bouncing: Floats, before: Floats
) -> None:
    """Interpolate between the impulses without and with restitution, as far as no energy is added.

    The work is a quadratic function of the share of impulses with restitution, determined by three values.
    """
    plain = impulses.copy()
    at = np.zeros(3)
    for k in range(3):
        share = 0.5 * k
        _set_velocities(bodies, before)
        for row in range(len(rows)):
            impulses[row] = plain[row] + share * (bouncing[row] - plain[row])
            push(bodies, contacts, rows, row, impulses[row])
        at[k] = _work(contacts, rows, impulses, bodies)
    share = _crossing(at[0], at[1], at[2])
    _set_velocities(bodies, before)
    for row in range(len(rows)):
        impulses[row] = plain[row] + share * (bouncing[row] - plain[row])
        push(bodies, contacts, rows, row, impulses[row])


@inlined
def _crossing(start: float, middle: float, end: float) -> float:
    """Return the root in [0, 1] of a parabola that is negative at 0 and positive at 1."""
    bend = 2.0 * (start - 2.0 * middle + end)
    slope = end - start - bend
    if not start < 0.0:
        return 0.0
    root = math.sqrt(max(0.0, slope * slope - 4.0 * bend * start))
    # The form that does not lose digits where the bend is small.
    share = 2.0 * -start / (slope + root) if slope + root > 0.0 else 0.0
    return min(1.0, max(0.0, share))
