"""A row's result depends on its genome and key alone: not on batch, order, threads or earlier attempts."""

from dataclasses import fields
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.config import SimulationConfig
from engine.kernels.attempts import sample_rows
from engine.kernels.random_numbers import ATTEMPT_CHANNEL, fill_uniform
from engine.opcodes import Op
from engine.sampling import sample
from engine.streams import key_rows
from engine.vocabulary import Method, Purpose, Verdict

ROWS = 60
DRAWS = 4
BLOCKS = 3
"""Blocks of two numbers that an attempt with four draws owns: one for the variant, four, one spare."""


@pytest.fixture(scope="module")
def program(assemble):
    """Two soft and hard requirements on the first and the last of four draws, three variants."""
    return assemble(
        poses=[("L0", "L0", "L0")],
        literals=(0.0, 0.3),
        variants=[(0.0,), (0.0,), (0.0,)],
        weights=(1, 2, 3),
        impossible={1: 0},
        genes=[(0, 1)],
        draws=DRAWS,
        checks=[
            ([(Op.LT, "T0", "D0", "G0")], "T0"),
            ([(Op.LT, "T1", "D3", "L1")], "T1", 0.5),
            ([(Op.LT, "T2", "L1", "D1")], "T2"),
        ],
    )


@pytest.fixture(scope="module")
def request_rows():
    keys = key_rows(11, Method.GA, 1, 2, range(ROWS))
    return np.linspace(0.01, 0.9, ROWS)[:, np.newaxis], keys


def assert_equal(actual, expected, rows=slice(None)):
    for field in fields(expected):
        np.testing.assert_array_equal(getattr(actual, field.name), getattr(expected, field.name)[rows], field.name)


@given(rows=st.lists(st.integers(0, ROWS - 1), max_size=12), jobs=st.integers(1, 3))
def test_rows_stand_alone(program, request_rows, rows, jobs):
    """Any selection of rows, in any order, with repetitions, on any number of threads, gives those rows."""
    genomes, keys = request_rows
    whole = sample(program, genomes, keys)
    assert_equal(sample(program, genomes[rows], keys[rows], jobs=jobs), whole, rows)


@pytest.mark.parametrize("jobs", [2, 4])
def test_threads_change_nothing(program, request_rows, jobs):
    """The whole batch on several threads equals the batch on one."""
    assert_equal(sample(program, *request_rows, jobs=jobs), sample(program, *request_rows))


@given(limit=st.integers(1, 60))
def test_a_lower_limit_only_cuts_off(program, request_rows, limit):
    """With fewer attempts allowed, rows that needed no more are the same and the others are exhausted."""
    whole = sample(program, *request_rows)
    cut = sample(program, *request_rows, config=SimulationConfig(max_attempts=limit))
    kept = whole.attempts <= limit
    assert np.all(cut.verdict[~kept] == Verdict.EXHAUSTED)
    assert np.array_equal(cut.draws[kept], whole.draws[kept])
    assert np.array_equal(cut.attempts[kept], whole.attempts[kept])


def test_draws_are_at_their_address(program, request_rows):
    """The accepted attempt's draws are the numbers that its place in the stream holds, though made lazily."""
    scenes = sample(program, *request_rows)
    numbers = np.empty((ROWS, 2 * BLOCKS * int(scenes.attempts.max())))
    fill_uniform(scenes.keys, int(Purpose.SCENE), ATTEMPT_CHANNEL, numbers)
    for row in np.flatnonzero(scenes.valid):
        first = 2 * BLOCKS * (scenes.attempts[row] - 1)
        assert np.array_equal(scenes.draws[row], numbers[row, first + 1 : first + 1 + DRAWS])
        assert scenes.variant[row] == (0 if numbers[row, first] < 1 / 6 else 2)


@pytest.mark.parametrize("column", range(6))
def test_every_field_of_the_key_counts(program, request_rows, column):
    """Changing any one field of the key gives other draws."""
    genomes, keys = request_rows
    other = keys.copy()
    other[:, column] += 1
    first, second = sample(program, genomes, keys), sample(program, genomes, other)
    both = first.valid & second.valid
    assert both.sum() > ROWS / 2
    assert not np.any(first.draws[both] == second.draws[both])


def test_read_only_and_strided_input(program, request_rows):
    """Arrays of another memory layout give the same scenes, without another compilation."""
    genomes, keys = request_rows
    wide = np.repeat(keys, 2, axis=0)[::2]
    frozen = genomes.copy()
    frozen.flags.writeable = False
    kernel: Any = getattr(sample_rows, "finished", sample_rows)
    expected, compiled = sample(program, genomes, keys), len(kernel.signatures)
    assert_equal(sample(program, frozen, wide), expected)
    assert len(kernel.signatures) == compiled
