"""Words of Scenic: what operators and specifiers give, where what has no place stands, and what the compiler runs.

Expected numbers are those of Scenic 3.1.1, whose headings count from the north; where a file has no `model` line they
count from the east.
"""

import math

import numpy as np
import pytest

from cortex_dsl import CompileError, compile_text
from cortex_dsl.semantics.model import state
from cortex_dsl.semantics.names.properties import IGNORED, SCENIC_ONLY
from engine.vocabulary import Column, Verdict
from tests.cortex_dsl.semantics.conftest import findings

HERE = "map intersection()\n"
MODEL = "map intersection()\nmodel scenic.domains.driving.model\n"
FREE = ", with regionContainedIn None, with allowCollisions True"
EGO = f"ego = new Car at (3, 2), facing 30 deg{FREE}\n"
OTHER = f"other = new Car at (13, 12), facing 65 deg{FREE}\n"


def rows(text: str, count: int = 1) -> np.ndarray:
    """Columns of the actors of valid scenes: (scene, actor, column)."""
    scenario = compile_text(text)
    scenes = scenario.sample(count, seed=5)
    assert scenes.valid.all()
    values = np.asarray(scenes.values)
    actors = values.shape[1] // len(Column)
    return values[:, : actors * len(Column)].reshape(count, actors, len(Column))


def errors(text: str) -> list[str]:
    return [d.code for d in findings(text) if d.severity.value == "error"]


@pytest.mark.parametrize("head", [HERE, MODEL])
@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("relative heading of other", "35 deg"),
        ("40 deg relative to ego", "70 deg"),
        ("ego relative to 40 deg", "70 deg"),
        ("(5 deg relative to 40 deg)", "45 deg"),
        ("distance past other", None),
        ("(relative position of other).x", "10 m"),
        ("(relative position of ego from other).y", "-10 m"),
    ],
)
def test_operators_on_places(head: str, expression: str, value: str | None) -> None:
    """Each has the value of Scenic's reference."""
    north = 90.0 if head == MODEL else 0.0
    if value is None:
        turn = math.radians(30.0 + north)
        value = f"{-10.0 * math.cos(turn) - 10.0 * math.sin(turn)} m"
    unit = value.split()[-1]
    rows(head + EGO + OTHER + f"require abs(({expression}) - ({value})) < 1e-9 {unit}\n")


def test_angles_count_as_the_file_does() -> None:
    """The way to the north-east: 45 deg from the east, -45 deg from the north; 65 deg along it are 110 deg there."""
    for head, angle in ((HERE, 45.0), (MODEL, -45.0)):
        rows(head + EGO + OTHER + f"require abs((angle to other) - {angle} deg) < 1e-9 deg\n")
        rows(
            head
            + EGO
            + OTHER
            + f"require abs((angle from other to ego) - ({angle - math.copysign(180, angle)}) deg) < 1e-9 deg\n"
        )
        seen = 65.0 - angle
        rows(head + EGO + OTHER + f"require abs((apparent heading of other) - {seen} deg) < 1e-9 deg\n")


def test_a_field_has_a_heading_at_a_place() -> None:
    """As the file counts headings; of the road that of the lane there."""
    for head, north in ((HERE, 0.0), (MODEL, 90.0)):
        field = 'f = VectorField("f", lambda p: (3 * p.x + p.y) * 1 deg)\n'
        rows(head + EGO + field + "require abs((f at (2 m, -1 m)) - 5 deg) < 1e-9 deg\n")
        rows(head + EGO + field + "require abs((1 deg relative to (f at (2 m, -1 m))) - 6 deg) < 1e-9 deg\n")
        way = f"require abs((roadDirection at (30 m, -1.75 m)) - {-north} deg) < 1e-9 deg\n"
        rows(head + EGO + way)
    assert "SCN550" in errors(HERE + EGO + "h = (ego at (1.75, -30))\n")


