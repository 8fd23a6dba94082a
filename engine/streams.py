"""Addresses of random numbers: the method, the individual, the purpose. Two addresses never share a number.

Scenes and behaviours draw from Philox4x32-10 (`engine.kernels.random_numbers`): a 64-bit key and a 128-bit counter.

| word      | bits, from the most significant                             |
|-----------|-------------------------------------------------------------|
| key       | seed (63); its upper word exclusive-or method bits 8 to 35  |
| counter 0 | block number (32); a block is two uniform numbers           |
| counter 1 | index (32)                                                  |
| counter 2 | run (16), generation (16)                                   |
| counter 3 | rollout (16), method bits 4 to 7 (4), channel (4),          |
|           | `Purpose` (4), method bits 0 to 3 (4)                       |

A method that has a value in `Method` is numbered by it; every other method, of this or of another package, by its name
(`method_number`): the first 32 bits of SHA-256 of the name, above the four bits of `Method.CUSTOM`. Two such methods
share their numbers when these 32 bits are equal, which has probability 2^-32 for two names, and 1e-8 for ten methods in
one installation; or, for seeds of 2^32 and above only, when their seeds differ by the difference of their names. With a
method of `Method` they share no number.

Attempt a of a scene with n nuisance draws owns the blocks from a * B on, B = ceil((n + 1) / 2): its first number picks
the variant, the next n are the draws. Soft requirements and genes have channels of their own. A search's operators draw
from numpy's Philox4x64-10 under the same fields (`operator_generator`).
"""

import re
from collections.abc import Iterable, Iterator
from hashlib import sha256
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.errors import ArgumentError
from engine.tables import Ints
from engine.vocabulary import Method, Purpose

if TYPE_CHECKING:
    from numpy.random import Generator

    from engine.program import Program


class StreamKey(NamedTuple):
    """Name of one stream of random numbers. Equal keys give equal numbers, independent of all other streams."""

    seed: int
    method: int
    """`vocabulary.Method`, or the number of a search method's name (`engine.streams.method_number`)."""
    run: int
    generation: int
    index: int  # pyright: ignore[reportIncompatibleMethodOverride]  # no value is ever looked up in a key
    rollout: int


FIELD_BITS = StreamKey(seed=63, method=36, run=16, generation=16, index=32, rollout=16)
"""Width of each field. Keys are int64, hence 63."""
SINGLE_DRAWS = 100
"""Maximum number of genomes that a single run samples until one allows a scene; Scenic redraws params, too."""
NUMBER_BITS = 4
"""Number of bits of a method that `Method.CUSTOM` fills if the remaining bits come from its name."""
NO_SEARCH = (Method.SINGLE, Method.SAMPLE, Method.CUSTOM)
"""Numbers that no search method has, for any name."""
NAMED = "method-"
"""Beginning of a method numbered by its name, in the text of a key; eight hexadecimal digits follow."""


def method_number(name: str) -> int:
    """Return the `method` of a search method's stream keys: its value in `Method`, else the number of its name."""
    method = old_number(name)
    if method != Method.CUSTOM:
        return method
    digest = sha256(name.encode()).digest()
    return int.from_bytes(digest[:4], "big") << NUMBER_BITS | Method.CUSTOM


def old_number(name: str) -> int:
    """Return the number of a search method in old versions: its value in `Method`, `CUSTOM` for all others."""
    known = {method.name.lower(): method for method in Method if method not in NO_SEARCH}
    return int(known.get(name, Method.CUSTOM))


def key_rows(
    seed: int, method: int, run: int, generation: int, indices: Iterable[int] | NDArray[np.integer], rollout: int = 0
) -> Ints:
    """Return (n, 6) int64: one `StreamKey` row for each index."""
    index = np.asarray(indices if isinstance(indices, np.ndarray) else list(indices), dtype=np.int64)
    rows = np.empty((len(index), len(StreamKey._fields)), dtype=np.int64)
    _check(StreamKey(seed, method, run, generation, 0, rollout))
    rows[:] = (seed, method, run, generation, 0, rollout)
    rows[:, StreamKey._fields.index("index")] = index
    check_keys(rows)
    return rows


