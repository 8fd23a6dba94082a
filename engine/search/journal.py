"""The journal: one SQLite file with all data of a run, written one generation at a time.

Each generation is one transaction in write-ahead mode, so a killed process loses at most the generation in flight. The
*results* of a run (`generation`, `individual`, `simulation`) are a pure function of file, settings and seed; its
duration (`pace`, `status`) is in separate tables. In their order, the individuals replay a searcher by ask and tell.

| table      | one row for each                                                                       |
|------------|----------------------------------------------------------------------------------------|
| manifest   | field of `Manifest`, as JSON                                                           |
| generation | generation: its figures, as JSON, and its link (see `engine.search.chain`)            |
| individual | place in a generation: genome, operator, parents, birth, fitness                       |
| simulation | rollout that was run: verdict, counts per requirement, metrics, risk; named by birth   |
| pace       | generation: seconds since the start                                                    |
| status     | `running` or the kind of its end (`campaign`), and the seal of the journal (one row)   |
| action     | scene in which a controller's decisions are kept: its key, the shape, float64 numbers  |
| blame      | analysed run: verdicts of the reference driver on its collisions, under the last link   |

A stream key is the manifest's seed, method and run, then birth and rollout. Genomes and counts are little-endian blobs
(float64; int32, tested then failed); NaN is NULL. If the search has an objective other than the risk, or the file has
objectives, a further blob (float64) holds the value of each objective, the broken expectations, and whether the run is
a find of the search.
"""

import sqlite3
from collections.abc import Generator, Iterable, Mapping
from contextlib import closing, contextmanager, suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from engine.assessment import COLUMNS, take, to_arrays
from engine.search.campaign import INTERRUPTED, Campaign, Progress
from engine.search.chain import NO_ACTIONS, PART, PARTS, Array, Pace, actions_digest, blame_row, last_link, link, seal
from engine.search.evaluations import Evaluations, GenerationFigures, flat_rollouts
from engine.search.insight.kinds import collisions_of
from engine.search.manifest import Manifest
from engine.search.store import SPACE_TO_BEGIN, UNBORN, StoreError, check_not_removed, store_errors
from engine.strict_json import json_text
from engine.tables import Floats

APPLICATION_ID = 0x43525458
"""File type mark of a journal of cortexc ("CRTX")."""
SCHEMA_VERSION = 3
"""Rises with every change of the tables."""
WITHOUT_CHAIN = 2
"""Schema version before links and seals: it can be read and continued, but not verified."""

_SIMULATION = ",\n    ".join(
    f"{name} {'REAL' if row.kind is float else 'INTEGER NOT NULL'}" for row in COLUMNS for name in row.columns
)
SCHEMA = f"""
CREATE TABLE manifest (field TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE generation (generation INTEGER PRIMARY KEY, figures TEXT NOT NULL, link BLOB NOT NULL);
CREATE TABLE individual (
    generation INTEGER NOT NULL, place INTEGER NOT NULL,
    birth_generation INTEGER NOT NULL, birth_place INTEGER NOT NULL, reused INTEGER NOT NULL,
    operator INTEGER NOT NULL,
    parent_1_generation INTEGER NOT NULL, parent_1_place INTEGER NOT NULL,
    parent_2_generation INTEGER NOT NULL, parent_2_place INTEGER NOT NULL,
    verdict INTEGER NOT NULL, fitness REAL, genome BLOB NOT NULL,
    PRIMARY KEY (generation, place)
) WITHOUT ROWID;
CREATE TABLE simulation (
    generation INTEGER NOT NULL, place INTEGER NOT NULL, rollout INTEGER NOT NULL,
    {_SIMULATION},
    counts BLOB NOT NULL,{{sought}}
    PRIMARY KEY (generation, place, rollout)
) WITHOUT ROWID;
CREATE TABLE pace (generation INTEGER PRIMARY KEY, seconds REAL NOT NULL);
CREATE TABLE status (status TEXT NOT NULL, seconds REAL, seal BLOB NOT NULL);
INSERT INTO status VALUES ('running', NULL, zeroblob({PART * len(PARTS)}));
PRAGMA application_id = {APPLICATION_ID};
PRAGMA user_version = {SCHEMA_VERSION};
"""  # noqa: S608 (made of names in this package alone)
_SOUGHT = "\n    sought BLOB NOT NULL,"
"""Column of a run with an objective other than the risk, or with objectives in its file."""


_ACTIONS = """
CREATE TABLE IF NOT EXISTS action
    (key BLOB PRIMARY KEY, turns INTEGER NOT NULL, numbers INTEGER NOT NULL, decided BLOB NOT NULL) WITHOUT ROWID
"""
"""Table that exists only if a controller drives."""


_BLAME = "CREATE TABLE IF NOT EXISTS blame (link BLOB NOT NULL, verdicts BLOB NOT NULL, digest BLOB NOT NULL)"
"""Table that exists once a run was analysed. It can be computed again, so that it is no part of the seal."""


