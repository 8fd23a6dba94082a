"""A single run, a sample and a search, as a user meets them."""

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from engine.search.store import StoreError

Command = Callable[..., Any]
Scenario = Callable[..., Path]

SMALL = ("--generations", "3", "--population", "12")


def test_run_is_shown(cortexc: Command, left_turn: Path) -> None:
    """One run: the drawing, the story, metrics, risk, params, and the command that shows it again."""
    result = cortexc(left_turn, "--seed", "3", "--metrics")
    assert result.code == 0
    for title in ("Scene", "What happened", "Over time", "Metrics", "Risk", "Params", "Choices"):
        assert f"\n{title}" in result.out
    assert f"cortexc {left_turn} --seed 3" in " ".join(result.out.split())
    assert "\x1b" not in result.out


def test_run_repeats_itself(cortexc: Command, left_turn: Path) -> None:
    """The same seed gives the same document, another seed another."""
    first, second, other = (cortexc(left_turn, "--json", "--seed", seed).document for seed in (3, 3, 4))
    assert first == second
    assert first["params"] != other["params"]


def test_an_aborted_run_is_no_scene(cortexc: Command, scenario: Scenario) -> None:
    """Exit code 3; the rule, its line and the time are reported by both engines, and so is what was recorded."""
    rule = 'require always (distance from ego to adversary) > 60 m as "far apart"'
    path = scenario("terminate after", f'{rule}\nrecord ego.speed as "pace"\nterminate after')
    line = path.read_text()[: path.read_text().index(rule)].count("\n") + 1
    for engine in ("batch", "world"):
        result = cortexc(path, "--seed", "6", "--engine", engine)
        assert result.code == 3
        assert f"invalid, for it broke `far apart` (line {line})" in " ".join(result.out.split())
        assert "Records" in result.out
        document = cortexc(path, "--seed", "6", "--engine", engine, "--json").document
        assert (document["verdict"], document["end"]["reason"]) == ("aborted", "aborted")
        assert (document["end"]["rule"], document["end"]["line"]) == ("far apart", line)
        (record,) = document["records"]
        assert (record["name"], record["unit"]) == ("pace", "m/s")
        assert record["time"][-1] == pytest.approx(document["end"]["time"])


def test_measures_beside_the_risk_are_in_the_document(cortexc: Command, left_turn: Path) -> None:
    """Each with its actors, its unit, which only shares have not, and its meaning."""
    metrics = cortexc(left_turn, "--json", "--seed", "4").document["metrics"]
    names = [metric["name"] for metric in metrics]
    assert {"TTC", "PET", "DRAC", "THW", "delta-V", "steering oscillation"} <= set(names)
    assert all(metric["meaning"] for metric in metrics)
    shares = {"BTN", "STN", "P_fatal", "P_serious", "lateral grip", "combined grip"}
    assert {metric["name"] for metric in metrics if not metric["unit"]} <= shares
    assert [metric["actors"] for metric in metrics if metric["name"] == "delta-V"] == [["ego"], ["adversary"]]


def test_both_engines_agree(cortexc: Command, left_turn: Path) -> None:
    """The scored part of a run is the same in the batch host and in the world."""
    batch, world = (cortexc(left_turn, "--json", "--engine", engine).document for engine in ("batch", "world"))
    assert batch["collided"] == world["collided"]
    assert batch["risk"]["score"] == world["risk"]["score"]
    assert batch["pairs"][0]["min_distance"] == pytest.approx(world["pairs"][0]["min_distance"], abs=1e-9)


def test_a_param_held_fixed_stays(cortexc: Command, left_turn: Path) -> None:
    """`-p` is obeyed by the run and repeated in the command that shows it again."""
    result = cortexc(left_turn, "-p", "EGO_SPEED=36 km/h")
    assert "starts at 36.0 km/h" in result.out
    assert "-p 'EGO_SPEED=36 km/h'" in result.out
    assert "EGO_SPEED 36 km/h held" in " ".join(result.out.split())
    document = cortexc(left_turn, "-p", "EGO_SPEED=36", "-p", "ADV_SPEED=10 m/s", "--json").document
    assert "EGO_SPEED" not in document["params"]
    assert document["held"] == {
        "EGO_SPEED": {"value": 36.0, "unit": "km/h"},
        "ADV_SPEED": {"value": 10.0, "unit": "m/s"},
    }


