"""The suite of rare failures: what its tables rest on (`python -m benchmarks.suite`)."""

from pathlib import Path

import pytest

from benchmarks.suite import comparison, truth
from benchmarks.suite.scenarios import HALVES, HERE, JUDGE, TUNE, named, scenario
from engine.search.statistics import clopper_pearson

KEPT = truth.kept()


def test_every_file_is_in_the_table() -> None:
    """Half of them tune, half judge, with 8, 20 and 50 genes in both."""
    assert {file.stem for file in HERE.glob("*.scn")} == set(HALVES) == set(KEPT)
    assert len(HALVES) >= 12
    for half in (TUNE, JUDGE):
        names = named(half)
        assert len(names) == len(HALVES) // 2
        assert {len(scenario(name).program.space) for name in names} == {8, 20, 50}


@pytest.mark.parametrize("name", HALVES)
def test_what_is_known_is_known_of_this_file(name: str) -> None:
    """Rates belong to the program as it is, and are rare; every start is to be fair."""
    program, known = scenario(name).program, KEPT[name]
    assert program.settings.fair
    assert known.digest == program.digest
    low, high = clopper_pearson(known.failures, known.valid)
    assert high > 1e-5
    assert low < 1e-2
    assert sum(known.mechanisms.values()) == known.failures


def test_draws_add_up(tmp_path: Path) -> None:
    """Two pieces are one campaign, and agree with what is kept."""
    whole, parts, name = tmp_path / "whole.json", tmp_path / "parts.json", "cut_in"
    truth.add([name], 600, 1, whole)
    truth.add([name], 250, 1, parts)
    truth.add([name], 350, 1, parts)
    assert whole.read_text() == parts.read_text()
    drawn, known = truth.kept(whole)[name], KEPT[name]
    low, high = clopper_pearson(drawn.failures, drawn.valid, 0.999)
    assert low <= known.rate <= high


def test_runs_are_kept_once(tmp_path: Path) -> None:
    """A second call makes only what is missing, and the tables name what was run."""
    path = tmp_path / "runs.jsonl"
    comparison.compare(["cut_in"], ["random"], "conflict", 1, 200, 1, 60.0, path)
    comparison.compare(["cut_in"], ["random", "trust_regions"], "conflict", 1, 200, 1, 60.0, path)
    found = comparison.kept(path)
    assert [each.method for each in found] == ["random", "trust_regions"]
    assert all(each.valid == 200 for each in found)
    assert "| cut_in | trust_regions | 1 |" in comparison.table(found, KEPT)
