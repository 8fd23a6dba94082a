"""Runs with what an objective asks of them beside their results: by how much others missed the ego."""

import math

from engine.kernels.encroachment import encroachment
from engine.kernels.jit import inlined, kernel
from engine.kernels.rows import Requested, Results, measure_run, note_end, note_outlines, run_scene
from engine.kernels.stage import Plan, Run, Status
from engine.kernels.swept import Span, Swept
from engine.tables import Floats
from engine.vocabulary import State, Verdict


@kernel
def gap_rows(
    plan: Plan,
    scenes: Requested,
    first: int,
    last: int,
    run: Run,
    outlines: Floats,
    sweep: Swept,
    out: Results,
    gaps: Floats,
) -> None:
    """Run the valid scenes of rows `first` to `last` (exclusive) as `rows.simulate_rows` does; and PET by area [s] of
    the ego and each other, as `encroachment_gap` has it, into `gaps` (n, others): NaN of two who are never there
    together.
    """
    for row in range(first, last):
        if scenes.verdict[row] == Verdict.VALID:
            run_scene(plan, scenes, row, run)
            if note_end(run, row, out):
                measure_run(plan, run, row, outlines, out)
            note_outlines(plan, run, outlines)
            samples = int(run.status[Status.SAMPLE]) + (0 if run.status[Status.CONTACT_ONE] >= 0 else 1)
            for other in range(1, len(plan.kinds)):
                gaps[row, other - 1] = _gap(run.states[:samples], other, outlines, sweep) * plan.layout.time_step


@inlined
def _gap(states: Floats, other: int, outlines: Floats, sweep: Swept) -> float:
    """PET by area, in samples."""
    ego, them = _span(states, 0), _span(states, other)
    if max(ego.first, them.first) > min(ego.last, them.last):
        return math.nan
    return encroachment(states, ego, them, outlines, sweep)


@inlined
def _span(states: Floats, actor: int) -> Span:
    """From the first sample at which an actor is there to the last one before it is not; of none 0 to -1."""
    first, last = 0, -1
    for k in range(len(states)):
        if states[k, actor, State.PRESENT] != 0.0:
            first = k if last < 0 else first
            last = k
        elif last >= 0:
            break
    return Span(actor, first, last)