def test_places_beside_others() -> None:
    """`beyond` on the line of sight, a corner of an outline, and the side of a plain point in its own frame."""
    text = (
        f"ego = new Car at (0, 0), facing 0 deg, with length 4, with width 2{FREE}\n"
        f"a = new Car beyond (3, 4) by 5 from (0, 0){FREE}\n"
        f"b = new Car at (front left of ego){FREE}\n"
        f"c = new Car right of (20, 10) by 3, facing 90 deg, with width 2{FREE}\n"
        f"d = new Car at ((1, 2) relative to ego){FREE}\n"
    )
    (scene,) = rows(HERE + text)
    expected = [(0, 0), (6, 8), (2, 1), (24, 10), (2, -1)]
    assert np.allclose(scene[:, [Column.X, Column.Y]], expected, atol=1e-9)


def test_what_is_visible_is_seen() -> None:
    """`visible` draws places in view, `not visible` others, and both differ from scene to scene."""
    text = (
        "ego = new Car before intersection by 20 m along [intersection.incomingLanes[0]]\n"
        "near = new Car visible\nfar = new Car not visible\nspot = new Car on visible road\n"
        "require ego can see near\nrequire not (ego can see far)\n"
    )
    found = rows(HERE + text, 10)
    ego, near, far, spot = (found[:, i] for i in range(4))
    for each in (near, spot):
        away = np.hypot(each[:, Column.X] - ego[:, Column.X], each[:, Column.Y] - ego[:, Column.Y])
        assert (away < 60.0).all()
    assert len(set(far[:, Column.X])) == 10


def test_a_place_sees_as_far_and_as_wide_as_it_was_made_to() -> None:
    """Its sector bounds what is drawn in its view, what of a region is in it, and what it can see."""
    text = (
        f"{HERE}op = new OrientedPoint at (60, 60), facing 45 deg, with visibleDistance 5, with viewAngle 90 deg\n"
        f"near = new Point at (300, 200), with visibleDistance 2\nego = new Object visible from op{FREE}\n"
        f"a = new Object visible from near{FREE}\nb = new Object in op.visibleRegion{FREE}\n"
        f"p = new Point in CircularRegion((60, 60), 9) visible from op\nc = new Object at p{FREE}\n"
        f"q = new Point in CircularRegion((60, 60), 9) not visible from op\nd = new Object at q{FREE}\n"
        "require op can see (61, 61) and not (op can see (61, 59.5)) and not (op can see (64, 64))\n"
        "require near can see a and not (near can see b)\n"
    )
    found = rows(text, 40)
    for actor, (x, y), reach in ((0, (60, 60), 5), (1, (300, 200), 2), (2, (60, 60), 5), (3, (60, 60), 5)):
        away = np.hypot(found[:, actor, Column.X] - x, found[:, actor, Column.Y] - y)
        assert 0.7 * reach < away.max() <= reach + 1e-9
    for actor in (0, 2, 3):
        assert (found[:, actor, [Column.X, Column.Y]] >= 60.0).all()
    away = found[:, 4, [Column.X, Column.Y]] - 60.0
    assert not ((away >= 0.0).all(axis=1) & (np.hypot(*away.T) <= 5.0)).any()
    assert errors(HERE + "ego = new Car\np = new Point at (1, 1), with viewAngle 3\n") == ["SCN204"]


def test_what_has_no_place_of_its_own() -> None:
    """A car is anywhere on the road and heads along it; an `Object` and a point stand in the middle of the map."""
    cars = rows(HERE + "ego = new Car\n", 20)[:, 0]
    assert len(set(cars[:, Column.X])) == 20
    (scene,) = rows(
        HERE + "ego = new Car at (30, -1.75)\nthing = new Object\nspot = new Point\n"
        "other = new Object at spot offset by 0 @ 8\n"
    )
    assert scene[1:, [Column.X, Column.Y]].tolist() == [[0, 0], [0, 8]]
    assert errors(HERE + "ego = new Car\nnew Pedestrian\n") == ["SCN407"]


