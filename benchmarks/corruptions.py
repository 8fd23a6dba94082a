"""Is a journal that was changed read without a word? `python -m benchmarks.corruptions [--count 1000] [--seed 0]`

Finished journals of three searches (for the risk alone, for what a competent driver avoids, with a controller) are
changed at random: bits and bytes of the file, its pages, its end, cells and rows of its tables, and values inside its
manifest. Each is read as every command reads it, and must be refused with a cure, unless what is read is, number for
number, what the undamaged journal gives: such changes are harmless. Exit code 1 if one passes in silence, or breaks
something.
"""

import argparse
import json
import pickle
import random
import shutil
import sqlite3
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

import cortex_dsl as cx
from benchmarks.campaigns import EXAMPLES
from benchmarks.fuzz.texts import limited
from engine.search.journal_reader import read_journal
from engine.search.store import JOURNAL, StoreError

PAGE = 4096
TIME_LIMIT = 20
"""For reading one journal [s]."""
TABLES = ("manifest", "generation", "individual", "simulation", "pace", "status", "action", "blame")
OUTCOMES = ("refused", "harmless", "silent", "broken")
Change = Callable[[random.Random, Path], None]


# -- changes -----------------------------------------------------------------------------------------------------------


def bits(rng: random.Random, path: Path) -> None:
    """One bit, or a few."""
    data = bytearray(path.read_bytes())
    for _ in range(rng.choice((1, 1, 1, 2, 8))):
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    path.write_bytes(data)


def stretch(rng: random.Random, path: Path) -> None:
    """Some bytes in a row: other ones, zeros, or those of another place."""
    data = bytearray(path.read_bytes())
    size = rng.choice((1, 4, 16, 64, 512))
    at, other = rng.randrange(len(data) - size), rng.randrange(len(data) - size)
    data[at : at + size] = rng.choice((rng.randbytes(size), bytes(size), data[other : other + size]))
    path.write_bytes(data)


