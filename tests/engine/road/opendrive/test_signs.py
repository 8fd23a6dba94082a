"""Traffic lights and signs of files: which lanes they tell, which arms have lights, and what scripts ask of them."""

from pathlib import Path

import pytest

from cortex_dsl import CompileError, compile_text
from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.pipeline import compile_source
from cortex_dsl.source import Source
from engine.road import Network, build_network
from engine.road.lights import lights_for_nobody, lit_arms, signs_at
from engine.road.opendrive.network import map_file

VILLAGE = Path(__file__).parents[4] / "examples" / "roads" / "village.xodr"
LIGHT = (
    '<signal id="7" name="light" s="1" t="-2" orientation="-" country="OpenDRIVE" type="1000001" subtype="-1" '
    'dynamic="yes"><validity fromLane="{0}" toLane="{0}"/></signal>'
)
STANDING = LIGHT.format(0)
REFERENCE = (
    '<signalReference id="7" s="2" t="0" orientation="+"><validity fromLane="-1" toLane="-1"/></signalReference>'
)
SIGN = '<signal id="9" name="50" s="10" t="4" orientation="+" country="de" type="274" subtype="50" value="50"/>'


def village(folder: Path, **signals: str) -> Path:
    """With signals by the road that they belong to, as in `r4="<signal …/>"`."""
    text = VILLAGE.read_text()
    for name, each in signals.items():
        start = text.index(f'<road id="{name[1:]}"')
        end = text.index("</road>", start)
        text = f"{text[:end]}<signals>{each}</signals>{text[end:]}"
    path = folder / "lit.xodr"
    path.write_text(text)
    return path


def read(path: Path) -> Network:
    return build_network(map_file(path, path.name))


def test_a_light_over_a_way_through_tells_those_who_wait_for_it(tmp_path: Path) -> None:
    """Of one that counts for no lane where it stands, as in CARLA's towns, a reference says where it does."""
    network = read(village(tmp_path, r1=STANDING, r4=REFERENCE))
    (sign,) = network.signs
    assert (sign.id, sign.road, sign.is_traffic_light, sign.country) == ("7", "road4", True, "OpenDRIVE")
    assert [network.lanes[lane].road for lane in sign.lanes] == ["road4"]
    assert signs_at(network, 0) == (sign,)
    lit = lit_arms(network)
    assert lit is not None
    ((_, arm),) = lit
    assert {lane.road for lane in network.intersections[0].legs[arm].incoming_lanes} == {"road1"}


def test_a_light_that_tells_no_arm_is_none(tmp_path: Path) -> None:
    """One that faces those who leave the junction: it is counted, and a plan holds as where the file has no lights."""
    backwards = '<signal id="7" s="1" t="-2" orientation="-" type="1000001"/>'
    network = read(village(tmp_path, r1=backwards))
    assert [sign.is_traffic_light for sign in network.signs] == [True]
    assert (lit_arms(network), lights_for_nobody(network)) == (None, 1)


def test_signs_stand_where_the_file_says(tmp_path: Path) -> None:
    """Road 1 begins at (51.5, 0) and leads west: 10 m on and 4 m to the left is (41.5, -4)."""
    network = read(village(tmp_path, r1=SIGN))
    (sign,) = network.signs
    assert (sign.x, sign.y) == (pytest.approx(41.5), pytest.approx(-4.0))
    assert (sign.type, sign.subtype, sign.value, sign.is_traffic_light) == ("274", "50", 50.0, False)
    (lane,) = (network.lanes[lane] for lane in sign.lanes)
    assert (lane.road, lane.forward) == ("road1", True)
    assert lit_arms(network) is None


@pytest.mark.parametrize(
    ("orientation", "ways"), [("+", {True}), ("-", {False}), ("none", {True, False}), ("odd", {True, False})]
)
def test_a_sign_without_lanes_tells_those_who_come_its_way(orientation: str, ways: set[bool], tmp_path: Path) -> None:
    network = read(village(tmp_path, r1=SIGN.replace('"+"', f'"{orientation}"')))
    assert {network.lanes[lane].forward for lane in network.signs[0].lanes} == ways


@pytest.mark.parametrize(
    ("odd", "left", "remark"),
    [
        (SIGN.replace('s="10"', 's="-3"'), 0, "signals are left out whose id, place or lanes cannot be read: 1"),
        (SIGN.replace(' t="4"', ""), 0, "signals are left out whose id, place or lanes cannot be read: 1"),
        (SIGN.replace('value="50"', 'value="fifty"'), 1, "values of signals that are not numbers are left out: 1"),
        (SIGN.replace('s="10"', 's="4000"'), 1, ""),
        (REFERENCE, 0, "references are left out to signals that are not there, or cannot be read: 1"),
        (STANDING, 0, ""),
    ],
)
def test_odd_signals_never_refuse_a_map(odd: str, left: int, remark: str, tmp_path: Path) -> None:
    network = read(village(tmp_path, r1=odd))
    assert len(network.signs) == left
    assert list(network.remarks) == [remark] * bool(remark)


