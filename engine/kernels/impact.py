"""Impacts of rigid bodies in the plane: what all contacts of one instant do together.

The laws, at each contact point with closing speed w (negative: approaching) along the normal n and slip u along the
tangent:

    w+ >= -e min(w, 0),   p >= 0,   p (w+ + e min(w, 0)) = 0      Newton's restitution e, impulse p on the normal
    |q| <= mu p,   u+ = 0 or q = -mu p sign(u+)                    Coulomb's friction mu on the final slip

All contacts of an instant are solved together, so that a body pinched between two others gets from both. Two faces
that meet flat touch in two points and rub along one line. Newton's law may add energy where friction turns the slip
around (Kane and Levinson 1985, "Dynamics: Theory and Applications", section 5.8). There restitution is lessened until
none is added: without it, contacts take energy only.

Source: Stronge 2018, "Impact Mechanics", 2nd ed., chapters 3 and 8; the sweeps are projected Gauss-Seidel (Moreau 1999,
"Numerical aspects of the sweeping process"), their end is solved as the linear equations that hold there.
"""

import math

import numpy as np

from engine.kernels.contact import ROW, Body, Contact, Row, lay_out, push, speed_along
from engine.kernels.jit import allocating, inlined, kernel
from engine.tables import Floats

LEAST_RESTITUTION_SPEED = 0.1
"""Whatever closes more slowly does not bounce, so that no body bounces for ever [m/s]."""
ROUNDS = 8
"""Of sweeps, each of twice as many as the one before; after each the equations are tried."""
FIRST_SWEEPS = 20
SETTLED = 1e-14
"""Of the fastest closing speed: sweeps that change less are over."""
HOLDS = 1e-10
"""Of the fastest closing speed: how exactly a solution of the equations must obey the laws."""
SINGULAR = 1e-11
"""Equations whose pivot is no larger repeat others: their impulse is another's."""


# -- what the contacts of an instant do --------------------------------------------------------------------------------


@allocating
def resolve(bodies: Floats, contacts: Floats, restitution: float, friction: float) -> None:
    """Give all bodies their velocities after the impact, and all contacts their impulses."""
    rows = np.zeros((3 * len(contacts), ROW))
    for contact in range(len(contacts)):
        lay_out(bodies, contacts, contact, rows)
    before = bodies[:, Body.VX : Body.SPIN + 1].copy()
    impulses = np.zeros(len(rows))
    _solve(bodies, contacts, rows, impulses, restitution, friction)
    if _work(contacts, rows, impulses, bodies) > 0.0:
        bouncing = impulses.copy()
        _set_velocities(bodies, before)
        _solve(bodies, contacts, rows, impulses, 0.0, friction)
        _lessen(bodies, contacts, rows, impulses, bouncing, before)
    for contact in range(len(contacts)):
        for part in range(3):
            contacts[contact, Contact.PUSH1 + part] = impulses[3 * contact + part]


@inlined
def _set_velocities(bodies: Floats, velocities: Floats) -> None:
    """Give each body its row of `velocities`; a loop, since an assigned slice takes half a second to compile."""
    for body in range(len(bodies)):
        for part in range(3):
            bodies[body, Body.VX + part] = velocities[body, part]


@inlined
def _copy(source: Floats, target: Floats) -> None:
    for i in range(len(source)):
        target[i] = source[i]


@inlined
def _target(rows: Floats, row: int, restitution: float) -> float:
    """The least speed on a normal after the impact [m/s]."""
    speed = rows[row, Row.SPEED]
    return -restitution * speed if speed < -LEAST_RESTITUTION_SPEED else 0.0


@kernel
def _solve(
    bodies: Floats, contacts: Floats, rows: Floats, impulses: Floats, restitution: float, friction: float
) -> None:
    """Sweep over all rows until the laws hold; what they hold as equations is solved at once."""
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
    """Let each row obey its law, one after another; the largest change of a relative speed [m/s]."""
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
    """Take pushing normals and sticking tangents as they are now and solve for them; whether the laws hold then.

    A tangent that slips has the impulse of its normals times the friction, so it is no unknown of its own.
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
    """Push along a row, and rub with it where its contact slips."""
    push(bodies, contacts, rows, row, impulse)
    tangent = row - row % 3 + 2
    if slips[tangent] != 0.0:
        push(bodies, contacts, rows, tangent, slips[tangent] * impulse)


@allocating
def _eliminate(matrix: Floats, wanted: Floats) -> None:
    """Solve in place by Gauss's elimination with pivots from all that is left; unknowns that repeat others are 0."""
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
    """Whether velocities and impulses obey all laws, to a tolerance of speed [m/s]."""
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
    """Energy that impulses bring [J]: each times the mean of the speeds along it before and after."""
    work = 0.0
    for row in range(len(rows)):
        if rows[row, Row.RESPONSE] > 0.0 and impulses[row] != 0.0:
            work += 0.5 * impulses[row] * (rows[row, Row.SPEED] + speed_along(bodies, contacts, rows, row))
    return work


@allocating
def _lessen(bodies: Floats, contacts: Floats, rows: Floats, impulses: Floats, bouncing: Floats, before: Floats) -> None:
    """Mix the impulses without restitution with those that bounced: as much of these as brings no energy.

    The work of a mix with the share s of bouncing impulses is a parabola in s, known from three of its values.
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
    """Where in [0, 1] a parabola that is negative at 0 and positive at 1 becomes positive."""
    bend = 2.0 * (start - 2.0 * middle + end)
    slope = end - start - bend
    if not start < 0.0:
        return 0.0
    root = math.sqrt(max(0.0, slope * slope - 4.0 * bend * start))
    # The form that does not lose digits where the bend is small.
    share = 2.0 * -start / (slope + root) if slope + root > 0.0 else 0.0
    return min(1.0, max(0.0, share))
