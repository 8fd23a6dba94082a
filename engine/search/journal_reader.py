"""Reading a journal back: exactly what the campaign held when it was written."""

import json
import sqlite3
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import astuple, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from engine.outcomes import Assessment
from engine.search.assessment import SCALARS, from_columns, map_arrays, take
from engine.search.evaluations import (
    Evaluations,
    Figures,
    GenerationFigures,
    aggregate,
    generation_figures,
    goal_of,
)
from engine.search.journal import APPLICATION_ID, SCHEMA_VERSION
from engine.search.manifest import Manifest, read_manifest
from engine.search.store import StoreError, example_run, store_errors
from engine.search.typed import ManifestError
from engine.tables import Floats, Ints


@dataclass(frozen=True)
class Record:
    """A run as its journal holds it."""

    manifest: Manifest
    evaluations: Evaluations
    generations: tuple[GenerationFigures, ...]
    status: str
    """`running` (or killed), `stopped`, `finished`."""
    seconds: float
    """NaN unless stopped or finished."""
    spent: float
    """Until the last generation was written [s]."""
    actions: Mapping[bytes, Floats] = field(default_factory=dict[bytes, Floats])
    """What controllers decided, (turns, numbers) by the bytes of a scene's key, where it is kept."""

    def past(self) -> list[Evaluations]:
        """The evaluations of each generation, as `run_campaign` takes them."""
        generation = self.evaluations.places[:, 0]
        return [take(self.evaluations, generation == number) for number in range(len(self.generations))]


def read_journal(path: Path) -> Record:
    """Read a whole run.

    Raises:
        StoreError: no such file, not a journal of ours, of a newer version, or damaged.
    """
    if not path.is_file():
        raise StoreError(f"there is no journal at `{path}`", f"name the folder of a run, such as {example_run()}")
    with store_errors(path), closing(_opened(path)) as connection:
        _check(path, connection)
        try:
            return _consistent(_record(connection))
        except ManifestError as error:
            raise damaged(path, error) from error
        except (ValueError, KeyError, TypeError, IndexError, AttributeError, OverflowError) as error:
            raise damaged(path, f"what it holds does not fit together ({type(error).__name__})") from error


def damaged(path: Path, why: object) -> StoreError:
    """Return the error for a journal that was changed from outside."""
    return StoreError(f"`{path}` is damaged: {why}", "restore it from a copy, or repeat the run")


def _opened(path: Path) -> sqlite3.Connection:
    """A connection that only reads. What a process left half done when it was killed is taken back before."""
    address = f"{path.resolve().as_uri()}?mode="
    connection = sqlite3.connect(f"{address}ro", uri=True)
    try:
        connection.execute("SELECT count(*) FROM sqlite_master")
    except sqlite3.OperationalError as error:
        connection.close()
        if error.sqlite_errorcode & 0xFF != sqlite3.SQLITE_READONLY:
            raise
        with closing(sqlite3.connect(f"{address}rw", uri=True)) as writer:
            writer.execute("SELECT count(*) FROM sqlite_master")
        return sqlite3.connect(f"{address}ro", uri=True)
    return connection


def _record(connection: sqlite3.Connection) -> Record:
    manifest = _manifest(connection)
    status, seconds = connection.execute("SELECT status, seconds FROM status").fetchone()
    if not isinstance(status, str) or not isinstance(seconds, float | int | None):
        raise TypeError("a status is a word and its seconds a number")
    figures = connection.execute("SELECT generation, figures FROM generation ORDER BY generation").fetchall()
    return Record(
        manifest=manifest,
        evaluations=_evaluations(connection, manifest),
        generations=tuple(_figures(generation, text) for generation, text in figures),
        status=status,
        seconds=float("nan") if seconds is None else seconds,
        spent=_spent(connection),
        actions=_actions(connection),
    )


def _consistent(record: Record) -> Record:
    """The record, each of whose generations has the figures that follow from its individuals.

    Raises:
        ValueError: rows were lost or changed since they were written.
    """
    if len(record.evaluations) != sum(each.by_individual.individuals for each in record.generations):
        raise ValueError
    for past, written in zip(record.past(), record.generations, strict=True):
        found = generation_figures(past, written.generation)
        for name in ("by_individual", "by_simulation"):
            pair = [[float(number) for number in astuple(getattr(each, name))] for each in (found, written)]
            if not np.allclose(*pair, rtol=1e-9, atol=0.0, equal_nan=True):
                raise ValueError
    return record


def _actions(connection: sqlite3.Connection) -> dict[bytes, Floats]:
    """Of a run in which a controller drives."""
    if not connection.execute("SELECT count(*) FROM sqlite_master WHERE name = 'action'").fetchone()[0]:
        return {}
    rows = connection.execute("SELECT key, turns, numbers, decided FROM action").fetchall()
    return {key: np.frombuffer(decided, dtype="<f8").reshape(turns, numbers) for key, turns, numbers, decided in rows}


def _spent(connection: sqlite3.Connection) -> float:
    """What a run took is read beside its results, which are complete without it."""
    if not connection.execute("SELECT count(*) FROM sqlite_master WHERE name = 'pace'").fetchone()[0]:
        return 0.0
    return connection.execute("SELECT coalesce(max(seconds), 0.0) FROM pace").fetchone()[0]


