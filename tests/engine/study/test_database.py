"""A study on disk is the study in memory, whatever carried it out and however often it was interrupted."""

import shutil
import sqlite3
from collections.abc import Callable
from contextlib import closing
from dataclasses import fields, replace
from pathlib import Path

import pytest

from engine.outcomes import Assessment
from engine.search.evaluations import Evaluations
from engine.search.run import search
from engine.search.store import StoreError
from engine.study.database import STUDY, Study, StudyStore, is_study, read_evaluations, read_study
from engine.study.execution import perform, perform_all
from engine.study.plan import Address, Plan, check
from engine.study.run_records import DamagedBlock, pack, unpack
from engine.vocabulary import Method
from tests.folders import small_files
from tests.journals import reseal


def contents(folder: Path) -> list[tuple]:
    """Every row that a plan decides."""
    with sqlite3.connect(folder / STUDY) as connection:
        tables = ("scenario", "run", "evaluations")
        return [row for table in tables for row in connection.execute(f"SELECT * FROM {table} ORDER BY 1, 2, 3")]


def same_table(first: object, second: object, kind: type) -> None:
    for field in fields(kind):
        a, b = getattr(first, field.name), getattr(second, field.name)
        if field.name == "rollouts":
            same_table(a, b, Assessment)
        else:
            assert a.dtype == b.dtype, field.name
            assert a.tobytes() == b.tobytes(), field.name


@pytest.mark.parametrize(("method", "rollouts"), [("random", 1), ("ga", 1), ("ga", 3)])
def test_a_block_holds_every_evaluation_exactly(plan: Plan, method: str, rollouts: int) -> None:
    task = plan.task(Address(1, method, 2))
    config = replace(task.config, search=replace(task.config.search, rollouts=rollouts, generations=6))
    evaluations = search(task.program, method, config).evaluations
    blob = pack(evaluations)
    again = unpack(blob, config.search.seed, Method[method.upper()], 2, "mean")
    same_table(evaluations, again, Evaluations)


def test_a_damaged_block_is_reported(study: Study, plan: Plan) -> None:
    blob = perform(plan.task(Address(0, "random", 0))).block
    for damaged in (blob[:-20], blob[:50], b"", b"nonsense"):
        with pytest.raises(DamagedBlock):
            unpack(damaged, 5, 2, 0, "mean")


def test_a_study_reads_back_as_it_was_planned_and_run(study: Study, plan: Plan) -> None:
    assert study.complete
    assert study.plan.methods == plan.methods
    assert [s.program.digest for s in study.plan.subjects] == [s.program.digest for s in plan.subjects]
    assert [s.config for s in study.plan.subjects] == [s.config for s in plan.subjects]
    assert [record.address for record in study.records] == list(plan.addresses())
    finished = perform(plan.task(Address(1, "ga", 2)))
    stored = study.records[-1]
    assert stored.figures == finished.record.figures
    assert stored.course.tobytes() == finished.record.course.tobytes()


def test_evaluations_of_a_run_are_those_of_its_campaign(study: Study, plan: Plan) -> None:
    task = plan.task(Address(0, "ga", 1))
    same_table(search(task.program, "ga", task.config).evaluations, read_evaluations(study, task.address), Evaluations)


def test_runs_differ_and_methods_share_no_numbers(study: Study) -> None:
    genomes = {}
    for record in study.records:
        evaluations = read_evaluations(study, record.address)
        genomes[record.address] = evaluations.genomes[:12].tobytes()
    assert len({genomes[Address(0, "random", run)] for run in range(3)}) == 3
    assert genomes[Address(0, "random", 0)] != genomes[Address(0, "ga", 0)]


def test_two_processes_find_what_one_finds(study: Study, plan: Plan, carry_out: Callable, tmp_path: Path) -> None:
    other = carry_out(plan, tmp_path / "two", jobs=2)
    assert contents(other.folder) == contents(study.folder)


