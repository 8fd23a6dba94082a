"""Parallel runs: a slot stores the state of a run from a pause to the next, and all slots share a working memory.

One call of `rollout.advance` advances the run of each slot to its next pause or to its end. The same code serves a
single run and many. `run.slots[slot]` is the state of the run in a slot: its own registers, actors, status, end, key
and blocks, and the shared memory. A slot stores the current state of its run and no record; at most the commands or
states of a step (`kernels.review`). Such runs take their turns at every sample (`Layout.hold` is 1). Samples and turns
are stored in rings whose number of rows is a power of two, so that the row of a sample needs no division.
"""

import math

from engine.kernels.jit import deferred, inlined
from engine.kernels.run_state import NO_SPEED, RUNNING, Memory, Plan, Run, Status
from engine.vocabulary import State

EMPTY = -2
"""Entry in place of the end of a run in a slot without a run."""
PAGE = 8
"""Number of rows of a page; a row holds the decisions and commands from a pause to the next."""
COMMAND_COLUMNS = 2
"""Numbers of a command: pedal (the brake is negative) and steering angle."""


@inlined
def is_idle(run: Run, slot: int) -> bool:
    """Return True if a slot has no run that continues."""
    return bool(run.slot_status[slot, Status.END] != RUNNING)


@inlined
def resume_run(run: Run, slot: int) -> None:
    """Copy the recent samples of a slot into the record. No driver reads samples before those that slots store.

    Earlier impacts between other actors are left out: they are read only from the record of a whole run.
    """
    run.status[Status.SHADED] = -1
    run.status[Status.IMPACTS] = 0
    for actor in range(run.slot_segments.shape[1]):
        for column in range(run.segments.shape[1]):
            run.segments[actor, column] = run.slot_segments[slot, actor, column]
    now, back = int(run.status[Status.SAMPLE]), run.slot_states.shape[1]
    for sample in range(max(now - back + 1, 0), now + 1):
        row = sample & (back - 1)
        for actor in range(run.states.shape[1]):
            for column in range(run.states.shape[2]):
                run.states[sample, actor, column] = run.slot_states[slot, row, actor, column]
    for rule in range(run.watched.shape[1]):
        run.watched[now, rule] = run.slot_watched[slot, rule]


@inlined
def _take_decisions(plan: Plan, run: Run, slot: int) -> None:
    """Copy the decisions for the turns from the current sample to the next pause."""
    now, kept = int(run.status[Status.SAMPLE]), run.slot_actions.shape[1]
    for turn in range(now, min(now + plan.layout.pause, len(run.actions))):
        row = turn & (kept - 1)
        for number in range(run.actions.shape[1]):
            run.actions[turn, number] = run.slot_actions[slot, row, number]


@inlined
def is_judged_later(plan: Plan) -> bool:
    """Return True if the values of rules at all samples decide the results of a run."""
    return plan.layout.judged != 0 or len(plan.temporal_root) > 0


@deferred()
def continue_run(plan: Plan, run: Run, slot: int) -> None:
    """Copy the run of a slot into the working memory: recent samples, decisions of the coming turns."""
    resume_run(run, slot)
    _take_decisions(plan, run, slot)


@deferred()
def leave_run(run: Run, slot: int, first: int) -> None:
    """Call `suspend_run`, as a separately compiled function."""
    suspend_run(run, slot, first)


@deferred()
def note_commands(plan: Plan, run: Run, pages: Run, page: int, row: int, turn: int) -> None:
    """Store the commands of all actors in the coming step in `pages`: NaN for an actor that leaves.

    Without command columns, store the states of all actors at the current sample instead. An actor that executes
    external decisions needs no entry. `Status.UNTOLD` is set if anything else moves an actor. The values of rules that
    are judged after the run follow, in the last columns. `page` and `row` are those of the last pause, `turn` counts
    the steps since then.
    """
    sample = int(run.status[Status.SAMPLE])
    if is_judged_later(plan):
        place = pages.command_pages.shape[3] - run.watched.shape[1]
        for rule in range(run.watched.shape[1]):
            pages.command_pages[page, row, turn, place + rule] = run.watched[sample, rule]
    if len(run.command_columns) == 0:
        for actor in range(run.states.shape[1]):
            for column in range(run.states.shape[2]):
                place = actor * run.states.shape[2] + column
                pages.command_pages[page, row, turn, place] = run.states[sample, actor, column]
        return
    for actor in range(len(plan.kinds)):
        at, memory = int(run.command_columns[actor]), run.actors[actor]
        leaves = memory[Memory.LEAVING] != 0.0
        goes = not leaves and run.states[sample, actor, State.PRESENT] != 0.0
        throttle, brake, steer = memory[Memory.THROTTLE], memory[Memory.BRAKE], memory[Memory.STEER]
        if at < 0:
            number = -1 - at
            asked, pressed = run.actions[sample, number], run.actions[sample, number + 1]
            known = goes and throttle == asked and brake == pressed and steer == run.actions[sample, number + 2]
        else:
            pages.command_pages[page, row, turn, at] = throttle - brake if goes else math.nan
            pages.command_pages[page, row, turn, at + 1] = steer
            known = leaves or (goes and (brake == 0.0 or throttle == 0.0) and throttle >= 0.0 and brake >= 0.0)
        other = memory[Memory.FREE] != 0.0 or memory[Memory.TRACK] != 0.0 or memory[Memory.REVERSE] != 0.0
        if not known or other or memory[Memory.SET_SPEED] != NO_SPEED or memory[Memory.STOP] != 0.0:
            run.status[Status.UNTOLD] = 1


@inlined
def suspend_run(run: Run, slot: int, first: int) -> None:
    """Copy the samples from `first` to the current sample into a slot."""
    for actor in range(run.slot_segments.shape[1]):
        for column in range(run.segments.shape[1]):
            run.slot_segments[slot, actor, column] = run.segments[actor, column]
    now, back = int(run.status[Status.SAMPLE]), run.slot_states.shape[1]
    for sample in range(max(now - back + 1, first), now + 1):
        row = sample & (back - 1)
        for actor in range(run.states.shape[1]):
            for column in range(run.states.shape[2]):
                run.slot_states[slot, row, actor, column] = run.states[sample, actor, column]
    looked = now - (1 if run.status[Status.CONTACT_ONE] >= 0 else 0)
    for rule in range(run.watched.shape[1]):
        run.slot_watched[slot, rule] = run.watched[looked, rule]
    if len(run.slot_touching) > 0 and looked < now:
        for rule in range(run.watched.shape[1]):
            run.slot_touching[slot, rule] = run.watched[now, rule]
