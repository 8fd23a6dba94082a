"""`cortexc suite`: geometry of the cells, planted defects, deviations, searched ranges, files, and bad input."""

import csv
import importlib
import json
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cortex_dsl as cx
from cortex_dsl.api import seeded_runs, suite_cells, testing
from cortex_dsl.api.contenders import side_of
from cortex_dsl.api.limits import budget_of
from cortex_dsl.api.suite_tables import SuiteError, read_suite, suite_names, suite_of
from cortex_dsl.api.suites import run_suite
from cortex_dsl.console.terminal import Exit
from cortex_dsl.report.findings.suite_report import CellResult, GroupResult, Outcome, SuiteReport
from engine.gates.ranges import largest_ranges, spread
from engine.gates.ratings import Colour
from engine.vocabulary import Answer

Run = Callable[..., Any]
BLIND = "ConstantSpeedBehavior(EGO_SPEED)"
BLIND_ON_PATH = "FollowTrajectoryBehavior(EGO_SPEED, EGO_PATH, max_lateral=none)"
NEVER = "EmergencyBrakeBehavior(FollowLaneBehavior(EGO_SPEED), min_speed={})"
"""An emergency brake with a condition for a speed below which it never begins."""


def cells(report: SuiteReport) -> dict[str, CellResult]:
    return {cell.id: cell for cell in report.cells}


# -- tables ------------------------------------------------------------------------------------------------------------


def test_the_cells_are_those_of_the_rating_calculator() -> None:
    """412 standard cells, and the 500 extended ones less the 24 that rows declared as AEB have twice."""
    suite = suite_of("euroncap-2026")
    assert sum(cell.range == "standard" for cell in suite.cells) == 412
    assert sum(cell.range == "extended" for cell in suite.cells) == 500 - 24
    assert len({cell.id for cell in suite.cells}) == len(suite.cells)


@pytest.mark.parametrize("name", suite_names())
def test_every_cell_has_a_source_and_its_scenario_compiles(name: str) -> None:
    """A shipped suite has no file without a cell, and no cell without a file or a reason."""
    suite = suite_of(name)
    assert suite.edition
    assert all(cell.source and cell.status in ("verified", "unverified") for cell in suite.cells)
    used = {group.file.name for group in suite.groups if group.file is not None}
    helpers = {"lab.scn", "suite.toml"} | ({"turns.scn"} if name.startswith("euroncap") else set())
    assert used | helpers == {path.name for path in suite.folder.iterdir()}
    for group in suite.groups:
        assert (group.file is None) == all(cell.reason for cell in group.cells)
        if group.file is not None:
            assert cx.load(group.file).program.controls


def expected_impact(cell: CellResult) -> float:
    """Return the impact speed of an ego that keeps its speed [km/h]."""
    speed, target = float(cell.params["SPEED"]), float(cell.params.get("TARGET_SPEED", 0.0))
    along = cell.group in ("CCRs", "CCRm", "CMRs", "CBLA")
    return speed - target if along else speed + target if cell.group.startswith("CCFho") else speed


TURNS = ("CCFtap", "CMFtap", "CPTAfs & CPTAns", "CPTAfo & CPTAno", "CBTAfs & CBTAns", "CBTAfo & CBTAno")


def test_an_ego_that_turns_without_a_reaction_is_hit_at_the_time_of_the_cell() -> None:
    """After 7 s, less what the corners of outlines meet before their middles."""
    report = run_suite("euroncap-2026", BLIND_ON_PATH, budget=1, only=[*TURNS, "CCFhol"])
    assert [group.name for group in report.groups] == ["CCFhol", *TURNS]
    for cell in report.cells:
        assert cell.outcome is Outcome.FAIL, cell
        assert cell.impact == pytest.approx(expected_impact(cell), rel=0.01), cell
        target = float(cell.params.get("TARGET_SPEED", 0.0))
        length = {50.0: 44.0, 70.0: 60.0, 90.0: 78.0, 100.0: 88.0}.get(target, 0.0)
        due = 7.0 if cell.group in TURNS else (60.0 + length) / target * 3.6 + 1.5
        assert float(cell.event.split(" s")[0]) == pytest.approx(due, abs=0.13), cell


@pytest.mark.parametrize("name", TURNS)
@pytest.mark.parametrize(
    ("driver", "said"), [(BLIND, "does not follow `EGO_PATH`"), ("FollowLaneBehavior", "EGO_PATH")]
)
def test_a_driver_that_keeps_its_lane_has_no_result_where_the_ego_turns(name: str, driver: str, said: str) -> None:
    """Neither green nor red: it was not in the test."""
    report = run_suite("euroncap-2026", driver, budget=1, only=[name])
    assert {cell.outcome for cell in report.cells} == {Outcome.NOT_RUN}
    assert said in report.cells[0].reason


WARNS = "EmergencyBrakeBehavior(FollowTrajectoryBehavior(EGO_SPEED, EGO_PATH), warning_ttc={} s)"
SEES = "EmergencyBrakeBehavior(FollowTrajectoryBehavior(EGO_SPEED, EGO_PATH), range={})"


