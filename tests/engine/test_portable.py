"""Functions whose bits do not depend on the processor: laws over random arguments, with and without its extensions."""

import hashlib
import math
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from engine import portable
from engine.tables import Floats
from tests.processor import EXTENSIONS, on_the_oldest

ROOT = Path(__file__).parent.parent.parent
COUNT = 22_500
OF_ONE = {
    portable.exp: math.exp,
    portable.log: math.log,
    portable.log1p: math.log1p,
    portable.tan: math.tan,
    portable.arcsin: math.asin,
    portable.arctan: math.atan,
}
LIKE = {
    portable.exp: np.exp,
    portable.log: np.log,
    portable.log1p: np.log1p,
    portable.tan: np.tan,
    portable.arcsin: np.arcsin,
    portable.arctan: np.arctan,
}
ANY = arrays(np.float64, st.integers(0, 8), elements=st.floats())


def digests() -> str:
    """Digests of every function of the module, of random arguments; printed by a process for the test below."""
    stream = np.random.default_rng(7)
    share, number, other = stream.random(COUNT), 5.0 * stream.standard_normal(COUNT), stream.standard_normal(COUNT)
    values = {
        "one": np.concatenate([portable.exp(number), portable.tan(number), portable.arctan(number)]),
        "share": np.concatenate([portable.log(share), portable.log1p(share), portable.arcsin(share)]),
        "two": np.concatenate([portable.power(share, number), portable.arctan2(number, other)]),
    }
    for size in (1, 7, 64, 65, 150):
        matrix = number[: size * size].reshape(size, size)
        square = portable.product(matrix, matrix.T) + np.eye(size)
        lower = portable.cholesky(square)
        values[f"matrices {size}"] = np.concatenate([square, lower, portable.solved(lower, matrix)])
    return " ".join(hashlib.sha256(value.tobytes()).hexdigest() for value in values.values())


@pytest.mark.skipif(not EXTENSIONS, reason="numpy has no code for this processor beyond its oldest")
def test_bits_are_those_of_the_oldest_processor() -> None:
    """The logarithms of numpy differ there, so that the two processes do run different code."""
    program = "import numpy as np; from tests.engine.test_portable import digests; print(digests())"
    program += f"; print(np.log(np.random.default_rng(7).random({COUNT})).tobytes().hex())"
    words = [sys.executable, "-c", program]
    run = subprocess.run(words, cwd=ROOT, env=on_the_oldest(), capture_output=True, text=True, check=True)
    ours, of_numpy = run.stdout.splitlines()
    assert ours == digests()
    if "AVX512_SKX" in EXTENSIONS or "X86_V4" in EXTENSIONS:
        assert of_numpy != np.log(np.random.default_rng(7).random(COUNT)).tobytes().hex()


@given(ANY)
@pytest.mark.parametrize("function", OF_ONE)
def test_each_element_is_what_math_returns(function: Callable[[Floats], Floats], values: Floats) -> None:
    """Where `math` raises an error, the infinity or NaN that numpy returns."""
    with np.errstate(all="ignore"):
        found, like = function(values), LIKE[function](values)
    assert np.array_equal(np.isnan(found), np.isnan(like))
    for value, one, near in zip(values.tolist(), found.tolist(), like.tolist(), strict=True):
        try:
            assert np.array_equal(one, OF_ONE[function](value), equal_nan=True)
        except (ValueError, OverflowError):
            assert np.array_equal(one, near, equal_nan=True)


@given(ANY, st.floats())
def test_powers_and_directions_are_what_math_returns(values: Floats, other: float) -> None:
    """Errors of `math` are numpy's infinities and NaN, with their sign."""
    with np.errstate(all="ignore"):
        powers, like, directions = (
            portable.power(values, other),
            np.power(values, other),
            portable.arctan2(values, other),
        )
    turned = [math.atan2(value, other) for value in values.tolist()]
    assert np.array_equal(directions, turned, equal_nan=True)
    for value, one, near in zip(values.tolist(), powers.tolist(), like.tolist(), strict=True):
        try:
            assert np.array_equal(one, math.pow(value, other), equal_nan=True)
        except (ValueError, OverflowError):
            assert np.array_equal(one, near, equal_nan=True)


@given(st.integers(1, 150), st.integers(0, 2**32))
def test_a_factor_times_itself_is_the_matrix(size: int, seed: int) -> None:
    """For stacks, too, each of whose matrices has the factor that it has alone; and systems with it are solved."""
    stream = np.random.default_rng(seed)
    roots = stream.standard_normal((2, size, size))
    matrices = portable.product(roots, roots.transpose(0, 2, 1)) + np.eye(size)
    lower = portable.cholesky(matrices)
    assert np.allclose(lower @ lower.transpose(0, 2, 1), matrices, rtol=1e-9, atol=1e-9)
    assert (np.triu(lower, 1) == 0.0).all()
    right = stream.standard_normal((size, 3))
    assert np.allclose(lower[0] @ portable.solved(lower[0], right), right, rtol=1e-6, atol=1e-6)
