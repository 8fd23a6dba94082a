"""Text tables of a large search: they are written on request, at once or later, and no command needs them."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import engine.search.manifest
import engine.search.result_files
from cortex_dsl.api.restoring import restore
from cortex_dsl.api.resuming import resume
from cortex_dsl.api.runs import open_run
from cortex_dsl.api.scenario import load
from engine.search.campaign import Progress
from engine.search.result_files import TABLES
from tests.folders import content, files
from tests.runs import SEARCH

Command = Callable[..., Any]
pytestmark = pytest.mark.usefixtures("small_design", "large")

SIMULATIONS = 4 * 30
"""Simulations of the run of `SEARCH`."""


@pytest.fixture
def large(monkeypatch: pytest.MonkeyPatch) -> None:
    """A search of the tests is large, and its tables have many parts, of which the last one is shorter."""
    monkeypatch.setattr(engine.search.manifest, "MOST_IN_TABLES", SIMULATIONS - 1)
    monkeypatch.setattr(engine.search.result_files, "ROWS", 7)


@pytest.fixture
def bare(left_turn: Path, cortexc: Command, ga_run: Path, tmp_path: Path) -> Path:
    """A large search without tables, beside the one with tables, so that both name the scenario by the same path."""
    run = ga_run.parent / f"{tmp_path.parent.name}-{tmp_path.name}"
    assert cortexc(left_turn, *SEARCH, "--out", run).code == 0
    return run


def tables(folder: Path) -> dict[str, bytes]:
    return {name: (folder / name).read_bytes() for name in TABLES if (folder / name).exists()}


def without_tables(found: dict[str, Any]) -> dict[str, Any]:
    return {name: each for name, each in found.items() if name not in TABLES}


@pytest.mark.parametrize("how", ["report", "restore", "at once"])
def test_tables_made_later_are_those_made_at_once(
    how: str, bare: Path, ga_run: Path, left_turn: Path, cortexc: Command
) -> None:
    """They have the bytes of the tables of a small search, which are made as one part; all else is the same."""
    assert tables(bare) == {}
    assert content(bare) == without_tables(dict(content(ga_run)))
    if how == "at once":
        bare = bare.with_name(f"{bare.name}-at-once")
        assert cortexc(left_turn, *SEARCH, "--tables", "--out", bare).code == 0
    elif how == "report":
        said = cortexc("report", bare, "--cases", 0, "--tables").said
        assert all(name in said for name in TABLES)
    else:
        restore(open_run(bare), tables=True)
    assert tables(bare) == tables(ga_run)


def test_no_command_needs_tables(bare: Path, ga_run: Path, cortexc: Command) -> None:
    """Every command that reads a run gives the same with and without them, and makes none."""
    run = shutil.copytree(ga_run, bare.with_name(f"{bare.name}-with"))
    for words in (
        ("resume", ..., "--metrics"),
        ("report", ..., "--cases", 1),
        ("analyse", ..., "--json"),
        ("replay", ..., "--to", bare.with_name("case.svg")),
        ("verify", ..., "--sample", 5, "--json"),
        ("probability", ..., "--samples", 100, "--json"),
        ("export", ..., "--to", "csv", "--json"),
    ):
        seen = [cortexc(*(folder if each is ... else each for each in words)) for folder in (bare, run)]
        assert seen[0].code == seen[1].code == 0, seen[0].said
        assert tables(bare) == {}
    assert len(open_run(bare).every_case()) == len(open_run(run).every_case()) > 0


def test_the_screen_names_the_command(bare: Path, ga_run: Path, cortexc: Command) -> None:
    """Where there are no tables, the summary says why, and which command makes them."""
    assert f"cortexc report {bare} --tables" in " ".join(cortexc("resume", bare).out.split())
    assert "--tables" not in cortexc("resume", ga_run).out


def test_verify_compares_the_tables_that_exist(bare: Path, cortexc: Command) -> None:
    """A table that is there must follow from the journal; one that is not there is no damage, and is not made."""
    assert cortexc("verify", bare, "--sample", 0).code == 0
    restore(open_run(bare), tables=True)
    right = tables(bare)
    (bare / "critical.csv").unlink()
    assert cortexc("verify", bare, "--sample", 0).code == 0
    for name in ("evaluations.csv", "evaluations.jsonl"):
        for wrong in (right[name][:-1], right[name] + b"\n", right[name].replace(b"1", b"2", 1), b""):
            (bare / name).write_bytes(wrong)
            found = cortexc("verify", bare, "--sample", 0)
            assert found.code == 2
            assert f"`{bare / name}` is changed" in found.said
        restore(open_run(bare))
        assert tables(bare) == {each: right[each] for each in TABLES if each != "critical.csv"}


@pytest.mark.parametrize("requested", [True, False])
def test_a_killed_search_keeps_the_request(requested: bool, left_turn: Path, tmp_path: Path) -> None:
    """A search that is killed and resumed has the files of one that was not, with tables and without."""

    def kill(progress: Progress) -> None:
        if progress.generation == 1:
            raise SystemExit

    scenario, size = load(left_turn), {"generations": 4, "population": 30, "seed": 1, "tables": requested}
    scenario.search("ga", out=tmp_path / "whole", **size)
    with pytest.raises(SystemExit):
        scenario.search("ga", out=tmp_path / "killed", on_generation=kill, **size)
    assert tables(tmp_path / "killed") == {}
    resume(tmp_path / "killed")
    assert content(tmp_path / "killed") == content(tmp_path / "whole")
    assert set(tables(tmp_path / "killed")) == set(TABLES if requested else ())


def test_a_longer_search_brings_its_tables_up_to_date(bare: Path, cortexc: Command) -> None:
    """Tables of an earlier state of the journal do not stay as they are."""
    restore(open_run(bare), tables=True)
    before = files(bare)
    assert cortexc("resume", bare, "--generations", 5).code == 0
    after = files(bare)
    assert all(after[name] != before[name] for name in ("evaluations.csv", "evaluations.jsonl", "generations.csv"))
    assert cortexc("verify", bare, "--sample", 0).code == 0
