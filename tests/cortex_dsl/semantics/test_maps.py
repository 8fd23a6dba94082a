"""`map`: lone roads and the roads of files, by the native line and by Scenic's."""

import math
import os
from pathlib import Path

import pytest

from cortex_dsl.diagnostics import CompileError, Severity
from cortex_dsl.files import Folder
from cortex_dsl.pipeline import Compiled, compile_source
from cortex_dsl.source import Source
from engine.maps import LoneRoad, MapFile, RoadSpec, Roundabout

ROADS = Path(__file__).parents[3] / "examples" / "roads"
VILLAGE = 'map opendrive("village.xodr")\n'
ALWAYS_TRUE = "SCN480"
UNREAD = "SCN466"
"""On what a map states and nothing reads: `test_unread` is about that."""
EGO = "ego = new Car on road\n"


def compiled(text: str, folder: Path = ROADS) -> Compiled:
    return compile_source(Source("here.scn", text), files=Folder(folder))


def codes(text: str, folder: Path = ROADS) -> list[str]:
    try:
        found = compiled(text, folder).diagnostics
    except CompileError as error:
        found = error.diagnostics
    return [each.code for each in found if each.code != UNREAD]


@pytest.mark.parametrize(
    ("text", "spec"),
    [
        ("map road()", LoneRoad()),
        ("map road(lanes=2, length=1 km, curve=-300 m)", LoneRoad(2, 1000.0, -300.0)),
        (
            "map road(curve=100 m, bend=90 deg, one_way=True)",
            LoneRoad(curve=100.0, bend=math.pi / 2, one_way=True),
        ),
    ],
)
def test_lone_roads(text: str, spec: LoneRoad) -> None:
    """The arguments are the fields of the specification, in SI."""
    assert compiled(f"{text}\n{EGO}").program.road_spec == spec


def test_roundabouts() -> None:
    """The arguments are the fields of the specification, in SI."""
    text = "map roundabout(arms=5, lanes=2, radius=40 m, corner_radius=9 m, approach=1 km, left_hand=True)\n"
    spec = Roundabout(5, 2, 40.0, 9.0, 1000.0, left_hand=True)
    assert compiled(text + EGO).program.road_spec == spec


@pytest.mark.parametrize("arm", range(1, 4))
def test_routes_through_a_roundabout(arm: int) -> None:
    """From the first arm to each other one: in, past the arms between, and out."""
    text = (
        "map roundabout()\n"
        "start = network.roads[0].forwardLanes.lanes[0]\n"
        f"way = start.routeTo(network.roads[{arm}].backwardLanes.lanes[0])\n"
        f"require len(way) == {3 + 2 * (4 - arm)} and way[0] is start and len(start.routeTo(start)) == 1\n" + EGO
    )
    assert set(codes(text)) == {ALWAYS_TRUE}


@pytest.mark.parametrize(
    ("route", "code"),
    [
        ("network.lanes[1].routeTo(network.lanes[0])", "SCN504"),
        ("network.lanes[0].routeTo(3)", "SCN303"),
        ("network.lanes[0].routeTo()", "SCN308"),
    ],
)
def test_routes_that_there_are_not(route: str, code: str) -> None:
    """A way that no road has, and an end that is no lane."""
    assert code in codes(f"map roundabout()\nego = new Car before network.intersections[0] by 5 m along {route}\n")


def test_what_a_lone_road_can_be_asked() -> None:
    """One road, its lanes and groups, and neither intersection nor maneuver."""
    text = (
        "map road(lanes=2, one_way=True)\n"
        "r = network.roads[0]\n"
        "require r.is1Way and (r.backwardLanes is None) and len(r.lanes) == 2 and len(network.laneGroups) == 1\n"
        "require len(network.intersections) == 0 and len(network.lanes[0].maneuvers) == 0\n"
        "require network.lanes[0].sections[0].fasterLane.lane is network.lanes[1]\n" + EGO
    )
    assert set(codes(text)) == {ALWAYS_TRUE}


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("map road(lanes=9)", "SCN411"),
        ("map road(curve=2 m)", "SCN411"),
        ("map road(bend=2 deg)", "SCN411"),
        ("map road(length=0/0)", "SCN401"),
        ("map road(rows=2)", "SCN205"),
        ("map road(500 m)", "SCN427"),
        ("map raod()", "SCN412"),
        ("map opendrive()", "SCN427"),
        ("map opendrive(3)", "SCN427"),
        ('map opendrive("a.xodr", "b.xodr")', "SCN427"),
        ('map opendrive("nowhere.xodr")', "SCN438"),
        ('map opendrive("overtaking.scn")', "SCN439"),
        ("map roundabout(arms=2)", "SCN411"),
        ("map roundabout(radius=9 m, lanes=2)", "SCN411"),
        ("map roundabout(radius=0/0)", "SCN401"),
        ("map roundabout(arms=4.5)", "SCN510"),
        ("map roundabout(ways=4)", "SCN205"),
        (VILLAGE + VILLAGE, "SCN413"),
        ("map road()\nrequire (distance from ego to intersection) < 5", "SCN448"),
    ],
)
def test_maps_that_are_wrong(text: str, code: str) -> None:
    """Each is answered by its code, and by no traceback."""
    found = codes(f"{text}\n{EGO}" if "require" not in text else text.replace("\n", f"\n{EGO}", 1) + "\n")
    assert code in found


