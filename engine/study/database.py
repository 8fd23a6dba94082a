"""A study on disk: `study.sqlite`, one transaction per run, and the compiled scenarios in a folder next to it.

A killed process loses at most the runs in flight. The *results* of runs (`run`, `evaluations`) are a pure function of
the plan, for any order of their ends; their durations (`pace`) are in a separate table.

| table       | one row for each                                                                      |
|-------------|---------------------------------------------------------------------------------------|
| manifest    | fact about the whole study, as JSON                                                   |
| scenario    | scenario: its name, file, manifest, and the digest of its program in `programs/NN.npz` |
| run         | finished run: its figures as JSON, their course over the generations as float64       |
| evaluations | finished run: every evaluation, see `engine.study.run_records`                            |
| pace        | finished run: seconds                                                                 |
| seal        | one row: a digest of all of these, and of each block by its digest                    |

The seal shows whether the contents of the file are still those that were written. Runs end in any order, so it is the
sum (exclusive or) of one digest per row: of manifest and scenarios, and of each run with its figures, its course, its
seconds and the digest of its block of evaluations. It is checked when the study is read; a block is compared with its
digest when the block is read.

`StudyStore` writes it; `read_study` reads it back, its plan with the compiled scenarios and its records, and
`read_evaluations` any run's evaluations.
"""

import json
import os
import sqlite3
from collections.abc import Iterable, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from hashlib import blake2b
from itertools import accumulate
from pathlib import Path, PurePath
from shutil import rmtree
from typing import Any

import numpy as np

from engine.errors import CortexError
from engine.program import ArchiveError, load_program, save_program
from engine.search.chain import LINK, actions_digest, either
from engine.search.evaluations import Evaluations
from engine.search.manifest import DrivenBy, config_from
from engine.search.past import recorded_driver, who_drove
from engine.search.protocol import DEFAULT_OBJECTIVES
from engine.search.store import SPACE_TO_BEGIN, StoreError, check_not_removed, located, refuse_empty, store_errors
from engine.streams import method_number, old_number
from engine.strict_json import json_text
from engine.study.plan import Address, Plan, Subject
from engine.study.run_records import FIELDS, DamagedBlock, Finished, RunRecord, flat, unflat, unpack

# -- the seal ----------------------------------------------------------------------------------------------------------

COUNTS = "SELECT (SELECT count(*) FROM run), (SELECT count(*) FROM pace), (SELECT count(*) FROM evaluations)"
SCENARIOS = "SELECT number, name, file, manifest, digest FROM scenario"
RUNS = """SELECT scenario, method, run, figures, course, seconds, digest
FROM run LEFT JOIN pace USING (scenario, method, run) LEFT JOIN evaluations USING (scenario, method, run)
ORDER BY run.rowid"""


def digest_of(block: bytes) -> bytes:
    """Return the digest of the stored evaluations of a run."""
    return blake2b(block, digest_size=LINK).digest()


def has_seal(connection: sqlite3.Connection) -> bool:
    """Return True if the study has a seal."""
    return connection.execute("SELECT 1 FROM sqlite_master WHERE name = 'seal'").fetchone() is not None


def seals_of(connection: sqlite3.Connection) -> list[bytes]:
    """Return the seals that fit the rows: before the first run, and after each run in the order of their writing."""
    facts = (*connection.execute("SELECT field, value FROM manifest"), *connection.execute(SCENARIOS))
    runs = (actions_digest([run]) for run in connection.execute(RUNS))
    return list(accumulate(runs, either, initial=actions_digest(facts)))


def broken_seal(connection: sqlite3.Connection, seal: bytes) -> bool:
    """Return True if some row is not as it was sealed, or there are more or fewer; `seal` is the last of `seals_of`."""
    counts = set(connection.execute(COUNTS).fetchone())
    return len(counts) != 1 or connection.execute("SELECT value FROM seal").fetchall() != [(seal,)]


def add_to_seal(connection: sqlite3.Connection, run: tuple[Any, ...]) -> None:
    """Add one run to the seal, within the transaction that writes it; `run` has the columns of `RUNS`."""
    (stored,) = connection.execute("SELECT value FROM seal").fetchone()
    connection.execute("UPDATE seal SET value = ?", (either(stored, actions_digest([run])),))


