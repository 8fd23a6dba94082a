"""What does all of this come to, at once? `python -m benchmarks.torture [--texts 100000] [--runs 5000] [--kills 500]`

Texts of the fuzzer (`benchmarks.fuzz`) are compiled; of those that compile, so many run to the end: in both hosts,
which must agree (`benchmarks.agreement`), and as the concrete scenario of their scene, which must run to the same bits.
Then processes are killed at random moments: searches, their workers, those of a Dask cluster, studies, exports, the
formatter and a driver's stack. What is left must be whole, and what goes on must end as if nobody had disturbed it.
Exit code 1 if anything is lost, differs or is answered with a traceback; `--keep FOLDER` writes the texts down. Meant
for an idle machine; fewer of each for a busy one.
"""

import argparse
import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cortex_dsl as cx
from benchmarks import agreement, fuzz, kills
from cortex_dsl.syntax.reading import decode
from engine import batch
from engine.errors import ControllerError, CortexError
from engine.search.store import JOURNAL

CHUNK = 100
"""Texts that a process takes at a time."""
TIME_LIMIT = 120
"""For one run in both hosts [s]."""
FILE = Path("examples/left_turn.scn").resolve()
SAME = ("verdict", "collided", "end_reason", "steps", "min_distance", "closing_speed", "end_time", "contact_actors")
"""What a concrete scenario comes to, bit for bit."""
SIZE = ("--generations", "8", "--population", "30", "--seed", "3")


# -- texts, some of which run to the end -------------------------------------------------------------------------------


@dataclass(frozen=True)
class Part:
    """What became of the texts of one chunk."""

    outcomes: Counter[str]
    broken: list[fuzz.Broken]


def run_to_the_end(text: bytes) -> str:
    """What a text that compiles comes to; raises whatever must not be."""
    scenario = cx.compile_text(decode("fuzzed.scn", text).text)
    scenario = replace(
        scenario, config=replace(scenario.config, contact=replace(scenario.config.contact, aftermath=0.0))
    )
    try:
        scenes = scenario.scene_of_seed(0)
    except ControllerError:
        return "nobody drives"
    if not scenes.valid[0]:
        return "no scene"
    found = agreement.held(scenario, scenes)
    if found.flags_differ or found.states_differ > agreement.TOLERANCE:
        raise AssertionError(f"the hosts differ: {found}")
    again = cx.compile_text(scenario.concrete(scenes))
    again = replace(again, config=scenario.config)
    one, other = (
        batch.simulate(each.program, drawn, each.config.simulation, contact=each.config.contact)
        for each, drawn in ((scenario, scenes), (again, again.scene_of_seed()))
    )
    for name in SAME:
        if getattr(one, name).tobytes() != getattr(other, name).tobytes():
            raise AssertionError(f"the concrete scenario differs in {name}")
    return "run to the end"


def run_chunk(seed: int, count: int, runs: int) -> Part:
    """`count` texts of one stream, of which at most so many run to the end."""
    resource.setrlimit(resource.RLIMIT_AS, (fuzz.MEMORY_LIMIT, fuzz.MEMORY_LIMIT))
    stream, outcomes, broken = fuzz.sources(random.Random(seed), fuzz.corpus()), Counter[str](), list[fuzz.Broken]()
    for _ in range(count):
        kind, text = next(stream)
        try:
            with fuzz.limited(fuzz.TIME_LIMIT):
                outcome = fuzz.judge(text)
            outcomes[outcome] += 1
            if outcome == "compiled" and outcomes["run to the end"] < runs:
                with fuzz.limited(TIME_LIMIT):
                    outcomes[run_to_the_end(text)] += 1
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            outcomes["broken"] += 1
            broken.append(fuzz.Broken(f"{kind}-{type(error).__name__}", text, traceback.format_exc()))
    return Part(outcomes, broken)


