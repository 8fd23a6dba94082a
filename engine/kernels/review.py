"""Assessment of parallel runs that have ended, on their record.

How a run ended is stored in its slot. In runs in which only the ego can be struck, the commands of each step are stored
(`slots.note_commands`). If nothing but commands moves an actor (`Status.UNTOLD`), motion reproduces the record from
them, bit for bit, without behaviors and without a search for contact. In all other runs the states are stored.
"""

import math

from engine.kernels.jit import inlined, shared
from engine.kernels.motion import step
from engine.kernels.rows import Results, measure_run, note_end
from engine.kernels.run_state import NO_SPEED, Memory, Plan, Run, Status, place
from engine.kernels.slots import PAGE
from engine.tables import Floats, Ints


@shared
def review_slots(plan: Plan, run: Run, chosen: Ints, actions: Floats, outlines: Floats, out: Results) -> None:
    """Write the results of the runs of the chosen slots, which have ended, into the rows of the same numbers.

    `actions` (chosen, turns, numbers) are the decisions made in the slots, `outlines` (actors, 3) is working memory.
    The rows of `out` hold the values of a run without a result.
    """
    for number in range(len(chosen)):
        slot = chosen[number]
        its = run.slots[slot]
        if note_end(its, slot, out):
            if len(run.command_columns) == 0:
                _read_states(plan, run, slot, int(its.status[Status.SAMPLE]))
            else:
                _repeat_motion(plan, run, its, slot, actions[number])
            its.status[Status.SHADED] = -1  # the outlines that hide are those of another slot
            measure_run(plan, its, slot, outlines, out)


@inlined
def _read_states(plan: Plan, run: Run, slot: int, last: int) -> None:
    """Write the record of a slot from its stored states: the samples up to `last`, its current one."""
    states, pause = run.states, plan.layout.pause
    for sample in range(last + 1):
        row = sample // pause
        for actor in range(states.shape[1]):
            for column in range(states.shape[2]):
                if sample == last:
                    state = run.slot_states[slot, last & (run.slot_states.shape[1] - 1), actor, column]
                else:
                    page, place = run.slot_pages[slot, row // PAGE], actor * states.shape[2] + column
                    state = run.command_pages[page, row % PAGE, sample % pause, place]
                states[sample, actor, column] = state


@inlined
def _repeat_motion(plan: Plan, run: Run, its: Run, slot: int, actions: Floats) -> None:
    """Write the record of a slot: the samples up to its current one. The state of its actors is restored."""
    _copy(its.actors, run.actors)
    for actor in range(len(plan.kinds)):
        place(plan, its, 0, actor, float(plan.present[actor]))
        its.actors[actor, Memory.LEFT_ROAD] = 0.0  # the time is known: no step determines it again
        its.actors[actor, Memory.SET_SPEED] = NO_SPEED
    last, pause = int(its.status[Status.SAMPLE]), plan.layout.pause
    for row in range((last + pause - 1) // pause):
        page, first = run.slot_pages[slot, row // PAGE], row * pause
        for turn in range(min(pause, last - first)):
            its.status[Status.SAMPLE] = first + turn
            _command(plan, its, run.command_pages[page, row % PAGE, turn], actions[first + turn])
            step(plan, its)
    its.status[Status.SAMPLE] = last
    _copy(run.actors, its.actors)


@inlined
def _copy(source: Floats, target: Floats) -> None:
    for actor in range(source.shape[0]):
        for column in range(source.shape[1]):
            target[actor, column] = source[actor, column]


@inlined
def _command(plan: Plan, run: Run, commands: Floats, decided: Floats) -> None:
    """Set the commands of all actors in a step."""
    for actor in range(len(plan.kinds)):
        at, memory = int(run.command_columns[actor]), run.actors[actor]
        if at < 0:
            number = -1 - at
            memory[Memory.THROTTLE], memory[Memory.BRAKE] = decided[number], decided[number + 1]
            memory[Memory.STEER] = decided[number + 2]
            continue
        pedal = commands[at]
        memory[Memory.LEAVING] = 1.0 if math.isnan(pedal) else 0.0
        memory[Memory.THROTTLE], memory[Memory.BRAKE] = max(pedal, 0.0), max(-pedal, 0.0)
        memory[Memory.STEER] = commands[at + 1]
