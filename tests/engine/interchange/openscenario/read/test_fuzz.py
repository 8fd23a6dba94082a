"""Whatever bytes a file holds, it is read or refused: nothing but an `InterchangeError` comes out."""

import contextlib
import re
from pathlib import Path

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from engine.interchange import InterchangeError
from engine.interchange.openscenario.read import read_openscenario
from engine.opendrive.read import read_opendrive
from engine.xml import Limits
from tests.engine.interchange.openscenario.read.files import (
    ROAD,
    XODR,
    at_time,
    event,
    follow,
    polyline,
    scenario,
    speed,
    teleport,
    vehicle,
    world,
)
from tests.laws import examples

often = settings(examples(400), suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
LIMITS = Limits(megabytes=1, elements=5000)
LANE = '<Position><LanePosition roadId="1" laneId="-1" s="{}"/></Position>'
PARAMETER = '<ParameterDeclaration name="v" parameterType="double" value="4"/>'
CARRIED = "".join(
    f'<Property name="cortexc.{name}" value="{value}"/>'
    for name, value in {
        "step": "0.1",
        "time": "0 0.1 0.2",
        "speed": "10 10 10",
        "steer": "0 0 0",
        "acceleration": "0 0 0",
        "throttle": "0 0 0",
        "brake": "0 0 0",
    }.items()
)
XOSC = scenario(
    [vehicle("Ego", properties=CARRIED), vehicle("b"), vehicle("c")],
    [
        ("Ego", teleport(world(0, 0, 0)) + follow(polyline((0.0, world(0)), (0.1, world(1)), (0.2, world(2))))),
        ("b", teleport(LANE.format(5)) + speed(4)),
        ("c", teleport('<Position><RelativeWorldPosition entityRef="b" dx="${$v + 1}" dy="0"/></Position>')),
    ],
    [
        event("b", follow(polyline((0.0, LANE.format(9)), (0.3, LANE.format(12)))), at_time(0.1)),
        event("c", '<GlobalAction><EntityAction entityRef="c"><DeleteEntityAction/></EntityAction></GlobalAction>'),
    ],
    network=ROAD,
    parameters=PARAMETER,
    stop=at_time(0.25),
)
VALUES = [match.span(1) for match in re.finditer('="([^"]*)"', XOSC)]
ROAD_VALUES = [match.span(1) for match in re.finditer('="([^"]*)"', XODR)]
TAGS = [match.group() for match in re.finditer(r"<[^<>]*>", XOSC)]
NASTY = (
    *("", "0", "-1", "1e308", "-1e308", "1e-300", "NaN", "INF", "-INF", "1e999999", "1" * 400, "0x10", "1_0", "٣"),
    *("$v", "$w", "${$v}", "${", "${1/0}", "${((((1))))}", "a" * 5000, "../../../../etc/passwd", "file:///etc/passwd"),
    *("Ego", "b", "x y", "true", ".", "..", "/", "/dev/zero", "/dev/stdin", "&#0;", "&lt;", "&x;", "-2", "1.5", "500"),
)
edits = st.lists(st.tuples(st.integers(0, 10_000), st.sampled_from(NASTY)), min_size=1, max_size=3)


def survives(folder: Path, scenario_bytes: bytes, road_bytes: bytes) -> None:
    (folder / "case.xosc").write_bytes(scenario_bytes)
    (folder / "road.xodr").write_bytes(road_bytes)
    with contextlib.suppress(InterchangeError):
        recording = read_openscenario(folder / "case.xosc", limits=LIMITS).recording
        assert np.isfinite(recording.states).all()
        assert (np.diff(recording.time) > 0).all()
        assert recording.step > 0
    with contextlib.suppress(InterchangeError):
        network = read_opendrive(folder / "road.xodr", LIMITS)
        assert network.summary()
        for road in network.roads.values():
            for s in (0.0, road.length / 2, road.length):
                assert np.isfinite(network.pose(road.id, None, s)).all()


def with_values(text: str, spans: list[tuple[int, int]], changes: list[tuple[int, str]]) -> str:
    """The text with other attribute values; the last place first, so that those before stay where they are."""
    chosen = {spans[number % len(spans)]: value for number, value in changes}
    for (start, end), value in sorted(chosen.items(), reverse=True):
        text = text[:start] + value + text[end:]
    return text


def test_the_seed_is_read(tmp_path: Path) -> None:
    """Else the rest would say little."""
    (tmp_path / "case.xosc").write_text(XOSC)
    (tmp_path / "road.xodr").write_text(XODR)
    assert len(read_openscenario(tmp_path / "case.xosc").recording.actors) == 3


@often
@given(edits, edits)
def test_nasty_values(tmp_path: Path, changes: list[tuple[int, str]], road: list[tuple[int, str]]) -> None:
    """Any attribute of a scenario or a road."""
    survives(tmp_path, with_values(XOSC, VALUES, changes).encode(), with_values(XODR, ROAD_VALUES, road).encode())


@often
@given(st.lists(st.tuples(st.integers(0, 10_000), st.binary(max_size=4)), min_size=1, max_size=6), st.booleans())
def test_mutated_bytes(tmp_path: Path, changes: list[tuple[int, bytes]], cut: bool) -> None:
    """Bytes put in place of others, and files cut short."""
    data, road = bytearray(XOSC.encode()), bytearray(XODR.encode())
    for where, value in changes:
        for text in (data, road):
            place = where % len(text)
            text[place : place + len(value)] = value
    survives(tmp_path, bytes(data[: changes[0][0]] if cut else data), bytes(road))


@often
@given(st.integers(0, 1000), st.integers(0, 1000), st.integers(0, 2))
def test_elements_lost_doubled_and_swapped(tmp_path: Path, one: int, other: int, how: int) -> None:
    """The reader finds what it looks for, or says that it does not."""
    first, second = TAGS[one % len(TAGS)], TAGS[other % len(TAGS)]
    text = XOSC.replace(first, ("", first + second, second)[how])
    survives(tmp_path, text.encode(), XODR.encode())


@often
@given(st.binary(max_size=200))
def test_bytes_of_any_kind(tmp_path: Path, data: bytes) -> None:
    """No file at all, as far as XML is concerned."""
    survives(tmp_path, data, data)
