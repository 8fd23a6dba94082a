"""All evaluations of one run as one compressed blob: every number, and less room than the numbers themselves need.

A blob is zlib over: the length of a JSON header (uint32), the header (each array's name, type and shape), the arrays,
little-endian. Each array lies there byte by byte, all first bytes, then all second ones, as those are alike. An elite's
repeated simulation is not stored again, and nothing that can be computed from the rest is: places, keys, verdicts of
individuals and their fitness.
"""

import json
import zlib
from collections.abc import Iterator
from dataclasses import fields
from math import prod

import numpy as np

from engine.errors import Signal
from engine.search.assessment import Assessment, map_arrays, take
from engine.search.evaluations import Evaluations, flat_rollouts, judge
from engine.streams import key_rows
from engine.tables import Ints

LEVEL = 1
"""Of zlib: higher ones take several times as long and save a tenth."""
INDIVIDUAL = ("genomes", "births", "operator", "parents", "reused")
"""Fields of `Evaluations` that are stored as they are."""


class DamagedBlock(Signal):
    """A blob is not what `pack` made."""


def pack(evaluations: Evaluations) -> bytes:
    """A whole run as one blob."""
    arrays = dict(_arrays(evaluations))
    header = {name: [array.dtype.newbyteorder("<").str, array.shape] for name, array in arrays.items()}
    text = json.dumps(header).encode()
    parts = [np.uint32(len(text)).astype("<u4").tobytes(), text, *map(_bytes, arrays.values())]
    return zlib.compress(b"".join(parts), LEVEL)


def _arrays(evaluations: Evaluations) -> Iterator[tuple[str, np.ndarray]]:
    yield "generation", np.bincount(evaluations.places[:, 0]).astype(np.int32)
    yield "rollouts", np.array([evaluations.rollouts.verdict.shape[1]], dtype=np.int32)
    for name in INDIVIDUAL:
        yield name, getattr(evaluations, name)
    runs = flat_rollouts(take(evaluations, evaluations.simulated))
    for field in fields(Assessment):
        yield f"run.{field.name}", getattr(runs, field.name)


def _bytes(array: np.ndarray) -> bytes:
    flat = np.ascontiguousarray(array.astype(array.dtype.newbyteorder("<")))
    return flat.reshape(-1).view(np.uint8).reshape(flat.size, flat.itemsize).T.tobytes()


def unpack(blob: bytes, seed: int, method: int, run: int, aggregate: str) -> Evaluations:
    """Exactly what was packed; the fields of its stream keys and the aggregate are known from the plan.

    Raises:
        DamagedBlock: the blob is cut off, altered, or of another version.
    """
    try:
        arrays = _read(blob)
        runs = Assessment(**{field.name: arrays[f"run.{field.name}"] for field in fields(Assessment)})
        return _evaluations(arrays, runs, (seed, method, run), aggregate)
    except (zlib.error, ValueError, KeyError, IndexError, TypeError) as error:
        raise DamagedBlock(f"{type(error).__name__}: {error}") from error


def _read(blob: bytes) -> dict[str, np.ndarray]:
    data = zlib.decompress(blob)
    length = int(np.frombuffer(data, "<u4", 1)[0])
    offset = 4 + length
    arrays = {}
    for name, (kind, shape) in json.loads(data[4:offset]).items():
        dtype = np.dtype(kind)
        count = prod(shape)
        raw = np.frombuffer(data, np.uint8, count * dtype.itemsize, offset).reshape(dtype.itemsize, count)
        arrays[name] = (
            np.ascontiguousarray(raw.T).reshape(-1).view(dtype).reshape(shape).astype(dtype.newbyteorder("="))
        )
        offset += count * dtype.itemsize
    return arrays


def _evaluations(
    arrays: dict[str, np.ndarray], runs: Assessment, stream: tuple[int, int, int], aggregate: str
) -> Evaluations:
    """Individuals with their simulations: a reused one has those of its birth."""
    rollouts, sizes = int(arrays["rollouts"][0]), arrays["generation"]
    first = np.concatenate([[0], np.cumsum(sizes)[:-1]])
    generation = np.repeat(np.arange(len(sizes)), sizes)
    places = np.stack([generation, np.arange(len(generation)) - first[generation]], axis=1).astype(np.int32)
    births, reused = arrays["births"], arrays["reused"]
    born = first[births[:, 0]] + births[:, 1]
    simulation = (np.cumsum(~reused) - 1)[born]
    each = map_arrays(runs, lambda array: array.reshape(-1, rollouts, *array.shape[1:])[simulation])
    verdict, fitness = judge(each, aggregate)
    return Evaluations(
        **{name: arrays[name] for name in INDIVIDUAL},
        places=places,
        verdict=verdict,
        fitness=fitness,
        keys=_keys(births, rollouts, stream),
        rollouts=each,
    )


def _keys(births: Ints, rollouts: int, stream: tuple[int, int, int]) -> Ints:
    """(n, k, 6) stream keys."""
    rows = np.repeat(births.astype(np.int64), rollouts, axis=0)
    keys = key_rows(*stream, 0, rows[:, 1])
    keys[:, 3] = rows[:, 0]
    keys[:, 5] = np.tile(np.arange(rollouts), len(births))
    return keys.reshape(len(births), rollouts, keys.shape[1])
