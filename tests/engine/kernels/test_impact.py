"""One impulse solver for all contacts of an instant: closed forms, conservation, bodies pinched between others."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.kernels.geometry import Box, frame
from engine.kernels.impacts.solver import Body, Contact, add_contact, closing, contact_geometry, resolve
from engine.tables import Floats
from engine.vehicles import BICYCLE, BUS, CAR, MODELS, ActorModel
from engine.vocabulary import ActorKind
from tests.laws import examples

RESTITUTION, FRICTION = 0.15, 0.5
VELOCITY = [Body.VX, Body.VY, Body.SPIN]


def body(x: float, y: float, vx: float, vy: float, spin: float, mass: float, inertia: float) -> list[float]:
    return [x, y, vx, vy, spin, 1.0 / mass, 1.0 / inertia]


def of(model: ActorModel, x: float, y: float, vx: float, vy: float = 0.0, spin: float = 0.0) -> list[float]:
    return body(x, y, vx, vy, spin, model.mass, model.yaw_inertia)


def contact(one: int, other: int, angle: float, *points: tuple[float, float]) -> list[float]:
    row = [0.0] * len(Contact)
    row[Contact.ONE], row[Contact.OTHER] = one, other
    row[Contact.NX], row[Contact.NY] = math.cos(angle), math.sin(angle)
    row[Contact.POINTS] = len(points)
    for k, point in enumerate(points):
        row[Contact.X1 + 2 * k : Contact.X1 + 2 * k + 2] = point
    return row


def after(bodies: Floats, contacts: Floats, e: float = RESTITUTION, mu: float = FRICTION) -> Floats:
    """The bodies after an impact."""
    result = bodies.copy()
    resolve(result, contacts, e, mu)
    return result


def masses(bodies: Floats) -> tuple[Floats, Floats]:
    """Masses and inertias; 0 for what is fixed."""
    with np.errstate(divide="ignore"):
        mass, inertia = 1.0 / bodies[:, Body.INVERSE_MASS], 1.0 / bodies[:, Body.INVERSE_INERTIA]
    return np.where(np.isfinite(mass), mass, 0.0), np.where(np.isfinite(inertia), inertia, 0.0)


def energy(bodies: Floats) -> float:
    mass, inertia = masses(bodies)
    square = bodies[:, Body.VX] ** 2 + bodies[:, Body.VY] ** 2
    return float(0.5 * (mass * square + inertia * bodies[:, Body.SPIN] ** 2).sum())


def momentum(bodies: Floats) -> Floats:
    """Linear momentum, and angular momentum about the origin."""
    mass, inertia = masses(bodies)
    px, py = mass * bodies[:, Body.VX], mass * bodies[:, Body.VY]
    turning = bodies[:, Body.X] * py - bodies[:, Body.Y] * px + inertia * bodies[:, Body.SPIN]
    return np.array([px.sum(), py.sum(), turning.sum()])


# -- one contact, by its closed form -----------------------------------------------------------------------------------


def relative(bodies: Floats, row: Floats) -> Floats:
    """Velocity of the other body's contact point relative to the one's: along normal and tangent."""
    n = row[[Contact.NX, Contact.NY]]
    t = np.array([-n[1], n[0]])
    point = row[[Contact.X1, Contact.Y1]]
    velocity = np.zeros(2)
    for sign, which in ((-1.0, Contact.ONE), (1.0, Contact.OTHER)):
        b = bodies[int(row[which])]
        arm = point - b[[Body.X, Body.Y]]
        velocity += sign * (b[[Body.VX, Body.VY]] + b[Body.SPIN] * np.array([-arm[1], arm[0]]))
    return np.array([velocity @ n, velocity @ t])


def closed_form(bodies: Floats, row: Floats, e: float, mu: float) -> Floats:
    """The impulse of a single contact: it sticks, or slips one way or the other (Stronge 2018, section 3.5)."""
    n = row[[Contact.NX, Contact.NY]]
    t = np.array([-n[1], n[0]])
    response = np.zeros((2, 2))
    for which in (Contact.ONE, Contact.OTHER):
        b = bodies[int(row[which])]
        arm = row[[Contact.X1, Contact.Y1]] - b[[Body.X, Body.Y]]
        levers = np.array([arm[0] * n[1] - arm[1] * n[0], arm[0] * t[1] - arm[1] * t[0]])
        response += b[Body.INVERSE_MASS] * np.eye(2) + b[Body.INVERSE_INERTIA] * np.outer(levers, levers)
    before = relative(bodies, row)
    if before[0] >= 0.0:
        return np.zeros(2)
    wanted = np.array([-(1.0 + e) * before[0], -before[1]])
    stick = np.linalg.solve(response, wanted)
    if abs(stick[1]) <= mu * stick[0]:
        return stick
    for sign in (1.0, -1.0):
        push = wanted[0] / (response[0, 0] + sign * mu * response[0, 1])
        slip = before[1] + push * (response[1, 0] + sign * mu * response[1, 1])
        if push >= 0.0 and sign * slip <= 1e-12:
            return np.array([push, sign * mu * push])
    raise AssertionError("no case holds")


def brought(bodies: Floats, row: Floats, impulse: Floats) -> Floats:
    """The bodies after a given impulse on normal and tangent."""
    result = bodies.copy()
    n = row[[Contact.NX, Contact.NY]]
    force = impulse[0] * n + impulse[1] * np.array([-n[1], n[0]])
    for sign, which in ((-1.0, Contact.ONE), (1.0, Contact.OTHER)):
        b = result[int(row[which])]
        arm = row[[Contact.X1, Contact.Y1]] - b[[Body.X, Body.Y]]
        b[[Body.VX, Body.VY]] += sign * force * b[Body.INVERSE_MASS]
        b[Body.SPIN] += sign * (arm[0] * force[1] - arm[1] * force[0]) * b[Body.INVERSE_INERTIA]
    return result


speeds, spins, places = st.floats(-25.0, 25.0), st.floats(-3.0, 3.0), st.floats(-2.5, 2.5)
kinds = st.sampled_from([kind for kind in ActorKind if kind is not ActorKind.OBSTACLE])


@st.composite
def single_contacts(draw: st.DrawFn) -> tuple[Floats, Floats]:
    """Two bodies on the two sides of a contact at the origin, the second one perhaps a wall."""
    angle = draw(st.floats(-math.pi, math.pi))
    n, rows = np.array([math.cos(angle), math.sin(angle)]), []
    for side in (-1.0, 1.0):
        model = MODELS[draw(kinds)]
        # A point on the outline's edge, so that levers are those of boxes.
        behind, aside = 0.5 * model.length, draw(st.floats(-0.5, 0.5)) * model.width
        x, y = side * behind * n + aside * np.array([-n[1], n[0]])
        rows.append(of(model, x, y, draw(speeds), draw(speeds), draw(spins)))
    if draw(st.booleans()):
        rows[1] = [*rows[1][:2], 0.0, 0.0, 0.0, 0.0, 0.0]
    return np.array(rows), np.array([contact(0, 1, angle, (0.0, 0.0))])


@examples(300)
@given(single_contacts(), st.floats(0.0, 1.0), st.floats(0.0, 0.8))
def test_a_single_contact_has_its_closed_form(scene: tuple[Floats, Floats], e: float, mu: float) -> None:
    """Stick and slip, to 1e-9 m/s, where Newton's law brings no energy; where it would, it brings none."""
    bodies, contacts = scene
    if abs(relative(bodies, contacts[0])[0]) < 0.1:
        return
    expected = brought(bodies, contacts[0], closed_form(bodies, contacts[0], e, mu))
    found = after(bodies, contacts, e, mu)
    if energy(expected) <= energy(bodies):
        assert found == pytest.approx(expected, abs=1e-9)
    else:
        assert energy(found) == pytest.approx(energy(bodies), rel=1e-9)
        assert relative(found, contacts[0])[0] >= -1e-9


