"""Judging runs side by side that have ended: everybody moves again as commanded, and the record is measured.

A lane keeps what everybody was commanded in each step (`lanes.note_commands`). Motion makes the same record of it, bit
for bit, without a look at anybody's behaviour or at contact: how the run ended stands in the lane. That holds for runs
in which nobody but the ego can be struck, and in which commands are all that moves anybody (`Status.UNTOLD`).
"""

import math

from engine.kernels.jit import inlined, shared
from engine.kernels.lanes import PAGE, in_lane, lane_with
from engine.kernels.motion import step
from engine.kernels.rows import Results, measure_run, note_end
from engine.kernels.stage import NO_SPEED, Plan, Run, Slot, Status, place
from engine.tables import Floats, Ints


@shared
def review_lanes(plan: Plan, run: Run, chosen: Ints, actions: Floats, outlines: Floats, out: Results) -> None:
    """Write what became of the runs of the chosen lanes, which have ended, into the rows of their numbers, filled for
    none. `actions` (chosen, turns, numbers) is what was decided in them, `outlines` (actors, 3) working memory.
    """
    for number in range(len(chosen)):
        lane = chosen[number]
        its = in_lane(run, lane)
        if note_end(its, lane, out):
            _move_again(plan, lane_with(run, lane, run.actors, run.status, run.told), lane, actions[number])
            measure_run(plan, its, lane, outlines, out)


@inlined
def _move_again(plan: Plan, run: Run, lane: int, actions: Floats) -> None:
    """Make the record of a lane again: the samples up to its current one."""
    for actor in range(len(plan.kinds)):
        place(plan, run, 0, actor, float(plan.present[actor]))
        run.actors[actor, Slot.LEFT_ROAD] = 0.0  # it is known when, and nobody need look again
        run.actors[actor, Slot.SET_SPEED] = NO_SPEED
    last, pause = int(run.lane_status[lane, Status.SAMPLE]), plan.layout.pause
    for row in range((last + pause - 1) // pause):
        told, first = run.told_pages[run.lane_pages[lane, row // PAGE], row % PAGE], row * pause
        for turn in range(min(pause, last - first)):
            run.status[Status.SAMPLE] = first + turn
            _command(plan, run, told[turn], actions[first + turn])
            step(plan, run)


@inlined
def _command(plan: Plan, run: Run, told: Floats, decided: Floats) -> None:
    """Command everybody what it was commanded in a step."""
    for actor in range(len(plan.kinds)):
        at, slots = int(run.told_at[actor]), run.actors[actor]
        if at < 0:
            number = -1 - at
            slots[Slot.THROTTLE], slots[Slot.BRAKE] = decided[number], decided[number + 1]
            slots[Slot.STEER] = decided[number + 2]
            continue
        pedal = told[at]
        slots[Slot.LEAVING] = 1.0 if math.isnan(pedal) else 0.0
        slots[Slot.THROTTLE], slots[Slot.BRAKE] = max(pedal, 0.0), max(-pedal, 0.0)
        slots[Slot.STEER] = told[at + 1]
