"""The suite of rare failures: what its tables rest on (`python -m benchmarks.suite`)."""

from pathlib import Path

import pytest

from benchmarks.suite import comparison, truth
from benchmarks.suite.scenarios import HALVES, HERE, JUDGE, TUNE, named, scenario


def test_every_file_is_in_the_table() -> None:
    """Half of them tune, half judge, with 8, 20 and 50 genes in both."""
    assert {file.stem for file in HERE.glob("*.scn")} == set(HALVES)
    assert len(HALVES) >= 12
    for half in (TUNE, JUDGE):
        names = named(half)
        assert len(names) == len(HALVES) // 2
        assert {len(scenario(name).program.space) for name in names} == {8, 20, 50}
        assert all(scenario(name).program.settings.fair for name in names)


@pytest.mark.parametrize("name", truth.kept())
def test_what_is_known_is_known_of_this_file(name: str) -> None:
    """Rates belong to the program as it is, and each failure has a mechanism."""
    known = truth.kept()[name]
    assert known.digest == scenario(name).program.digest
    assert known.failures < 0.02 * known.valid
    assert sum(known.mechanisms.values()) == known.failures


def test_draws_add_up_and_runs_are_kept_once(tmp_path: Path) -> None:
    """Two pieces of draws are one campaign; a second call makes only the searches that are missing."""
    whole, parts, name = tmp_path / "whole.json", tmp_path / "parts.json", "cut_in"
    truth.add([name], 600, 1, whole)
    truth.add([name], 250, 1, parts)
    truth.add([name], 350, 1, parts)
    assert whole.read_text() == parts.read_text()
    path = tmp_path / "runs.jsonl"
    comparison.compare([name], ["random"], "conflict", 1, 200, 1, 60.0, path)
    comparison.compare([name], ["random", "best_first"], "conflict", 1, 200, 1, 60.0, path)
    found = comparison.kept(path)
    assert [each.method for each in found] == ["random", "best_first"]
    assert all(each.valid == 200 for each in found)
    known = truth.kept(whole)
    assert "| cut_in | best_first | 1 |" in comparison.table(found, known)
    assert "| cut_in | judge | 8 | 600 |" in truth.table(known)
