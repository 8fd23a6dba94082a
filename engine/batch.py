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
from engine.kernels.rows import Window, simulate_rows
from engine.kernels.run_state import Status
from engine.outcomes import Outcomes
from engine.program import Program
from engine.scenes import Scenes, Trajectory
from engine.vocabulary import STORED

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
    measures: int = STORED,
) -> Outcomes:
    """Run all valid scenes and return their outcomes; rows of invalid scenes have their verdict and NaN / -1.

    `hold` and `slides` are those of `engine.host.plan`: they repeat a run with finer motion, or with slipping tyres.
    Results of a `Measure` that is not among `measures` have the values of an invalid scene.
    """
    shared = plan(program, config, contact, hold, slides, measures=measures)
    rows = requested(program, scenes)
    results = empty_results(program, rows, measures)

    def run(window: Window) -> None:
        scratch = memory(program, shared.layout.last_sample + 1, measures)
        simulate_rows(shared, rows, window, scratch, np.zeros((len(program.actors), 3)), results)

    in_parts(len(scenes), jobs, run)
    return outcomes(results)


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
        heights=heights_of(shared.road, shared.kinds, run.states[:samples]),
    )