@pytest.mark.parametrize(
    ("suite", "group"),
    [("euroncap-2026", "CCRs FCW"), ("euroncap-2026", "CMRs FCW"), ("fmvss-127", "slower lead with manual brake")],
)
def test_a_person_brakes_only_where_the_driver_warns(suite: str, group: str) -> None:
    """A brake that never acts, and a person after its warning: avoided; without a warning there is no result."""
    only = [f"{group}*"]
    person = WARNS.replace("warning_ttc", "max_speed=0 m/s, warning_ttc").format(8)
    warned = run_suite(suite, person, budget=4, only=only)
    assert {cell.outcome for cell in warned.cells} == {Outcome.PASS}
    for each in warned.groups:  # the run that shows whether the driver warns is one of them
        assert each.runs == sum(cell.simulations for cell in each.cells) > 0
    late = run_suite(suite, person.replace("=8 s", "=0.4 s"), budget=4, only=only)
    assert {cell.outcome for cell in late.cells} == {Outcome.FAIL}
    for driver in ("EmergencyBrakeBehavior", "FollowLaneBehavior"):
        silent = run_suite(suite, driver, budget=4, only=only)
        assert {cell.reason for cell in silent.cells} == {suite_cells.NO_WARNING}


def test_a_warning_in_time_is_as_good_as_no_contact() -> None:
    """In rows at 70 and 80 km/h: from a time to collision of 1.7 s on."""
    only = ["CPLA day/[78]0/25", "CBLA/[78]0/25"]
    for ttc, outcome in ((1.8, Outcome.PASS), (1.6, Outcome.FAIL)):
        driver = WARNS.replace("warning_ttc", "max_speed=0 m/s, warning_ttc").format(ttc)
        assert {cell.outcome for cell in run_suite("euroncap-2026", driver, budget=1, only=only).cells} == {outcome}


def test_a_night_is_run_with_the_sensor_that_the_driver_states() -> None:
    """A sensor that sees as far as by day has the results of the day; a blind one those of an ego without a brake."""
    for name in ("CPNA", "CPLA", "CPNCO", "CPFA"):
        same = run_suite("euroncap-2026", SEES.format("150 m + 0 m * LIGHT"), budget=1, only=[f"{name} *"])
        day, night = same.groups
        assert [cell.colour for cell in day.cells] == [cell.colour for cell in night.cells]
        blind = run_suite("euroncap-2026", SEES.format("0.1 m if LIGHT < 10 else 150 m"), budget=1, only=[f"{name} *"])
        assert [cell.colour for cell in blind.groups[0].cells] == [cell.colour for cell in day.cells]
        assert {cell.outcome for cell in blind.groups[1].cells} == {Outcome.FAIL}
        unsaid = run_suite("euroncap-2026", SEES.format("150 m"), budget=1, only=[f"{name} night"])
        assert {cell.outcome for cell in unsaid.cells} == {Outcome.NOT_RUN}


def test_an_ego_that_keeps_its_speed_strikes_the_target_of_every_cell_at_the_nominal_speed() -> None:
    """Contact after 4 s, but for targets that brake; so every cell that is run fails."""
    report = run_suite("euroncap-2026", BLIND, budget=1)
    run = [cell for cell in report.cells if cell.outcome is not Outcome.NOT_RUN and cell.group != "CCFhol"]
    assert len(run) == 631
    for cell in run:
        assert cell.outcome is Outcome.FAIL, cell
        if cell.group not in ("CCRb", "CMRb"):
            assert cell.event.startswith("4.00 s: contact"), cell
            assert cell.impact == pytest.approx(expected_impact(cell), abs=0.05), cell
    assert report.points == 0.0
    assert not report.passed


def test_the_limits_of_un_r152_are_those_of_its_tables() -> None:
    """A car that keeps its speed passes no cell; limits never fall with the speed."""
    suite = suite_of("un-r152")
    for group in suite.groups:
        for load in ("maximum", "running order"):
            limits = [
                cell.limit
                for cell in sorted(group.cells, key=lambda cell: float(cell.params["SPEED"]))
                if cell.params.get("LOAD") == load
            ]
            assert limits == sorted(limits)
    car = {cell.id: cell.limit for cell in suite.cells}
    assert [car[f"car M1/maximum/{speed}"] for speed in (40, 42, 45, 50, 55, 60)] == [0, 10, 15, 25, 30, 35]
    assert [car[f"car N1/maximum/{speed}"] for speed in (38, 40, 42, 45, 60)] == [0, 10, 15, 20, 40]
    assert car["bicycle N1/maximum/38"] == 15


# -- planted defects ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("speed", "location"), [(40, 25), (10, 0), (80, 100), (60, -25)])
def test_a_defect_in_one_cell_fails_there_and_nowhere_else(speed: int, location: int) -> None:
    """The brake never begins at one speed and one place."""
    driver = NEVER.format(
        f"0 m/s if abs(SPEED - {speed} km/h) > 1 km/h or abs(LOCATION - {location}) > 1 else 200 km/h"
    )
    found = cells(run_suite("euroncap-2026", driver, only=["CCRs"], budget=1))
    failing = [name for name, cell in found.items() if cell.outcome is not Outcome.PASS]
    assert failing == [f"CCRs/{speed}/{location}"]
    assert found[failing[0]].impact == pytest.approx(speed, abs=0.05)
    assert found[failing[0]].said["careful"] == "avoids"