STUDY = "study.sqlite"
PROGRAMS = "programs"
STREAMS = "streams"
"""Key of a fact: numbers in the stream keys of methods that are numbered by their name."""
APPLICATION_ID = 0x43525354
"""File type mark of a study of cortexc ("CRST")."""
SCHEMA_VERSION = 3
"""Rises with every change of the tables, of `RunFigures` or of `Assessment`."""
WITHOUT_SEAL = 2  # readable and extendable, but not verifiable
_KEY = "scenario INTEGER NOT NULL, method TEXT NOT NULL, run INTEGER NOT NULL"
_SCHEMA = f"""
CREATE TABLE manifest (field TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE scenario (number INTEGER PRIMARY KEY, name TEXT, file TEXT, manifest TEXT, digest TEXT);
CREATE TABLE run ({_KEY}, figures TEXT NOT NULL, course BLOB NOT NULL, PRIMARY KEY (scenario, method, run));
CREATE TABLE evaluations ({_KEY}, block BLOB NOT NULL, digest BLOB NOT NULL, PRIMARY KEY (scenario, method, run));
CREATE TABLE pace ({_KEY}, seconds REAL NOT NULL, PRIMARY KEY (scenario, method, run));
CREATE TABLE seal (value BLOB NOT NULL);
PRAGMA application_id = {APPLICATION_ID};
PRAGMA user_version = {SCHEMA_VERSION};
"""


def is_study(folder: Path) -> bool:
    """Return True if the folder contains a study (and not a single run)."""
    return (folder / STUDY).is_file()


class StudyStore:
    """An open study that is being carried out; its `write` is an `on_run`."""

    def __init__(self, path: Path, connection: sqlite3.Connection) -> None:
        self.path = path
        self._connection = connection
        self._inode = path.stat().st_ino

    @classmethod
    def create(cls, folder: Path, plan: Plan, facts: dict[str, Any]) -> "StudyStore":
        """Start a study in an empty folder; `facts` are additional data for its readers.

        Raises:
            StoreError: the file cannot be written.
        """
        path, plan = folder / STUDY, replace(plan, subjects=tuple(each.seen_from(folder) for each in plan.subjects))
        with store_errors(path, SPACE_TO_BEGIN):
            if path.exists():
                raise StoreError(f"`{path}` exists already", "name another --out; a study is never overwritten")
            try:
                _save_programs(folder, plan)
                connection = opened(path, "rwc")
                rows = [(field, json_text(value)) for field, value in {**facts, **_document(plan)}.items()]
                connection.executescript(f"BEGIN; {_SCHEMA}")
                with connection:
                    connection.executemany("INSERT INTO manifest VALUES (?, ?)", rows)
                    connection.executemany("INSERT INTO scenario VALUES (?, ?, ?, ?, ?)", _scenario_rows(plan))
                    connection.execute("INSERT INTO seal VALUES (?)", (seals_of(connection)[-1],))
            except BaseException:
                rmtree(folder / PROGRAMS, ignore_errors=True)
                for partial in folder.glob(f"{STUDY}*"):
                    partial.unlink()
                raise
        return cls(path, connection)

    @classmethod
    def reopen(cls, folder: Path) -> "StudyStore":
        """Reopen a study that `read_study` has read.

        Raises:
            StoreError: the file cannot be written, or a method would draw different random numbers.
        """
        with store_errors(folder / STUDY):
            connection = opened(folder / STUDY, "rw")
            _check_streams(folder, connection)
            return cls(folder / STUDY, connection)

    def write(self, finished: Finished) -> None:
        """Add one run; after an error nothing of it is stored.

        Raises:
            StoreError: the file cannot be written, or was removed.
        """
        check_not_removed(self.path, self._inode)
        record = finished.record
        figures = json_text(flat(record.figures))
        course, where, seconds = record.course.astype("<f8").tobytes(), tuple(record.address), float(record.seconds)
        with store_errors(self.path), self._connection as connection:
            connection.execute("INSERT INTO run VALUES (?, ?, ?, ?, ?)", (*where, figures, course))
            connection.execute("INSERT INTO pace VALUES (?, ?, ?, ?)", (*where, seconds))
            if has_seal(connection):
                digest = digest_of(finished.block)
                connection.execute("INSERT INTO evaluations VALUES (?, ?, ?, ?, ?)", (*where, finished.block, digest))
                add_to_seal(connection, (*where, figures, course, seconds, digest))
            else:
                connection.execute("INSERT INTO evaluations VALUES (?, ?, ?, ?)", (*where, finished.block))

    def close(self) -> None:
        """Close the study and leave one file; two more remain if another process reads it or the disk is full."""
        with suppress(sqlite3.OperationalError):
            self._connection.execute("PRAGMA journal_mode = DELETE")
        self._connection.close()


