"""The page of a run: its numbers are the journal's, its names do no harm, and it needs nothing from outside."""

import json
import re
import sys
from dataclasses import asdict
from itertools import accumulate
from math import isnan
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cortex_dsl.api.runs import OpenedRun
from cortex_dsl.cli import main
from cortex_dsl.report.findings.analysis_report import DRIVER, JUDGED
from cortex_dsl.report.page.analysis_sections import KINDS
from cortex_dsl.report.page.player import SCRIPTS
from cortex_dsl.report.page.run_sections import STREAMS, how_runs_ended
from engine.search.evaluations import distinct_collisions, figures
from engine.search.insight.kinds import PACES, failures
from engine.vocabulary import State

from .conftest import missing_numbers

pytestmark = pytest.mark.usefixtures("small_design")


def test_every_figure_is_the_journals(read, opened: OpenedRun) -> None:
    """Each number with a name has the value that the journal gives under that name."""
    evaluations = opened.record.evaluations
    everyone = figures(evaluations, np.ones(len(evaluations), dtype=bool))
    truth = {f"by_individual.{name}": value for name, value in asdict(everyone).items()}
    simulated = figures(evaluations, evaluations.simulated)
    truth |= {f"by_simulation.{name}": value for name, value in asdict(simulated).items()}
    truth |= {"distinct_collisions": distinct_collisions(evaluations), "worst.score": int(evaluations.score.max())}
    truth["distinct_finds"] = truth["distinct_collisions"]
    truth |= {f"failures.{name}": value for name, value in asdict(failures(evaluations, opened.blame)).items()}
    for case in opened.first_cases(3):
        truth |= {f"case.{case.rank}.score": case.score, f"case.{case.rank}.min_distance": case.min_distance}
    assert len(read.figures) > 15
    for name, shown in read.figures.items():
        for value, _ in shown:
            assert value == truth[name] or (isnan(value) and isnan(truth[name])), name


def test_figures_are_read_as_they_are_shown(read) -> None:
    """The first number in the text of each figure is its value, rounded."""
    for name, shown in read.figures.items():
        for value, text in shown:
            number = re.search(r"-?[\d,]+(\.\d+)?", text)
            if number is None:
                assert text == "–"
                assert isnan(value)
                continue
            decimals = len((number.group(1) or ".")[1:])
            assert float(number.group().replace(",", "")) == pytest.approx(value, abs=0.51 * 10**-decimals), name


def test_embedded_numbers_equal_the_journal(read, opened: OpenedRun) -> None:
    """The data block holds the generations and cases of the journal, to the last bit."""
    block = json.loads(read.blocks["run"])
    record = opened.record
    assert block["program_digest"] == record.manifest.program_digest
    for row, truth in zip(block["generations"], record.generations, strict=True):
        for group in ("by_individual", "by_simulation"):
            for name, value in asdict(getattr(truth, group)).items():
                assert row[group][name] == (None if isnan(value) else value)
    for row in block["cases"]:
        assert row["genome"] == record.evaluations.genomes[row["row"]].tolist()
        assert row["key"] == record.evaluations.keys[row["row"], row["rollout"]].tolist()


SAID_OF_ALL = (
    DRIVER,
    KINDS,
    STREAMS,
    JUDGED,
    *PACES,
    "0.25× 0.5× 1× 2× 4×",
    "(95 % interval of Clopper and Pearson)",
    "brackets 95 %",
)
"""What a page says of every run: the numbers in it are no findings."""


def test_every_number_of_the_page_stands_in_its_data(read, page_text: str, opened: OpenedRun) -> None:
    """Whoever reads the JSON misses nothing that the page says; durations are told apart, in other units."""
    page = re.sub(r"It took [^.]*(\.\d)?[^.]*\.", "", page_text)
    for path in (opened.folder, opened.folder.parent):
        page = page.replace(str(path), "")
    assert missing_numbers(page, json.loads(read.blocks["run"]), SAID_OF_ALL) == []


def test_named_figures_are_found_by_their_names(read) -> None:
    """The name of a figure is its place in the data; those of a case stand under its rank."""
    data = json.loads(read.blocks["run"])
    data["case"] = {str(case["rank"]): case for case in data["cases"]}
    for name, shown in read.figures.items():
        value: Any = data
        for step in name.split("."):
            value = value[step]
        assert all(value == number or (value is None and isnan(number)) for number, _ in shown), name


def test_replays_are_the_simulation(read, opened: OpenedRun) -> None:
    """Positions unpacked from the page are those of the scene run again, to half a centimetre."""
    replays = json.loads(read.blocks["replays"])
    for case, replay in zip(opened.first_cases(3), replays, strict=True):
        run = opened.scenario.watch(opened.scenario.scene(case))
        assert replay["samples"] == len(run.trajectory.time)
        assert replay["contact"] == run.trajectory.contact_sample
        for number, actor in enumerate(replay["actors"]):
            states = run.trajectory.states[:, number]
            there = states[:, State.PRESENT] > 0.5
            x = list(accumulate(step for step in actor["x"] if step is not None))
            assert np.array(x) / 100.0 == pytest.approx(states[there, State.X], abs=0.0051)


def test_replayed_cases_have_the_journals_outcome(opened: OpenedRun) -> None:
    """What the page plays collides exactly where the journal says so."""
    for case in opened.first_cases(3):
        run = opened.scenario.watch(opened.scenario.scene(case))
        assert bool(run.outcomes.collided[0]) == case.collided
        assert run.outcomes.min_distance.min() == pytest.approx(case.min_distance, abs=1e-6)