def test_no_valid_scene(cortexc: Command, scenario: Scenario) -> None:
    """Requirements that hardly ever meet end with 3 and a table that names the culprit."""
    path = scenario("EGO_INIT_DIST) <= 2.5 m", "EGO_INIT_DIST) <= 2.5e-9 m")
    result = cortexc(path, "--max-attempts", "20")
    assert result.code == 3
    assert result.out == ""
    assert "no valid scene" in result.said
    assert "first culprit: ego starts where it should (line 41) never held" in result.said
    document = cortexc(path, "--max-attempts", "20", "--json").document
    assert document["verdict"] == "exhausted"
    assert document["requirements"][0]["pass_rate"] == 0.0


def test_a_behaviour_that_never_acts(cortexc: Command, scenario: Scenario) -> None:
    """A loop without an action is the file's mistake: a diagnostic at its line, not a hang."""
    path = scenario("        take SetBrakeAction(EGO_BRAKE)", "        while True:\n            x = 1")
    result = cortexc(path, "-p", "SAFETY_DIST=50 m", "-p", "EGO_INIT_DIST=10 m", "-p", "ADV_INIT_DIST=10 m")
    assert result.code == 1
    assert "never acts" in result.said


def test_sample(cortexc: Command, left_turn: Path) -> None:
    """A sample counts verdicts and requirements; its document holds the same numbers."""
    result = cortexc(left_turn, "--sample", "200", "--seed", "1")
    assert result.code == 0
    assert "200 scenes" in result.out
    document = cortexc(left_turn, "--sample", "200", "--seed", "1", "--json", "--jobs", "1").document
    assert sum(document["verdicts"].values()) == document["scenes"] == 200
    assert f"{document['verdicts']['valid']} " in result.out
    failures = sum(requirement["failed"] for requirement in document["requirements"])
    assert document["attempts"] == failures + document["verdicts"]["valid"]


def test_sample_without_any_valid_scene(cortexc: Command, scenario: Scenario) -> None:
    """Nothing valid among all: 3."""
    path = scenario("EGO_INIT_DIST) <= 2.5 m", "EGO_INIT_DIST) <= 2.5e-9 m")
    assert cortexc(path, "--sample", "5", "--max-attempts", "10").code == 3


def test_search(cortexc: Command, left_turn: Path, tmp_path: Path) -> None:
    """A search leaves a run directory and shows what it found."""
    result = cortexc(left_turn, "--ga", *SMALL, "--paper", "--out", tmp_path / "run")
    assert result.code == 0
    assert "among 36 individuals" in result.out
    assert {path.name for path in (tmp_path / "run").iterdir()} >= {"journal.sqlite", "evaluations.csv", "summary.json"}
    with (tmp_path / "run" / "evaluations.csv").open() as file:
        assert len(list(csv.DictReader(file))) == 36


def test_the_worst_cases_replay_exactly(cortexc: Command, left_turn: Path, tmp_path: Path) -> None:
    """Each concrete scenario runs to the outcome that the search saw, to the last bit."""
    cortexc(left_turn, "--random", *SMALL, "--seed", "2", "--out", tmp_path / "run")
    with (tmp_path / "run" / "evaluations.csv").open() as file:
        rows = {row["key"]: row for row in csv.DictReader(file)}
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    for case in summary["worst"]:
        seen = rows[case["key"]]
        again = cortexc(tmp_path / "run" / "worst" / f"{case['rank']:02d}.scn", "--engine", "batch", "--json").document
        assert again["risk"]["score"] == case["score"]
        assert again["pairs"][0]["min_distance"] == float(seen["min_distance"])
        assert again["pairs"][0]["ttc_at_ms"] == float(seen["ttc_at_ms"])
        assert again["end"]["time"] == float(seen["end_time"])


