"""Processes that are killed at random moments: what is left is whole, and what goes on ends as if undisturbed."""

import random
import shutil
import tempfile
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from benchmarks import kills
from benchmarks.torture.commands import FILE, DiffersError, command, warm
from benchmarks.torture.ledger import Ledger
from engine.errors import CortexError
from engine.search.store import JOURNAL

ROUND = 12
"""Kills of one kind, after which what was done is kept."""
SIZE = ("--generations", "8", "--population", "30", "--seed", "3")

Tidy = Callable[[Path], Any]
"""What a folder holds that must be the same, whatever happened on the way."""


def going_on(
    rng: random.Random, folder: Path, count: int, start: tuple[object, ...], resume: tuple[object, ...], child: bool,
    tidy: Tidy,
) -> int:  # fmt: skip
    """Kill a command and what goes on with it, until so many were killed; the end is that of an undisturbed one."""
    began = time.monotonic()
    if command(*start, folder / "whole").ended():
        raise DiffersError("the undisturbed command failed")
    usual, done, idle = time.monotonic() - began, 0, 0
    while done < count and idle < 50:
        out = folder / f"out-{done}-{idle}"
        for _ in range(min(4, count - done)):
            process = command(*(resume if (out / resume_file(resume)).exists() else start), out)
            hit = process.killed_after(rng.uniform(0.3, 1.0) * usual, child)
            if child and hit:
                process.ended()
            done, idle = done + hit, idle + (not hit)
        for words in (resume if (out / resume_file(resume)).exists() else start, resume):
            if command(*words, out).ended():
                raise DiffersError(f"{words} failed after a kill")
        if tidy(out) != tidy(folder / "whole"):
            raise DiffersError(f"{out.name} is another")
        shutil.rmtree(out)
    return done


def resume_file(resume: tuple[object, ...]) -> str:
    """What there must be to go on."""
    return JOURNAL if resume[0] == "resume" else "study.sqlite"


def tables(folder: Path) -> Any:
    """Rows and tables of a run or a study."""
    rows = kills.journal(folder / JOURNAL, kills.TABLES[:2]) if (folder / JOURNAL).exists() else None
    found = sorted(path for path in folder.rglob("*.csv") if path.name != "pace.csv")
    return rows, [(path.name, path.read_text(encoding="utf-8")) for path in found]


def searches(rng: random.Random, folder: Path, count: int, *words: object, child: bool = False) -> int:
    """Of a search, or of what runs its simulations."""
    start = (FILE, "--ga", *SIZE, *(words or ("--jobs", 1)), "--out")
    return going_on(rng, folder, count, start, ("resume",), child, tables)


def studies(rng: random.Random, folder: Path, count: int) -> int:
    """Of a study of two methods."""
    start = ("study", FILE, "--methods", "ga,random", "--runs", 3, *SIZE, "--jobs", 1, "--out")
    return going_on(rng, folder, count, start, ("study", "--jobs", 1, "--resume"), False, tables)


def exports(rng: random.Random, folder: Path, count: int) -> int:
    """Of an export: each file is there whole, or not at all; done again, it is as if it had been done once."""
    if command(FILE, "--random", *SIZE, "--out", folder / "run").ended():
        raise DiffersError("the search failed")
    words = ("export", folder / "run", "--to", "xosc,csv,commonroad", "--top", 5, "--out")
    began = time.monotonic()
    command(*words, folder / "whole").ended()
    usual, whole, done = time.monotonic() - began, contents(folder / "whole"), 0
    for number in range(2 * count):
        out = folder / f"out-{number}"
        done += command(*words, out).killed_after(rng.uniform(0.6, 1.05) * usual)
        there = contents(out)
        if any(whole.get(name) != content for name, content in there.items() if not name.startswith(".")):
            raise DiffersError("half of a file has its name")
        if command(*words, out).ended() or contents(out) != whole:
            raise DiffersError("an export that was killed is not done again")
        shutil.rmtree(out)
        if done >= count:
            break
    return done


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()} if folder.exists() else {}


def formats(rng: random.Random, folder: Path, count: int) -> int:
    """Of the formatter: a file is as it was, or as it is to be."""
    before = FILE.read_bytes().replace(b"    ", b"  ").replace(b"=", b" = ")
    path = folder / "file.scn"
    path.write_bytes(before)
    began = time.monotonic()
    command("fmt", path).ended()
    usual, after, done = time.monotonic() - began, path.read_bytes(), 0
    for _ in range(3 * count):
        path.write_bytes(before)
        done += command("fmt", path).killed_after(rng.uniform(0.5, 1.0) * usual)
        if path.read_bytes() not in (before, after):
            raise DiffersError("a file is neither as it was nor as it is to be")
        if done >= count:
            break
    return done


def stacks(_: random.Random, folder: Path, count: int) -> int:
    """Of a driver's stack: `benchmarks.kills`."""
    found = kills.disturbed(count, kills.FILE, folder)
    if not found.same:
        raise DiffersError("the journal is another")
    return found.kills


KINDS: Mapping[str, Callable[[random.Random, Path, int], int]] = {
    "searches": searches,
    "workers": lambda rng, folder, count: searches(rng, folder, count, "--engine", "world", "--jobs", 2, child=True),
    "dask": lambda rng, folder, count: searches(rng, folder, count, "--jobs", 2, "--dask", "local", child=True),
    "studies": studies,
    "exports": exports,
    "fmt": formats,
    "stacks": stacks,
}


def killed(count: int, seed: int, kinds: tuple[str, ...], ledger: Ledger) -> tuple[dict[str, int], list[str]]:
    """So many kills, shared by the kinds, and what went wrong."""
    done, wrong = dict.fromkeys(kinds, 0), list[str]()
    for number, kind in enumerate(kinds):
        share = count * (number + 1) // len(kinds) - count * number // len(kinds)
        for first in range(0, share, ROUND):
            name = f"{kind}-{seed}-{first}-{min(ROUND, share - first)}"
            if name not in ledger.done:
                ledger.add(name, _round(kind, random.Random(name), min(ROUND, share - first)))
            done[kind] += ledger.done[name]["kills"]
            wrong += [f"{kind}: {said}" for said in ledger.done[name]["wrong"]]
    return done, wrong


def _round(kind: str, rng: random.Random, count: int) -> dict[str, Any]:
    """Some kills of one kind, and what went wrong."""
    warm()  # before anything is timed
    with tempfile.TemporaryDirectory() as folder:
        try:
            return {"kills": KINDS[kind](rng, Path(folder), count), "wrong": []}
        except (DiffersError, CortexError) as error:
            return {"kills": 0, "wrong": [str(error)]}