def test_the_roads_of_a_file() -> None:
    """The native line reads it, as seen from the scenario; the specification keeps its digest."""
    spec = compiled(VILLAGE + EGO).program.road_spec
    assert isinstance(spec, MapFile)
    assert (spec.file, spec.path, len(spec.digest)) == ("village.xodr", str(ROADS / "village.xodr"), 32)


def test_scenic_files_read_their_map_where_it_is_there(tmp_path: Path) -> None:
    """Without a note; where it is not there, a grid takes its place, and a note says so; `map` comes before both."""
    text = "param map = localPath('village.xodr')\n" + EGO
    assert isinstance(compiled(text).program.road_spec, MapFile)
    assert codes(text) == []
    assert compiled(text, tmp_path).program.road_spec == RoadSpec()
    assert codes(text, tmp_path) == ["SCN442"]
    assert compiled(text.replace("\n", "\nmap road()\n", 1)).program.road_spec == LoneRoad()


def test_maps_are_found_in_the_folders_of_a_variable(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By their names, whatever folder a line says; a file where the line says comes first."""
    monkeypatch.setenv("CORTEXC_MAPS", f"{tmp_path}{os.pathsep}{ROADS}")
    for line in (VILLAGE, VILLAGE.replace('"v', '"../maps/v'), "param map = localPath('../../CARLA/village.xodr')\n"):
        spec = compiled(line + EGO, tmp_path).program.road_spec
        assert isinstance(spec, MapFile)
        assert Path(spec.path) == ROADS / "village.xodr"
    assert codes('map opendrive("../roads/")\n' + EGO, tmp_path) == ["SCN438"]


def test_a_broken_map_of_scenic_is_an_error(tmp_path: Path) -> None:
    """Nobody searches on another road than the one that lies there."""
    (tmp_path / "village.xodr").write_text("<OpenDRIVE>")
    assert codes("param map = localPath('village.xodr')\n" + EGO, tmp_path) == ["SCN439"]


@pytest.mark.parametrize(
    ("road", "cure"),
    [(VILLAGE, "a trajectory that starts earlier"), ("map intersection()\n", "a longer `approach` in `map`")],
)
@pytest.mark.parametrize(
    ("distance", "word"), [("200 m", "a shorter distance"), ("Range(5, 200) m", "narrow the range")]
)
def test_what_helps_where_a_way_is_too_short(road: str, cure: str, distance: str, word: str) -> None:
    """The roads of a file are as long as they are; those of a grid, as long as `map` says."""
    text = f"{road}lane = intersection.incomingLanes[0]\nego = new Car before intersection by {distance} along [lane]\n"
    try:
        found = compiled(text).diagnostics
    except CompileError as error:
        found = error.diagnostics
    (said,) = [each.cure for each in found if each.code in ("SCN421", "SCN445")]
    assert cure in said
    assert word in said


def test_what_is_odd_about_a_file_is_said_once(tmp_path: Path) -> None:
    """However many variants there are."""
    text = (
        (ROADS / "village.xodr")
        .read_text()
        .replace('elementType="road" elementId="', 'elementType="road" elementId="x', 1)
    )
    (tmp_path / "village.xodr").write_text(text)
    assert codes(VILLAGE + "lane = Uniform(*network.lanes)\nego = new Car in lane.centerline\n", tmp_path) == ["SCN449"]


def test_what_lies_at_a_point() -> None:
    """Scenic's `roadAt` and its like, of points and of objects whose lane is known; None where nothing is."""
    text = (
        "map intersection()\n"
        "lane = network.lanes[0]\n"
        "require network.roadAt((1.75 m, 30 m)) is network.roads[0] and network.roadAt(90 @ 90) is None\n"
        "require network.intersectionAt((0 m, 0 m)) is intersection and network.intersectionAt((1, 30)) is None\n"
        "require network.laneGroupAt(-1.75 @ 30).lanes[0] is lane\n"
        "ego = new Car in lane.centerline\n"
        "require network.roadAt(ego) is lane.road and len(network.laneGroupAt(ego).lanes) == 1\n"
        "require network.intersectionAt(ego) is None\n"
    )
    assert set(codes(text)) == {ALWAYS_TRUE}


@pytest.mark.parametrize("name", ["roadAt", "laneGroupAt", "intersectionAt"])
def test_what_lies_where_only_the_run_knows(name: str) -> None:
    """It cannot be listed then, and a lane is no place."""
    assert "SCN630" in codes(f"ego = new Car at (Range(0, 1) m, 30 m)\nrequire network.{name}(ego) is None\n")
    assert "SCN303" in codes(f"require network.{name}(network.lanes[0]) is None\n{EGO}")


def test_what_a_file_can_be_asked() -> None:
    """Scenic's names mean the same there."""
    text = VILLAGE + (
        "i = network.intersections[0]\n"
        "require i.is3Way and not i.is4Way and len(i.incomingLanes) == 3 and len(i.maneuvers) == 6\n"
        "require len(network.lanes) == 15 and len(network.roads) == 4\n"
        "climbing = filter(lambda l: l.sections[0]._laneToRight is not None, network.lanes)\n"
        "require len(climbing) == 1 and climbing[0].sections[0]._laneToLeft is not None\n"
        "turns = filter(lambda m: m.type is ManeuverType.LEFT_TURN, i.maneuvers)\n"
        "require len(turns) == 2 and len(turns[0].conflictingManeuvers) > 0\n" + EGO
    )
    assert set(codes(text)) == {ALWAYS_TRUE}


@pytest.mark.parametrize(
    ("line", "has"),
    [
        ("Uniform(*filter(lambda i: i.is4Way, network.intersections)).incomingLanes[0]", "3 roads (1)"),
        (
            "Uniform(*filter(lambda m: m.type is ManeuverType.U_TURN, network.intersections[0].maneuvers)).startLane",
            "LEFT_TURN (2), RIGHT_TURN (2), STRAIGHT (2)",
        ),
    ],
)
def test_a_map_without_what_is_asked_for_says_what_it_has(line: str, has: str) -> None:
    """No intersection of four roads is in the village, and no turn back."""
    text = f"{VILLAGE}lane = {line}\nego = new Car in lane.centerline\n"
    with pytest.raises(CompileError) as caught:
        compiled(text)
    (found,) = (each for each in caught.value.diagnostics if each.severity is Severity.ERROR)
    assert has in found.cure


def test_a_map_without_intersections_says_so(tmp_path: Path) -> None:
    """And not that a filter should be wider, which is the cure where it is the filter that leaves none."""
    (tmp_path / "plain.xodr").write_text(PLAIN, encoding="utf-8")
    text = (
        f'map opendrive("{tmp_path / "plain.xodr"}")\n'
        "i = Uniform(*filter(lambda i: i.is4Way, network.intersections))\n"
        "ego = new Car in i.incomingLanes[0].centerline\n"
    )
    with pytest.raises(CompileError) as caught:
        compiled(text)
    (found,) = caught.value.diagnostics
    assert found.cure == "choose another map: this one has no intersections"


def test_elements_of_a_map_have_names() -> None:
    """Those of Scenic: `road1`, `intersection10`; lanes have those of reports. A road is one section here."""
    ir = compiled(
        VILLAGE
        + """
road = network.elements["road1"]
assert road in network.roads
assert network.elements["intersection10"] is network.intersections[0]
assert network.elements["road1.lane0"] is road.lanes[0]
section = road.sections[0]
assert section.road is road
assert [each.lane for each in section.forwardLanes] == list(road.forwardLanes.lanes)
assert len(section.lanes) == len(section.forwardLanes) + len(section.backwardLanes)
ego = new Car in section.backwardLanes[0]
"""
    )
    assert len(ir.program.actors) == 1


PLAIN = """\
<?xml version="1.0"?>
<OpenDRIVE><header revMajor="1" revMinor="6"/>
<road name="" length="100" id="1" junction="-1">
<planView><geometry s="0" x="0" y="0" hdg="0" length="100"><line/></geometry></planView>
<lanes><laneSection s="0"><center><lane id="0" type="none" level="false"/></center>
<right><lane id="-1" type="driving" level="false"><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane></right>
</laneSection></lanes></road>
</OpenDRIVE>
"""
