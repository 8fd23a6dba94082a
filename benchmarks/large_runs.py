"""What does a large search cost? `python -m benchmarks.large_runs [--generations 1000] [--population 1000] [FILE]`.

A search by the genetic algorithm in one process, the same search killed in its last tenth and resumed, and a report:
processor time and peak memory of each command, and its time for an individual beside that of a search of a tenth of the
generations. Where nothing is quadratic, that ratio is at most about 1.
"""

import argparse
import json
import os
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
from contextlib import closing
from pathlib import Path
from typing import NamedTuple

from benchmarks.campaigns import EXAMPLES
from engine.search.store import JOURNAL

MOST_MEMORY = 1000.0
"""Memory that a command may take [MB], at a million individuals."""


class Cost(NamedTuple):
    seconds: float
    """Processor time [s]."""
    memory: float
    """Peak of the resident memory [MB]."""


def cost(*words: object, until: tuple[Path, int] | None = None) -> Cost:
    """Run a command to its end, or until a journal has so many generations, when it is killed."""
    command = [sys.executable, "-m", "cortex_dsl", *map(str, words)]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    if until is not None:
        while _generations(until[0]) < until[1]:
            time.sleep(0.1)
        process.send_signal(signal.SIGKILL)
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == (0 if until is None else -signal.SIGKILL), command
    return Cost(used.ru_utime + used.ru_stime, used.ru_maxrss / 1000.0)


def _generations(journal: Path) -> int:
    try:
        with closing(sqlite3.connect(f"file:{journal}?mode=ro", uri=True)) as connection:
            return connection.execute("SELECT count(*) FROM generation").fetchone()[0]
    except sqlite3.Error:
        return -1


def measured(file: Path, population: int, generations: int, folder: Path) -> dict[str, Cost]:
    """Return the cost of each command."""
    run, killed = folder / "run", folder / "killed"
    words = (file, "--ga", "--population", population, "--generations", generations, "--jobs", 1, "--out")
    search = cost(*words, run)
    cost(*words, killed, until=(killed / JOURNAL, generations * 9 // 10))
    found = {"search": search, "resume": cost("resume", killed, "--jobs", 1), "report": cost("report", run)}
    with closing(sqlite3.connect(run / JOURNAL)) as connection:
        connection.execute("ATTACH ? AS other", (str(killed / JOURNAL),))
        links = (connection.execute(f"SELECT link FROM {name}.generation").fetchall() for name in ("main", "other"))
        assert len({str(each) for each in links}) == 1
    shutil.rmtree(folder)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("file", nargs="?", type=Path, default=EXAMPLES / "left_turn.scn")
    parser.add_argument("--population", type=int, default=1000)
    parser.add_argument("--generations", type=int, default=1000)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        sizes = options.generations // 10, options.generations
        few, many = (measured(options.file, options.population, each, Path(folder) / str(each)) for each in sizes)
    rows = {
        name: {
            "seconds": each.seconds,
            "megabytes": each.memory,
            "for an individual beside a tenth": each.seconds / few[name].seconds * sizes[0] / sizes[1],
        }
        for name, each in many.items()
    }
    if options.json:
        print(json.dumps(rows, indent=2))
        return
    for name, row in rows.items():
        print(f"{name:<8}" + ", ".join(f"{number:,.2f} {what}" for what, number in row.items()))
    print(f"asked for: at most {MOST_MEMORY:,.0f} megabytes at a million individuals")


if __name__ == "__main__":
    main()
