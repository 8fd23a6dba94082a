"""Networks of OpenDRIVE files: our own roads come back as they were written, an own file with spirals and a lane that
opens, files that are wrong, and, where `CORTEXC_MAPS` names a folder of them, the towns of CARLA.
"""

import math
import os
import re
from itertools import pairwise, permutations
from pathlib import Path

import numpy as np
import pytest
import shapely
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cortex_dsl.pipeline import compile_source
from cortex_dsl.source import Source
from engine.errors import InterchangeError
from engine.interchange.opendrive import write_opendrive
from engine.maps import LoneRoad, MapSpec, Roundabout, map_content, map_from
from engine.opendrive.curves import Pose, clothoid
from engine.road import Lane, LaneRole, Network, build_network
from engine.road.opendrive.fitting import TOLERANCE, biarc
from engine.road.opendrive.network import map_file
from engine.road.opendrive.surfaces import PRECISION, rounded, union
from engine.road.outline import near, outline
from engine.road.paths import PathBook
from engine.road.regions import triangle_areas
from engine.road.sections import faster, group_of, road_of, to_left, to_right
from engine.vocabulary import ManeuverType
from tests.engine.interchange.opendrive.reading_back import specs
from tests.laws import examples

VILLAGE = Path(__file__).parents[4] / "examples" / "roads" / "village.xodr"
TOWNS = {"Town01": (124, 12, 72), "Town04": (454, 27, 257), "Town10HD": (168, 9, 82)}


def read(path: Path) -> Network:
    return build_network(map_file(path, path.name))


def reread(spec: MapSpec, folder: Path) -> Network:
    path = folder / "road.xodr"
    path.write_text(write_opendrive(spec, None, "road"))
    return read(path)


def nearest(network: Network, x: float, y: float, heading: float) -> Lane:
    """The lane whose middle is there."""

    def off(lane: Lane) -> float:
        pose = network.paths.pose(lane.path, 0.5 * lane.length)
        return math.hypot(pose.x - x, pose.y - y) + abs(math.remainder(pose.heading - heading, math.tau))

    return min(network.lanes, key=off)


limits = {"speed_limit": st.sampled_from([None, 50.0 / 3.6])}
lone = st.builds(LoneRoad, st.integers(1, 3), st.just(150.0), st.sampled_from([None, 90.0, -300.0]), **limits)
round_ones = st.builds(
    Roundabout, st.integers(3, 5), st.integers(1, 2), st.just(30.0), left_hand=st.booleans(), **limits
)


