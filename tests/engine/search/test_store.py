"""Run directories, the journal and the exports."""

import csv
import errno
import json
import os
import shutil
import sqlite3
from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.assessment import Evaluate, take
from engine.atomic import write_all
from engine.config import Config, SearchConfig
from engine.outcomes import Assessment
from engine.program import ParamSpace
from engine.search.campaign import Campaign, OnGeneration
from engine.search.journal import Journal
from engine.search.journal_reader import read_journal
from engine.search.manifest import Manifest
from engine.search.protocol import Box
from engine.search.result_files import result_files
from engine.search.run import Task, run_campaign
from engine.search.searchers import build_searcher
from engine.search.store import (
    JOURNAL,
    StoreError,
    example_run,
    new_directory,
    numbered_directory,
    store_errors,
)
from engine.tables import Floats, Ints
from tests.engine.search.conftest import assert_equal
from tests.folders import small_files
from tests.journals import unchain

CONFIG = SearchConfig(generations=5, population=20, seed=11, rollouts=2, aggregate="q90")


def run(
    space: ParamSpace, evaluate: Evaluate, config: SearchConfig = CONFIG, on_generation: OnGeneration | None = None
) -> Campaign:
    searcher = build_searcher("ga", Box.of(space), Config(search=config))
    return run_campaign(Task(space, evaluate, config, "ga", "cortex"), searcher, on_generation)


@pytest.fixture
def evaluate(space: ParamSpace, evaluators: Callable[..., Evaluate]) -> Evaluate:
    return evaluators(space, error_above=0.95)


def test_journal_round_trip(
    tmp_path: Path, space: ParamSpace, evaluate: Evaluate, manifests: Callable[..., Manifest]
) -> None:
    """What is read is what was found, bit for bit: manifest, every evaluation, every figure."""
    journal = Journal.create(tmp_path / JOURNAL, manifests(space, CONFIG))
    found = run(space, evaluate, on_generation=journal.write)
    journal.finish(found)
    record = read_journal(tmp_path / JOURNAL)
    assert record.manifest == replace(
        manifests(space, CONFIG), settings=json.loads(json.dumps(manifests(space, CONFIG).settings))
    )
    assert_equal(record.evaluations, found.evaluations)
    assert [repr(row) for row in record.generations] == [repr(row) for row in found.generations]
    assert (record.status, record.seconds) == ("finished", found.elapsed)
    assert [path.name for path in tmp_path.iterdir()] == [JOURNAL]


def test_journal_of_the_same_seed_is_the_same(
    tmp_path: Path, space: ParamSpace, evaluate: Evaluate, manifests: Callable[..., Manifest]
) -> None:
    """The tables of results are equal row by row; only pace and status may differ."""
    dumps = []
    for name in ("a.sqlite", "b.sqlite"):
        journal = Journal.create(tmp_path / name, manifests(space, CONFIG))
        journal.finish(run(space, evaluate, on_generation=journal.write))
        with sqlite3.connect(tmp_path / name) as connection:
            dumps.append(
                [
                    connection.execute(f"SELECT * FROM {table}").fetchall()
                    for table in ("generation", "individual", "simulation", "manifest")
                ]
            )
        connection.close()
    assert dumps[0] == dumps[1]


def test_rows_are_compact(
    tmp_path: Path, space: ParamSpace, evaluators: Callable[..., Evaluate], manifests: Callable[..., Manifest]
) -> None:
    """An evaluation takes no more than 300 bytes."""
    config = SearchConfig(generations=10, population=100)
    journal = Journal.create(tmp_path / JOURNAL, manifests(space, config))
    journal.finish(run(space, evaluators(space), config, journal.write))
    assert (tmp_path / JOURNAL).stat().st_size < 300 * 1000


def test_interrupted_campaign_keeps_its_generations(
    tmp_path: Path, space: ParamSpace, evaluate: Evaluate, manifests: Callable[..., Manifest]
) -> None:
    """Ctrl-C in a later generation, also while it is being written, leaves a whole journal of the earlier ones."""
    journal = Journal.create(tmp_path / JOURNAL, manifests(space, CONFIG))

    def write(progress: Any) -> None:
        if progress.generation == 2:
            raise KeyboardInterrupt
        journal.write(progress)

    found = run(space, evaluate, on_generation=write)
    assert read_journal(tmp_path / JOURNAL).status == "running"
    assert len(read_journal(tmp_path / JOURNAL).generations) == 2
    journal.finish(found)
    record = read_journal(tmp_path / JOURNAL)
    assert record.status == "stopped"
    assert_equal(record.evaluations, found.evaluations)
    assert len(record.generations) == 3


