"""Fair starts: the additional condition of `simulation(fair=True)`.

A start is fair if the reference driver of `engine.avoidability`, here without perception and reaction times, avoids
every collision by braking at once along the ego's path (`engine.kernels.fairness`). Sampling redraws an unfair start;
the evaluation of requirements counts unfair starts.
"""

from collections.abc import Callable

import numpy as np

from engine.avoidability import R157, drive_memory
from engine.config import SimulationConfig
from engine.host import in_parts, plan
from engine.kernels.fairness import fair_rows
from engine.kernels.recipe import Ledger
from engine.kernels.rows import Requested, Window
from engine.program import Program
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import Verdict

MOST = 50
"""Maximum number of starts of a genome that are simulated until one is fair."""


def fair_starts(program: Program, starts: Requested, config: SimulationConfig, jobs: int = 1) -> Bools:
    """Return (n,) True for valid and fair starts."""
    shared, said = plan(program, config), np.zeros(len(starts.verdict), dtype=np.int32)

    def drive(window: Window) -> None:
        fair_rows(shared, starts, window, drive_memory(program, config, 2), R157, said)

    in_parts(len(said), jobs, drive)
    return said != 0


def undecided(verdict: Ints, variant: Ints, values: Floats, keys: Ints) -> Requested:
    """Return starts without decisions of controllers."""
    return Requested(verdict, variant.astype(np.int64), values, keys, np.zeros((len(verdict), 0, 0)))


def draw_until_fair(
    program: Program,
    config: SimulationConfig,
    keys: Ints,
    ledger: Ledger,
    draw_on: Callable[[Ints], None],
    jobs: int = 1,
) -> None:
    """Drive the scenes of a ledger, and draw again where the start is not fair: `draw_on` makes attempts at rows.

    An attempt that comes to the scene before it, as all do of a file that draws nothing, is as unfair, and not driven.
    """
    rows = np.flatnonzero(ledger.verdict == Verdict.VALID)
    fair = np.ones(len(rows), dtype=bool)
    for driven in range(1, MOST + 1):
        if not len(rows):
            return
        fair[fair] = _are_fair(program, config, keys, ledger, rows[fair], jobs)
        ledger.tested[rows, -1] += 1
        rows = rows[~fair]
        ledger.failed[rows, -1] += 1
        if driven < MOST:
            variant, values = ledger.variant[rows], ledger.values[rows]
            draw_on(rows)
            other = (ledger.variant[rows] != variant) | (ledger.values[rows] != values).any(axis=1)
            valid = ledger.verdict[rows] == Verdict.VALID
            rows, fair = rows[valid], other[valid]
    ledger.verdict[rows], ledger.variant[rows] = Verdict.EXHAUSTED, -1
    ledger.values[rows], ledger.draws[rows] = np.nan, np.nan


def _are_fair(program: Program, config: SimulationConfig, keys: Ints, ledger: Ledger, rows: Ints, jobs: int) -> Bools:
    if not len(rows):
        return np.zeros(0, dtype=bool)
    starts = undecided(ledger.verdict[rows], ledger.variant[rows], ledger.values[rows], keys[rows])
    return fair_starts(program, starts, config, jobs)
