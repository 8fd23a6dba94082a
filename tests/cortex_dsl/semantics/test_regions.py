"""Regions, fields and the workspace of a file: what they contain, how places in them are spread, what is refused.

Expected places of fields are those of Scenic 3.1.1's own tests of `following` and `offset along`.
"""

import math
from collections.abc import Callable

import numpy as np
import pytest

from cortex_dsl import compile_text
from engine.vocabulary import Column
from tests.cortex_dsl.semantics.conftest import findings

Inside = Callable[[np.ndarray, np.ndarray], np.ndarray]
HEAD = "map intersection()\nego = new Car on road, with allowCollisions True\n"
NOTCHED = "PolygonalRegion([(0, 0), (20, 0), (20, 20), (10, 5), (0, 20)])"


def places(region: str, count: int = 2000, before: str = "") -> np.ndarray:
    """x, y and heading of a thing in a region, drawn again and again (count, 3)."""
    scenario = compile_text(f"{HEAD}{before}p = new Object in {region}, with allowCollisions True\n")
    scenes = scenario.sample(count, seed=3)
    assert scenes.valid.all()
    at = len(Column)
    return np.asarray(scenes.values)[:, [at + Column.X, at + Column.Y, at + Column.HEADING]]


def fails(text: str) -> bool:
    """Whether no scene meets what a text requires."""
    return not compile_text(HEAD + text).sample(1, seed=1).valid[0]