@settings(examples(15), suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(spec=specs() | lone | round_ones)
def test_our_own_roads_come_back(spec: MapSpec, tmp_path: Path) -> None:
    """The same lanes where they lay, with the same neighbours, ways on and conflicts."""
    ours, theirs = build_network(spec), reread(spec, tmp_path)
    assert len(theirs.lanes) == len(ours.lanes)
    assert len(theirs.intersections) == len(ours.intersections)
    same: dict[int, Lane] = {}
    for lane in ours.lanes:
        pose = ours.paths.pose(lane.path, 0.5 * lane.length)
        same[lane.id] = found = nearest(theirs, *pose)
        for share in (0.0, 0.3, 1.0):
            mine, other = (n.paths.pose(x.path, share * x.length) for n, x in ((ours, lane), (theirs, found)))
            assert (mine.x, mine.y) == pytest.approx((other.x, other.y), abs=1e-5)
        assert found.width == pytest.approx(lane.width)
        assert found.speed_limit == lane.speed_limit
        assert theirs.regions.area(found.region) == pytest.approx(ours.regions.area(lane.region), rel=2e-2)
    assert len({lane.id for lane in same.values()}) == len(ours.lanes)
    for lane in ours.lanes:
        assert {same[each.id].id for each in lane.successors} == {each.id for each in same[lane.id].successors}
        if lane.role is not LaneRole.CONNECTING:
            for beside in (to_left, to_right, faster):
                mine, other = beside(lane), beside(same[lane.id])
                assert (None if mine is None else same[mine.id]) is other
    key = {(same[m.start].id, same[m.end].id): m for m in ours.maneuvers}
    assert len(theirs.maneuvers) == len(ours.maneuvers)
    for maneuver in theirs.maneuvers:
        mine = key[maneuver.start, maneuver.end]
        assert maneuver.type is mine.type
        expected = {(same[m.start].id, same[m.end].id) for m in mine.conflicting_maneuvers}
        assert {(m.start, m.end) for m in maneuver.conflicting_maneuvers} == expected
    # A junction is what its lanes cover, which leaves out what lies between them.
    assert 0.75 * ours.regions.area(0) < theirs.regions.area(0) < 1.005 * ours.regions.area(0)


@pytest.fixture(scope="module")
def village() -> Network:
    return read(VILLAGE)


def test_village_has_what_it_should(village: Network) -> None:
    """One junction of three roads, and a road beyond one of them that gains a lane."""
    assert (len(village.lanes), len(village.intersections), len(village.maneuvers)) == (15, 1, 6)
    assert village.intersections[0].is_3way
    kinds = sorted(maneuver.type.name for maneuver in village.maneuvers)
    assert kinds == ["LEFT_TURN"] * 2 + ["RIGHT_TURN"] * 2 + ["STRAIGHT"] * 2
    assert [len(road.groups) for road in village.roads] == [2, 2, 2, 2]
    climb = village.road_named["road100"]
    kerb, through = climb.forward.lanes
    assert (kerb.number, through.number) == (1, 2)
    assert to_right(through) is kerb
    assert to_left(through) is climb.backward.lanes[0]
    assert to_left(climb.backward.lanes[0]) is through
    assert group_of(kerb) is climb.forward
    assert road_of(kerb) is climb
    assert village.remarks == ()


def test_drivers_without_a_plan_drive_on(village: Network) -> None:
    """Down the hill, through the junction and out of the village."""
    lane = village.road_named["road100"].backward.lanes[0]
    parts = village.paths.parts(lane.default_route)
    assert [next(each.name for each in village.lanes if each.path == part) for part in parts] == [
        "road100.lane2",
        "road2.lane0",
        "road7.lane0",
        "road1.lane1",
    ]
    assert all(village.paths.continues(one, other) for one, other in pairwise(parts))


def test_centre_lines_follow_the_file(village: Network) -> None:
    """A lane beside spirals and an arc leaves its true place by no more than the tolerance, without corners."""
    lane = village.road_named["road100"].forward.lanes[1]
    start = clothoid(40.0, 0.0, 0.02 / 40.0)
    entry = village.road_named["road2"].backward.lanes[0]
    end = village.paths.pose(entry.path, entry.length)
    x, y = end.x - 1.75 * math.sin(end.heading), end.y + 1.75 * math.cos(end.heading)  # the reference line
    for s in np.linspace(0.0, 40.0, 33):
        there = Pose(x, y, end.heading).moved(*clothoid(float(s), 0.0, 0.02 / 40.0))
        place = there.moved(0.0, -1.75)
        assert village.paths.distance(lane.path, place.x, place.y) <= TOLERANCE + 1e-6
    assert start.heading == pytest.approx(0.4)
    for one, other in pairwise(village.paths.primitives(lane.path)):
        meeting = one.pose(one.length)
        assert math.hypot(meeting.x - other.x, meeting.y - other.y) < 1e-3
        assert abs(math.remainder(meeting.heading - other.heading, math.tau)) < 1e-3


def test_surfaces_hold_the_lanes(village: Network) -> None:
    """Points of all lanes lie on the road, those inside the junction in its area; the outlines are drawn."""
    (junction,) = village.intersections
    for lane in village.lanes:
        for share in (0.05, 0.5, 0.95):
            x, y, _ = village.paths.pose(lane.path, share * lane.length)
            assert village.regions.contains(0, x, y)
            assert village.regions.contains(lane.region, x, y)
            assert village.regions.contains(junction.region, x, y) == (lane.role is LaneRole.CONNECTING)
    drawn = outline(village)
    assert drawn.kerbs
    assert len(drawn.stop_lines) == 3
    assert len(drawn.widths) == len(village.lanes)


def test_nobody_stops_where_no_other_way_meets_theirs() -> None:
    """On the motorway of the on-ramp all lead into lanes of their own."""
    network = build_network(map_file(VILLAGE.with_name("on_ramp.xodr"), "on_ramp.xodr"))
    assert sum(bool(lane.maneuvers) for lane in network.lanes) == 3
    assert outline(network).stop_lines == ()


def test_a_lane_that_ends_in_a_taper_is_drawn_as_wide_as_it_is() -> None:
    """The acceleration lane of the on-ramp narrows to nothing: its area is drawn, and no strip of its mean width."""
    network = build_network(map_file(VILLAGE.with_name("on_ramp.xodr"), "on_ramp.xodr"))
    drawn = outline(network)
    (area,) = drawn.areas
    (narrowing,) = (lane for lane, width in zip(network.lanes, drawn.widths, strict=True) if not width)
    left, right = network.bounds[narrowing.id]
    assert np.hypot(*(left - right).T).min() < 0.01
    assert {tuple(point) for point in area.tolist()} == {tuple(point) for point in np.vstack([left, right]).tolist()}


@pytest.mark.parametrize("reach", [5.0, 30.0, 1000.0])
def test_what_is_near_is_drawn_whole(village: Network, reach: float) -> None:
    """Every point of a line that lies there is still drawn, and no line that does not come there."""
    drawn, middle = outline(village), np.array([village.intersections[0].center])
    part = near(drawn, middle, reach)
    for name in ("kerbs", "middle_lines", "lane_lines", "stop_lines", "center_lines"):
        whole, kept = (np.vstack([*getattr(each, name), np.zeros((0, 2))]) for each in (drawn, part))
        inside = whole[np.all(np.abs(whole - middle) <= reach, axis=1)]
        assert {tuple(point) for point in inside.tolist()} <= {tuple(point) for point in kept.tolist()}
        assert len(kept) <= len(whole) + len(getattr(part, name))
    assert len(part.center_lines) == len(part.widths)
    assert (len(part.center_lines) == len(drawn.center_lines)) is (reach > 500.0)
    assert all(np.abs(line - middle).min(axis=0).max() < 200.0 for line in part.kerbs)


def test_another_file_is_another_road(tmp_path: Path) -> None:
    """A specification keeps the digest of the file; it survives JSON."""
    path = tmp_path / "here.xodr"
    path.write_bytes(VILLAGE.read_bytes())
    spec = map_file(path, "here.xodr")
    assert map_from(map_content(spec)) == spec
    assert spec.intersections == 1
    path.write_bytes(VILLAGE.read_bytes() + b"<!-- -->")
    with pytest.raises(InterchangeError, match="has changed"):
        build_network(spec)
    path.unlink()
    with pytest.raises(InterchangeError, match="is not there"):
        build_network(spec)


BOMB = """<?xml version="1.0"?>
<!DOCTYPE x [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">]><OpenDRIVE>&b;</OpenDRIVE>"""
PLAN = '<planView><geometry s="0" x="0" y="0" hdg="0" length="9"><line/></geometry></planView>'
LANES = '<lanes><laneSection s="0"><right><lane id="-1" type="{}"><width sOffset="0" a="3" b="0" c="0" d="0"/></lane>'
ROAD = '<road id="1" length="9" junction="-1">{link}' + PLAN + LANES + "</right></laneSection></lanes></road>"
DRIVEN = ROAD.replace("{}", "driving")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<OpenDRIVE><road", "XML"),
        (BOMB, "entit"),
        ("<OpenDRIVE/>", "no road"),
        ("<OpenDRIVE>" + ROAD.replace("{}", "sidewalk").format(link="") + "</OpenDRIVE>", "no lane to drive on"),
        ("<OpenDRIVE>" + DRIVEN.format(link="").replace('a="3"', 'a="1e9"') + "</OpenDRIVE>", r"1e\+09 m wide"),
    ],
)
def test_bad_files(text: str, message: str, tmp_path: Path) -> None:
    """They are refused with a reason and a cure."""
    path = tmp_path / "bad.xodr"
    path.write_text(text)
    with pytest.raises(InterchangeError, match=message) as caught:
        read(path)
    assert caught.value.cure


