"""`--check` and `--emit`: diagnostics in every form, and every stage of the compiler."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

Command = Callable[..., Any]
Scenario = Callable[..., Path]


def test_check_of_a_good_file(cortexc: Command, left_turn: Path) -> None:
    """Fine, with a count of what is in it."""
    result = cortexc(left_turn, "--check")
    assert result.code == 0
    assert "7 params, 2 actors" in result.out


def test_check_of_a_bad_file(cortexc: Command, scenario: Scenario) -> None:
    """Errors go to stderr with their place, and the code is 1."""
    path = scenario("EGO_SPEED     = Range(5, 80) km/h", "EGO_SPEED     = Range(80, 5) km/h")
    result = cortexc(path, "--check")
    assert result.code == 1
    assert result.out == ""
    assert f"{path}:" in result.said
    assert "error[SCN" in result.said


def test_check_as_a_document(cortexc: Command, scenario: Scenario, left_turn: Path) -> None:
    """Under --json the diagnostics are the document, also where there are none."""
    assert cortexc(left_turn, "--check", "--json").document["diagnostics"] == []
    result = cortexc(scenario("km/h", "kmh"), "--check", "--json")
    assert result.code == 1
    assert result.document["schema"] == "cortexc/diagnostics"
    assert result.document["errors"] == len(result.document["diagnostics"]) > 0


def test_check_for_github(cortexc: Command, scenario: Scenario) -> None:
    """Annotations name file, line and column in GitHub's own form."""
    path = scenario("> TERM_DIST", "> TERM_DISTT")
    result = cortexc(path, "--check", "--format", "github")
    assert result.code == 1
    assert result.out.startswith(f"::error file={path},line=")


@pytest.mark.parametrize("stage", ["tree", "ast", "ir", "program"])
def test_emit(cortexc: Command, stage: str, left_turn: Path) -> None:
    """Every stage can be printed, as text and in a document."""
    result = cortexc(left_turn, "--emit", stage)
    assert result.code == 0
    assert len(result.out.splitlines()) > 50
    document = cortexc(left_turn, "--emit", stage, "--json").document
    assert document["stage"] == stage
    assert document["text"].strip() == result.out.strip()


def test_emit_of_a_syntax_stage_needs_only_the_grammar(cortexc: Command, scenario: Scenario) -> None:
    """A file with a wrong name has a syntax tree, but no program."""
    path = scenario("> TERM_DIST", "> NOT_DEFINED")
    assert cortexc(path, "--emit", "ast").code == 0
    assert cortexc(path, "--emit", "program").code == 1


def test_a_param_held_fixed(cortexc: Command, left_turn: Path) -> None:
    """`-p` takes a gene out of the search; a misspelt name or a wrong unit is a diagnostic."""
    assert "6 params" in cortexc(left_turn, "--check", "-p", "EGO_SPEED=50 km/h").out
    for wrong in ("EGO_SPED=50 km/h", "EGO_SPEED=50 m", "EGO_SPEED=nan"):
        result = cortexc(left_turn, "--check", "-p", wrong)
        assert result.code == 1, wrong
        assert "error[SCN" in result.said


def test_the_scenario_to_run_can_be_named(cortexc: Command, tmp_path: Path) -> None:
    """`--scenario` picks one of several; one that is not there is an error with the nearest."""
    path = tmp_path / "two.scn"
    text = "map intersection()\nego = new Car on road\n"
    path.write_text(text + "scenario A():\n    setup:\n        b = new Obstacle on road\nscenario Main():\n    pass\n")
    assert "1 actor," in cortexc(path, "--check").out
    assert "2 actors" in cortexc(path, "--check", "--scenario", "A").out
    assert "error[SCN241]" in cortexc(path, "--check", "--scenario", "B").err


def test_mistakes_in_imported_files_name_them(cortexc: Command, tmp_path: Path) -> None:
    """In the text, in the document and for GitHub."""
    (tmp_path / "cars.scn").write_text("# a library\nx = y\n")
    path = tmp_path / "main.scn"
    path.write_text("map intersection()\nimport cars\nego = new Car on road\n")
    library = tmp_path / "cars.scn"
    assert f"{library}:2:5: error[SCN201]" in cortexc(path, "--check").err
    assert f"file={library},line=2" in cortexc(path, "--check", "--format", "github").out
    found = [d for d in cortexc(path, "--check", "--json").document["diagnostics"] if d["code"] == "SCN201"]
    assert [(d["file"], d["start"]["line"]) for d in found] == [(str(library), 2)]
