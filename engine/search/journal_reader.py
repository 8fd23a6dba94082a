"""Reader of journals: it returns exactly the data of the campaign that wrote them."""

import json
import sqlite3
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import astuple, dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from engine.assessment import COLUMNS, SCALARS, from_columns, map_arrays, take
from engine.errors import Signal
from engine.outcomes import Assessment
from engine.search.chain import BEGINNING, Array, actions_digest, broken_parts, link, numbers, whole_numbers
from engine.search.evaluations import (
    Evaluations,
    Figures,
    GenerationFigures,
    aggregate,
    counted,
    generation_figures,
    goal_of,
)
from engine.search.journal import APPLICATION_ID, SCHEMA_VERSION, WITHOUT_CHAIN, has_chain
from engine.search.manifest import Manifest, ManifestError, read_manifest
from engine.search.store import StoreError, example_run, refuse_empty, store_errors
from engine.tables import Floats, Ints

Reader = Callable[[tuple[Any, ...]], Array]
"""Function from the values of a column to its array."""
AT_ONCE = 20_000
"""Rows that are read as Python objects at once."""
NO_DAMAGE = (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED, sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_READONLY)
"""Error codes of SQLite that do not mean that the file is damaged."""


@dataclass(frozen=True)
class Record:
    """A run as its journal holds it."""

    manifest: Manifest
    evaluations: Evaluations
    generations: tuple[GenerationFigures, ...]
    status: str
    """`running` (or killed), or a status of `engine.search.campaign`."""
    seconds: float
    """NaN while it is running, and if it was killed."""
    spent: float
    """Time until the last generation was written [s]."""
    actions: Mapping[bytes, Floats] = field(default_factory=dict[bytes, Floats])
    """Decisions of controllers, (turns, numbers) by the bytes of a scene's key, where they are stored."""
    links: tuple[str, ...] = ()
    """Links of the chain in hexadecimal, the first of them before the first generation; empty for a journal from before
    there were chains.
    """
    proved: bool = False
    """True if the chain proves that all data are as written (`engine.search.chain`); False without a chain."""

    @property
    def link(self) -> str:
        """Last link of the chain; empty if there is none."""
        return self.links[-1] if self.links else ""

    def past(self) -> list[Evaluations]:
        """Return the evaluations of each generation, as input of `run_campaign`; arrays are views of the whole."""
        edges = np.searchsorted(self.evaluations.places[:, 0], np.arange(len(self.generations) + 1)).tolist()
        return [take(self.evaluations, slice(*edge)) for edge in pairwise(edges)]


def read_journal(path: Path) -> Record:
    """Read a whole run.

    Raises:
        StoreError: the file is missing, is not a journal of cortexc, has a newer version, or is damaged.
    """
    if not path.is_file():
        raise StoreError(f"there is no journal at `{path}`", f"name the folder of a run, such as {example_run()}")
    with store_errors(path), closing(_opened(path)) as connection:
        connection.execute("BEGIN")  # one consistent snapshot, even while a process writes
        _check(path, connection)
        try:
            return _consistent(_record(connection))
        except (ManifestError, BrokenChainError) as error:
            raise damaged(path, error) from error
        except sqlite3.DatabaseError as error:
            if getattr(error, "sqlite_errorcode", 0) & 0xFF in NO_DAMAGE:
                raise
            raise damaged(path, error) from error
        except (ValueError, KeyError, TypeError, IndexError, AttributeError, OverflowError, RecursionError) as error:
            raise damaged(path, f"what it holds does not fit together ({type(error).__name__})") from error


def damaged(path: Path, why: object) -> StoreError:
    """Return the error for a journal that was changed from outside."""
    return StoreError(f"`{path}` is damaged: {why}", "restore it from a copy, or repeat the run")


def _opened(path: Path) -> sqlite3.Connection:
    """Return a read-only connection. The unfinished transaction of a killed process is rolled back first."""
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
    individuals, simulations = _individuals(connection, manifest), _simulations(connection, manifest)
    figures = connection.execute("SELECT generation, figures FROM generation ORDER BY generation").fetchall()
    proved = has_chain(connection)
    links = _checked_links(connection, individuals, simulations) if proved else ()
    stored = _action_rows(connection)
    if proved and (broken := broken_parts(connection, actions_digest(stored))):
        raise BrokenChainError(" and ".join(f"`{name}`" for name in broken) + " is not what was written")
    return Record(
        manifest=manifest,
        evaluations=_evaluations(individuals, simulations, manifest),
        generations=tuple(_figures(generation, text) for generation, text in figures),
        status=status,
        seconds=float("nan") if seconds is None else seconds,
        spent=_spent(connection),
        actions={key: np.frombuffer(each, dtype="<f8").reshape(turns, wide) for key, turns, wide, each in stored},
        links=links,
        proved=proved,
    )


