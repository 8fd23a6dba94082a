"""`--check` on what cannot be, `--prune`, and who is to blame."""

import json
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

import cortex_dsl as cx

Command = Callable[..., Any]
Scenario = Callable[..., Path]

NEVER = ("terminate after", 'require EGO_INIT_DIST > 57 m as "far off"\nterminate after')


def test_check_names_what_can_hold(cortexc: Command, left_turn: Path) -> None:
    """The part of a range that no scene can have, and why."""
    result = cortexc(left_turn, "--check")
    assert result.code == 0
    assert "EGO_INIT_DIST above 50.25 m cannot hold: ego starts where it should, outlines inside the road" in " ".join(
        result.out.split()
    )


def test_the_document_of_check(cortexc: Command, left_turn: Path, scenario: Scenario) -> None:
    """The same for programs: each cut with its param, unit and reasons; and what excludes what."""
    found = cortexc(left_turn, "--check", "--json").document["feasibility"]
    assert found["looked_at"]
    assert not found["infeasible"]
    cut = next(cut for cut in found["cuts"] if cut["param"] == "EGO_INIT_DIST")
    assert (cut["unit"], cut["side"], round(cut["value"], 2)) == ("m", "above", 50.25)
    assert cut["requirements"] == ["ego starts where it should", "outlines inside the road"]
    document = cortexc(scenario(*NEVER), "--check", "--json").document
    assert document["feasibility"]["infeasible"]
    assert document["feasibility"]["conflict"] == ["ego starts where it should", "far off"]
    assert "feasibility" not in cortexc(scenario("km/h", "kmh"), "--check", "--json").document


def test_check_of_an_infeasible_file(cortexc: Command, scenario: Scenario) -> None:
    """Exit code 1, and a diagnostic at the requirements that exclude each other."""
    path = scenario(*NEVER)
    result = cortexc(path, "--check")
    assert result.code == 1
    assert "error[SCN530]" in result.said
    assert "`ego starts where it should` and `far off` exclude each other" in result.said
    document = cortexc(path, "--check", "--json").document
    assert document["errors"] == 1
    assert document["diagnostics"][-1]["code"] == "SCN530"


def test_an_infeasible_run_names_the_requirement_to_blame(cortexc: Command, scenario: Scenario) -> None:
    """Exit code 3; the smallest conflict, proved."""
    path = scenario(*NEVER)
    result = cortexc(path, "--max-attempts", "200")
    assert result.code == 3
    assert "never together: `ego starts where it should` (line 41) and `far off` (line 44); proved" in " ".join(
        result.err.split()
    )
    document = cortexc(path, "--max-attempts", "200", "--json").document
    assert document["attempts"] <= 200, "one genome is tried where it is proved that none has a scene"
    conflict = document["blame"]["conflict"]
    assert conflict == {"requirements": ["ego starts where it should", "far off"], "proved": True}


def test_sample_of_what_is_proved_impossible(cortexc: Command, tmp_path: Path) -> None:
    """Nothing is drawn: the requirement to blame is reported at once, with its place and the amount."""
    path = tmp_path / "far.scn"
    path.write_text(
        "map intersection(approach=80 m)\nlane = network.lanes[0]\n"
        "ego = new Car before intersection by 40 m along lane\nother = new Car ahead of ego by Range(20, 30) m\n"
        'require (distance to other) < 10 m as "near"\n'
    )
    result = cortexc(path, "--sample", "1000000")
    words = result.said
    assert result.code == 3
    assert words.startswith("no valid scene can be drawn from this file; that is proved")
    assert "help: relax `near` (line 5) by" in words
    assert "in 0 attempts" not in words
    document = cortexc(path, "--sample", "1000000", "--json").document
    assert (document["scenes"], document["attempts"]) == (0, 0)
    assert document["blame"]["conflict"] == {"requirements": ["near"], "proved": True}


@pytest.mark.parametrize("method", ["ga", "random,niching"])
def test_search_of_what_is_proved_impossible(method: str, cortexc: Command, scenario: Scenario, tmp_path: Path) -> None:
    """Nothing is simulated and no folder is made: exit code 3 with the conflict."""
    path, out = scenario(*NEVER), tmp_path / "run"
    result = cortexc(path, "--method", method, "--out", out)
    assert result.code == 3
    assert "no valid scene can be drawn from this file; that is proved" in result.said
    document = cortexc(path, "--method", method, "--out", out, "--json").document
    assert document["searches"] == []
    assert document["blame"]["conflict"] == {
        "requirements": ["ego starts where it should", "far off"],
        "proved": True,
    }
    assert not out.exists()


@pytest.mark.parametrize(
    "words", [(), ("--condition", "joint"), ("--method", "subset"), ("--method", "importance")], ids=str
)
def test_probability_of_what_is_proved_impossible(words: tuple[str, ...], cortexc: Command, scenario: Scenario) -> None:
    """Nothing is simulated by any method: exit code 3 with the conflict."""
    path = scenario(*NEVER)
    result = cortexc("probability", path, *words)
    assert (result.code, result.out) == (3, "")
    assert "no valid scene can be drawn from this file; that is proved" in result.said
    document = cortexc("probability", path, *words, "--json").document
    assert (document["value"], document["simulations"], document["withheld"]) == (None, 0, "invalid")
    assert document["blame"]["conflict"]["proved"]


