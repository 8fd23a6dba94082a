"""Lanes of OpenDRIVE lie where the standard says, and questions about what is not there are answered."""

import math
import re
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

from engine.interchange import InterchangeError
from engine.interchange.opendrive import road_map, write_opendrive
from engine.maps import RoadSpec
from engine.opendrive.read import read_opendrive
from engine.road import build_network
from tests.engine.interchange.opendrive.reading_back import specs
from tests.engine.interchange.openscenario.read.files import XODR, network
from tests.laws import examples

NEGATIVE = 'id="-1" type="driving"><width sOffset="0" a="-3"'
LHT = XODR.replace('junction="-1"', 'junction="-1" rule="LHT"')


BUILT = """<objects>
 <object id="1" type="building" s="20" t="8" hdg="0.3" length="10" width="6"/>
 <object id="2" type="building" s="20" t="-9" length="10" width="6" zOffset="5" name="bridge"/>
 <object id="3" type="building" s="20" t="-9" radius="4" name="tower"/>
 <object id="4" type="building" s="60" t="9" length="8" width="6"><outline/></object>
 <object id="5" type="building" s="900" t="9" length="8" width="6"/>
 <object id="6" type="tree" s="30" t="5" length="1" width="1"/>
</objects></road>"""


def test_buildings_beside_a_road_are_walls(tmp_path: Path) -> None:
    """Those that are rectangles and stand on the ground; a remark names what is left out."""
    road = network(
        tmp_path, XODR.replace("</road>", BUILT).replace('hdg="0" length', 'hdg="1.5707963267948966" length')
    )
    assert road.buildings == pytest.approx(np.array([[-8.0, 20.0, math.pi / 2 + 0.3, 10.0, 6.0]]))
    assert [remark for remark in road.remarks if "building" in remark] == [
        "buildings that are not rectangles, or have no place, are left out: `tower` and 2 more"
    ]
    assert len(network(tmp_path, XODR).buildings) == 0


def test_buildings_of_ours_are_read_where_they_stand(tmp_path: Path) -> None:
    """All of them, to the last digits."""
    spec = RoadSpec(buildings=5.0)
    (tmp_path / "road.xodr").write_text(write_opendrive(spec, None, "road"))
    read, ours = read_opendrive(tmp_path / "road.xodr").buildings, build_network(spec).buildings
    order = [np.lexsort(rows[:, :2].round(3).T) for rows in (read, ours)]
    assert len(ours) == 4
    np.testing.assert_allclose(read[order[0]], ours[order[1]], rtol=0.0, atol=1e-9)


@pytest.mark.parametrize(
    ("lane", "offset", "y", "heading"),
    [(-1, 0.0, -1.5, 0.0), (-2, 0.0, -5.0, 0.0), (-2, 0.5, -4.5, 0.0), (1, 0.0, 1.5, math.pi), (0, 0.0, 0.0, 0.0)],
)
def test_lanes_are_counted_from_the_middle(tmp_path: Path, lane: int, offset: float, y: float, heading: float) -> None:
    """Negative ids lie to the right; offsets are to the left of the reference line, on both sides."""
    assert network(tmp_path, XODR).pose("1", lane, 20.0, offset) == pytest.approx((20.0, y, heading))


def test_traffic_keeps_to_the_side_that_the_rule_says(tmp_path: Path) -> None:
    """With left hand traffic lanes on the left run along the reference line."""
    lht = network(tmp_path, LHT)
    assert lht.pose("1", 1, 20.0).heading == 0.0
    assert lht.pose("1", -1, 20.0).heading == math.pi
    assert lht.summary() == "1 road, 0 junctions, 3 driving lanes, 100 m in all, left hand traffic"
    assert "right hand traffic" in network(tmp_path, XODR).summary()


def test_without_a_lane_t_is_measured_from_the_reference_line(tmp_path: Path) -> None:
    """Positive to the left, heading with the road."""
    assert network(tmp_path, XODR).pose("1", None, 30.0, 7.0) == pytest.approx((30.0, 7.0, 0.0))


def test_lane_offsets_widths_and_sections_change_along_the_road(tmp_path: Path) -> None:
    """Cubics count from where they begin; a section holds from its own s on."""
    text = XODR.replace(
        "<lanes>", '<lanes><laneOffset s="0" a="0" b="0" c="0" d="0"/><laneOffset s="50" a="1" b="0.02" c="0" d="0"/>'
    ).replace(
        '<right>\n   <lane id="-1" type="driving"><width sOffset="0" a="3" b="0" c="0" d="0"/>',
        '<right>\n   <lane id="-1" type="driving"><width sOffset="0" a="3" b="0" c="0" d="0"/>'
        '<width sOffset="20" a="3" b="0.1" c="0" d="0"/>',
    )
    road = network(tmp_path, text)
    assert road.pose("1", -1, 20.0).y == pytest.approx(-1.5)
    assert road.pose("1", -1, 40.0).y == pytest.approx(-2.5)
    assert road.pose("1", -2, 40.0).y == pytest.approx(-7.0)
    assert road.pose("1", -1, 60.0).y == pytest.approx(1.2 - 3.5)


def test_borders_stand_for_widths(tmp_path: Path) -> None:
    """A border is measured from the lane offset, on the lane's own side."""
    text = XODR.replace('<width sOffset="0" a="4"', '<border sOffset="0" a="-8"')
    assert network(tmp_path, text).pose("1", -2, 10.0).y == pytest.approx(-5.5)