def test_an_interrupted_study_becomes_the_undisturbed_one(study: Study, plan: Plan, tmp_path: Path) -> None:
    store = StudyStore.create(tmp_path, plan, {"engine": "test"})

    def interrupted(finished) -> None:
        store.write(finished)
        if finished.record.address.run == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        perform_all(plan, interrupted)
    store.close()
    half = read_study(tmp_path)
    assert not half.complete
    assert len(half.records) == 5
    store = StudyStore.reopen(tmp_path)
    perform_all(half.plan, store.write, done=[record.address for record in half.records])
    store.close()
    assert contents(tmp_path) == contents(study.folder)


def test_what_is_no_study_is_refused(study: Study, tmp_path: Path) -> None:
    assert is_study(study.folder)
    assert not is_study(tmp_path)
    with pytest.raises(StoreError, match="no study"):
        read_study(tmp_path)
    (tmp_path / STUDY).write_bytes(b"not a database, but long enough to be taken for one" * 40)
    with pytest.raises(StoreError, match="not a readable"):
        read_study(tmp_path)
    (tmp_path / STUDY).unlink()
    sqlite3.connect(tmp_path / STUDY).execute("CREATE TABLE t (x)").connection.close()
    with pytest.raises(StoreError, match="another program"):
        read_study(tmp_path)


def test_a_lost_or_foreign_program_is_reported(plan: Plan, carry_out: Callable, tmp_path: Path) -> None:
    one = replace(plan, runs=1, methods=("random",))
    study = carry_out(one, tmp_path / "a")
    programs = study.folder / "programs"
    (programs / "01.npz").write_bytes((programs / "02.npz").read_bytes())
    with pytest.raises(StoreError, match="damaged"):
        read_study(study.folder)


def test_a_study_without_its_scenarios_is_reported(plan: Plan, carry_out: Callable, tmp_path: Path) -> None:
    study = carry_out(replace(plan, runs=1, methods=("random",)), tmp_path / "a")
    with closing(sqlite3.connect(study.folder / STUDY)) as connection:
        connection.execute("DELETE FROM scenario")
        reseal(connection)
        connection.commit()
    with pytest.raises(StoreError, match="damaged: it has lost"):
        read_study(study.folder)