class BrokenChainError(Signal, ValueError):
    """Stored rows differ from those that were written."""


def _checked_links(
    connection: sqlite3.Connection, individuals: tuple[Array, ...], simulations: tuple[Array, ...]
) -> tuple[str, ...]:
    """Recompute the link of every generation; return all links in hexadecimal, after `BEGINNING`.

    Raises:
        BrokenChainError: a link differs from the stored one.
    """
    rows = connection.execute("SELECT generation, figures, link FROM generation ORDER BY generation").fetchall()
    born, simulated = individuals[0][:, 0], simulations[0]
    if [row[0] for row in rows] != list(range(len(rows))) or max(
        born.max(initial=-1), simulated.max(initial=-1)
    ) >= len(rows):
        raise BrokenChainError("its generations are not those that were written")
    before, links = BEGINNING, [BEGINNING.hex()]
    for generation, figures, stored in rows:
        parts = [
            [array[slice(*np.searchsorted(order, (generation, generation + 1)))] for array in table]
            for order, table in ((born, individuals), (simulated, simulations))
        ]
        before = link(before, figures, *parts)
        if before != stored:
            raise BrokenChainError(f"generation {generation} is not what was written")
        links.append(before.hex())
    return tuple(links)


def _consistent(record: Record) -> Record:
    """Return the record after a check that the figures of each generation follow from its individuals.

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


def _action_rows(connection: sqlite3.Connection) -> list[tuple[Any, ...]]:
    """Return the stored decisions; [] unless a controller drives."""
    if not connection.execute("SELECT count(*) FROM sqlite_master WHERE name = 'action'").fetchone()[0]:
        return []
    return connection.execute("SELECT key, turns, numbers, decided FROM action").fetchall()


def _spent(connection: sqlite3.Connection) -> float:
    """Return the time until the last generation was written [s]; the results are complete without it."""
    if not connection.execute("SELECT count(*) FROM sqlite_master WHERE name = 'pace'").fetchone()[0]:
        return 0.0
    return connection.execute("SELECT coalesce(max(seconds), 0.0) FROM pace").fetchone()[0]


def _check(path: Path, connection: sqlite3.Connection) -> None:
    refuse_empty(path)
    if connection.execute("PRAGMA application_id").fetchone()[0] != APPLICATION_ID:
        raise StoreError(f"`{path}` is a database of another program", "name the folder of a run")
    found = connection.execute("PRAGMA user_version").fetchone()[0]
    if found not in (SCHEMA_VERSION, WITHOUT_CHAIN):
        raise StoreError(
            f"`{path}` has version {found} of the journal, this program reads {WITHOUT_CHAIN} and {SCHEMA_VERSION}",
            "use the version of cortexc that wrote it",
        )
    if has_chain(connection) != (found == SCHEMA_VERSION):
        raise damaged(path, "its version is not that of its tables")
    stored = [row[1] for row in connection.execute("PRAGMA table_info(simulation)")][3:]
    if tuple(stored) not in ((*SCALARS, "counts"), (*SCALARS, "counts", "sought")):
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


def _evaluations(individuals: tuple[Array, ...], simulations: tuple[Array, ...], manifest: Manifest) -> Evaluations:
    integers, _, genomes = individuals
    integers = integers.astype(np.int32)
    births = integers[:, 2:4]
    names, runs = _runs(simulations, manifest)
    at = np.array([names[generation, place] for generation, place in births.tolist()], dtype=np.int64)
    rollouts = map_arrays(runs, lambda array: array[at])
    return Evaluations(
        genomes=genomes,
        places=integers[:, 0:2],
        births=births,
        operator=integers[:, 5],
        parents=integers[:, 6:10].reshape(-1, 2, 2),
        reused=integers[:, 4].astype(bool),
        verdict=integers[:, 10],
        fitness=aggregate(goal_of(rollouts), counted(rollouts), manifest.settings["search"]["aggregate"]),
        keys=_keys(births, rollouts.verdict.shape[1], manifest),
        rollouts=rollouts,
    )


def _individuals(connection: sqlite3.Connection, manifest: Manifest) -> tuple[Array, ...]:
    """Return the arrays of the individuals as the writer had them: integers (n, 11), fitness (n,), genomes (n, d)."""
    readers: list[Reader] = [whole_numbers] * 11 + [numbers, _reader("<f8", len(manifest.parameters))]
    *integers, fitness, genomes = _columns(connection, "individual ORDER BY generation, place", readers)
    return np.stack(integers, axis=1), fitness, genomes.astype(np.float64)


def _simulations(connection: sqlite3.Connection, manifest: Manifest) -> tuple[Array, ...]:
    """Return the arrays of the simulations as the writer had them: one per column, blobs as (n, m)."""
    kinds = [int] * 3 + [row.kind for row in COLUMNS for _ in row.columns]
    readers: list[Reader] = [numbers if kind is float else whole_numbers for kind in kinds]
    readers.append(_reader("<i4", 2 * len(manifest.requirements)))
    if manifest.keeps_sought:
        readers.append(_reader("<f8", manifest.aims + len(manifest.objectives) + 1))
    return tuple(_columns(connection, "simulation ORDER BY generation, place, rollout", readers))


def _columns(connection: sqlite3.Connection, table: str, readers: Sequence[Reader]) -> list[Array]:
    """Return the columns of a table, each made by its reader, some rows after the other.

    Raises:
        ValueError: the table has more or fewer columns.
    """
    cursor = connection.execute(f"SELECT * FROM {table}")  # noqa: S608
    if len(cursor.description) != len(readers):
        raise ValueError("values of objectives must be stored if the run has some beside the risk, and only then")
    parts = [[reader(()) for reader in readers]]
    while rows := cursor.fetchmany(AT_ONCE):
        parts.append([reader(column) for reader, column in zip(readers, zip(*rows, strict=True), strict=True)])
    return [np.concatenate(column) for column in zip(*parts, strict=True)]


def _reader(kind: str, wide: int) -> Reader:
    """Return a reader of blobs, each with `wide` numbers, as rows."""
    return lambda blobs: np.frombuffer(b"".join(blobs), dtype=kind).reshape(len(blobs), wide)


def _runs(simulations: tuple[Array, ...], manifest: Manifest) -> tuple[dict[tuple[int, int], int], Assessment]:
    """Return the row of each birth, and all simulations as arrays (births, k, …)."""
    generation, place = simulations[:2]
    count, columns = len(generation), dict(zip(SCALARS, simulations[3:], strict=False))
    born = dict.fromkeys(zip(generation.tolist(), place.tolist(), strict=True))
    births = {birth: number for number, birth in enumerate(born)}
    counts, *sought = simulations[3 + len(SCALARS) :]
    counts = counts.astype(np.int64).reshape(count, 2, len(manifest.requirements))
    others = _sought(sought[0], manifest) if sought else _nothing_sought(columns)
    runs = from_columns(columns, tested=counts[:, 0], failed=counts[:, 1], **others)
    rollouts = count // max(1, len(births))
    return births, map_arrays(runs, lambda array: array.reshape(len(births), rollouts, *array.shape[1:]))


def _sought(table: Array, manifest: Manifest) -> dict[str, Any]:
    aims, values = manifest.aims, table.astype(np.float64)
    return {"sought": values[:, :aims], "broken": values[:, aims:-1], "found": values[:, -1] == 1.0}


def _nothing_sought(columns: Mapping[str, Array]) -> dict[str, Any]:
    nothing = np.zeros((len(columns["collided"]), 0))
    return {"sought": nothing, "broken": nothing, "found": columns["collided"].astype(bool)}


def _keys(births: Ints, rollouts: int, manifest: Manifest) -> Ints:
    """Return (n, k, 6) stream keys."""
    keys = np.empty((len(births), rollouts, 6), dtype=np.int64)
    keys[:] = (manifest.seed, manifest.method_number, manifest.run, 0, 0, 0)
    keys[:, :, 3:5] = births[:, np.newaxis]
    keys[:, :, 5] = np.arange(rollouts)
    return keys
