"""Timed polylines become recordings: who, where, when, how fast."""

import math
from pathlib import Path

import numpy as np
import pytest

from engine.vocabulary import ActorKind, State
from tests.engine.interchange.openscenario.read.files import (
    NO_ROAD,
    ROAD,
    STRAIGHT,
    TIMING,
    XODR,
    at_time,
    event,
    follow,
    polyline,
    read,
    refused,
    scenario,
    simple,
    speed,
    teleport,
    vehicle,
    world,
)

POSE = [State.X, State.Y, State.HEADING]
BLOCK = """<ScenarioObject name="{name}"><MiscObject name="b" mass="5" miscObjectCategory="obstacle"><BoundingBox>
 <Center x="0" y="0" z="1"/><Dimensions width="1" length="2" height="1"/></BoundingBox></MiscObject></ScenarioObject>"""
WALKER = """<ScenarioObject name="walker"><Pedestrian name="p" mass="80" pedestrianCategory="pedestrian"><BoundingBox>
 <Center x="0.1" y="0" z="1"/><Dimensions width="0.5" length="0.6" height="2"/></BoundingBox></Pedestrian>
</ScenarioObject>"""


@pytest.mark.parametrize("minor", [0, 1, 2, 3])
def test_a_polyline_is_where_its_centre_was(tmp_path: Path, minor: int) -> None:
    """Vertices are of the rear axle, the recording of the outline's middle; 1.0 places the trajectory otherwise."""
    text = scenario([vehicle("Ego")], [("Ego", follow(STRAIGHT, first=minor == 0))], minor=minor)
    imported = read(tmp_path, text)
    recording = imported.recording
    assert recording.time.tolist() == [0.0, 0.1, 0.2]
    assert recording.states[:, 0, State.X].tolist() == [1.5, 2.5, 3.5]
    assert recording.rear_axle(0)[:, 0] == pytest.approx([0.0, 1.0, 2.0])
    assert recording.states[:, 0, State.SPEED] == pytest.approx([10.0, 10.0, 10.0])
    assert (recording.step, recording.name, recording.commands) == (0.1, "case", False)
    assert (recording.contact, imported.road, imported.remarks) == (None, None, ())
    assert recording.provenance.facts["format"] == f"OpenSCENARIO 1.{minor}"


def test_actors_have_the_size_and_limits_that_the_file_says(tmp_path: Path) -> None:
    """Vehicles, people and things, each with its kind."""
    init = [("Ego", follow(STRAIGHT)), ("walker", teleport(world(5.0, 1.0, 2.0))), ("block", teleport(world(9.0)))]
    recording = read(tmp_path, scenario([vehicle("Ego"), WALKER, BLOCK.format(name="block")], init)).recording
    ego, walker, block = recording.actors
    assert (ego.kind, ego.length, ego.width, ego.rear_to_center, ego.wheelbase) == (ActorKind.CAR, 4.5, 1.8, 1.5, 2.7)
    assert (ego.max_speed, ego.max_acceleration, ego.max_braking, ego.max_steer) == (70.0, 5.0, 9.0, 0.5)
    assert (walker.kind, walker.mass, walker.rear_to_center) == (ActorKind.PEDESTRIAN, 80.0, 0.1)
    assert (block.kind, block.length, block.width) == (ActorKind.OBSTACLE, 2.0, 1.0)
    assert recording.states[:, 2, POSE].tolist() == [[9.0, 0.0, 0.0]] * 3
    assert recording.states[0, 1, POSE] == pytest.approx([5 + 0.1 * math.cos(2), 1 + 0.1 * math.sin(2), 2.0])


def test_the_ego_is_who_is_called_so(tmp_path: Path) -> None:
    """Else the first; an option names another."""
    init = [(name, follow(STRAIGHT)) for name in ("a", "hero", "c")]
    text = scenario([vehicle(name) for name, _ in init], init)
    assert [actor.name for actor in read(tmp_path, text).recording.actors] == ["hero", "a", "c"]
    assert read(tmp_path, text, ego="c").recording.actors[0].name == "c"
    assert read(tmp_path, text.replace("hero", "b")).recording.actors[0].name == "a"


def test_a_property_says_who_the_ego_is(tmp_path: Path) -> None:
    """Before any name does, as ScenarioRunner has it."""
    said = '<Property name="type" value="ego_vehicle"/>'
    init = [(name, follow(STRAIGHT)) for name in ("ego", "b", "hero")]
    text = scenario([vehicle("ego"), vehicle("b", properties=said), vehicle("hero")], init)
    assert [actor.name for actor in read(tmp_path, text).recording.actors] == ["b", "ego", "hero"]