def test_killed_campaign_is_readable(
    tmp_path: Path, space: ParamSpace, evaluate: Evaluate, manifests: Callable[..., Manifest]
) -> None:
    """A copy of the files at any moment, as a kill leaves them, holds every generation that was written."""
    journal = Journal.create(tmp_path / JOURNAL, manifests(space, CONFIG))
    copy = tmp_path / "copy"
    copy.mkdir()

    def write(progress: Any) -> None:
        journal.write(progress)
        if progress.generation == 3:
            for path in tmp_path.glob(f"{JOURNAL}*"):
                (copy / path.name).write_bytes(path.read_bytes())

    found = run(space, evaluate, on_generation=write)
    journal.finish(found)
    record = read_journal(copy / JOURNAL)
    assert len(record.generations) == 4
    assert_equal(record.evaluations, take(found.evaluations, slice(0, 80)))


def test_full_disk_is_a_clear_error(
    tmp_path: Path, space: ParamSpace, evaluate: Evaluate, manifests: Callable[..., Manifest]
) -> None:
    """The generation that does not fit is left out whole; those before it stay."""
    journal = Journal.create(tmp_path / JOURNAL, manifests(space, CONFIG))

    def write(progress: Any) -> None:
        if progress.generation == 2:
            pages = journal._connection.execute("PRAGMA page_count").fetchone()[0]
            journal._connection.execute(f"PRAGMA max_page_count = {pages}")
        journal.write(progress)

    with pytest.raises(StoreError, match="no space left") as caught:
        run(space, evaluate, on_generation=write)
    assert "--out" in caught.value.cure
    journal.close()
    assert len(read_journal(tmp_path / JOURNAL).generations) == 2


@pytest.mark.parametrize("size", [0, 3000, 20_000])
def test_a_disk_without_space_for_a_journal(
    size: int, tmp_path: Path, space: ParamSpace, manifests: Callable[..., Manifest]
) -> None:
    """Nothing is left, and the cure does not offer to resume."""
    with small_files(size), pytest.raises(StoreError) as caught:
        Journal.create(tmp_path / JOURNAL, manifests(space, CONFIG))
    assert "free some space" in caught.value.cure
    assert "resume" not in caught.value.cure
    assert list(tmp_path.iterdir()) == []
    Journal.create(tmp_path / JOURNAL, manifests(space, CONFIG)).close()


@pytest.mark.parametrize(
    "harm",
    [
        "UPDATE simulation SET score = 99",
        "UPDATE simulation SET collided = 1 - collided",
        "UPDATE individual SET verdict = 3 WHERE generation = 1",
        "DELETE FROM individual WHERE place % 3 = 0",
        "DELETE FROM generation WHERE generation = 1",
    ],
)
def test_changed_rows_are_noticed(
    harm: str, tmp_path: Path, space: ParamSpace, evaluate: Evaluate, manifests: Callable[..., Manifest]
) -> None:
    """No command shows numbers that do not follow from what was simulated."""
    journal = Journal.create(tmp_path / JOURNAL, manifests(space, CONFIG))
    journal.finish(run(space, evaluate, on_generation=journal.write))
    journal.close()
    assert read_journal(tmp_path / JOURNAL).proved
    unproved = unchain(Path(shutil.copy(tmp_path / JOURNAL, tmp_path / "old.sqlite")))
    assert not read_journal(unproved).proved
    for path, message in ((tmp_path / JOURNAL, "not (what|those that)"), (unproved, "does not fit together")):
        with closing(sqlite3.connect(path)) as connection, connection:
            connection.execute(harm)
        with pytest.raises(StoreError, match=message):
            read_journal(path)


def test_foreign_and_damaged_files(tmp_path: Path, space: ParamSpace, manifests: Callable[..., Manifest]) -> None:
    """A journal that is missing, not a database, another program's or of another version is named as that."""
    with pytest.raises(StoreError, match="no journal"):
        read_journal(tmp_path / "missing.sqlite")
    text = tmp_path / "text.sqlite"
    text.write_text("not a database at all, but long enough to be looked at as one" * 20)
    with pytest.raises(StoreError, match="not a readable journal"):
        read_journal(text)
    foreign = tmp_path / "foreign.sqlite"
    connection = sqlite3.connect(foreign)
    connection.execute("CREATE TABLE manifest (a)")
    connection.close()
    with pytest.raises(StoreError, match="another program"):
        read_journal(foreign)
    newer = tmp_path / "newer.sqlite"
    journal = Journal.create(newer, manifests(space, CONFIG))
    journal._connection.execute("PRAGMA user_version = 99")
    journal.close()
    with pytest.raises(StoreError, match="version 99"):
        read_journal(newer)


