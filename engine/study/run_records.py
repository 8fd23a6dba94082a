"""The stored record of each run of a study: its figures, their course over the generations, and all its evaluations as
one compressed blob (`pack`, `unpack`). The courses of all runs give the curves of a figure over the generations.

    curve = curve_of(study.plan, study.records, 0, "ga", "rl")
    curve.median, curve.band()              # (generations,)
    smoothed(curve.median)                  # as the paper's figures

A blob holds every number in compressed form: it is zlib over the length of a JSON header (uint32), the header (each
array's name, type and shape), and the arrays, little-endian. Each array is stored by byte position, all first bytes,
then all second bytes, as these are similar. The repeated simulation of an elite is not stored again, nor are values
that follow from the rest: places, keys, verdicts of individuals and their fitness.
"""

import json
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from math import prod
from typing import Any

import numpy as np

from engine.assessment import map_arrays, take
from engine.errors import ArgumentError, Signal
from engine.outcomes import Assessment
from engine.search.campaign import Campaign
from engine.search.evaluations import Evaluations, Figures, GenerationFigures, flat_rollouts, judge
from engine.search.insight.diversity import grids
from engine.streams import key_rows
from engine.study.plan import Address, Plan
from engine.tables import Floats, Ints

# -- all evaluations of a run as a blob --------------------------------------------------------------------------------
LEVEL = 1
"""Compression level of zlib: higher levels take several times as long and save a tenth."""
INDIVIDUAL = ("genomes", "births", "operator", "parents", "reused")
"""Fields of `Evaluations` that are stored as they are."""


class DamagedBlock(Signal):
    """A blob is not an output of `pack`."""


