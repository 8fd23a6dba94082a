"""A toy world for searches: a landscape with invalid regions, noise from the stream key alone, and no simulator."""

import json
from collections.abc import Callable
from dataclasses import asdict, fields
from typing import Any

import numpy as np
import pytest

from engine.assessment import Evaluate
from engine.config import Config, SearchConfig
from engine.outcomes import MEASURED, Assessment
from engine.program import ParamSpace
from engine.search.evaluations import Evaluations, judge
from engine.search.manifest import Manifest, Parameter
from engine.search.protocol import Box
from engine.tables import Floats, Ints
from engine.vocabulary import Distribution, EndReason, GeneKind, Verdict

REQUIREMENTS = 3


def make_space(
    low: list[float], high: list[float], kinds: list[GeneKind] | None = None, names: list[str] | None = None
) -> ParamSpace:
    """A space of genes with the given ranges; continuous unless `kinds` says otherwise."""
    count = len(low)
    kinds = kinds or [GeneKind.CONTINUOUS] * count
    return ParamSpace(
        names=tuple(names or [f"GENE_{i}" for i in range(count)]),
        units=("m",) * count,
        kinds=np.array(kinds, dtype=np.int32),
        low=np.array(low, dtype=np.float64),
        high=np.array(high, dtype=np.float64),
        distribution=np.full(count, Distribution.UNIFORM, dtype=np.int32),
        shape=np.zeros((count, 2)),
        scale=np.ones(count),
        options=tuple(
            tuple(f"option {i}" for i in range(int(b) + 1)) if kind is GeneKind.INDEX else ()
            for kind, b in zip(kinds, high, strict=True)
        ),
        weights=((),) * count,
    )


def noise(keys: Ints) -> Floats:
    """(n,) numbers in [0, 1) that depend on each key alone."""
    state = np.zeros(len(keys), dtype=np.uint64)
    for column in range(keys.shape[1]):
        state = (state ^ keys[:, column].astype(np.uint64)) * np.uint64(0x9E3779B97F4A7C15)
        state ^= state >> np.uint64(29)
    return (state >> np.uint64(11)).astype(np.float64) * 2.0**-53


def make_evaluate(space: ParamSpace, dead: int = -1, error_above: float = 2.0) -> Evaluate:
    """Risk rises towards the middle of the box in every gene but `dead`; the lowest quarter of gene 0 is invalid."""
    width = np.where(space.high > space.low, space.high - space.low, 1.0)

    def evaluate(genomes: Floats, keys: Ints) -> Assessment:
        unit = (genomes - space.low) / width
        live = [gene for gene in range(len(space)) if gene != dead]
        chance = noise(keys)
        distance = np.abs(unit[:, live] - 0.5).mean(axis=1) * 9.0 + 0.5 * chance if live else chance
        verdict = np.where(unit[:, 0] < 0.25, int(Verdict.EXHAUSTED), 0) if len(space) else np.zeros(len(keys), int)
        verdict = np.where(chance > error_above, int(Verdict.ERROR), verdict).astype(np.int32)
        return assessed(verdict, distance)

    return evaluate


def assessed(verdict: Ints, distance: Floats) -> Assessment:
    """Rows with these verdicts and, where valid, these least distances; below 1 m is a collision."""
    valid = verdict == Verdict.VALID
    collided = valid & (distance < 1.0)
    md = np.where(valid, np.where(collided, 0.0, distance), np.nan)
    band = np.where(valid, np.clip(4 - np.nan_to_num(distance), 0, 4).astype(np.int32), 0)
    parts = np.stack([10 * collided, band, band, band], axis=1).astype(np.int32)
    count = len(verdict)
    failed = np.where(valid, 1, 2000)[:, np.newaxis] * np.arange(REQUIREMENTS)
    blank = {row.name: np.full(count, row.fill, row.dtype) for row in MEASURED}
    known = {
        "verdict": verdict,
        "variant": np.where(valid, 0, -1).astype(np.int32),
        "attempts": np.where(valid, 7, 2000).astype(np.int64),
        "tested": failed + 1,
        "failed": failed,
        "score": np.where(valid, parts.sum(axis=1), -1).astype(np.int32),
        "continuous": np.where(valid, 10.0 * collided + np.clip(12.0 - distance, 0.0, 12.0), np.nan),
        "parts": parts,
        "pair": np.where(valid, 0, -1).astype(np.int32),
        "collided": collided,
        "end_reason": np.where(valid, np.where(collided, EndReason.COLLISION, EndReason.TIMEOUT), -1).astype(np.int32),
        "end_rule": np.full(count, -1, dtype=np.int32),
        "end_time": np.where(valid, 3.0 + distance, np.nan),
        "min_distance": md,
        "min_distance_time": md + 1.0,
        "max_closing_speed": md + 2.0,
        "max_closing_time": md + 3.0,
        "distance_at_ms": md + 4.0,
        "ttc_at_ms": md + 5.0,
        "ego_speed": md + 6.0,
        "other_speed": md + 7.0,
        "approach_angle": np.where(valid, 1.0, np.nan),
        "closing_speed": md + 8.0,
        "side": np.where(valid, 0, -1).astype(np.int32),
        "left_road_time": np.full(count, np.nan),
    }
    made = blank | known
    made["sought"] = made["broken"] = np.zeros((*np.shape(made["collided"]), 0))
    return Assessment(**{"found": made["collided"], **made})


