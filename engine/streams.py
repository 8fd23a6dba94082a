"""Addresses of random numbers: who asks, for which individual, for what. Two addresses never share a number.

Scenes and behaviours draw from Philox4x32-10 (`engine.kernels.philox`): a 64-bit key and a 128-bit counter.

| word      | bits, from the most significant                             |
|-----------|-------------------------------------------------------------|
| key       | seed (63)                                                   |
| counter 0 | block number (32); a block is two uniform numbers           |
| counter 1 | index (32)                                                  |
| counter 2 | run (16), generation (16)                                   |
| counter 3 | rollout (16), channel (8), `Purpose` (4), `Method` (4)      |

Attempt a of a scene with n nuisance draws owns the blocks from a * B on, B = ceil((n + 1) / 2): its first number
picks the variant, the next n are the draws. Soft requirements and genes have channels of their own. A search's
operators draw from numpy's Philox4x64-10 under the same fields (`operator_generator`).
"""

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from engine.errors import ArgumentError
from engine.scenes import StreamKey
from engine.tables import Ints
from engine.vocabulary import Method, Purpose

if TYPE_CHECKING:
    from numpy.random import Generator

FIELD_BITS = StreamKey(seed=63, method=4, run=16, generation=16, index=32, rollout=16)
"""Width of each field. Keys are int64, hence 63."""


def key_rows(
    seed: int, method: int, run: int, generation: int, indices: Iterable[int] | NDArray[np.integer], rollout: int = 0
) -> Ints:
    """(n, 6) int64: one `StreamKey` row for each index."""
    index = np.asarray(indices if isinstance(indices, np.ndarray) else list(indices), dtype=np.int64)
    rows = np.empty((len(index), len(StreamKey._fields)), dtype=np.int64)
    _check(StreamKey(seed, method, run, generation, 0, rollout))
    rows[:] = (seed, method, run, generation, 0, rollout)
    rows[:, StreamKey._fields.index("index")] = index
    check_keys(rows)
    return rows


def check_keys(keys: Ints) -> None:
    """Raise ValueError unless `keys` is (n, 6) int64 and every field fits its place in an address."""
    if keys.ndim != 2 or keys.shape[1] != len(StreamKey._fields) or keys.dtype != np.int64:
        raise ArgumentError(
            f"keys: expected (n, 6) int64 stream keys, got {keys.shape} {keys.dtype}", "`key_rows` makes some"
        )
    if len(keys):
        _check(StreamKey(*(int(value) for value in keys.min(axis=0))))
        _check(StreamKey(*(int(value) for value in keys.max(axis=0))))


def _check(key: StreamKey) -> None:
    for name, value, bits in zip(StreamKey._fields, key, FIELD_BITS, strict=True):
        if not 0 <= value < 1 << bits:
            raise ArgumentError(
                f"{name} of a random stream is {value}; it must lie in 0 .. {(1 << bits) - 1}", "take a number in there"
            )


def format_key(key: Iterable[int]) -> str:
    """A key as text for concrete files: `1.ga.0.12.55.0` (seed, method, run, generation, index, rollout)."""
    fields = StreamKey(*(int(value) for value in key))
    _check(fields)
    return ".".join(str(value) for value in fields._replace(method=Method(fields.method).name.lower()))


def parse_key(text: str) -> StreamKey:
    """Inverse of `format_key`; ValueError says what is wrong."""
    words = text.strip().split(".")
    if len(words) != len(StreamKey._fields):
        raise ArgumentError(
            f"a stream key has six fields, {'.'.join(StreamKey._fields)}; `{text}` has {len(words)}", "copy a whole one"
        )
    numbers = [_method(word) if name == "method" else _number(name, word) for name, word in _named(words)]
    key = StreamKey(*numbers)
    _check(key)
    return key


def _named(words: Iterable[str]) -> Iterable[tuple[str, str]]:
    return zip(StreamKey._fields, words, strict=True)


def _method(word: str) -> int:
    names = [method.name.lower() for method in Method]
    if word not in names:
        raise ArgumentError(f"`{word}` is no method of a stream key; valid: {', '.join(names)}", "name one of these")
    return Method[word.upper()]


def _number(name: str, word: str) -> int:
    if not (word.isascii() and word.isdigit()):
        raise ArgumentError(f"{name} of a stream key is a whole number, not `{word}`", "copy a whole key")
    return int(word)


def operator_generator(seed: int, method: int, run: int, generation: int, index: int = 0) -> "Generator":
    """A numpy generator for a search's operators, independent of every scene and of every other address.

    The fields fill disjoint bits of Philox4x64's key and of the counter's top word, which counting never reaches.
    """
    from numpy.random import Generator, Philox  # not for those who only read the language: it takes its time

    _check(StreamKey(seed, method, run, generation, index, 0))
    key = [seed, run << 48 | generation << 32 | index]
    counter = [0, 0, 0, Purpose.OPERATOR << 4 | method]
    return Generator(Philox(counter=np.array(counter, dtype=np.uint64), key=np.array(key, dtype=np.uint64)))
