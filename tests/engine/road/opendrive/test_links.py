"""How lanes of a file go on: a link that one side states holds for both, and none is lost without a note."""

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from engine.opendrive.read import read_opendrive
from engine.road.opendrive.linking import Links
from engine.road.opendrive.remarks import on_ends, on_links
from tests.engine.road.opendrive.corrupting import Corrupted, corruptions
from tests.engine.road.opendrive.files import EXAMPLES, graph, lane, link, network, plan, road, section, written
from tests.laws import examples

NEXT = link("successor", "2", "start"), link("predecessor", "1", "end")


def two_roads(first: str = NEXT[0], second: str = NEXT[1], links: tuple[bool, bool] = (True, True)) -> tuple[str, str]:
    """Return two roads of two lanes, one behind the other; `links`: whether the lanes of each are linked."""
    there, here = (1 if linked else None for linked in links)
    one = section([lane(1, after=there)], [lane(-1, after=there and -1)])
    other = section([lane(1, here)], [lane(-1, here and -1)])
    return road("1", one, first), road("2", other, second, place={"x": 50.0})


DIRECT = (
    '<junction id="5" type="direct"><connection id="0" incomingRoad="1" linkedRoad="2" contactPoint="start">'
    '<laneLink from="-1" to="-1"/><laneLink from="1" to="1"/></connection></junction>'
)
TO_JUNCTION = '<{} elementType="junction" elementId="5"/>'
COMPLETE = {
    "two roads": two_roads(),
    "direct junction": (*two_roads(TO_JUNCTION.format("successor"), TO_JUNCTION.format("predecessor")), DIRECT),
    "sections": (road("1", section(right=[lane(-1, after=-1)]) + section(right=[lane(-1, before=-1)], s=20.0)),),
    "village": ((EXAMPLES / "village.xodr").read_text(),),
    "on-ramp": ((EXAMPLES / "on_ramp.xodr").read_text(),),
}


def map_text(name: str) -> str:
    text = "".join(COMPLETE[name])
    return text if "<OpenDRIVE" in text else f"<OpenDRIVE>{text}</OpenDRIVE>"


def corrupted() -> st.SearchStrategy[tuple[str, Corrupted]]:
    return st.sampled_from([(name, each) for name in COMPLETE for each in corruptions(map_text(name))])


def judged(text: str, folder: Path) -> tuple[set[tuple[tuple[str, int], ...]], set[str]]:
    path = folder / "road.xodr"
    path.write_text(text)
    read = read_opendrive(path)
    links = Links(read)
    return graph(links), {*read.remarks, *on_links(read), *on_ends(links)}


def test_links_that_are_there_are_not_remarked(tmp_path: Path) -> None:
    for name in COMPLETE:
        edges, remarks = judged(map_text(name), tmp_path)
        assert not remarks
        assert bool(edges) is (name != "sections")


@settings(examples(150), suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(case=st.deferred(corrupted))
def test_a_corrupted_link_changes_nothing_or_is_named(case: tuple[str, Corrupted], tmp_path: Path) -> None:
    """Any link of a complete map, left out or leading elsewhere: the same graph, or a note that names the road."""
    name, wrong = case
    edges, remarks = judged(wrong.text, tmp_path)
    named = any(f"`{each}`" in remark for remark in remarks for each in wrong.names)
    assert edges == judged(map_text(name), tmp_path)[0] or named, wrong.what


FULL = {(("1", -1), ("2", -1)), (("2", 1), ("1", 1))}


@pytest.mark.parametrize(
    ("elements", "said"),
    [
        (two_roads(), 0),
        (two_roads(links=(True, False)), 0),
        (two_roads(links=(False, True)), 0),
        (two_roads(second=""), 0),
        (two_roads(first=""), 0),
        (two_roads(first="<successor/>"), 0),
        (two_roads(link("successor", "2", "end"), link("predecessor", "1", "start")), 1),
        (two_roads(link("successor", "2", "start").replace("contactPoint", "was")), 0),
        (COMPLETE["direct junction"], 0),
    ],
)
def test_what_one_side_states_holds_for_both(elements: tuple[str, ...], said: int, tmp_path: Path) -> None:
    """Of roads and of lanes; the end that lies there is taken where a file names the far one."""
    found = plan(written(tmp_path, *elements))
    assert graph(found.links) == FULL
    assert len(found.remarks) == said


def test_lanes_that_touch_without_a_link_are_named(tmp_path: Path) -> None:
    found = plan(written(tmp_path, *two_roads("", "", (False, False))))
    assert not graph(found.links)
    assert found.remarks == (
        "lane -1 of road `1` ends where lane -1 of road `2` begins, and no link joins them (so do 1 more)",
    )


def test_lanes_that_run_apart_are_not_named(tmp_path: Path) -> None:
    """Neither is one that begins 0.2 m further on, nor one that leads back."""
    one, other = two_roads("", "", (False, False))
    away = other.replace('x="50.0"', 'x="50.2"')
    back = other.replace('hdg="0.0"', 'hdg="3.2"')
    for second in (away, back):
        assert not plan(written(tmp_path, one, second)).remarks


@pytest.mark.parametrize("kind", ["virtual", "crossing"])
def test_junctions_without_roads_through_them_are_named(kind: str, tmp_path: Path) -> None:
    found = plan(written(tmp_path, *two_roads(), f'<junction id="9" type="{kind}"/>'))
    assert graph(found.links) == FULL
    assert found.remarks == (f"no lane leads through junction `9` of the type `{kind}`, which is not read",)


def test_a_lane_that_splits_in_a_direct_junction_leads_both_ways(tmp_path: Path) -> None:
    """An exit begins beside the lane that goes on; a driver without a plan takes the first."""
    exit_link = '<connection id="1" incomingRoad="1" linkedRoad="3" contactPoint="start"><laneLink from="-1" to="-1"/>'
    elements = COMPLETE["direct junction"]
    ramp = road(
        "3", section(right=[lane(-1)]), '<predecessor elementType="junction" elementId="5"/>', place={"x": 50.0}
    )
    both = elements[2].replace("</junction>", f"{exit_link}</connection></junction>")
    path = written(tmp_path, *elements[:2], ramp, both)
    assert graph(plan(path).links) == {*FULL, (("1", -1), ("3", -1))}
    lanes = {(each.road, each.forward): each for each in network(path).lanes}
    start = lanes["road1", True]
    assert [each.road for each in start.successors] == ["road2", "road3"]
    assert start.network.paths.parts(start.default_route) == (start.path, lanes["road2", True].path)


SINGLE = 'singleSide="true"'
LEFT, RIGHT = [lane(1)], [lane(-1, after=-1)]


def test_sides_that_are_cut_on_their_own_are_those_of_whole_sections(tmp_path: Path) -> None:
    """Both ways to write a left side of one section beside a right side of two."""
    single = section(LEFT, s=0.0, more=SINGLE) + section((), RIGHT, 0.0, SINGLE)
    single += section((), [lane(-1, before=-1)], 20.0, SINGLE)
    whole = section([lane(1, after=1)], RIGHT) + section([lane(1, before=1)], [lane(-1, before=-1)], 20.0)
    plans = [plan(written(tmp_path, road("1", text))) for text in (single, whole)]
    assert [each.parts for each in plans[0].links.lanes] == [each.parts for each in plans[1].links.lanes]
    assert len(plans[0].lanes) == 2
    for one, other in zip(*(each.lanes for each in plans), strict=True):
        assert one.line == other.line
    assert not plans[0].remarks
