"""By how much others missed the ego: runs driven again, of which nothing but the conflict gap is kept."""

import math

from engine.kernels.encroachment import Span, encroachment_gap, stay
from engine.kernels.jit import inlined, kernel
from engine.kernels.rollout import advance, begin
from engine.kernels.rows import Requested, note_outlines
from engine.kernels.stage import RUNNING, Plan, Run, Status
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
    corners: Floats,
    ways: Floats,
    out: Floats,
) -> None:
    """PET by area [s] of the ego and each other, as `encroachment_gap` has it, into `out` (n, others), of each valid
    scene from row `first` to `last` (exclusive); NaN of two who are never there together.

    `outlines` (actors, 3), `corners` and `ways` (see `stay`) are working memory.
    """
    for row in range(first, last):
        if scenes.verdict[row] == Verdict.VALID:
            begin(plan, run, int(scenes.variant[row]), scenes.values[row], scenes.keys[row], scenes.actions[row])
            note_outlines(plan, run, outlines)
            advance(plan, run, plan.layout.last_sample + 1, run.status[Status.END] == RUNNING)
            samples = int(run.status[Status.SAMPLE]) + (0 if run.status[Status.CONTACT_ONE] >= 0 else 1)
            for other in range(1, len(plan.kinds)):
                out[row, other - 1] = _gap(run.states[:samples], other, outlines, corners, ways) * plan.layout.time_step


@inlined
def _gap(states: Floats, other: int, outlines: Floats, corners: Floats, ways: Floats) -> float:
    """PET by area, in samples."""
    ego, them = _span(states, 0), _span(states, other)
    if max(ego.first, them.first) > min(ego.last, them.last):
        return math.nan
    first = stay(states, ego, them, outlines, corners, ways)
    return encroachment_gap(first, stay(states, them, ego, outlines, corners, ways))


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
