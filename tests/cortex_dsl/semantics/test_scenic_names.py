"""Names of Scenic's scripts that mean the same here: `Vector`, heights of 0, ends of lines, directions of lanes."""

import math
from itertools import pairwise

import numpy as np
import pytest

from cortex_dsl import compile_text
from cortex_dsl.diagnostics import CompileError
from engine.acceptance import measure_acceptance
from engine.config import SimulationConfig
from engine.sampling import sample
from engine.streams import key_rows
from engine.vocabulary import Column, Method

SCRIPT = "map intersection()\nmodel scenic.domains.driving.model\nlane = intersection.incomingLanes[0]\n"


def pose(specifiers: str, above: str = "") -> tuple[float, float, float]:
    """X, y and heading of an object."""
    text = f"{SCRIPT}{above}ego = new Car {specifiers}, with regionContainedIn None\n"
    program = compile_text(text).program
    values = sample(program, np.zeros((1, 0)), key_rows(0, Method.SAMPLE, 0, 0, range(1)), SimulationConfig()).values[0]
    return values[Column.X], values[Column.Y], values[Column.HEADING]


@pytest.mark.parametrize("place", ["(10, 20, 0)", "Vector(10, 20)", "Vector(10, 20, 0 m)", "(10 m, 20 m, 1 - 1)"])
def test_a_place_may_have_a_height_of_zero(place: str) -> None:
    """And may be written as a `Vector`."""
    assert pose(f"at {place}, facing 0 deg") == pose("at (10, 20), facing 0 deg")


def test_the_ends_of_a_line_are_its_points() -> None:
    """With the heading of the lane there."""
    for end, index in (("start", 0), ("end", 1)):
        x, y, heading = pose(f"at lane.centerline.{end}, facing lane.centerline.{end}.heading")
        assert pose(f"at lane.centerline[{index}], facing roadDirection")[:2] == (x, y)
        assert pose(f"at ({x}, {y}), facing lane.orientation")[2] == pytest.approx(heading)


def test_a_lane_has_its_own_direction_where_others_cross() -> None:
    """At one point of an intersection, each connecting lane heads another way."""
    above = "through = [m.connectingLane for m in intersection.maneuvers if m.type is ManeuverType.STRAIGHT]\n"
    headings = [pose(f"at (0, 0), facing through[{number}].orientation[(0, 0)]", above)[2] for number in range(4)]
    turned = sorted(each % math.tau for each in headings)
    assert [b - a for a, b in pairwise(turned)] == pytest.approx([math.pi / 2] * 3, abs=0.2)


@pytest.mark.parametrize(("side", "holds"), [(10, True), (99, True), (101, False)])
def test_a_region_contains_another(side: float, holds: bool) -> None:
    """All corners lie in it."""
    text = (
        f"{SCRIPT}ego = new Car at (0, 0), with regionContainedIn None\nbig = RectangularRegion((0, 0), 0, 100, 100)\n"
    )
    text += f"require big.containsRegion(RectangularRegion((0, 0), 0, {side}, {side}))\n"
    assert measure_acceptance(compile_text(text).program, 10).acceptance == holds


@pytest.mark.parametrize(
    ("place", "model", "code", "cure"),
    [("(1, 2, 3)", True, "SCN402", "heights are not simulated"), ("(1, 2, 0)", False, "SCN303", "`(x, y)`")],
)
def test_other_heights_are_refused(place: str, model: bool, code: str, cure: str) -> None:
    """They would be lost; and files without a `model` line write two numbers."""
    head = SCRIPT if model else SCRIPT.replace("model scenic.domains.driving.model\n", "")
    with pytest.raises(CompileError) as refused:
        compile_text(f"{head}ego = new Car at {place}, with regionContainedIn None\n")
    assert refused.value.diagnostics[-1].code == code
    assert cure in refused.value.diagnostics[-1].cure


@pytest.mark.parametrize(("height", "shown"), [("3", "a height is 3 m"), ("Range(1, 2)", "a height is drawn")])
def test_the_height_is_shown(height: str, shown: str) -> None:
    """As the file has it, or that no number is known before a scene is drawn."""
    with pytest.raises(CompileError) as refused:
        compile_text(f"{SCRIPT}ego = new Car at (1, 2, {height}), with regionContainedIn None\n")
    assert refused.value.diagnostics[-1].message.startswith(shown)
