"""Scenarios are valid, complete, and say who is where at every step.

`UPDATE_GOLDEN=1 pytest` on this file writes the files it compares with, to be read before they are kept.
"""

import math
import os
import re
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
import pytest
from hypothesis import given

from engine.interchange import Contact, Export, InterchangeError, Recording, SignalTimes
from engine.interchange.commonroad import write_commonroad
from engine.interchange.commonroad.write import VEHICLES, benchmark_id
from engine.interchange.measuring import measure
from engine.interchange.sources import read_recording
from engine.interchange.xml_writing import decimal
from engine.kernels.geometry import Box, box_distance
from engine.maps import RoadSpec
from engine.road import build_network
from engine.road.opendrive.network import map_file
from engine.vocabulary import ActorKind, EndReason, State
from tests.engine.interchange.commonroad.recordings import LIGHTS, ROAD, SPEED, STEP, absent, actor, crash, recording
from tests.engine.interchange.opendrive.reading_back import specs
from tests.laws import examples
from tests.schemas import findings

VILLAGE = Path(__file__).parents[4] / "examples" / "roads" / "village.xodr"
GOLDEN = Path(__file__).parent / "golden"
NUMBER = r"[1-9][0-9]*"
SIZE = VEHICLES[2]
"""Of the ego, a car."""


def text_of(export: Export) -> str:
    (name,) = (name for name in export.files if name.endswith(".cr.xml"))
    text = export.files[name]
    assert isinstance(text, str)
    return text


def scenario(made: Recording, stem: str = "case-3") -> Element:
    text = text_of(write_commonroad(made, stem))
    assert not findings("commonroad", "", text)
    return ElementTree.fromstring(text)


def value(state: Element, tag: str) -> float:
    text = state.findtext(f"{tag}/exact")
    assert text is not None
    return float(text)


def states(obstacle: Element) -> list[Element]:
    """From step 0 on."""
    return [*obstacle.findall("initialState"), *obstacle.findall("trajectory/state")]


def places(obstacle: Element) -> np.ndarray:
    points = [state.find("position/point") for state in states(obstacle)]
    return np.array([[float(point.findtext(axis, "")) for axis in "xy"] for point in points if point is not None])


@examples(25)
@given(specs())
def test_every_road_is_valid(spec: RoadSpec) -> None:
    """By the schema, which also holds ids unique and references met; with all maneuvers and lights."""
    root = scenario(recording(road=spec, signals=LIGHTS))
    network = build_network(spec)
    assert len(root.findall("lanelet")) == len(network.lanes)
    assert len(root.findall("trafficLight")) == sum(len(each.legs) for each in network.intersections)
    successors = [
        tuple(int(ref.attrib["ref"]) for ref in incoming.findall(f"successors{way}"))
        for incoming in root.findall("intersection/incoming")
        for way in ("Straight", "Left", "Right")
    ]
    assert sorted(sum(successors, ())) == sorted(maneuver.connecting + 1 for maneuver in network.maneuvers)


def test_the_road_of_a_file_is_valid() -> None:
    """With its own lanes, and an intersection for each junction."""
    spec = map_file(VILLAGE, "village.xodr")
    root, network = scenario(recording(road=spec)), build_network(spec)
    assert len(root.findall("lanelet")) == len(network.lanes)
    assert len(root.findall("intersection")) == len(network.intersections)
    assert not root.findall("lanelet/stopLine")


@pytest.mark.parametrize("left_hand", [False, True])
def test_turns_and_who_is_on_the_left(left_hand: bool) -> None:
    """Who comes in from the south has the west on its left, and turns left to it."""
    spec = RoadSpec(left_hand=left_hand)
    root, network = scenario(recording(road=spec)), build_network(spec)
    for incoming in root.findall("intersection/incoming"):
        lane = network.lanes[int(incoming.find("incomingLanelet").attrib["ref"]) - 1]  # type: ignore[union-attr]
        left = next(each for each in lane.maneuvers if each.type.name == "LEFT_TURN")
        assert int(incoming.find("successorsLeft").attrib["ref"]) == left.connecting + 1  # type: ignore[union-attr]
        other = root.find(f"intersection/incoming[@id='{incoming.find('isLeftOf').attrib['ref']}']")  # type: ignore[union-attr]
        from_left = network.lanes[int(other.find("incomingLanelet").attrib["ref"]) - 1]  # type: ignore[union-attr]
        assert from_left.road == left.end_lane.road


