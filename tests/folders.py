"""What the folders of runs and studies hold, without the time that the searches took."""

import json
import signal
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import pytest

from engine.search.journal_reader import read_journal

MADE_BY_SEARCH = (".csv", ".jsonl", ".json", ".md", ".scn")
OF_TIME = ("seconds", "seconds_per_simulation", "per_second", "elapsed", "command_line", "started")
DATABASES: Mapping[str, tuple[str, ...]] = {
    "journal.sqlite": ("manifest", "generation", "individual", "simulation"),
    "study.sqlite": ("manifest", "scenario", "run", "evaluations"),
}
"""Their tables but those of time."""


def files(folder: Path) -> Mapping[str, bytes]:
    """Return the contents of all files that are derived from a journal or a study, by their relative paths."""
    paths = (path for path in folder.rglob("*") if path.suffix in MADE_BY_SEARCH)
    return {str(path.relative_to(folder)): path.read_bytes() for path in paths}


def content(folder: Path) -> Mapping[str, Any]:
    """Return everything in a run or a study but times and the command line: files, rows of tables, and the status."""
    found: dict[str, Any] = dict(files(folder))
    found["summary.json"] = timeless(json.loads(found["summary.json"]))
    for name, tables in DATABASES.items():
        if (folder / name).exists():
            with closing(sqlite3.connect(folder / name)) as connection:
                found |= {table: sorted(connection.execute(f"SELECT * FROM {table}"), key=repr) for table in tables}
    found["manifest"] = [row for row in found["manifest"] if row[0] not in OF_TIME]
    if (folder / "journal.sqlite").exists():
        found["status"] = read_journal(folder / "journal.sqlite").status
    return found


def timeless(value: Any) -> Any:
    """Return a document without times and without the command line."""
    if isinstance(value, dict):
        return {name: timeless(each) for name, each in value.items() if name not in OF_TIME}
    return [timeless(each) for each in value] if isinstance(value, list) else value


@contextmanager
def small_files(size: int) -> Iterator[None]:
    """Let no file grow beyond a size [bytes], as on a full disk; the test is skipped where there are no such limits."""
    resource = pytest.importorskip("resource")
    limits, before = resource.getrlimit(resource.RLIMIT_FSIZE), signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, limits[1]))
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, before)