def test_head_on_equals_change_by_half_of_one_plus_e() -> None:
    """Two cars at 10 m/s each, flat on: each changes by 11.5 m/s and neither turns."""
    x = 0.5 * CAR.length
    bodies = np.array([of(CAR, -x, 0, 10), of(CAR, x, 0, -10)])
    found = after(bodies, np.array([contact(0, 1, 0.0, (0, -0.8), (0, 0.8))]))
    assert found[:, Body.VX] == pytest.approx([-1.5, 1.5], abs=1e-12)
    assert found[:, Body.SPIN] == pytest.approx([0.0, 0.0], abs=1e-12)


def test_a_flat_contact_off_centre_pushes_at_its_inner_corner() -> None:
    """Of a side that overlaps half, the corner nearer to the centres takes all: the outer one parts as both turn."""
    x = 0.5 * CAR.length
    bodies = np.array([of(CAR, -x, 0, 10), of(CAR, x, 1.2, -10)])
    contacts = np.array([contact(0, 1, 0.0, (0, 0.4), (0, 0.8))])
    resolve(bodies, contacts, RESTITUTION, 0.0)
    pushes = contacts[0, [Contact.IMPULSE1, Contact.IMPULSE2]]
    assert sorted(pushes > 0.0) == [False, True] or np.all(pushes > 0.0)
    assert bodies[0, Body.SPIN] * bodies[1, Body.SPIN] > 0.0