def test_nothing_is_overwritten(tmp_path: Path, space: ParamSpace, manifests: Callable[..., Manifest]) -> None:
    """Neither a run, nor a folder with something in it, nor a journal."""
    directory = new_directory(tmp_path / "out" / "deep")
    Journal.create(directory / JOURNAL, manifests(space, CONFIG)).close()
    with pytest.raises(StoreError, match="already holds a run"):
        new_directory(directory)
    with pytest.raises(StoreError, match="exists already"):
        Journal.create(directory / JOURNAL, manifests(space, CONFIG))
    with pytest.raises(StoreError, match="not empty"):
        new_directory(tmp_path / "out")
    assert list(new_directory(tmp_path / "empty").iterdir()) == []


@pytest.mark.parametrize(
    ("complaint", "message", "cure"),
    [
        ("database or disk is full", "no space left for", "free some space"),
        ("disk I/O error", "the disk does not take what is written to", "free some space"),
        ("file is not a database", "is not a readable journal: file is not a database", "restore it from a copy"),
        ("database disk image is malformed", "is not a readable journal", "restore it from a copy"),
        ("database is locked", "is in use by another process", "wait for it, or name another --out"),
        ("unable to open database file", "cannot open", "make it writable"),
        ("attempt to write a readonly database", "cannot open", "make it writable"),
        ("no such table: pace", "no such table: pace", "name another folder with --out"),
    ],
)
def test_what_sqlite_says_is_reported_with_a_cure(complaint: str, message: str, cure: str) -> None:
    """Each of its complaints by what a user can do about it."""
    with pytest.raises(StoreError) as caught, store_errors(Path("runs/mine/journal.sqlite")):
        raise sqlite3.OperationalError(complaint)
    assert message in caught.value.message
    assert "`runs/mine/journal.sqlite`" in caught.value.message
    assert caught.value.cure.startswith(cure)


def test_a_journal_in_use_is_said_to_be(tmp_path: Path, space: ParamSpace, manifests: Callable[..., Manifest]) -> None:
    """What SQLite itself says of a journal that another connection is writing."""
    path = tmp_path / "journal.sqlite"
    Journal.create(path, manifests(space, SearchConfig())).close()
    with closing(sqlite3.connect(path, isolation_level=None)) as writer:
        writer.execute("BEGIN EXCLUSIVE")
        with (
            closing(sqlite3.connect(path, timeout=0.0, isolation_level=None)) as other,
            pytest.raises(StoreError, match="is in use by another process"),
            store_errors(path),
        ):
            other.execute("BEGIN IMMEDIATE")


def test_default_directories_are_numbered(tmp_path: Path) -> None:
    """Each run gets the next number, also past gaps, past 999, and under names that file systems mind."""
    root = tmp_path / "runs"
    names = [numbered_directory("left_turn", "ga", root).name for _ in range(2)]
    assert names == ["left_turn-ga-001", "left_turn-ga-002"]
    assert numbered_directory("left_turn", "random", root).name == "left_turn-random-001"
    (root / "left_turn-ga-999").mkdir()
    assert numbered_directory("left_turn", "ga", root).name == "left_turn-ga-1000"
    assert numbered_directory("../a b/ü", "ga", root).name == "a-b-ü-ga-001"
    assert numbered_directory("u\u0308nï 日本\x1b[2J\u202e", "ga", root).name == "ünï-日本-2J-ga-001"
    assert len(os.fsencode(numbered_directory("日" * 300, "ga", root).name)) <= 255
    assert numbered_directory("..", "ga", root).parent == root


def test_places_that_cannot_be_written(tmp_path: Path) -> None:
    """A file in the way, or a device that is full, is an error with a cure."""
    (tmp_path / "file").write_text("")
    for make in (lambda: new_directory(tmp_path / "file" / "out"), lambda: new_directory(tmp_path / "file")):
        with pytest.raises(StoreError, match="cannot write") as caught:
            make()
        assert "file" in caught.value.cure
    with pytest.raises(StoreError, match="cannot write") as caught, store_errors(tmp_path):
        raise OSError(errno.ENOSPC, "No space left on device")
    assert "free some space" in caught.value.cure
    with pytest.raises(StoreError) as caught:
        numbered_directory("a", "ga", tmp_path / "file")
    assert "file" in caught.value.cure


