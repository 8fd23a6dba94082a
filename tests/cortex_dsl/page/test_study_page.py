"""The page of a study: its numbers are the study's, and it opens without errors."""

import json
from pathlib import Path
from typing import Any

import pytest

from cortex_dsl.cli import main
from engine.study.findings import findings
from engine.study.reading import Study, read_study

from .conftest import HOSTILE, SCENARIO, Reader


@pytest.fixture(scope="module")
def study_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three runs of two methods on one scenario."""
    home = tmp_path_factory.mktemp("study")
    file = home / f"{HOSTILE}.scn"
    file.write_text(SCENARIO, encoding="utf-8")
    words = ["--runs", "3", "--generations", "4", "--population", "15", "--jobs", "1", "--out", str(home / "study")]
    assert main(["study", str(file), *words, "--json"]) == 0
    return home / "study"


@pytest.fixture(scope="module")
def study_file(study_folder: Path) -> Path:
    path = study_folder / "report.html"
    assert main(["report", str(study_folder)]) == 0
    return path


@pytest.fixture(scope="module")
def study(study_folder: Path) -> Study:
    return read_study(study_folder)


def test_figures_are_the_studys(study: Study, study_file: Path) -> None:
    """Each named median is that of the study, and the embedded tests are its tests."""
    reader = Reader()
    reader.feed(study_file.read_text(encoding="utf-8"))
    found = findings(study.plan, study.records)
    truth = {f"{r.scenario}.{r.method}.{r.measure.name}.median": r.spread.median for r in found.comparisons}
    assert len(reader.figures) > 10
    for name, shown in reader.figures.items():
        for value, _ in shown:
            assert value == truth[name] or (value != value and truth[name] != truth[name])
    assert len(json.loads(reader.blocks["study"])["tests"]) == len(found.comparisons)
    assert not [tag for tag, attributes in reader.tags if "onerror" in attributes]


def test_figures_of_a_study_are_refused(study_folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`--figures` draws a run; for a study the message says what to do."""
    assert main(["report", str(study_folder), "--figures", "x"]) == 2
    assert "this is a study" in capsys.readouterr().err


def test_opens_in_a_browser(chromium: Any, study_file: Path) -> None:
    """Without errors, and no wider than a narrow screen."""
    tab = chromium.new_page(viewport={"width": 390, "height": 800})
    troubles: list[str] = []
    tab.on("console", lambda message: troubles.append(message.text))
    tab.on("pageerror", lambda error: troubles.append(str(error)))
    tab.goto(study_file.as_uri())
    assert tab.evaluate("document.documentElement.scrollWidth <= innerWidth")
    tab.close()
    assert troubles == []
