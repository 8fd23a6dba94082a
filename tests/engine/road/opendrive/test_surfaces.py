"""What lanes cover, wherever they lie and however they are turned; and lanes of which there is no such thing."""

import math
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cortex_dsl.api.scenario import compile_text
from cortex_dsl.pipeline import compile_source
from cortex_dsl.source import Source
from engine.errors import InterchangeError
from engine.road.regions import triangle_areas
from engine.vocabulary import Column
from tests.engine.road.opendrive.files import EXAMPLES, graph, lane, moved, network, plan, road, section, written
from tests.laws import examples

TAPER = road("1", section([lane(1), lane(2, a=3.5, b=-0.035)], [lane(-1), lane(-2)]), length=100.0)
ARC = road("1", section([lane(1)], [lane(-1), lane(-2, a=0.0, b=0.05)]), length=70.0, place={"curvature": 0.02})
MAPS = {
    "taper": f"<OpenDRIVE>{TAPER}</OpenDRIVE>",
    "taper to nothing": f"<OpenDRIVE>{road('1', section(right=[lane(-1, a=3.0, b=-0.06)]))}</OpenDRIVE>",
    "arc": f"<OpenDRIVE>{ARC}</OpenDRIVE>",
    "village": (EXAMPLES / "village.xodr").read_text(),
    "on-ramp": (EXAMPLES / "on_ramp.xodr").read_text(),
}
poses = st.tuples(st.floats(-3000.0, 3000.0), st.floats(-3000.0, 3000.0), st.floats(-math.pi, math.pi))