def in_notched(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return (x >= 0) & (x <= 20) & (y >= 0) & (y <= np.where(x < 10, 20 - 1.5 * x, 1.5 * x - 10))


@pytest.mark.parametrize(
    ("region", "inside", "mean"),
    [
        ("CircularRegion((3, 5), 2)", lambda x, y: np.hypot(x - 3, y - 5) <= 2, (3, 5)),
        ("RectangularRegion((3, 5), 0 deg, 8, 3)", lambda x, y: (abs(x - 3) <= 1.5) & (abs(y - 5) <= 4), (3, 5)),
        ("SectorRegion((0, 0), 3, 90 deg, 180 deg)", lambda x, y: (np.hypot(x, y) <= 3) & (y >= 0), (0, 4 / math.pi)),
        (NOTCHED, in_notched, (10, 7.0)),
        ("CircularRegion((0, 0), 2).union(CircularRegion((1, 0), 2))",
         lambda x, y: (np.hypot(x, y) <= 2) | (np.hypot(x - 1, y) <= 2), (0.5, 0)),
        ("CircularRegion((0, 0), 2).intersect(RectangularRegion((2, 0), 0 deg, 9, 4))",
         lambda x, y: (np.hypot(x, y) <= 2) & (x >= 0), (8 / (3 * math.pi), 0)),
        ("RectangularRegion((0, 0), 0 deg, 4, 4).difference(RectangularRegion((1, 0), 0 deg, 4, 2))",
         lambda x, y: (abs(x + 1) <= 1) & (abs(y) <= 2), (-1, 0)),
    ],
)  # fmt: skip
def test_places_are_spread_evenly(region: str, inside: Inside, mean: tuple[float, float]) -> None:
    """All lie inside, and their mean is the centroid (five standard errors of 2,000 draws)."""
    x, y, _ = places(region).T
    assert inside(x, y).all()
    for values, expected in ((x, mean[0]), (y, mean[1])):
        assert abs(values.mean() - expected) < 5.0 * values.std() / math.sqrt(len(values))


def test_a_line_gives_its_heading() -> None:
    """A place on a polyline heads along it, each piece as likely as it is long."""
    x, y, heading = places("PolylineRegion([(0, 0), (3, 3), (6, 3)])").T
    first = x < 3.0
    assert np.allclose(y, np.where(first, x, 3.0))
    assert np.allclose(heading, np.where(first, math.pi / 4, 0.0))
    share = math.sqrt(18.0) / (math.sqrt(18.0) + 3.0)
    assert abs(first.mean() - share) < 5.0 * math.sqrt(share * (1.0 - share) / len(x))


@pytest.mark.parametrize(
    ("condition", "holds"),
    [
        (f"(10, 4) in {NOTCHED}", True),
        (f"(10, 6) in {NOTCHED}", False),
        ("abs((distance from (13, 9) to CircularRegion((10, 5), 3)) - 2 m) < 1e-9 m", True),
        ("abs((distance from (10, 6) to " + NOTCHED + ") - 0.5547 m) < 1e-4 m", True),
        ("box in RectangularRegion((50, 50), 0 deg, 4, 4)", True),
        ("box in RectangularRegion((51.5, 50), 0 deg, 4, 4)", False),
        ("box in PolygonalRegion([(0, 0), (100, 0), (100, 100), (50, 49), (0, 100)])", False),
        ("box in PolygonalRegion([(0, 0), (100, 0), (100, 100), (50, 52), (0, 100)])", True),
        ("box in PolygonalRegion([(0, 0), (100, 0), (100, 100), (50, 50.5), (0, 100)])", False),
    ],
)
def test_what_lies_in_a_region(condition: str, *, holds: bool) -> None:
    """Points and whole outlines, a notch that pierces an outline between its corners included."""
    box = "box = new Object at (50, 50), with length 2, with width 2\n"
    assert fails(f"{box}require {condition}\n") != holds


def test_the_workspace_holds_all_objects() -> None:
    """But those that say themselves what they lie in; only what is called `workspace` does."""
    thing = "box = new Object at (50, 50)\n"
    far = ", with regionContainedIn None\n"
    small = "workspace = Workspace(CircularRegion((0, 0), 20))\n"
    ego = "map intersection()\nego = new Object at (0, 0)\n"
    for text, valid in (
        (small + thing, False),
        (small + thing.replace("\n", far), True),
        (small.replace("workspace =", "other =") + thing, True),
        (small.replace("20", "80") + thing, True),
    ):
        assert compile_text(ego + text).sample(1, seed=1).valid[0] == valid


FIELD = 'vf = VectorField("Foo", lambda pos: 90 deg * (pos.x + pos.y - 1), minSteps=4, defaultStepSize=1)\n'


def test_a_field_is_followed_in_steps() -> None:
    """From (1, 1) four steps of 1 m turn at each: north, west and so on, as Scenic's test of `following` has it."""
    text = f"map intersection()\nmodel scenic.domains.driving.model\n{FIELD}ego = new Object at (1, 1)\n"
    scenario = compile_text(text + "p = new Object following vf for 4, with allowCollisions True\n")
    values = np.asarray(scenario.sample(1, seed=1).values)[0][len(Column) :]
    assert np.allclose(values[[Column.X, Column.Y]], (-1.0, 3.0))


def test_a_random_way_takes_as_many_steps_as_it_needs() -> None:
    """Straight fields lead as far as is asked for, whatever the number of steps."""
    text = f'{HEAD}vf = VectorField("F", lambda pos: 30 deg, minSteps=2, defaultStepSize=1)\nd = Range(1, 9)\n'
    scenario = compile_text(text + "p = new Object at (follow vf from (0, 0) for d), with foo d, with name 'p'\n")
    scenes = scenario.sample(50, seed=1)
    values = np.asarray(scenes.values)[:, len(Column) :]
    ratio = values[:, Column.Y] / values[:, Column.X]
    assert np.allclose(ratio, math.tan(math.radians(30.0)))
    far = np.hypot(values[:, Column.X], values[:, Column.Y])
    assert 1.0 <= far.min() < 2.0
    assert 8.0 < far.max() <= 9.0


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("r = CircularRegion((0, 0), 0)", "SCN402"),
        ("r = RectangularRegion((0, 0), 0 deg, -3, 2)", "SCN402"),
        ("r = SectorRegion((0, 0), 3, 0 deg, 400 deg)", "SCN402"),
        ("r = PolygonalRegion([(0, 0), (1, 0)])", "SCN477"),
        ("r = PolygonalRegion([(0, 0), (9, 9), (9, 0), (0, 9)])", "SCN477"),
        ("p = new Point in nowhere", "SCN477"),
        ("r = CircularRegion((0, 0), 3).union(road)", "SCN303"),
        ("r = PolygonalRegion(3)", "SCN303"),
        ('vf = VectorField("F", lambda pos: "x")\np = new Object at (1, 1), facing vf', "SCN303"),
        ('p = follow VectorField("F", 3 deg) for 1e9 m', "SCN402"),
    ],
)
def test_what_is_no_region_is_said(line: str, code: str) -> None:
    """Each with a code, at its place."""
    assert code in [d.code for d in findings(f"{HEAD}{line}\n")]


def test_edges_and_corners_of_objects() -> None:
    """`x.left` and its like are the places of the operators `left of x` and so on."""
    text = "a = new Object at (5, 5), facing 30 deg, with length 4, with width 2\n"
    for attribute, words in (("left", "left of"), ("front", "front of"), ("backRight", "back right of")):
        assert not fails(f"{text}require (distance from a.{attribute} to ({words} a)) < 1e-9\n")


def test_beside_a_place_by_two_numbers() -> None:
    """`by (x, y)`: so much between, and so far along, as in Scenic."""
    text = f"{HEAD}a = new Object left of (10, 20) by (20, 5), with width 2\n"
    require = "require (distance from a to (-11, 25)) < 1e-9\n"
    model = text.replace("ego", "model scenic.domains.driving.model\nego", 1)
    scenario = compile_text(model + require)
    assert scenario.sample(1, seed=1).valid[0]
