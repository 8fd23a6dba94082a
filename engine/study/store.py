"""A study on disk: `study.sqlite`, one transaction a run, and the compiled scenarios beside it.

A killed process loses at most the runs in flight. What the runs *found* (`run`, `evaluations`) is a pure function of
the plan, in whatever order they ended; what they took (`pace`) lies in a table of its own.

| table       | one row for each                                                                      |
|-------------|---------------------------------------------------------------------------------------|
| manifest    | fact about the whole study, as JSON                                                   |
| scenario    | scenario: its name, file, manifest, and the digest of its program in `programs/NN.npz` |
| run         | finished run: its figures as JSON, their course over the generations as float64       |
| evaluations | finished run: every evaluation, see `engine.study.block`                              |
| pace        | finished run: seconds                                                                 |
"""

import json
import sqlite3
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

from engine.program import save_program
from engine.search.journal import finite
from engine.search.store import insist_on, store_errors
from engine.study.plan import Plan, Subject
from engine.study.records import FIELDS, Finished, flat

STUDY = "study.sqlite"
PROGRAMS = "programs"
APPLICATION_ID = 0x43525354
"""Marks the file as ours ("CRST")."""
SCHEMA_VERSION = 1
"""Rises with every change of the tables, of `RunFigures` or of `Assessment`."""
_KEY = "scenario INTEGER NOT NULL, method TEXT NOT NULL, run INTEGER NOT NULL"
_SCHEMA = f"""
CREATE TABLE manifest (field TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE scenario (number INTEGER PRIMARY KEY, name TEXT, file TEXT, manifest TEXT, digest TEXT);
CREATE TABLE run ({_KEY}, figures TEXT NOT NULL, course BLOB NOT NULL, PRIMARY KEY (scenario, method, run));
CREATE TABLE evaluations ({_KEY}, block BLOB NOT NULL, PRIMARY KEY (scenario, method, run));
CREATE TABLE pace ({_KEY}, seconds REAL NOT NULL, PRIMARY KEY (scenario, method, run));
PRAGMA application_id = {APPLICATION_ID};
PRAGMA user_version = {SCHEMA_VERSION};
"""


def is_study(folder: Path) -> bool:
    """Whether the folder holds a study (and not a single run)."""
    return (folder / STUDY).is_file()


class StudyStore:
    """An open study that is being carried out; its `write` is an `on_run`."""

    def __init__(self, path: Path, connection: sqlite3.Connection) -> None:
        self.path = path
        self._connection = connection
        self._inode = path.stat().st_ino

    @classmethod
    def create(cls, folder: Path, plan: Plan, facts: dict[str, Any]) -> "StudyStore":
        """Start a study in a folder that exists and is empty; `facts` are whatever its readers should know.

        Raises:
            StoreError: it cannot be written.
        """
        path = folder / STUDY
        with store_errors(path):
            _save_programs(folder, plan)
            connection = opened(path, "rwc")
            rows = [(field, json.dumps(finite(value))) for field, value in {**facts, **_document(plan)}.items()]
            connection.executescript(f"BEGIN; {_SCHEMA}")
            with connection:
                connection.executemany("INSERT INTO manifest VALUES (?, ?)", rows)
                connection.executemany("INSERT INTO scenario VALUES (?, ?, ?, ?, ?)", _scenario_rows(plan))
        return cls(path, connection)

    @classmethod
    def reopen(cls, folder: Path) -> "StudyStore":
        """Go on with a study that `reading.read_study` has read.

        Raises:
            StoreError: it cannot be written.
        """
        with store_errors(folder / STUDY):
            return cls(folder / STUDY, opened(folder / STUDY, "rw"))

    def write(self, finished: Finished) -> None:
        """Add one run: all of it or, if anything goes wrong, nothing.

        Raises:
            StoreError: it cannot be written, or was removed.
        """
        insist_on(self.path, self._inode)
        record = finished.record
        figures = json.dumps(finite(flat(record.figures)), allow_nan=False)
        with store_errors(self.path), self._connection as connection:
            connection.execute(
                "INSERT INTO run VALUES (?, ?, ?, ?, ?)",
                (*record.address, figures, record.course.astype("<f8").tobytes()),
            )
            connection.execute("INSERT INTO evaluations VALUES (?, ?, ?, ?)", (*record.address, finished.block))
            connection.execute("INSERT INTO pace VALUES (?, ?, ?, ?)", (*record.address, record.seconds))

    def close(self) -> None:
        """Leave one plain file behind; two more beside it where somebody is reading, or the disk is full."""
        with suppress(sqlite3.OperationalError):
            self._connection.execute("PRAGMA journal_mode = DELETE")
        self._connection.close()


def opened(path: Path, mode: str) -> sqlite3.Connection:
    """A connection that reads (`ro`), or writes (`rw`), or makes the file first (`rwc`)."""
    connection = sqlite3.connect(f"{path.resolve().as_uri()}?mode={mode}", uri=True)
    if mode != "ro":
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = NORMAL")
    return connection


def _document(plan: Plan) -> dict[str, Any]:
    return {"methods": plan.methods, "runs": plan.runs, "profile": plan.profile, "fields": FIELDS}


def _save_programs(folder: Path, plan: Plan) -> None:
    (folder / PROGRAMS).mkdir(exist_ok=True)
    for number, subject in enumerate(plan.subjects):
        save_program(subject.program, program_file(folder, number))


def program_file(folder: Path, number: int) -> Path:
    return folder / PROGRAMS / f"{number + 1:02d}.npz"


def _scenario_rows(plan: Plan) -> Sequence[tuple[Any, ...]]:
    return [
        (number, subject.name, subject.file, _manifest_json(plan, subject), subject.program.digest)
        for number, subject in enumerate(plan.subjects)
    ]


def _manifest_json(plan: Plan, subject: Subject) -> str:
    return json.dumps(finite(asdict(plan.manifest(subject, plan.methods[0]))))
