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
from engine.vocabulary import Column, Method, State, Verdict

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


# -- velocities --------------------------------------------------------------------------------------------------------

MOVING = """
behavior Go():
    while True:
        take SetVelocityAction({velocity})
ego = new {kind} at (3, 40), facing {heading} deg, with behavior Go(), with regionContainedIn None
terminate after 2 s
"""


@pytest.mark.parametrize("heading", [0, 37, -120, 180])
@pytest.mark.parametrize("off", [0.0, 2.9, -2.9, 3.1, 90.0, 180.0])
def test_a_vehicle_moves_along_its_heading(heading: float, off: float) -> None:
    """With the speed of the velocity; one more than 3 degrees off its heading aborts the run, in both hosts."""
    way = math.radians(heading + off + 90.0)  # files with a `model` line count headings from north
    velocity = f"{5.0 * math.cos(way):.9f}, {5.0 * math.sin(way):.9f}, 0"
    text = SCRIPT + MOVING.format(kind="Car", heading=heading, velocity=velocity)
    scenario = compile_text(text)
    scenes = scenario.sample(1)
    batch, world = scenario.simulate(scenes), scenario.watch(scenes)
    assert (batch.verdict[0] == Verdict.VALID) == (world.outcomes.verdict[0] == Verdict.VALID) == (abs(off) <= 3.0)
    if abs(off) <= 3.0:
        states = world.trajectory.states[-1, 0]
        assert states[State.SPEED] == pytest.approx(5.0, abs=1e-6)
        assert states[State.HEADING] == pytest.approx(scenes.values[0, Column.HEADING])


@pytest.mark.parametrize(("x", "y"), [(1.5, 0.0), (-1.0, 1.0), (0.0, -2.0), (0.0, 0.0)])
def test_a_pedestrian_turns_into_its_velocity(x: float, y: float) -> None:
    """It goes that way at once, and stands without one."""
    scenario = compile_text(SCRIPT + MOVING.format(kind="Pedestrian", heading=20, velocity=f"{x}, {y}"))
    states = scenario.watch(scenario.sample(1)).trajectory.states[:, 0]
    moved = states[-1, :2] - states[1, :2]
    np.testing.assert_allclose(moved, np.array([x, y]) * (len(states) - 2) * 0.05, atol=1e-6)


@pytest.mark.parametrize("arguments", ["(1, 2)", "1", "1, 2, 3", "300, 0", "1 m, 2 m"])
def test_other_velocities_are_refused(arguments: str) -> None:
    """Two speeds are needed, a third one is 0, and none is beyond every vehicle."""
    with pytest.raises(CompileError):
        compile_text(SCRIPT + MOVING.format(kind="Car", heading=0, velocity=arguments))


# -- words of Python and of other tools --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("line", "cure"),
    [
        ("import random\nx = random.uniform(1, 2)", "Range(low, high)"),
        ("import numpy as np\nx = np.random.normal(1, 2)", "Normal(mean, deviation)"),
        ("from random import choice\nx = choice([1, 2])", "Uniform(*items)"),
        ("import random\nx = random.randint(1, 2)", "DiscreteRange(low, high)"),
        ("x = TimeSeries(3)", "draws anew each time"),
        ("def f():\n    global n\n    return 3", "self.count"),
        ("a = new Car with behavior BasicAgentBehavior()", "FollowLaneBehavior"),
    ],
)
def test_foreign_words_name_what_to_write(line: str, cure: str) -> None:
    """The cure of the diagnostic names the distribution, the behavior or the statement instead."""
    with pytest.raises(CompileError) as refused:
        compile_text(f"model scenic.domains.driving.model\n{line}\nego = new Car on road\n")
    assert any(cure in (each.cure or "") for each in refused.value.diagnostics)


@pytest.mark.parametrize(("side", "holds"), [(1.0, True), (3.4, True), (3.6, False)])
def test_regions_of_the_map_contain_rectangles(side: float, holds: bool) -> None:
    """A lane of 3.5 m contains one of its width; other areas are refused."""
    text = f"{SCRIPT}ego = new Car at (0, 0), with regionContainedIn None\npoint = lane.centerline.start\n"
    text += "middle = new OrientedPoint following roadDirection from point for 20\n"
    text += f"require lane.containsRegion(RectangularRegion(middle, middle.heading, {side}, 8))\n"
    assert measure_acceptance(compile_text(text).program, 10).acceptance == holds
    with pytest.raises(CompileError):
        compile_text(text + "require lane.containsRegion(CircularRegion((0, 0), 1))\n")


def test_points_have_no_height() -> None:
    """Their `z` is 0, as on Scenic's flat maps."""
    above = "p = Vector(3, 4)\n"
    assert pose("at (p.x + p.z, p.y), facing 0 deg", above) == pose("at (3, 4), facing 0 deg")
