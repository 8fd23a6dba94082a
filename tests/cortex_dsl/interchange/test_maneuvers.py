"""Maneuver mode of whole scenarios: formulas that hold for other genomes, valid files, and what is said of the rest."""

import re
from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from cortex_dsl import Scenario, compile_text, load
from cortex_dsl.api.runs import OpenedRun, open_run
from cortex_dsl.interchange.cases import ExportCase, case_of_run, case_of_scene
from cortex_dsl.interchange.formats import opendrive
from cortex_dsl.interchange.maneuvers import maneuver_files, maneuver_plan
from cortex_dsl.interchange.maneuvers.formulas import nearest_lane
from engine.interchange.contract import OSC_VERSIONS, ExportOptions
from engine.interchange.opendrive import road_map
from engine.interchange.openscenario.maneuvers.maneuver_plan import ActorPlan, ManeuverPlan, Measure
from engine.interchange.openscenario.read.parameters import substituted
from engine.interchange.openscenario.versions import VERSIONS
from engine.opendrive.read import read_opendrive
from engine.scenes import Scenes, actor_columns
from engine.search.ranking import worst_cases
from engine.vocabulary import Column, State
from engine.xml import read_xml
from tests.schemas import findings

EXAMPLES = sorted((Path(__file__).parents[3] / "examples").glob("*.scn"))
HEAD = """map intersection(ways=4, lanes=1, lane_width=3.5 m, corner_radius=6 m, approach=50 m)
param SPEED = Range(10, 60) km/h
way = [intersection.incomingLanes[0], intersection.incomingLanes[0].maneuvers[0].connectingLane]
spot = new OrientedPoint in intersection.incomingLanes[0].centerline
"""
DRIVES = "    with behavior FollowTrajectoryBehavior(target_speed=SPEED, trajectory=way)\n"
BESIDE = "other = new Car on network.lanes[2]\n"


def row_of(scenes: Scenes, row: int) -> Scenes:
    return replace(scenes, **{each.name: getattr(scenes, each.name)[row : row + 1] for each in fields(scenes)})


def first_scene(scenario: Scenario, seed: int = 1) -> Scenes:
    scenes = scenario.sample(20, seed)
    return row_of(scenes, int(np.flatnonzero(scenes.valid)[0]))


def case_of(scenario: Scenario, seed: int = 1) -> ExportCase:
    return case_of_scene(scenario, first_scene(scenario, seed), Path("case.scn"), seed, "cortexc case.scn")


def plan_of(text: str) -> ManeuverPlan:
    scenario = compile_text(text)
    return maneuver_plan(scenario, first_scene(scenario))


def ego_of(body: str, speed: str = "SPEED") -> ManeuverPlan:
    """The plan of an ego with a behavior of its own, and of a car that stands on another lane."""
    behaviour = "behavior Mine():\n" + "".join(f"    {line}\n" for line in body.splitlines())
    return plan_of(f"{HEAD}{behaviour}ego = new Car at spot,\n    with speed {speed}, with behavior Mine()\n{BESIDE}")


FOLLOW = "do FollowTrajectoryBehavior(target_speed=SPEED, trajectory=way)"


def caught(when: str, act: str) -> str:
    return f"try:\n    {FOLLOW}\ninterrupt when {when}:\n    {act}"


# -- the examples -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_formulas_hold_for_other_genomes(path: Path) -> None:
    """One scene's plan with the values of another on the same lanes says what that one's own plan does."""
    scenario = load(path)
    scenes = scenario.sample(40, seed=5)
    valid = np.flatnonzero(scenes.valid)
    rows = [row for row in valid if scenes.variant[row] == scenes.variant[valid[0]]]
    one, *others = [maneuver_plan(scenario, scenes, int(row)) for row in rows]
    assert others
    for row, other in zip(rows[1:], others, strict=True):
        own = [each.value(other.values) for each in other.formulas()]
        assert [each.value(other.values) for each in one.formulas()] == pytest.approx(own, abs=1e-9)
        assert_is_scene(scenario, scenes, int(row), one, other.values)


