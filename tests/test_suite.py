"""The suite of rare failures: what its tables rest on (`python -m benchmarks.suite`)."""

from pathlib import Path

import pytest

from benchmarks.suite import comparison, tables, truth
from benchmarks.suite.outside import OUTSIDE
from benchmarks.suite.scenarios import HALVES, HERE, JUDGE, TUNE, named, scenario
from engine.extras import MissingExtraError, is_installed

PACKAGES = {"optuna_tpe": "optuna", "nevergrad_de": "nevergrad", "pymoo_ga": "pymoo", "extra_trees": "sklearn"}


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
    assert "| cut_in | best_first | 1 |" in tables.table(found, known)
    assert all(row.processor is not None and row.processor > 0.0 for row in found)
    assert all(row.reached.keys() == row.first.keys() for row in found)
    assert "| cut_in | judge | 8 | 600 |" in truth.table(known)


@pytest.mark.parametrize("method", OUTSIDE)
def test_optimisers_of_other_packages_search_as_plug_ins_do(method: str) -> None:
    """The same seed gives the same run; without its package the answer names the command that brings it."""
    if not is_installed(PACKAGES[method]):
        with pytest.raises(MissingExtraError, match="which is not installed"):
            comparison.searched("walker_hesitates", method, "conflict", 200, 0)
        return
    first = comparison.searched("walker_hesitates", method, "conflict", 200, 0)
    again = comparison.searched("walker_hesitates", method, "conflict", 200, 0)
    assert (first.valid, first.first, first.cells) == (again.valid, again.first, again.cells)
    assert 0 < first.valid <= 200


def found(method: str, run: int, first: dict[str, int], seconds: float) -> comparison.Found:
    reached = dict.fromkeys(first, seconds)
    return comparison.Found(
        "cut_in", "d", method, "conflict", 100, run, 100, 9.0, len(first), len(first), first, seconds, reached
    )


def test_summaries_count_runs_that_all_methods_have() -> None:
    """Two runs of each, though one method has three; what is reached later than chance needs for all is not in time."""
    truths = {"cut_in": truth.Truth("d", 100, 100, 4, {"a": 2, "b": 2})}
    rows = [found("random", run, {"a": 7}, 1.0) for run in range(3)]
    rows += [found("slow", run, {"a": 1, "b": 3}, 5.0) for run in range(2)]
    assert "| cut_in | 3/3, 7 | 2/2, 1 |" in tables.compact(rows, truths)
    told = tables.summaries(rows, truths)
    assert "| random | both | 1 | 2 | 2 (75%) | 16% .. 100% | 1.0 of 2 | 1.0 | 1 | 1.0 |" in told
    assert "| slow | both | 1 | 2 | 2 (75%) | 16% .. 100% | 2.0 of 2 | 0.0 | 2 | 5.0 |" in told