@pytest.mark.parametrize(
    "link",
    [
        '<link><successor elementType="road" elementId="77" contactPoint="start"/></link>',
        '<link><successor elementType="junction" elementId="8"/></link>',
        '<link><successor elementType="road" elementId="1" contactPoint="start"/></link>',
    ],
)
def test_links_to_nowhere_end_the_road(link: str, tmp_path: Path) -> None:
    """A lane that leads nowhere is a lane that ends."""
    path = tmp_path / "odd.xodr"
    path.write_text("<OpenDRIVE>" + DRIVEN.format(link=link) + "</OpenDRIVE>")
    network = read(path)
    assert [lane.successors for lane in network.lanes] == [()]
    assert network.lanes[0].role is LaneRole.THROUGH
    assert ["leads to something that does not exist" in each for each in network.remarks] == (
        [] if '"1"' in link else [True]
    )


def test_gaps_and_junctions_of_roads_that_are_not_there_are_told(tmp_path: Path) -> None:
    """And the map is read as far as it goes."""
    path = tmp_path / "odd.xodr"
    piece = '<geometry s="{}" x="{}" y="0" hdg="0" length="4.5"><line/></geometry>'
    plan = f"<planView>{piece.format(0, 0)}{piece.format(4.5, 4.6)}</planView>"
    junction = '<junction id="5"><connection id="0" incomingRoad="1" connectingRoad="42"/></junction>'
    path.write_text("<OpenDRIVE>" + DRIVEN.format(link="").replace(PLAN, plan) + junction + "</OpenDRIVE>")
    gap, lost = read(path).remarks
    assert gap == "the reference line of road `1` is broken, by up to 0.1 m"
    assert lost == "junction `5` joins roads that do not exist: these connections are not used"


