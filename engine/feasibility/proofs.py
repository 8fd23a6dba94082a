"""What was proved of a program, kept in the user's cache: checking a file again costs no second proof.

A proof is a pure function of the program's digest and of the code that makes it, so both name the entry.
"""

import json
import os
from collections.abc import Iterator
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path

import numpy as np

from engine.feasibility.explanation import Cut, Feasibility, explain
from engine.program import Program
from engine.user_cache import cached_file

FAMILY = "proof-*.json"
CODE = (Path(__file__).parent, Path(__file__).parents[1] / "road")
"""Folders whose files decide what is proved."""


def remembered(program: Program) -> Feasibility:
    """`explain`, or what it said of the same program before."""
    entry = cached_file(f"proof-{_key(program)}.json", FAMILY)
    known = None if entry is None else _read(entry)
    if known is not None:
        return known
    found = explain(program)
    if entry is not None:
        _write(entry, found)
    return found


def _key(program: Program) -> str:
    return sha256("\0".join([program.digest, *_fingerprints()]).encode()).hexdigest()[:24]


def _fingerprints() -> Iterator[str]:
    """Which code this is, without reading it."""
    for folder in CODE:
        for path in sorted(folder.glob("*.py")):
            state = path.stat()
            yield f"{path.name} {state.st_size} {state.st_mtime_ns}"


def _read(entry: Path) -> Feasibility | None:
    """None where nothing is kept, or what is kept cannot be read."""
    try:
        kept = json.loads(entry.read_text(encoding="utf-8"))
        return Feasibility(
            looked_at=bool(kept["looked_at"]),
            infeasible=bool(kept["infeasible"]),
            conflict=tuple(kept["conflict"]),
            impossible=np.array(kept["impossible"], dtype=np.int32),
            low=np.array(kept["low"], dtype=np.float64),
            high=np.array(kept["high"], dtype=np.float64),
            cuts=tuple(Cut(**{**cut, "requirements": tuple(cut["requirements"])}) for cut in kept["cuts"]),
        )
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _write(entry: Path, found: Feasibility) -> None:
    """Whole or not at all; a cache that cannot be written is none."""
    kept = asdict(found) | {name: getattr(found, name).tolist() for name in ("impossible", "low", "high")}
    unborn = entry.with_name(f"{entry.stem}-{os.getpid()}.json")
    try:
        unborn.write_text(json.dumps(kept, default=lambda value: value.item()), encoding="utf-8")
        unborn.replace(entry)
    except OSError:
        unborn.unlink(missing_ok=True)