def test_a_trajectory_that_begins_elsewhere_is_reported(tmp_path: Path) -> None:
    """Who is put in one place and follows vertices in another; put twice is put where it was last."""
    init = [("Ego", teleport(world(0, 500)) + follow(STRAIGHT))]
    assert read(tmp_path, scenario([vehicle("Ego")], init)).remarks == ("Ego jumps 500.0 m at 0 s",)
    init = [("Ego", teleport(world(0, 500)) + teleport(world(0, 0)) + follow(STRAIGHT))]
    assert read(tmp_path, scenario([vehicle("Ego")], init)).remarks == ()


def test_a_vertex_far_from_its_neighbours_is_reported(tmp_path: Path) -> None:
    """Where no acceleration explains it; a turn of a coarse polyline is none."""
    for off, jumps in ((1.5, 0), (30.0, 2)):
        way = [(t / 10, world(float(t), off if t == 5 else 0.0, 0.0)) for t in range(9)]
        found = read(tmp_path, simple(polyline(*way)))
        assert found.remarks[0] == f"Ego: its vertex at 0.5 s lies {off:.1f} m off the way of its neighbours"
        assert [remark.count(f"`Ego` jumps {jumps} times, first 30.0 m") for remark in found.remarks[1:]] == [1] * (
            jumps // 2
        )
        assert found.recording.there[:, 0].tolist() == [not (jumps and t == 5) for t in range(9)]
    corner = polyline((0.0, world(0, 0, 0)), (1.0, world(10, 0, 0)), (2.0, world(10, 10, 1.6)))
    assert read(tmp_path, simple(corner)).remarks == ()


@pytest.mark.parametrize(
    "position",
    [
        '<LanePosition roadId="1" laneId="-1" s="5" offset="1e9"/>',
        '<RoadPosition roadId="1" s="5" t="-1e9"/>',
        '<RelativeObjectPosition entityRef="b" dx="1e9" dy="0"/>',
        '<RelativeWorldPosition entityRef="b" dx="0" dy="1e9"/>',
    ],
)
def test_offsets_to_nowhere_are_refused(tmp_path: Path, position: str) -> None:
    """The error says how far they may lead."""
    init = [("b", follow(STRAIGHT)), ("Ego", teleport(f"<Position>{position}</Position>"))]
    error = refused(tmp_path, scenario([vehicle("Ego"), vehicle("b")], init, network=ROAD), XODR)
    assert "from -100000 to 100000" in error.message


def test_leaving_a_road_that_is_not_ours_is_not_judged(tmp_path: Path) -> None:
    """Its outline is not known, which is said."""
    (remark,) = read(tmp_path, simple(network=ROAD), XODR).remarks
    assert "leaves the road is not judged" in remark


def test_missing_headings_lie_along_the_way(tmp_path: Path) -> None:
    """A vertex looks to the next one elsewhere; the last looks on, as esmini has it; turns take the short way."""
    way = polyline(
        (0.0, world(0, 0)), (0.1, world(0, 0)), (0.2, world(-1, 0.1)), (0.3, world(-2, 0)), (0.4, world(-2, -1))
    )
    headings = read(tmp_path, simple(way)).recording.states[:, 0, State.HEADING]
    first, second = math.atan2(0.1, -1.0), math.pi + math.atan2(0.1, 1.0)
    assert headings == pytest.approx([first, first, second, 1.5 * math.pi, 1.5 * math.pi])


def test_given_headings_run_on_by_the_shortest_turn(tmp_path: Path) -> None:
    """From 3.1 to -3.1 is a small turn to the left."""
    way = polyline((0.0, world(0, 0, 3.1)), (0.1, world(-1, 0, -3.1)), (0.2, world(-2, 0, 3.1)))
    headings = read(tmp_path, simple(way)).recording.states[:, 0, State.HEADING]
    assert headings == pytest.approx([3.1, math.tau - 3.1, 3.1])


@pytest.mark.parametrize(
    ("timing", "start", "times"),
    [
        (TIMING, 0.0, [0.0, 0.1, 0.2]),
        ('<Timing domainAbsoluteRelative="absolute" offset="1" scale="2"/>', 0.0, [0.0, 1.0, 1.2, 1.4]),
        ('<Timing domainAbsoluteRelative="relative" offset="0.5" scale="1"/>', 1.0, [0.0, 1.0, 1.5, 1.6, 1.7]),
    ],
)
def test_times_follow_domain_offset_and_scale(tmp_path: Path, timing: str, start: float, times: list[float]) -> None:
    """Relative times count from when the event starts."""
    text = scenario(
        [vehicle("Ego")], [("Ego", teleport(world(0, 0, 0)))], [event("Ego", follow(STRAIGHT, timing), at_time(start))]
    )
    recording = read(tmp_path, text).recording
    assert recording.time == pytest.approx(times)
    assert recording.states[-1, 0, State.X] == pytest.approx(3.5)