def test_all_exports_hold_the_same_values(
    tmp_path: Path, space: ParamSpace, evaluate: Evaluate, manifests: Callable[..., Manifest]
) -> None:
    """CSV and JSON lines have one row a rollout and read back to the same numbers; critical ones are apart."""
    found = run(space, evaluate, replace(CONFIG, generations=8, population=40))
    write_all(tmp_path, result_files(found, manifests(space, CONFIG)))
    with (tmp_path / "evaluations.csv").open(newline="") as file:
        table = list(csv.DictReader(file))
    lines = [json.loads(line) for line in (tmp_path / "evaluations.jsonl").read_text().splitlines()]
    runs = found.evaluations.rollouts
    assert len(table) == len(lines) == 8 * 40 * 2
    for row, line in zip(table, lines, strict=True):
        assert list(line)[: len(row)] == list(row)
        at = int(row["individual"]), int(row["rollout"])
        assert float(row["param_GENE_0"]) == line["param_GENE_0"] == found.evaluations.genomes[at[0], 0]
        assert row["key"] == line["key"] == "11.ga.0." + ".".join(map(str, found.evaluations.keys[at][3:]))
        assert int(row["score"]) == line["score"] == runs.score[at]
        assert (row["min_distance"] == "") == (line["min_distance"] is None) == bool(np.isnan(runs.min_distance[at]))
        assert row["min_distance"] == "" or float(row["min_distance"]) == runs.min_distance[at]
        assert line["failed"] == runs.failed[at].tolist()
        assert (row["verdict"] == "valid") == (runs.verdict[at] == 0)
    by_number = {row["individual"]: row for row in table}
    for row in table:
        assert by_number[row["birth"]]["param_GENE_1"] == row["param_GENE_1"]
        assert row["operator"] != "mutation" or by_number[row["parent_1"]]["verdict"] in ("valid", "exhausted", "error")
    critical = (tmp_path / "critical.csv").read_text().splitlines()
    assert len(critical) - 1 == (runs.score >= 14).sum() > 0


def test_every_column_is_explained_beside_the_tables(
    tmp_path: Path, space: ParamSpace, evaluate: Evaluate, manifests: Callable[..., Manifest]
) -> None:
    """The page in the run directory names every file and every column, params and doubled figures by their prefix."""
    write_all(tmp_path, result_files(run(space, evaluate, CONFIG), manifests(space, CONFIG)))
    page = (tmp_path / "README.md").read_text()
    names = {path.name for path in tmp_path.iterdir()} - {"README.md"}
    for table in ("evaluations.csv", "generations.csv"):
        names |= set((tmp_path / table).read_text().split("\n", 1)[0].split(","))
    unexplained = {name for name in names if f"`{name}`" not in page}
    assert all(name.startswith(("param_", "simulated_")) for name in unexplained)


def test_summary_and_generations(
    tmp_path: Path, space: ParamSpace, evaluate: Evaluate, manifests: Callable[..., Manifest]
) -> None:
    """The summary is strict JSON with manifest, figures, cases and genes; generations.csv has one row for each."""
    found = run(space, evaluate)
    write_all(tmp_path, result_files(found, manifests(space, CONFIG)))
    document = json.loads((tmp_path / "summary.json").read_text(), parse_constant=lambda text: pytest.fail(text))
    assert document["manifest"]["preset"] == "cortex"
    assert document["by_individual"]["nc"] == found.by_individual.nc
    assert document["last_generations"]["by_individual"]["individuals"] == 100
    assert document["worst"][0]["key"].startswith("11.ga.0.")
    assert set(document["worst"][0]["genome"]) == set(space.names)
    assert [gene["name"] for gene in document["genes"]] == list(space.names)
    with (tmp_path / "generations.csv").open(newline="") as file:
        table = list(csv.DictReader(file))
    assert [int(row["nis"]) for row in table] == [row.by_individual.nis for row in found.generations]
    assert [float(row["simulated_rl"]) for row in table] == [row.by_simulation.rl for row in found.generations]


def test_names_that_need_quotes(
    tmp_path: Path, spaces: Callable[..., ParamSpace], rows: Any, manifests: Callable[..., Manifest]
) -> None:
    """A gene may be called anything that the language allows; percent signs and quotes do no harm."""
    space = spaces([0.0], [1.0], names=['odd, "100 %s"'])

    def evaluate(genomes: Floats, keys: Ints) -> Assessment:
        return rows(np.zeros(len(keys), dtype=np.int32), genomes[:, 0])

    found = run(space, evaluate, SearchConfig(generations=1, population=3))
    write_all(tmp_path, result_files(found, manifests(space, CONFIG)))
    with (tmp_path / "evaluations.csv").open(newline="") as file:
        assert 'param_odd, "100 %s"' in next(csv.DictReader(file))
    assert 'param_odd, "100 %s"' in json.loads((tmp_path / "evaluations.jsonl").read_text().splitlines()[0])


def test_a_run_that_is_there_is_the_example(tmp_path: Path) -> None:
    """The latest; without any, one that a search would make."""
    root = tmp_path / "runs"
    assert example_run(root) == root / "left_turn-ga-001"
    for age, name in ((20, "ped-ga-001"), (10, "ped-random-001"), (30, "old-ga-001")):
        (root / name).mkdir(parents=True)
        (root / name / JOURNAL).touch()
        os.utime(root / name / JOURNAL, (1000 - age, 1000 - age))
    assert example_run(root) == root / "ped-random-001"
