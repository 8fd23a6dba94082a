"""Small commands that together call every kernel that the usual commands need; run in an empty folder.

`python -m wheels.jobs [NAMES]` runs those of the names, or all.
"""

import os
import shutil
import sys
import tempfile
from pathlib import Path

from cortex_dsl.cli import main

ROOT = Path(__file__).parent.parent
EXAMPLES = ROOT / "examples"
SMALL = ("--generations", "2", "--population", "12", "--seed", "1")
FORMATS = "xosc,xodr,commonroad,scenic,csv,parquet,mcap,scn"
FAIR = """map intersection(ways=4)
simulation(fair=True)
param V = Range(1, 9) m/s
param GAP = Range(5, 30) m
ego = new Car on road, with speed V
other = new Car ahead of ego by GAP, with speed 1 m/s
require ego can see other
expect always (distance from ego to other) > 2 m
maximize largest(ego.speed)
terminate after 2 s
"""
"""Fair starts, sight, a formula and an objective."""
JOBS: dict[str, tuple[tuple[str, ...], ...]] = {
    "first": (("new", "first.scn"), ("first.scn", "--ga", *SMALL, "--out", "first")),
    "run": (("first.scn",), ("first.scn", "--engine", "batch"), ("first.scn", "--sample", "20")),
    "examples": tuple(
        (str(path), "--ga", *SMALL, "--out", f"examples/{path.stem}")
        for path in sorted((*EXAMPLES.glob("*.scn"), *EXAMPLES.glob("roads/*.scn")))
    ),
    "careful": ((str(ROOT / "benchmarks" / "careful_left_against_crossing.scn"), "--ga", *SMALL, "--out", "careful"),),
    "fair": (("fair.scn", "--sample", "20"), ("fair.scn", "--ga", *SMALL, "--out", "fair")),
    "world": (("first.scn", "--ga", *SMALL, "--engine", "world", "--jobs", "1", "--out", "world"),),
    "objectives": (
        ("first.scn", "--ga", *SMALL, "--objective", "avoidable", "--out", "avoidable"),
        ("first.scn", "--ga", *SMALL, "--objective", "conflict", "--out", "conflict"),
    ),
    "methods": (("first.scn", "--ga", *SMALL, "--method", "failure_kinds", "--out", "kinds"),),
    "after": (
        ("analyse", "first", "--budget", "200"),
        ("probability", "first.scn", "--samples", "200"),
        ("verify", "first"),
        ("verify", "first", "--model", "dynamic", "--worst", "3"),
        ("verify", "examples/motorway_cut_in", "--model", "dynamic", "--worst", "3"),
        ("report", "first"),
        ("study", "first.scn", "--runs", "2", "--generations", "2", "--population", "10", "--out", "study"),
    ),
    "exports": (
        ("export", "first", "--to", FORMATS, "--check", "--out", "exports"),
        ("export", "first", "--to", "xosc", "--mode", "maneuver", "--check", "--out", "maneuver"),
    ),
    "recordings": (
        ("measure", "exports/first-case01.csv", "--to", "scn", "--out", "recorded"),
        ("measure", "exports/first-case01.csv", "--all"),
        ("recorded/first-case01.scn", "--ga", *SMALL, "--out", "replayed"),
    ),
    "drivers": (
        ("crossing.scn", "--ego", "python:planner:drive", "--ga", *SMALL, "--out", "mine"),
        ("crossing.scn", "--ego", "python:planner:drive", "--ego-observes", "egocentric", "--sample", "20"),
        ("verify", "mine", "--ego", "python:planner:drive"),
    ),
}


def perform(names: list[str]) -> int:
    """Run jobs in the present folder; return the number of commands that failed."""
    for path in (EXAMPLES / "own_driver").iterdir():
        shutil.copy(path, path.name)
    Path("fair.scn").write_text(FAIR, encoding="utf-8")
    failed = 0
    for words in (words for name in names for words in JOBS[name]):
        print("cortexc", *words, file=sys.stderr, flush=True)
        status = main([*words, "--no-colour"])
        if status:
            print(f"  failed: {status}", file=sys.stderr, flush=True)
            failed += 1
    return failed


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        sys.path.insert(0, folder)
        sys.exit(perform(sys.argv[1:] or list(JOBS)) > 0)
