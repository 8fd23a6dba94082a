"""A small run of the fuzzer: no text breaks the compiler."""

import random
import time

from benchmarks import fuzz

INPUTS = 600
SECONDS = 10.0
"""For one text; none of those of this seed needs one."""


def test_no_text_breaks_the_compiler() -> None:
    """Every mutant ends in a program or in diagnostics with places inside the text."""
    stream = fuzz.sources(random.Random(7), fuzz.corpus())
    outcomes = set()
    for _ in range(INPUTS):
        _, text = next(stream)
        start = time.perf_counter()
        outcomes.add(fuzz.judge(text))
        assert time.perf_counter() - start < SECONDS, text
    assert outcomes == {"compiled", "diagnostics"}
