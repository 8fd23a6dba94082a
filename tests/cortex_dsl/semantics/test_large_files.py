"""The work of the compiler is in proportion to the text: counted in lines that run, the same on every machine."""

import sys
from typing import Any

import pytest

from benchmarks.large_files import LARGE, misspelt, of_parts, seconds_of

AS_BEFORE = 1.001
"""What each further part may cost beside the one before; one loop over all params for each of them makes it 1.002."""


def lines_run(text: str) -> int:
    count = 0

    def traced(_frame: Any, _event: str, _argument: Any) -> Any:
        nonlocal count
        count += 1
        return traced

    before = sys.gettrace()
    sys.settrace(traced)
    try:
        seconds_of(text)
    finally:
        sys.settrace(before)
    return count


@pytest.mark.parametrize("kind", ["params, each required", "ends"])
def test_each_further_part_costs_what_the_one_before_did(kind: str) -> None:
    seconds_of(of_parts(LARGE[kind], 1))
    few, some, many = (lines_run(of_parts(LARGE[kind], count)) for count in (25, 50, 100))
    assert many - some <= AS_BEFORE * 2 * (some - few)


def test_a_misspelt_name_is_held_against_many_names_once() -> None:
    """Four more of them cost a part of what the file has cost with the first four, which had to look at all names."""
    four = lines_run(misspelt(400, 4))
    assert lines_run(misspelt(400, 8)) - four < four / 6