def test_a_surface_whose_outline_meets_itself() -> None:
    """That of esmini's `lane_offset_intersection.xodr` does, and was a bug of ours (70)."""
    crossed = shapely.Polygon([(0.0, 0.0), (4.0, 4.0), (4.0, 0.0), (0.0, 4.0)])
    with pytest.raises(shapely.errors.GEOSException):
        shapely.set_precision(crossed, PRECISION)
    assert rounded(crossed).area == pytest.approx(8.0)


def test_surfaces_that_lie_apart_stand_in_the_order_of_their_places() -> None:
    """Each is made by itself, whatever the order of the roads; those that overlap are one."""
    square = np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)])
    squares = [shapely.Polygon(square + np.array([x, 0.0])) for x in (30.0, 0.0, 60.0, 62.0)]
    shape, lines = union(squares)
    assert [float(line[:, 0].min()) for line in lines] == [0.0, 30.0, 60.0]
    assert triangle_areas(shape.triangles).sum() == pytest.approx(16.0 + 16.0 + 24.0)
    for other in permutations(squares):
        assert np.array_equal(union(other)[0].edges, shape.edges)


def again(text: str, dx: float) -> str:
    """Roads and junctions of a file under other ids, moved aside."""
    moved = re.sub(r' x="([^"]*)"', lambda found: f' x="{float(found[1]) + dx}"', text)
    keys = "road id|elementId|junction|junction id|incomingRoad|connectingRoad"
    return re.sub(rf'\b({keys})="(\d+)"', lambda found: f'{found[1]}="{1000 + int(found[2])}"', moved)


@pytest.mark.parametrize(("dx", "said"), [(0.0, 245), (4.0, 185), (200.0, None)])
def test_junctions_in_one_another_are_told(dx: float, said: int | None, tmp_path: Path) -> None:
    text, path = VILLAGE.read_text(), tmp_path / "two.xodr"
    more = again(text, dx)
    path.write_text(text.replace("</OpenDRIVE>", more[more.index("<road ") :]))
    network = read(path)
    assert (len(network.intersections), len(network.maneuvers)) == (2, 12)
    common = [f"junctions `10` and `1010` have {said} m^2 in common: who is in one gives no way to those in the other"]
    assert list(network.remarks) == (common if said else [])


@pytest.mark.parametrize(
    ("which", "remark"),
    [
        (1, "traffic keeps left only on 1 of 10 roads, such as `1`"),
        (-1, "no lane leads through junction `10`: its links do not fit its roads"),
    ],
)
def test_traffic_that_keeps_left_where_the_links_say_otherwise(which: int, remark: str, tmp_path: Path) -> None:
    path = tmp_path / "odd.xodr"
    path.write_text(VILLAGE.read_text().replace('rule="RHT"', 'rule="LHT"', which))
    loose, said = read(path).remarks
    assert said == remark
    assert "and no link joins them" in loose


