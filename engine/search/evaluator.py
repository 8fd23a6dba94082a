"""`Evaluate` with the real simulators: sample a scene for each genome, simulate it, assess its risk; and `Blaming` with
the real reference driver. Simulations of a search can be repeated, to check that the results are the same.

This is the only module of the search that imports sampler, hosts and risk; a host is imported when it is chosen.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from engine.assessment import Evaluate, take, to_arrays
from engine.config import Config
from engine.errors import ArgumentError
from engine.outcomes import MEASURED, Assessment, Outcomes, Result, Retention
from engine.program import Program
from engine.risk import PROFILES, Risk, RiskProfile, assess
from engine.run_count import report_runs
from engine.sampling import sample
from engine.scenes import Scenes
from engine.search.chain import canonical
from engine.search.evaluations import Evaluations
from engine.search.insight.kinds import Blaming
from engine.search.objectives import Objective, Runs, known_objectives, objectives
from engine.search.protocol import DEFAULT_OBJECTIVES
from engine.tables import Bools, Floats, Ints
from engine.verdicts import KnownVerdicts, blame
from engine.vocabulary import STORED, Blame

if TYPE_CHECKING:
    from engine.driving.blocks import Driven

Simulate = Callable[[Scenes], Outcomes]
Simulated = tuple[Scenes, Outcomes]
"""Scenes that were run, and their outcomes."""
BLAMED_AT_ONCE = 1 << 14
"""Collisions whose scenes are in memory at once."""
MOST = 1e9
"""Largest magnitude of an objective; a mean over infinite values is not a number."""


def make_evaluator(
    program: Program,
    config: Config,
    profile: RiskProfile,
    aims: Sequence[Objective] = (),
    verdicts: KnownVerdicts | None = None,
    stored: int = STORED,
) -> Evaluate:
    """Return an evaluator of this program with the host, threads and settings of the config.

    It computes the objectives `aims`; without any, the risk. Verdicts on the way are added to `verdicts`. `stored`: the
    measures of a run that its assessments contain.
    """
    jobs = config.search.jobs
    measures = stored
    for aim in aims:
        measures |= aim.reads
    simulate = _simulator(program, config, measures)

    def evaluate(genomes: Floats, keys: Ints) -> Assessment:
        scenes, outcomes = simulate(sample(program, genomes, keys, config.simulation, jobs))
        risk = assess(outcomes, profile)
        runs = Runs(program, config, scenes, outcomes, risk, verdicts)
        values = [np.where(aim.counts(runs), np.clip(aim.value(runs), -MOST, MOST), np.nan) for aim in aims]
        found = aims[0].finds(runs, values[0]) & aims[0].counts(runs) if aims else None
        sought = np.stack(values, axis=1) if values else np.zeros((len(outcomes), 0))
        return assessment(scenes, outcomes, risk, sought, found)

    return evaluate


def make_blaming(program: Program, config: Config, known: KnownVerdicts | None = None) -> Blaming:
    """Return a function that repeats runs of this program with the reference drivers and returns the `Blame` of each;
    `known`: verdicts that need no run.
    """
    jobs = config.search.jobs

    def blaming(genomes: Floats, keys: Ints) -> Ints:
        said = np.full(len(keys), int(Blame.NONE), dtype=np.int32)
        every = _drivable(config, genomes, keys)
        for first in range(0, len(every), BLAMED_AT_ONCE):
            rows = every[first : first + BLAMED_AT_ONCE]
            scenes = sample(program, genomes[rows], keys[rows], config.simulation, jobs)
            if config.driver is not None:
                from engine.driving.blocks import redriven

                scenes = redriven(program, scenes, config, jobs)
            said[rows] = blame(
                program, scenes, config.simulation, config.contact, jobs, config.search.references, known
            )
        return said

    return blaming


def _drivable(config: Config, genomes: Floats, keys: Ints) -> Ints:
    """Return the rows with scenes that can be driven: all without an external driver."""
    if config.driver is None:
        return np.arange(len(keys))
    from engine.driving.blocks import can_be_driven

    return np.flatnonzero(can_be_driven(config.driver, keys, genomes))


def _simulator(program: Program, config: Config, measures: int) -> Callable[[Scenes], Simulated]:
    """Return the function that simulates scenes with the measures of a run that are read.

    Scenes with an external driver are simulated while they are driven; the world host then simulates them a second
    time.
    """
    simulate, batched = make_host(program, config, measures), config.search.engine == "batch"
    reported = set[str]()

    def run(scenes: Scenes) -> Simulated:
        if config.driver is not None:
            jobs, contact = config.search.jobs, config.contact
            done: Driven = config.driver.drive(program, scenes, config.simulation, contact, jobs, measures)
            done.tell(reported)
            return done.scenes, done.outcomes if batched else simulate(done.scenes)
        outcomes = simulate(scenes)
        report_runs(len(scenes))
        return scenes, outcomes

    return run


def make_host(program: Program, config: Config, measures: int = STORED) -> Simulate:
    """Return the simulator that the config names: `batch`, which computes `measures`, or `world`."""
    jobs = config.search.jobs
    if config.search.engine == "batch":
        from engine import batch

        return lambda scenes: batch.simulate(
            program, scenes, config.simulation, jobs, config.contact, measures=measures
        )
    if config.search.engine == "world":
        from engine import world

        return lambda scenes: world.simulate(program, scenes, config, jobs=jobs)
    raise ArgumentError(f"engine: expected batch or world, got `{config.search.engine}`", "name one of these")


def assessment(
    scenes: Scenes, outcomes: Outcomes, risk: Risk, sought: Floats | None = None, found: Bools | None = None
) -> Assessment:
    """Return sampled, simulated and assessed rows as one table; a result per pair or actor is reduced as its row says.

    `sought` (n, objectives) and `found` (n,) are those of `Assessment`; by default the risk is the objective.
    """
    valid = outcomes.verdict == 0
    distances = np.where(np.isnan(outcomes.min_distance), np.inf, outcomes.min_distance)
    deciding = np.maximum(risk.pair, 0)
    chosen = {
        Retention.NEAREST: np.argmin(distances, axis=1) if distances.shape[1] else deciding,
        Retention.DECIDING: deciding,
    }
    return Assessment(
        verdict=outcomes.verdict,
        variant=scenes.variant,
        attempts=scenes.attempts.astype(np.int32),
        tested=scenes.tested.astype(np.int32),
        failed=scenes.failed.astype(np.int32),
        score=risk.score,
        continuous=np.where(valid, risk.continuous, np.nan),
        parts=risk.parts,
        pair=np.where(valid, risk.pair, -1),
        sought=np.zeros((len(outcomes), 0)) if sought is None else sought,
        broken=outcomes.broken,
        found=outcomes.collided & valid if found is None else found,
        **{row.name: _of_scene(row, getattr(outcomes, row.name), valid, chosen) for row in MEASURED},
    )


def _of_scene(row: Result, values: NDArray[Any], valid: Bools, chosen: Mapping[Retention, Ints]) -> NDArray[Any]:
    """Return (n,) the value of a result that is stored for each scene."""
    if row.retention is Retention.OWN:
        return values & valid if row.kind is bool else values
    if row.retention is Retention.LEAST:
        least = np.where(np.isnan(values), np.inf, values).min(axis=1, initial=np.inf)
        return np.where(np.isinf(least), np.nan, least)
    if row.retention is Retention.EGO:
        return np.where(valid, values[:, 0], row.fill)
    if not values.shape[1]:
        return np.full(len(values), row.fill, row.dtype)
    return np.where(valid, values[np.arange(len(values)), chosen[row.retention]], row.fill).astype(row.dtype)


# -- simulations of a search, run again: does each come to what its journal says, bit for bit? -------------------------


@dataclass(frozen=True)
class Repeated:
    """Simulations that were run again."""

    rows: Ints
    """(n, 2) Individual and rollout of each simulation."""
    same: Bools
    """(n,) True if the repeated simulation has the same result."""
    with_objectives: bool
    """True if the objectives were computed again; a function of a Python program cannot be."""


def repeat(
    program: Program, config: Config, profile: str, objective: Sequence[str], evaluations: Evaluations, rows: Ints
) -> Repeated:
    """Repeat simulations, given by rows (n, 2) of individual and rollout, and compare every stored number."""
    known = tuple(objective) == DEFAULT_OBJECTIVES or set(objective) <= set(known_objectives(program))
    aims = objectives(program, objective) if known else ()
    individual, rollout = rows.T
    before = take(evaluations.rollouts, (individual, rollout))
    if not len(rows):
        return Repeated(rows, np.ones(0, dtype=np.bool_), known)
    evaluate = make_evaluator(program, config, PROFILES[profile], aims)
    after = evaluate(evaluations.genomes[individual], evaluations.keys[individual, rollout])
    same = np.ones(len(rows), dtype=np.bool_)
    pairs = [*zip(to_arrays(before).values(), to_arrays(after).values(), strict=True)]
    names = ("tested", "failed", "broken", *(("sought", "found") if known else ()))
    pairs += [(getattr(before, name), getattr(after, name)) for name in names]
    for old, new in pairs:
        equal = canonical(old).view(np.int64) == canonical(new).view(np.int64)
        same &= equal.reshape(len(rows), -1).all(axis=1)
    return Repeated(rows, same, known)


def sampled(evaluations: Evaluations, count: int, among: Bools) -> Ints:
    """Return (n, 2) individual and rollout of at most `count` distinct simulations, spread evenly `among`."""
    rows = np.argwhere(among & evaluations.simulated[:, np.newaxis])
    chosen = np.unique(np.linspace(0, len(rows) - 1, min(count, len(rows))).round().astype(np.int64))
    return rows[chosen]
