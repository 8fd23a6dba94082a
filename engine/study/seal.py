"""The seal of a study: it shows whether the contents of the file are still those that were written.

Runs end in any order, so the seal is the sum (exclusive or) of one digest per row: of manifest and scenarios, and of
each run with its figures, its course, its seconds and the digest of its block of evaluations. It is checked when the
study is read; a block is compared with its digest when the block is read.
"""

import sqlite3
from hashlib import blake2b
from itertools import accumulate
from typing import Any

from engine.search.chain import LINK, actions_digest, either

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
    (kept,) = connection.execute("SELECT value FROM seal").fetchone()
    connection.execute("UPDATE seal SET value = ?", (either(kept, actions_digest([run])),))