def test_every_actor_is_where_it_was() -> None:
    """Centres, full digits; the ego is the problem, the others obstacles of their types, what never moves static."""
    made = recording(*list(ActorKind))
    root = scenario(made)
    kinds = [each.findtext("type") for each in root.findall("dynamicObstacle")]
    assert kinds == ["car", "truck", "bus", "motorcycle", "bicycle", "pedestrian"]
    assert [each.findtext("type") for each in root.findall("staticObstacle")] == ["unknown"]
    for index, obstacle in enumerate(root.findall("dynamicObstacle"), 1):
        assert np.array_equal(places(obstacle), made.states[:, index, [State.X, State.Y]])
        assert [int(value(state, "time")) for state in states(obstacle)] == list(range(len(made)))
        assert [value(state, "velocity") for state in states(obstacle)] == [SPEED] * len(made)
        assert obstacle.findtext("shape/rectangle/length") == f"{made.actors[index].length:g}"
    start = root.find("planningProblem/initialState")
    assert start is not None
    assert value(start, "velocity") == SPEED


def test_the_goal_is_where_the_ego_ends() -> None:
    """At its last step, and no earlier."""
    made = recording()
    goal = scenario(made).find("planningProblem/goalState")
    assert goal is not None
    assert [goal.findtext(f"time/{end}") for end in ("intervalStart", "intervalEnd")] == ["3", "3"]
    center = [float(goal.findtext(f"position/rectangle/center/{axis}", "")) for axis in "xy"]
    assert center == made.states[-1, 0, [State.X, State.Y]].tolist()


def test_rates_follow_from_positions() -> None:
    """A turn of 0.02 rad a step is a yaw rate of 0.2 rad/s at each of its steps."""
    made = recording(ActorKind.CAR)
    made.states[:, 1, State.HEADING] = 20.0 + 0.02 * np.arange(len(made))
    (obstacle,) = scenario(made).findall("dynamicObstacle")
    assert [value(state, "yawRate") for state in states(obstacle)] == pytest.approx([0.02 / STEP] * len(made))
    headings = [value(state, "orientation") for state in states(obstacle)]
    assert headings == pytest.approx([20.0 - 6.0 * np.pi + 0.02 * i for i in range(len(made))])


def test_who_comes_late_waits_aside() -> None:
    """An obstacle must be somewhere from step 0 on: off the road, and a remark says so by name."""
    made = absent(absent(recording(ActorKind.CAR, ActorKind.CAR), 1, 0, 1), 2, 0)
    export = write_commonroad(made, "case")
    root = ElementTree.fromstring(text_of(export))
    west = min(float(x.text or "") for x in root.iterfind("lanelet//x"))
    one, two = (places(obstacle) for obstacle in root.findall("dynamicObstacle"))
    assert (one[:2, 0] < west - 10.0).all()
    assert np.hypot(*(one[0] - two[0])) > 10.0
    assert np.array_equal(one[2:], made.states[2:, 1, [State.X, State.Y]])
    first = root.find("dynamicObstacle")
    assert first is not None
    assert [value(state, "velocity") for state in states(first)] == [0.0, 0.0, SPEED, SPEED]
    assert any("car_1, car_2" in remark and "aside" in remark for remark in export.remarks)


def test_who_leaves_is_gone() -> None:
    """The trajectory ends; nobody is kept standing on the road."""
    (obstacle,) = scenario(absent(recording(ActorKind.CAR), 1, 2, 3)).findall("dynamicObstacle")
    assert len(states(obstacle)) == 2


def test_who_is_never_there_is_named() -> None:
    """Left out, and not in silence."""
    export = write_commonroad(absent(recording(ActorKind.CAR), 1, 0, 1, 2, 3), "case")
    assert "<dynamicObstacle" not in text_of(export)
    assert any(remark.startswith("car_1 is never there") for remark in export.remarks)


def test_time_starts_with_the_ego() -> None:
    """Step 0 is the first at which it is there."""
    export = write_commonroad(absent(recording(ActorKind.CAR), 0, 0), "case")
    (obstacle,) = ElementTree.fromstring(text_of(export)).findall("dynamicObstacle")
    assert len(states(obstacle)) == 3
    assert any("step 0 is 0.1 s into the run" in remark for remark in export.remarks)


