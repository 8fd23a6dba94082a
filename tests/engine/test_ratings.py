"""Colours and points of rating tests: the tables of the protocol, and what holds for any colouring."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.gates.ratings import COLOURS, Colour, Rule, colours, extended_points, standard_points

IMPACTS = (0.0, 0.1, 9.9, 10.0, 19.9, 20.0, 29.9, 30.0, 55.0)
TABLE = {
    10: "green red red red red red red red red",
    20: "green red red red red red red red red",
    30: "green brown brown red red red red red red",
    40: "green orange orange brown brown red red red red",
    50: "green yellow yellow orange orange brown brown red red",
    80: "green yellow yellow orange orange brown brown red red",
    130: "green yellow yellow orange orange brown brown red red",
}
"""Colours by speed of the ego, at `IMPACTS`."""


def colour(rule: Rule, speed: float, impact: float, reduction: float = 0.0, limit: float = 0.0) -> Colour:
    """Return the colour of one run with a contact."""
    one = np.ones(1)
    return COLOURS[int(colours(rule, speed, one == 1.0, impact * one, reduction * one, limit)[0])]


@pytest.mark.parametrize("speed", TABLE)
def test_the_bands_are_those_of_the_protocol(speed: int) -> None:
    """The upper end of a band belongs to the next one, as in the calculator."""
    found = [colour(Rule.MITIGATION_OR_AVOIDANCE, speed, impact) for impact in IMPACTS]
    assert found == TABLE[speed].split()


def test_the_other_rules() -> None:
    """Avoidance, a limit, and the reduction of speed, which is red again above 30 km/h."""
    assert [colour(Rule.AVOIDANCE, 50, impact) for impact in (0.0, 0.1)] == ["green", "red"]
    assert [colour(Rule.LIMIT, 50, impact, limit=25.0) for impact in (0.0, 25.0, 25.1)] == ["green", "green", "red"]
    reductions = (0.0, 10.0, 10.1, 20.0, 20.1, 30.0, 30.1)
    found = [colour(Rule.MITIGATION, 50, 60.0, reduction) for reduction in reductions]
    assert found == ["red", "red", "orange", "orange", "green", "green", "red"]


@given(speed=st.sampled_from([10, 20, 30, 40, 50, 60, 130]), impacts=st.lists(st.floats(0.0, 200.0), min_size=2))
def test_a_faster_impact_is_never_better(speed: int, impacts: list[float]) -> None:
    """Colours are ordered as impacts are, and no contact is green."""
    ordered = np.sort(impacts)
    contact = np.ones(len(ordered), dtype=bool)
    found = colours(Rule.MITIGATION_OR_AVOIDANCE, speed, contact, ordered, ordered)
    assert (np.diff(found) >= 0).all()
    assert (colours(Rule.MITIGATION_OR_AVOIDANCE, speed, ~contact, ordered, ordered) == 0).all()


@pytest.mark.parametrize(
    ("red", "share"), [(0, 1.0), (1, 0.75), (25, 0.75), (26, 0.5), (50, 0.5), (51, 0.0), (100, 0.0)]
)
def test_extended_points_have_three_steps(red: int, share: float) -> None:
    """All, three quarters from 75 %, half from 50 %."""
    found = [Colour.RED] * red + [Colour.BROWN] * (100 - red)
    assert extended_points(found, 0.3) == pytest.approx(0.3 * share)


@given(found=st.lists(st.sampled_from(COLOURS), min_size=1), total=st.floats(0.1, 6.0))
def test_standard_points_are_the_mean_of_the_cells(found: list[Colour], total: float) -> None:
    """Between 0 and the total; all green gives all."""
    points = standard_points(found, total)
    assert 0.0 <= points <= total * (1.0 + 1e-12)
    assert standard_points([Colour.GREEN] * len(found), total) == pytest.approx(total)
    assert (points == 0.0) == (set(found) == {Colour.RED})
