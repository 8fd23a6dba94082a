"""`cortexc analyse`, `cortexc probability` and `--freeze`, as a user meets them."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

Command = Callable[..., Any]
SYSTEM = "simulation(system=[EGO_BRAKE, SAFETY_DIST, CRASH_DIST])\n"


@pytest.fixture
def declared(left_turn: Path, tmp_path: Path) -> Path:
    """The example, with the params of its system under test named above all of them."""
    path = tmp_path / "declared.scn"
    text = left_turn.read_text(encoding="utf-8")
    path.write_text(text.replace("map intersection", SYSTEM + "map intersection", 1), encoding="utf-8")
    return path


@pytest.fixture
def run(cortexc: Command, declared: Path, tmp_path: Path) -> Path:
    folder = tmp_path / "run"
    assert cortexc(declared, "--ga", "--generations", "6", "--population", "60", "--out", folder).code == 0
    return folder


def test_a_run_is_understood(cortexc: Command, run: Path) -> None:
    """Every part has its title; the page fits its terminal and says what the search should not have chosen."""
    result = cortexc("analyse", run, "--budget", "700")
    assert result.code == 0
    titles = ("Kinds of failures", "ego speed x other speed", "approach angle", "Which params matter", "UN R157")
    for title in titles:
        assert title in result.out
    assert "EGO_BRAKE, SAFETY_DIST, CRASH_DIST" in result.out
    assert max(map(len, result.out.splitlines())) <= 100
    assert "\x1b" not in result.out


def test_the_document_says_the_same(cortexc: Command, run: Path) -> None:
    """One document; its counts fit one another, and 0 simulations leave the design out."""
    found = cortexc("analyse", run, "--budget", "0", "--json").document
    assert found["schema"] == "cortexc/analysis"
    assert found["sensitivity"] is None
    assert len(found["kinds"]) == len(found["clusters"])
    assert sum(len(cluster["rows"]) for cluster in found["clusters"]) == found["failures"]
    assert sum(found["avoided"]["by"].values()) == found["avoided"]["driven"] <= len(found["distinct"])
    assert found["system"] == ["EGO_BRAKE", "SAFETY_DIST", "CRASH_DIST"]


def test_analyse_needs_a_run(cortexc: Command, tmp_path: Path) -> None:
    """Without one, and without a journal in it, a cure is told."""
    for arguments in (("analyse",), ("analyse", tmp_path)):
        result = cortexc(*arguments)
        assert result.code == 2
        assert "help:" in result.err


def test_probability_has_its_interval(cortexc: Command, left_turn: Path) -> None:
    """Both estimators tell a value inside its interval, and roughly the same one."""
    values = []
    for method in ("mc", "subset"):
        found = cortexc("probability", left_turn, "--method", method, "--samples", "2000", "--json").document
        assert found["interval"]["low"] < found["value"] < found["interval"]["high"]
        assert 0.6 < found["valid_share"] < 0.8
        values.append(found["value"])
    assert values[0] == pytest.approx(values[1], abs=0.05)
    text = cortexc("probability", left_turn, "--samples", "500").out
    assert "given a valid scene" in text
    assert "Clopper and Pearson" in text


def test_probability_says_what_is_wrong(cortexc: Command, left_turn: Path, tmp_path: Path) -> None:
    """No file, a file that is not there, too few samples for chains."""
    assert cortexc("probability").code == 2
    assert cortexc("probability", tmp_path / "none.scn").code == 2
    assert cortexc("probability", left_turn, "--method", "subset", "--samples", "50").code == 2


def test_frozen_params_are_no_genes(cortexc: Command, declared: Path) -> None:
    """What the file calls the system's stands at the middle of its range, or at what -p says."""
    program = cortexc(declared, "--freeze", "-p", "CRASH_DIST=1", "--emit", "program").out
    assert [line.split()[2].rstrip(":") for line in program.splitlines() if line.startswith("gene ")] == [
        "EGO_INIT_DIST",
        "EGO_SPEED",
        "ADV_INIT_DIST",
        "ADV_SPEED",
    ]
    assert cortexc(declared, "--freeze", "--json").document["params"].keys().isdisjoint({"EGO_BRAKE", "CRASH_DIST"})


def test_params_to_freeze_can_be_named(cortexc: Command, left_turn: Path) -> None:
    """By name in any file; one that is not there is told, as is a file that names none."""
    assert "6 params" in cortexc(left_turn, "--freeze", "EGO_BRAKE", "--check").out
    wrong = cortexc(left_turn, "--freeze", "EGO_BRAK", "--check")
    assert wrong.code == 2
    assert "did you mean `EGO_BRAKE`?" in wrong.err
    silent = cortexc(left_turn, "--freeze", "--check")
    assert silent.code == 2
    assert "simulation(system=" in silent.err


def test_the_manifest_knows_whose_the_params_are(run: Path) -> None:
    """So that a run can be judged without its file."""
    manifest = json.loads((run / "summary.json").read_text(encoding="utf-8"))["manifest"]
    system = [parameter["name"] for parameter in manifest["parameters"] if parameter["system"]]
    assert system == ["EGO_BRAKE", "SAFETY_DIST", "CRASH_DIST"]