def outlines_overlap(root: Element, made: Recording) -> list[bool]:
    """At each step, of two that lie along the x axis: the other against the ego as its solution has it."""
    (other,) = root.findall("dynamicObstacle")
    solution = ElementTree.fromstring(str(write_commonroad(made, "case").files["case.solution.xml"]))
    ego = np.array([[float(state.findtext(axis, "")) for axis in "xy"] for state in solution.iter("ksState")])
    size = made.actors[0].length, made.actors[0].width
    return np.all(np.abs(places(other) - ego) < size, axis=1).tolist()


def test_contact_shows_at_the_step_after_it() -> None:
    """Physics has the two apart again by then; the file has them overlap at that step only, and says so."""
    made = crash()
    assert outlines_overlap(scenario(made), made) == [False, False, False, True, False, False]
    remarks = write_commonroad(made, "case").remarks
    assert any("0.2300 s, lies between steps 2 and 3" in remark for remark in remarks)
    assert any(remark.startswith("at step 3 ") for remark in remarks)


def test_contact_at_the_end_shows_too() -> None:
    """A recording that ends with it gets one step more."""
    made = crash()
    made = replace(made, time=made.time[:4], states=made.states[:4])
    assert outlines_overlap(scenario(made), made) == [False, False, False, True]


def test_contact_at_a_step_shows_at_the_next() -> None:
    """There the outlines only touch."""
    made = crash()
    time, contact = np.delete(made.time, 3), made.contact
    assert contact is not None
    states = np.delete(made.states, 2, axis=0)
    made = replace(made, time=time, states=states, contact=replace(contact, time=0.2))
    assert outlines_overlap(scenario(made), made)[1:4] == [False, False, True]
    assert not any("lies between" in remark for remark in write_commonroad(made, "case").remarks)


def into_a_wall() -> Recording:
    """At 5 m/s the ego's front meets a block 0.23 s into the run, and physics has it back where it came from."""
    road = replace(ROAD, buildings=2.0)
    x, y, heading, length, _ = build_network(road).buildings[0].tolist()
    made = recording(samples=6, road=road)
    off = 0.5 * (length + made.actors[0].length)
    touching = made.states[2:3].copy()
    touching[0, 0, [State.X, State.Y]] = x - off * math.cos(heading), y - off * math.sin(heading)
    along = np.array([math.cos(heading), math.sin(heading)])
    made.states[:, 0, [State.X, State.Y]] = (
        touching[0, 0, [State.X, State.Y]] - SPEED * np.abs(made.time - 0.23)[:, None] * along
    )
    made.states[:, 0, State.HEADING] = touching[0, 0, State.HEADING] = heading
    time, states = np.insert(made.time, 3, 0.23), np.insert(made.states, 3, touching, axis=0)
    return replace(made, time=time, states=states, contact=Contact(0.23, (0,)))


def test_buildings_are_there_and_stop_the_ego(tmp_path: Path) -> None:
    """As obstacles of the environment, whose type `building` the schema has; the ego overlaps one at the step after its
    contact alone, and our own reader takes them for the walls that they are.
    """
    made = into_a_wall()
    assert made.road is not None
    blocks = build_network(made.road).buildings
    root = scenario(made)
    walls = root.findall("environmentObstacle")
    assert [each.findtext("type") for each in walls] == ["building"] * len(blocks) == ["building"] * 4
    assert not list(root.iter("staticObstacle"))
    export = write_commonroad(made, "case")
    assert any("collision checker" in remark for remark in export.remarks)
    assert any(remark.startswith("at step 3 ego stands as it would without contact") for remark in export.remarks)
    for name, text in export.files.items():
        (tmp_path / name).write_text(str(text), encoding="utf-8")
    read = read_recording(tmp_path / "case.cr.xml").recording
    assert read.buildings is not None
    assert np.array_equal(read.buildings, blocks)
    places = read.states[:, 0, [State.X, State.Y, State.HEADING]].tolist()
    boxes = [Box(x, y, heading, *SIZE) for x, y, heading in places]
    hit = [any(box_distance(box, Box(*row)) == 0.0 for row in blocks.tolist()) for box in boxes]
    assert hit == [False, False, False, True, False, False]
    outcomes = measure(read).outcomes
    assert outcomes.end_reason[0] == EndReason.BUILDING
    assert 0.2 < outcomes.end_time[0] <= 0.3


