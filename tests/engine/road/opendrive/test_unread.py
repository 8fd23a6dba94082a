"""Whatever a map states and nothing reads is named, once for each kind, and changes nothing else."""

import re
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cortex_dsl.files import Folder
from cortex_dsl.pipeline import compile_source
from cortex_dsl.source import Source
from engine.opendrive.read import METADATA, read_opendrive
from engine.road.opendrive.contents import packed, to_bytes
from engine.road.opendrive.lanes import ALIKE, NEAR
from tests.engine.road.opendrive.files import EXAMPLES, lane, network, road, section, written
from tests.laws import examples

VILLAGE = (EXAMPLES / "village.xodr").read_text()
PLACES = [each.tag for each in ElementTree.fromstring(VILLAGE).iter()]
UNUSED = ("roadMark", "CRG", "material", "height", "access", "laneGroup", "bridge", "future", "station")
NEW = ("layer", "speedOfSound", "z")


def outcome(text: str, folder: Path) -> tuple[bytes, str]:
    """Return all of the network but what is said to be unread, and that."""
    path = folder / "road.xodr"
    path.write_text(text)
    made = network(path)
    said, made.unread = made.unread, ""
    return to_bytes(packed(made, NEAR, ALIKE), "key"), said


def inside(element: Element, root: Element) -> bool:
    """Return True for an element that a reader asks for: what is in others belongs to these."""
    unasked = [each for tag in METADATA for each in root.iter(tag)]
    return not any(element in each.iter() for each in unasked)


@settings(examples(100), suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    number=st.integers(0, len(PLACES) - 1),
    name=st.sampled_from([*UNUSED, *NEW]),
    is_element=st.booleans(),
    before=st.booleans(),
)
def test_an_element_or_attribute_that_nothing_reads_is_one_kind_more(
    number: int, name: str, is_element: bool, before: bool, tmp_path: Path
) -> None:
    """Anywhere in a file, first or last of its place: one kind is named, and the roads stay bit for bit."""
    root = ElementTree.fromstring(VILLAGE)
    here = list(root.iter())[number]
    if not is_element:
        here.set(name, "7")
    elif before:
        here.insert(0, Element(name, {"a": "7"}))
    else:
        SubElement(SubElement(here, name), "more", {"a": "7"})
    same, said = outcome(VILLAGE, tmp_path)
    roads, more = outcome(ElementTree.tostring(root, encoding="unicode"), tmp_path)
    assert roads == same
    kind = name if is_element else f"{name} of {here.tag}"
    if inside(here, root) and name != "roadMark":
        assert more.count(f"{kind} (1, line") == 1
    assert more.count(", line") - said.count(", line") == (inside(here, root) and name != "roadMark")


def test_a_second_element_where_one_is_read_is_not_read(tmp_path: Path) -> None:
    """Only the first `link` of a road counts."""
    twice = VILLAGE.replace("<planView>", '<link><successor elementType="road" elementId="3"/></link><planView>', 1)
    assert outcome(twice, tmp_path)[0] == outcome(VILLAGE, tmp_path)[0]
    assert "link (1, line" in outcome(twice, tmp_path)[1]


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ("<elevationProfile/><lateralProfile/><surface/>", ""),
        ('<elevationProfile><elevation s="0" a="0" b="0" c="0" d="0"/></elevationProfile>', ""),
        ('<elevationProfile><elevation s="0" a="0" b="0.1" c="0" d="0"/></elevationProfile>', "elevationProfile"),
        ('<elevationProfile><elevation s="0" a="high"/></elevationProfile>', "elevationProfile"),
        ('<lateralProfile><superelevation s="0" a="0.1" b="0" c="0" d="0"/></lateralProfile>', "lateralProfile"),
        ('<surface><CRG file="bumps.crg"/></surface>', "surface"),
        ('<objects><object type="tree" id="1" s="1" t="9"/><object type="pole"/></objects>', "object"),
        ('<userData code="a"/>', ""),
    ],
)
def test_what_has_no_effect_is_not_named(more: str, said: str, tmp_path: Path) -> None:
    """What is flat or empty states nothing that would differ; every slope, surface and object is named."""
    found = read_opendrive(written(tmp_path, road("1", section(right=[lane(-1)])).replace("<lanes>", f"{more}<lanes>")))
    assert [each.name for each in found.unread] == ([said] if said else [])


def test_lanes_that_nobody_drives_on_are_named(tmp_path: Path) -> None:
    rails = lane(-2).replace("driving", "tram")
    found = network(written(tmp_path, road("1", section(right=[lane(-1), rails]))))
    assert found.unread == "not read: lane of type tram (1, line 1 in road `1`)"


def test_a_map_has_one_note_whatever_it_leaves_out(tmp_path: Path) -> None:
    """Its kinds stand in one sentence, with how many there are and where the first one stands; paint has none."""
    text = 'map opendrive("village.xodr")\nego = new Car on road\n'
    assert not compile_source(Source("here.scn", text), files=Folder(EXAMPLES)).diagnostics
    more = '<bridge id="1" s="0" length="5"/><tunnel id="2"/>'
    (tmp_path / "village.xodr").write_text(VILLAGE.replace("</planView>", f"</planView><objects>{more}</objects>", 1))
    (found,) = compile_source(Source("here.scn", text), files=Folder(tmp_path)).diagnostics
    assert found.code == "SCN466"
    assert re.search(r"not read: bridge \(1, line \d+\), tunnel \(1, line \d+\)$", found.message)
