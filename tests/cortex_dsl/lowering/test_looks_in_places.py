"""Sight in the place of an object: the objects before it hide, and nothing needs what it is part of."""

import pytest

import cortex_dsl as cx

FORMS = (
    "b = new Car ahead of ego by ({})",
    "b = new Car at ({}, 9 m), with regionContainedIn None",
    "b = new Car at (200 m, 9 m), facing ({}) / 1 m * 1 deg, with regionContainedIn None",
    "b = new Car ahead of ego by 90, with length ({}) / 10",
    "b = new Car ahead of ego by 90, with occluding ego can see sign",
    "p = new Point at ({}, 9 m)\nb = new Car at p, facing 90 deg, with regionContainedIn None",
    "b = new Car ahead of ego by ({})\nc = new Car behind b by (5 if ego can see b else 8)",
)
START = "map road(lanes=3, length=900 m)\nego = new Car at (9 m, 0 m)\nsign = new Car ahead of ego by 40\n"
LOOK = "60 m if ego can see sign else 80 m"


@pytest.mark.parametrize("form", FORMS)
def test_a_look_in_a_place_has_a_scene(form: str) -> None:
    scenario = cx.compile_text(START + form.format(LOOK) + "\n")
    assert scenario.sample(1).valid[0]


@pytest.mark.parametrize(("wall", "ahead"), [("", 60.0), ("wall = new Bus ahead of ego by 10\n", 80.0)])
def test_what_comes_before_hides_and_what_comes_later_does_not(wall: str, ahead: float) -> None:
    """A bus that covers the sign moves the object only if it is placed first."""
    placed = f"other = new Car ahead of ego by ({LOOK})\n"
    later = "late = new Bus ahead of ego by 10\n" if not wall else ""
    scenario = cx.compile_text(START + wall + placed + later)
    scenes = scenario.sample(1)
    assert scenes.valid[0]
    names = list(scenario.program.actors)
    states = scenario.watch(scenes).trajectory.states[0]
    gap = states[names.index("other"), 0] - states[0, 0]
    assert gap == pytest.approx(ahead + 4.5, abs=1.0)
