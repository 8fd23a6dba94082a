"""What an export and a measurement show, whole, and the lines of a road that was read.

`UPDATE_GOLDEN=1 pytest` on this file writes the files it compares with, to be read before they are kept.
"""

import io
import os
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from rich.console import Console, RenderableType

from cortex_dsl.interchange.formats import FORMATS, Gathered, checked_of
from cortex_dsl.report.findings.interchange_report import MeasuredReport, Written, road_outline
from cortex_dsl.report.terminal import render
from cortex_dsl.report.terminal.export_view import export_view
from cortex_dsl.report.terminal.theme import THEME
from cortex_dsl.report.views.recordings import measured_view
from engine.interchange import Recording
from engine.interchange.contract import ExportOptions, Finding
from engine.interchange.measuring import measure
from engine.interchange.opendrive import write_opendrive
from engine.maps import RoadSpec
from engine.opendrive.read import read_opendrive
from engine.opendrive.roads import OdrNetwork
from engine.tables import Floats
from tests.engine.interchange.commonroad.recordings import ORIGIN, ROAD, crash

GOLDEN = Path(__file__).parent / "golden"
WIDTH = 80


def rendered(view: RenderableType) -> str:
    console = Console(file=io.StringIO(), theme=THEME, width=WIDTH, color_system=None, highlight=False, markup=False)
    console.print(view, crop=False)
    assert isinstance(console.file, io.StringIO)
    return "".join(f"{line.rstrip()}\n" for line in console.file.getvalue().splitlines())


def assert_golden(name: str, text: str) -> None:
    file = GOLDEN / name
    if os.environ.get("UPDATE_GOLDEN"):
        GOLDEN.mkdir(exist_ok=True)
        file.write_text(text, encoding="utf-8")
    assert text == file.read_text(encoding="utf-8")


def exported(findings: list[Finding] | None, checked: dict[str, str]) -> Written:
    """Two cases in two formats, one file of them there before."""
    names = ["two_cars-case01", "two_cars-case02"]
    cases: list[Any] = [
        SimpleNamespace(rank=rank, recording=replace(crash(), name=name)) for rank, name in enumerate(names, 1)
    ]
    files = {f"{name}.{ending}": b"x" * size for name in names for ending, size in (("xosc", 36_012), ("csv", 812))}
    gathered = Gathered(
        files={**files, "two_cars.xodr": b"x" * 1_234_567},
        formats={**{file: file.rpartition(".")[2] for file in files}, "two_cars.xodr": "xosc"},
        names=[[file for file in files if file.startswith(name)] for name in names],
        remarks={
            ("csv", "names are not in the table, only numbers: 0 ego, 1 car_1"): [0, 1],
            ("xosc", "what follows first contact at 0.230 s is contact physics, replayed as it was"): [0],
            ("xosc", "what follows first contact at 0.317 s is contact physics, replayed as it was"): [1],
            ("xosc", "not there from the beginning: car_1"): [1],
        },
    )
    return Written(cases, gathered, Path("runs/x/exports"), frozenset({"two_cars.xodr"}), findings, checked, OPENED)


OPENED = {name: kind.opened for name, kind in FORMATS.items()}
FOUND = [Finding("two_cars-case01.csv, ego", "the place at 0.100 s is 0.5 off", "export it again")]


@pytest.mark.parametrize(
    ("name", "findings", "mode"),
    [("exported", None, "trajectory"), ("checked", [], "maneuver"), ("found", FOUND, "trajectory")],
)
def test_an_export(name: str, findings: list[Finding] | None, mode: str) -> None:
    """Files, what opens them, what is left out, and what a check looked at: nothing was, where none was asked for."""
    checked = {} if findings is None else {format_: checked_of(format_, mode) for format_ in ("xosc", "csv")}
    assert_golden(f"{name}.txt", rendered(export_view(exported(findings, checked), ExportOptions(mode=mode))))


@pytest.fixture
def road(tmp_path: Path) -> OdrNetwork:
    path = tmp_path / "road.xodr"
    path.write_text(write_opendrive(RoadSpec(ways=3, approach=20.0), None, "road", ORIGIN))
    return read_opendrive(path)


def measured(recording: Recording, road: OdrNetwork) -> MeasuredReport:
    return MeasuredReport(
        file="case.xosc",
        recording=recording,
        measured=measure(recording),
        profile="paper",
        remarks=("its traffic lights are not taken over",),
        road=road,
        lines=road_outline(road),
        again="cortexc import case.xosc",
        written=("case.csv",),
    )


def test_a_measurement(road: OdrNetwork) -> None:
    """Head-on at 18 km/h each, with what the file says of itself and of its params."""
    assert crash().road == ROAD
    assert_golden("measured.txt", rendered(render.rendered(measured_view(measured(crash(), road)), WIDTH)))


def test_the_lines_of_a_road(road: OdrNetwork) -> None:
    """Kerbs and middle line of each road between junctions, from its begin to its end."""
    lines = road_outline(road)
    kerbs = [f"kerb    {_ends(line)}" for line in lines.kerbs]
    assert_golden("road_lines.txt", "\n".join([*kerbs, *(f"middle  {_ends(each)}" for each in lines.middle_lines), ""]))


def _ends(line: Floats) -> str:
    (x, y), (to_x, to_y) = (line[0] + 0.0).round(3).tolist(), (line[-1] + 0.0).round(3).tolist()
    return f"{len(line)} points from ({x:g}, {y:g}) to ({to_x:g}, {to_y:g})"
