"""The batch host: thousands of scenes at once, each up to the ego's first contact or its end.

A scene's outcome depends only on the program, the scene and the config: not on the other scenes, their order, or the
number of threads.
"""

from collections.abc import Sequence

import numpy as np

from engine.config import ContactConfig, SimulationConfig
from engine.errors import ArgumentError
from engine.host import empty_results, heights_of, in_parts, memory, outcomes, outlines, plan, requested, samples_of
from engine.kernels.rollout import advance, begin
from engine.kernels.rows import Gaps, Window, gap_rows, judge_rows, simulate_rows
from engine.kernels.run_state import Status
from engine.kernels.swept import swept
from engine.outcomes import Outcomes
from engine.program import Program
from engine.scenes import Scenes, Trajectory
from engine.tables import Floats

DEFAULTS = SimulationConfig()
CONTACT = ContactConfig()


def simulate(
    program: Program,
    scenes: Scenes,
    config: SimulationConfig = DEFAULTS,
    jobs: int = 1,
    contact: ContactConfig = CONTACT,
    hold: int = 1,
    slides: Sequence[int] = (),
) -> Outcomes:
    """Run all valid scenes and return their outcomes; rows of invalid scenes have their verdict and NaN / -1.

    `hold` and `slides` are those of `engine.host.plan`: they repeat a run with finer motion, or with slipping tyres.
    """
    shared, rows = plan(program, config, contact, hold, slides), requested(program, scenes)
    results = empty_results(program, rows)
    run_rows = judge_rows if len(program.judged) else simulate_rows

    def run(window: Window) -> None:
        scratch = memory(program, shared.layout.last_sample + 1)
        run_rows(shared, rows, window, scratch, np.zeros((len(program.actors), 3)), results)

    in_parts(len(scenes), jobs, run)
    return outcomes(results)


def simulate_with_gaps(
    program: Program,
    scenes: Scenes,
    config: SimulationConfig = DEFAULTS,
    jobs: int = 1,
    contact: ContactConfig = CONTACT,
) -> tuple[Outcomes, Floats]:
    """Run all valid scenes as `simulate` does, and return (n, pairs) PET by area [s] of the ego and each actor, too.

    NaN if there is none (`engine.kernels.encroachment`), and for invalid scenes.
    """
    shared, rows = plan(program, config, contact), requested(program, scenes)
    results = empty_results(program, rows)
    gaps = np.full((len(scenes), len(program.actors) - 1), np.nan)

    def run(window: Window) -> None:
        samples = shared.layout.last_sample + 1
        scratch, sizes = memory(program, samples), np.zeros((len(program.actors), 3))
        gap_rows(shared, rows, window, scratch, sizes, Gaps(swept(samples + 1), gaps), results)

    in_parts(len(scenes), jobs, run)
    if len(program.judged):
        return simulate(program, scenes, config, jobs, contact), gaps
    return outcomes(results), gaps


def trajectory(
    program: Program,
    scenes: Scenes,
    row: int,
    config: SimulationConfig = DEFAULTS,
    contact: ContactConfig = CONTACT,
) -> Trajectory:
    """Return the states of one valid scene over time, up to the end or the last sample before the ego touches."""
    if not scenes.valid[row]:
        raise ArgumentError(f"scene {row} is not valid; only a valid one can be run", "`scenes.valid` says which are")
    shared, run = plan(program, config, contact), memory(program, samples_of(config) + 1)
    rows = requested(program, scenes)
    begin(shared, run, int(rows.variant[row]), rows.values[row], rows.keys[row], rows.actions[row])
    advance(shared, run, samples_of(config) + 1, True)
    touched = bool(run.status[Status.CONTACT_ONE] >= 0)
    samples = int(run.status[Status.SAMPLE]) + (0 if touched else 1)
    return Trajectory(
        time=np.arange(samples, dtype=np.float64) * config.time_step,
        states=run.states[:samples].copy(),
        outlines=outlines(program, rows.values[row]),
        contact_sample=samples - 1 if touched else -1,
        watched=run.watched[:samples].copy(),
        heights=heights_of(shared.road, run.states[:samples]),
    )