@pytest.mark.parametrize("share", [0.02, 0.3, 0.9])
def test_the_least_deviation_and_the_probability_of_a_defect_within_the_tolerance_are_found(share: float) -> None:
    """The brake never begins from a share of the tolerance of the ego's speed on."""
    driver = NEVER.format(f"0 m/s if VUT_SPEED < {share} else 200 km/h")
    (cell,) = run_suite("euroncap-2026", driver, only=["CCRs/50/50"], budget=400).cells
    assert cell.outcome is Outcome.PASS
    assert cell.deviation is not None
    assert cell.deviation.size == pytest.approx(share, abs=2e-3)
    assert cell.low <= 1.0 - share <= cell.high


def test_a_group_has_points_only_with_all_of_its_cells() -> None:
    """The share of a few cells says nothing of the scenario."""
    suite = suite_of("euroncap-2026").only(["CCRs", "CCRm/30/*"])
    assert {group.name: bool(group.points) for group in suite.groups} == {"CCRs": True, "CCRm": False}


def test_a_driver_without_a_failing_deviation_has_none() -> None:
    """Nothing is claimed that was not found."""
    (cell,) = run_suite("euroncap-2026", "EmergencyBrakeBehavior", only=["CCRs/50/50"], budget=100).cells
    assert (cell.outcome, cell.failures, cell.deviation) == (Outcome.PASS, 0, None)
    assert cell.runs == 100
    assert cell.high < 0.05


def test_a_failing_window_of_one_per_cent_of_a_range_is_found_in_each_of_100_searches() -> None:
    """Equally spaced runs leave no window of 1 % out, wherever it lies."""
    points = spread(200, 1)[:, 0]
    for low in np.random.default_rng(1).uniform(0.0, 0.99, 100):
        assert ((points >= low) & (points <= low + 0.01)).any()
    driver = NEVER.format("0 m/s if abs(SPEED - 45.2 km/h) > 0.35 km/h else 200 km/h")
    (cell,) = run_suite("fmvss-127", driver, only=["stopped lead"]).cells
    assert cell.outcome is Outcome.FAIL
    assert cell.searched is not None
    low, high = cell.searched.ranges["SPEED"]
    assert (low, high) == pytest.approx((10.0, 44.8), abs=0.4)


@given(
    failing=st.lists(st.integers(0, 49), min_size=1, max_size=10, unique=True),
)
def test_a_range_without_a_failure_holds_no_failing_run(failing: list[int]) -> None:
    """Its ends are runs that keep clear, and no range of more runs does."""
    points = np.linspace(0.0, 1.0, 50)[:, np.newaxis]
    failed = np.zeros(50, dtype=bool)
    failed[failing] = True
    ((low, high),) = largest_ranges(points, failed, np.array([[0.0, 1.0]]))
    inside = (points[:, 0] >= low) & (points[:, 0] <= high)
    assert not (inside & failed).any()
    gaps = "".join("x" if each else "." for each in failed).split("x")
    assert inside.sum() == max(map(len, gaps))


# -- the command -------------------------------------------------------------------------------------------------------

DRIVERS = """\
import numpy as np

def coasts(observations):
    return np.zeros((len(observations), 3))

def dies_at_40(observations):
    if (abs(observations[:, 0] - 40 / 3.6) < 0.3).any():
        raise ValueError("not at this speed")
    return coasts(observations)

def brakes(observations):
    return np.tile([0.0, 1.0, 0.0], (len(observations), 1))

def brakes_or_dies_at_40(observations):
    dies_at_40(observations)
    return brakes(observations)

def steers(observations):
    return np.tile([0.0, 0.0, 0.5], (len(observations), 1))

coasting = False

def coasts_at_times(observations):
    return coasts(observations) if coasting else brakes(observations)
"""


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder with drivers, in which the command runs."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "suite_drivers.py").write_text(DRIVERS)
    monkeypatch.delitem(sys.modules, "suite_drivers", raising=False)
    return tmp_path


