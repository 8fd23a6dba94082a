"""Random numbers that are a pure function of an address: Philox4x32-10.

Salmon, Moraes, Dror and Shaw (2011), "Parallel random numbers: as easy as 1, 2, 3", SC'11: ten rounds of multiply and
exclusive-or turn a 128-bit counter under a 64-bit key into 128 random bits. There is no state to carry: equal
addresses give equal numbers, whatever was drawn before or beside. `engine.streams` says how addresses are packed.
"""

from typing import NamedTuple

import numpy as np

from engine.kernels.inline import inlined
from engine.kernels.jit import kernel
from engine.tables import Floats, Ints

# numba turns a mixture of uint64 and int64 into a float, so every integer in here is a uint64.
MULTIPLIER_0 = np.uint64(0xD2511F53)
MULTIPLIER_1 = np.uint64(0xCD9E8D57)
WEYL_0 = np.uint64(0x9E3779B9)
WEYL_1 = np.uint64(0xBB67AE85)
WORD = np.uint64(0xFFFFFFFF)
WORD_BITS = np.uint64(32)
HALF_WORD_BITS = np.uint64(16)
EXCESS_BITS = np.uint64(11)
LABEL_BITS = np.uint64(4)
NIBBLE = np.uint64(0xF)
BYTE_BITS = np.uint64(8)
ONE = np.uint64(1)
DOUBLE_STEP = 2.0**-53

ATTEMPT_CHANNEL = 0
"""Variants and nuisance draws of a scene's attempts; also the only channel of the other purposes. A channel has four
bits."""
COIN_CHANNEL = 1
"""The coins of `require[p]`, one number a requirement."""
GENE_CHANNEL = 2
"""Gene values, one number a gene."""
JUMP_CHANNEL = 3
"""Attempts that a pruned scene jumps over, one number an attempt."""


class Stream(NamedTuple):
    """All of an address but the block number; 32-bit words kept as uint64."""

    key_0: np.uint64
    key_1: np.uint64
    counter_1: np.uint64
    counter_2: np.uint64
    counter_3: np.uint64


@inlined
def philox4x32(
    key_0: np.uint64, key_1: np.uint64, a: np.uint64, b: np.uint64, c: np.uint64, d: np.uint64
) -> tuple[np.uint64, np.uint64, np.uint64, np.uint64]:
    """Four random 32-bit words from the counter (a, b, c, d) under the key."""
    for _ in range(10):
        product_0 = MULTIPLIER_0 * a
        product_1 = MULTIPLIER_1 * c
        a, c = (product_1 >> WORD_BITS) ^ b ^ key_0, (product_0 >> WORD_BITS) ^ d ^ key_1
        b, d = product_1 & WORD, product_0 & WORD
        key_0, key_1 = (key_0 + WEYL_0) & WORD, (key_1 + WEYL_1) & WORD
    return a, b, c, d


@kernel
def open_stream(key: Ints, purpose: int, channel: int) -> Stream:
    """The stream of one `StreamKey` row for one purpose; the row's fields must fit (see `engine.streams`)."""
    seed = np.uint64(key[0])
    method, run, generation = np.uint64(key[1]), np.uint64(key[2]), np.uint64(key[3])
    place = (method >> LABEL_BITS & NIBBLE) << LABEL_BITS | np.uint64(channel)
    label = (place << LABEL_BITS | np.uint64(purpose)) << LABEL_BITS | method & NIBBLE
    return Stream(
        seed & WORD,
        seed >> WORD_BITS ^ method >> BYTE_BITS,
        np.uint64(key[4]),
        run << HALF_WORD_BITS | generation,
        np.uint64(key[5]) << HALF_WORD_BITS | label,
    )


@inlined
def uniform_pair(stream: Stream, block: np.uint64) -> tuple[float, float]:
    """Numbers 2 * block and 2 * block + 1 of a stream: uniform multiples of 2^-53 in [0, 1)."""
    a, b, c, d = philox4x32(stream.key_0, stream.key_1, block, stream.counter_1, stream.counter_2, stream.counter_3)
    first = float((a << WORD_BITS | b) >> EXCESS_BITS) * DOUBLE_STEP
    return first, float((c << WORD_BITS | d) >> EXCESS_BITS) * DOUBLE_STEP


@kernel
def uniform(stream: Stream, number: int) -> float:
    """Number `number` of a stream, in [0, 1)."""
    position = np.uint64(number)
    first, second = uniform_pair(stream, position >> ONE)
    return second if position & ONE else first


@kernel
def fill_uniform(keys: Ints, purpose: int, channel: int, out: Floats) -> None:
    """Fill `out` (n, k) with the first k numbers of the stream of each of `keys` (n, 6)."""
    for row in range(out.shape[0]):
        stream = open_stream(keys[row], purpose, channel)
        for column in range(out.shape[1]):
            out[row, column] = uniform(stream, column)