def test_who_waits_for_a_trajectory_drives_on(tmp_path: Path) -> None:
    """At the speed of the beginning, and after the last vertex at the last speed."""
    way = polyline((1.0, world(5, 0, 0)), (1.1, world(6, 0, 0)), (1.2, world(7, 0, 0)))
    text = scenario(
        [vehicle("Ego"), vehicle("other")],
        [
            ("Ego", teleport(world(0, 0, 0)) + speed(5)),
            ("other", follow(polyline((0.0, world(0, 9, 0)), (2.2, world(0, 9, 0))))),
        ],
        [event("Ego", follow(way), at_time(1.0))],
    )
    imported = read(tmp_path, text, step=0.1)
    x = np.interp([0.5, 1.0, 1.1, 2.2], imported.recording.time, imported.recording.states[:, 0, State.X])
    assert x == pytest.approx([4.0, 6.5, 7.5, 18.5])
    assert imported.remarks == ()


def test_times_of_all_make_one_grid(tmp_path: Path) -> None:
    """Everybody is at all times of everybody, on straight ways between its own."""
    other = polyline((0.05, world(0, 5, 0)), (0.25, world(2, 5, 0)))
    text = scenario([vehicle("Ego"), vehicle("b")], [("Ego", follow(STRAIGHT)), ("b", follow(other))])
    recording = read(tmp_path, text).recording
    assert recording.time.tolist() == [0.0, 0.05, 0.1, 0.2, 0.25]
    assert recording.states[:, 0, State.X] == pytest.approx([1.5, 2.0, 2.5, 3.5, 4.0])
    assert recording.states[:, 1, State.X] == pytest.approx([1.5, 1.5, 2.0, 3.0, 3.5])
    assert recording.step == 0.1


def test_far_vertices_get_samples_between(tmp_path: Path) -> None:
    """Every 0.05 s, or as asked for."""
    way = polyline((0.0, world(0, 0, 0)), (2.0, world(10, 0, 0)))
    assert len(read(tmp_path, simple(way)).recording) == 41
    recording = read(tmp_path, simple(way), step=0.5).recording
    assert (recording.step, recording.time.tolist()) == (0.5, [0.0, 0.5, 1.0, 1.5, 2.0])


def test_the_stop_trigger_ends_it(tmp_path: Path) -> None:
    """In the middle of a step too; one that is later than all vertices changes nothing."""
    for stop, times in ((0.15, [0.0, 0.1, 0.15]), (7.0, [0.0, 0.1, 0.2])):
        text = scenario([vehicle("Ego")], [("Ego", follow(STRAIGHT))], stop=at_time(stop))
        assert read(tmp_path, text).recording.time == pytest.approx(times)


def test_another_stop_is_passed_over_with_a_remark(tmp_path: Path) -> None:
    """Its name is said."""
    stop = (
        '<ConditionGroup><Condition name="c" delay="0" conditionEdge="none"><ByValueCondition>'
        '<StoryboardElementStateCondition storyboardElementType="act" storyboardElementRef="act" '
        'state="endTransition"/>'
        "</ByValueCondition></Condition></ConditionGroup>"
    )
    imported = read(tmp_path, scenario([vehicle("Ego")], [("Ego", follow(STRAIGHT))], stop=stop))
    assert any("StoryboardElementStateCondition" in remark for remark in imported.remarks)


def test_entities_come_and_go(tmp_path: Path) -> None:
    """Who is added is not there before, who is deleted is not there from then on."""
    add = (
        f'<GlobalAction><EntityAction entityRef="b"><AddEntityAction>{world(3, 3, 0)}</AddEntityAction>'
        "</EntityAction></GlobalAction>"
    )
    leave = '<GlobalAction><EntityAction entityRef="b"><DeleteEntityAction/></EntityAction></GlobalAction>'
    way = polyline(*((t / 10, world(t, 0, 0)) for t in range(6)))
    events = [event("b", add, at_time(0.1)), event("b", leave, at_time(0.3)), event("b", add, at_time(0.5))]
    recording = read(tmp_path, scenario([vehicle("Ego"), vehicle("b")], [("Ego", follow(way))], events)).recording
    assert recording.states[:, 1, State.PRESENT].tolist() == [0, 1, 1, 0, 0, 1]
    assert recording.states[1, 1, POSE].tolist() == [4.5, 3.0, 0.0]


