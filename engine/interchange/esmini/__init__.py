"""Playback of exported files by esmini, if its library is available, and comparison with the run.

The library is loaded in a separate process (`child.py`) with limits of time and memory. The user names it; it is never
searched for, neither in the working folder nor at a path in a file.
"""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from engine.errors import InterchangeError, quoted
from engine.interchange.openscenario.document import entity_names
from engine.interchange.recording import Recording
from engine.tables import Floats

VARIABLE = "CORTEXC_ESMINI"
"""Environment variable that names the library if `--esmini` does not."""
LIBRARIES = ("libesminiLib.so", "libesminiLib.dylib", "esminiLib.dll")
CHILD = Path(__file__).with_name("child.py")
PATIENCE = 60.0
"""Time limit for one file [s]."""
MEMORY = 4_000_000_000
"""Memory limit of its process [bytes]."""
HOW_TO = f"name the library of a built esmini by --esmini PATH, or by its whole path in {VARIABLE}"


def esmini_library(named: Path | None) -> Path:
    """Return the path of esmini's library: the named path, else that of the variable; a folder may contain it, or its
    `bin`.

    Raises:
        InterchangeError: no path is given, or the library is not there.
    """
    text = os.environ.get(VARIABLE, "") if named is None else str(named)
    if not text:
        raise InterchangeError("esmini is not known here", HOW_TO)
    path = Path(text).expanduser()
    if named is None and not path.is_absolute():
        raise InterchangeError(f"{VARIABLE} is {quoted(text)}, and no whole path", HOW_TO)
    places = [path, *(path / folder / name for folder in ("", "bin") for name in LIBRARIES)]
    found = next((place for place in places if place.is_file()), None)
    if found is None:
        raise InterchangeError(f"there is no esmini at {quoted(text)}", HOW_TO)
    return found.resolve()


@dataclass(frozen=True)
class Played:
    """Playback of a file by esmini."""

    instants: Floats
    """(instants,) [s]."""
    poses: Floats
    """(instants, actors, 3) Centre of the outline [m] and heading [rad]; NaN for an absent actor."""
    collisions: Mapping[frozenset[str], float]
    """First time at which two entities collide [s]."""


def play(
    library: Path,
    files: Mapping[str, bytes],
    name: str,
    recording: Recording,
    instants: Floats,
    trajectory_filter: str = "0",
) -> Played:
    """Play the named file, with the other files that it needs.

    `trajectory_filter`: distance [m] below which esmini merges vertices.

    Raises:
        InterchangeError: esmini does not open it, crashes, takes too long, too much memory, or is not esmini.
    """
    names = entity_names(recording)
    with TemporaryDirectory() as folder:
        for each, content in files.items():
            (Path(folder) / each).write_bytes(content)
        job = {
            "library": str(library),
            "file": str(Path(folder) / name),
            "names": names,
            "instants": instants.tolist(),
            "filter": trajectory_filter,
        }
        answer = answer_of(job, Path(folder), name)
    _refuse_other_layout(answer["sizes"], recording, names)
    missing = [float("nan")] * 3
    poses = np.array([[missing if pose is None else pose for pose in row] for row in answer["poses"]], dtype=np.float64)
    collisions: dict[frozenset[str], float] = {}
    for time, one, other in answer["collisions"]:
        collisions.setdefault(frozenset((one, other)), time)
    return Played(instants, poses.reshape(len(instants), len(names), 3), collisions)


def answer_of(job: Mapping[str, Any], folder: Path, name: str) -> dict[str, Any]:
    """Return the answer of `child.py` to a job; it works in this folder.

    Raises:
        InterchangeError: as `play`.
    """
    result, bounds = folder / "result.json", {"memory": MEMORY, "seconds": int(PATIENCE)}
    try:
        done = subprocess.run(  # noqa: S603 - our own script, by this very interpreter
            [sys.executable, "-I", str(CHILD), str(result)],
            input=json.dumps({**job, **bounds}).encode(),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            cwd=folder,
            timeout=PATIENCE,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise InterchangeError(f"esmini hangs: no end after {PATIENCE:g} s", BY_HAND, name) from None
    answer: dict[str, Any] = json.loads(result.read_text(encoding="utf-8")) if result.exists() else {}
    if "poses" in answer or "rows" in answer:
        return answer
    raise InterchangeError(_reason(answer, done.returncode, done.stderr), BY_HAND, name)


BY_HAND = "play the file with esmini itself, and look into its log"


def _reason(answer: Mapping[str, Any], code: int, said: bytes) -> str:
    """Return the reason for a missing answer."""
    if "missing" in answer or "foreign" in answer:
        return f"this is not a library of esmini: {quoted(str(answer.get('missing', answer.get('foreign'))))}"
    if "memory" in answer:
        return f"esmini takes more than {MEMORY / 1e9:g} GB"
    if answer.get("refused"):
        return "esmini does not open it"
    if code == -getattr(signal, "SIGXCPU", 0):
        return f"esmini hangs: no end after {PATIENCE:g} s"
    if code < 0:
        return f"esmini crashes ({signal.Signals(-code).name})"
    last = said.decode(errors="replace").strip().splitlines()
    return f"esmini ends without an answer{': ' + quoted(last[-1]) if last else ''}"


def _refuse_other_layout(sizes: Mapping[str, Sequence[float]], recording: Recording, names: Sequence[str]) -> None:
    """Raise InterchangeError if the fields of the library's states differ from esmini 3.6.0, so that values are
    unreliable.
    """
    for name, actor in zip(names, recording.actors, strict=True):
        if name in sizes and not np.allclose(sizes[name], (actor.length, actor.width), atol=1e-3):
            raise InterchangeError(
                "this esmini lays its states out otherwise than version 3.6.0", "take that version, or a near one"
            )
