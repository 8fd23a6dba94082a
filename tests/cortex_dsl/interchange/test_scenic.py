"""Scenic source: every value fixed, in Scenic's units, headings and names; a remark by line for what it cannot say."""

import math
import os
import re
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from cortex_dsl import Scenario, compile_text, load
from cortex_dsl.interchange.cases import ExportCase, case_of_scene
from cortex_dsl.interchange.formats import FORMATS, scenic
from engine.errors import InterchangeError
from engine.interchange.contract import ExportOptions
from engine.road import LaneRole, build_network
from engine.vocabulary import State

ROOT = Path(__file__).parents[3]
FOUND = [*sorted((ROOT / "examples").glob("*.scn")), *sorted((ROOT / "tests" / "agreement").glob("*.scn"))]
LEFT_HAND = [path for path in FOUND if "left_hand=True" in path.read_text(encoding="utf-8")]
SCENARIOS = [path for path in FOUND if path not in LEFT_HAND]
GOLDEN = Path(__file__).with_name("golden")
ROAD = "map intersection(approach=60 m)\n"
EGO = "ego = new Car at (1.75 m, -40 m), facing 90 deg, with speed 36 km/h"


def case_of(scenario: Scenario, file: str = "case.scn") -> ExportCase:
    """The first valid scene."""
    scenes = scenario.sample(40, 1)
    row = int(np.flatnonzero(scenes.valid)[0])
    one = replace(scenes, **{each.name: getattr(scenes, each.name)[row : row + 1] for each in fields(scenes)})
    return case_of_scene(scenario, one, Path(file), None, "")


def written(text: str, folder: Path | None = None) -> tuple[str, tuple[str, ...]]:
    """The statements behind the head of a scenario's Scenic file, and the remarks."""
    export = scenic(case_of(compile_text(text, "case.scn", folder=folder)), "case", ExportOptions())
    whole = str(export.files["case.scenic"])
    return whole[whole.index("\nmodel scenic") :], export.remarks


def body(statements: str) -> str:
    return written(f"{ROAD}{EGO}\n{statements}\n")[0]


@pytest.mark.parametrize("path", SCENARIOS, ids=lambda path: path.stem)
def test_everybody_stands_where_the_run_began(path: Path, tmp_path: Path) -> None:
    """Place to the last digit, heading from the north, size; nothing of ours is found fault with."""
    case = case_of(load(path))
    export = scenic(case, "case", ExportOptions())
    text = str(export.files["case.scenic"])
    poses = re.findall(r"new (?!OrientedPoint)\w+ at \((\S+), (\S+)\),\s+facing (\S+?),", text)
    first = [state for state in case.recording.states[0] if state[State.PRESENT]]
    for state in first:
        nearest = [(float(x), float(y), float(heading)) for x, y, heading in poses]
        assert (state[State.X], state[State.Y], state[State.HEADING] - math.pi / 2.0) in nearest
    for name, content in export.files.items():
        (tmp_path / name).write_text(str(content), encoding="utf-8")
    check = FORMATS["scenic"].load_checker()
    assert (
        list(
            check(
                replace(case, recording=replace(case.recording, name="case")),
                tmp_path,
                list(export.files),
                ExportOptions(),
            )
        )
        == []
    )


@pytest.mark.parametrize("path", SCENARIOS, ids=lambda path: path.stem)
def test_lanes_are_found_by_points_of_their_own(path: Path) -> None:
    """Each point at which the map is asked for a lane lies on one lane's middle, and on no other lane."""
    case = case_of(load(path))
    text = str(scenic(case, "case", ExportOptions()).files["case.scenic"])
    network = build_network(case.scenario.program.road_spec)
    lanes = [lane for lane in network.lanes if lane.role is not LaneRole.CONNECTING]
    for name, x, y in re.findall(r"^lane_(\S+) = network\.laneAt\(\((\S+), (\S+)\)\)", text, re.MULTILINE):
        off = {lane: network.paths.distance(lane.path, float(x), float(y)) for lane in lanes}
        near = [re.sub(r"\W", "_", lane.name) for lane in lanes if off[lane] < lane.width / 2]
        assert near == [name]


