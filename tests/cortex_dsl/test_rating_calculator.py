"""Points of `euroncap-2026` by Euro NCAP's own calculator, a separate program (`euroncap-rating-2026`).

The tests are skipped where it is not installed: `EURONCAP_RATING` names its executable, or the path has it.
"""

import json
import os
import random
import shutil
import subprocess
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from cortex_dsl.api.suite_tables import Group, suite_of
from cortex_dsl.api.suites import run_suite
from cortex_dsl.report.findings.suite_report import CellResult, GroupResult, Outcome, SuiteReport
from cortex_dsl.report.gates.suite_workbook import filled, template_of
from engine.gates.ratings import COLOURS, EXTENDED, STANDARD, Colour
from tests.laws import share

SCRIPT = Path(__file__).parents[1] / "engine" / "rating_calculator.py"
PROGRAM = os.environ.get("EURONCAP_RATING") or shutil.which("euroncap_rating_2026")
Judge = Callable[[list[Mapping[str, str]]], list[Mapping[str, tuple[float, float]]]]

pytestmark = pytest.mark.skipif(PROGRAM is None, reason="euroncap-rating-2026 is not installed")


@pytest.fixture(scope="module")
def template(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a template that the calculator generates."""
    assert PROGRAM is not None
    folder = tmp_path_factory.mktemp("calculator")
    subprocess.run([PROGRAM, "crash_avoidance", "generate-template"], cwd=folder, check=True, capture_output=True)
    return folder / "ca_template.xlsx"


@pytest.fixture(scope="module")
def judge(template: Path) -> Judge:
    """Return a function that asks the calculator for the points of colourings, of its template or another workbook."""
    assert PROGRAM is not None
    python = Path(PROGRAM).parent / "python"

    def points(
        colourings: list[Mapping[str, str]], workbook: Path = template
    ) -> list[Mapping[str, tuple[float, float]]]:
        words = [str(python), str(SCRIPT), str(workbook)]
        done = subprocess.run(words, input=json.dumps(colourings), capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr[-2000:]
        return json.loads(done.stdout)

    return points


def rated() -> list[Group]:
    """Return the groups of the suite that have points; the others are no scenarios of the calculator."""
    return [group for group in suite_of("euroncap-2026").groups if group.points]


def ours(report: SuiteReport) -> dict[str, tuple[float, float]]:
    """Return our points of each scenario."""
    return {
        group.name: (group.score(STANDARD) or 0.0, group.score(EXTENDED) or 0.0)
        for group in report.groups
        if group.points
    }


def coloured(colours: Mapping[str, Colour]) -> dict[str, tuple[float, float]]:
    """Return our points of a colouring of all cells."""
    found = {}
    for group in rated():
        cells = tuple(
            CellResult(**{**blank(cell.id), "range": cell.range, "colour": colours[cell.id]}) for cell in group.cells
        )
        result = GroupResult(group.name, cells, group.points)
        found[group.name] = (result.score(STANDARD) or 0.0, result.score(EXTENDED) or 0.0)
    return found


def blank(name: str) -> dict[str, object]:
    """Return the fields of a cell that points do not depend on."""
    texts = dict.fromkeys(("group", "rule", "source", "status"), "")
    return {"id": name, "params": {}, "limit": 0.0, "outcome": Outcome.PASS, **texts}


def test_random_colourings_have_the_points_of_the_calculator(judge: Judge) -> None:
    """In every scenario, with few, some and many cells of each colour."""
    draw, cells = random.Random(7), [cell for group in rated() for cell in group.cells]
    colourings = []
    for _ in range(share(100)):
        weights = [draw.random() ** 3 for _ in COLOURS]
        colourings.append({cell.id: draw.choices(COLOURS, weights)[0] for cell in cells})
    for colouring, theirs in zip(colourings, judge(colourings), strict=True):
        found = coloured(colouring)
        assert found.keys() == theirs.keys()
        for name, points in found.items():
            assert points == pytest.approx(tuple(theirs[name]), abs=1e-9), name


def test_the_points_of_a_run_are_those_of_the_calculator(judge: Judge) -> None:
    """A brake that is a little late has cells of several colours; cells that are not run count as red."""
    driver = "EmergencyBrakeBehavior(FollowLaneBehavior(EGO_SPEED), reference_deceleration=8.5 m/s^2, delay=0.1 s)"
    report = run_suite("euroncap-2026", driver, budget=1)
    colours = {cell.id: cell.colour or Colour.RED for group in report.groups if group.points for cell in group.cells}
    assert len(set(colours.values())) > 3
    (theirs,) = judge([colours])
    found = ours(replace(report, entry=()))
    for name, points in found.items():
        assert points == pytest.approx(tuple(theirs[name]), abs=1e-9), name


def filled_from(report: SuiteReport, template: Path, folder: Path) -> Path:
    """Return a copy of the template with the colours of a report."""
    path = folder / template.name
    path.write_bytes(filled(template_of(template), report))
    return path


def test_a_filled_workbook_has_the_points_of_the_report(
    judge: Callable[..., Any], template: Path, tmp_path: Path
) -> None:
    """The calculator reads the colours of a run from its own template."""
    pytest.importorskip("openpyxl")
    driver = "EmergencyBrakeBehavior(FollowTrajectoryBehavior(EGO_SPEED, EGO_PATH), delay=0.1 s)"
    report = run_suite("euroncap-2026", driver, budget=1)
    (theirs,) = judge([{}], filled_from(report, template, tmp_path))
    for name, points in ours(replace(report, entry=())).items():
        assert points == pytest.approx(tuple(theirs[name]), abs=1e-9), name


def test_a_part_of_a_suite_fills_its_cells_alone(template: Path, tmp_path: Path) -> None:
    """Choices of other cells stay empty."""
    openpyxl = pytest.importorskip("openpyxl")
    report = run_suite("euroncap-2026", "EmergencyBrakeBehavior", budget=1, only=["CCRs/20/50"])
    books = (template, filled_from(report, template, tmp_path))
    sheets = [openpyxl.load_workbook(each)["FC - Car & PTW pred."] for each in books]
    before, after = ({cell.coordinate: cell.value for row in sheet for cell in row} for sheet in sheets)
    assert {place: after[place] for place in after if after[place] != before[place]} == {"G4": "Green"}
