"""Journals from before there were chains, made of those of today: what is wrong in one is told without digests. And
studies that were changed, as if they had been written so.
"""

import sqlite3
from contextlib import closing
from pathlib import Path

from engine.search.journal import WITHOUT_CHAIN
from engine.study.database import seals_of


def unchain(path: Path) -> Path:
    """Take links and seal out of a journal."""
    with closing(sqlite3.connect(path)) as connection, connection:
        connection.execute("ALTER TABLE generation DROP COLUMN link")
        connection.execute("ALTER TABLE status DROP COLUMN seal")
        connection.execute(f"PRAGMA user_version = {WITHOUT_CHAIN}")
    return path


def reseal(connection: sqlite3.Connection) -> None:
    """Let the seal of a study be that of what stands in it now."""
    connection.execute("UPDATE seal SET value = ?", (seals_of(connection)[-1],))