def assert_is_scene(
    scenario: Scenario, scenes: Scenes, row: int, plan: ManeuverPlan, values: Mapping[str, float]
) -> None:
    """Starts and speeds of a plan are those of a scene."""
    columns = actor_columns(scenario.program, scenes.values[row])
    network = road_map(scenario.program.road_spec).network
    for actor, own in zip(plan.actors, columns, strict=True):
        assert actor.start.lane is not None
        pose = network.paths.pose(network.lanes[actor.start.lane].path, actor.start.s.value(values))
        centre = own[Column.REAR_TO_CENTER] * np.array([np.cos(pose.heading), np.sin(pose.heading)])
        assert np.array(pose[:2]) + centre == pytest.approx(own[[Column.X, Column.Y]], abs=1e-9)
        assert actor.speed.value(values) == pytest.approx(own[Column.SPEED])


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_every_param_of_the_examples_can_be_varied(path: Path) -> None:
    """All genes decide something in the file, and two shifts stand for what was drawn."""
    scenario = load(path)
    plan = maneuver_plan(scenario, first_scene(scenario))
    names = [each.name for each in plan.parameters]
    assert names == [*scenario.program.space.names, "ego_shift", "adversary_shift"]
    assert not any(actor.exact for actor in plan.actors)
    assert all(each.low <= each.value <= each.high for each in plan.parameters)
    (brakes,) = plan.actors[0].reactions
    assert [each.limit.expression() for group in brakes.when for each in group] == ["$SAFETY_DIST"]
    measures = [each.measure for end in plan.ends for group in end.when for each in group]
    assert measures == [Measure.DISTANCE_TO_START, Measure.RELATIVE_DISTANCE, Measure.COLLISION, Measure.TIME]


@pytest.mark.parametrize("version", OSC_VERSIONS)
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_the_examples_are_valid_in_every_version(path: Path, version: str) -> None:
    export = maneuver_files(case_of(load(path)), "case", ExportOptions(osc=version, mode="maneuver"), "road.xodr")
    assert list(export.files) == (["case.xosc"] if version == "1.0" else ["case.xosc", "case.ranges.xosc"])
    for text in export.files.values():
        assert findings("openscenario", version, text) == []
    assert any("view sector" in remark for remark in export.remarks)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_the_reader_evaluates_every_expression_that_is_written(path: Path, tmp_path: Path) -> None:
    """However long it is: `cortexc import` then names what depends on the simulation, not an expression."""
    files = maneuver_files(case_of(load(path)), "case", ExportOptions(mode="maneuver"), "road.xodr").files
    (tmp_path / "case.xosc").write_text(str(files["case.xosc"]), encoding="utf-8")
    read = substituted(read_xml(tmp_path / "case.xosc", "OpenSCENARIO"))
    values = [value for each in read.walk() for value in each.attributes.values()]
    assert "$" not in "".join(values)


def test_the_command_offers_the_versions_that_there_are() -> None:
    """Three lists, of which the command's must not load the others."""
    from cortex_dsl.cli import export

    assert export.OSC_VERSIONS == OSC_VERSIONS == tuple(VERSIONS)


@pytest.fixture(scope="module")
def small_run(tmp_path_factory: pytest.TempPathFactory) -> OpenedRun:
    """More cases than are looked at as champions, on several lanes."""
    folder = tmp_path_factory.mktemp("maneuvers") / "run"
    load(EXAMPLES[0]).search("random", generations=3, population=40, seed=3, out=folder)
    return open_run(folder)


@pytest.mark.parametrize("rank", [1, 3, -1], ids=["first", "third", "last"])
def test_a_run_has_its_champions(small_run: OpenedRun, rank: int) -> None:
    """The case itself, then those that make the same finite choices, worst first; the others are counted.

    The last case of all is none of the worst, and none of these makes the choices that it makes.
    """
    worst, every = worst_cases(small_run.record.evaluations, 50), small_run.every_case()
    chosen = worst[rank - 1] if rank > 0 else every[-1]
    case = case_of_run(small_run, chosen)
    export = maneuver_files(case, "case", ExportOptions(mode="maneuver"), "road.xodr")
    text = str(export.files["case.champions.xosc"])
    assert findings("openscenario", "1.2", text) == []
    same = [each for each in worst if small_run.scenario.scene(each).variant[0] == case.scenes.variant[0]]
    speeds = re.findall(r'parameterRef="EGO_SPEED" value="([^"]+)"', text)
    gene = small_run.scenario.program.space.names.index("EGO_SPEED")
    expected = [chosen, *(each for each in same if each.genome != chosen.genome)]
    assert [float(each) for each in speeds] == [each.genome[gene] for each in expected]
    assert len(worst) == 50 > len(same)
    said = f"{50 - len(same)} of the run's 50 worst cases make other finite choices"
    assert any(remark.startswith(said) for remark in export.remarks)