def test_a_default_place_comes_back_from_a_copy() -> None:
    """What was drawn for a car without a place stands in the concrete scenario, bit for bit."""
    loaded = compile_text(HERE + "ego = new Car\nother = new Car, facing 30 deg\n".replace(", facing", " facing"))
    scenes = loaded.sample(1, seed=2)
    again = compile_text(loaded.concrete(scenes, 0)).sample(1, seed=9)
    assert again.values[0].tolist() == scenes.values[0].tolist()


# -- what differed in silence ------------------------------------------------------------------------------------------


def test_at_an_oriented_point() -> None:
    """Here it gives its heading; Scenic 3 takes the place alone: a vehicle heads along its lane, a thing north."""
    text = "p = new OrientedPoint at (-30, -1.75), facing 40 deg\n"
    text += f"ego = new Car at p{FREE}\nthing = new Object at p{FREE}\n"
    for head, headings in ((HERE, [math.radians(40)] * 2), (MODEL, [0.0, math.pi / 2])):
        assert rows(head + text)[0][:, Column.HEADING].tolist() == pytest.approx(headings, abs=1e-9)


@pytest.mark.parametrize(("head", "heading"), [(HERE, 0.0), (MODEL, math.pi / 2)])
def test_default_headings(head: str, heading: float) -> None:
    """East here, north in Scenic's files: of people, of things, and of oriented points."""
    text = (
        f"ego = new Car at (3, 2){FREE}\na = new Pedestrian at (20, 10)\nb = new Obstacle at (20, 20)\n"
        f"p = new OrientedPoint at (9, 9)\nc = new Car at p, facing p.heading{FREE}\n"
    )
    (scene,) = rows(head + text)
    assert scene[1:, Column.HEADING].tolist() == pytest.approx([heading] * 3)


@pytest.mark.parametrize(("head", "size"), [(HERE, (4.508, 1.61)), (MODEL, (4.5, 2.0))])
def test_size_of_a_car(head: str, size: tuple[float, float]) -> None:
    """A passenger car here, Scenic's outline in Scenic's files; a size that is given stays."""
    (scene,) = rows(head + f"ego = new Car at (3, 2){FREE}\nb = new Car at (30, 2), with length 5{FREE}\n")
    assert scene[0, [Column.LENGTH, Column.WIDTH]].tolist() == pytest.approx(size)
    assert scene[1, Column.LENGTH] == 5.0


def test_places_and_headings_of_classes() -> None:
    """A given position wins over that of the class, and the heading of a place over the heading of the class."""
    text = (
        "class Parked(Car):\n    position: (20, 20)\n    heading: 10 deg\n    regionContainedIn: None\n"
        "ego = new Parked with position (3, 4)\n"
        "b = new Parked\n"
        "c = new Parked at (new OrientedPoint at (40, 40), facing 70 deg)\n"
    )
    (scene,) = rows(HERE + text)
    assert scene[:, Column.X].tolist() == [3.0, 20.0, 40.0]
    assert np.degrees(scene[:, Column.HEADING]).tolist() == pytest.approx([10.0, 10.0, 70.0])


def test_reversed_ranges() -> None:
    """An error here, a note in Scenic's files, where it is drawn from all the same."""
    text = "ego = new Car on road, with speed Range(9, 3)\n"
    assert errors(HERE + text) == ["SCN501"]
    assert "SCN515" in [d.code for d in findings(MODEL + text)]
    assert 3.0 <= rows(MODEL + text)[0, 0, Column.SPEED] <= 9.0


# -- what the compiler runs --------------------------------------------------------------------------------------------


