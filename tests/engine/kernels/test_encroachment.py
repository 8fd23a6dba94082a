"""PET and encroachment time by conflict area: by hand where paths cross, against shapely's areas elsewhere."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely import unary_union
from shapely.geometry import MultiPoint, Polygon
from shapely.geometry.base import BaseGeometry

from engine.kernels.encroachment import OccupancyInterval, encroachment, encroachment_gap
from engine.kernels.encroachment import stays as stays_of
from engine.kernels.geometry import Box
from engine.kernels.swept import LINES, POINTS, Span, hulls_apart, lay, swept
from engine.tables import Floats
from engine.vocabulary import State
from tests.laws import examples

STEP = 0.05
OUTLINES = np.array([[4.0, 2.0, 0.0], [4.0, 2.0, 0.0]])


def drive(x: float, y: float, heading: float, speed: float, turning: float = 0.0, samples: int = 120) -> Floats:
    """A drive at a steady speed and turning rate [rad/s]."""
    states = np.zeros((samples, len(State)))
    headings = heading + turning * STEP * np.arange(samples)
    way = np.column_stack([np.cos(headings), np.sin(headings)]) * speed * STEP
    states[:, [State.X, State.Y]] = np.array([x, y]) + np.vstack([np.zeros(2), np.cumsum(way, axis=0)[:-1]])
    states[:, State.HEADING], states[:, State.SPEED], states[:, State.PRESENT] = headings, speed, 1.0
    return states


def stays(ego: Floats, other: Floats) -> tuple[OccupancyInterval, OccupancyInterval]:
    """Of both, in seconds."""
    states, one, two = together(ego, other)
    found = stays_of(states, one, two, OUTLINES, swept(len(states)))
    return OccupancyInterval(found[0].enter * STEP, found[0].leave * STEP), OccupancyInterval(
        found[1].enter * STEP, found[1].leave * STEP
    )


def together(ego: Floats, other: Floats) -> tuple[Floats, Span, Span]:
    states = np.stack([ego, other], axis=1)
    return states, Span(0, 0, len(states) - 1), Span(1, 0, len(states) - 1)


def gap(ego: Floats, other: Floats) -> float:
    return encroachment_gap(*stays(ego, other))


def test_where_paths_cross_the_area_is_their_square() -> None:
    """The ego is in it from (20 - 3) / 10 to (20 + 3) / 10 s, the other from (40 - 3) / 10 s: 1.4 s later."""
    ego, other = drive(-20, 0, 0, 10), drive(0, -40, math.pi / 2, 10)
    mine, theirs = stays(ego, other)
    assert mine == pytest.approx((1.7, 2.3), abs=1e-9)
    assert theirs == pytest.approx((3.7, 4.3), abs=1e-9)
    assert gap(ego, other) == pytest.approx(1.4, abs=1e-9)
    assert gap(other, ego) == pytest.approx(-1.4, abs=1e-9)


def test_a_slanting_crossing_lies_farther_apart_by_area_than_by_shift() -> None:
    """The area is long, though the outlines never cover its two ends at once."""
    turn = 0.3
    ego, other = drive(-30, 0, 0, 10), drive(-45 * math.cos(turn), -45 * math.sin(turn), turn, 10, samples=160)[:120]
    mine, theirs = stays(ego, other)
    assert mine.leave - mine.enter > 1.5
    assert math.isnan(gap(ego, other)) or abs(gap(ego, other)) < theirs.enter


def test_without_a_shared_area_there_is_none_and_a_follower_shares_all_of_it() -> None:
    """Infinite beside one another; no number behind one another, as both are in it at a time."""
    assert gap(drive(-20, 0, 0, 10), drive(-20, 5, 0, 10)) == math.inf
    assert math.isnan(gap(drive(-20, 0, 0, 10), drive(-30, 0, 0, 10)))


def test_who_stands_is_in_the_area_all_the_time() -> None:
    """Of one sample or of many."""
    mine, theirs = stays(drive(-20, 0, 0, 10), drive(0, 0, 0, 0))
    assert mine.enter == pytest.approx(1.6, abs=1e-9)
    assert theirs == pytest.approx((0.0, 119 * STEP), abs=1e-9)
    assert gap(drive(0, 0, 0, 0, samples=1), drive(9, 0, 0, 0, samples=1)) == math.inf
    assert gap(drive(0, 0, 0, 0, samples=1), drive(3, 0, 0, 0, samples=1)) == 0.0


def polygon(x: float, y: float, heading: float) -> Polygon:
    cos, sin = math.cos(heading), math.sin(heading)
    half = ((2, 1), (-2, 1), (-2, -1), (2, -1))
    return Polygon([(x + a * cos - b * sin, y + a * sin + b * cos) for a, b in half])


def covered(states: Floats) -> list[BaseGeometry]:
    """What a drive covers in each step."""
    boxes = [polygon(*row) for row in states[:, [State.X, State.Y, State.HEADING]].tolist()]
    return [MultiPoint([*one.exterior.coords, *two.exterior.coords]).convex_hull for one, two in pairwise(boxes)]


MOTIONS = (st.floats(-40, 40), st.floats(-40, 40), st.floats(-3, 3), st.floats(0, 15), st.floats(-0.4, 0.4))


@examples(40)
@given(*MOTIONS)
def test_steps_in_the_area_are_those_of_every_pair_of_steps(
    x: float, y: float, heading: float, speed: float, turning: float
) -> None:
    """Whatever boxes, ways and steps apart leave out: hulls of all steps held against one another say the same; and the
    gap is that of both stays, to the last bit.
    """
    ego, other = drive(-30, 0, 0, 12), drive(x, y, heading, speed, turning)
    states, one, two = together(ego, other)
    mine, theirs = hulls(ego), hulls(other)
    near, samples = np.zeros(1, dtype=np.int32), len(states)
    touching = np.array([[hulls_apart(a, b, near) < 0.0 for b in theirs] for a in mine])
    found = stays_of(states, one, two, OUTLINES, swept(samples))
    for stay, touches in zip(found, (touching.any(axis=1), touching.any(axis=0)), strict=True):
        steps = np.flatnonzero(touches)
        assert math.isfinite(stay.enter) == bool(len(steps))
        if len(steps):
            assert steps[0] <= stay.enter <= steps[0] + 1
            assert steps[-1] <= stay.leave <= steps[-1] + 1
    told, worked_out = encroachment(states, one, two, OUTLINES, swept(samples)), encroachment_gap(*found)
    assert told == worked_out or (math.isnan(told) and math.isnan(worked_out))


def hulls(states: Floats) -> Floats:
    """(steps, POINTS, 2)"""
    corners = np.zeros((len(states) - 1, POINTS, 2))
    for k in range(len(corners)):
        for first, row in ((0, states[k]), (4, states[k + 1])):
            lay(corners[k], first, Box(row[State.X], row[State.Y], row[State.HEADING], *OUTLINES[0, :2].tolist()))
    return corners


def test_a_line_that_parts_two_hulls_is_remembered_and_changes_no_answer() -> None:
    """Two squares two metres apart, whichever of all lines is tried first."""
    one, other = np.zeros((POINTS, 2)), np.zeros((POINTS, 2))
    for corners, x in ((one, 0.0), (other, 4.0)):
        lay(corners, 0, Box(x, 0.0, 0.0, 2.0, 2.0))
        lay(corners, 4, Box(x, 0.0, 0.0, 2.0, 2.0))
    for hint in range(2 * LINES):
        near = np.array([hint], dtype=np.int32)
        assert hulls_apart(one, other, near) == 2.0
        assert hulls_apart(one, one, near) < 0.0


@examples(40)
@given(*MOTIONS)
def test_in_the_area_are_those_steps_that_touch_what_the_other_sweeps(
    x: float, y: float, heading: float, speed: float, turning: float
) -> None:
    """As shapely has it, to a step; who never touches it is never in it."""
    ego, other = drive(-30, 0, 0, 12), drive(x, y, heading, speed, turning)
    area = unary_union(covered(other))
    inside = [k for k, hull in enumerate(covered(ego)) if hull.distance(area) < 1e-9]
    mine, theirs = stays(ego, other)
    assert math.isfinite(mine.enter) == math.isfinite(theirs.enter)
    if not inside:
        assert mine.enter == math.inf
    elif math.isfinite(mine.enter):
        assert inside[0] - 1e-6 <= mine.enter / STEP <= inside[0] + 1 + 1e-6
        assert inside[-1] - 1e-6 <= mine.leave / STEP <= inside[-1] + 1 + 1e-6
    else:
        assert max(hull.intersection(area).area for hull in covered(ego)) < 1e-9  # they only graze