LANE = '<Position><LanePosition roadId="1" laneId="-1" s="{}" offset="{}"/></Position>'


def test_positions_on_the_road(tmp_path: Path) -> None:
    """Lane and road positions, and those relative to one that stands or drives on along its lane."""
    relative = '<Position><RelativeLanePosition entityRef="{}" dLane="{}" ds="{}" offset="0"/></Position>'
    road_position = '<Position><RoadPosition roadId="1" s="5" t="2"/></Position>'
    oriented = (
        '<Position><LanePosition roadId="1" laneId="1" s="40"><Orientation type="relative" h="0.5"/></LanePosition>'
        "</Position>"
    )
    names = ["Ego", "a", "b", "c", "d", "e"]
    init = [
        ("Ego", teleport(LANE.format(10, 0.5)) + speed(10)),
        ("a", teleport(relative.format("Ego", -1, 20))),
        ("b", teleport(relative.format("Ego", 1, 20))),
        ("c", teleport(road_position)),
        ("d", teleport(oriented)),
        ("e", teleport('<Position><RelativeRoadPosition entityRef="c" ds="1" dt="-1"/></Position>')),
    ]
    way = polyline(*((t / 10, relative.format("Ego", 0, 10 * t / 10)) for t in range(3)))
    timing = TIMING.replace("absolute", "relative")
    text = scenario(
        [vehicle(name, center=0.0) for name in names],
        init,
        [event("Ego", follow(way, timing), at_time(1.0))],
        network=ROAD,
    )
    imported = read(tmp_path, text, XODR)
    first, last = imported.recording.states[0][:, POSE], imported.recording.states[-1][:, POSE]
    expected = [[10, -1, 0], [30, -5, 0], [30, 1.5, math.pi], [5, 2, 0], [40, 1.5, math.pi + 0.5], [6, 1, 0]]
    assert first == pytest.approx(np.array(expected))
    assert last[0] == pytest.approx([22.0, -1.5, 0.0])
    assert imported.road is not None


def test_positions_relative_to_others(tmp_path: Path) -> None:
    """In the frame of the other, or along the axes of the world; of one that moves, where it is then."""
    in_frame = (
        '<Position><RelativeObjectPosition entityRef="Ego" dx="1" dy="2"><Orientation type="relative" h="0.25"/>'
        "</RelativeObjectPosition></Position>"
    )
    on_axes = '<Position><RelativeWorldPosition entityRef="Ego" dx="1" dy="2"/></Position>'
    way = polyline((0.0, world(0, 0, math.pi / 2)), (1.0, world(0, 10, math.pi / 2)))
    init = [("Ego", teleport(world(0, 0, math.pi / 2)) + follow(way))]
    entities = [vehicle(name, center=0.0) for name in ("Ego", "a", "b")]
    places = [event("a", teleport(in_frame), at_time(0.5)), event("b", teleport(on_axes), at_time(0.5))]
    text = scenario(entities, [*init, ("a", teleport(world(9))), ("b", teleport(world(9)))], places)
    last = read(tmp_path, text).recording.states[-1][:, POSE]
    assert last[1] == pytest.approx([-2.0, 6.0, math.pi / 2 + 0.25])
    assert last[2] == pytest.approx([1.0, 7.0, math.pi / 2])


def test_entities_and_trajectories_of_a_catalog_beside(tmp_path: Path) -> None:
    """With values assigned to their parameters."""
    body = vehicle("x").split(">", 1)[1].removesuffix("</ScenarioObject>")
    body = body.replace('name="x"', 'name="sedan"').replace('length="4.5"', 'length="$Length"')
    declared = '<ParameterDeclarations><ParameterDeclaration name="Length" parameterType="double" value="4"/>'
    body = body.replace("<BoundingBox>", declared + "</ParameterDeclarations><BoundingBox>")
    way = f'<Trajectory name="way" closed="false"><Shape>{STRAIGHT}</Shape></Trajectory>'
    head = '<FileHeader revMajor="1" revMinor="2"/>'
    (tmp_path / "cats").mkdir()
    for name, content in (("Cars", body), ("Ways", way)):
        catalog = f'<OpenSCENARIO>{head}<Catalog name="{name}">{content}</Catalog></OpenSCENARIO>'
        (tmp_path / "cats" / f"{name}.xosc").write_text(catalog)
    car = (
        '<ScenarioObject name="Ego"><CatalogReference catalogName="Cars" entryName="sedan"><ParameterAssignments>'
        '<ParameterAssignment parameterRef="Length" value="6"/></ParameterAssignments></CatalogReference>'
        "</ScenarioObject>"
    )
    action = follow(STRAIGHT)
    begin, end = action.index("<Trajectory name"), action.index("</Trajectory>") + len("</Trajectory>")
    reference = '<CatalogReference catalogName="Ways" entryName="way"/>'
    locations = '<VehicleCatalog><Directory path="cats"/></VehicleCatalog>'
    text = scenario([car], [("Ego", action[:begin] + reference + action[end:])], catalogs=locations)
    recording = read(tmp_path, text).recording
    assert recording.actors[0].length == 6.0
    assert len(recording) == 3