def _remove_unborn(unborn: Path) -> None:
    """Remove a journal that is not complete, with the files of SQLite next to it."""
    for stale in unborn.parent.glob(f"{unborn.name}*"):
        stale.unlink()


def _adding(table: str, columns: int) -> str:
    return f"INSERT INTO {table} VALUES ({', '.join('?' * columns)})"  # noqa: S608


def has_chain(connection: sqlite3.Connection) -> bool:
    """Return True if the journal has links and a seal."""
    tables = [[row[1] for row in connection.execute(f"PRAGMA table_info({each})")] for each in ("generation", "status")]
    return ["link" in tables[0], "seal" in tables[1]] != [False, False]


class Journal:
    """An open journal that a running campaign writes; its `write` is an `on_generation`."""

    def __init__(self, path: Path, connection: sqlite3.Connection) -> None:
        self.path = path
        self._connection = connection
        self._inode = path.stat().st_ino
        self._chained = has_chain(connection)
        self._pace = Pace()

    @classmethod
    def create(cls, path: Path, manifest: Manifest) -> "Journal":
        """Start the journal of a new run.

        Raises:
            StoreError: the file exists already, or it cannot be written.
        """
        with store_errors(path, SPACE_TO_BEGIN):
            if path.exists():
                raise StoreError(f"`{path}` exists already", "name another --out; a run is never overwritten")
            # A journal gets its name when it is complete, so that a process that ends early leaves no partial journal
            # there.
            unborn = path.with_name(path.name + UNBORN)
            _remove_unborn(unborn)
            try:
                with closing(sqlite3.connect(unborn, isolation_level=None)) as connection:
                    connection.execute("PRAGMA journal_mode = WAL")
                    connection.executescript("BEGIN; " + SCHEMA.format(sought=_SOUGHT if manifest.keeps_sought else ""))
                    connection.executemany("INSERT INTO manifest VALUES (?, ?)", _manifest_rows(manifest))
                    seal(connection)
                    connection.execute("COMMIT")
                unborn.rename(path)
            except BaseException:
                _remove_unborn(unborn)
                raise
        return cls(path, _open(path))

    @classmethod
    def reopen(cls, path: Path, manifest: Manifest | None = None) -> "Journal":
        """Reopen the journal of a run that was stopped or killed; `journal_reader` has checked the file.

        `manifest` replaces the stored manifest, for a run that is extended.

        Raises:
            StoreError: the file cannot be written.
        """
        with store_errors(path):
            connection = _open(path)
            with _transaction(connection):
                connection.execute("UPDATE status SET status = 'running', seconds = NULL")
                if manifest is not None:
                    connection.executemany("REPLACE INTO manifest VALUES (?, ?)", _manifest_rows(manifest))
                if has_chain(connection):
                    seal(connection)
            return cls(path, connection)

    @property
    def link(self) -> str:
        """Return the last link of the chain in hexadecimal; "" without a chain."""
        with store_errors(self.path):
            return last_link(self._connection).hex() if self._chained else ""

    def write(self, progress: Progress) -> None:
        """Add one generation; after an error nothing of it is stored.

        Raises:
            RemovedError: the file does not exist any more.
            StoreError: the file cannot be written.
        """
        self._write(progress.evaluations, progress.figures, progress.elapsed)

    def keep(self, actions: Mapping[bytes, Floats]) -> None:
        """Store the decisions of controllers, (turns, numbers) by the name (`driving.decisions.name_of`) of each scene.

        Raises:
            StoreError: the file cannot be written.
        """
        if not actions:
            return
        with store_errors(self.path), _transaction(self._connection) as connection:
            connection.execute(_ACTIONS)
            rows = [(key, *each.shape, each.astype("<f8").tobytes()) for key, each in actions.items()]
            old = [row for key in actions for row in connection.execute("SELECT * FROM action WHERE key = ?", (key,))]
            connection.executemany("INSERT OR REPLACE INTO action VALUES (?, ?, ?, ?)", rows)
            self._seal(connection, actions_digest([*old, *rows]))

    def complete(self, campaign: Campaign) -> None:
        """Add the generations that an interrupt (Ctrl-C) left unwritten."""
        with store_errors(self.path):
            written = self._connection.execute("SELECT count(*) FROM generation").fetchone()[0]
        for figures in campaign.generations[written:]:
            rows = campaign.evaluations.places[:, 0] == figures.generation
            self._write(take(campaign.evaluations, rows), figures, campaign.elapsed)

    def finish(self, campaign: Campaign) -> None:
        """Store the final status of the run after all its data, and leave one plain file."""
        self.complete(campaign)
        with store_errors(self.path):
            with _transaction(self._connection) as connection:
                connection.execute("UPDATE status SET status = ?, seconds = ?", (campaign.status, campaign.elapsed))
                self._seal(connection)
                if self._chained and campaign.status != INTERRUPTED:
                    verdicts = campaign.blame[collisions_of(campaign.evaluations)]
                    connection.execute(_BLAME)
                    connection.execute("DELETE FROM blame")
                    connection.execute(_adding("blame", 3), blame_row(last_link(connection), verdicts))
            with suppress(sqlite3.OperationalError):  # another process reads: the mode stays, without harm
                self._connection.execute("PRAGMA journal_mode = DELETE")
        self.close()

    def close(self) -> None:
        """Let go of the file; a run that was not finished stays `running` in it."""
        self._connection.close()

    def _write(self, evaluations: Evaluations, figures: GenerationFigures, seconds: float) -> None:
        check_not_removed(self.path, self._inode)
        text = figures_json(figures)
        individuals, simulations = _individuals(evaluations), _simulations(evaluations)
        with store_errors(self.path), _transaction(self._connection) as connection:
            if self._chained:
                before = last_link(connection)
                row = figures.generation, text, link(before, text, individuals, simulations)
            else:
                row = figures.generation, text
            connection.execute(_adding("generation", len(row)), row)
            connection.executemany(_adding("individual", 13), _individual_rows(individuals))
            connection.executemany(_adding("simulation", len(simulations)), _simulation_rows(simulations))
            connection.execute("INSERT INTO pace VALUES (?, ?)", (figures.generation, seconds))
            self._seal(connection)

    def _seal(self, connection: sqlite3.Connection, actions: bytes = NO_ACTIONS) -> None:
        if self._chained:
            seal(connection, actions, self._pace)