def test_a_driver_that_dies_in_one_cell_loses_no_other(cortexc: Run, home: Path) -> None:
    """The cell is an error, all others have their verdicts, and all files are written."""
    words = ("suite", "euroncap-2026", "--ego", "python:suite_drivers:dies_at_40", "--only", "CCRs/*/50")
    result = cortexc(*words, "--budget", "8", "--out", "out", "--junit", "j.xml", "--json")
    assert result.code == Exit.BROKEN_LIMIT
    found = {cell["id"]: cell for cell in result.document["groups"][0]["cells"]}
    assert {name for name, cell in found.items() if cell["outcome"] == "error"} == {"CCRs/40/50"}
    assert "not at this speed" in found["CCRs/40/50"]["reason"]
    assert sum(cell["outcome"] == "fail" for cell in found.values()) == 7
    suite = ET.parse(home / "j.xml").getroot().find("testsuite")
    assert suite is not None
    assert (suite.get("tests"), suite.get("failures"), suite.get("errors")) == ("8", "7", "1")
    with (home / "out" / "cells.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["outcome"] for row in rows] == [cell["outcome"] for cell in found.values()]
    assert "CCRs/40/50" in (home / "out" / "report.html").read_text()


def test_a_failure_that_does_not_come_again_is_reported(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A random driver may fail in no run of the search; the failures that are known remain."""
    drivers = importlib.import_module("suite_drivers")
    batches = list[int]()

    def drive(*given: Any) -> Any:
        batches.append(len(given[2].valid))
        monkeypatch.setattr(drivers, "coasting", len(batches) == 2)
        return seeded_runs.drive(*given)

    monkeypatch.setattr(suite_cells, "drive", drive)
    (cell,) = run_suite("euroncap-2026", "python:suite_drivers:coasts_at_times", only=["CCRs/50/50"], budget=8).cells
    assert batches[:2] == [1, 8]
    assert (cell.outcome, cell.failures) == (Outcome.PASS, 8)
    assert cell.deviation is not None
    assert cell.deviation.size > 0.0
    assert cell.deviation.impact > 0.0


def test_an_entry_cell_in_which_the_driver_fails_is_broken(home: Path) -> None:
    """An entry condition may name a group."""
    for path in suite_of("euroncap-2026").folder.iterdir():
        (home / path.name).write_text(path.read_text().replace('entry = ["CCRs/', 'entry = ["CCRs", "CCRs/'))
    driver = "python:suite_drivers:brakes_or_dies_at_40"
    report = run_suite(str(home), driver, only=["CCRs/[34]0/50"], budget=1)
    assert [cell.outcome for cell in report.cells] == [Outcome.PASS, Outcome.ERROR]
    assert report.entry == ("CCRs/40/50",)


def test_the_case_of_a_search_is_a_contact_if_there_is_one(home: Path) -> None:
    """Wide gaps break the following gap without a contact."""
    for path in suite_of("un-r157").folder.iterdir():
        (home / path.name).write_text(path.read_text())
    table = home / "suite.toml"
    text = table.read_text()
    old = '"SPEED GAP" = [[10, 11], [20, 22], [30, 33], [40, 44], [50, 56], [60, 67]]'
    assert old in text
    table.write_text(text.replace(old, "SPEED = [10]\nsearch = { GAP = [31, 36] }"))
    (cell,) = run_suite(str(home), BLIND, only=["following gap"], budget=11).cells
    assert cell.outcome is Outcome.FAIL
    assert cell.contact
    assert cell.impact == pytest.approx(2.0, abs=0.05)


def test_the_settings_of_the_driver_are_in_the_command_and_in_the_replay(cortexc: Run, home: Path) -> None:
    """Both commands give the same results again."""
    words = ("--ego", "python:suite_drivers:coasts", "--only", "CCRs/50/50", "--budget", "2", "--json")
    settings = ("--ego-batch", "7", "--ego-observes", "egocentric")
    document = cortexc("suite", "euroncap-2026", *words, *settings, "--out", "out").document
    (cell,) = document["groups"][0]["cells"]
    assert cell["outcome"] == "fail"
    for command in (document["command"], cell["deviation"]["replay"]):
        assert " ".join(settings) in command
    assert cortexc(*cell["deviation"]["replay"].split()[1:]).code == Exit.FINE


def test_a_group_that_cannot_be_run_is_an_error_in_junit(cortexc: Run, home: Path) -> None:
    """A file with errors, and a driver that does not fit; a failure without a kept case has no replay."""
    cortexc("suite", "un-r152", "--copy", "mine")
    car = home / "mine" / "car.scn"
    car.write_text(car.read_text().replace("TARGET_SPEED,", "TARGT_SPEED,", 1))
    only = ("--only", "car M1", "--only", "pedestrian M1/maximum/20", "--budget", "2", "--junit", "j.xml")
    for driver, code in (
        (BLIND, Exit.DIAGNOSTICS),
        ("EmergencyBrakeBehavior", Exit.DIAGNOSTICS),
        ("EmergencyBrakeBehavior(FollowLaneBehavior(SPED))", Exit.USAGE),
    ):
        result = cortexc("suite", "mine", "--ego", driver, *only, "--json")
        assert result.code == code
        assert not result.document["passed"]
        root = ET.parse(home / "j.xml").getroot()
        suites = {suite.get("name"): suite for suite in root.iter("testsuite")}
        error = suites["car M1"].find("testcase/error")
        assert error is not None
        assert error.get("message")
        assert (suites["car M1"].get("tests"), suites["car M1"].get("errors")) == ("1", "1")
        assert root.get("errors") == str(sum(1 for _ in root.iter("error")))
        for failure in root.iter("failure"):
            assert failure.text
            assert "replay" not in failure.text


def test_a_kept_case_fails_again(cortexc: Run, home: Path) -> None:
    """The case of the least deviation is a scenario of its own with the contact of the table."""
    driver = NEVER.format("0 m/s if VUT_SPEED < 0.5 else 200 km/h")
    result = cortexc("suite", "euroncap-2026", "--ego", driver, "--only", "CPNA day/50/50", "--out", "out", "--json")
    assert result.code == Exit.FINE
    (cell,) = result.document["groups"][0]["cells"]
    case = home / "out" / cell["deviation"]["case"]
    scenario = cx.load(case)
    outcomes = scenario.simulate(scenario.scene_of_seed())
    assert outcomes.collided[0]
    assert outcomes.ego_speed[0, 0] * 3.6 == pytest.approx(cell["deviation"]["impact_speed"], abs=1e-6)
    assert cortexc(*cell["deviation"]["replay"].split()[1:]).code == Exit.FINE


def test_results_depend_neither_on_jobs_nor_on_the_selection(
    cortexc: Run, home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Documents are equal, and a cell has the same numbers alone."""
    driver = NEVER.format("0 m/s if VUT_LATERAL < 0.2 else 200 km/h")
    words = (
        "suite",
        "euroncap-2026",
        "--ego",
        driver,
        "--budget",
        "40",
        "--json",
        "--only",
        "CCRs/50/*",
        "--only",
        "CPFA*",
    )
    one = cortexc(*words, "--only", "CMRs/30/50")
    monkeypatch.setattr(testing, "ALONE", 0.0)
    two = cortexc(*words, "--only", "CMRs/30/50", "--jobs", "2")
    assert json.loads(one.out) == json.loads(two.out)
    alone = cortexc("suite", "euroncap-2026", "--ego", driver, "--budget", "40", "--json", "--only", "CMRs/30/50")
    found = next(group for group in one.document["groups"] if group["name"] == "CMRs")
    assert alone.document["groups"][0]["cells"] == found["cells"]


def test_cells_that_cannot_be_represented_are_listed_and_never_pass(cortexc: Run, home: Path) -> None:
    """A night is counted with its reason; it breaks nothing."""
    words = (
        "suite",
        "euroncap-2026",
        "--ego",
        "EmergencyBrakeBehavior",
        "--only",
        "CPNCO night",
        "--only",
        "CPNCO day/30/50",
    )
    result = cortexc(*words, "--budget", "4")
    assert result.code == Exit.FINE
    assert result.out.startswith("Crash Avoidance - Frontal Collisions 1.2")
    assert "darkness" in result.out
    assert "19 cells: 1 pass, 18 not run" in result.out


def test_a_suite_of_which_no_cell_runs_is_no_success(cortexc: Run, home: Path) -> None:
    assert cortexc("suite", "euroncap-2026", "--ego", "EmergencyBrakeBehavior", "--only", "CPNCO night").code == (
        Exit.NO_SCENE
    )


def test_a_driver_that_leaves_the_road_fails(cortexc: Run, home: Path) -> None:
    """It has no contact, and has not stopped for the target either."""
    words = ("suite", "euroncap-2026", "--ego", "python:suite_drivers:steers", "--only", "CCRs/40/50", "--budget", "2")
    result = cortexc(*words, "--json")
    (cell,) = result.document["groups"][0]["cells"]
    assert result.code == Exit.BROKEN_LIMIT
    assert (cell["outcome"], cell["contact"]) == ("fail", False)
    assert "left the road" in cell["event"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("suite",), "no suite given"),
        (("suite", "un-r1522", "--ego", "EmergencyBrakeBehavior"), "did you mean `un-r152`?"),
        (("suite", "un-r152"), "no driver given"),
        (("suite", "un-r152", "--ego", "EmergencyBrakeBehavior", "--only", "cars*"), "matches no cell"),
        (("suite", "un-r152", "--ego", "EmergencyBreakBehavior"), "did you mean `EmergencyBrakeBehavior`?"),
        (("suite", "un-r152", "--ego", "python:nowhere:drive"), "nowhere"),
        (("suite", "un-r152", "--ego", "some.scn"), "no driver"),
        (("suite", "un-r152", "--ego", "EmergencyBrakeBehavior", "--budget", "0"), "--budget"),
        (("suite", "un-r152", "--ego", "EmergencyBrakeBehavior", "--junit", "no/j.xml"), "there is no folder"),
    ],
)
def test_mistakes_of_the_command_line_end_with_2(
    cortexc: Run, home: Path, words: tuple[str, ...], message: str
) -> None:
    """Nothing runs, and the message has a cure."""
    result = cortexc(*words)
    assert result.code == Exit.USAGE
    assert message in result.said
    assert "help:" in result.said


