"""A small run of the fuzzer: no text breaks the compiler."""

import random
import time

from benchmarks.fuzz import maps
from benchmarks.fuzz import texts as fuzz
from benchmarks.torture import texts
from benchmarks.torture.commands import FILE
from tests.laws import share

INPUTS = share(600)
MAPS = share(120)
SECONDS = 300.0
"""Of work for one text, however busy the machine is: only what never ends takes as long."""


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


def test_no_road_file_breaks_a_command() -> None:
    """Every changed file ends in a run, a run with a note, or a refusal that says where in the file."""
    rng = random.Random(5)
    stream, outcomes = maps.samples(rng), set()
    with maps.judging(rng) as judged:
        for _ in range(MAPS):
            sample, start = next(stream), time.thread_time()
            outcomes.add(judged(sample))
            assert time.thread_time() - start < SECONDS, sample
    assert {"run", "refused"} <= outcomes