def evaluated(genomes: Floats, rollouts: Assessment) -> Evaluations:
    """One generation of individuals, each simulated; rollouts of shape (individuals, rollouts)."""
    count = len(genomes)
    verdict, fitness = judge(rollouts, "mean")
    places = np.stack([np.zeros(count), np.arange(count)], axis=1).astype(np.int32)
    return Evaluations(
        genomes=np.asarray(genomes, dtype=float),
        places=places,
        births=places,
        operator=np.zeros(count, dtype=np.int32),
        parents=np.full((count, 2, 2), -1, dtype=np.int32),
        reused=np.zeros(count, dtype=bool),
        verdict=verdict,
        fitness=fitness,
        keys=np.zeros((*rollouts.verdict.shape, 6), dtype=np.int64),
        rollouts=rollouts,
    )


def assert_equal(first: Any, second: Any) -> None:
    """Two tables hold the same numbers, NaN equal to NaN."""
    for field in fields(first):
        a, b = getattr(first, field.name), getattr(second, field.name)
        if isinstance(a, np.ndarray):
            np.testing.assert_array_equal(a, b, err_msg=field.name)
        else:
            assert_equal(a, b)


def make_manifest(space: ParamSpace, config: SearchConfig, method: str = "ga") -> Manifest:
    """Of a toy search."""
    rows = zip(space.names, space.units, space.kinds.tolist(), space.low.tolist(), space.high.tolist(), strict=True)
    return Manifest(
        name="toy",
        file="toy.scn",
        file_text='"""A toy."""\n',
        file_digest="0" * 64,
        program_digest="1" * 64,
        method=method,
        preset="cortex" if method == "ga" else "",
        profile="paper",
        seed=config.seed,
        run=config.run,
        settings=json.loads(json.dumps(asdict(Config(search=config)))),
        versions={"cortexc": "0.1.0"},
        platform="any",
        command_line=("toy.scn", "--ga"),
        parameters=tuple(Parameter(*row, options) for row, options in zip(rows, space.options, strict=True)),
        requirements=("first, of all", 'the "second"', "third"),
        rules=("time",),
        actors=("ego", "adversary"),
    )


@pytest.fixture
def space() -> ParamSpace:
    """Five continuous genes, an integer and an index gene."""
    kinds = [GeneKind.CONTINUOUS] * 5 + [GeneKind.INTEGER, GeneKind.INDEX]
    return make_space([5, 5, 0, 5, -1, 2, 0], [58, 80, 1, 58, 1, 9, 3], kinds)


@pytest.fixture
def box(space: ParamSpace) -> Box:
    return Box.of(space)


@pytest.fixture
def spaces() -> Callable[..., ParamSpace]:
    """`make_space`."""
    return make_space


@pytest.fixture
def evaluators() -> Callable[..., Evaluate]:
    """`make_evaluate`."""
    return make_evaluate


@pytest.fixture
def rows() -> Callable[[Ints, Floats], Assessment]:
    """`assessed`."""
    return assessed


@pytest.fixture
def manifests() -> Callable[..., Manifest]:
    """`make_manifest`."""
    return make_manifest
