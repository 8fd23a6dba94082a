"""Reader of journals: it returns exactly the data of the campaign that wrote them."""

import json
import sqlite3
import zlib
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from engine.assessment import COLUMNS, SCALARS, take, with_room
from engine.errors import Signal
from engine.outcomes import Assessment
from engine.search.chain import (
    BEGINNING,
    Array,
    actions_digest,
    broken_parts,
    link,
    numbers,
    verdicts_of,
    whole_numbers,
)
from engine.search.evaluations import (
    Evaluations,
    Figures,
    GenerationFigures,
    aggregate,
    counted,
    generation_figures,
    goal_of,
)
from engine.search.insight.kinds import collisions_of
from engine.search.journal import APPLICATION_ID, SCHEMA_VERSION, WITHOUT_CHAIN, has_chain
from engine.search.manifest import Manifest, ManifestError, read_manifest
from engine.search.store import StoreError, example_run, refuse_empty, store_errors
from engine.tables import Floats, Ints
from engine.vocabulary import Blame

AT_ONCE = 500
"""Rows that are read as Python objects at once: few enough to stay in the cache of a processor."""
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
    seal: bytes = b""
    """Seal of the journal; empty without a chain."""
    links: tuple[str, ...] = ()
    """Links of the chain in hexadecimal, the first of them before the first generation; empty for a journal from before
    there were chains.
    """
    blame: Ints | None = None
    """(n, k) `Blame` of each rollout as the analysis of the run found it; None if it is not stored."""
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


@dataclass(frozen=True)
class _Individuals:
    """Table of individuals as the writer had it."""

    integers: Ints
    """(n, 11)"""
    fitness: Floats
    genomes: Floats
    """(n, d)"""

    def columns(self) -> tuple[Array, ...]:
        return self.integers, self.fitness, self.genomes


@dataclass(frozen=True)
class _Simulations:
    """Table of simulations, in the order of birth and rollout."""

    births: int
    rollouts: int
    key: Ints
    """(n, 3) generation, place, rollout"""
    arrays: dict[str, Array]
    """Arrays (births, rollouts, …) of an `Assessment`."""
    blobs: tuple[Array, ...]
    """Arrays (n, m) of the blobs as the writer had them."""

    def columns(self) -> tuple[Array, ...]:
        """Return the columns as the writer had them."""
        flat = {row: _flat(self.arrays[row.name]) for row in COLUMNS}
        scalars = [column for row in COLUMNS for column in (flat[row].T if row.parts else [flat[row]])]
        return (*self.key.T, *scalars, *self.blobs)

    def rows_of(self, births: Ints) -> Ints:
        """Return (n,) the place of each birth (n, 2) in the arrays.

        Raises:
            KeyError: a birth has no simulation.
        """
        there = self.key[:: max(1, self.rollouts), :2].astype(np.int64)
        names, wanted = (pair[:, 0] << 32 | pair[:, 1] for pair in (there, births.astype(np.int64)))
        at = np.searchsorted(names, wanted)
        if len(wanted) and (not len(names) or (names[np.minimum(at, len(names) - 1)] != wanted).any()):
            raise KeyError("an individual without its simulation")
        return at


def _flat(array: Array) -> Array:
    return array.reshape(-1, *array.shape[2:])


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
        except (
            ValueError,
            KeyError,
            TypeError,
            IndexError,
            AttributeError,
            OverflowError,
            RecursionError,
            zlib.error,
        ) as error:
            raise damaged(path, f"what it holds does not fit together ({type(error).__name__})") from error


def read_again(path: Path, record: Record) -> Record:
    """Return the record of a journal that may have grown since it was read; an equal seal proves that it has not.

    Raises:
        StoreError: as `read_journal`.
    """
    if record.proved:
        with store_errors(path), closing(_opened(path)) as connection:
            _check(path, connection)
            if connection.execute("SELECT seal FROM status").fetchall() == [(record.seal,)]:
                return record
    return read_journal(path)


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
    evaluations = _evaluations(individuals, simulations, manifest)
    return Record(
        manifest=manifest,
        evaluations=evaluations,
        generations=tuple(_figures(generation, text) for generation, text in figures),
        status=status,
        seconds=float("nan") if seconds is None else seconds,
        spent=_spent(connection),
        actions={key: np.frombuffer(each, dtype="<f8").reshape(turns, wide) for key, turns, wide, each in stored},
        seal=connection.execute("SELECT seal FROM status").fetchone()[0] if proved else b"",
        links=links,
        blame=_blame(connection, evaluations, links) if proved else None,
        proved=proved,
    )