def test_units_are_si() -> None:
    """Scenic has none; the author's stands behind the number of a param."""
    text, _ = written(f"{ROAD}param SPEED = 36 km/h\n{EGO}\nGAP = 2 km\nterminate after 1 min\n")
    assert "SPEED = 10  # 36 km/h\nparam SPEED = SPEED" in text
    assert "GAP = 2000" in text
    assert "terminate after 60 seconds" in text
    assert "with speed 10" in text


def test_times_have_a_word_behind_them() -> None:
    """Also those that are worked out."""
    behavior = (
        "    do IdleBehavior() for t + 1 s\n    do IdleBehavior() for 3 steps\n    wait for t\n    wait for 2 steps\n"
    )
    text = body(f"WAIT = 2 s\nbehavior B(t):\n{behavior}")
    assert "do IdleBehavior() for t + 1 seconds" in text
    assert "do IdleBehavior() for 3 steps" in text
    assert "wait for t seconds" in text
    assert "wait for 2 steps" in text


def test_headings_are_from_the_north() -> None:
    """Ours are from the east; where the author's file has a `model` line they are Scenic's already."""
    ours = "behavior B():\n    if self.heading > 30 deg:\n        wait\n"
    assert "if self.heading + 90 deg > 30 deg:" in body(ours)
    text, _ = written(f"{ROAD}model scenic.domains.driving.model\nego = new Car at (1.75, -40), facing 0 deg\n{ours}")
    assert "if self.heading > 30 deg:" in text
    assert "new Car at (1.75, -40.0), facing 0.0" in text.replace("\n    ", " ")


def test_degrees_bind_loosely() -> None:
    """`6 / 3 deg` is `(6 / 3) deg` there."""
    assert f"PART = 6 / {math.radians(3)!r}" in body("PART = 6 / 3 deg\n")


def test_steering_is_a_share_to_the_right() -> None:
    """Ours is an angle, positive to the left."""
    text = body("behavior B():\n    take SetSteerAction(5 deg)\n")
    assert re.search(r"SetSteerAction\(-\(5 deg / 0\.\d+\)\)", text)


def test_motion_sight_and_walking_are_scenic_s() -> None:
    """Velocities, views and turns on foot have its own words; a direction counts from the north."""
    text, remarks = written(
        f"{ROAD}{EGO}\nspot = new OrientedPoint at (30, 20), with visibleDistance 9 m, with viewAngle 90 deg\n"
        "behavior Walk():\n    take SetWalkingDirectionAction(30 deg), SetWalkingSpeedAction(2 m/s)\n"
        "    take SetWalkingDirectionAction(self.heading)\n"
        "new Pedestrian at (20, 20), with behavior Walk()\n"
        "new Object in CircularRegion((30, 20), 9) visible from spot\n"
        "require (30, 20) in spot.visibleRegion\nterminate when ego.velocity.x > 9 or ego.angularSpeed > 1\n"
        "require always (1.75, -20) in ego.visibleRegion\n"
    )
    for line in (
        "SetWalkingDirectionAction(-60 deg), SetWalkingSpeedAction(2)",
        "take SetWalkingDirectionAction(self.heading)",
        "in spot.visibleRegion",
        "terminate when ego.velocity.x > 9 or ego.angularSpeed > 1",
        "always (1.75, -20) in ego.visibleRegion",
    ):
        assert line in text, text
    assert not [remark for remark in remarks if "Scenic has no" in remark]


def test_lights_are_left_out_with_their_line() -> None:
    """As a comment, and as a remark; the arguments that speak of them go, too."""
    scenario = f"{ROAD}signals(green=3 s)\n{EGO},\n    with behavior FollowLaneBehavior(9 m/s, obey_signals=True)\n"
    text, remarks = written(scenario)
    assert "# signals(green=3 s)" in text
    assert any(remark.startswith("line 2: traffic lights") for remark in remarks)
    assert any("`obey_signals`" in remark and remark.startswith("line 4: ") for remark in remarks)
    assert "with behavior FollowLaneBehavior(9)" in text