def texts(count: int, runs: int, seed: int, jobs: int, keep: Path | None) -> Counter[str]:
    """What became of so many texts."""
    each = [-(-runs * size // count) for size in fuzz.chunks(count, CHUNK)]
    parts = fuzz.spread(run_chunk, count, CHUNK, seed * fuzz.SEEDS + 500_000, jobs, each)
    broken = [one for part in parts for one in part.broken]
    if keep is not None:
        fuzz.write_down(broken, keep)
    return sum((part.outcomes for part in parts), Counter[str]())


# -- kills -------------------------------------------------------------------------------------------------------------

Tidy = Callable[[Path], Any]
"""What a folder holds that must be the same, whatever happened on the way."""


class DiffersError(Exception):
    """Something was lost, or is another."""


def command(*words: object) -> "subprocess.Popen[bytes]":
    """Start `cortexc`, in a session of its own; a traceback on its stderr is a fault."""
    line = [sys.executable, "-m", "cortex_dsl", *map(str, words)]
    return subprocess.Popen(line, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True)


def ended(process: "subprocess.Popen[bytes]") -> int:
    """The exit code of a process that is waited for."""
    said = process.communicate()[1].decode(errors="replace")
    if "Traceback" in said or "a bug in cortexc" in said:
        raise DiffersError(said[-2000:])
    return process.returncode


def killed(process: "subprocess.Popen[bytes]", seconds: float, child: bool = False) -> bool:
    """Kill a process, or one of its children alone, after some time; whether there was one to kill."""
    try:
        process.wait(seconds)
    except subprocess.TimeoutExpired:
        victims = kills.children_of(process.pid) if child else [process.pid]
        for victim in victims[-1:]:
            (os.kill if child else os.killpg)(victim, signal.SIGKILL)
        if not child:
            process.communicate()
        return bool(victims)
    ended(process)
    return False


def going_on(
    rng: random.Random, folder: Path, count: int, start: tuple[object, ...], resume: tuple[object, ...], child: bool,
    tidy: Tidy,
) -> int:  # fmt: skip
    """Kill a command and what goes on with it, until so many were killed; the end is that of an undisturbed one."""
    began = time.monotonic()
    if ended(command(*start, folder / "whole")):
        raise DiffersError("the undisturbed command failed")
    usual, done, idle = time.monotonic() - began, 0, 0
    while done < count and idle < 50:
        out = folder / f"out-{done}-{idle}"
        for _ in range(min(4, count - done)):
            process = command(*(resume if (out / resume_file(resume)).exists() else start), out)
            hit = killed(process, rng.uniform(0.3, 1.0) * usual, child)
            if child and hit:
                ended(process)
            done, idle = done + hit, idle + (not hit)
        for words in (resume if (out / resume_file(resume)).exists() else start, resume):
            if ended(command(*words, out)):
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
    return rows, [(path.name, [line for line in path.read_text().splitlines() if rows]) for path in found]


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
    if ended(command(FILE, "--random", *SIZE, "--out", folder / "run")):
        raise DiffersError("the search failed")
    words = ("export", folder / "run", "--to", "xosc,csv,commonroad", "--top", 5, "--out")
    began = time.monotonic()
    ended(command(*words, folder / "whole"))
    usual, whole, done = time.monotonic() - began, contents(folder / "whole"), 0
    for number in range(2 * count):
        out = folder / f"out-{number}"
        done += killed(command(*words, out), rng.uniform(0.6, 1.05) * usual)
        there = contents(out)
        if any(whole.get(name) != content for name, content in there.items() if not name.startswith(".")):
            raise DiffersError("half of a file has its name")
        if ended(command(*words, out)) or contents(out) != whole:
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
    ended(command("fmt", path))
    usual, after, done = time.monotonic() - began, path.read_bytes(), 0
    for _ in range(3 * count):
        path.write_bytes(before)
        done += killed(command("fmt", path), rng.uniform(0.5, 1.0) * usual)
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


def kill_all(count: int, seed: int, kinds: tuple[str, ...]) -> tuple[dict[str, int], list[str]]:
    """So many kills, shared by the kinds, and what went wrong."""
    done, wrong = dict[str, int](), list[str]()
    for number, kind in enumerate(kinds):
        share = count * (number + 1) // len(kinds) - count * number // len(kinds)
        with tempfile.TemporaryDirectory() as folder:
            try:
                done[kind] = KINDS[kind](random.Random(seed + number), Path(folder), share) if share else 0
            except (DiffersError, CortexError) as error:
                done[kind] = 0
                wrong.append(f"{kind}: {error}")
    return done, wrong


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--texts", type=int, default=100_000)
    parser.add_argument("--runs", type=int, default=5_000, help="of the texts that compile, these run to the end")
    parser.add_argument("--kills", type=int, default=500)
    parser.add_argument("--kinds", default=",".join(KINDS), help="of kills")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--keep", type=Path, help="a folder for texts that break something")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    began = time.monotonic()
    found = texts(options.texts, options.runs, options.seed, options.jobs, options.keep) if options.texts else Counter()
    done, wrong = kill_all(options.kills, options.seed, tuple(options.kinds.split(",")))
    seconds = time.monotonic() - began
    if options.json:
        print(json.dumps({"texts": found, "kills": done, "wrong": wrong, "seconds": seconds}, indent=2))
    else:
        print(f"{options.texts:,} texts: " + ", ".join(f"{count:,} {name}" for name, count in sorted(found.items())))
        print(f"{sum(done.values()):,} kills: " + ", ".join(f"{count:,} {kind}" for kind, count in done.items()))
        print("\n".join(wrong) or f"nothing lost, nothing different, no traceback; {seconds:.0f} s")
    return 1 if found["broken"] or wrong else 0


if __name__ == "__main__":
    sys.exit(main())