def test_an_edited_file_is_noticed(plan: Plan, carry_out: Callable, tmp_path: Path) -> None:
    path = tmp_path / "edited.scn"
    subject = replace(plan.subjects[0], file=str(path))
    path.write_text(subject.program.source_text)
    study = carry_out(Plan((subject,), ("random",), 1), tmp_path / "study")
    assert study.edited == ()
    path.write_text(subject.program.source_text + "\n# a remark\n")
    assert read_study(study.folder).edited == ("../edited.scn",)


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"methods": ("ga", "ga")}, "named twice"),
        ({"methods": ("gx",)}, "none of"),
        ({"runs": 0}, "runs"),
        ({"methods": ()}, "needs"),
    ],
)
def test_a_plan_that_cannot_be_carried_out_is_reported(plan: Plan, change: dict, problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        check(replace(plan, **change))


def test_numbers_take_less_room_than_the_specification_allows(study: Study, plan: Plan) -> None:
    """At most 100 bytes a simulation beside the numbers; in runs of a usual length."""
    subject = plan.subjects[0]
    search_config = replace(subject.config.search, generations=30, population=100)
    usual = replace(subject, config=replace(subject.config, search=search_config))
    task = Plan((usual,), ("random",), 1).task(Address(0, "random", 0))
    evaluations = search(task.program, "random", task.config).evaluations
    runs = evaluations.rollouts
    numbers = evaluations.genomes.nbytes + sum(getattr(runs, field.name).nbytes for field in fields(Assessment))
    assert len(pack(evaluations)) < numbers
    assert len(pack(evaluations)) < 250 * len(evaluations)


def test_a_study_that_is_taken_away_is_reported(plan: Plan, tmp_path: Path) -> None:
    """With the next run, not by silence: the open file would take what nobody ever finds."""
    store = StudyStore.create(tmp_path, plan, {"engine": "test"})
    done = perform(plan.task(Address(0, "random", 0)))
    (tmp_path / STUDY).unlink()
    with pytest.raises(StoreError, match="was removed"):
        store.write(done)
    store.close()


# -- the seal ----------------------------------------------------------------------------------------------------------

OLD = Path(__file__).parent / "version_2"
"""Kept from before there was a seal: two methods, two runs of two generations of four."""
CHANGES = (
    "UPDATE manifest SET value = '\"paper-mm\"' WHERE field = 'profile'",
    "UPDATE scenario SET file = 'other.scn' WHERE number = 0",
    "UPDATE run SET figures = replace(figures, '1', '2') WHERE run = 1",
    "UPDATE run SET course = zeroblob(length(course)) WHERE run = 2",
    "UPDATE pace SET seconds = seconds + 1 WHERE run = 0",
    "DELETE FROM pace WHERE run = 1",
    "DELETE FROM run WHERE run = 2",
    "UPDATE evaluations SET digest = zeroblob(32) WHERE run = 1",
    "UPDATE seal SET value = zeroblob(16)",
    "DELETE FROM seal",
    "DROP TABLE seal",
    "PRAGMA user_version = 2",
)


@pytest.mark.parametrize("change", CHANGES)
def test_what_was_changed_is_told(study: Study, change: str, tmp_path: Path) -> None:
    """No row, and no number of it, can be another without a word."""
    folder = Path(shutil.copytree(study.folder, tmp_path / "study"))
    assert read_study(folder).proved
    with closing(sqlite3.connect(folder / STUDY)) as connection, connection:
        connection.execute(change)
    with pytest.raises(StoreError, match="damaged"):
        read_study(folder)


def test_changed_evaluations_are_told_when_they_are_read(study: Study, tmp_path: Path) -> None:
    """A block is as large as all else together: the study opens without it."""
    folder = Path(shutil.copytree(study.folder, tmp_path / "study"))
    with closing(sqlite3.connect(folder / STUDY)) as connection, connection:
        connection.execute("UPDATE evaluations SET block = (SELECT block FROM evaluations WHERE run = 0) WHERE run = 1")
    changed = read_study(folder)
    read_evaluations(changed, changed.records[0].address)
    address = next(record.address for record in changed.records if record.address.run == 1)
    with pytest.raises(StoreError, match="are not what was written"):
        read_evaluations(changed, address)


def test_a_kept_study_of_version_2(tmp_path: Path) -> None:
    """It reads as it did and is gone on with, as one that nothing is proved of; so does its program."""
    folder = Path(shutil.copytree(OLD, tmp_path / "old"))
    study = read_study(folder)
    assert (study.proved, len(study.records), study.plan.methods, study.plan.runs) == (False, 4, ("random", "ga"), 2)
    assert [len(read_evaluations(study, record.address)) for record in study.records] == [8] * 4
    last = study.records[-1].address
    with closing(sqlite3.connect(folder / STUDY)) as connection, connection:
        for table in ("run", "pace", "evaluations"):
            connection.execute(f"DELETE FROM {table} WHERE (scenario, method, run) = (?, ?, ?)", tuple(last))
    half = read_study(folder)
    store = StudyStore.reopen(folder)
    perform_all(half.plan, store.write, done=[record.address for record in half.records])
    store.close()
    again, old = read_study(folder).records[-1], study.records[-1]
    assert (repr(again.figures), again.course.tobytes()) == (repr(old.figures), old.course.tobytes())


@pytest.mark.parametrize("size", [0, 3000, 20_000])
def test_a_disk_without_space_for_a_study(size: int, plan: Plan, tmp_path: Path) -> None:
    """Nothing is left, and the cure does not offer to resume; an existing study is kept."""
    with small_files(size), pytest.raises(StoreError) as caught:
        StudyStore.create(tmp_path, plan, {})
    assert "free some space" in caught.value.cure
    assert "resume" not in caught.value.cure
    assert list(tmp_path.iterdir()) == []
    StudyStore.create(tmp_path, plan, {}).close()
    with pytest.raises(StoreError, match="exists already"):
        StudyStore.create(tmp_path, plan, {})
    assert read_study(tmp_path).plan.runs == plan.runs
