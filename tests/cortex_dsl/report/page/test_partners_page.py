"""A page of a search among three: with whom the ego collided, and with whom never."""

import json
from pathlib import Path

import pytest

from cortex_dsl.api.runs import OpenedRun, open_run
from cortex_dsl.cli import main
from cortex_dsl.report.page.run_page import run_page
from cortex_dsl.report.page.run_sections import how_runs_ended
from tests.cortex_dsl.report.page.conftest import Reader

SCENARIO = """\
map intersection(approach=80 m)

param EGO_SPEED = Range(20, 60) km/h
param TRUCK_START = Range(10, 60) m

mine = Uniform(*filter(lambda m: m.type is ManeuverType.STRAIGHT, intersection.maneuvers))
theirs = Uniform(*mine.conflictingManeuvers)

ego = new Car before intersection by 40 m along mine,
    with speed EGO_SPEED,
    with behavior FollowTrajectoryBehavior(EGO_SPEED, mine)
truck = new Truck before intersection by TRUCK_START along theirs,
    with speed 40 km/h,
    with behavior FollowTrajectoryBehavior(40 km/h, theirs)
walker = new Pedestrian behind ego by 12 m

terminate after 12 s
"""


@pytest.fixture(scope="module")
def three(tmp_path_factory: pytest.TempPathFactory) -> OpenedRun:
    """Somebody on foot stands where the ego never comes."""
    home = tmp_path_factory.mktemp("three")
    file, run = home / "three.scn", home / "run"
    file.write_text(SCENARIO, encoding="utf-8")
    words = ["--ga", "--generations", "4", "--population", "16", "--seed", "3", "--out", str(run), "--json"]
    assert main([str(file), *words]) == 0
    return open_run(run)


@pytest.fixture(scope="module")
def read_three(three: OpenedRun) -> Reader:
    reader = Reader()
    reader.feed(run_page(three, 1, 0))
    return reader


def test_the_walker_who_was_missed_has_a_tile(read_three: Reader, three: OpenedRun) -> None:
    """With 0, beside the truck with all collisions; and the numbers for programs agree."""
    numbers = json.loads(read_three.blocks["run"])
    hits = numbers["by_simulation"]["colliding_runs"]
    assert hits > 0
    assert numbers["collisions_with"] == {"truck": hits, "walker": 0}
    assert numbers["collisions_without_ego"] == 0
    assert read_three.figures["collisions_with.walker"] == [(0.0, "0")]
    assert read_three.figures["collisions_with.truck"][0][0] == hits
    summary = json.loads((Path(three.folder) / "summary.json").read_text(encoding="utf-8"))
    assert summary["collisions_with"] == numbers["collisions_with"]


def test_the_ends_name_partners(three: OpenedRun) -> None:
    """Also the one that was never touched."""
    counts = {text: count for text, count, _ in how_runs_ended(three)[0]}
    assert counts["collision with truck"] > 0
    assert counts["collision with walker"] == 0


def test_tabs_and_story_name_partners(three: OpenedRun) -> None:
    """`risk 22, truck`; and how near the ego came to the other."""
    text = run_page(three, 1, 0)
    assert ", truck</small>" in text
    assert "Nearest to the others" in text
    assert "By partner: truck " in text
