"""How long `cortexc FILE --check` takes on a map: read for the first time, kept from before, and beside a bare file.

Processor time of whole processes, in turn, with a cache of their own; medians of the rounds. The first process of all,
which compiles Python's own files, does not count.
"""

import os
import resource
import statistics
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

ROUNDS = 5
BARE = "map intersection(ways=4)\nego = new Car on road\n"


def seconds(script: Path, folder: Path) -> Mapping[str, float]:
    """By what is done, of a process [s]."""
    found: dict[str, list[float]] = {"a bare file": [], "the first time": [], "kept": []}
    with TemporaryDirectory() as place:
        bare = Path(place) / "bare.scn"
        bare.write_text(BARE, encoding="utf-8")
        surroundings = {
            **{name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"},
            "CORTEXC_MAPS": str(folder.resolve()),
            "CORTEXC_CACHE": place,
            "PYTHONPYCACHEPREFIX": f"{place}/pyc",
        }
        _checked(script, surroundings)
        for _ in range(ROUNDS):
            found["a bare file"].append(_checked(bare, surroundings))
            for entry in (*Path(place).glob("roads-*"), *Path(place).glob("proof-*")):
                entry.unlink()
            found["the first time"].append(_checked(script, surroundings))
            found["kept"].append(_checked(script, surroundings))
    return {name: statistics.median(each) for name, each in found.items()}


def _checked(file: Path, surroundings: Mapping[str, str]) -> float:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    words = [sys.executable, "-m", "cortex_dsl", str(file), "--check"]
    subprocess.run(words, env=dict(surroundings), check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