def test_a_road_without_buildings_has_no_obstacles_of_the_environment() -> None:
    """And says nothing of them."""
    export = write_commonroad(recording(ActorKind.CAR), "case")
    assert "environmentObstacle" not in text_of(export)
    assert not any("building" in remark for remark in export.remarks)


def test_who_only_graze_overlap_too() -> None:
    """Corners that clip each other are apart again by the next step: the file shows them on the way there."""
    made = crash()
    length, width = made.actors[0].length, made.actors[0].width
    since = made.time - 0.23
    made.states[:, 0, [State.X, State.Y]] = 0.0
    made.states[:, 1, State.X] = length - 5.0 * since
    made.states[:, 1, State.Y] = width - 0.01 + since  # clear of each other 0.01 s after contact
    assert outlines_overlap(scenario(made), made) == [False, False, False, True, False, False]


@pytest.mark.parametrize("late", [0, 1, 3])
def test_lights_follow_the_plan(late: int) -> None:
    """At every step of three rounds each arm shows what the plan says, also where step 0 is later than the run's 0 s.

    The plan, 4 s of which are over when the run begins: north and south are green from 0 to 10 s, yellow to 13 s; east
    and west green from 15 to 25 s, yellow to 28 s; it starts again at 30 s.
    """
    made = absent(recording(ActorKind.CAR, samples=8, signals=LIGHTS), 0, *range(late))
    greens = {"north": 0.0, "south": 0.0, "east": 15.0, "west": 15.0}
    arms = [leg.name for site in build_network(ROAD).intersections for leg in site.legs]
    for arm, light in zip(arms, scenario(made).iter("trafficLight"), strict=True):
        shown, first = _lamps(light)
        for step in range(3 * len(shown)):
            into = (4.0 + (late + step) * STEP - greens[arm] + 1e-9) % 30.0
            expected = "green" if into < 10.0 else "yellow" if into < 13.0 else "red"
            assert shown[(step - first) % len(shown)] == expected, (arm, step)


def _lamps(light: Element) -> tuple[list[str], int]:
    """What a light shows step by step, and at which step that begins."""
    parts = light.findall("cycle/cycleElement")
    shown = [part.findtext("color", "") for part in parts for _ in range(int(part.findtext("duration", "")))]
    return shown, int(light.findtext("cycle/timeOffset", "0"))


def test_lights_between_steps_are_reported() -> None:
    """And those that somebody may change; a yellow that is shorter than half a step is left out."""
    odd = SignalTimes(green=9.97, yellow=0.03, all_red=2.0, offset=0.0, controlled=True)
    export = write_commonroad(recording(signals=odd), "case")
    assert not findings("commonroad", "", text_of(export))
    assert "yellow" not in text_of(export)
    assert sum("light" in remark for remark in export.remarks) == 2


def test_the_head_states_the_origin() -> None:
    """Provenance and params, escaped; the name by CommonRoad's rule."""
    root = scenario(recording())
    assert root.attrib["source"] == "a car meets <another>; scenario: two & two.scn; seed: 7; SPEED: 18 km/h"
    assert root.attrib["date"] == "2025-03-01"
    assert root.attrib["benchmarkID"] == "ZAM_TwoCars-1_3_T-1"


@pytest.mark.parametrize(
    ("name", "stem"), [("left_turn", "left_turn-12"), ("", ""), ("été 3", "x-0"), ("A b-c", "case 007")]
)
def test_benchmark_ids_follow_the_rule(name: str, stem: str) -> None:
    """Three letters, a map, its number, a configuration, a prediction."""
    assert re.fullmatch(rf"[A-Z]{{3}}_[a-zA-Z0-9]+-{NUMBER}_{NUMBER}_T-{NUMBER}", benchmark_id(name, stem))


@pytest.mark.parametrize("number", [1e-7, -1e-300, 1e22, 0.1 + 0.2, -0.0, 123456789.125, 5e-324])
def test_decimals_read_back(number: float) -> None:
    """Without an exponent, which the schema forbids."""
    assert float(decimal(number)) == number
    assert "e" not in decimal(number).lower()