def test_expectations_and_objectives_are_left_out_with_their_line() -> None:
    """Scenic refuses a file with such a line as a whole; all of its lines stay, behind number signs."""
    text, remarks = written(
        f'{ROAD}{EGO}\nexpect always ego.speed < 9 m/s as "slow"\nmaximize largest(\n    ego.speed\n) as "fast"\n'
        "minimize final(ego.speed)\n"
    )
    assert not re.search(r"^(expect|maximize|minimize)\b", text, re.MULTILINE)
    assert '# left out, Scenic has no `expect`:\n# expect always ego.speed < 9 m/s as "slow"\n' in text
    assert '# maximize largest(\n#     ego.speed\n# ) as "fast"\n' in text
    assert "line 3: Scenic has no `expect`: left out" in remarks
    neither = "Scenic has neither `maximize` nor `minimize`: left out"
    assert [f"line 4: {neither}", f"line 7: {neither}"] == [each for each in remarks if neither in each]


@pytest.mark.parametrize("thing", ["Obstacle", "Barrier", "Object", "Crate"])
def test_things_may_stand_where_the_ego_does_not_see_them(thing: str) -> None:
    """Scenic's `Object` has to be seen at the start unless it says otherwise; its cars and pedestrians need not."""
    text = body(f"class Crate(Obstacle):\n    length: 2 m\nthing = new {thing} at (6 m, 6 m), facing 0 deg")
    assert text.count("with requireVisible False") == 1
    assert "with requireVisible False" in text[text.index("thing = new") :]


def test_a_condition_without_words_is_left_out_alone() -> None:
    """The rest of the behaviour stays."""
    text, remarks = written(
        f"{ROAD}{EGO}, with behavior B()\nother = new Car at (-1.75 m, 30 m), facing 270 deg\n"
        "behavior B():\n    try:\n        do FollowLaneBehavior(9 m/s)\n"
        "    interrupt when timeToCollision(self, other) < 2 s:\n        take SetBrakeAction(1)\n"
        "    interrupt when (distance to other) < 9 m:\n        take SetBrakeAction(0.5)\n"
    )
    assert "# interrupt when timeToCollision(self, other) < 2 s:\n" in text
    assert "interrupt when distance to other < 9:" in text
    assert "line 7: Scenic has no `timeToCollision`: left out" in remarks


def test_drivers_of_ours_have_stand_ins() -> None:
    """Which say what they lack."""
    text, remarks = written(f"{ROAD}{EGO}, with behavior CarFollowingBehavior(9 m/s, time_headway=2 s)\n")
    assert "behavior CarFollowingBehavior(target_speed=10, trajectory=None):" in text
    assert any("`CarFollowingBehavior`" in remark and "even behind other actors" in remark for remark in remarks)
    assert any("`time_headway`" in remark for remark in remarks)


def test_intersections_are_measured_to_by_their_outline() -> None:
    """Scenic's own lies centimetres beside it."""
    text = body("require (distance from ego to intersection) > 30 m")
    assert "require distance from ego to area_of_intersection > 30" in text
    assert re.search(r"area_of_intersection = PolygonalRegion\(\[\(-?9\.5, -?3\.5\)", text)


def test_brackets_of_temporal_formulas() -> None:
    """Scenic reads brackets around one only before few words."""
    text = body(
        'require always (ego.speed > 1 m/s implies next ego.speed > 0 m/s) as "goes"\n'
        "require (always ego.speed > 1 m/s) until ego.y > -30 m\n"
    )
    assert 'require always ego.speed > 1 implies next ego.speed > 0 as "goes"' in text
    assert "require always ego.speed > 1 until ego.position.y > -30" in text


