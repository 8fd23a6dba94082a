"""The batch host: thousands of scenes at once, each up to first contact or its end. No contact physics.

A scene's outcome depends on nothing but the program, the scene and the config: not on the other scenes, their order,
or the number of threads.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields
from itertools import pairwise

import numpy as np

from engine.config import SimulationConfig
from engine.kernels.rollout import advance, begin
from engine.kernels.rows import Requested, Results, simulate_rows
from engine.kernels.stage import Status
from engine.program import Program
from engine.runs import memory, outlines, plan, samples_of
from engine.scenes import Outcomes, Scenes, Trajectory

CHUNK = 1000
"""Scenes that one uninterruptible call may run: some 30 ms, so that Ctrl-C is answered at once."""


def simulate(
    program: Program, scenes: Scenes, config: SimulationConfig = SimulationConfig(), jobs: int = 1
) -> Outcomes:
    """Run all valid scenes; rows of invalid ones keep their verdict and hold NaN / -1."""
    shared = plan(program, config)
    requested = Requested(
        verdict=np.require(scenes.verdict, np.int32, "CAW"),
        variant=np.require(scenes.variant, np.int32, "CAW"),
        values=np.require(scenes.values, np.float64, "CAW"),
        keys=np.require(scenes.keys, np.int64, "CAW"),
    )
    results = _empty_results(len(program.actors), requested)

    def run(chunk: tuple[int, int]) -> None:
        scratch = memory(program, samples_of(config) + 1)
        simulate_rows(shared, requested, *chunk, scratch, np.zeros((len(program.actors), 3)), results)

    chunks = _chunks(len(scenes), jobs)
    if jobs == 1 or len(chunks) < 2:
        for chunk in chunks:
            run(chunk)
    else:
        with ThreadPoolExecutor(jobs) as pool:
            list(pool.map(run, chunks))
    return Outcomes(**{field.name: getattr(results, field.name) for field in fields(Outcomes)})


def trajectory(program: Program, scenes: Scenes, row: int, config: SimulationConfig = SimulationConfig()) -> Trajectory:
    """States of one valid scene over time, up to the end or the last sample before first contact."""
    if not scenes.valid[row]:
        raise ValueError(f"scene {row} is not valid; only a valid one can be run")
    shared, run = plan(program, config), memory(program, samples_of(config) + 1)
    values = np.require(scenes.values[row], np.float64, "CAW")
    begin(shared, run, int(scenes.variant[row]), values, np.require(scenes.keys[row], np.int64, "CAW"))
    advance(shared, run, samples_of(config) + 1, True)
    contact = bool(run.status[Status.CONTACT_ONE] >= 0)
    samples = int(run.status[Status.SAMPLE]) + (0 if contact else 1)
    return Trajectory(
        time=np.arange(samples) * config.time_step,
        states=run.states[:samples].copy(),
        outlines=outlines(program, values),
        contact_sample=samples - 1 if contact else -1,
    )


def _chunks(rows: int, jobs: int) -> list[tuple[int, int]]:
    """Ranges of rows: several a thread, so that threads end at about the same time."""
    size = max(1, min(CHUNK, -(-rows // (4 * jobs))))
    return list(pairwise([*range(0, rows, size), rows]))


def _empty_results(actors: int, scenes: Requested) -> Results:
    rows = len(scenes.verdict)

    def numbers(*shape: int) -> np.ndarray:
        return np.full((rows, *shape), np.nan)

    def integers(*shape: int) -> np.ndarray:
        return np.full((rows, *shape), -1, dtype=np.int32)

    pairs = actors - 1
    return Results(
        verdict=scenes.verdict.copy(),
        collided=np.zeros(rows, dtype=np.bool_),
        end_reason=integers(),
        end_rule=integers(),
        end_time=numbers(),
        steps=integers(),
        min_distance=numbers(pairs),
        min_distance_time=numbers(pairs),
        max_closing_speed=numbers(pairs),
        max_closing_time=numbers(pairs),
        distance_at_ms=numbers(pairs),
        ttc_at_ms=numbers(pairs),
        left_road_time=numbers(actors),
        contact_actors=integers(2),
    )