def _check(path: Path, connection: sqlite3.Connection) -> None:
    if connection.execute("PRAGMA application_id").fetchone()[0] != APPLICATION_ID:
        raise StoreError(f"`{path}` is a database of another program", "name the folder of a run")
    found = connection.execute("PRAGMA user_version").fetchone()[0]
    if found != SCHEMA_VERSION:
        raise StoreError(
            f"`{path}` has version {found} of the journal, this program reads {SCHEMA_VERSION}",
            "use the version of cortexc that wrote it",
        )
    kept = [row[1] for row in connection.execute("PRAGMA table_info(simulation)")][3:]
    if tuple(kept) not in ((*SCALARS, "counts"), (*SCALARS, "counts", "sought")):
        raise StoreError(f"`{path}` keeps other results than this program", "use the version of cortexc that wrote it")


def _manifest(connection: sqlite3.Connection) -> Manifest:
    rows = connection.execute("SELECT field, value FROM manifest")
    return read_manifest({field: _json(field, value) for field, value in rows})


def _json(field: str, value: str) -> Any:
    try:
        return json.loads(value)
    except (ValueError, TypeError, RecursionError):
        raise ManifestError(f"`{field}` of its manifest must be JSON") from None


def _figures(generation: int, text: str) -> GenerationFigures:
    tables = json.loads(text)
    by = {name: Figures(**{key: _number(value) for key, value in table.items()}) for name, table in tables.items()}
    return GenerationFigures(generation, **by)


def _number(value: Any) -> Any:
    return float("nan") if value is None else value


def _evaluations(connection: sqlite3.Connection, manifest: Manifest) -> Evaluations:
    rows = connection.execute("SELECT * FROM individual ORDER BY generation, place").fetchall()
    integers = np.array([row[:11] for row in rows], dtype=np.int32).reshape(len(rows), 11)
    genomes = np.frombuffer(b"".join(row[12] for row in rows), dtype="<f8").astype(np.float64)
    births = integers[:, 2:4]
    names, runs = _simulations(connection, manifest)
    at = np.array([names[generation, place] for generation, place in births.tolist()], dtype=np.int64)
    rollouts = map_arrays(runs, lambda array: array[at])
    valid = rollouts.verdict == 0
    return Evaluations(
        genomes=genomes.reshape(len(rows), len(manifest.parameters)),
        places=integers[:, 0:2],
        births=births,
        operator=integers[:, 5],
        parents=integers[:, 6:10].reshape(-1, 2, 2),
        reused=integers[:, 4].astype(bool),
        verdict=integers[:, 10],
        fitness=aggregate(goal_of(rollouts), valid, manifest.settings["search"]["aggregate"]),
        keys=_keys(births, rollouts.verdict.shape[1], manifest),
        rollouts=rollouts,
    )


def _simulations(connection: sqlite3.Connection, manifest: Manifest) -> tuple[dict[tuple[int, int], int], Assessment]:
    """Row of each birth, and all simulations as arrays (births, k, …)."""
    rows = connection.execute("SELECT * FROM simulation ORDER BY generation, place, rollout").fetchall()
    births = {birth: number for number, birth in enumerate(dict.fromkeys((row[0], row[1]) for row in rows))}
    values = list(zip(*rows, strict=True)) or [()] * (len(SCALARS) + 5)
    end, requirements = 3 + len(SCALARS), len(manifest.requirements)
    columns = {name: list(column) for name, column in zip(SCALARS, values[3:end], strict=True)}
    counts = np.frombuffer(b"".join(values[end]), dtype="<i4").astype(np.int64).reshape(len(rows), 2, requirements)
    others = _sought(values[end + 1], manifest) if manifest.keeps_sought else _nothing_sought(columns)
    runs = from_columns(columns, tested=counts[:, 0], failed=counts[:, 1], **others)
    rollouts = len(rows) // max(1, len(births))
    return births, map_arrays(runs, lambda array: array.reshape(len(births), rollouts, *array.shape[1:]))


def _sought(blobs: Sequence[bytes], manifest: Manifest) -> dict[str, Any]:
    aims, expected = manifest.aims, len(manifest.objectives)
    numbers = np.frombuffer(b"".join(blobs), dtype="<f8").astype(np.float64).reshape(len(blobs), aims + expected + 1)
    return {"sought": numbers[:, :aims], "broken": numbers[:, aims:-1], "found": numbers[:, -1] == 1.0}


def _nothing_sought(columns: Mapping[str, Sequence[Any]]) -> dict[str, Any]:
    count = len(columns["collided"])
    nothing = np.zeros((count, 0))
    return {"sought": nothing, "broken": nothing, "found": np.array(columns["collided"], dtype=bool).reshape(count)}


def _keys(births: Ints, rollouts: int, manifest: Manifest) -> Ints:
    """(n, k, 6) stream keys."""
    keys = np.empty((len(births), rollouts, 6), dtype=np.int64)
    keys[:] = (manifest.seed, manifest.method_number, manifest.run, 0, 0, 0)
    keys[:, :, 3:5] = births[:, np.newaxis]
    keys[:, :, 5] = np.arange(rollouts)
    return keys