def _open(path: Path) -> sqlite3.Connection:
    """Return a connection to an existing journal, in the mode in which readers do not wait for its writer."""
    with store_errors(path):
        connection = sqlite3.connect(f"{path.resolve().as_uri()}?mode=rw", uri=True, isolation_level=None)
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = NORMAL")
        return connection


def _manifest_rows(manifest: Manifest) -> list[tuple[str, str]]:
    return [(name, json_text(value)) for name, value in manifest.stored().items()]


@contextmanager
def _transaction(connection: sqlite3.Connection) -> Generator[sqlite3.Connection]:
    """Commit at the end of the block, roll back if it raises."""
    connection.execute("BEGIN IMMEDIATE")
    try:
        yield connection
        connection.execute("COMMIT")
    except BaseException:
        if connection.in_transaction:
            connection.execute("ROLLBACK")
        raise


def figures_json(figures: GenerationFigures) -> str:
    """Return the figures of a generation without its number as JSON; NaN is null."""
    document = {"by_individual": asdict(figures.by_individual), "by_simulation": asdict(figures.by_simulation)}
    return json_text(document)


def _individuals(evaluations: Evaluations) -> tuple[Array, ...]:
    """Return integers (n, 11), fitness (n,) and genomes (n, d), in the order of the columns."""
    integers = np.concatenate(
        [
            evaluations.places,
            evaluations.births,
            evaluations.reused[:, np.newaxis],
            evaluations.operator[:, np.newaxis],
            evaluations.parents.reshape(-1, 4),
            evaluations.verdict[:, np.newaxis],
        ],
        axis=1,
    )
    return integers, evaluations.fitness, evaluations.genomes.astype("<f8")


def _individual_rows(individuals: tuple[Array, ...]) -> Iterable[tuple[Any, ...]]:
    integers, fitness, genomes = individuals
    rows = zip(integers.tolist(), fitness.tolist(), genomes, strict=True)
    return ((*numbers, fit, genome.tobytes()) for numbers, fit, genome in rows)


def _simulations(evaluations: Evaluations) -> tuple[Array, ...]:
    """Return one row per rollout of this generation's simulations, without elites: columns as arrays, blobs (n, m)."""
    new = take(evaluations, evaluations.simulated)
    count, rollouts = map(int, new.rollouts.verdict.shape)
    keys = np.concatenate(
        [np.repeat(new.births, rollouts, axis=0), np.tile(np.arange(rollouts), count)[:, np.newaxis]], axis=1
    )
    runs = flat_rollouts(new)
    blobs = [np.concatenate([runs.tested, runs.failed], axis=1).astype("<i4")]
    if runs.sought.shape[1] + runs.broken.shape[1] > 0:
        blobs.append(np.concatenate([runs.sought, runs.broken, runs.found[:, np.newaxis]], axis=1).astype("<f8"))
    return (*keys.T, *to_arrays(runs).values(), *blobs)


def _simulation_rows(simulations: tuple[Array, ...]) -> Iterable[tuple[Any, ...]]:
    columns = (each.tolist() if each.ndim == 1 else [row.tobytes() for row in each] for each in simulations)
    return zip(*columns, strict=True)
