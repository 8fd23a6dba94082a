"""The one helper for words that are nearly right."""

import pytest

from cortex_dsl.spelling import class_called, did_you_mean, likely_range, nearest

TURNS = ("STRAIGHT", "LEFT_TURN", "RIGHT_TURN", "U_TURN")


@pytest.mark.parametrize(
    ("word", "meant"),
    [("RIGHT", "RIGHT_TURN"), ("LEFT", "LEFT_TURN"), ("left_trun", "LEFT_TURN"), ("STRAIGT", "STRAIGHT"), ("x", None)],
)
def test_nearest(word: str, meant: str | None) -> None:
    """A word that begins another is meant for it; else letters decide."""
    assert nearest(word, TURNS) == meant


def test_letters_that_changed_places() -> None:
    """The same letters in another order come before other letters."""
    assert nearest("eog", ("log", "ego", "egg")) == "ego"


def test_of_several_beginnings_the_shortest() -> None:
    """What was nearly finished is meant."""
    assert nearest("lane", ("laneToLeft", "lanes", "laneSection")) == "lanes"


@pytest.mark.parametrize(
    ("word", "meant"),
    [("truck", "Truck"), ("lorry", "Truck"), ("walker2", "Pedestrian"), ("Child", "Pedestrian"), ("adversary", None)],
)
def test_class_called(word: str, meant: str | None) -> None:
    """What people call things, and their numbers."""
    assert class_called(word, ("Car", "Truck", "Pedestrian")) == meant


def test_likely_range() -> None:
    """By a part of the name."""
    assert likely_range("EGO_SPEED") == "Range(20, 60) km/h"
    assert likely_range("COLOUR") == "Range(LOW, HIGH)"


def test_no_sidewalk() -> None:
    """The cure is a place beside the road that compiles."""
    assert "after intersection by 3 m" in did_you_mean("sidewalk", ())