def test_classes_of_ours_come_along() -> None:
    text = body("thing = new Barrier at (6 m, 6 m), with regionContainedIn None\n")
    assert "class Barrier(Object):\n    pass" in text
    assert "with regionContainedIn everywhere" in text


def test_imports_are_put_in(tmp_path: Path) -> None:
    """Scenic has modules of its own: what is imported stands in the file. Under a name of its own it cannot."""
    (tmp_path / "cars.scn").write_text("LENGTH = 4.8 m\nclass Taxi(Car):\n    length: LENGTH\n", encoding="utf-8")
    use = "ego = new Taxi at (1.75 m, -40 m), facing 90 deg\n"
    text, _ = written(f"from cars import Taxi\n{ROAD}{use}", tmp_path)
    assert "LENGTH = 4.8\n\nclass Taxi(Car):\n    length: LENGTH" in text
    with pytest.raises(InterchangeError, match="under a name of its own"):
        written(f"import cars as c\n{ROAD}{EGO}\nLENGTH = c.LENGTH\n", tmp_path)


def test_left_hand_roads_are_refused() -> None:
    """Scenic reads them as right-hand ones: every lane would run the wrong way."""
    with pytest.raises(InterchangeError, match="right-hand traffic"):
        written("map intersection(left_hand=True)\nego = new Car on road\n")
    for path in LEFT_HAND:
        with pytest.raises(InterchangeError, match="right-hand traffic"):
            scenic(case_of(load(path), path.name), path.stem, ExportOptions())


def test_names_of_the_author_are_not_taken() -> None:
    """A lane that is looked up gets another name where the file has that one."""
    text = body("lane_east_in_1 = 3\nlane = network.lanes[2]\n")
    assert re.search(r"^lane_\w+ = network\.laneAt", text, re.MULTILINE)
    assert text.count("lane_east_in_1 = ") <= 2


@pytest.mark.parametrize("path", [path for path in SCENARIOS if path.parent.name == "agreement"], ids=lambda p: p.stem)
def test_golden(path: Path) -> None:
    """The files as they were read by a person, and by Scenic 3.1.1."""
    case = case_of(load(path), path.name)
    text = str(scenic(case, path.stem, ExportOptions()).files[f"{path.stem}.scenic"])
    golden = GOLDEN / f"{path.stem}.scenic"
    if os.environ.get("UPDATE_GOLDEN"):
        GOLDEN.mkdir(exist_ok=True)
        golden.write_text(text, encoding="utf-8")
    assert text == golden.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("action", "there"),
    [
        ("SetSpeedAction(speed=3 m/s)", "SetSpeedAction(3)"),
        ("SetBrakeAction(brake=0.5)", "SetBrakeAction(0.5)"),
        ("SetSteerAction(steer=0)", "SetSteerAction(-(0 / 0.551))"),
        ("SetWalkingSpeedAction(speed=1 m/s)", "SetWalkingSpeedAction(1)"),
    ],
)
def test_actions_are_given_what_they_take_by_place(action: str, there: str) -> None:
    """What we call `speed` is not called so there in all of them."""
    text = f"behavior Acts():\n    while True:\n        take {action}\n"
    assert f"take {there}\n" in body(text)


def test_named_arguments_come_in_their_order() -> None:
    """`thresholdDistance` before `vehicle` is written behind it."""
    condition = "withinDistanceToAnyObjs(thresholdDistance=5 m, vehicle=self)"
    text = f"behavior Acts():\n    while {condition}:\n        wait\n"
    assert "while withinDistanceToAnyObjs(self, 5):\n" in body(text)


def test_a_heading_out_of_a_list_is_left_out() -> None:
    """Turned to the north it cannot be while it is not known which number of the list it is."""
    text = "behavior Acts():\n    way = [30 deg]\n    while True:\n        take SetWalkingDirectionAction(*way)\n"
    statements, remarks = written(f"{ROAD}{EGO}\n{text}")
    assert "# take SetWalkingDirectionAction(*way)" in statements
    assert any("arguments of an action in a list" in each for each in remarks)
