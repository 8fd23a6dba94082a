"""The page of a study: its numbers are the study's, and it opens without errors."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cortex_dsl.cli import main
from cortex_dsl.report.findings.paper_metrics import METRICS
from cortex_dsl.report.findings.study_report import BOXED
from engine.study.database import Study, read_study
from engine.study.verdict import FAMILIES, RULE, findings

from .conftest import HOSTILE, SCENARIO, Reader, missing_numbers

EXAMPLE = Path(__file__).parents[4] / "examples" / "left_turn.scn"


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


SAID_OF_ALL = (
    RULE.partition(" ")[2],
    FAMILIES.partition(" ")[2],
    "below 0.05, 0.01, 0.001",
    "95 %",
    "A12 above 0.5",
    "A12",
)
"""What a page says of every study: the numbers in it are no findings."""


def test_every_number_of_the_page_stands_in_its_data(study_folder: Path, study_file: Path) -> None:
    """Whoever reads the JSON misses nothing that the page says."""
    reader, text = Reader(), study_file.read_text(encoding="utf-8")
    reader.feed(text)
    page = text.replace(str(study_folder), "")
    assert missing_numbers(page, json.loads(reader.blocks["study"]), SAID_OF_ALL) == []


def test_figures_of_a_study(study_folder: Path, study: Study, tmp_path: Path) -> None:
    """Curves of the five metrics and boxes of every measure shown, in three formats, with the medians of the study."""
    pytest.importorskip("matplotlib")
    assert main(["report", str(study_folder), "--figures", str(tmp_path)]) == 0
    names = {path.name for path in tmp_path.iterdir()}
    assert {"curves-rl.svg", "curves-nis.pdf", "boxes-colliding-genomes.png", "boxes-rl.svg"} <= names
    assert len(names) == 3 * (len(METRICS) + len(BOXED))
    assert all(path.stat().st_size > 1000 for path in tmp_path.iterdir())
    assert "colliding genomes" in (tmp_path / "boxes-colliding-genomes.svg").read_text(encoding="utf-8")


def test_every_link_of_the_top_leads_somewhere(study_file: Path) -> None:
    reader = Reader()
    reader.feed(study_file.read_text(encoding="utf-8"))
    names = {attributes["id"] for _, attributes in reader.tags if "id" in attributes}
    links = [href[1:] for _, attributes in reader.tags if (href := attributes.get("href") or "").startswith("#")]
    assert "primary" in links
    assert "paper" not in links  # of other scenarios than the paper's
    assert set(links) <= names


def test_intervals_do_not_collapse(study: Study) -> None:
    """Three runs can tell nothing to two decimals, however clear they are."""
    rows = findings(study.plan, study.records).comparisons
    assert all(row.interval.high - row.interval.low > 0.2 for row in rows if row.interval.low == row.interval.low)


def test_beside_the_paper(opened_tab: Callable[..., Any], tmp_path: Path) -> None:
    """Where scenario, methods and budget are the paper's: its numbers, what differs in words, within 800 pixels."""
    words = ["--runs", "1", "--jobs", "1", "--out", str(tmp_path / "s"), "--json"]
    assert main(["study", str(EXAMPLE), *words]) == 0
    assert main(["report", str(tmp_path / "s"), "--figures", str(tmp_path / "figures")]) == 0
    assert {"paper-curves.svg", "paper-boxes.svg"} <= {path.name for path in (tmp_path / "figures").iterdir()}
    assert "left_turn, genetic" in (tmp_path / "figures" / "paper-curves.svg").read_text(encoding="utf-8")
    assert main(["report", str(tmp_path / "s")]) == 0
    tab = opened_tab(tmp_path / "s" / "report.html", 800, 800)
    assert "point the same way as in the paper" in tab.inner_text("#paper")
    assert tab.inner_text("#paper .studies tbody tr:last-child").startswith("this study")
    assert "13.30" in tab.inner_text("#paper .beside")
    assert "not reproduced: " in tab.inner_text("#paper")
    assert tab.locator("#layout .chart .course").count() == 2 * len(METRICS)  # one scenario, two methods
    assert tab.locator("#layout .chart .course.dashed").count() == len(METRICS)
    assert tab.locator("#layout .chart .boxed").count() == 2 * 2 * len(METRICS)  # all scenarios, and the one
    fits = "boxes => boxes.every(box => box.scrollWidth <= box.clientWidth)"
    assert tab.eval_on_selector_all("#paper .wide", fits)


def test_opens_in_a_browser(opened_tab: Callable[..., Any], study_file: Path) -> None:
    """Without errors, and no wider than a narrow screen."""
    tab = opened_tab(study_file, 390, 800)
    assert tab.evaluate("document.documentElement.scrollWidth <= innerWidth")
