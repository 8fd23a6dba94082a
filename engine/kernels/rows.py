"""Many runs, one after another: from rows of scenes to rows of results, by the table in `engine.outcomes`."""

import math
from collections import namedtuple
from typing import TYPE_CHECKING, Any, NamedTuple

from engine.handles import handle
from engine.kernels.encroachment import encroachment
from engine.kernels.fault import fault_of
from engine.kernels.jit import deferred, inlined, kernel, shared
from engine.kernels.judging import judge
from engine.kernels.levels import has_levels, measure_on_levels, restore_levels
from engine.kernels.noticing import note_sightings
from engine.kernels.pair import PLACES, ROWS, measure_pair
from engine.kernels.rollout import advance, begin
from engine.kernels.run_state import Memory, Plan, Run, Status, column_of, vehicle_of
from engine.kernels.slots import EMPTY, suspend_run
from engine.kernels.swept import Span
from engine.outcomes import OUTCOMES, PAIRS, Per
from engine.tables import SLIDING, Floats, Ints
from engine.vocabulary import ActorKind, Column, EndReason, Measure, State, Verdict

FAULT = ROWS.index("fault")
"""Column of the fault in a pair's row."""
FILLS = tuple(float(row.fill) for row in PAIRS)
"""Value of each number of a pair in an invalid run."""


@handle
class Requested(NamedTuple):
    """The scenes to run; arrays of `engine.scenes.Scenes`."""

    verdict: Ints
    variant: Ints
    values: Floats
    keys: Ints
    actions: Floats
    """(n, turns, numbers)"""


class Window(NamedTuple):
    """Rows `first` to `last` (exclusive) of the scenes."""

    first: int
    last: int


if TYPE_CHECKING:

    class Results(Any):
        """The arrays of `engine.outcomes.Outcomes` under the same names, with the values of a run without a result.

        Those of pairs are one array (n, pairs, len(PAIRS)), in the order of `PAIRS`, those of objectives two; `gaps` is
        (n, pairs), or (n, 0) where gaps are not measured.
        """

else:
    Results = handle(
        namedtuple(
            "Results", [*(row.name for row in OUTCOMES if row.per is not Per.PAIR), "pairs", "gaps", "sought", "broken"]
        )
    )


# -- runs --------------------------------------------------------------------------------------------------------------


@kernel
def simulate_rows(plan: Plan, scenes: Requested, window: Window, run: Run, outlines: Floats, out: Results) -> None:
    """Run the valid scenes of a window to their ends, each in the memory of `run`.

    `outlines` (actors, 3) is working memory.
    """
    for row in range(window.first, window.last):
        if scenes.verdict[row] == Verdict.VALID:
            run_scene(plan, scenes, row, run)
            note_results(plan, run, row, outlines, out)


@kernel
def run_scene(plan: Plan, scenes: Requested, row: int, run: Run) -> None:
    """Run the scene of a row to its end."""
    begin(plan, run, int(scenes.variant[row]), scenes.values[row], scenes.keys[row], scenes.actions[row])
    # Numbers of the types that hosts pass from Python, and no literal truth: numba would compile it twice.
    advance(plan, run, plan.layout.last_sample + 1, row >= 0)


@shared
def start_slots(plan: Plan, scenes: Requested, chosen: Ints, run: Run) -> None:
    """Set up the scenes of the rows `chosen` in the slots of the same numbers."""
    for slot in chosen:
        run.slot_status[slot, Status.END] = EMPTY
        if scenes.verdict[slot] == Verdict.VALID:
            its = run.slots[slot]
            begin(plan, its, int(scenes.variant[slot]), scenes.values[slot], scenes.keys[slot], scenes.actions[slot])
            suspend_run(its, slot, 0)


# -- the end of a run, and what it comes to ----------------------------------------------------------------------------


@inlined
def note_results(plan: Plan, run: Run, row: int, outlines: Floats, out: Results) -> None:
    """Write the results of a run that has ended into its row."""
    if note_end(run, row, out):
        measure_run(plan, run, row, outlines, out)
        if plan.layout.judged != 0:
            note_objectives(plan, run, row, outlines, out)


@inlined
def note_end(run: Run, row: int, out: Results) -> bool:
    """Write the end of the scored run into its row; return True if it is valid, so that it may be measured.

    Two others may have touched after that end, in the ego's last step or before a temporal rule was judged.
    """
    reason = run.status[Status.END]
    if reason == EndReason.BROKEN or reason == EndReason.STUCK:
        out.verdict[row] = Verdict.ERROR
    elif reason == EndReason.ABORTED:
        out.verdict[row] = Verdict.ABORTED
    out.end_reason[row] = reason
    out.end_rule[row] = run.status[Status.DETAIL]
    out.end_time[row] = run.end[0]
    out.steps[row] = run.status[Status.SAMPLE]
    out.collided[row] = reason == EndReason.COLLISION
    out.contact_actors[row, 0] = run.status[Status.CONTACT_ONE]
    out.contact_actors[row, 1] = run.status[Status.CONTACT_OTHER]
    if run.end[2] <= run.end[0]:
        out.others_contact_time[row] = run.end[2]
        out.others_contact_actors[row, 0] = run.status[Status.OTHERS_ONE]
        out.others_contact_actors[row, 1] = run.status[Status.OTHERS_OTHER]
    for actor in range(len(run.actors)):
        out.left_road_time[row, actor] = run.actors[actor, Memory.LEFT_ROAD]
    return out.verdict[row] == Verdict.VALID