def test_loops_and_functions_of_the_top_level() -> None:
    """They leave values behind, and objects."""
    text = (
        "def mean(first, *others, scale=1):\n    total = first\n    for other in others:\n        total += other\n"
        "    return scale * total / (1 + len(others))\n"
        "def larger(a, b):\n    if a > b:\n        return a\n    return b\n"
        "xs = []\nfor i in range(10):\n    if i % 2 == 0:\n        continue\n"
        "    if i > 8:\n        break\n    xs.append(i)\n"
        "ys = xs\nxs.append(100)\nassert len(ys) == 5 and ys[1:3] == [3, 5] and ys[-1] == 100\n"
        "n = 0\nwhile n < 3:\n    n += 1\n"
        f"ego = new Car at (mean(1, 2, 6, scale=2), larger(n, 2)){FREE}\n"
        "for x, y in [(10, 0), (20, 5)]:\n    new Obstacle at (x, y)\n"
    )
    (scene,) = rows(HERE + text)
    assert scene[:, [Column.X, Column.Y]].tolist() == [[6, 3], [10, 0], [20, 5]]


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("while True:\n    x = 3\n", "SCN434"),
        ("def f(n):\n    return f(n + 1)\nx = f(0)\n", "SCN435"),
        ("for i in range(1000000000):\n    x = i\n", "SCN402"),
        ("for i in 3:\n    x = i\n", "SCN303"),
        ("assert 1 > 2, 'never'\n", "SCN476"),
        ("for i in range(3):\n    param A = 3\n", "SCN431"),
        ("break\n", "SCN431"),
        ("return 3\n", "SCN431"),
        ("if Range(0, 1) > 0.5:\n    x = 3\n", "SCN506"),
        ("x = [1, 2][0:2:0]\n", "SCN402"),
    ],
)
def test_limits_of_what_the_compiler_runs(text: str, code: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each has its code, and nothing hangs; the limit as it is ends a block of the reference."""
    monkeypatch.setattr(state, "EVALUATION_LIMIT", 20_000)
    assert errors(HERE + text + "ego = new Car on road\n")[0] == code


def test_loops_and_waits_of_behaviours() -> None:
    """A counted loop with `continue` and `break`, waits for a time and for a condition, and the clock in steps."""
    text = (
        "behavior B():\n    n = 0\n    for i in range(10):\n        if i == 1:\n            continue\n"
        "        if i == 4:\n"
        "            break\n        n += i\n        wait\n    assert n == 5\n    wait for 1 s\n"
        "    wait until simulation().currentTime >= 40\n    terminate\n"
        "ego = new Car on road, with behavior B()\nterminate after 10 s\n"
    )
    loaded = compile_text(HERE + text)
    outcomes = loaded.simulate(loaded.sample(1, seed=1))
    assert float(outcomes.end_time[0]) == pytest.approx(2.0)


COUNTING = (
    "map intersection()\nbehavior Count():\n    while True:\n        take self.laps, [1, 2], None\n"
    "        self.laps += 1\n"
    "        other.seen = self.laps >= 3\n"
    "ego = new Object with laps {first}, with behavior Count\nother = new Car on road, with seen False\n"
)


def test_an_object_sets_properties_of_its_own() -> None:
    """What a behavior sets others see from then on; it begins as it was made."""
    text = COUNTING.format(first=0) + (
        "monitor Watch():\n    while not other.seen:\n        wait\n    terminate\nrequire monitor Watch()\n"
        "record ego.laps as laps\n"
    )
    scenario = compile_text(text)
    scenes = scenario.sample(1, seed=1)
    run = scenario.watch(scenes)
    kept = {record.name: record.values.tolist() for record in run.records}
    assert kept["laps"] == [0.0, 0.0, 1.0, 2.0, 3.0]
    assert scenario.simulate(scenes).end_time[0] == pytest.approx(run.trajectory.time[-1])


def test_what_a_property_begins_with_decides_about_the_scene() -> None:
    """`require always` on it rejects starts that break it, and draws others."""
    text = COUNTING.format(first="DiscreteRange(0, 9)") + "require always ego.laps < 8 as few\nterminate after 0.1 s\n"
    scenario = compile_text(text)
    scenes = scenario.sample(40, seed=2)
    assert scenes.valid.all()
    assert scenes.attempts.max() > 1
    ends = scenario.simulate(scenes)
    assert 0 < int((ends.verdict == 0).sum()) <= 40


def test_what_cannot_be_set_is_said() -> None:
    """What the run works out, what is settled with the scene, and what an object was not made with."""
    for line in ("self.position = (1, 2)", "self.width = 2 m", "self.other = 3"):
        body = f"map intersection()\nbehavior B():\n    {line}\n    wait\nego = new Car on road, with behavior B()\n"
        assert errors(body) == ["SCN617"]
    assert errors("map intersection()\nego = new Car on road\nego.laps = 3\n") == ["SCN116"]


def test_own_properties_are_no_slips() -> None:
    """What the file asks for is its own; what nobody asks for, and what is nearly a property, is misspelt."""
    ego = "map intersection()\nego = new Car on road, with {}\n"
    assert errors(ego.format("laps 3")) == ["SCN204"]
    assert errors(ego.format("laps 3") + "require ego.laps > 2\n") == []
    assert errors(ego.format("sped 3") + "require ego.sped > 2\n") == ["SCN204"]
    assert errors("map intersection()\nego = new Object with anything [1, 2]\n") == []
    assert errors("map intersection()\nego = new Object with sped 3\n") == ["SCN204"]


def test_nothing_of_the_language_moves_an_object() -> None:
    """It takes what it likes, and no pedal; an `Obstacle` does nothing at all."""
    behavior = "map intersection()\nbehavior B():\n    take {}\nego = new {} at (0, 0), with behavior B()\n"
    assert errors(behavior.format("7", "Object")) == []
    assert errors(behavior.format("SetThrottleAction(1)", "Object")) == ["SCN631"]
    assert errors(behavior.format("7", "Obstacle")) == ["SCN610"]
    assert errors(behavior.format("7", "Car")) == ["SCN605"]


def test_a_wrong_place_does_not_hide_what_is_wrong_in_a_behavior() -> None:
    """Both are said at once, and nothing about those that stand beside the object."""
    text = (
        "map intersection()\nbehavior B():\n    do FollowLaneBehavior(target_sped=3)\n"
        "ego = new Car at 3 m, with behavior B()\nother = new Car ahead of ego by 3 m\n"
    )
    assert sorted(errors(text)) == ["SCN205", "SCN303"]
    assert sorted(errors(text.replace("Car at 3 m,", "Pedestrian"))) == ["SCN205", "SCN407"]


def test_resample_draws_from_the_same_distribution_by_itself() -> None:
    """Uncorrelated, of the same law; a second one too; what the first depends on stays as it was drawn."""
    text = f"m = Range(20, 40)\nx = Normal(m, 1)\nego = new Car at (x, resample(x)), with speed m * 1 m/s{FREE}\n"
    drawn = rows(HERE + text, 400)[:, 0]
    x, y, m = drawn[:, Column.X], drawn[:, Column.Y], drawn[:, Column.SPEED]
    assert abs(float(np.corrcoef(x - m, y - m)[0, 1])) < 0.2
    assert float(np.std(x - m)) == pytest.approx(1.0, abs=0.15) == pytest.approx(float(np.std(y - m)), abs=0.3)


def test_a_concrete_copy_keeps_what_was_drawn_again() -> None:
    scenario = compile_text(HERE + f"x = Uniform(4, 6, 9)\nego = new Car at (x, resample(x)), facing 0 deg{FREE}\n")
    scenes = scenario.sample(1, seed=3)
    copy = compile_text(scenario.concrete(scenes))
    assert np.array_equal(copy.sample(1).values[0, :2], scenes.values[0, :2])
    assert scenes.values[0, 0] != scenes.values[0, 1]


def test_the_initial_scenario_is_the_first_with_a_setup() -> None:
    """Scenic's own cases: of two that `compose` starts the first, none where the one that runs has a setup."""
    part = "scenario Sub(y):\n    setup:\n        if initial scenario:\n            ego = new Object at (0, 0)\n"
    part += "        p = new Object at (9, y)\n"
    bare = "scenario Main():\n    compose:\n        do Sub(9), Sub(19)\n"
    placed = bare.replace("    compose", "    setup:\n        ego = new Object at (30, 0)\n    compose")
    assert rows(HERE + part + bare)[0, :, Column.X].tolist() == [0.0, 9.0, 9.0]
    assert rows(HERE + part + placed)[0, :, Column.X].tolist() == [30.0, 9.0, 9.0]


def test_the_timestep_of_scenic_is_the_step_of_the_run() -> None:
    """With a `model` line; `simulation` comes first, and one that is no step is refused."""
    car = "ego = new Car on road\n"
    said = "param timestep = 0.1\n"
    assert compile_text(MODEL + said + car).config.simulation.time_step == 0.1
    assert compile_text(HERE + said + car).config.simulation.time_step == 0.05
    both = MODEL + said + "simulation(time_step=0.02 s)\n" + car
    assert compile_text(both).config.simulation.time_step == 0.02
    assert errors(MODEL + "param timestep = 9\n" + car) == ["SCN402"]


@pytest.mark.parametrize(
    ("expression", "text"),
    [
        ('f"{3} {2.5:.2f} {7:03d} {{}}"', "3 2.50 007 {}"),
        ("f'{30 km/h:.1f} {1.5 m} {90 deg:.2f}'", "8.3 m/s 1.5 m 1.57 rad"),
        ("f'''{True} {None} {[1, 2]} {(1, 'a')}'''", "True None [1, 2] (1, a)"),
        ("f\"{'a':>3}{(lambda x: x + 1)(2)}{3 != 4}\"", "  a3True"),
        ('"a" + str(2) + str(1e300)', "a21e+300"),
        ('f"{ego} {ManeuverType.LEFT_TURN}"', "ego LEFT_TURN"),
    ],
)
def test_texts_hold_values(expression: str, text: str) -> None:
    """As Python writes them; numbers with their unit, things of the road by their name."""
    rows(HERE + EGO + f"assert {expression} == {text!r}, {expression}\n")


def test_int_is_the_whole_part_towards_zero() -> None:
    """Of what is known and of what is drawn."""
    known = "assert [int(-2.7), int(2.7), int(-0.2), int('-3'), int(True), float('2.5')] == [-2, 2, 0, -3, 1, 2.5]\n"
    drawn = "x = Range(-3, 3)\nrequire int(x) == (floor(x) if x >= 0 else ceil(x))\n"
    rows(HERE + known + EGO + drawn, 50)
    spread = rows(HERE + "ego = new Object at (int(Range(-3, 3)), 0)\n", 200)[:, 0, Column.X]
    assert set(spread.tolist()) == {-2.0, -1.0, 0.0, 1.0, 2.0}


def test_classes_are_asked_for() -> None:
    """An object is of its class, of those that this is made from, and of no other."""
    text = HERE + "class Taxi(Car):\n    width: 2\nclass Cab(Taxi):\n    width: 2\n"
    text += f"ego = new Taxi at (3, 2){FREE}\np = new OrientedPoint at (1, 1)\n"
    true = ("ego, Taxi", "ego, Car", "ego, (Truck, Object)", "p, Point", "3, int", "[1], list", "'a', (int, str)")
    false = ("ego, Cab", "ego, Truck", "p, Car", "2.5, int", "(1, 2), list", "3, str", "True, float")
    asserted = [f"assert isinstance({each})\n" for each in (*true, "Range(1, 2), (int, float)")]
    rows(text + "".join([*asserted, *(f"assert not isinstance({each})\n" for each in false)]))
    assert errors(text + "assert isinstance(Range(1, 2), int)\n") == ["SCN506"]


def test_a_copy_of_a_scene_keeps_its_quotes() -> None:
    """What was chosen inside a text stands in the other quotes."""
    text = HERE + f"k = f\"a{{Uniform('x', 'it s')}}\"\nego = new Object at (len([k]), 0){FREE}\nrequire k == 'ax'\n"
    scenario = compile_text(text + "terminate after 1 s\n")
    copy = scenario.concrete(scenario.sample(1, seed=2))
    assert "k = f\"a{'x'}\"" in copy
    compile_text(copy)


def test_an_assertion_says_its_text() -> None:
    """With its values where it is known to be false; what is drawn stays open and is required of the scene."""
    (said,) = [d for d in findings(HERE + 'x = 3\nassert x == 4, f"x is {x}"\n' + EGO) if d.code == "SCN476"]
    assert said.reason == "x is 3"
    drawn = compile_text(HERE + 'x = Range(3, 5)\nassert x < 4, f"x is {x:.2f}"\n' + EGO)
    assert "x is …" in [requirement.name for requirement in drawn.program.requirements]


def test_two_fields_turn_one_another() -> None:
    """Headings add up as the file counts them, whichever side is a field."""
    field = 'f = VectorField("f", lambda p: 0.1 * p.x)\n'
    text = f"{field}ego = new Object at (9, 20), facing (f relative to f){FREE}\n"
    assert rows(MODEL + text)[0, 0, Column.HEADING] == pytest.approx(1.8 + math.pi / 2)
    assert rows(HERE + text)[0, 0, Column.HEADING] == pytest.approx(1.8)


@pytest.mark.parametrize("value", ["1 / (P - P)", "10 ** (300 * P)", "exp(800 * P)"])
def test_a_scene_with_a_number_beyond_all_bounds_fails(value: str) -> None:
    """As one with no number does; no host is given it."""
    scenes = compile_text(f"{HERE}P = Range(1, 2)\nego = new Object at (9, 9), with width {value}{FREE}\n").sample(5)
    assert not scenes.valid.any()
    assert set(scenes.verdict.tolist()) == {Verdict.ERROR}


@pytest.mark.parametrize(("function", "code"), [("lambda p: f", "SCN303"), ("lambda p: (f at p)", "SCN435")])
def test_a_field_that_is_made_of_itself_is_refused(function: str, code: str) -> None:
    """Before anything is asked of it without end."""
    assert errors(f'{HERE}f = VectorField("f", {function})\nego = new Object at (0, 0), facing f\n') == [code]


def test_the_lane_at_a_known_point_is_a_lane() -> None:
    """It has maneuvers and a centre line; inside the intersection, where lanes cross, only the run knows it."""
    text = f"{HERE}lane = network.laneAt((1.75, -30))\nego = new Car on lane.centerline\n"
    rows(text + "assert lane in network.lanes and len(lane.maneuvers) == 3\nrequire ego in lane\n")
    rows(f"{HERE}assert network.laneAt(new Point at (1.75, -30)) is network.laneAt((1.75, -20))\n{EGO}")
    assert errors(f"{HERE}x = network.laneAt((0.3, 0.4)).maneuvers\n{EGO}") == ["SCN630"]


@pytest.mark.parametrize("name", IGNORED)
def test_a_property_that_is_not_read_is_named(name: str) -> None:
    """Of a class of the file, and behind `with`; once, with the number of places."""
    text = f"class T(Car):\n    {name}: 1\nego = new T at (0, 0)\na = new Car at (9, 9), with {name} 1\n"
    (note,) = (found for found in findings(text) if found.code == "SCN226")
    assert note.message == f"not read: `{name}` (2)"
    assert text[note.label.span.start : note.label.span.end] == name
    assert "SCN226" not in {found.code for found in findings(text + "# allow SCN226\n")}


@pytest.mark.parametrize("name", SCENIC_ONLY)
@pytest.mark.parametrize(
    "text",
    [
        "a = new Car at (9, 9), with {name} 1\n",
        "a = new Object at (9, 9), with {name} 1\n",
        "class T(Car):\n    mine: 1\na = new T at (9, 9), with {name} 1\n",
        "class T:\n    {name}: 1\na = new T at (9, 9)\n",
        "class T(Car):\n    {name}: 1\na = new T at (9, 9)\n",
    ],
)
def test_what_turns_or_moves_an_object_in_scenic_alone_is_refused(name: str, text: str) -> None:
    """Also where an object may have properties of its own: it would have no effect, without a word."""
    with pytest.raises(CompileError) as error:
        compile_text(f"ego = new Car at (0, 0)\n{text.format(name=name)}")
    assert error.value.message.startswith("SCN204")
