"""Mistakes of scenarios from other tools: each is reported with a place and a cure."""

from pathlib import Path

import pytest

from engine.interchange import InterchangeError
from engine.interchange.openscenario.read import read_openscenario
from engine.xml import Limits
from tests.engine.interchange.openscenario.read.files import (
    ROAD,
    STRAIGHT,
    TIMING,
    XODR,
    event,
    follow,
    polyline,
    refused,
    scenario,
    simple,
    speed,
    teleport,
    vehicle,
    world,
)

LANE = '<Position><LanePosition roadId="{}" laneId="{}" s="{}"/></Position>'
EGO = vehicle("Ego")


def on_lane(road: str, lane: int, s: float) -> str:
    return scenario([EGO], [("Ego", teleport(LANE.format(road, lane, s)) + follow(STRAIGHT))], network=ROAD)


@pytest.mark.parametrize(
    ("shape", "said"),
    [
        (polyline(), "no vertex"),
        (polyline((0.0, world(0)), (None, world(1))), "no time"),
        (polyline((0.0, world(0)), (0.2, world(1)), (0.1, world(2))), "0.1 s after 0.2 s"),
        (polyline((0.0, world(0)), (0.1, world(1)), (0.1, world(2))), "0.1 s after 0.1 s"),
        (polyline((0.0, world(0)), (1e-300, world(1))), "must ascend"),
        (polyline((0.0, world(0)), (0.1, world(0))), "no direction"),
        (polyline((0.0, "")), "no <Position>"),
        (polyline((0.0, "<Position/>")), "is empty"),
        (polyline((0.0, "<Position><GeoPosition/></Position>")), "<GeoPosition> is not read"),
        (polyline((0.0, '<Position><WorldPosition y="1"/></Position>')), "lacks the attribute `x`"),
        (polyline((0.0, '<Position><WorldPosition x="NaN" y="1"/></Position>')), "not a number"),
        (polyline((0.0, '<Position><WorldPosition x="INF" y="1"/></Position>')), "not a number"),
        (polyline((0.0, '<Position><WorldPosition x="1_0" y="1"/></Position>')), "not a number"),
        (polyline((0.0, '<Position><WorldPosition x="1e300" y="1"/></Position>')), "cannot be"),
        (polyline((0.0, world(0, 0, 1e9))), "cannot be"),
        ("<Clothoid/>", "is a <Clothoid>"),
        ("<Nurbs/>", "is a <Nurbs>"),
        ("", "no shape"),
    ],
)
def test_polylines_without_sense_are_refused(tmp_path: Path, shape: str, said: str) -> None:
    """No vertices, no times, times that do not ascend, positions that are none."""
    assert said in refused(tmp_path, simple(shape)).message


def test_one_vertex_is_a_place(tmp_path: Path) -> None:
    """It needs no direction; a single sample is a recording of one instant."""
    (tmp_path / "case.xosc").write_text(simple(polyline((0.0, world(3.0)))))
    recording = read_openscenario(tmp_path / "case.xosc").recording
    assert recording.time.tolist() == [0.0]
    assert recording.states[0, 0, :3].tolist() == [4.5, 0.0, 0.0]


@pytest.mark.parametrize(
    ("timing", "said"),
    [
        ("<None/>", "has no times"),
        ("", "has no times"),
        (TIMING.replace("absolute", "sometime"), "no time domain `sometime`"),
        (TIMING.replace('scale="1"', 'scale="0"'), "scaled by 0"),
        (TIMING.replace('scale="1"', 'scale="-1"'), "cannot be"),
        (TIMING.replace('scale="1"', ""), "lacks the attribute `scale`"),
    ],
)
def test_timings_without_sense_are_refused(tmp_path: Path, timing: str, said: str) -> None:
    """Above all trajectories without times, which a simulator would drive at a speed of its own."""
    assert said in refused(tmp_path, simple(timing=timing)).message


@pytest.mark.parametrize(
    ("text", "said", "cure"),
    [
        (on_lane("2", -1, 5.0), "no road `2`", "`1`"),
        (on_lane("1", -7, 5.0), "no lane -7", "lanes -2, -1, 1"),
        (on_lane("1", -1, 500.0), "beyond the end", "0 to 100 m"),
        (on_lane("1", -1, 5.0).replace(ROAD, "<RoadNetwork/>"), "needs the road", "LogicFile"),
    ],
)
def test_unknown_places_on_the_road_are_reported_with_what_exists(
    tmp_path: Path, text: str, said: str, cure: str
) -> None:
    """At the line of the position that asks."""
    error = refused(tmp_path, text, XODR)
    assert said in error.message
    assert cure in error.cure
    assert error.place.startswith("case.xosc, line ")


def test_a_missing_road_file_is_reported(tmp_path: Path) -> None:
    """With one beside that may be meant; a web address is not fetched."""
    (tmp_path / "roads.xodr").write_text(XODR)
    error = refused(tmp_path, simple(network=ROAD))
    assert '"road.xodr" is not there' in error.message
    assert "`roads.xodr`" in error.cure
    elsewhere = simple(network=ROAD.replace("road.xodr", "https://example.com/road.xodr"))
    assert "nothing is fetched" in refused(tmp_path, elsewhere).message


def test_a_broken_road_is_reported_with_its_own_name(tmp_path: Path) -> None:
    """The place is in the road's file."""
    assert refused(tmp_path, simple(network=ROAD), "<OpenDRIVE").place == "road.xodr, line 1, column 1"
    assert "an OpenSCENARIO file" in refused(tmp_path, simple(network=ROAD), "<OpenSCENARIO/>").message