def pack(evaluations: Evaluations) -> bytes:
    """Return a whole run as one blob."""
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
    """Return the packed evaluations; the plan supplies the fields of their stream keys and the aggregate.

    Raises:
        DamagedBlock: the blob is truncated, altered, or of another version.
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
    arrays: dict[str, np.ndarray] = {}
    layout: dict[str, tuple[str, list[int]]] = json.loads(data[4:offset])
    for name, (kind, shape) in layout.items():
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
    """Return individuals with their simulations; a reused individual has those of its birth."""
    rollouts, sizes = int(arrays["rollouts"][0]), arrays["generation"]
    first = np.concatenate([[0], np.cumsum(sizes)[:-1]])
    generation = np.repeat(np.arange(len(sizes)), sizes)
    places = np.stack([generation, np.arange(len(generation)) - first[generation]], axis=1).astype(np.int32)
    births, reused = arrays["births"], arrays["reused"]
    born = first[births[:, 0]] + births[:, 1]
    simulation = (np.cumsum(~reused) - 1)[born]
    each = map_arrays(runs, lambda array: array.reshape(len(array) // rollouts, rollouts, *array.shape[1:])[simulation])
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
    """Return (n, k, 6) stream keys."""
    rows = np.repeat(births.astype(np.int64), rollouts, axis=0)
    keys = key_rows(*stream, 0, rows[:, 1])
    keys[:, 3] = rows[:, 0]
    keys[:, 5] = np.tile(np.arange(rollouts), len(births))
    return keys.reshape(len(births), rollouts, keys.shape[1])


# -- records -----------------------------------------------------------------------------------------------------------

LAST = 10
"""Generations at the end that get figures of their own, as in the paper."""
FIELDS = tuple(field.name for field in fields(Figures))
"""Rows of a course."""
OWN = ("distinct_collisions", "kinds", "avoidable", "avoidable_kinds", "failing_cells", "first_collision")
"""Numbers of a run that are no `Figures`."""


@dataclass(frozen=True)
class RunFigures:
    """Figures of one run; a pure function of plan and address."""

    individuals: Figures
    """Figures of the whole run; an elite counts in each generation that contains it, as in the paper."""
    simulations: Figures
    """Figures of the whole run; each distinct simulation counts once."""
    last_individuals: Figures
    """Figures of the last ten generations."""
    last_simulations: Figures
    distinct_collisions: int
    """Different genomes that collided: the yield."""
    kinds: int
    """Number of kinds of its collisions (see `engine.search.insight.kinds`): the variety."""
    avoidable: int
    """Distinct simulations with a collision that a competent driver avoids."""
    avoidable_kinds: int
    """Number of kinds of avoidable collisions."""
    failing_cells: int
    """Cells with a collision, over the descriptor grids that all runs have; grids of sampled lanes are excluded."""
    first_collision: float
    """Distinct simulations up to and including the first collision; NaN without one."""


@dataclass(frozen=True)
class RunRecord:
    """Record of one finished run."""

    address: Address
    figures: RunFigures
    course: Floats
    """(2, fields, generations): `FIELDS` of each generation, by individual and by simulation."""
    seconds: float
    """Duration [s]; the only field that is not reproducible."""


@dataclass(frozen=True)
class Finished:
    """A run that has just ended and is not stored yet."""

    record: RunRecord
    block: bytes
    """All its evaluations, see `engine.study.run_records`."""


def finished(address: Address, campaign: Campaign) -> Finished:
    """Return the record of a campaign that ran to its end."""
    record = RunRecord(address, run_figures(campaign), course(campaign.generations), campaign.elapsed)
    return Finished(record, pack(campaign.evaluations))


def run_figures(campaign: Campaign) -> RunFigures:
    evaluations, came = campaign.evaluations, campaign.failures
    return RunFigures(
        individuals=campaign.by_individual,
        simulations=campaign.by_simulation,
        last_individuals=campaign.last(LAST),
        last_simulations=campaign.last(LAST, by_simulation=True),
        distinct_collisions=campaign.distinct_collisions,
        kinds=came.kinds,
        avoidable=came.avoidable,
        avoidable_kinds=came.avoidable_kinds,
        failing_cells=sum(grid.failing for grid in grids(evaluations)),
        first_collision=first_collision(evaluations),
    )


def first_collision(evaluations: Evaluations) -> float:
    """Return the number of distinct simulations up to the first collision; NaN without one."""
    hits = np.flatnonzero(evaluations.rollouts.collided[evaluations.simulated].ravel())
    return float(hits[0] + 1) if len(hits) else float("nan")


def course(generations: Sequence[GenerationFigures]) -> Floats:
    """Return (2, fields, generations): `FIELDS` of each generation, by individual and by simulation."""
    pairs = [(figures.by_individual, figures.by_simulation) for figures in generations]
    rows = [[[getattr(figures, name) for name in FIELDS] for figures in pair] for pair in pairs]
    return np.array(rows, dtype=np.float64).reshape(len(rows), 2, len(FIELDS)).transpose(1, 2, 0).copy()


def flat(figures: RunFigures) -> dict[str, float]:
    """Return every number by a unique name, such as `nc`, `simulated_nc`, `last_nc` and `last_simulated_nc`."""
    groups = {"": "individuals", "simulated_": "simulations", "last_": "last_individuals"}
    groups["last_simulated_"] = "last_simulations"
    row: dict[str, float] = {name: getattr(figures, name) for name in OWN}
    for prefix, group in groups.items():
        row |= {f"{prefix}{name}": getattr(getattr(figures, group), name) for name in FIELDS}
    return row


def unflat(row: dict[str, Any]) -> RunFigures:
    """Return the figures of a `flat` row; None is NaN."""
    numbers: dict[str, Any] = {name: float("nan") if value is None else value for name, value in row.items()}

    def group(prefix: str) -> Figures:
        return Figures(**{name: numbers[f"{prefix}{name}"] for name in FIELDS})

    return RunFigures(
        individuals=group(""),
        simulations=group("simulated_"),
        last_individuals=group("last_"),
        last_simulations=group("last_simulated_"),
        **{name: numbers[name] for name in OWN},
    )


# -- curves: metrics over the generations, every run, their median and a band ------------------------------------------

WINDOW = 7
"""Values that a parabola of the Savitzky-Golay filter is fitted to; the paper names the filter, not its settings."""


@dataclass(frozen=True)
class Curve:
    """One field of `engine.search.evaluations.Figures` over the generations of all runs of a cell."""

    scenario: str
    method: str
    field: str
    values: Floats
    """(runs, generations), NaN where a generation has no such number."""

    @property
    def median(self) -> Floats:
        """Return (generations,) the median over the runs that have the number; NaN if none has."""
        return self.quantile(0.5)

    def band(self, low: float = 0.25, high: float = 0.75) -> tuple[Floats, Floats]:
        """Return two quantiles over the runs, (generations,) each."""
        return self.quantile(low), self.quantile(high)

    def quantile(self, level: float) -> Floats:
        """Return (generations,) the quantile over the runs; NaN if no run has a number."""
        result = np.full(self.values.shape[1], np.nan)
        known = ~np.isnan(self.values).all(axis=0)
        if known.any():
            result[known] = np.nanquantile(self.values[:, known], level, axis=0)
        return result


def curve_of(
    plan: Plan,
    records: Sequence[RunRecord],
    scenario: int,
    method: str,
    field: str,
    by_simulation: bool = False,
) -> Curve:
    """Return the course of a field in one cell, over its finished runs.

    Raises:
        ValueError: no such field.
    """
    if field not in FIELDS:
        raise ArgumentError(f"field: `{field}` is none of {', '.join(FIELDS)}", "name one of these")
    chosen = [record.course for record in records if record.address[:2] == (scenario, method)]
    generations = plan.subjects[scenario].config.search.generations
    row = FIELDS.index(field)
    values = np.array([course[int(by_simulation), row] for course in chosen], dtype=np.float64)
    return Curve(plan.subjects[scenario].name, method, field, values.reshape(len(chosen), generations))


def smoothed(values: Floats) -> Floats:
    """Return each value replaced by that of a parabola fitted to its neighbours; short courses and gaps stay.

    Savitzky and Golay (1964), "Smoothing and differentiation of data by simplified least squares procedures". The first
    and last values are those of the first and the last parabola.
    """
    if len(values) < WINDOW or np.isnan(values).any():
        return values
    middle = WINDOW // 2
    line = np.arange(WINDOW) - middle
    parabola = 3 * line**2 - middle * (middle + 1)
    bent = np.outer(line, line) / (line**2).sum() + np.outer(parabola, parabola) / (parabola**2).sum()
    weights: Floats = 1.0 / WINDOW + bent
    neighbours = np.arange(len(values) - WINDOW + 1)[:, np.newaxis] + np.arange(WINDOW)
    inside: Floats = (values[neighbours] * weights[middle]).sum(axis=1)
    first: Floats = (weights * values[:WINDOW]).sum(axis=1)
    last: Floats = (weights * values[-WINDOW:]).sum(axis=1)
    return np.concatenate([first[:middle], inside, last[middle + 1 :]])
