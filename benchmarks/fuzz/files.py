"""The loop, the report and the options that fuzzers of files share: changed files are judged one after the other."""

import argparse
import json
import random
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import asdict, dataclass
from pathlib import Path

from benchmarks.fuzz.texts import limited

TIME_LIMIT = 10
"""For one sample [s]."""
JUMPS = (1e-9, 1e-3, 0.1, 0.9, 1.1, 10.0, 1e3, 1e6, 1e12)
"""Factors and terms by which a number jumps."""


@dataclass(frozen=True)
class Sample:
    """The files of one input, by name; the first is the one that is named to a command."""

    files: dict[str, bytes]

    @property
    def name(self) -> str:
        return next(iter(self.files))


Judge = Callable[[Sample], str]
"""Returns what became of a sample; raises whatever must not be."""


@dataclass(frozen=True)
class Fuzzer:
    """A kind of files."""

    samples: Callable[[random.Random], Iterator[Sample]]
    """Changed files, for ever."""
    judging: Callable[[random.Random], AbstractContextManager[Judge]]
    """Has loaded what a judgement needs, so that the time of the first sample is its own."""


@dataclass(frozen=True)
class Judged:
    """What became of all samples."""

    count: int
    outcomes: dict[str, int]
    broken: int
    slowest: float
    """[s]"""
    seconds: float


def fuzz(fuzzer: Fuzzer, count: int, seed: int = 0, keep: Path | None = None) -> Judged:
    """Judge that many samples; those that break something, and the slowest, are written to `keep`."""
    begin, rng = time.perf_counter(), random.Random(seed)
    stream, outcomes, slowest, slowest_sample = fuzzer.samples(rng), Counter[str](), 0.0, Sample({})
    with fuzzer.judging(rng) as judge:
        for number in range(count):
            sample, start = next(stream), time.thread_time()
            try:
                with limited(TIME_LIMIT):
                    outcome = judge(sample)
            except KeyboardInterrupt:
                raise
            except BaseException as error:
                outcome = "broken"
                _write(keep, f"{number:05d}-{type(error).__name__}", sample, traceback.format_exc())
            if (seconds := time.thread_time() - start) > slowest:
                slowest, slowest_sample = seconds, sample
            outcomes[outcome] += 1
    _write(keep, "slowest", slowest_sample, f"{slowest:.2f} s")
    found = dict(sorted(outcomes.items()))
    return Judged(count, found, outcomes["broken"], slowest, time.perf_counter() - begin)


def _write(folder: Path | None, name: str, sample: Sample, told: str) -> None:
    if folder is not None:
        (folder / name).mkdir(parents=True, exist_ok=True)
        (folder / f"{name}.txt").write_text(told, encoding="utf-8")
        for each, content in sample.files.items():
            (folder / name / each).write_bytes(content)


def run(description: str | None, fuzzer: Fuzzer, arguments: Sequence[str]) -> int:
    """Judge as the command line asks and report; return the exit code."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args(arguments)
    found = fuzz(fuzzer, options.count, options.seed, options.keep)
    if options.json:
        print(json.dumps(asdict(found), indent=2))
    else:
        for name, count in found.outcomes.items():
            print(f"{name:22}{count:>9,}")
        print(f"broken {found.broken}, slowest {found.slowest:.2f} s, {found.seconds:.0f} s in all")
    return 1 if found.broken else 0