def test_both_methods_side_by_side(cortexc: Command, left_turn: Path, tmp_path: Path) -> None:
    """Two searches, two directories, one table, one document."""
    result = cortexc(left_turn, "--ga", "--random", *SMALL, "--out", tmp_path / "both", "--json", "--jobs", "1")
    assert [search["method"] for search in result.document["searches"]] == ["ga", "random"]
    assert sorted(path.name for path in (tmp_path / "both").iterdir()) == ["ga", "random"]
    assert "Side by side" in cortexc(left_turn, "--ga", "--random", *SMALL, "--out", tmp_path / "again").out


def test_results_never_depend_on_threads(cortexc: Command, left_turn: Path, tmp_path: Path) -> None:
    """One thread or two: the same evaluations, byte for byte."""
    for jobs in ("1", "2"):
        cortexc(left_turn, "--ga", *SMALL, "--jobs", jobs, "--out", tmp_path / jobs)
    assert (tmp_path / "1" / "evaluations.csv").read_bytes() == (tmp_path / "2" / "evaluations.csv").read_bytes()


def test_a_run_is_never_overwritten(cortexc: Command, left_turn: Path, tmp_path: Path) -> None:
    """A folder with results is refused before anything runs; so is a file."""
    cortexc(left_turn, "--random", *SMALL, "--out", tmp_path / "run")
    refused = cortexc(left_turn, "--random", *SMALL, "--out", tmp_path / "run")
    assert refused.code == 2
    assert "already holds a run" in refused.said
    (tmp_path / "file").write_text("")
    assert cortexc(left_turn, "--random", *SMALL, "--out", tmp_path / "file").code == 2
    assert cortexc(left_turn, "--random", *SMALL, "--out", tmp_path / "file" / "below").code == 2


def test_results_that_cannot_be_put_away_are_still_shown(
    cortexc: Command, left_turn: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A disk that fills up at the end costs the files, not the report; the code is 2."""

    def full(*_: object) -> None:
        raise StoreError("no space left", "free some space")

    monkeypatch.setattr("cortex_dsl.api.run_folder.write_derived", full)
    result = cortexc(left_turn, "--random", *SMALL, "--paper", "--out", tmp_path / "run")
    assert result.code == 2
    assert "among 36 individuals" in result.out
    assert "no space left" in result.said


def test_rollouts(cortexc: Command, left_turn: Path, tmp_path: Path) -> None:
    """Several scenes for each genome, one fitness."""
    out = tmp_path / "run"
    result = cortexc(left_turn, "--ga", *SMALL, "--rollouts", "2", "--aggregate", "max", "--out", out, "--json")
    assert result.code == 0
    assert result.document["searches"][0]["by_individual"]["runs"] == 72


def test_nothing_to_search(cortexc: Command, scenario: Scenario, tmp_path: Path) -> None:
    """A file without params cannot be searched, and says so."""
    text = scenario().read_text()
    path = tmp_path / "fixed.scn"
    path.write_text(text.replace("param ", ""))
    result = cortexc(path, "--ga", "--out", tmp_path / "run")
    assert result.code in (1, 2)
    assert not (tmp_path / "run").exists()


def test_a_search_without_a_scene_says_why(cortexc: Command, scenario: Scenario, tmp_path: Path) -> None:
    """A search in which nothing was valid ends with 3 and the table of requirements."""
    path = scenario("EGO_INIT_DIST) <= 2.5 m", "EGO_INIT_DIST) <= 2.5e-9 m")
    result = cortexc(path, "--random", *SMALL, "--max-attempts", "20", "--out", tmp_path / "run")
    assert result.code == 3
    assert "first culprit: ego starts where it should (line 41) never held" in " ".join(result.out.split())
