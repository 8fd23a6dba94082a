"""Does a stack that is killed change what a search finds? `python -m benchmarks.kills [KILLS] [FILE]`

Searches with `examples/own_driver/stack.py` once undisturbed, and once while the stack is killed so many times, at
random moments on the clock: the journals must hold the same evaluations and the same actions.
"""

import os
import random
import signal
import sqlite3
import sys
import tempfile
import threading
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cortex_dsl as cx
from engine.search.store import JOURNAL

FILE = "examples/own_driver/crossing.scn"
STACK = Path("examples/own_driver/stack.py").resolve()
PAUSE = (0.5, 2.0)
"""From one kill to the next, in which a stack can start and answer [s]."""
GENERATIONS = 200
"""Which take longer than ten such pauses."""
TABLES = ("individual", "simulation", "action")
"""Of a journal."""


@dataclass(frozen=True)
class Disturbed:
    """What a search with a stack that was killed came to."""

    kills: int
    failures: int
    """Kills in a question."""
    rows: int
    """Of the journal."""
    same: bool


def disturbed(kills: int, file: str, folder: Path) -> Disturbed:
    """A search undisturbed, and again while its stack is killed."""
    undisturbed = searched(file, folder / "one")
    done = threading.Event()
    killed: list[int] = []
    killer = threading.Thread(target=kill, args=(kills, killed, done))
    killer.start()
    other = searched(file, folder / "other")
    done.set()
    killer.join()
    failures = Path(folder, "other", "controller.log").read_text(encoding="utf-8").count("signal 9")
    return Disturbed(len(killed), failures, sum(len(table) for table in undisturbed.values()), undisturbed == other)


def main(kills: int = 10, file: str = FILE) -> None:
    with tempfile.TemporaryDirectory() as folder:
        found = disturbed(kills, file, Path(folder))
    print(f"{found.kills} kills, {found.failures} of them in a question: {found.rows:,} rows of the journal", end=" ")
    print("are the same" if found.same else "DIFFER")
    sys.exit(0 if found.same and found.kills == kills else 1)


def searched(file: str, folder: Path) -> dict[str, list[Any]]:
    """The journal of a search, without what tells of the clock."""
    scenario = cx.load(file).driven_by(f"process:{sys.executable} {STACK}", block=32)
    scenario.search("ga", generations=GENERATIONS, population=40, seed=1, out=folder)
    return journal(folder / JOURNAL)


def journal(path: Path, tables: tuple[str, ...] = TABLES) -> dict[str, list[Any]]:
    """The rows of the tables that tell of nothing but the search."""
    with closing(sqlite3.connect(path)) as opened:
        return {table: sorted(opened.execute(f"SELECT * FROM {table}"), key=repr) for table in tables}


def kill(kills: int, killed: list[int], done: threading.Event) -> None:
    """Kill our stack at random moments of a search."""
    moments = random.Random()
    while len(killed) < kills and not done.is_set():
        done.wait(moments.uniform(*PAUSE))
        for process in children()[: kills - len(killed)]:
            with suppress(ProcessLookupError):
                os.kill(process, signal.SIGKILL)
                killed.append(process)


def children() -> list[int]:
    """Our own children that run the stack."""
    return [each for each in children_of(os.getpid()) if str(STACK) in _line(each)]


def children_of(process: int) -> list[int]:
    """All children of a process that is there."""
    found: list[int] = []
    for task in Path(f"/proc/{process}/task").glob("*/children"):
        with suppress(OSError):
            found += [int(word) for word in task.read_text(encoding="utf-8").split()]
    return found


def _line(process: int) -> str:
    with suppress(OSError):
        return Path(f"/proc/{process}/cmdline").read_text(encoding="utf-8")
    return ""


if __name__ == "__main__":
    main(*(int(word) if word.isdigit() else word for word in sys.argv[1:]))  # type: ignore[arg-type]