def test_integers_of_very_many_values_are_drawn_like_any_number() -> None:
    """And said so; few are named one by one, and both are declared as what they are."""
    text = f"param FEW = DiscreteRange(1, 5)\nparam MANY = DiscreteRange(1, 500)\n{HEAD}ego = new Car at spot,\n"
    text += "    with speed FEW + MANY / 100, with behavior FollowLaneBehavior(SPEED)\n"
    export = maneuver_files(case_of(compile_text(text)), "case", ExportOptions(mode="maneuver"), "road.xodr")
    text = str(export.files["case.xosc"])
    declared = dict(re.findall(r'<ParameterDeclaration name="(\w+)" parameterType="(\w+)"', text))
    assert (declared["FEW"], declared["MANY"], declared["SPEED"]) == ("int", "int", "double")
    ranges = str(export.files["case.ranges.xosc"])
    assert findings("openscenario", "1.2", ranges) == []
    assert ranges.count("<Element ") == 5
    said = [remark for remark in export.remarks if "whole" in remark]
    assert said == ["the ranges draw MANY from all numbers, not from the whole ones alone: they are too many"]


# -- starts -----------------------------------------------------------------------------------------------------------


def start_of(text: str) -> tuple[ActorPlan, ManeuverPlan]:
    plan = plan_of(f"{HEAD}{text}")
    return plan.actors[0], plan


def test_a_start_that_a_param_decides_is_a_formula() -> None:
    made, plan = start_of(
        f"param DIST = Range(5, 40) m\nego = new Car before intersection by DIST along way,\n{DRIVES}"
    )
    assert made.start.s.expression() == "${48.577 - $DIST}"
    assert plan.parameters[-1].name == "DIST"


def test_a_start_that_was_drawn_is_a_parameter_of_its_own() -> None:
    drawn, plan = start_of(f"ego = new Car at spot,\n{DRIVES}")
    assert drawn.start.s.expression() == "$ego_start"
    assert plan.values["ego_start"] == pytest.approx(drawn.start.s.value(plan.values))


def test_a_param_may_be_called_like_a_start() -> None:
    drawn, plan = start_of(f"param ego_start = Range(5, 6) m/s\nego = new Car at spot, with speed ego_start,\n{DRIVES}")
    assert drawn.start.s.expression() == "$ego_start_drawn"
    assert drawn.speed.expression() == "$ego_start"
    assert len(plan.values) == 3


def test_who_stands_beside_a_lane_keeps_its_offset_and_turn() -> None:
    made, _ = start_of(f"ego = new Car at spot offset by 0.3 @ 0, facing spot.heading + 5 deg,\n{DRIVES}")
    assert made.start.lane == 0
    assert made.start.offset == pytest.approx(-0.3 - 1.423 * np.sin(np.radians(5.0)))
    assert made.start.turned == pytest.approx(np.radians(5.0))
    assert made.start.s.plain


def test_who_stands_off_the_road_is_put_in_the_plane() -> None:
    made, _ = start_of("ego = new Car at (60, 60), facing 0 rad, with regionContainedIn None, with speed SPEED\n")
    assert made.exact
    assert made.start.lane is None
    assert made.start.pose == pytest.approx((60.0 - 1.423, 60.0, 0.0))


@pytest.mark.parametrize("seed", range(5))
def test_the_lane_somebody_is_on_is_that_of_the_simulator(seed: int) -> None:
    """`engine.kernels.region.lane_nearest` is what runs ask."""
    from engine.kernels.nearest_lane import lane_nearest

    program = load(EXAMPLES[0]).program
    network = road_map(program.road_spec).network
    for x, y, heading in np.random.default_rng(seed).uniform([-60, -60, -4], [60, 60, 4], (40, 3)).tolist():
        assert nearest_lane(network, x, y, heading) == lane_nearest(program.road, x, y, heading)


def test_two_ends_of_one_name_stay_two() -> None:
    """Readers want names of their own for all conditions."""
    near = "    try:\n        " + FOLLOW
    for distance in (3, 5):
        near += f"\n    interrupt when withinDistanceToAnyObjs(self, {distance} m):\n        terminate"
    text = f"{HEAD}behavior Mine():\n{near}\nego = new Car at spot, with behavior Mine()\n{BESIDE}"
    case = case_of(compile_text(text))
    (first, *_) = maneuver_files(case, "case", ExportOptions(mode="maneuver"), "road.xodr").files.values()
    stop = str(first).partition("</Story>")[2]
    names = re.findall(r'<Condition name="([^"]+)"', stop)
    assert len(names) == len(set(names)) == 4


# -- behaviours -------------------------------------------------------------------------------------------------------