# -- several contacts at once ------------------------------------------------------------------------------------------


@st.composite
def heaps(draw: st.DrawFn) -> tuple[Floats, Floats]:
    """Up to six bodies, some fixed, with up to eight contacts anywhere between them, flat or at a corner."""
    count = draw(st.integers(2, 6))
    rows = []
    for _ in range(count):
        row = of(MODELS[draw(kinds)], draw(places), draw(places), draw(speeds), draw(speeds), draw(spins))
        rows.append([*row[:2], 0.0, 0.0, 0.0, 0.0, 0.0] if draw(st.integers(0, 4)) == 0 else row)
    contacts = []
    for _ in range(draw(st.integers(1, 8))):
        one = draw(st.integers(0, count - 2))
        other = draw(st.integers(one + 1, count - 1))
        if rows[one][Body.INVERSE_MASS] + rows[other][Body.INVERSE_MASS] == 0.0:
            continue
        angle, point = draw(st.floats(-math.pi, math.pi)), (draw(places), draw(places))
        wide = draw(st.sampled_from([0.0, 0.7]))
        second = (point[0] - wide * math.sin(angle), point[1] + wide * math.cos(angle))
        contacts.append(contact(one, other, angle, *((point, second) if wide else (point,))))
    return np.array(rows), np.array(contacts).reshape(-1, len(Contact))


@examples(200)
@given(heaps())
def test_heaps_keep_momentum_and_gain_no_energy(scene: tuple[Floats, Floats]) -> None:
    """Whatever touches whatever: numbers stay numbers, momentum holds to 1e-9, energy does not rise."""
    bodies, contacts = scene
    found = after(bodies, contacts)
    assert np.isfinite(found).all()
    assert energy(found) <= energy(bodies) * (1.0 + 1e-9)
    if np.all(bodies[:, Body.INVERSE_MASS] > 0.0):
        mass, _ = masses(bodies)
        size = float(np.abs(mass[:, None] * bodies[:, [Body.VX, Body.VY]]).sum()) + 1.0
        assert momentum(found) == pytest.approx(momentum(bodies), abs=1e-9 * size)
    fixed = bodies[:, Body.INVERSE_MASS] == 0.0
    assert np.array_equal(found[fixed], bodies[fixed])


@pytest.mark.parametrize("speed", [3.0, 15.0, 30.0])
def test_a_bicycle_between_a_bus_and_a_wall(speed: float) -> None:
    """Nobody is left faster than the bus was, and the bicycle does not move away from the wall into the bus."""
    bus, wall = of(BUS, -0.5 * BUS.length - BICYCLE.length, 0, speed), [5.0, 0, 0, 0, 0, 0, 0]
    bodies = np.array([bus, of(BICYCLE, -0.5 * BICYCLE.length, 0, 0), wall])
    back = -BICYCLE.length
    contacts = np.array([contact(0, 1, 0.0, (back, -0.3), (back, 0.3)), contact(1, 2, 0.0, (0, -0.3), (0, 0.3))])
    found = after(bodies, contacts)
    assert np.all(np.hypot(found[:, Body.VX], found[:, Body.VY]) <= speed * (1.0 + 1e-9))
    # Both contacts part by Newton's law: the bus from the bicycle at e times its speed, the bicycle from the wall at 0.
    assert found[1, Body.VX] <= 1e-9
    assert found[1, Body.VX] - found[0, Body.VX] == pytest.approx(RESTITUTION * speed, abs=1e-6)


