"""The chain of a journal: what was written can be told from what stands there now.

Each generation has a *link*: a digest (BLAKE2b) of its figures, individuals and simulations, and of the link before it.
Links are a pure function of what was found, so that two searches that found the same end in the same link. What may
change as a run goes on lies under the *seal*, which is written anew with each change: a digest for each of manifest,
status (with the last link), pace and actions. A reader makes links and seal again from the rows that it returns.

Digests are of numbers and not of the bytes of the file: -0.0 is 0.0, as SQLite keeps it, and NaN is one number.
"""

import sqlite3
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
"""What lies under the seal, in its order: the names of the tables."""
BEGINNING = b"cortexc journal"
"""In the place of the link before the first."""
NO_ACTIONS = bytes(PART)

Array = NDArray[Any]


def whole_numbers(column: Sequence[Any]) -> Array:
    """A column of whole numbers as int64.

    Raises:
        TypeError: something else stands in it: SQLite takes anything everywhere.
    """
    array = np.array(column) if len(column) else np.zeros(0, dtype=np.int64)
    if array.dtype != np.int64:
        raise TypeError("a column of whole numbers must contain whole numbers")
    return array


def numbers(column: Sequence[Any]) -> Array:
    """A column of numbers as float64; None is NaN."""
    return np.array(column, dtype=np.float64)


def link(before: bytes, figures: str, individuals: Sequence[Array], simulations: Sequence[Array]) -> bytes:
    """The link of a generation: of its figures as they are stored, and of arrays with a row for each individual and for
    each simulation.
    """
    state = blake2b(before, digest_size=LINK)
    state.update(figures.encode())
    for table in (individuals, simulations):
        for array in table:
            content = canonical(array)
            state.update(f"{content.dtype.str}{content.shape}".encode())
            state.update(content.tobytes())
    return state.digest()


def canonical(array: Array) -> Array:
    """The same numbers in one form, whatever machine and type they come from."""
    if array.dtype.kind != "f":
        return array.astype("<i8")
    same = array.astype("<f8") + 0.0
    same[np.isnan(same)] = np.nan
    return same


def last_link(connection: sqlite3.Connection) -> bytes:
    """The link of the last generation that is written."""
    row = connection.execute("SELECT link FROM generation ORDER BY generation DESC LIMIT 1").fetchone()
    return BEGINNING if row is None else row[0]


def parts(connection: sqlite3.Connection, actions: bytes) -> bytes:
    """The seal that fits the rows of a journal, whose actions have this digest."""
    status = connection.execute("SELECT status, seconds FROM status").fetchall()
    pace = connection.execute("SELECT generation, seconds FROM pace ORDER BY generation").fetchall()
    manifest = connection.execute("SELECT field, value FROM manifest ORDER BY field").fetchall()
    said = (_digest(manifest), _digest([*status, (last_link(connection),)]), _digest(pace))
    return b"".join(said) + actions


def seal(connection: sqlite3.Connection, actions: bytes = NO_ACTIONS) -> None:
    """Write the seal anew, as a part of the transaction that changed something; `actions` is the digest of those that
    were added, or taken away.
    """
    (old,) = connection.execute("SELECT seal FROM status").fetchone()
    added = either(old[-PART:], actions)
    connection.execute("UPDATE status SET seal = ?", (parts(connection, added),))


def actions_digest(rows: Iterable[tuple[Any, ...]]) -> bytes:
    """Of actions in any order: what is added and what is taken away change it by the same."""
    total = NO_ACTIONS
    for row in rows:
        total = either(total, _digest([row]))
    return total


def either(first: bytes, second: bytes) -> bytes:
    """The sum of two digests, in any order."""
    return bytes(a ^ b for a, b in zip(first, second, strict=True))


def _digest(rows: Iterable[tuple[Any, ...]]) -> bytes:
    """Of texts, numbers and bytes, each with its type."""
    return blake2b(repr(list(rows)).encode(errors="surrogatepass"), digest_size=PART).digest()


def broken_parts(connection: sqlite3.Connection, actions: bytes) -> list[str]:
    """Tables under the seal that are not as they were sealed."""
    (kept,) = connection.execute("SELECT seal FROM status").fetchone()
    found = parts(connection, actions)
    if not isinstance(kept, bytes) or len(kept) != len(found):
        return ["status"]
    return [name for i, name in enumerate(PARTS) if kept[i * PART :][:PART] != found[i * PART :][:PART]]