@pytest.mark.parametrize(
    ("entities", "said"),
    [
        ([], "no actor takes part"),
        ([EGO, EGO], "two take part as `Ego`"),
        ([EGO.replace('<Center x="1.5" y="0" z="0.7"/>', "")], "no <BoundingBox/Center>"),
        ([EGO.replace('length="4.5"', 'length="0"')], "cannot be"),
        ([EGO.replace('length="4.5"', 'length="-4"')], "cannot be"),
        ([EGO.replace('vehicleCategory="car"', 'vehicleCategory="cart"')], "no vehicle category `cart`"),
        ([EGO.replace(' vehicleCategory="car"', "")], "lacks the attribute `vehicleCategory`"),
        (['<ScenarioObject name="Ego"><ExternalObjectReference name="x"/></ScenarioObject>'], "not read here"),
        (['<ScenarioObject name="Ego"/>'], "`Ego` is nothing"),
        (["<ScenarioObject/>"], "lacks the attribute `name`"),
        (
            ['<ScenarioObject name="Ego"><CatalogReference catalogName="Cars" entryName="vw"/></ScenarioObject>'],
            'the catalog "Cars" is not beside',
        ),
        ([vehicle(f"v{i}") for i in range(1001)], "1,001 take part"),
        ([EGO, vehicle("other")], "nothing says where `other` is"),
    ],
)
def test_entities_without_sense_are_refused(tmp_path: Path, entities: list[str], said: str) -> None:
    """None, two of one name, without outline or kind, from a catalog that is not there, nowhere."""
    assert said in refused(tmp_path, scenario(entities, [("Ego", follow(STRAIGHT))])).message


WAITS = (
    '<ConditionGroup><Condition name="c" delay="0" conditionEdge="none"><ByEntityCondition><EntityCondition>'
    '<TimeHeadwayCondition value="1"/></EntityCondition></ByEntityCondition></Condition></ConditionGroup>'
)


@pytest.mark.parametrize(
    ("init", "events", "said"),
    [
        ([("ego", follow(STRAIGHT))], [], "no actor is called `ego`"),
        ([("Ego", teleport(world(0)))], [], "no actor follows a trajectory with times"),
        ([("Ego", teleport(world(0)))], [event("Ego", speed(5.0))], "moved by <SpeedAction>"),
        ([("Ego", teleport(world(0)))], [event("Ego", follow(STRAIGHT), WAITS)], "waits for <TimeHeadwayCondition>"),
        ([("Ego", teleport(world(0)))], [event("", follow(STRAIGHT))], "no actor is called ``"),
        ([("Ego", follow("").replace("<TrajectoryRef>", "").replace("</TrajectoryRef>", ""))], [], "no shape"),
        ([("Ego", speed(1e9) + follow(STRAIGHT))], [], "cannot be"),
        (
            [("Ego", teleport('<Position><RelativeObjectPosition entityRef="Ego" dx="1" dy="1"/></Position>'))],
            [],
            "where `Ego` is at 0 s is not known",
        ),
    ],
)
def test_storyboards_without_sense_are_refused(
    tmp_path: Path, init: list[tuple[str, str]], events: list[str], said: str
) -> None:
    """Unknown names, motion that only a simulator knows, triggers that depend on a run."""
    assert said in refused(tmp_path, scenario([EGO], init, events)).message


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('revMajor="1"', 'revMajor="0"', "OpenSCENARIO 0.2"),
        (' revMajor="1"', "", "lacks the attribute `revMajor`"),
        ("<Entities>", '<Catalog name="c"/><Entities>', "a catalog, not a scenario"),
        ("Storyboard>", "Storybook>", "no <Storyboard>"),
        ("Entities>", "Entity>", "no <Entities>"),
        ("OpenSCENARIO>", "OpenDRIVE>", "an OpenDRIVE road"),
    ],
)
def test_other_kinds_of_files_are_reported(tmp_path: Path, old: str, new: str, said: str) -> None:
    """Old versions, catalogs, and files with parts missing."""
    text = simple()
    assert text.replace(old, new) != text
    assert said in refused(tmp_path, text.replace(old, new)).message


def test_options_without_sense_are_refused(tmp_path: Path) -> None:
    """An ego that is not there, a step that is none."""
    assert "did you mean `Ego`" in refused(tmp_path, simple(), ego="Egon").cure
    for step in (0.0, -1.0, 1e-9, float("nan"), float("inf")):
        with pytest.raises(InterchangeError, match="a step of"):
            read_openscenario(tmp_path / "case.xosc", step=step)


def test_more_samples_than_memory_holds_are_refused(tmp_path: Path) -> None:
    """A vertex a year later, or a tiny step, is refused before it costs memory."""
    way = polyline((0.0, world(0)), (1e8, world(1)))
    assert "more than is read at once" in refused(tmp_path, simple(way)).message
    late = polyline((0.0, world(0)), (1000.0, world(1)))
    assert "more than is read at once" in refused(tmp_path, simple(late), step=1e-4).message


def test_limits_hold_for_the_road_too(tmp_path: Path) -> None:
    """A huge road beside a small scenario is refused at the limit."""
    error = refused(tmp_path, simple(network=ROAD), XODR + " " * 200_000, limits=Limits(megabytes=0.1))
    assert "larger than 0.1 MB" in error.message
    assert error.place.startswith("road.xodr")