def test_three_bodies_in_one_point() -> None:
    """Three cars that meet at one point from three sides: as the picture, the result has its symmetry."""
    rows, contacts = [], []
    for k in range(3):
        angle = 2 * math.pi * k / 3
        c, s = math.cos(angle), math.sin(angle)
        rows.append(of(CAR, -2.0 * c, -2.0 * s, 10 * c, 10 * s))
    for one, other in ((0, 1), (0, 2), (1, 2)):
        way = np.array(rows[other][:2]) - np.array(rows[one][:2])
        contacts.append(contact(one, other, math.atan2(way[1], way[0]), (0.0, 0.0)))
    found = after(np.array(rows), np.array(contacts))
    assert np.isfinite(found).all()
    out = np.hypot(found[:, Body.VX], found[:, Body.VY])
    assert out == pytest.approx([out[0]] * 3, abs=1e-9)
    assert out[0] <= 10.0
    assert momentum(found)[:2] == pytest.approx([0.0, 0.0], abs=1e-6)


def test_no_contacts_change_nothing() -> None:
    """An instant without contacts, and one whose bodies part, leave all velocities as they are."""
    bodies = np.array([of(CAR, -3, 0, -1), of(CAR, 3, 0, 1)])
    for contacts in (np.zeros((0, len(Contact))), np.array([contact(0, 1, 0.0, (0, 0))])):
        assert np.array_equal(after(bodies, contacts), bodies)


# -- where outlines touch ----------------------------------------------------------------------------------------------


def meeting(a: Box, b: Box) -> tuple[Floats, Floats]:
    """The touching of two outlines as a contact of bodies at rest."""
    found = contact_geometry(frame(a), frame(b))
    rows = np.zeros((1, len(Contact)))
    add_contact(rows, 0, 0, 1, found)
    return np.array([[box.x, box.y, 0.0, 0.0, 0.0, 1.0, 1.0] for box in (a, b)]), rows


def test_flat_sides_touch_at_the_ends_of_their_overlap() -> None:
    """A car 1 m to the left behind another: both points of the overlap, and the normal straight ahead."""
    _, rows = meeting(Box(0, 0, 0, 4, 2), Box(4.0, 1.0, 0.0, 4, 2))
    assert rows[0, Contact.POINTS] == 2
    assert rows[0, [Contact.NX, Contact.NY]] == pytest.approx([1, 0])
    assert sorted(rows[0, [Contact.Y1, Contact.Y2]]) == pytest.approx([0, 1])
    assert rows[0, [Contact.X1, Contact.X2]] == pytest.approx([2, 2])


def test_a_corner_touches_in_a_point() -> None:
    """A corner against a side: that corner, and the side's normal, whoever is asked first."""
    a, b = Box(0, 0, 0, 4, 2), Box(2 + math.sqrt(2), 0.3, math.pi / 4, 2, 2)
    for one, other, sign in ((a, b, 1), (b, a, -1)):
        _, rows = meeting(one, other)
        assert rows[0, Contact.POINTS] == 1
        assert rows[0, [Contact.NX, Contact.NY]] == pytest.approx([sign, 0])
        assert rows[0, [Contact.X1, Contact.Y1]] == pytest.approx([2, 0.3])


@given(st.floats(-math.pi, math.pi), st.floats(-math.pi, math.pi), st.floats(-1.0, 1.0))
def test_normals_part_the_outlines(heading: float, other: float, aside: float) -> None:
    """Moved along the normal by the gap, two outlines touch and no more; approach has the right sign."""
    a = Box(0, 0, heading, 4, 2)
    b = Box(1.5, aside, other, 3, 1)
    found = contact_geometry(frame(a), frame(b))
    moved = Box(b.x - found.gap * found.nx, b.y - found.gap * found.ny, other, 3, 1)
    assert contact_geometry(frame(a), frame(moved)).gap == pytest.approx(0.0, abs=1e-9)
    bodies, rows = meeting(a, b)
    bodies[1, [Body.VX, Body.VY]] = -2 * found.nx, -2 * found.ny
    assert closing(bodies, rows, 0) == pytest.approx(2.0)