def _blame(connection: sqlite3.Connection, evaluations: Evaluations, links: Sequence[str]) -> Ints | None:
    """Return the stored verdicts on collisions; None if there are none, or none for the last of the `links`.

    Raises:
        BrokenChainError: they are not what was written.
    """
    if not _has_table(connection, "blame"):
        return None
    rows = connection.execute("SELECT link, verdicts, digest FROM blame").fetchall()
    verdicts = verdicts_of(rows[0]) if len(rows) == 1 else None
    if verdicts is None or (at := rows[0][0].hex()) not in links:
        raise BrokenChainError("`blame` is not what was written")
    if at != links[-1]:
        return None
    hit, said = collisions_of(evaluations), np.full(evaluations.rollouts.verdict.shape, int(Blame.NONE), dtype=np.int32)
    said[hit] = verdicts
    return said


def _has_table(connection: sqlite3.Connection, name: str) -> bool:
    return bool(connection.execute("SELECT count(*) FROM sqlite_master WHERE name = ?", (name,)).fetchone()[0])


class BrokenChainError(Signal, ValueError):
    """Stored rows differ from those that were written."""


def _checked_links(
    connection: sqlite3.Connection, individuals: _Individuals, simulations: _Simulations
) -> tuple[str, ...]:
    """Recompute the link of every generation; return all links in hexadecimal, after `BEGINNING`.

    Raises:
        BrokenChainError: a link differs from the stored one.
    """
    rows = connection.execute("SELECT generation, figures, link FROM generation ORDER BY generation").fetchall()
    born, simulated = individuals.integers[:, 0], simulations.key[:, 0]
    if [row[0] for row in rows] != list(range(len(rows))) or max(
        born.max(initial=-1), simulated.max(initial=-1)
    ) >= len(rows):
        raise BrokenChainError("its generations are not those that were written")
    edges = [np.searchsorted(order, np.arange(len(rows) + 1)).tolist() for order in (born, simulated)]
    tables = individuals.columns(), simulations.columns()
    before, links = BEGINNING, [BEGINNING.hex()]
    for generation, figures, stored in rows:
        cuts = [slice(*edge[generation : generation + 2]) for edge in edges]
        before = link(
            before, figures, *([array[cut] for array in table] for table, cut in zip(tables, cuts, strict=True))
        )
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
        pair = [[*vars(each.by_individual).values(), *vars(each.by_simulation).values()] for each in (found, written)]
        figures = np.array(pair, dtype=np.float64)
        figures[~np.isfinite(figures)] = np.nan  # JSON has neither: the mean of distances of actors that never meet
        if not np.allclose(*figures, rtol=1e-9, atol=0.0, equal_nan=True):
            raise ValueError
    return record


def _action_rows(connection: sqlite3.Connection) -> list[tuple[Any, ...]]:
    """Return the stored decisions; [] unless a controller drives."""
    if not _has_table(connection, "action"):
        return []
    return connection.execute("SELECT key, turns, numbers, decided FROM action").fetchall()


def _spent(connection: sqlite3.Connection) -> float:
    """Return the time until the last generation was written [s]; the results are complete without it."""
    if not _has_table(connection, "pace"):
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


def _evaluations(individuals: _Individuals, simulations: _Simulations, manifest: Manifest) -> Evaluations:
    """Return the evaluations; the arrays of `simulations` move into them one by one, so that few are there twice."""
    integers = individuals.integers
    births, reused = integers[:, 2:4], integers[:, 4].astype(bool)
    at, runs = simulations.rows_of(births), simulations.arrays
    planned = manifest.settings["search"]["generations"] * manifest.settings["search"]["population"]
    room = min(planned, 2 * len(at))  # rows to come, of a run that is not finished: see `Rows`
    for name in runs:
        array = np.empty((max(room, len(at)), *runs[name].shape[1:]), dtype=runs[name].dtype)
        runs[name] = np.take(runs[name], at, axis=0, out=array[: len(at)], mode="clip")
    rollouts = Assessment(**runs)
    return Evaluations(
        genomes=with_room(individuals.genomes, max(room, len(at)))[: len(at)],
        places=integers[:, 0:2],
        births=births,
        operator=integers[:, 5],
        parents=integers[:, 6:10].reshape(-1, 2, 2),
        reused=reused,
        verdict=integers[:, 10],
        fitness=aggregate(goal_of(rollouts), counted(rollouts), manifest.settings["search"]["aggregate"]),
        keys=_keys(births, rollouts.verdict.shape[1], max(room, len(at)), manifest),
        rollouts=rollouts,
    )


