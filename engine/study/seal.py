"""The seal of a study: what was written can be told from what stands there now.

Runs end in any order, so that the seal is a sum (exclusive or) of a digest for each row: of manifest and scenarios, and
of each run with its figures, its course, its seconds and the digest of its block of evaluations. It is read with the
study; a block is held against its digest when it is read.
"""

import sqlite3
from collections.abc import Iterator
from hashlib import blake2b
from typing import Any

from engine.search.chain import LINK, actions_digest, either

COUNTS = "SELECT (SELECT count(*) FROM run), (SELECT count(*) FROM pace), (SELECT count(*) FROM evaluations)"
RUNS = """SELECT scenario, method, run, figures, course, seconds, digest
FROM run LEFT JOIN pace USING (scenario, method, run) LEFT JOIN evaluations USING (scenario, method, run)"""


def digest_of(block: bytes) -> bytes:
    """Of the evaluations of a run, as they are stored."""
    return blake2b(block, digest_size=LINK).digest()


def has_seal(connection: sqlite3.Connection) -> bool:
    """Whether a study was begun with one."""
    return connection.execute("SELECT 1 FROM sqlite_master WHERE name = 'seal'").fetchone() is not None


def seal_of(connection: sqlite3.Connection) -> bytes:
    """The seal that fits all rows."""
    return actions_digest(_rows(connection))


def broken_seal(connection: sqlite3.Connection) -> bool:
    """Whether some row is not as it was sealed, or there are more, or fewer of them."""
    counts = set(connection.execute(COUNTS).fetchone())
    kept = connection.execute("SELECT value FROM seal").fetchall()
    return len(counts) != 1 or kept != [(seal_of(connection),)]


def add_to_seal(connection: sqlite3.Connection, run: tuple[Any, ...]) -> None:
    """Seal one more run, as a part of the transaction that writes it; `run` as `RUNS` has it."""
    (kept,) = connection.execute("SELECT value FROM seal").fetchone()
    connection.execute("UPDATE seal SET value = ?", (either(kept, actions_digest([run])),))


def _rows(connection: sqlite3.Connection) -> Iterator[tuple[Any, ...]]:
    yield from connection.execute("SELECT field, value FROM manifest")
    yield from connection.execute("SELECT number, name, file, manifest, digest FROM scenario")
    yield from connection.execute(RUNS)