@settings(examples(20), suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
@given(specs())
def test_our_own_roads_are_read_where_they_lie(tmp_path: Path, spec: RoadSpec) -> None:
    """Each lane of every road that we write runs along our path, heading with its traffic."""
    ours = road_map(spec)
    read = network(tmp_path, write_opendrive(spec, None, "road"))
    for lane in ours.network.lanes:
        for along in np.linspace(0.0, lane.length, 5).tolist():
            pose, place = ours.network.paths.pose(lane.path, along), ours.place(lane.id, along)
            found = read.pose(*place)
            assert (found.x, found.y) == pytest.approx((pose.x, pose.y), abs=1e-9)
            assert math.remainder(found.heading - pose.heading, math.tau) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("road", "lane", "s", "said", "cure"),
    [
        ("7", -1, 5.0, "no road `7`", "there is `1`"),
        ("1", -3, 5.0, "no lane -3", "lanes -2, -1, 1"),
        ("1", -1, 100.1, "beyond the end", "from 0 to 100 m"),
        ("1", None, -1.0, "before the beginning", "from 0 to 100 m"),
        ("1", 10**9, 5.0, "no lane 1000000000", "lanes"),
    ],
)
def test_what_is_not_there_is_reported_with_what_is(
    tmp_path: Path, road: str, lane: int | None, s: float, said: str, cure: str
) -> None:
    """Roads, lanes, and the ends of a road."""
    with pytest.raises(InterchangeError) as caught:
        network(tmp_path, XODR).pose(road, lane, s, place="case.xosc, line 3")
    assert said in caught.value.message
    assert cure in caught.value.cure
    assert caught.value.place == "case.xosc, line 3"


def test_a_rounded_end_is_still_the_end(tmp_path: Path) -> None:
    """Half a millimetre beyond is the end itself."""
    assert network(tmp_path, XODR).pose("1", -1, 100.0005).x == 100.0


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("<road ", '<road x="1" ', None),
        ('id="1" length="100"', 'length="100"', "lacks the attribute `id`"),
        ('length="100" junction', 'length="NaN" junction', "not a number"),
        ('<geometry s="0"', '<geometri s="0"', "not well-formed"),
        ("<planView>", "<planView/><planView2>", "not well-formed"),
        ('<lane id="-2"', '<lane id="-1"', "two lanes of one section"),
        ('<lane id="-2"', '<lane id="-999999"', "do not run on"),
        ('<lane id="-2"', '<lane id="x"', "not a whole number"),
        ("<line/>", "", "needs one curve"),
        ('a="4"', 'a="1e10"', "cannot be"),
        ('a="4"', 'a="wide"', "not a number"),
    ],
)
def test_broken_roads_are_reported_with_their_line(tmp_path: Path, old: str, new: str, said: str | None) -> None:
    """Missing, doubled and absurd parts of a road."""
    text = XODR.replace(old, new)
    assert text != XODR
    if said is None:
        assert network(tmp_path, text).roads
        return
    with pytest.raises(InterchangeError, match=said) as caught:
        network(tmp_path, text)
    assert caught.value.place.startswith("road.xodr, line ")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("<OpenDRIVE/>", "no road in it"),
        ('<OpenDRIVE><road id="1" length="1"/></OpenDRIVE>', "has no <planView>"),
        ('<OpenDRIVE><road id="1" length="1"><planView/></road></OpenDRIVE>', "no <geometry>"),
        (XODR.replace("</road>", "</road>" + XODR[XODR.index("<road") : XODR.index("</OpenDRIVE>")]), "two roads"),
    ],
)
def test_incomplete_networks_are_reported(tmp_path: Path, text: str, said: str) -> None:
    """No roads, roads without a line, two roads of one id."""
    with pytest.raises(InterchangeError, match=said):
        network(tmp_path, text)


def test_a_section_of_many_lanes_is_refused(tmp_path: Path) -> None:
    """Each place on it would count them all; the error says how many there may be."""
    row = '<lane id="{}" type="driving"><width sOffset="0" a="1" b="0" c="0" d="0"/></lane>'
    text = XODR.replace("<right>", "<right>" + "".join(row.format(-3 - i) for i in range(100)))
    with pytest.raises(InterchangeError, match="a section of 104 lanes") as caught:
        network(tmp_path, text)
    assert "at most 100" in caught.value.cure


def test_a_negative_width_is_nothing_and_reported(tmp_path: Path) -> None:
    """The lane beyond it lies where it would without."""
    read = network(tmp_path, XODR.replace('id="-1" type="driving"><width sOffset="0" a="3"', NEGATIVE))
    assert read.remarks == ("lane -1 of road `1` is -3 m wide, which is taken as 0 m",)
    assert read.pose("1", -2, 10.0).y == -2.0


def test_long_lists_of_a_road_cost_nothing_at_each_place(tmp_path: Path) -> None:
    """A place is found by halving, not by going through all pieces and widths."""
    starts = [i / 500 for i in range(50_000)]
    pieces = [f'<geometry s="{s}" x="{s}" y="0" hdg="0" length="0.002"><line/></geometry>' for s in starts]
    widths = [f'<width sOffset="{s}" a="3" b="0" c="0" d="0"/>' for s in starts]
    text = re.sub("<geometry.*?</geometry>", "".join(pieces), XODR)
    text = text.replace('<width sOffset="0" a="3" b="0" c="0" d="0"/>', "".join(widths))
    read = network(tmp_path, text)
    begin = time.process_time()
    assert {read.pose("1", -1, s).y for s in starts[:2000]} == {-1.5}
    assert time.process_time() - begin < 1.0
