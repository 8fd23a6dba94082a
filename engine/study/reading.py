"""Reading a study back: its plan with the compiled scenarios, its records, and any run's evaluations."""

import json
import sqlite3
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from engine import archive
from engine.config import Config, ContactConfig, GAConfig, SearchConfig, SimulationConfig
from engine.errors import CortexError
from engine.search.evaluations import Evaluations
from engine.search.searchers import method_of
from engine.search.store import StoreError, store_errors
from engine.study.block import DamagedBlock, unpack
from engine.study.plan import Address, Plan, Subject
from engine.study.records import FIELDS, RunRecord, unflat
from engine.study.store import APPLICATION_ID, SCHEMA_VERSION, STUDY, is_study, opened, program_file


@dataclass(frozen=True)
class Study:
    """A study as its folder tells it."""

    folder: Path
    plan: Plan
    records: tuple[RunRecord, ...]
    """Of all finished runs, in the order of the plan."""
    manifest: dict[str, Any]
    edited: tuple[str, ...]
    """Files that say something else now; the study goes by what they said when it was begun."""

    @property
    def complete(self) -> bool:
        plan = self.plan
        return len(self.records) == plan.runs * len(plan.subjects) * len(plan.methods)


def read_study(folder: Path) -> Study:
    """Read a study without its evaluations.

    Raises:
        StoreError: no such folder, not a study of ours, of another version, or damaged.
    """
    if not is_study(folder):
        raise StoreError(
            f"there is no study in `{folder}`", "name the folder of a study, such as runs/study-6x2x30-001"
        )
    path = folder / STUDY
    with store_errors(path), closing(opened(path, "ro")) as connection:
        _check(path, connection)
        try:
            manifest = {field: json.loads(value) for field, value in connection.execute("SELECT * FROM manifest")}
            plan = _plan(folder, connection, manifest)
            records = _records(connection)
        except (ValueError, KeyError, TypeError, IndexError, AttributeError, archive.ArchiveError) as error:
            raise _damaged(folder, error.message if isinstance(error, CortexError) else str(error)) from error
    ordered = tuple(records[address] for address in plan.addresses() if address in records)
    return Study(folder, plan, ordered, manifest, tuple(_edited(plan)))


def read_evaluations(study: Study, address: Address) -> Evaluations:
    """Every evaluation of one finished run, as its campaign held them.

    Raises:
        StoreError: the run is not finished, or what is stored of it is damaged.
    """
    path = study.folder / STUDY
    with store_errors(path), closing(opened(path, "ro")) as connection:
        query = "SELECT block FROM evaluations WHERE (scenario, method, run) = (?, ?, ?)"
        row = connection.execute(query, tuple(address)).fetchone()
    if row is None:
        raise StoreError(
            f"`{study.folder}` holds no finished run {address.run} of {address.method}", "go on with the study"
        )
    search = study.plan.subjects[address.scenario].config.search
    try:
        return unpack(row[0], search.seed, int(method_of(address.method)), address.run, search.aggregate)
    except DamagedBlock as error:
        raise _damaged(study.folder, str(error)) from error


def _check(path: Path, connection: sqlite3.Connection) -> None:
    if connection.execute("PRAGMA application_id").fetchone()[0] != APPLICATION_ID:
        raise StoreError(f"`{path}` is a database of another program", "name the folder of a study")
    found = connection.execute("PRAGMA user_version").fetchone()[0]
    if found != SCHEMA_VERSION:
        raise StoreError(
            f"`{path}` has version {found} of a study, this program reads {SCHEMA_VERSION}",
            "use the version of cortexc that wrote it",
        )


def _damaged(folder: Path, why: str) -> StoreError:
    return StoreError(f"the study in `{folder}` is damaged: {why}", "restore it from a copy, or repeat it")


def _plan(folder: Path, connection: sqlite3.Connection, manifest: dict[str, Any]) -> Plan:
    rows = connection.execute("SELECT number, name, file, manifest, digest FROM scenario ORDER BY number")
    subjects = tuple(_subject(folder, *row) for row in rows)
    return Plan(subjects, tuple(manifest["methods"]), manifest["runs"], manifest["profile"])


def _subject(folder: Path, number: int, name: str, file: str, manifest: str, digest: str) -> Subject:
    program = archive.load(program_file(folder, number))
    if program.digest != digest:
        raise ValueError(f"{program_file(folder, number)} is not the program that the study is about")
    parts = json.loads(manifest)["settings"]
    config = Config(
        simulation=SimulationConfig(**parts["simulation"]),
        contact=ContactConfig(**parts["contact"]),
        search=SearchConfig(**parts["search"]),
        ga=GAConfig(**parts["ga"]),
    )
    return Subject(name, file, program, config)


def _records(connection: sqlite3.Connection) -> dict[Address, RunRecord]:
    query = "SELECT scenario, method, run, figures, course, seconds FROM run JOIN pace USING (scenario, method, run)"
    records = {}
    for scenario, method, run, figures, course, seconds in connection.execute(query):
        address = Address(scenario, method, run)
        values = np.frombuffer(course, dtype="<f8").astype(np.float64).reshape(2, len(FIELDS), -1)
        records[address] = RunRecord(address, unflat(json.loads(figures)), values, seconds)
    return records


def _edited(plan: Plan) -> Sequence[str]:
    """Files of the study that are there and differ."""
    texts = {subject.file: subject.program.source_text for subject in plan.subjects}
    texts |= {file.name: file.text for subject in plan.subjects for file in subject.program.imported}
    return [name for name, text in texts.items() if _differs(Path(name), text)]


def _differs(path: Path, text: str) -> bool:
    try:
        return path.is_file() and path.read_bytes().decode() != text
    except (OSError, ValueError):
        return False