def single_keys(program: "Program", seed: int | None) -> Iterator[Ints]:
    """Yield the keys that a single run tries in turn, until one allows a scene, (1, 6) each.

    A concrete file has its own key, which is used unless a seed is requested.
    """
    pinned = program.settings.stream
    if pinned is not None and seed is None:
        yield np.array([parse_key(pinned)], dtype=np.int64)
        return
    for index in range(SINGLE_DRAWS if len(program.space) else 1):
        yield key_rows(seed or 0, Method.SINGLE, 0, 0, [index])


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
    """Return a key as text for concrete files: `1.ga.0.12.55.0` (seed, method, run, generation, index, rollout).

    A method that is numbered by its name is `method-` and the eight hexadecimal digits of the name's hash.
    """
    fields = StreamKey(*(int(value) for value in key))
    _check(fields)
    return ".".join([str(fields.seed), _method_text(fields.method), *map(str, fields[2:])])


def format_keys(keys: Ints) -> list[str]:
    """Return the text of each key (n, 6), as `format_key` does."""
    check_keys(keys)
    methods = {method: _method_text(method) for method in set(keys[:, 1].tolist())}
    return [".".join((str(seed), methods[method], *map(str, rest))) for seed, method, *rest in keys.tolist()]


def scene_in_words(key: Iterable[int]) -> str:
    """Return `generation 2, place 31` for a search, `scene 7` for a sample, "" for a single run."""
    fields = StreamKey(*(int(value) for value in key))
    if fields.method == Method.SINGLE:
        return ""
    if fields.method == Method.SAMPLE:
        return f"scene {fields.index}"
    rollout = f", rollout {fields.rollout}" if fields.rollout else ""
    return f"generation {fields.generation}, place {fields.index}{rollout}"


def _method_text(method: int) -> str:
    if method <= max(Method):
        return Method(method).name.lower()
    if method & (1 << NUMBER_BITS) - 1 != Method.CUSTOM:
        raise ValueError(f"method of a random stream is {method}, which is the number of no method")
    return f"{NAMED}{method >> NUMBER_BITS:08x}"


def parse_key(text: str) -> StreamKey:
    """Return the key of a text of `format_key`; raise ValueError for any other text."""
    words = text.strip().split(".")
    if len(words) != len(StreamKey._fields):
        raise ArgumentError(
            f"a stream key has six fields, {'.'.join(StreamKey._fields)}; `{text}` has {len(words)}", "copy a whole one"
        )
    numbers = [
        _method(word) if name == "method" else _number(name, word)
        for name, word in zip(StreamKey._fields, words, strict=True)
    ]
    key = StreamKey(*numbers)
    _check(key)
    return key


def _method(word: str) -> int:
    if match := re.fullmatch(f"{NAMED}([0-9a-f]{{8}})", word):
        return int(match[1], 16) << NUMBER_BITS | Method.CUSTOM
    names = [method.name.lower() for method in Method]
    if word not in names:
        raise ArgumentError(f"`{word}` is not a method of a stream key; valid: {', '.join(names)}", "name one of these")
    return Method[word.upper()]


def _number(name: str, word: str) -> int:
    if not (word.isascii() and word.isdigit()):
        raise ArgumentError(f"{name} of a stream key is a whole number, not `{word}`", "copy a whole key")
    return int(word)


def operator_generator(seed: int, method: int, run: int, generation: int, index: int = 0) -> "Generator":
    """Return a numpy generator for a search's operators, independent of every scene and of every other address.

    The fields fill disjoint bits of Philox4x64's key and of the counter's top word, which counting never reaches.
    """
    from numpy.random import Generator, Philox  # slow, rarely needed

    _check(StreamKey(seed, method, run, generation, index, 0))
    key = [seed, run << 48 | generation << 32 | index]
    counter = [0, 0, 0, method >> NUMBER_BITS << 8 | Purpose.OPERATOR << 4 | method & (1 << NUMBER_BITS) - 1]
    return Generator(Philox(counter=np.array(counter, dtype=np.uint64), key=np.array(key, dtype=np.uint64)))