ROADS = "lit = filter(lambda r: len(r.signals) > 0, network.roads)\n"
EGO = "ego = new Car in network.intersections[0].incomingLanes[0].centerline"


def said(text: str) -> tuple[Diagnostic, ...]:
    """Return all diagnostics, but for the note on what no reader asks for (SCN466): `test_unread` is about that."""
    try:
        found = compile_source(Source("lit.scn", text)).diagnostics
    except CompileError as error:
        found = error.diagnostics
    return tuple(each for each in found if each.code != "SCN466")


def test_scripts_ask_signs_for_what_they_are(tmp_path: Path) -> None:
    text = (
        f'map opendrive("{village(tmp_path, r1=SIGN, r4=LIGHT.format(-1))}")\n{ROADS}sign = lit[0].signals[0]\n'
        "here = network.intersections[0]\nlight = here.signals[0]\n"
        'assert len(lit) == 1 and sign.value == 50 and sign.type == "274" and sign.country == "de"\n'
        'assert not sign.isTrafficLight and light.isTrafficLight and light.openDriveID == "7"\n'
        f"assert here.isSignalized and light.value is None and sign.position.x > 41\n{EGO}\n"
    )
    found = said(text)
    assert [each.code for each in found] == ["SCN458"]
    assert found[0].message.endswith("no driver heeds its 1 traffic light and 1 sign")
    assert "signals()" in found[0].cure


def test_three_signals_by_another_name_are_no_plan(tmp_path: Path) -> None:
    """The note counts lights that no driver heeds by the statement `signals`, wherever else the word may stand."""
    text = f'"""signals() of a village."""\nmap opendrive("{village(tmp_path, r4=LIGHT.format(-1))}")\nsignals = 3\n'
    (found,) = said(f"{text}{EGO}, with speed signals\n")
    assert found.code == "SCN458"
    assert found.message.endswith("no driver heeds its 1 traffic light")


@pytest.mark.parametrize("plan", ["", "signals()\n"])
def test_lights_of_an_arm_are_listed_and_keep_what_the_file_says(plan: str, tmp_path: Path) -> None:
    """Those over the lanes into an intersection too, with a plan and without."""
    text = (
        f'map opendrive("{village(tmp_path, r1=STANDING, r4=REFERENCE)}")\n{plan}'
        "here = network.intersections[0]\nlight = here.signals[0]\n"
        "assert here.isSignalized and len(here.signals) == 1 and light.isTrafficLight\n"
        f'assert light.openDriveID == "7" and light.country == "OpenDRIVE" and light.position.x > 0\n{EGO}\n'
    )
    assert not [each for each in said(text) if each.code == "SCN476"]
    assert {each.code for each in said(text)} <= {"SCN458", "SCN454"}


def test_a_plan_is_that_of_the_arms_that_have_lights(tmp_path: Path) -> None:
    """Who comes by road 1 has a light, who comes by another has none; nothing is remarked of lights then."""
    path = village(tmp_path, r1=STANDING, r4=REFERENCE)
    text = (
        f'map opendrive("{path}")\nsignals(green=10 s, yellow=0 s, all_red=1000 s, offset=500 s)\n'
        'here = filter(lambda l: l.road.name == "road{}", network.intersections[0].incomingLanes)[0]\n'
        "assert (here.signal is None) == {} and len(network.intersections[0].signals) == 1\n"
        "ego = new Car before network.intersections[0] by 20 m along [here], with speed 8 m/s,\n"
        "    with behavior FollowLaneBehavior(8 m/s, obey_signals=True)\n"
        "terminate when ego in network.intersections[0]\nterminate after 10 s\n"
    )
    steps = []
    for road, has_none in (("1", False), ("3", True)):
        written = text.format(road, has_none)
        assert not said(written)
        scenario = compile_text(written)
        steps.append(int(scenario.simulate(scenario.sample(1, seed=1)).steps[0]))
    assert steps[0] == 200 > 2 * steps[1]


def test_a_sign_has_no_colour(tmp_path: Path) -> None:
    text = (
        f'map opendrive("{village(tmp_path, r4=SIGN)}")\nsignals()\n{EGO}\n'
        'terminate when getTrafficLightStatus(network.intersections[0].signals[-1]) == "red"\n'
    )
    assert "`signal` must be a traffic light, but this is a sign of the map" in [each.message for each in said(text)]