def test_a_driver_that_does_not_fit_is_refused_with_its_reason(cortexc: Run, home: Path) -> None:
    """All cells are listed as not run; the exit code is that of a missing driver."""
    result = cortexc(
        "suite", "un-r152", "--ego", "EmergencyBrakeBehavior(FollowLaneBehavior(SPED))", "--only", "car M1"
    )
    assert result.code == Exit.USAGE
    assert "SCN201" in result.out
    assert str(home) not in result.out


def test_a_copy_can_be_changed(cortexc: Run, home: Path) -> None:
    """A copied suite runs by its folder; its mistakes are named with place and cure."""
    assert cortexc("suite", "un-r152", "--copy", "mine").code == Exit.FINE
    assert cortexc("suite", "un-r152", "--copy", "mine").code == Exit.FINE
    table = home / "mine" / "suite.toml"
    table.write_text(table.read_text().replace("[10, 20]", "[12]"))
    words = ("suite", "mine", "--ego", "EmergencyBrakeBehavior", "--budget", "2", "--json")
    result = cortexc(*words, "--only", "car M1/*/12")
    assert [cell["id"] for cell in result.document["groups"][0]["cells"]] == [
        "car M1/maximum/12",
        "car M1/running order/12",
    ]
    car = home / "mine" / "car.scn"
    car.write_text(car.read_text().replace("TARGET_SPEED,", "TARGT_SPEED,", 1))
    result = cortexc(*words, "--only", "car M1/*/12", "--only", "pedestrian M1/*/20")
    assert result.code == Exit.DIAGNOSTICS
    groups = {group["name"]: group for group in result.document["groups"]}
    assert groups["car M1"]["diagnostics"]
    assert {cell["outcome"] for cell in groups["pedestrian M1"]["cells"]} == {"pass"}


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("title =", "titel =", "has no `title`"),
        ('file = "car.scn"', 'file = "cars.scn"', "which is not there"),
        ('rule = "limit"', 'rule = "limits"', "`rule` is 'limits'; expected"),
        ('status = "verified"', 'status = "sure"', "`status` is 'sure'; expected"),
        ('impact = "relative"', 'impact = "both"', "`impact` is 'both'; expected"),
        ('impact = "relative"', 'impact = "relative"\nlimit = -5', "`limit` is -5; expected"),
        ('impact = "relative"', 'impact = "relative"\nlimit = inf', "`limit` is inf; expected"),
        ('id = ["LOAD", "SPEED"]', 'id = ["LOAD", "SPED"]', "without `SPED`"),
        ('id = ["LOAD", "SPEED"]', 'id = ["LOAD"]', "two cells are called"),
        ("[[groups]]", "[[group]", "is not valid TOML"),
    ],
)
def test_mistakes_of_a_table_are_named(tmp_path: Path, old: str, new: str, message: str) -> None:
    """The message has the file, the group and the key."""
    source = suite_of("un-r152").folder
    for path in source.iterdir():
        (tmp_path / path.name).write_text(
            path.read_text().replace(old, new) if path.suffix == ".toml" else path.read_text()
        )
    with pytest.raises(SuiteError) as found:
        read_suite(tmp_path)
    assert message in found.value.message
    assert "suite.toml" in found.value.message