def test_later_interrupts_go_before_earlier_ones() -> None:
    first = "interrupt when withinDistanceToAnyObjs(self, 20 m):\n    take SetBrakeAction(0.2)"
    second = "interrupt when withinDistanceToAnyObjs(self, 5 m):\n    take SetBrakeAction(1)"
    hard, soft = ego_of(f"try:\n    {FOLLOW}\n{first}\n{second}").actors[0].reactions
    assert hard.change.rate.number == pytest.approx(8.0, abs=1e-3)
    assert [(each.limit.number, each.below) for each in hard.when[0]] == [(5.0, True)]
    assert [(each.limit.number, each.below) for each in soft.when[0]] == [(20.0, True), (5.0, False)]


@pytest.mark.parametrize(
    ("when", "measure", "below"),
    [
        ("(distance from self to other) < 9 m", Measure.RELATIVE_DISTANCE, True),
        ("(distance from self to other) > 9 m", Measure.RELATIVE_DISTANCE, False),
        ("timeToCollision(self, other) < 2 s", Measure.TIME_TO_COLLISION, True),
        ("self.speed > 9 m/s", Measure.SPEED, False),
        ("(distance from self to spot) > 9 m", Measure.DISTANCE_TO_START, False),
    ],
)
def test_conditions_that_can_be_said(when: str, measure: Measure, below: bool) -> None:
    plan = plan_of(
        f"{HEAD}behavior Mine(other):\n    try:\n        {FOLLOW}\n    interrupt when {when}:\n"
        "        take SetBrakeAction(1)\nother = new Car on network.lanes[2]\n"
        "ego = new Car at spot, with speed SPEED, with behavior Mine(other)\n"
    )
    actor = next(each for each in plan.actors if each.name == "ego")
    (reaction,) = actor.reactions
    ((condition,),) = reaction.when
    assert (condition.measure, condition.below) == (measure, below)


@pytest.mark.parametrize(
    ("body", "said"),
    [
        (caught("withinDistanceToAnyObjs(self, 9 m)", "take SetThrottleAction(1)"), "an action other than a brake"),
        (caught("withinDistanceToAnyObjs(self, 9 m)", "wait"), "`interrupt` with `wait`"),
        (caught("self in intersection", "take SetBrakeAction(1)"), "`interrupt` with a condition on region"),
        (f"require self.speed < 90 m/s\n{FOLLOW}", "a `require` or precondition"),
    ],
)
def test_what_is_left_out_is_named_with_its_line(body: str, said: str) -> None:
    plan = ego_of(body)
    assert not plan.actors[0].exact
    remark = next(each for each in plan.remarks if said in each)
    assert re.search(r"left out of `ego`: .*\(line \d+\)$", remark)


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("while True:\n    take SetThrottleAction(0.5)", "an action other than a brake (throttle)"),
        ("while self.speed > 1 m/s:\n    take SetBrakeAction(0.5)\n" + FOLLOW, "what it does after a loop"),
        (f"if self.speed > 3 m/s:\n    {FOLLOW}\nelse:\n    take SetBrakeAction(1)", "`if`"),
        ("do choose FollowLaneBehavior(5 m/s), ConstantSpeedBehavior(3 m/s)", "`do choose` or `do shuffle`"),
        ("do CarFollowingBehavior(target_speed=SPEED)", "a target speed that depends on"),
        (f"{FOLLOW} for 3 s\ndo ConstantSpeedBehavior(3 m/s)", "what it does after `try`"),
        ("x = 1\nwhile x < 5:\n    x = x + 1\n    wait", "a number that changes while it drives"),
        ("take SetBrakeAction(1)", "an action of its own"),
    ],
)
def test_who_cannot_be_said_goes_along_its_trajectory(body: str, said: str) -> None:
    """And says so, with the construct and its line."""
    plan = ego_of(body)
    assert plan.actors[0].exact
    remark = next(each for each in plan.remarks if "recorded trajectory" in each)
    assert said in remark
    assert re.search(r"\(line \d+\)", remark)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("monitor Calm():\n    while True:\n        wait\nrequire monitor Calm()\n", "what `Calm` does is left out"),
        ("require always ego.speed < 90 m/s\n", "is not watched"),
        ("require eventually ego.speed > 1 m/s\n", "temporal requirements are not watched"),
        ("record ego.speed\n", "nothing is recorded"),
        ("terminate when ego in intersection\n", "is left out"),
        ("param IDLE = Range(0, 1)\n", "nothing in the file depends on"),
    ],
)
def test_what_belongs_to_nobody_is_named(text: str, said: str) -> None:
    plan = plan_of(f"{HEAD}ego = new Car at spot, with behavior FollowLaneBehavior(SPEED)\n{text}")
    assert any(said in remark for remark in plan.remarks)