def test_hostile_names_stay_text(read, page_text: str) -> None:
    """Neither the name of the scenario, nor its description, nor a requirement becomes markup."""
    assert not [tag for tag, attributes in read.tags if "onerror" in attributes]
    assert not re.search(r"<script[^>]*>\s*alert", page_text)
    assert sum(tag == "script" for tag, _ in read.tags) == 3 + 1 + len(SCRIPTS)
    assert "&lt;img src=x onerror=alert(1)&gt;" in page_text


def test_page_needs_no_network(read, page_text: str) -> None:
    """No element asks for anything outside the file."""
    for tag, attributes in read.tags:
        assert tag not in ("link", "img", "iframe")
        assert "src" not in attributes
        assert (attributes.get("href") or "#").startswith("#")
    assert "@import" not in page_text
    assert "url(" not in page_text


def test_ends_add_up(opened: OpenedRun) -> None:
    """Each distinct simulation is counted in one row of the ends."""
    rows, whole = how_runs_ended(opened)
    assert sum(count for _, count, _ in rows) == whole == int(opened.record.evaluations.simulated.sum())


def test_command_writes_the_page(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`cortexc report` writes a file, says where, and the same journal gives the same bytes."""
    path = tmp_path / "page.html"
    assert main(["report", str(folder), "--out", str(path), "--cases", "2"]) == 0
    assert capsys.readouterr().out.strip() == str(path)
    first = path.read_bytes()
    assert main(["report", str(folder), "--out", str(path), "--cases", "2"]) == 0
    assert path.read_bytes() == first
    assert len(first) < 3_000_000


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["report"], "which run?"),
        (["report", "nowhere"], "there is no"),
        (["replay"], "replay what?"),
        (["replay", "nowhere"], "there is no"),
        (["replay", "nowhere.scn"], "there is no file"),
        (["replay", "x", "--to", "x.mov"], "a film or a picture"),
        (["replay", "x.scn", "--case", "2"], "--case has no effect on a scenario, which has no cases"),
        (["replay", "x", "--speed", "0"], "must be a factor"),
    ],
)
def test_slips_are_reported(words: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    """A wrong command line ends with 2, a message and no traceback."""
    assert main(words) == 2
    said = capsys.readouterr().err
    assert message in said
    assert "Traceback" not in said


def test_unwritable_page_is_reported(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A page that cannot be written is the user's to mend."""
    assert main(["report", str(folder), "--out", str(tmp_path / "no" / "page.html"), "--cases", "0"]) == 2
    assert "cannot write" in capsys.readouterr().err


def test_figures_for_papers(folder: Path, tmp_path: Path) -> None:
    """`--figures` writes each figure as SVG, PNG and PDF."""
    pytest.importorskip("matplotlib")
    words = ["--out", str(tmp_path / "page.html"), "--cases", "0", "--figures", str(tmp_path / "figures")]
    assert main(["report", str(folder), *words]) == 0
    names = {path.name for path in (tmp_path / "figures").iterdir()}
    assert {"course.svg", "course.png", "course.pdf", "params-1.svg", "case-1.pdf"} <= names
    assert all(path.stat().st_size > 2000 for path in (tmp_path / "figures").iterdir())


def test_missing_extra_has_a_cure(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Without Pillow a film is refused with the command that installs it."""
    monkeypatch.setitem(sys.modules, "PIL.Image", None)
    assert main(["replay", str(folder), "--to", str(tmp_path / "film.gif")]) == 2
    assert "[report]" in capsys.readouterr().err


ODD = {
    "nobody else": """
map intersection(ways=4, lanes=1, lane_width=3.5 m, corner_radius=6 m, approach=50 m)
param KIND = Uniform(1, 2, 3)
lane = Uniform(*intersection.incomingLanes)
ego = new Car at (new OrientedPoint in lane.centerline), with speed KIND * 3 m/s
terminate after 3 s
""",
    "nothing valid": """
map intersection(ways=4, lanes=1, lane_width=3.5 m, corner_radius=6 m, approach=50 m)
param NEAR = Range(1, 2) m
lane = Uniform(*intersection.incomingLanes)
ego = new Car at (new OrientedPoint in lane.centerline)
other = new Car at (new OrientedPoint in lane.centerline)
require (distance from ego to other) < NEAR
terminate after 3 s
""",
}


@pytest.mark.parametrize("what", ODD)
def test_searches_that_find_nothing_have_a_page(what: str, tmp_path: Path) -> None:
    """A page says so in words, and shows no number that is none."""
    file, run = tmp_path / "odd.scn", tmp_path / "run"
    file.write_text(ODD[what], encoding="utf-8")
    main([str(file), "--random", "--generations", "2", "--population", "8", "--out", str(run), "--json"])
    assert main(["report", str(run)]) == 0
    text = (run / "report.html").read_text(encoding="utf-8")
    words = {"nobody else": "the ego was alone", "nothing valid": "no scene met the requirements"}
    assert words[what] in text
    assert not re.search(r">[^<]*\b(nan|inf|None)\b[^<]*<", text.split("<script", maxsplit=1)[0].split("</style>")[-1])


def test_the_mean_is_of_what_was_sought(tmp_path: Path) -> None:
    """Of a search for something else than the risk it is not called one."""
    file, run = Path(__file__).parents[4] / "examples" / "left_turn.scn", str(tmp_path / "run")
    small = ["--generations", "2", "--population", "10", "--seed", "1"]
    assert main([str(file), "--ga", "--objective", "conflict", *small, "--out", run]) == 0
    assert main(["report", run]) == 0
    page = (tmp_path / "run" / "report.html").read_text(encoding="utf-8")
    assert "mean conflict of a valid simulation" in page
    assert "mean risk of" not in page
