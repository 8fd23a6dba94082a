"""A small run of the fuzzer: no recording breaks `cortexc measure`."""

import random
import time
from collections import Counter
from pathlib import Path

from benchmarks.fuzz import recordings
from tests.laws import share

SECONDS = 10.0
"""Of work for one recording."""


def test_no_recording_breaks_a_command(tmp_path: Path) -> None:
    """Every changed file of every kind ends in a result, a result with a note, or a refusal with its place."""
    stream, outcomes = recordings.recordings(random.Random(2)), Counter[str]()
    for number in range(share(150)):
        sample, start = next(stream), time.thread_time()
        outcomes[recordings.judge(sample, tmp_path, every_pair=number % 5 == 0)] += 1
        assert number == 0 or time.thread_time() - start < SECONDS, sample.name
    assert outcomes["refused"] > 0
    assert outcomes["result with a note"] > 0