def test_what_is_not_replayed_is_reported(tmp_path: Path) -> None:
    """Another action of who follows a trajectory, lights, a map that is known by name only, and jumps."""
    lights = '<TrafficSignals><TrafficSignalController name="x"/></TrafficSignals>'
    network = f'<RoadNetwork><LogicFile filepath="Town01"/>{lights}</RoadNetwork>'
    way = polyline((1.0, world(50, 0, 0)), (1.1, world(51, 0, 0)))
    events = [event("Ego", follow(way), at_time(1.0)), event("Ego", speed(3.0))]
    remarks = read(
        tmp_path, scenario([vehicle("Ego")], [("Ego", teleport(world(0, 0, 0)))], events, network=network)
    ).remarks
    for word in ("traffic lights", '"Town01"', "jumps 50.0 m at 1 s", "<SpeedAction> of Ego"):
        assert any(word in remark for remark in remarks), word


def test_actions_without_motion_change_nothing(tmp_path: Path) -> None:
    """Controllers, appearance, environment."""
    action = "<PrivateAction><ControllerAction><AssignControllerAction/></ControllerAction></PrivateAction>"
    text = scenario([vehicle("Ego")], [("Ego", action + follow(STRAIGHT))], [event("Ego", action)], network=NO_ROAD)
    assert read(tmp_path, text).remarks == ("not read: `ControllerAction` (2, case.xosc, line 11)",)


def test_speeds_have_the_sign_of_the_motion(tmp_path: Path) -> None:
    """Who backs up has a negative speed; sideways motion is none."""
    back = polyline(*((t / 10, world(-float(t), 0, 0.0)) for t in range(4)))
    assert read(tmp_path, simple(back)).recording.states[:, 0, State.SPEED] == pytest.approx([-10.0] * 4)
    aside = polyline(*((t / 10, world(0, float(t), 0.0)) for t in range(4)))
    assert read(tmp_path, simple(aside)).recording.states[:, 0, State.SPEED] == pytest.approx([0.0] * 4)


def test_a_trajectory_that_may_be_steered_is_reported(tmp_path: Path) -> None:
    """In mode `follow` a simulator stays near the trajectory only."""
    text = simple().replace('followingMode="position"', 'followingMode="follow"')
    assert any("mode `follow`" in remark for remark in read(tmp_path, text).remarks)


def test_sparse_vertices_are_followed_at_constant_accelerations(tmp_path: Path) -> None:
    """In mode `follow`, as esmini 3.6 does it: from 5 m/s 20 m in 2 s take 5 m/s^2; 15 m/s are too fast for 24 m in
    4 s, so that it stops there 0.8 s earlier. In mode `position` it is even from one vertex to the next.
    """
    way = polyline((0.0, world(0, 0, 0)), (2.0, world(20, 0, 0)), (6.0, world(44, 0, 0)))
    start = teleport(world(0, 0, 0)) + speed(5.0)
    text = scenario([vehicle("Ego")], [("Ego", start)], [event("Ego", follow(way), at_time(0))])
    even = read(tmp_path, text).recording
    recording = read(tmp_path, text.replace('followingMode="position"', 'followingMode="follow"')).recording
    offset = even.states[0, 0, State.X]

    def at(time: float) -> int:
        return int(np.flatnonzero(np.abs(recording.time - time) < 1e-9)[0])

    x = recording.states[:, 0, State.X] - offset
    assert x[[at(1.0), at(2.0), at(4.0), at(5.2), at(6.0)]] == pytest.approx([7.5, 20.0, 40.625, 44.0, 44.0])
    assert recording.states[at(1.0), 0, State.SPEED] == pytest.approx(10.0)
    assert even.states[at(1.0), 0, State.X] - offset == pytest.approx(10.0)