def opened(path: Path, mode: str) -> sqlite3.Connection:
    """Return a connection that reads (`ro`), writes (`rw`), or creates the file first (`rwc`)."""
    connection = sqlite3.connect(f"{path.resolve().as_uri()}?mode={mode}", uri=True)
    if mode != "ro":
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = NORMAL")
    return connection


def _document(plan: Plan) -> dict[str, Any]:
    document = {"methods": plan.methods, "runs": plan.runs, "profile": plan.profile, "fields": FIELDS}
    document |= {} if plan.objective == DEFAULT_OBJECTIVES else {"objective": plan.objective}
    numbers = {method: method_number(method) for method in _numbered_by_name(plan.methods)}
    return {**document, STREAMS: numbers} if numbers else document


def _numbered_by_name(methods: Iterable[str]) -> list[str]:
    """Return the methods whose streams are numbered by their name."""
    return [method for method in methods if method_number(method) != old_number(method)]


def _check_streams(folder: Path, connection: sqlite3.Connection) -> None:
    """Raise StoreError unless each method draws from the streams of its finished runs."""
    facts = {field: json.loads(value) for field, value in connection.execute("SELECT * FROM manifest")}
    for method in _numbered_by_name(facts["methods"]):
        if facts.get(STREAMS, {}).get(method) != method_number(method):
            raise StoreError(
                f"the study in `{folder}` was begun when all searchers of other packages, `{method}` among them, drew "
                "the same random numbers",
                "report it as it is, or start a new one",
            )


def _save_programs(folder: Path, plan: Plan) -> None:
    (folder / PROGRAMS).mkdir(exist_ok=True)
    for number, subject in enumerate(plan.subjects):
        save_program(subject.program, program_file(folder, number))


def program_file(folder: Path, number: int) -> Path:
    return folder / PROGRAMS / f"{number + 1:02d}.npz"


def _scenario_rows(plan: Plan) -> Sequence[tuple[Any, ...]]:
    return [
        (
            number,
            subject.name,
            subject.file,
            json_text(plan.manifest(subject, plan.methods[0]).stored()),
            subject.program.digest,
        )
        for number, subject in enumerate(plan.subjects)
    ]


# -- reading -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Study:
    """A study as its folder holds it."""

    folder: Path
    plan: Plan
    records: tuple[RunRecord, ...]
    """Records of all finished runs, in the order of the plan."""
    manifest: dict[str, Any]
    edited: tuple[str, ...]
    """Files that have changed since the study began; the study uses their old contents."""
    proved: bool
    """True if the seal proves that all data are as written; False for a study without a seal."""
    seals: tuple[str, ...] = ()
    """Seals in hexadecimal, before the first run and after each run; empty for a study without a seal."""

    def driven_by(self, ego: object) -> "Study":
        """Return the study with its driver, which must be named again.

        Raises:
            StoreError: a different driver drove, or none.
        """
        subjects = tuple(self._driven(subject, ego) for subject in self.plan.subjects)
        return replace(self, plan=replace(self.plan, subjects=subjects))

    def _driven(self, subject: Subject, ego: object) -> Subject:
        driver = who_drove(self.folder, subject.config.driver, {}, ego)
        return replace(subject, config=replace(subject.config, driver=driver))

    @property
    def complete(self) -> bool:
        return len(self.records) == sum(1 for _ in self.plan.addresses())


def read_study(folder: Path) -> Study:
    """Read a study without its evaluations.

    Raises:
        StoreError: no such folder, not a study of cortexc, of another version, or damaged.
    """
    if not is_study(folder):
        raise StoreError(
            f"there is no study in `{folder}`", "name the folder of a study, such as runs/study-6x2x30-001"
        )
    path = folder / STUDY
    with store_errors(path), closing(opened(path, "ro")) as connection:
        proved = _check(path, connection)
        try:
            seals = seals_of(connection) if proved else []
            if proved and broken_seal(connection, seals[-1]):
                raise ValueError("it is not what was written: its seal is broken")
            manifest = {field: json.loads(value) for field, value in connection.execute("SELECT * FROM manifest")}
            plan = _plan(folder, connection, manifest)
            if not plan.subjects or not plan.methods:
                raise ValueError("it has lost its scenarios or its methods")
            records = _records(connection)
        except (ValueError, KeyError, TypeError, IndexError, AttributeError, ArchiveError) as error:
            raise _damaged(folder, error.message if isinstance(error, CortexError) else str(error)) from error
    ordered = tuple(records[address] for address in plan.addresses() if address in records)
    return Study(folder, plan, ordered, manifest, tuple(_edited(folder, plan)), proved, tuple(map(bytes.hex, seals)))