def test_a_study_with_a_file_that_is_proved_impossible(
    cortexc: Command, left_turn: Path, scenario: Scenario, tmp_path: Path
) -> None:
    """The file and its conflict are named, nothing is begun, and no folder is made: as for a file with errors."""
    path, out = scenario(*NEVER), tmp_path / "study"
    result = cortexc("study", left_turn, path, "--runs", 1, "--out", out)
    assert result.code == 3
    assert "no valid scene can be drawn from this file; that is proved" in result.said
    assert f"`{path}` cannot be studied, and nothing is begun" in result.said
    document = cortexc("study", left_turn, path, "--runs", 1, "--out", out, "--json").document
    assert (document["file"], document["runs"]) == (str(path), 0)
    assert document["blame"]["conflict"]["requirements"] == ["ego starts where it should", "far off"]
    assert not out.exists()


@pytest.mark.parametrize("words", [(), ("replay",), ("export", "--to", "xosc")], ids=["run", "replay", "export"])
def test_a_scene_of_what_is_proved_impossible(
    words: tuple[str, ...], cortexc: Command, scenario: Scenario, tmp_path: Path
) -> None:
    """Every command that needs one scene of a file gives the proof and exit code 3; nothing is written."""
    before, options = words[:1], words[1:]
    result = cortexc(*before, scenario(*NEVER), *options)
    assert result.code == 3
    assert result.said.startswith("no valid scene can be drawn from this file; that is proved")
    assert "never together: `ego starts where it should`" in " ".join(result.said.split())
    assert not list(tmp_path.glob("*.xosc"))


@pytest.mark.parametrize(
    "ask",
    [
        lambda path: cx.search(path, generations=1, population=2),
        lambda path: cx.load(path).search("random", generations=1, population=2),
        lambda path: cx.study(path, methods="random", runs=1, generations=1, population=2),
    ],
    ids=["search", "Scenario.search", "study"],
)
def test_python_raises_the_proof(ask: Callable[[Path], object], scenario: Scenario) -> None:
    """At once, as the diagnostic of `--check`."""
    with pytest.raises(cx.CompileError) as raised:
        ask(scenario(*NEVER))
    assert [each.code for each in raised.value.diagnostics] == ["SCN530"]
    assert "`ego starts where it should` and `far off` exclude each other" in str(raised.value)


def test_sample_says_what_to_relax(cortexc: Command, left_turn: Path) -> None:
    """To reach the acceptance that was asked for."""
    assert "to accept 5.00 %: relax `" in cortexc(left_turn, "--sample", "50", "--target", "5%").out
    relaxed = cortexc(left_turn, "--sample", "50", "--target", "5%", "--json").document["blame"]["relax"]
    assert [entry["name"] for entry in relaxed] == ["ego starts where it should", "adversary starts where it should"]
    assert all(10 < entry["amount"] < 30 for entry in relaxed)


@pytest.mark.parametrize("target", ["0", "101%", "-5%", "much", "nan"])
def test_a_target_is_a_share(cortexc: Command, left_turn: Path, target: str) -> None:
    """Anything else is a slip of the user."""
    assert cortexc(left_turn, "--sample", "5", f"--target={target}").code == 2


def test_a_target_needs_a_sample(cortexc: Command, left_turn: Path) -> None:
    """It would do nothing in a search."""
    result = cortexc(left_turn, "--ga", "--target", "5%")
    assert result.code == 2
    assert "--target has no effect" in result.said


def test_pruned_sample(cortexc: Command, left_turn: Path, tmp_path: Path) -> None:
    """Fewer attempts, other verdicts for what cannot be, nothing else."""
    plain, pruned = (cortexc(left_turn, "--sample", "2000", "--json", *flag).document for flag in ((), ("--prune",)))
    assert pruned["attempts"] < 0.3 * plain["attempts"]
    assert pruned["verdicts"]["valid"] == pytest.approx(plain["verdicts"]["valid"], rel=0.1)
    assert pruned["verdicts"]["infeasible"] > 0
    assert (plain["pruned"], pruned["pruned"]) == (False, True)
    easy = tmp_path / "easy.scn"
    easy.write_text("param V = Range(5, 9) m/s\nego = new Car on road, with speed V\nrequire V < 8 m/s\n")
    assert not cortexc(easy, "--sample", "100", "--json", "--prune").document[
        "pruned"
    ]  # no scene needs so many attempts


def test_pruned_search(cortexc: Command, left_turn: Path, tmp_path: Path) -> None:
    """Recorded in the manifest, independent of jobs, and its worst cases replay."""
    small = ("--random", "--generations", "2", "--population", "20", "--prune")
    for jobs in (1, 2):
        assert cortexc(left_turn, *small, "--jobs", jobs, "--out", tmp_path / str(jobs)).code == 0
    with closing(sqlite3.connect(tmp_path / "1" / "journal.sqlite")) as journal:
        ((settings,),) = journal.execute("SELECT value FROM manifest WHERE field = 'settings'").fetchall()
    assert json.loads(settings)["simulation"]["prune"] is True
    first, second = ((tmp_path / str(jobs) / "worst" / "01.scn").read_text() for jobs in (1, 2))
    assert first == second
    case = tmp_path / "1" / "worst" / "01.scn"
    assert cortexc(case).out.startswith(f"{left_turn.stem}, case 1  ")
    risk = int(case.read_text().split("risk ")[1].split()[0].rstrip('."'))
    assert cortexc(case, "--json", "--engine", "batch").document["risk"]["score"] == risk
