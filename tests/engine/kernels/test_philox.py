"""The random numbers: right bits, right doubles, no shared addresses."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from engine.kernels import random_numbers
from engine.streams import key_rows
from engine.vocabulary import Method, Purpose

WORD = (1 << 32) - 1
words = st.integers(0, WORD)


def reference_philox4x32(key: tuple[int, int], counter: tuple[int, int, int, int]) -> tuple[int, ...]:
    """Philox4x32-10 in Python's unbounded integers, straight from the paper's definition of a round."""
    left, right = key
    c0, c1, c2, c3 = counter
    for _ in range(10):
        high_0, low_0 = divmod(0xD2511F53 * c0, 1 << 32)
        high_1, low_1 = divmod(0xCD9E8D57 * c2, 1 << 32)
        c0, c1, c2, c3 = high_1 ^ c1 ^ left, low_1, high_0 ^ c3 ^ right, low_0
        left, right = (left + 0x9E3779B9) & WORD, (right + 0xBB67AE85) & WORD
    return c0, c1, c2, c3


def compiled_philox4x32(key: tuple[int, ...], counter: tuple[int, ...]) -> tuple[int, ...]:
    return tuple(int(word) for word in random_numbers.philox4x32(*(np.uint64(word) for word in (*key, *counter))))


@pytest.mark.parametrize(
    ("key", "counter", "expected"),
    [
        ((0, 0), (0, 0, 0, 0), (0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8)),
        ((WORD, WORD), (WORD, WORD, WORD, WORD), (0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD)),
        (
            (0xA4093822, 0x299F31D0),
            (0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344),
            (0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1),
        ),
    ],
    ids=["zeros", "ones", "digits of pi"],
)
def test_published_known_answers(key, counter, expected):
    """The three known answers that Random123 publishes for philox4x32 with ten rounds."""
    assert compiled_philox4x32(key, counter) == expected


@given(key=st.tuples(words, words), counter=st.tuples(words, words, words, words))
def test_equals_an_independent_form(key, counter):
    """The kernel equals unbounded-integer Python for any key and counter."""
    assert compiled_philox4x32(key, counter) == reference_philox4x32(key, counter)


def test_doubles_are_the_upper_53_bits():
    """Two words make one double in [0, 1), in the order of the words, at the documented address."""
    seed, method, run, generation, index, rollout = 0x1234_5678_9ABC_DEF0, Method.GA, 3, 4, 5, 6
    actual = np.empty((1, 6))
    random_numbers.fill_uniform(
        key_rows(seed, method, run, generation, [index], rollout), int(Purpose.BEHAVIOUR), 7, actual
    )
    label = rollout << 16 | 7 << 8 | Purpose.BEHAVIOUR << 4 | method
    for number in range(6):
        block = reference_philox4x32((seed & WORD, seed >> 32), (number // 2, index, run << 16 | generation, label))
        high, low = block[2 * (number % 2) :][:2]
        assert actual[0, number] == ((high << 32 | low) >> 11) / 2**53


def test_a_method_of_a_name_has_an_address_of_its_own():
    """Four of its bits beside the channel, the others in the key, as documented."""
    seed, method, run, generation, index, rollout = 0x1234_5678_9ABC_DEF0, 0x9_8765_432F, 3, 4, 5, 6
    actual = np.empty((1, 2))
    random_numbers.fill_uniform(
        key_rows(seed, method, run, generation, [index], rollout), int(Purpose.SCENE), 3, actual
    )
    label = rollout << 16 | 0x2 << 12 | 3 << 8 | Purpose.SCENE << 4 | 0xF
    key = (seed & WORD, seed >> 32 ^ 0x9876543)
    block = reference_philox4x32(key, (0, index, run << 16 | generation, label))
    assert actual[0, 0] == ((block[0] << 32 | block[1]) >> 11) / 2**53


def test_uniformity():
    """A hundred thousand numbers over many streams pass a Kolmogorov-Smirnov test, and neighbours do not correlate."""
    numbers = np.empty((1000, 100))
    random_numbers.fill_uniform(key_rows(7, Method.SAMPLE, 0, 0, range(1000)), int(Purpose.SCENE), 0, numbers)
    assert numbers.min() >= 0.0
    assert numbers.max() < 1.0
    assert stats.kstest(numbers.ravel(), "uniform").pvalue > 0.001
    assert abs(np.corrcoef(numbers[:, :-1].ravel(), numbers[:, 1:].ravel())[0, 1]) < 0.01
    assert abs(np.corrcoef(numbers[:-1].ravel(), numbers[1:].ravel())[0, 1]) < 0.01


def test_purposes_and_channels_do_not_share_numbers():
    """Every purpose and channel of one key is a stream of its own."""
    numbers = np.empty((len(Purpose), 3, 1, 1))
    for purpose in Purpose:
        for channel in range(3):
            random_numbers.fill_uniform(
                key_rows(1, Method.GA, 0, 0, [0]), int(purpose), channel, numbers[purpose, channel]
            )
    assert len(np.unique(numbers)) == numbers.size