def test_a_param_that_no_cell_holds_and_that_excludes_the_nominal_test_is_named(tmp_path: Path) -> None:
    """A deviation must hold 0."""
    source = suite_of("un-r152").folder
    for path in source.iterdir():
        (tmp_path / path.name).write_text(path.read_text().replace("Range(0, 30) km/h", "Range(5, 30) km/h"))
    with pytest.raises(SuiteError, match="TARGET_SPEED"):
        run_suite(str(tmp_path), "EmergencyBrakeBehavior", only=["car M1"], budget=2)


def test_the_rule_expect_needs_a_scenario_with_one(cortexc: Run, home: Path) -> None:
    """Without it every run would pass; the message names the cell and the file."""
    assert cortexc("suite", "un-r157", "--copy", "mine").code == Exit.FINE
    file = home / "mine" / "following.scn"
    words = ("suite", "mine", "--ego", "EmergencyBrakeBehavior", "--budget", "2", "--only", "following gap/10")
    assert cortexc(*words).code in {Exit.FINE, Exit.BROKEN_LIMIT}
    kept = [line for line in file.read_text().splitlines() if not line.startswith("expect")]
    file.write_text("\n".join(kept) + "\n")
    result = cortexc(*words)
    assert result.code == Exit.USAGE
    assert "cell `following gap/10` has the rule `expect`, but following.scn has no `expect`" in result.err
    assert "help:" in result.err


