"""A small run of the fuzzers: no text breaks the compiler, and no file a command."""

import random
import time
from collections.abc import Mapping
from dataclasses import dataclass

import pytest

from benchmarks.fuzz import exports, maps, recordings
from benchmarks.fuzz import texts as fuzz
from benchmarks.fuzz.files import Fuzzer
from benchmarks.torture import texts
from benchmarks.torture.commands import FILE
from tests.laws import share

INPUTS = share(600)
SECONDS = 300.0
"""Of work for one text, however busy the machine is: only what never ends takes as long."""


@dataclass(frozen=True)
class Files:
    """A kind of files, and what must be among their outcomes."""

    fuzzer: Fuzzer
    seed: int
    count: int
    outcomes: frozenset[str]
    seconds: float = 10.0
    """Of work for one file."""


NOTED = frozenset({"result with a note", "refused"})
FILES: Mapping[str, Files] = {
    "maps": Files(maps.FUZZER, 5, share(120), frozenset({"run", "refused"}), SECONDS),
    "recordings": Files(recordings.FUZZER, 2, share(150), NOTED),
    "exports": Files(exports.FUZZER, 3, share(150), NOTED),
}


def test_no_text_breaks_the_compiler() -> None:
    """Every mutant ends in a program or in diagnostics with places inside the text."""
    stream = fuzz.sources(random.Random(7), fuzz.corpus())
    outcomes = set()
    for _ in range(INPUTS):
        _, text = next(stream)
        start = time.thread_time()
        outcomes.add(fuzz.judge(text))
        assert time.thread_time() - start < SECONDS, text
    assert outcomes == {"compiled", "diagnostics"}


def test_a_text_runs_to_the_end() -> None:
    """In both hosts, and as its concrete scenario, to the same bits: what `benchmarks.torture` does to many."""
    assert texts.run_to_the_end(FILE.read_bytes()) == "run to the end"


def test_a_run_that_a_drawn_value_makes_invalid_runs_again_from_its_concrete_copy() -> None:
    """What is asked of the whole run is known before it, where the value stands in the file; it was drawn before."""
    never = "require (eventually gap > 5) and not (always gap > 3)"
    text = f"ego = new Car\ngap = Range(3, 9)\n{never}\nterminate after 9 s\n"
    assert texts.run_to_the_end(text.encode()) == "run to the end"


@pytest.mark.parametrize("kind", FILES)
def test_no_file_breaks_a_command(kind: str) -> None:
    """Every changed file ends in a result, a result with a note, or a refusal with its place and a cure."""
    row = FILES[kind]
    rng, outcomes = random.Random(row.seed), set()
    stream = row.fuzzer.samples(rng)
    with row.fuzzer.judging(rng) as judged:
        for _ in range(row.count):
            sample, start = next(stream), time.thread_time()
            outcomes.add(judged(sample))
            assert time.thread_time() - start < row.seconds, sample.name
    assert outcomes >= row.outcomes
