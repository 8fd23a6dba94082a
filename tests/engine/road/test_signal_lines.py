"""Lines at which traffic waits for lights, and what these show: in every drawing of a road the same."""

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from cortex_dsl import compile_text
from cortex_dsl.lowering.given_out import colour_of
from cortex_dsl.report.findings.case_replay import replay_case
from cortex_dsl.report.page.player import player_data
from cortex_dsl.report.page.scene_svg import road_layer
from cortex_dsl.report.terminal.scene_view import draw_scene, signal_legend
from engine.interchange.recording import SignalTimes
from engine.maps import LoneRoad, RoadSpec
from engine.road import build_network
from engine.road.opendrive.network import map_file
from engine.road.outline import near, outline

ROADS = Path(__file__).parents[3] / "examples" / "roads"
PLAN = SignalTimes(6.0, 2.0, 1.0, 4.0)
SHOWN = partial(colour_of, PLAN)
LIT = """
map intersection(ways=4)
signals(green=1 s, yellow=1 s, all_red=1 s)
ego = new Car at (1.75 m, -20 m), facing 90 deg, with speed 9 m/s, with behavior FollowLaneBehavior(10 m/s)
other = new Car at (-30 m, -1.75 m), facing 0 deg, with behavior FollowLaneBehavior(3 m/s)
new Car at (30 m, 1.75 m), facing 180 deg
terminate after 3 s
"""


def test_colours_follow_the_plan() -> None:
    """Green, yellow, then red while it is the other phase's turn; unknown where behaviours change the lights."""
    assert [colour_of(PLAN, 0, time) for time in (0.0, 1.9, 2.0, 3.9, 4.0, 13.9, 14.0)] == [
        *("green", "green", "yellow", "yellow", "red", "red", "green")
    ]
    assert [colour_of(PLAN, 1, time) for time in (0.0, 4.9, 5.0, 11.0, 13.0)] == [
        "red",
        "red",
        "green",
        "yellow",
        "red",
    ]
    assert not any(
        {colour_of(PLAN, 0, time), colour_of(PLAN, 1, time)} == {"green"} for time in np.arange(0.0, 36.0, 0.25)
    )
    assert colour_of(replace(PLAN, controlled=True), 0, 0.0) == ""


def test_a_grid_has_lines_where_its_scenario_has_a_plan() -> None:
    """One across each lane that leads into an intersection, and those of facing arms show the same."""
    network = build_network(RoadSpec(ways=4, lanes=2))
    assert outline(network).signals == ()
    lines = outline(network, SHOWN).signals
    assert len(lines) == 8
    assert [len({each.colour(5.5) for each in lines if each.phase == phase}) for phase in (0, 1)] == [1, 1]
    stops = {tuple(line.ravel()) for line in outline(network).stop_lines}
    assert {tuple(each.line.ravel()) for each in lines} <= stops
    assert outline(build_network(LoneRoad()), SHOWN).signals == ()


def test_a_file_has_those_of_its_own_lights(tmp_path: Path) -> None:
    """The village has no light; with one over a lane only its lane has a line, with a plan or without."""
    text = (ROADS / "village.xodr").read_text(encoding="utf-8")
    plain = build_network(map_file(ROADS / "village.xodr", "village.xodr"))
    arm = plain.intersections[0].legs[0]
    road = arm.incoming_lanes[0].road.removeprefix("road")
    light = (
        '<signals><signal s="1" t="-2" id="77" name="" dynamic="yes" orientation="none" zOffset="0" country="" '
        'type="1000001" subtype="-1" value="-1"/></signals>'
    )
    before, after = text.split(f'id="{road}"', 1)
    lit = tmp_path / "lit.xodr"
    lit.write_text(f'{before}id="{road}"{after.replace("</lanes>", "</lanes>" + light, 1)}', encoding="utf-8")
    network = build_network(map_file(lit, "lit.xodr"))
    drawn = outline(network)
    assert 0 < len(drawn.signals) < len(outline(plain, SHOWN).signals)
    assert {each.colour(0.0) for each in drawn.signals} == {""}
    assert {each.colour(0.0) for each in outline(network, SHOWN).signals} <= {"green", "red"}
    far = np.array([(1e5, 1e5)])
    assert near(drawn, far, 10.0).signals == ()
    assert outline(plain).signals == ()


def test_every_drawing_shows_them() -> None:
    """Letters in the terminal, coloured lines in pages and films, by the plan of the scene."""
    scenario = compile_text(LIT)
    replay = replay_case(scenario, scenario.sample())
    assert len(replay.road.signals) == 4
    canvas = draw_scene(replay.road, replay.trajectory, None, 60)
    assert sorted(letter for letter, _ in canvas.marks.values() if letter in "gyrs") == ["g", "g", "r", "r"]
    assert len(signal_legend(replay.road)) == 1
    shown = str(road_layer(replay.road, 1.5))
    assert (shown.count('class="signal yellow"'), shown.count('class="signal red"')) == (2, 2)
    changes = player_data(replay)["signals"]
    first = next(each for each in changes if each[0][1] == "green")
    assert [colour for _, colour in first] == ["green", "yellow", "red"]
    assert [time for time, _ in first] == pytest.approx([0.0, 1.0, 2.0], abs=0.06)
