"""The chain of a journal: it shows whether the contents of the file are still those that were written.

Each generation has a *link*: a digest (BLAKE2b) of its figures, individuals and simulations, and of the link before it.
Links are a pure function of the results, so two searches with the same results end in the same link. Data that may
change while a run continues are covered by the *seal*, which is rewritten with each change: a digest for each of
manifest, status (with the last link), pace and actions. A reader recomputes links and seal from the rows that it
returns.

Digests cover numbers, not the bytes of the file: -0.0 is 0.0, as SQLite stores it, and NaN is one number.
"""

import sqlite3
import zlib
from array import array
from collections.abc import Iterable, Sequence
from hashlib import blake2b
from typing import Any

import numpy as np
from numpy.typing import NDArray

LINK = 32
"""Bytes of a link."""
PART = 16
"""Bytes of each digest in a seal."""
PARTS = ("manifest", "status", "pace", "action")
"""Names of the tables that the seal covers, in its order."""
BEGINNING = b"cortexc journal"
"""Predecessor of the first link."""
NO_ACTIONS = bytes(PART)
LEAST = -(1 << 63)
"""Least whole number of SQLite."""

Array = NDArray[Any]


def whole_numbers(column: Sequence[Any]) -> Array:
    """Return a column of whole numbers as int64.

    Raises:
        TypeError: the column contains another type; SQLite accepts any type in any column.
    """
    return np.frombuffer(array("q", column), dtype=np.int64)


def numbers(column: Sequence[Any]) -> Array:
    """Return a column of numbers as float64; None is NaN."""
    try:
        return np.frombuffer(array("d", column), dtype=np.float64)
    except TypeError:  # a column with None: an array takes numbers alone, and is made in half the time
        return np.array(column, dtype=np.float64)


def link(before: bytes, figures: str, individuals: Sequence[Array], simulations: Sequence[Array]) -> bytes:
    """Return the link of a generation: the digest of its stored figures, and of arrays with a row per individual and
    per simulation.
    """
    state = blake2b(before, digest_size=LINK)
    state.update(figures.encode())
    for table in (individuals, simulations):
        for column in table:
            content = canonical(column)
            state.update(f"{content.dtype.str}{content.shape}".encode())
            state.update(content.tobytes())
    return state.digest()


def canonical(values: Array) -> Array:
    """Return the same numbers in a form that does not depend on machine or type: int64 or float64, little-endian."""
    if values.dtype.kind != "f":
        return values.astype("<i8")
    same = values.astype("<f8") + 0.0
    same[np.isnan(same)] = np.nan
    return same


def last_link(connection: sqlite3.Connection) -> bytes:
    """Return the link of the last generation in the file; `BEGINNING` if there is none."""
    row = connection.execute("SELECT link FROM generation ORDER BY generation DESC LIMIT 1").fetchone()
    return BEGINNING if row is None else row[0]


class Pace:
    """Digest of the rows of `pace`, as by `_digest`; it reads each row once or twice, however often it is asked."""

    def __init__(self) -> None:
        self._state = blake2b(b"[", digest_size=PART)
        self._next = LEAST
        """First generation that is not in the state: a row that may still be rolled back is none of it."""

    def digest(self, connection: sqlite3.Connection) -> bytes:
        rows = connection.execute(
            "SELECT generation, seconds FROM pace WHERE generation >= ? ORDER BY generation", (self._next,)
        ).fetchall()
        for row in rows[:-1]:
            self._add(self._state, row)
            self._next = row[0] + 1
        state = self._state.copy()
        for row in rows[-1:]:
            self._add(state, row)
        state.update(b"]")
        return state.digest()

    def _add(self, state: Any, row: tuple[Any, ...]) -> None:
        state.update(f"{', ' if self._next > LEAST else ''}{row!r}".encode())


def parts(connection: sqlite3.Connection, actions: bytes, pace: Pace | None = None) -> bytes:
    """Return the seal that fits the rows of a journal; `actions` is the digest of its actions."""
    status = connection.execute("SELECT status, seconds FROM status").fetchall()
    manifest = connection.execute("SELECT field, value FROM manifest ORDER BY field").fetchall()
    paced = (pace or Pace()).digest(connection)
    said = (_digest(manifest), _digest([*status, (last_link(connection),)]), paced)
    return b"".join(said) + actions


def seal(connection: sqlite3.Connection, actions: bytes = NO_ACTIONS, pace: Pace | None = None) -> None:
    """Write the seal anew, as a part of the transaction that changed something; `actions` is the digest of those that
    were added, or taken away, `pace` that of the pace so far.
    """
    (old,) = connection.execute("SELECT seal FROM status").fetchone()
    added = either(old[-PART:], actions)
    connection.execute("UPDATE status SET seal = ?", (parts(connection, added, pace),))


def actions_digest(rows: Iterable[tuple[Any, ...]]) -> bytes:
    """Return a digest of actions that does not depend on their order; adding and removing a row change it equally."""
    total = NO_ACTIONS
    for row in rows:
        total = either(total, _digest([row]))
    return total


def blame_row(last: bytes, verdicts: Array) -> tuple[bytes, bytes, bytes]:
    """Return the last link of a journal, the verdicts (n,) on its collisions in compressed form, and their digest."""
    packed = zlib.compress(verdicts.astype("<i1").tobytes(), 1)
    return last, packed, _digest([(last, packed)])


def verdicts_of(row: tuple[Any, ...]) -> Array | None:
    """Return the verdicts of a `blame_row`; None if they are not what was written."""
    last, packed, digest = row
    return np.frombuffer(zlib.decompress(packed), dtype="<i1") if _digest([(last, packed)]) == digest else None


def either(first: bytes, second: bytes) -> bytes:
    """Return the bitwise sum of two digests, which does not depend on their order."""
    return bytes(a ^ b for a, b in zip(first, second, strict=True))


def _digest(rows: Iterable[tuple[Any, ...]]) -> bytes:
    """Return the digest of rows of texts, numbers and bytes; each value counts with its type."""
    return blake2b(repr(list(rows)).encode(errors="surrogatepass"), digest_size=PART).digest()


def broken_parts(connection: sqlite3.Connection, actions: bytes) -> list[str]:
    """Return the tables under the seal that differ from their sealed state."""
    (stored,) = connection.execute("SELECT seal FROM status").fetchone()
    found = parts(connection, actions)
    if not isinstance(stored, bytes) or len(stored) != len(found):
        return ["status"]
    return [name for i, name in enumerate(PARTS) if stored[i * PART :][:PART] != found[i * PART :][:PART]]
