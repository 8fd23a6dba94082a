"""`minimum distance` and `intersects` with a region: from the outline, at the start and while the scenario runs."""

import numpy as np
import pytest

from cortex_dsl import compile_text
from engine.outcomes import Outcomes
from engine.scenes import Scenes

HALF_LENGTH = 4.508 / 2
SPEED = 10.0


def run(*lines: str) -> tuple[Scenes, Outcomes]:
    """Cars that drive straight on at 10 m/s towards the intersection, from 10 to 30 m in front of it."""
    scenario = compile_text(
        "\n".join(
            (
                "map intersection(ways=4, lanes=1)",
                "lane = Uniform(*intersection.incomingLanes)",
                f"ego = new Car in lane.centerline, with speed {SPEED}, with behavior FollowLaneBehavior({SPEED})",
                "require 10 m < (distance to intersection) < 30 m",
                *lines,
            )
        )
    )
    scenes = scenario.sample(12, seed=1)
    assert scenes.valid.all()
    return scenes, scenario.simulate(scenes)


def test_the_outline_is_half_a_length_ahead_of_the_centre() -> None:
    """The car's front reaches the intersection half a length before its centre."""
    front, centre = (
        run(f"terminate when {condition}")[1].end_time
        for condition in ("(minimum distance to intersection) <= 0", "(distance to intersection) <= 0")
    )
    assert centre - front == pytest.approx(np.full(12, HALF_LENGTH / SPEED), abs=0.05 + 1e-9)


def test_to_intersect_is_to_have_no_distance() -> None:
    """Either way round, and in a behaviour as well as in a rule."""
    ends = [
        run(f"terminate when {condition}")[1].end_time
        for condition in (
            "(minimum distance to intersection) <= 0",
            "ego intersects intersection",
            "intersection intersects ego",
        )
    ]
    behaving = run(
        "behavior Watch():",
        "    while not (ego intersects intersection):",
        "        wait",
        "    terminate",
        "watcher = new Pedestrian at (40, 40), with behavior Watch()",
    )[1].end_time
    assert ends[0].tolist() == ends[1].tolist() == ends[2].tolist() == behaving.tolist()


def test_requirements_measure_outlines_at_the_start() -> None:
    """The two distances differ by half a length wherever the car stands."""
    gap = "(distance to intersection) - (minimum distance from ego to intersection)"
    scenes, _ = run(f"require abs({gap} - {HALF_LENGTH} m) < 1 mm", "require not (ego intersects intersection)")
    assert scenes.failed[:, 1:3].sum() == 0
