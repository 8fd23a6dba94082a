"""Contacts among many actors, of which only those near each other are compared."""

import numpy as np
import pytest

import cortex_dsl as cx
from engine.kernels.impacts.sweep import FEW
from engine.outcomes import PAIRS
from tests.laws import share

TRAFFIC = """
map intersection(approach=200 m)
param SPEED = Range(5, 20) m/s
param OTHERS = Range(5, 20) m/s
param GAP = Range(0, 30) m
ego = new Car at ({x}, {y}), facing {turn} deg, with speed SPEED, with behavior FollowLaneBehavior(SPEED)
one = new Car ahead of ego by 10 m, with speed 3 m/s, with behavior FollowLaneBehavior(OTHERS)
two = new Car ahead of one by 1 m + GAP, with speed 0 m/s
three = new Car behind ego by 20 m, with speed OTHERS, with behavior FollowLaneBehavior(30 m/s)
"""
PARKED = "crate{number} = new Obstacle at ({x} m, {y} m), with regionContainedIn None\n"
WAYS = {"north": ("1.75 m", "-150 m", 90), "east": ("-150 m", "-1.75 m", 0)}
PLACES = [(300.0, 300.0), (-300.0, 310.0), (305.0, -290.0), (-310.0, -310.0), (299.0, 280.0), (-2.0, 400.0)]
"""Far from the road, on both sides of all that moves on either axis."""


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("first", [True, False])
def test_actors_far_away_change_no_contact(way: str, first: bool) -> None:
    """Up to `FEW` actors are compared with every other; with more, those near each other must be found."""
    x, y, turn = WAYS[way]
    moving = TRAFFIC.format(x=x, y=y, turn=turn)
    parked = [PARKED.format(number=number, x=x, y=y) for number, (x, y) in enumerate(PLACES)]
    few, many = cx.compile_text(moving + parked[0]), cx.compile_text(moving + "".join(parked))
    if first:  # the numbers of the actors are not in the order of their places
        lines = moving.splitlines(keepends=True)
        many = cx.compile_text("".join([*lines[:6], *parked, *lines[6:]]).replace("\n\n", "\n"))
    assert len(few.program.actors) <= FEW < len(many.program.actors)
    scenes = few.sample(share(100), seed=2)
    found = few.simulate(scenes)
    others = many.simulate(many.sample(share(100), seed=2))
    assert found.collided.any()
    assert np.isfinite(found.others_contact_time).any()
    np.testing.assert_array_equal(found.end_reason, others.end_reason)
    np.testing.assert_array_equal(found.end_time, others.end_time)
    np.testing.assert_array_equal(found.others_contact_time, others.others_contact_time)
    names = [many.program.actors.index(name) - 1 for name in few.program.actors[1:]]
    for row in PAIRS:
        np.testing.assert_array_equal(getattr(found, row.name), getattr(others, row.name)[:, names], err_msg=row.name)