def test_walkers_go_along_their_trajectory_and_things_just_stand() -> None:
    plan = plan_of(
        f"{HEAD}ego = new Car at spot\nbox = new Obstacle on network.lanes[2]\n"
        "walker = new Pedestrian on network.lanes[4], with behavior WalkForwardBehavior(1 m/s)\n"
    )
    exact = {actor.name: actor.exact for actor in plan.actors}
    assert exact == {"ego": False, "box": False, "walker": True}
    assert any("pedestrian" in remark for remark in plan.remarks)


def test_a_lane_that_only_the_start_knows_is_followed() -> None:
    """`FollowLaneBehavior` looks for its lane when it begins, which a scene has settled."""
    plan = ego_of("do FollowLaneBehavior(SPEED)")
    assert not plan.actors[0].exact
    assert plan.actors[0].route[0] == plan.actors[0].start.lane
    assert plan.actors[0].phases[0].change.speed.expression() == "${$SPEED / 3.6}"


@pytest.mark.parametrize("seed", range(6))
def test_a_lane_that_a_param_chooses_is_the_one_of_the_scene(seed: int) -> None:
    """Where a gene decides some of the choices and chance the others, the plan is that of the scene's own variant."""
    scenario = compile_text(f"""{HEAD}drawn = Uniform(*intersection.incomingLanes)
param LANE = Uniform(0, 1, 2, 3)
lane = intersection.incomingLanes[LANE]
beside = Uniform(*drawn.maneuvers)
ego = new Car in lane.centerline,
    with behavior FollowTrajectoryBehavior(target_speed=SPEED, trajectory=[lane, lane.maneuvers[0].connectingLane])
other = new Car in beside.endLane.centerline
""")
    scenes = first_scene(scenario, seed)
    plan = maneuver_plan(scenario, scenes)
    x, y = actor_columns(scenario.program, scenes.values[0])[0, [Column.X, Column.Y]]
    network = scenario.compiled.scenario.network
    first = network.lanes[plan.actors[0].route[0]]
    assert network.paths.distance(first.path, x, y) < 1e-6


def test_who_runs_wide_of_its_lanes_goes_along_its_trajectory(worst: ExportCase) -> None:
    """Players keep an actor on its lane, whatever its speed; by how much it left it is said."""
    recording = worst.recording
    states = recording.states.copy()
    path = states[: recording.scored_samples(), 1, State.X : State.Y + 1]
    path += np.linspace(0.0, 2.0, len(path))[:, np.newaxis]
    wide = maneuver_plan(worst.scenario, worst.scenes, run=replace(recording, states=states))
    assert [actor.exact for actor in wide.actors] == [False, True]
    assert any(
        re.search(r"`adversary` goes along .* it runs \d\.\d m wide of its lanes", said) for said in wide.remarks
    )
    assert not any(actor.exact for actor in maneuver_plan(worst.scenario, worst.scenes).actors)


@pytest.mark.parametrize("name", ["village", "overtaking"])
def test_places_lie_on_the_lanes_of_the_road(name: str, tmp_path: Path) -> None:
    """On the roads of a file, and on curved ones: read by their road, lane and s, actors begin where they do."""
    scenario = load(EXAMPLES[0].parent / "roads" / f"{name}.scn")
    case = case_of(scenario)
    (tmp_path / "road.xodr").write_bytes(next(iter(road_of(case).values())))
    read = read_opendrive(tmp_path / "road.xodr")
    plan = maneuver_plan(scenario, case.scenes)
    export = maneuver_files(case, "case", ExportOptions(), "road.xodr")
    text = export.files["case.xosc"]
    assert isinstance(text, str)
    assert not findings("openscenario", "1.2", text)
    begins = ElementTree.fromstring(text).findall(".//TeleportAction/Position/LanePosition")
    for actor, begin in zip([each for each in plan.actors if each.start.lane is not None], begins, strict=True):
        s = eval(re.sub(r"[${}]", "", begin.attrib["s"]), {}, dict(plan.values))
        there = read.pose(begin.attrib["roadId"], int(begin.attrib["laneId"]), s, float(begin.get("offset", "0")))
        assert (there.x, there.y) == pytest.approx(actor.start.pose[:2], abs=0.01)


def road_of(case: ExportCase) -> Mapping[str, bytes]:
    files = opendrive(case, "case", ExportOptions()).files
    return {name: text if isinstance(text, bytes) else text.encode() for name, text in files.items()}