@deferred()
def note_objectives(plan: Plan, run: Run, row: int, outlines: Floats, out: Results) -> None:
    """Write the objectives of a measured run into its row; a run with a NaN among them is broken."""
    undefined = judge(plan, run, out.pairs[row], outlines, out.sought[row], out.broken[row])
    if undefined < 0:
        return
    out.verdict[row], out.end_reason[row], out.end_rule[row] = Verdict.ERROR, EndReason.BROKEN, undefined
    out.collided[row] = False
    out.contact_actors[row, :] = -1
    for pair in range(out.pairs.shape[1]):
        for number in range(len(FILLS)):
            out.pairs[row, pair, number] = FILLS[number]
    out.lateral_grip[row, :] = out.combined_grip[row, :] = math.nan
    out.sought[row, :] = out.broken[row, :] = math.nan


@inlined
def note_outlines(plan: Plan, run: Run, outlines: Floats) -> None:
    """Fill `outlines` (actors, 3) with length, width, rear axle to centre [m], which every measure of a run reads."""
    for actor in range(len(plan.kinds)):
        outlines[actor, 0] = column_of(plan, run, actor, Column.LENGTH)
        outlines[actor, 1] = column_of(plan, run, actor, Column.WIDTH)
        outlines[actor, 2] = column_of(plan, run, actor, Column.REAR_TO_CENTER)


@shared
def measure_run(plan: Plan, run: Run, row: int, outlines: Floats, out: Results) -> None:
    """Write the metrics of each pair (ego, other) over the samples up to contact or the end into the run's row."""
    note_outlines(plan, run, outlines)
    touching = run.status[Status.CONTACT_OTHER]
    ending, time_step = run.end[1], plan.layout.time_step
    samples = run.status[Status.SAMPLE] + (0 if ending > 0.0 else 1)
    rows = int(run.status[Status.SAMPLE]) + 1
    if has_levels(plan):
        measure_on_levels(plan, run, rows)
    for other in range(1, len(plan.kinds)):
        metrics = measure_pair(run.states, samples, time_step, other, outlines, touching == other, ending)
        for number in range(len(metrics)):
            out.pairs[row, other - 1, PLACES[number]] = metrics[number]
        if touching == other and plan.layout.measures & Measure.FAULT != 0:
            places = plan.layout.intersections
            fault = fault_of(run.states, samples - 1, time_step, other, outlines, metrics, plan.road, places)
            out.pairs[row, other - 1, FAULT] = float(fault)
    if plan.layout.measures & Measure.SIGHT != 0:
        note_sightings(plan, run, samples, ending, outlines, out.pairs[row])
    if plan.layout.measures & Measure.GAPS != 0:
        note_gaps(plan, run, samples, outlines, out.gaps[row])
    if has_levels(plan):
        restore_levels(plan, run, rows)
    for actor in range(len(plan.kinds) if plan.layout.measures & Measure.GRIP != 0 else 0):
        if plan.kinds[actor] != ActorKind.PEDESTRIAN and plan.kinds[actor] != ActorKind.OBSTACLE:
            grip = vehicle_of(plan, run, actor).grip
            used = grip_used(run.states, run.status[Status.SAMPLE], time_step, actor, grip)
            out.lateral_grip[row, actor] = used.sideways
            out.combined_grip[row, actor] = used.together
    run.status[Status.SHADED] = -1


# -- conflict gaps -----------------------------------------------------------------------------------------------------


@deferred()
def note_gaps(plan: Plan, run: Run, samples: int, outlines: Floats, gaps: Floats) -> None:
    """Write PET by area [s] of the ego and each other actor, as by `encroachment`; NaN for an actor that is never
    present with the ego.
    """
    states = run.states[:samples]
    ego = _span(states, 0)
    for other in range(1, len(plan.kinds)):
        them = _span(states, other)
        if max(ego.first, them.first) <= min(ego.last, them.last):
            gaps[other - 1] = encroachment(states, ego, them, outlines, run.swept) * plan.layout.time_step


@inlined
def _span(states: Floats, actor: int) -> Span:
    """Return the span from the first sample at which an actor is present to the last before a gap; 0 to -1 if never."""
    first, last = 0, -1
    for k in range(len(states)):
        if states[k, actor, State.PRESENT] != 0.0:
            first = k if last < 0 else first
            last = k
        elif last >= 0:
            break
    return Span(actor, first, last)


# -- grip --------------------------------------------------------------------------------------------------------------


class Used(NamedTuple):
    """The largest uses of grip in a run, as shares."""

    sideways: float
    together: float


@inlined
def grip_used(states: Floats, last: int, time_step: float, actor: int, grip: float) -> Used:
    """Return the largest use of grip by an actor, as a share of mu g: sideways, and in both directions together.

        sideways   v_m |psi'| / (mu g)          together   sqrt(a^2 + (v_m psi')^2) / (mu g)

    over each step up to sample `last`, with a its acceleration, psi' its yaw rate and v_m the speed at its middle.
    Steps in which the actor slides after an impact are left out. Above `MODEL_RANGE` the kinematic bicycle is not a
    valid model of a car: see `engine.outcomes`. `grip` is mu g [m/s^2]. 0 for an actor without a step.
    """
    # Without friction no grip is used: there is no acceleration either.
    grip = max(grip, 1e-9)
    sideways, together = 0.0, 0.0
    for k in range(last):
        before, after = states[k, actor, State.PRESENT], states[k + 1, actor, State.PRESENT]
        if before == 0.0 or after == 0.0 or after == SLIDING:
            continue
        along = states[k + 1, actor, State.ACCELERATION]
        speed = states[k + 1, actor, State.SPEED] - 0.5 * time_step * along
        across = speed * (states[k + 1, actor, State.HEADING] - states[k, actor, State.HEADING]) / time_step
        sideways = max(sideways, across * across)
        together = max(together, along * along + across * across)
    return Used(math.sqrt(sideways) / grip, math.sqrt(together) / grip)