def _individuals(connection: sqlite3.Connection, manifest: Manifest) -> _Individuals:
    count, genes = _count(connection, "individual"), len(manifest.parameters)
    integers = np.empty((count, 11), dtype=np.int32)
    found = _Individuals(integers, np.empty(count), np.empty((count, genes)))
    _fill(connection, "individual ORDER BY generation, place", [*integers.T, found.fitness, found.genomes])
    return found


def _simulations(connection: sqlite3.Connection, manifest: Manifest) -> _Simulations:
    """Return the simulations.

    Raises:
        ValueError: the births have different numbers of rollouts.
    """
    count, conditions = _count(connection, "simulation"), len(manifest.requirements)
    key = np.empty((count, 3), dtype=np.int32)
    flat = {row: np.empty((count, len(row.parts)) if row.parts else count, dtype=row.dtype) for row in COLUMNS}
    blobs: list[Array] = [np.empty((count, 2 * conditions), dtype=np.int32)]
    if manifest.keeps_sought:
        blobs.append(np.empty((count, manifest.aims + len(manifest.objectives) + 1)))
    scalars = [column for row, array in flat.items() for column in (array.T if row.parts else [array])]
    _fill(connection, "simulation ORDER BY generation, place, rollout", [*key.T, *scalars, *blobs])
    births = int((np.diff(key[:, :2], axis=0) != 0).any(axis=1).sum()) + (count > 0)
    rollouts = count // max(1, births)
    if births * rollouts != count:
        raise ValueError("each birth has the same number of rollouts")
    arrays = {row.name: array for row, array in flat.items()}
    arrays |= {"tested": blobs[0][:, :conditions], "failed": blobs[0][:, conditions:]}
    arrays |= _sought(blobs[1], manifest) if blobs[1:] else _nothing_sought(arrays["collided"])
    shaped = {name: array.reshape(births, rollouts, *array.shape[1:]) for name, array in arrays.items()}
    return _Simulations(births, rollouts, key, shaped, tuple(blobs))


def _count(connection: sqlite3.Connection, table: str) -> int:
    return connection.execute(f"SELECT count(*) FROM {table}").fetchone()[0]  # noqa: S608


def _fill(connection: sqlite3.Connection, table: str, targets: Sequence[Array]) -> None:
    """Fill arrays with the columns of a table, some rows after the other; blobs fill arrays (n, m).

    Raises:
        ValueError: the table has more or fewer columns, or a value is not of the type of its column.
    """
    cursor = connection.execute(f"SELECT * FROM {table}")  # noqa: S608
    if len(cursor.description) != len(targets):
        raise ValueError("values of objectives must be stored if the run has some beside the risk, and only then")
    row = 0
    while rows := cursor.fetchmany(AT_ONCE):
        for target, column in zip(targets, zip(*rows, strict=True), strict=True):
            part = target[row : row + len(rows)]
            values = _values(column, part)
            part[...] = values
            if part.dtype.kind != "f" and (part != values).any():
                raise ValueError("a number is larger than any that is written")
        row += len(rows)


def _values(column: Sequence[Any], part: Array) -> Array:
    """Return the values of a column as an array that fits `part`."""
    if part.ndim == 2:
        return np.frombuffer(b"".join(column), dtype=part.dtype.newbyteorder("<")).reshape(part.shape)
    return numbers(column) if part.dtype.kind == "f" else whole_numbers(column)


def _sought(table: Array, manifest: Manifest) -> dict[str, Any]:
    aims = manifest.aims
    return {"sought": table[:, :aims], "broken": table[:, aims:-1], "found": table[:, -1] == 1.0}


def _nothing_sought(collided: Array) -> dict[str, Any]:
    nothing = np.zeros((len(collided), 0))
    return {"sought": nothing, "broken": nothing, "found": collided.copy()}


def _keys(births: Ints, rollouts: int, room: int, manifest: Manifest) -> Ints:
    """Return (n, k, 6) stream keys, with room for so many."""
    keys = np.empty((room, rollouts, 6), dtype=np.int64)[: len(births)]
    keys[:] = (manifest.seed, manifest.method_number, manifest.run, 0, 0, 0)
    keys[:, :, 3:5] = births[:, np.newaxis]
    keys[:, :, 5] = np.arange(rollouts)
    return keys
