"""The real `Evaluate`: sample a scene for each genome, simulate it, judge its risk.

The one module of the search that knows sampler, hosts and risk; a host is imported when it is chosen.
"""

from collections.abc import Callable

import numpy as np

from engine.config import Config
from engine.errors import ArgumentError
from engine.feasibility import pruner
from engine.program import Program
from engine.risk import Risk, RiskProfile, assess
from engine.sampling import sample
from engine.scenes import Outcomes, Scenes
from engine.search.assessment import Assessment, Evaluate
from engine.tables import Floats, Ints

Simulate = Callable[[Scenes], Outcomes]


def make_evaluator(program: Program, config: Config, profile: RiskProfile) -> Evaluate:
    """An evaluator of this program by the engine, threads and settings of the config."""
    jobs = config.search.jobs
    prune = pruner(program) if config.simulation.prune else None
    simulate = make_host(program, config)

    def evaluate(genomes: Floats, keys: Ints) -> Assessment:
        scenes = sample(program, genomes, keys, config.simulation, jobs, prune)
        outcomes = simulate(scenes)
        return assessment(scenes, outcomes, assess(outcomes, profile))

    return evaluate


def make_host(program: Program, config: Config) -> Simulate:
    """The simulator that the config names: `batch` or `world`."""
    jobs = config.search.jobs
    if config.search.engine == "batch":
        from engine import batch

        return lambda scenes: batch.simulate(program, scenes, config.simulation, jobs=jobs)
    if config.search.engine == "world":
        from engine import world

        return lambda scenes: world.simulate(program, scenes, config, jobs=jobs)
    raise ArgumentError(f"engine: expected batch or world, got `{config.search.engine}`", "name one of these")


def assessment(scenes: Scenes, outcomes: Outcomes, risk: Risk) -> Assessment:
    """Sampled, simulated and judged rows as one table; of several pairs, MS and its kin are the deciding pair's."""
    rows = np.arange(len(outcomes))
    pair = np.maximum(risk.pair, 0)
    valid = outcomes.verdict == 0
    alone = outcomes.min_distance.shape[1] == 0
    distances = np.where(np.isnan(outcomes.min_distance), np.inf, outcomes.min_distance)
    nearest = rows if alone else np.argmin(distances, axis=1)

    def known(values: Floats, column: Ints) -> Floats:
        return np.full(len(rows), np.nan) if alone else np.where(valid, values[rows, column], np.nan)

    return Assessment(
        verdict=outcomes.verdict,
        variant=scenes.variant,
        attempts=scenes.attempts,
        tested=scenes.tested,
        failed=scenes.failed,
        score=risk.score,
        continuous=np.where(valid, risk.continuous, np.nan),
        parts=risk.parts,
        pair=np.where(valid, risk.pair, -1),
        collided=outcomes.collided.astype(bool) & valid,
        end_reason=outcomes.end_reason,
        end_rule=outcomes.end_rule,
        end_time=outcomes.end_time,
        min_distance=known(outcomes.min_distance, nearest),
        min_distance_time=known(outcomes.min_distance_time, nearest),
        max_closing_speed=known(outcomes.max_closing_speed, pair),
        max_closing_time=known(outcomes.max_closing_time, pair),
        distance_at_ms=known(outcomes.distance_at_ms, pair),
        ttc_at_ms=known(outcomes.ttc_at_ms, pair),
        ego_speed=known(outcomes.ego_speed, pair),
        other_speed=known(outcomes.other_speed, pair),
        approach_angle=known(outcomes.approach_angle, pair),
        closing_speed=known(outcomes.closing_speed, pair),
        side=np.full(len(rows), -1, np.int32) if alone else np.where(valid, outcomes.side[rows, pair], -1),
        left_road_time=_earliest(outcomes.left_road_time),
    )


def _earliest(times: Floats) -> Floats:
    """(n,) least of each row, NaN where all are."""
    least = np.where(np.isnan(times), np.inf, times).min(axis=1, initial=np.inf)
    return np.where(np.isinf(least), np.nan, least)
