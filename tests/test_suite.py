"""The suite of rare failures: what its tables rest on (`python -m benchmarks.suite`)."""

import math
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.random import default_rng

from benchmarks.suite import comparison, planting, tables, truth
from benchmarks.suite.outside import OUTSIDE
from benchmarks.suite.scenarios import HALVES, HERE, HIDDEN, JUDGE, PLANTED, TUNE, named, planted_in, scenario
from engine.extras import MissingExtraError, is_installed

PACKAGES = {"optuna_tpe": "optuna", "nevergrad_de": "nevergrad", "pymoo_ga": "pymoo", "extra_trees": "sklearn"}


def test_every_file_is_in_the_table() -> None:
    """Half of those written by hand tune, half judge, with 8, 20 and 50 genes in both; 24 hold planted defects."""
    assert {file.stem for file in HERE.glob("*.scn")} | {file.stem for file in HIDDEN.parent.glob("*.scn")} == set(
        HALVES
    )
    for half in (TUNE, JUDGE):
        names = named(half)
        assert len(names) == 6
        assert {len(scenario(name).program.space) for name in names} == {8, 20, 50}
        assert all(scenario(name).program.settings.fair for name in names)
    assert set(named(PLANTED)) == {each.name for each in planting.planted("any")}


@pytest.mark.parametrize("each", planting.planted("1"), ids=lambda each: each.name)
def test_a_planted_file_has_the_defects_of_its_seed_and_its_rate(each: planting.Planted) -> None:
    """Their places are those of the seed, the file is the text of what is hidden, and its rate is of its decade."""
    hidden = planted_in(each.name)
    places = [(defect.genes, defect.centre) for defect in each.defects]
    assert [(defect.genes, defect.centre) for defect in hidden] == places
    assert replace(each, defects=hidden).text == (HIDDEN.parent / f"{each.name}.scn").read_text()
    known, decade = truth.kept()[each.name], round(-math.log10(each.rate) - 0.5)
    assert 10.0 ** -(decade + 1) < known.rate < 10.0**-decade
    assert known.failures >= 100
    assert all(count > 0 for count in known.mechanisms.values())


@pytest.mark.parametrize("family", planting.FAMILIES)
def test_an_ego_without_a_defect_brakes_in_time(family: str) -> None:
    """So that failures near defects are all failures of a file: clearance at all corners, and in draws."""
    assert truth.least_clearance(family, 300) > 1.0


@given(st.integers(2, 5), st.floats(0.1, 0.3), st.floats(-6.0, -2.5))
def test_shells_are_exact_volumes_of_uniform_points(size: int, fails_below: float, exponent: float) -> None:
    """A defect that fails below a share of the delay has the rate for which it was made, by the volume of its ball."""
    place = planting.Defect(tuple("abcde"[:size]), (0.5,) * size, 1.0)
    defect = place.at_rate(10.0**exponent, fails_below)
    radius = defect.radius(fails_below)
    assert defect.ball * radius**size == pytest.approx(10.0**exponent, rel=1e-4)
    assert defect.share_at(10.0**exponent) == pytest.approx(fails_below, rel=1e-4)
    volume, edges = 0.0, iter(planting.EDGES)
    next(edges)
    for shell, points in defect.shells(50, default_rng(1)):
        edge, shares = next(edges), defect.share(points)
        volume += shell
        assert volume == pytest.approx(defect.ball * defect.radius(edge) ** size, rel=1e-9)
        assert (shares <= edge * (1.0 + 1e-6)).all()


@pytest.mark.parametrize("name", truth.kept())
def test_what_is_known_is_known_of_this_file(name: str) -> None:
    """Rates belong to the program as it is, and each failure has a mechanism."""
    known = truth.kept()[name]
    assert known.digest == scenario(name).program.digest
    assert known.rate < 0.02
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