def test_a_workbook_needs_its_package_and_a_folder(
    cortexc: Run, home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Before any cell is run."""
    words = ("suite", "euroncap-2026", "--ego", "EmergencyBrakeBehavior", "--workbook", str(tmp_path / "t.xlsx"))
    assert cortexc(*words).code == Exit.USAGE
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    result = cortexc(*words, "--out", str(tmp_path / "out"))
    assert result.code == Exit.USAGE
    assert "the package `openpyxl`, which is not installed" in result.err
    assert "[workbook]" in result.err


class Sheet:
    """A sheet of a workbook in memory, as openpyxl has them."""

    def __init__(self, rows: list[tuple[str, str]]) -> None:
        self.rows = rows

    def iter_rows(self, **_: object) -> list[tuple[str, str]]:
        """Return the rows."""
        return self.rows


class Book(dict[str, Sheet]):
    """A workbook in memory."""

    @property
    def sheetnames(self) -> list[str]:
        return list(self)


@pytest.mark.parametrize(
    ("version", "said"),
    [("4.1.0", "of version 4.1.0; the colours of version 5.4.9 are known"), (None, "no template of the rating")],
)
def test_a_workbook_of_another_version_is_refused(
    cortexc: Run, home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, version: str | None, said: str
) -> None:
    """By the version that its generator wrote, before any cell is run."""
    sheets = {} if version is None else {"Version": Sheet([("Template version", version)])}
    fake = SimpleNamespace(load_workbook=lambda _: Book(sheets))
    fake.utils = SimpleNamespace(exceptions=SimpleNamespace(InvalidFileException=KeyError))
    monkeypatch.setitem(sys.modules, "openpyxl", fake)
    result = cortexc(
        "suite", "un-r152", "--ego", "EmergencyBrakeBehavior", "--workbook", "t.xlsx", "--out", str(tmp_path / "out")
    )
    assert result.code == Exit.USAGE
    assert said in " ".join(result.err.split())
    assert "generate-template" in result.err


def test_the_list_names_every_suite(cortexc: Run) -> None:
    """With cells, those that can be run, and the edition."""
    result = cortexc("suite", "list", "--json")
    rows = {row["name"]: row for row in result.document["suites"]}
    assert set(rows) == set(suite_names())
    assert all(0 < row["can_be_run"] <= row["cells"] for row in rows.values())
    assert "euroncap-2026" in cortexc("suite", "list").out


# -- UN R157 -----------------------------------------------------------------------------------------------------------


def test_a_cut_in_counts_from_the_intrusion_of_the_regulation() -> None:
    """The share of the lane change at which the tyre is 0.3 m over the marking is that of the quintic of least jerk."""
    text = (suite_of("un-r157").folder / "cut_in.scn").read_text()
    share = float(text.split("intrusion = ")[1].split(" *")[0])
    moved = 10 * share**3 - 15 * share**4 + 6 * share**5
    assert moved == pytest.approx(((3.5 - 1.9) / 2 + 0.3) / 3.5, abs=1e-3)


def test_the_following_gap_is_owed_throughout() -> None:
    """A driver with a headway of 1.6 s keeps it; one of 0.5 s and one that keeps its speed do not."""
    only = ["following gap"]
    assert run_suite("un-r157", "CarFollowingBehavior(EGO_SPEED)", only=only).passed
    for driver in ("CarFollowingBehavior(EGO_SPEED, time_headway=0.5 s, min_gap=0.5 m)", BLIND):
        report = run_suite("un-r157", driver, only=only)
        assert {cell.outcome for cell in report.cells} == {Outcome.FAIL}


def test_cut_ins_that_can_be_avoided_are_avoided_by_a_driver_that_keeps_its_gap_and_no_other() -> None:
    """Scenes in which the regulation does not demand it do not count."""
    only = ["cut-in/40/20", "cut-in/60/10"]
    careful = run_suite("un-r157", "EmergencyBrakeBehavior(CarFollowingBehavior(EGO_SPEED))", only=only, budget=60)
    assert careful.passed
    blind = run_suite("un-r157", BLIND, only=only, budget=60)
    for cell in blind.cells:
        assert cell.outcome is Outcome.FAIL
        assert cell.searched is not None
        assert 0 < cell.searched.failures <= cell.searched.runs < 64
        counts = cell.references["careful"]
        assert set(counts) <= {Answer.AVOIDS, Answer.COLLIDES}
        assert sum(counts.values()) == cell.searched.runs
        assert cell.said["careful"] == f"avoids {counts[Answer.AVOIDS]} of {cell.searched.runs}"


def test_the_heads_of_a_search_name_failures(cortexc: Run, home: Path) -> None:
    """A failure of a search need not be a contact."""
    words = ("suite", "fmvss-127", "--ego", BLIND, "--only", "stopped lead", "--budget", "3")
    result = cortexc(*words)
    assert "no failure in" in result.out
    assert "contacts" not in result.out
    assert cortexc(*words, "--json").document["groups"][0]["cells"][0]["search"]["failures"] == 3


def test_a_cell_that_is_not_run_counts_as_red_in_the_points() -> None:
    """As the page of a suite says."""
    result = cells(run_suite("euroncap-2026", BLIND, only=["CPNCO night/30/50"], budget=1))["CPNCO night/30/50"]
    green = replace(result, outcome=Outcome.PASS, colour=Colour.GREEN)
    assert GroupResult("a", (result, green), {"standard": 1.0}).score("standard") == 0.5


# -- drivers that cannot be named, that end the process, or that are not deterministic ---------------------------------


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--ego", "EmergencyBrakeBehavior", "--budget", "0"), "--budget is `0`, and at least one run is needed"),
        (("--ego", ""), "the name of a driver is empty"),
        (("--ego", "  "), "the name of a driver is empty"),
        (("--ego", "process:/nonexistent"), "`/nonexistent` cannot be started: no such file or directory"),
        (("--ego", "process:/etc/passwd --fast"), "`/etc/passwd` cannot be started: it is not executable"),
    ],
)
def test_a_driver_that_names_nothing_is_a_wrong_command_line(cortexc: Run, words: tuple[str, ...], said: str) -> None:
    """The command ends before a cell runs, with the reason and a cure."""
    result = cortexc("suite", "un-r152", "--only", "car M1/maximum/10", *words)
    assert result.code == Exit.USAGE
    assert said in result.said
    assert "help:" in result.err
    assert not result.out


@pytest.mark.parametrize(
    ("driver", "place"),
    [
        ("EmergencyBrakeBehavior(FollowLaneBehavior(EGO_SPED))", "character 43 (`EGO_SPED`): SCN201"),
        ("EmergencyBrakeBehavior(FollowLaneBehavior(EGO_SPEED), treshold=1 s)", "character 55 (`treshold"),
        ("EmergencyBrakeBehavior(FollowLaneBehavior(EGO_SPEED) delay=1 s)", "character "),
    ],
)
def test_a_mistake_in_the_text_of_a_behavior_has_its_place(cortexc: Run, driver: str, place: str) -> None:
    """The place is that in the text of `--ego`, which the reader can see."""
    result = cortexc("suite", "un-r152", "--only", "car M1/maximum/10", "--ego", driver, "--json")
    assert result.code == Exit.USAGE
    refusal = result.document["groups"][0]["refusal"]
    assert place in refusal
    number = int(refusal.split("character ")[1].split(" ")[0].rstrip(":"))
    assert 1 <= number <= len(driver) + 1


def test_a_budget_of_time_that_the_least_work_exceeds_is_stated(cortexc: Run) -> None:
    """The nominal tests run whatever the budget is; the screen and the document say that they took longer."""
    words = ("suite", "un-r152", "--only", "car M1/maximum/[1-4]0", "--ego", "EmergencyBrakeBehavior", "--budget")
    (remark,) = cortexc(*words, "0.001s", "--json").document["remarks"]
    assert "more than --budget 0.001s" in remark
    assert "more than --budget 0.001s" in " ".join(cortexc(*words, "0.001s").out.split())
    assert cortexc(*words, "40", "--json").document["remarks"] == []


ODD_DRIVERS = """
import os

import numpy as np

ACTION = {"brakes": [0.0, 1.0, 0.0], "coasts": [0.0, 0.0, 0.0]}
calls = 0


def alternates(observations):
    \"\"\"Each block of scenes otherwise than the one before.\"\"\"
    global calls
    calls += 1
    return np.tile([0.0, 1.0 - 1e-6 * calls, 0.0], (len(observations), 1))


def passes_once(observations):
    \"\"\"The first test of a single scene brakes, all later ones do not.\"\"\"
    global calls
    if (len(observations) == 1 or calls) and (np.asarray(observations)[:, 0] > 0.0).any():
        calls += 1
    return np.tile(ACTION["brakes" if calls < 60 else "coasts"], (len(observations), 1))


def brakes(observations):
    return np.tile(ACTION["brakes"], (len(observations), 1))


def ends_the_process(observations):
    os._exit(7)
"""


@pytest.fixture
def odd(home: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (home / "odd_drivers.py").write_text(ODD_DRIVERS)
    monkeypatch.delitem(sys.modules, "odd_drivers", raising=False)
    return home


def test_a_driver_that_is_not_deterministic_is_named(cortexc: Run, odd: Path) -> None:
    """Each nominal test is driven twice; one that is driven otherwise is counted, on the screen and in all files."""
    words = ("suite", "un-r152", "--only", "car M1/maximum/[12]0", "--budget", "4", "--jobs", "1")
    document = cortexc(*words, "--ego", "python:odd_drivers:alternates", "--json", "--out", "out").document
    (remark,) = document["remarks"]
    assert "not deterministic: it drives 2 of 2 nominal tests otherwise the second time" in remark
    assert "not deterministic" in (odd / "out" / "report.html").read_text()
    assert cortexc(*words, "--ego", "python:odd_drivers:brakes", "--json").document["remarks"] == []


def test_a_cell_that_passes_once_and_fails_next_fails(odd: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The worse of both drives of the nominal test is its verdict."""
    drivers = importlib.import_module("odd_drivers")
    singles = list[int]()

    def drive(*given: Any) -> Any:
        if len(given[2].valid) == 1:
            singles.append(1)
        monkeypatch.setattr(drivers, "calls", 0 if len(singles) < 2 else 1000)
        return seeded_runs.drive(*given)

    monkeypatch.setattr(suite_cells, "drive", drive)
    report = run_suite("un-r152", "python:odd_drivers:passes_once", only=["car M1/maximum/20"], budget=1)
    (cell,) = report.cells
    assert cell.outcome is Outcome.FAIL
    assert cell.contact
    assert report.groups[0].otherwise == ("car M1/maximum/20",)


def test_a_driver_that_ends_its_process_loses_its_groups_only(cortexc: Run, odd: Path) -> None:
    """With several processes its cells are errors with the reason, and all files are written."""
    words = ("suite", "un-r152", "--only", "car M1/maximum/10", "--only", "pedestrian M1/maximum/20", "--budget", "2")
    driver = ("--ego", "python:odd_drivers:ends_the_process", "--jobs", "2")
    result = cortexc(*words, *driver, "--out", "out", "--json")
    assert result.code == Exit.BROKEN_LIMIT
    found = [cell for group in result.document["groups"] for cell in group["cells"]]
    assert {cell["outcome"] for cell in found} == {"error"}
    assert all("process of this group ended" in cell["reason"] for cell in found)
    assert (odd / "out" / "cells.csv").exists()


def test_groups_whose_process_does_not_end_keep_their_results(tmp_path: Path) -> None:
    """After a process ended, groups without a result run again, each in a process of its own."""
    plan = suite_cells.SuitePlan(side_of("EmergencyBrakeBehavior"), budget_of(1), jobs=2)
    jobs = ["one", "dies", "two", "three"]
    found = testing.results_of_files(ends_or_not, jobs, plan, 0.0, None, None, lambda name: f"lost {name}")
    assert list(found) == ["one", "lost dies", "two", "three"]


def ends_or_not(name: str, *_given: Any) -> str:
    """Return the name; `dies` ends the process."""
    import os

    if name == "dies":
        os._exit(3)
    return name