@settings(examples(60), suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(name=st.sampled_from(sorted(MAPS)), pose=poses)
def test_no_surface_depends_on_where_a_road_lies(name: str, pose: tuple[float, float, float], tmp_path: Path) -> None:
    """Lanes and links stay; the area of a straight road stays to 1e-6, that of any to 0.1 %."""
    path = tmp_path / "here.xodr"
    path.write_text(MAPS[name])
    here = plan(path)
    path.write_text(moved(MAPS[name], *pose))
    there = plan(path)
    assert len(here.lanes) == len(there.lanes)
    assert graph(here.links) == graph(there.links)
    area, other = (float(triangle_areas(each.surface.triangles).sum()) for each in (here, there))
    assert other == pytest.approx(area, rel=1e-6 if "taper" in name else 1e-3)
    for one, two in zip(here.lanes, there.lanes, strict=True):
        same = float(triangle_areas(one.shape.triangles).sum())
        assert float(triangle_areas(two.shape.triangles).sum()) == pytest.approx(same, rel=1e-3)
    # what the lanes cover is no less than the widest of them, and no more than all together
    lanes = [float(triangle_areas(each.shape.triangles).sum()) for each in there.lanes]
    assert max(lanes) * 0.99 < other < sum(lanes) * 1.01 + 1.0


LOST = (-60.998669341058786, -123.55418389902934, -1.4003907527669615)
"""A pose in which a mitred `buffer(-GAP)` of GEOS 3.14 loses the whole taper."""


def test_cars_on_the_road_are_on_every_lane(tmp_path: Path) -> None:
    """Also of a road whose surface once vanished in its place, beside another one."""
    first = moved(TAPER, *LOST)
    path = written(tmp_path, first, road("2", section(right=[lane(-1)]), place={"x": 200.0}))
    scenario = compile_text(f'map opendrive("{path}")\nego = new Car on road\n')
    lanes = network(path)
    scenes = scenario.sample(60, seed=3)
    places = scenes.values[scenes.valid][:, [Column.X, Column.Y]].tolist()
    used = {each.id for x, y in places for each in lanes.lanes if lanes.regions.contains(each.region, x, y)}
    assert used == {each.id for each in lanes.lanes}


def tight(width: float) -> str:
    """Return a road in a bend of 8 m to the right, whose lane is so wide."""
    return road("1", section(right=[lane(-1, a=width)]), length=12.0, place={"curvature": -0.125})


def test_a_lane_beyond_the_middle_of_its_curve_is_left_out(tmp_path: Path) -> None:
    """Up to twice the radius its middle runs on; then it runs backwards. Other roads stay."""
    for width, lanes in ((3.5, 2), (15.0, 2), (17.0, 1), (25.0, 1)):
        found = network(written(tmp_path, tight(width), road("2", section(right=[lane(-1)]), place={"x": 100.0})))
        assert len(found.lanes) == lanes
        left_out = "lane -1 of road `1` is left out: its middle has no length, or runs backwards"
        assert [each.startswith(left_out) for each in found.remarks] == [True] * (2 - lanes)


@pytest.mark.parametrize("length", ["0", "1e-9"])
def test_a_road_of_no_length_is_left_out(length: str, tmp_path: Path) -> None:
    short = road("1", section(right=[lane(-1)])).replace('length="50.0"', f'length="{length}"')
    both = written(tmp_path, short, road("2", section(right=[lane(-1)]), place={"x": 100.0}))
    assert network(both).remarks == ("road `1` has no length: it is left out",)
    with pytest.raises(InterchangeError, match="no lane to drive on"):
        network(written(tmp_path, short))


def test_a_road_ends_where_its_reference_line_ends(tmp_path: Path) -> None:
    longer = road("1", section(right=[lane(-1)])).replace('length="50.0"', 'length="1e8"', 1)
    found = network(written(tmp_path, longer))
    assert found.lanes[0].length == pytest.approx(50.0)
    assert found.remarks == ("road `1` is 1e+08 m long by its file, and its reference line 50 m, where it ends",)


def test_a_hole_in_a_reference_line_is_driven_over_and_named(tmp_path: Path) -> None:
    pieces = road("1", section(right=[lane(-1)])).replace(
        'length="50.0"><line/></geometry>',
        'length="20.0"><line/></geometry><geometry s="30" x="30" y="0" hdg="0" length="20"><line/></geometry>',
    )
    found = network(written(tmp_path, pieces))
    assert found.regions.area(0) == pytest.approx(50.0 * 3.5, rel=1e-3)
    assert found.lanes[0].length == pytest.approx(50.0)
    assert found.remarks == ("the reference line of road `1` is broken, by up to 10 m",)


LOW, HIGH = (road(name, section(right=[lane(-1)]), length=100.0, place=place) for name, place in (
    ("1", {"x": -50.0}), ("2", {"y": -50.0, "hdg": math.pi / 2.0, "height": 8.0})
))  # fmt: skip


@pytest.mark.parametrize(
    ("first", "second", "codes"),
    [
        (LOW, HIGH, {"SCN459"}),
        (LOW, HIGH.replace('a="8.0"', 'a="2.4"'), {"SCN449"}),
        (LOW, HIGH.replace('a="8.0"', 'a="0.5"'), set()),
        (LOW, HIGH.replace('b="0"', 'b="0.0001"', 1), {"SCN459", "SCN466"}),
        (LOW, HIGH.replace('a="8.0"', 'a="0"'), set()),
        (LOW, HIGH.replace('x="0.0"', 'x="80.0"'), set()),
    ],
)
def test_roads_that_pass_over_one_another_are_named(first: str, second: str, codes: set[str], tmp_path: Path) -> None:
    """A note says where, and what levels mean; heights that do not matter get none."""
    path = written(tmp_path, first, second)
    text = f'map opendrive("{path}")\nego = new Car on network.lanes[0]\n'
    found = {each.code: each for each in compile_source(Source("levels.scn", text)).diagnostics}
    assert found.keys() == codes
    if "SCN459" in codes:
        assert "road `2` passes 8.0 m above road `1` near (1.8, -1.8)" in found["SCN459"].message
        assert "2.5 m or more apart" in found["SCN459"].reason


def test_a_section_beyond_the_end_of_its_road_is_named(tmp_path: Path) -> None:
    found = network(written(tmp_path, road("1", section(right=[lane(-1)]) + section(right=[lane(-1)], s=120.0))))
    assert found.lanes[0].length == pytest.approx(50.0)
    where = "begins at s = 120 m, beyond the end of the road at 50 m"
    assert found.remarks == (f"a section of road `1` {where}: it is left out",)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("<laneSection ", '<laneSection singleSide="maybe" ', 'singleSide="maybe" has no meaning'),
        ("<road ", '<road rule="middle" ', 'rule="middle" has no meaning'),
        ("</OpenDRIVE>", '<junction id="7"/><junction id="7"/></OpenDRIVE>', "two junctions have the id `7`"),
    ],
)
def test_what_cannot_be_meant_is_refused(old: str, new: str, said: str, tmp_path: Path) -> None:
    """With its place and a cure; both words of a truth value, and none, are read."""
    path = written(tmp_path, road("1", section(right=[lane(-1)])))
    text = path.read_text()
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(InterchangeError, match=said) as caught:
        network(path)
    assert caught.value.cure
    assert "line" in caught.value.place
    for word in ("", "false", "0", " False "):
        path.write_text(text.replace("<laneSection ", f'<laneSection singleSide="{word}" '))
        assert len(network(path).lanes) == 1


@pytest.mark.parametrize(("link", "road_id"), [('from="-9" to="-1"', "1"), ('from="-1" to="-9"', "2")])
def test_lane_links_of_lanes_that_are_not_there_are_named(link: str, road_id: str, tmp_path: Path) -> None:
    both = [road(name, section(right=[lane(-1)]), place={"x": x}) for name, x in (("1", 0.0), ("2", 50.0))]
    connection = (
        f'<connection id="0" incomingRoad="1" connectingRoad="2" contactPoint="start"><laneLink {link}/></connection>'
    )
    found = network(written(tmp_path, *both, f'<junction id="7">{connection}</junction>'))
    said = f"a connection of junction `7` names lane -9 of road `{road_id}`, which has no such lane"
    assert [remark for remark in found.remarks if remark.startswith(said)]
