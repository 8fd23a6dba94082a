"""Outlines (oriented rectangles) at an instant: distances of two, and fields of view."""

import math
from typing import NamedTuple

from engine.kernels.jit import inlined, kernel
from engine.tables import Floats
from engine.vocabulary import State

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
    """Owner of the side to which the direction is normal: `SIDE_OF_A` or `SIDE_OF_B`; `CORNERS`: no side."""


@kernel
def box_distance(a: Box, b: Box) -> float:
    """Return the distance between two outlines [m]; 0.0 if they touch or overlap."""
    return nearest_points(frame(a), frame(b)).distance


@inlined
def half_diagonal(box: Box) -> float:
    """Return the radius of the circumscribed circle [m]."""
    return 0.5 * math.sqrt(box.length * box.length + box.width * box.width)


@inlined
def shortest_turn(start: float, end: float) -> float:
    """Return the turn from one heading to another, at most half a circle [rad]."""
    turn = end - start
    return turn if -math.pi <= turn <= math.pi else turn - 2.0 * math.pi * math.floor(turn / (2.0 * math.pi) + 0.5)


@inlined
def frame(box: Box) -> Frame:
    """Return the box as a frame."""
    return Frame(box.x, box.y, math.cos(box.heading), math.sin(box.heading), 0.5 * box.length, 0.5 * box.width)


@inlined
def building(buildings: Floats, number: int) -> Box:
    """Return the outline of a building of the road."""
    row = buildings[number]
    return Box(row[0], row[1], row[2], row[3], row[4])


@inlined
def outline_at(states: Floats, k: int, actor: int, outlines: Floats) -> Box:
    """Return an actor's outline at sample k. `outlines` (actors, at least 2): length, width [m]."""
    return Box(
        states[k, actor, State.X],
        states[k, actor, State.Y],
        states[k, actor, State.HEADING],
        outlines[actor, 0],
        outlines[actor, 1],
    )


@inlined
def outline_between(states: Floats, k: int, after: int, part: float, actor: int, outlines: Floats) -> Box:
    """Return an actor's outline a part (0..1) of the way from sample k to another, turned by the shortest turn."""
    turn = shortest_turn(states[k, actor, State.HEADING], states[after, actor, State.HEADING])
    return Box(
        states[k, actor, State.X] + part * (states[after, actor, State.X] - states[k, actor, State.X]),
        states[k, actor, State.Y] + part * (states[after, actor, State.Y] - states[k, actor, State.Y]),
        states[k, actor, State.HEADING] + part * turn,
        outlines[actor, 0],
        outlines[actor, 1],
    )


@kernel
def nearest_points(a: Frame, b: Frame) -> Nearest:
    """Return the nearest points of two outlines, after a test of the separating axes for overlap.

    Without an overlap, the distance is the least of the eight distances from a corner to the other box.
    """
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
    square_b, b_x, b_y = _nearest_corner(a, Frame(bx, by, cos, sin, b.half_length, b.half_width))
    square_a, a_x, a_y = _nearest_corner(b, Frame(ax, ay, cos, -sin, a.half_length, a.half_width))
    if square_b <= square_a:
        return _in_world(square_b, b_x, b_y, a.cos, a.sin, SIDE_OF_A)
    return _in_world(square_a, -a_x, -a_y, b.cos, b.sin, SIDE_OF_B)


@inlined
def _in_world(square: float, x: float, y: float, cos: float, sin: float, owner: int) -> Nearest:
    """Return the offset (x, y) in the owner's frame as a `Nearest`; an offset along an axis is normal to a side."""
    distance = math.sqrt(square)
    if distance == 0.0:
        return Nearest(0.0, 0.0, 0.0, CORNERS)
    owner = owner if x == 0.0 or y == 0.0 else CORNERS
    return Nearest(distance, (cos * x - sin * y) / distance, (sin * x + cos * y) / distance, owner)


@inlined
def _nearest_corner(box: Frame, other: Frame) -> tuple[float, float, float]:
    """Return the squared distance and the offset from a box to the nearest corner of another, given in its axes."""
    lx, ly = other.half_length * other.cos, other.half_length * other.sin
    wx, wy = -other.half_width * other.sin, other.half_width * other.cos
    best, best_x, best_y = math.inf, 0.0, 0.0
    for along, across in ((1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)):
        corner_x, corner_y = other.x + along * lx + across * wx, other.y + along * ly + across * wy
        off_x = corner_x - min(box.half_length, max(-box.half_length, corner_x))
        off_y = corner_y - min(box.half_width, max(-box.half_width, corner_y))
        square = off_x * off_x + off_y * off_y
        if square < best:
            best, best_x, best_y = square, off_x, off_y
    return best, best_x, best_y


class View(NamedTuple):
    """A field of view: apex x, y [m], axis heading [rad], full opening angle [rad], radius [m]."""

    x: float
    y: float
    heading: float
    angle: float
    distance: float
