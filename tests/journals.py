"""Journals from before there were chains, made of those of today: what is wrong in one is told without digests."""

import sqlite3
from contextlib import closing
from pathlib import Path

from engine.search.journal import WITHOUT_CHAIN


def unchain(path: Path) -> Path:
    """Take links and seal out of a journal."""
    with closing(sqlite3.connect(path)) as connection, connection:
        connection.execute("ALTER TABLE generation DROP COLUMN link")
        connection.execute("ALTER TABLE status DROP COLUMN seal")
        connection.execute(f"PRAGMA user_version = {WITHOUT_CHAIN}")
    return path
