"""Assessment of parallel runs that have ended, on their record.

How a run ended is stored in its slot. In runs in which only the ego can be struck, the commands of each step are stored
(`slots.note_commands`). If nothing but commands moves an actor (`Status.UNTOLD`), motion reproduces the record from
them, bit for bit, without behaviors and without a search for contact. In all other runs the states are stored. Values
of rules that decide the results are stored with either.
"""

import math

from engine.kernels.jit import inlined, shared
from engine.kernels.motion import step
from engine.kernels.rollout import judge_temporal
from engine.kernels.rows import Results, note_results
from engine.kernels.run_state import NO_SPEED, Memory, Plan, Run, Status, place
from engine.kernels.slots import PAGE, is_judged_later
from engine.tables import Floats, Ints


@shared
def review_slots(plan: Plan, run: Run, chosen: Ints, actions: Floats, outlines: Floats, out: Results) -> None:
    """Write the results of the runs of the chosen slots, which have ended, into the rows of the same numbers.

    `actions` (chosen, turns, numbers) are the decisions made in the slots, `outlines` (actors, 3) is working memory.
    The rows of `out` hold the values of a run without a result. The slots stay as they are: the record, and the state
    at its end, are restored in the memory that they share.
    """
    for number in range(len(chosen)):
        slot = chosen[number]
        last = int(run.slot_status[slot, Status.SAMPLE])
        if len(run.command_columns) == 0:
            _read_states(plan, run, slot, last)
        else:
            _repeat_motion(plan, run, slot, last, actions[number])
        _take_end(run, slot)
        if is_judged_later(plan):
            _read_watched(plan, run, slot, last)
            if len(plan.temporal_root) > 0:
                judge_temporal(plan, run)
        note_results(plan, run, slot, outlines, out)


@inlined
def _take_end(run: Run, slot: int) -> None:
    """Copy the state of a run at its end from its slot."""
    for entry in range(len(run.status)):
        run.status[entry] = run.slot_status[slot, entry]
    run.status[Status.SHADED] = -1  # the outlines that hide are those of another slot
    for entry in range(len(run.end)):
        run.end[entry] = run.slot_end[slot, entry]
    for register in range(len(run.registers)):
        run.registers[register] = run.slot_registers[slot, register]
    for actor in range(run.actors.shape[0]):
        for column in range(run.actors.shape[1]):
            run.actors[actor, column] = run.slot_actors[slot, actor, column]


@inlined
def _read_watched(plan: Plan, run: Run, slot: int, last: int) -> None:
    """Write the values of rules at all samples, and at the ego's first contact, as they were stored."""
    touched = run.status[Status.CONTACT_ONE] >= 0
    seen = last - (1 if touched else 0)
    for rule in range(run.watched.shape[1]):
        for sample in range(seen):
            page, turn = run.slot_pages[slot, sample // plan.layout.pause // PAGE], sample % plan.layout.pause
            row = sample // plan.layout.pause % PAGE
            column = run.command_pages.shape[3] - run.watched.shape[1] + rule
            run.watched[sample, rule] = run.command_pages[page, row, turn, column]
        run.watched[seen, rule] = run.slot_watched[slot, rule]
        if touched and len(run.slot_touching) > 0:
            run.watched[last, rule] = run.slot_touching[slot, rule]


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
def _repeat_motion(plan: Plan, run: Run, slot: int, last: int, actions: Floats) -> None:
    """Write the record of a slot: the samples up to `last`, its current one."""
    _take_end(run, slot)
    for actor in range(len(plan.kinds)):
        place(plan, run, 0, actor, float(plan.present[actor]))
        run.actors[actor, Memory.LEFT_ROAD] = 0.0  # the time is known: no step determines it again
        run.actors[actor, Memory.SET_SPEED] = NO_SPEED
    pause = plan.layout.pause
    for row in range((last + pause - 1) // pause):
        page, first = run.slot_pages[slot, row // PAGE], row * pause
        for turn in range(min(pause, last - first)):
            run.status[Status.SAMPLE] = first + turn
            _command(plan, run, run.command_pages[page, row % PAGE, turn], actions[first + turn])
            step(plan, run)


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