def read_evaluations(study: Study, address: Address) -> Evaluations:
    """Return the evaluations of one finished run, as its campaign held them.

    Raises:
        StoreError: the run is not finished, or its data are damaged.
    """
    path = study.folder / STUDY
    with store_errors(path), closing(opened(path, "ro")) as connection:
        query = "SELECT * FROM evaluations WHERE (scenario, method, run) = (?, ?, ?)"
        row = connection.execute(query, tuple(address)).fetchone()
    if row is None:
        raise StoreError(
            f"`{study.folder}` holds no finished run {address.run} of {address.method}", "go on with the study"
        )
    block = row[len(address)]
    if study.proved and digest_of(block) != row[-1]:
        raise _damaged(study.folder, f"evaluations of run {address.run} of {address.method} are not what was written")
    search = study.plan.subjects[address.scenario].config.search
    try:
        return unpack(block, search.seed, _number(study, address.method), address.run, search.aggregate)
    except DamagedBlock as error:
        raise _damaged(study.folder, str(error)) from error


def _number(study: Study, method: str) -> int:
    """Return the number of the method in the stream keys of the study."""
    return study.manifest.get(STREAMS, {}).get(method, old_number(method))


def _check(path: Path, connection: sqlite3.Connection) -> bool:
    """Check the file's type and version; return True if it has a seal."""
    refuse_empty(path)
    if connection.execute("PRAGMA application_id").fetchone()[0] != APPLICATION_ID:
        raise StoreError(f"`{path}` is a database of another program", "name the folder of a study")
    found = connection.execute("PRAGMA user_version").fetchone()[0]
    if found not in (SCHEMA_VERSION, WITHOUT_SEAL):
        raise StoreError(
            f"`{path}` has version {found} of a study, this program reads {WITHOUT_SEAL} and {SCHEMA_VERSION}",
            "use the version of cortexc that wrote it",
        )
    if has_seal(connection) != (found == SCHEMA_VERSION):
        raise _damaged(path.parent, "its version is not that of its tables")
    return found == SCHEMA_VERSION


def _damaged(folder: Path, why: str) -> StoreError:
    return StoreError(f"the study in `{folder}` is damaged: {why}", "restore it from a copy, or repeat it")


def _plan(folder: Path, connection: sqlite3.Connection, manifest: dict[str, Any]) -> Plan:
    rows = connection.execute("SELECT number, name, file, manifest, digest FROM scenario ORDER BY number")
    subjects = tuple(_subject(folder, *row) for row in rows)
    aims = tuple(manifest.get("objective", DEFAULT_OBJECTIVES))
    return Plan(subjects, tuple(manifest["methods"]), manifest["runs"], manifest["profile"], aims)


def _subject(folder: Path, number: int, name: str, file: str, manifest: str, digest: str) -> Subject:
    program = load_program(program_file(folder, number))
    if program.digest != digest:
        raise ValueError(f"{program_file(folder, number)} is not the program that the study is about")
    said = json.loads(manifest)
    driven = said.get("driver")
    driver = None if driven is None else recorded_driver(DrivenBy(**driven))
    return Subject(name, file, program, replace(config_from(said["settings"]), driver=driver))


def _records(connection: sqlite3.Connection) -> dict[Address, RunRecord]:
    query = "SELECT scenario, method, run, figures, course, seconds FROM run JOIN pace USING (scenario, method, run)"
    records: dict[Address, RunRecord] = {}
    for scenario, method, run, figures, course, seconds in connection.execute(query):
        address = Address(scenario, method, run)
        values = np.frombuffer(course, dtype="<f8").astype(np.float64).reshape(2, len(FIELDS), -1)
        records[address] = RunRecord(address, unflat(json.loads(figures)), values, seconds)
    return records


def _edited(folder: Path, plan: Plan) -> Sequence[str]:
    """Return the files of the study that exist and differ."""
    texts = {subject.file: subject.program.source_text for subject in plan.subjects}
    for subject in plan.subjects:
        beside = PurePath(subject.file).parent
        texts |= {os.path.normpath(beside / file.name): file.text for file in subject.program.imported}
    return [name for name, text in texts.items() if _differs(Path(located(folder, name)), text)]


def _differs(path: Path, text: str) -> bool:
    with suppress(OSError, ValueError):
        return path.is_file() and path.read_bytes().decode() != text
    return False
