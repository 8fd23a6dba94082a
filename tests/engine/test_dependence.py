"""Which programs are certain to have actors that ignore the ego."""

import pytest

from cortex_dsl import compile_text
from engine.dependence import ignores_ego

EGO = """
map road(lanes=2)
ego = new Car in network.lanes[0].centerline, with speed 5 m/s, with behavior {ego}
other = new Car in network.lanes[1].centerline, with behavior {other}
"""
STEADY = "FollowLaneBehavior(8 m/s)"
BEHAVIORS = """
behavior Steady():
    do FollowLaneBehavior(8 m/s)
behavior Draws():
    do FollowLaneBehavior(8 m/s) for Range(1, 3) s
    do FollowLaneBehavior(5 m/s)
behavior Sees():
    try:
        do FollowLaneBehavior(8 m/s)
    interrupt when self can see ego:
        take SetBrakeAction(1)
behavior Near():
    do FollowLaneBehavior(8 m/s) until (distance to ego) < 9 m
behavior Fast():
    do FollowLaneBehavior(8 m/s) until ego.speed > 7 m/s
behavior Later():
    do FollowLaneBehavior(8 m/s) until simulation().currentTime > 20
"""


@pytest.mark.parametrize(
    ("other", "ignores"),
    [
        (STEADY, True),
        ("Steady()", True),
        ("Later()", True),
        ("Draws()", False),
        ("Sees()", False),
        ("Near()", False),
        ("Fast()", False),
        ("EmergencyBrakeBehavior(FollowLaneBehavior(8 m/s))", False),
        ("CarFollowingBehavior(8 m/s)", False),
    ],
)
@pytest.mark.parametrize("ego", [STEADY, "Steady()", "Near()", "Draws()"])
def test_what_others_read(ego: str, other: str, ignores: bool) -> None:
    """Behaviors of the ego do not matter, those of the others do."""
    if ego == "Near()":
        ego = "EmergencyBrakeBehavior(FollowLaneBehavior(8 m/s))"
    assert ignores_ego(compile_text(BEHAVIORS + EGO.format(ego=ego, other=other)).program) == ignores


def test_rules_move_nobody_and_monitors_may() -> None:
    """A rule that looks at the ego ends the run; a monitor may start what it likes."""
    text = BEHAVIORS + EGO.format(ego=STEADY, other=STEADY)
    assert ignores_ego(compile_text(text + "terminate when ego.speed > 9 m/s\n").program)
    watches = "monitor Watches():\n    while True:\n        wait\n"
    assert not ignores_ego(compile_text(watches + text + "require monitor Watches()\n").program)