def pages(rng: random.Random, path: Path) -> None:
    """A page written to the place of another, lost, or two that changed places."""
    data = bytearray(path.read_bytes())
    first, second = (PAGE * rng.randrange(len(data) // PAGE) for _ in range(2))
    one, two = data[first : first + PAGE], data[second : second + PAGE]
    data[first : first + PAGE] = rng.choice((two, bytes(PAGE)))
    if rng.random() < 0.5:
        data[second : second + PAGE] = one
    path.write_bytes(data)


def end(rng: random.Random, path: Path) -> None:
    """The file cut off, or something at its end."""
    data = path.read_bytes()
    cut = rng.randrange(len(data))
    path.write_bytes(data[:cut] if rng.random() < 0.7 else data + rng.randbytes(rng.choice((1, PAGE))))


def cells(rng: random.Random, path: Path) -> None:
    """A cell of a table: another number, that of another row, a text, nothing."""
    with opened(path) as connection:
        table = _table(rng, connection)
        column = rng.choice([row[1] for row in connection.execute(f"PRAGMA table_info({table})")])
        rows = connection.execute(f"SELECT {column} FROM {table}").fetchall()
        old, other = (rng.choice(rows)[0] for _ in range(2))
        new = rng.choice((other, other, _near(rng, old), None, "7", 7, 0.5))
        where = f"{column} IS ? LIMIT 1 OFFSET ?"
        key = [row[1] for row in connection.execute(f"PRAGMA table_info({table})") if row[5]] or ["status"]
        found = connection.execute(
            f"SELECT {', '.join(key)} FROM {table} WHERE {where}",
            (old, rng.randrange(sum(each[0] == old for each in rows))),
        ).fetchone()
        condition = " AND ".join(f"{name} IS ?" for name in key)
        connection.execute(f"UPDATE {table} SET {column} = ? WHERE {condition}", (new, *found))


def rows(rng: random.Random, path: Path) -> None:
    """Rows taken away, of one place or of a generation; or a row that is there twice, under another key."""
    with opened(path) as connection:
        table = _table(rng, connection)
        names = [row[1] for row in connection.execute(f"PRAGMA table_info({table})")]
        row = rng.choice(connection.execute(f"SELECT * FROM {table}").fetchall())
        if rng.random() < 0.6:
            size = rng.choice((1, 2)) if names[0] == "generation" else 1
            condition = " AND ".join(f"{name} IS ?" for name in names[:size])
            connection.execute(f"DELETE FROM {table} WHERE {condition}", row[:size])
        else:
            added = (_near(rng, row[0]), *row[1:])
            marks = ", ".join("?" * len(row))
            connection.execute(f"INSERT OR REPLACE INTO {table} VALUES ({marks})", added)


def manifest(rng: random.Random, path: Path) -> None:
    """A value inside the manifest, as somebody edits it: another that fits, or a field more or less."""
    with opened(path) as connection:
        fields = dict(connection.execute("SELECT field, value FROM manifest").fetchall())
        name = rng.choice((*fields, "objective", "number"))
        values = ['["risk"]', '["avoidable"]', '["severity"]', "0", "1", '"x"', "[]", "null", *fields.values()]
        new = rng.choice(
            (_edited(rng, fields.get(name, "[]")), _edited(rng, fields.get(name, "[]")), rng.choice(values))
        )
        connection.execute("INSERT OR REPLACE INTO manifest VALUES (?, ?)", (name, new))


KINDS: Mapping[str, Change] = {change.__name__: change for change in (bits, stretch, pages, end, cells, rows, manifest)}


def _table(rng: random.Random, connection: sqlite3.Connection) -> str:
    there = [table for table in TABLES if connection.execute(f"PRAGMA table_info({table})").fetchall()]
    return rng.choice([table for table in there if connection.execute(f"SELECT 1 FROM {table}").fetchone()])


def _near(rng: random.Random, value: Any) -> Any:
    """Another value of its kind."""
    if isinstance(value, bytes):
        data = bytearray(value or b"\0")
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
        return bytes(data)
    if isinstance(value, str):
        return value.replace("1", "2", 1) if "1" in value else value + " "
    return (value or 0) + rng.choice((1, -1, 2, 256) if isinstance(value, int) else (1.0, 1e-9, -0.5))


def _edited(rng: random.Random, text: str) -> str:
    """A document with a number, a text or a truth in it changed."""
    document: Any = {"": json.loads(text)}
    inner, place = document, ""
    while isinstance(inner[place], dict | list) and inner[place]:
        inner = inner[place]
        place = rng.choice(list(inner) if isinstance(inner, dict) else range(len(inner)))
    old = inner[place]
    inner[place] = not old if isinstance(old, bool) else _near(rng, old if isinstance(old, int | float | str) else "x")
    return json.dumps(document[""], ensure_ascii=False)


def opened(path: Path) -> "closing[sqlite3.Connection]":
    """A connection whose every statement is a transaction of its own."""
    return closing(sqlite3.connect(path, isolation_level=None))


# -- judgement ---------------------------------------------------------------------------------------------------------


def fingerprint(path: Path) -> bytes:
    """All that a reader returns, bit for bit."""
    record = read_journal(path)
    content = asdict(record)
    content["actions"] = sorted((key, each.tobytes()) for key, each in record.actions.items())
    return pickle.dumps(_plain(content))


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return [(name, _plain(each)) for name, each in value.items()]
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    return (value.dtype.str, value.shape, value.tobytes()) if hasattr(value, "tobytes") else repr(value)


def judged(whole: bytes, path: Path) -> str:
    """What becomes of a journal that was changed."""
    try:
        with limited(TIME_LIMIT):
            return "harmless" if fingerprint(path) == whole else "silent"
    except StoreError as error:
        return "refused" if error.cure else "broken"
    except Exception as error:
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
        return "broken"


def corrupted(journals: list[Path], count: int, seed: int) -> Counter[tuple[str, str]]:
    """So many changes, each of a fresh copy: (kind, outcome)."""
    rng, found = random.Random(seed), Counter[tuple[str, str]]()
    wholes = [fingerprint(path) for path in journals]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / JOURNAL
        for number in range(count):
            at = rng.randrange(len(journals))
            kind = list(KINDS)[number % len(KINDS)]
            for stale in path.parent.iterdir():
                stale.unlink()
            shutil.copy(journals[at], path)
            with suppress(sqlite3.Error):  # what a table does not take leaves it as it was
                KINDS[kind](rng, path)
            found[kind, judged(wholes[at], path)] += 1
    return found


def searched(folder: Path) -> Iterator[Path]:
    """Journals of three small searches."""
    left_turn = EXAMPLES / "left_turn.scn"
    yield _search(folder / "risk", cx.load(left_turn), rollouts=2)
    yield _search(folder / "avoidable", cx.load(left_turn), objective="avoidable")
    driven = cx.load(EXAMPLES / "own_driver" / "crossing.scn").driven_by("python:examples.own_driver.planner:drive")
    yield _search(folder / "driven", driven)


def _search(folder: Path, scenario: cx.Scenario, **options: Any) -> Path:
    scenario.search("ga", generations=6, population=20, seed=1, out=folder, **options)
    return folder / JOURNAL


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        found = corrupted(list(searched(Path(folder))), options.count, options.seed)
    table = {kind: {outcome: found[kind, outcome] for outcome in OUTCOMES} for kind in KINDS}
    table["all"] = {outcome: sum(row[outcome] for row in table.values()) for outcome in OUTCOMES}
    if options.json:
        print(json.dumps(table, indent=2))
    else:
        print(f"{'':10}" + "".join(f"{outcome:>10}" for outcome in OUTCOMES))
        for kind, row in table.items():
            print(f"{kind:10}" + "".join(f"{number:>10,}" for number in row.values()))
    return 1 if table["all"]["silent"] + table["all"]["broken"] else 0


if __name__ == "__main__":
    sys.exit(main())