def test_a_lane_of_no_width(tmp_path: Path) -> None:
    """Beside others it is a thread that can be followed; alone it is no road."""
    path = tmp_path / "thin.xodr"
    path.write_text("<OpenDRIVE>" + DRIVEN.format(link="").replace('a="3"', 'a="0"') + "</OpenDRIVE>")
    with pytest.raises(InterchangeError, match="has a width"):
        read(path)


def test_a_junction_of_no_width(tmp_path: Path) -> None:
    """Nobody goes through it, which is said beside all else that is odd; its roads are there."""
    path = tmp_path / "thin.xodr"
    path.write_text(VILLAGE.read_text().replace('a="3.5"', 'a="0"'))
    network = read(path)
    assert network.remarks[-2:] == (
        "a lane of road `1` and 3 more has no width: no vehicle fits into it",
        "no lane of junction `10` has a width: it is not used",
    )
    assert (len(network.intersections), len(network.maneuvers)) == (0, 0)
    found = compile_source(Source("thin.scn", f'map opendrive("{path}")\nego = new Car on road\n')).diagnostics
    assert len(network.remarks) > 1
    assert all(any(remark in each.message for each in found) for remark in network.remarks)


@pytest.mark.parametrize(
    ("road", "lane", "limit"),
    [
        ("", "", None),
        ('<type s="0" type="town"><speed max="55" unit="mph"/></type>', "", 55 * 0.44704),
        ('<type s="0" type="town"><speed max="50" unit="km/h"/></type>', "", 50 / 3.6),
        ('<type s="0" type="town"><speed max="13"/></type><type s="8" type="rural"/>', "", 13.0),
        ('<type s="0" type="town"><speed max="13"/></type>', '<speed sOffset="0" max="9"/>', 9.0),
        ('<type s="0" type="town"><speed max="no limit"/></type>', "", None),
        ('<type s="0" type="town"><speed max="-3"/></type>', '<speed sOffset="0" max="nan"/>', None),
        ('<type s="0" type="town"><speed max="3" unit="knots"/></type>', "", None),
        ('<type s="0" type="town"/>', '<speed sOffset="6" max="9"/>', None),
    ],
)
def test_speed_limits(road: str, lane: str, limit: float | None, tmp_path: Path) -> None:
    """A lane's own comes before its road's; in the middle of the lane; what is no speed says nothing."""
    path = tmp_path / "limits.xodr"
    text = DRIVEN.format(link=road).replace("</lane>", f"{lane}</lane>")
    path.write_text(f"<OpenDRIVE>{text}</OpenDRIVE>")
    assert read(path).lanes[0].speed_limit == (None if limit is None else pytest.approx(limit))


poses = st.builds(Pose, st.floats(-5.0, 5.0), st.floats(-5.0, 5.0), st.floats(-1.2, 1.2))


@given(poses, st.floats(20.0, 60.0))
def test_biarcs_lead_from_pose_to_pose(last: Pose, ahead: float) -> None:
    """Two arcs with one tangent, which begin and end as they should."""
    last = Pose(last.x + ahead, last.y, last.heading)
    chain = biarc(Pose(0.0, 0.0, 0.0), last)
    paths = PathBook()
    path = paths.add(chain)
    end = paths.pose(path, paths.length(path))
    assert (end.x, end.y) == pytest.approx((last.x, last.y), abs=1e-6)
    assert math.remainder(end.heading - last.heading, math.tau) == pytest.approx(0.0, abs=1e-6)
    if len(chain) == 2:
        meeting = chain[0].pose(chain[0].length)
        assert math.remainder(meeting.heading - chain[1].heading, math.tau) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.skipif("CORTEXC_MAPS" not in os.environ, reason="CORTEXC_MAPS names no folder of maps")
@pytest.mark.parametrize("town", TOWNS)
def test_towns_have_what_scenic_finds(town: str) -> None:
    """Lanes, intersections and maneuvers are as many as in Scenic's network."""
    path = Path(os.environ["CORTEXC_MAPS"]) / f"{town}.xodr"
    if not path.is_file():
        pytest.skip(f"{path.name} is not there")
    network = read(path)
    assert (len(network.lanes), len(network.intersections), len(network.maneuvers)) == TOWNS[town]
    assert all(m.type is not ManeuverType.U_TURN for m in network.maneuvers)