def broken(made: Recording) -> Recording:
    states = made.states.copy()
    states[1, 0, State.SPEED] = np.nan
    return replace(made, states=states)


@pytest.mark.parametrize(
    ("made", "words"),
    [
        (replace(recording(), road=None), "lanelets"),
        (recording(samples=1), "fewer than two"),
        (absent(recording(), 0, 0, 1, 2, 3), "fewer than two"),
        (replace(recording(), time=np.array([0.0, 0.1, 0.4, 0.5])), "leaves out steps"),
        (broken(recording()), "no finite state"),
    ],
)
def test_what_cannot_be_written(made: Recording, words: str) -> None:
    """Each with a reason and a cure."""
    with pytest.raises(InterchangeError, match=words) as caught:
        write_commonroad(made, "case")
    assert caught.value.cure


def test_golden() -> None:
    """A whole small case, but for all lanelets except one."""
    made = absent(
        recording(ActorKind.TRUCK, ActorKind.OBSTACLE, road=RoadSpec(ways=3, approach=20.0), signals=LIGHTS), 1, 3
    )
    export = write_commonroad(made, "case-3")
    for name, text in export.files.items():
        assert isinstance(text, str)
        text = re.sub(r" <lanelet id=\"(?!1\").*?</lanelet>\n", "", text, flags=re.DOTALL)
        if os.environ.get("UPDATE_GOLDEN"):
            GOLDEN.mkdir(exist_ok=True)
            (GOLDEN / name).write_text(text, encoding="utf-8")
        assert text == (GOLDEN / name).read_text(encoding="utf-8")


# -- Solutions are valid, named as commonroad-io reads them, and hold the ego at every step ----------------------------


def solution(made: Recording) -> Element:
    text = str(write_commonroad(made, "case").files["case.solution.xml"])
    assert not findings("commonroad solution", "", text)
    return ElementTree.fromstring(text)


def column(root: Element, tag: str) -> list[float]:
    return [float(each.text or "") for each in root.iter(tag)]


def test_the_ego_at_every_step() -> None:
    """Centre, heading, speed of the rear axle and steering angle, from step 0 on; for the scenario's one problem."""
    made = recording()
    made.states[:, 0, State.STEER] = 0.125
    root = solution(made)
    for tag, state in (("x", State.X), ("y", State.Y), ("velocity", State.SPEED), ("steeringAngle", State.STEER)):
        assert column(root, tag) == made.states[:, 0, state].tolist()
    assert column(root, "time") == [0.0, 1.0, 2.0, 3.0]
    (trajectory,) = root
    scenario = ElementTree.fromstring(str(write_commonroad(made, "case").files["case.cr.xml"]))
    (problem,) = scenario.findall("planningProblem")
    assert trajectory.attrib["planningProblem"] == problem.attrib["id"]
    assert root.attrib["benchmark_id"] == f"KS2:JB1:{scenario.attrib['benchmarkID']}:2020a"


@pytest.mark.parametrize(("kind", "vehicle"), [(ActorKind.CAR, 2), (ActorKind.TRUCK, 4), (ActorKind.BICYCLE, 1)])
def test_the_vehicle_is_the_nearest_in_size(kind: ActorKind, vehicle: int) -> None:
    """And a remark says so unless it is of the same size."""
    made = replace(recording(), actors=(actor("ego", kind),))
    export = write_commonroad(made, "case")
    assert f'"KS{vehicle}:' in str(export.files["case.solution.xml"])
    assert any(f"vehicle {vehicle}" in remark for remark in export.remarks) == (kind is not ActorKind.CAR)


def test_headings_run_on_within_two_turns() -> None:
    """commonroad-io takes no others: they start near zero, and are wrapped only where a spin leaves two turns."""
    made = recording(samples=12)
    made.states[:, 0, State.HEADING] = 30.0 + 0.7 * np.arange(12)
    found = column(solution(made), "orientation")
    assert max(map(abs, found)) < math.tau
    turns = (np.array(found) - made.states[:, 0, State.HEADING]) / math.tau
    assert turns == pytest.approx(np.round(turns))
    assert np.round(turns).tolist() == [-5.0] * 11 + [-6.0]
