"""Runs side by side: what a run needs from one pause to the next stands in its lane, and one memory serves all in turn.

A step of many runs is one call: `rollout.advance` goes through the lanes, and runs each on to its next pause or to its
end, in its place. So the same code serves a lone run and many. A lane holds where its run stands, not how it came
there: no record, but at most what everybody was commanded (`kernels.review`). Such runs take their turns at every
sample (`Layout.hold` is 1). What a lane keeps of several samples or turns stands in a ring of as many rows as a power
of two, so that finding the row of one needs no division.
"""

import math

from engine.kernels.jit import inlined
from engine.kernels.stage import NO_SPEED, RUNNING, Plan, Run, Slot, Status
from engine.tables import Floats, Ints
from engine.vocabulary import State

EMPTY = -2
"""In the place of the end of a run, in a lane that has none."""
PAGE = 8
"""Rows of a page, each of what was decided, and commanded, from one pause to the next."""
TOLD = 2
"""Numbers that say what an actor is commanded in a step: the pedal, negative of the brake, and the steering angle."""


@inlined
def rests(run: Run, lane: int) -> bool:
    """Whether a lane has no run that goes on."""
    return bool(run.lane_status[lane, Status.END] != RUNNING)


@inlined
def in_lane(run: Run, lane: int) -> Run:
    """The memory of the run in a lane; what no run carries on is that of all. For `@shared` functions, which count no
    references.
    """
    return lane_with(run, lane, run.lane_actors[lane], run.lane_status[lane], run.told)


@inlined
def telling(plan: Plan, run: Run, lane: int) -> Run:
    """The same, with the row for what is commanded up to the next pause."""
    row = int(run.lane_status[lane, Status.SAMPLE]) // plan.layout.pause
    told = run.told_pages[run.lane_pages[lane, row // PAGE], row % PAGE]
    return lane_with(run, lane, run.lane_actors[lane], run.lane_status[lane], told)


@inlined
def lane_with(run: Run, lane: int, actors: Floats, status: Ints, told: Floats) -> Run:
    """The same with actors, status and commands that stand elsewhere."""
    return Run(
        states=run.states,
        registers=run.lane_registers[lane],
        resume=run.lane_resume[lane],
        actors=actors,
        status=status,
        end=run.lane_end[lane],
        legs=run.legs,
        impacts=run.impacts,
        key=run.lane_key[lane],
        watched=run.watched,
        worth=run.worth,
        decided=run.decided,
        beyond=run.beyond,
        final=run.final,
        shades=run.shades,
        actions=run.actions,
        told=told,
        told_at=run.told_at,
        lane_registers=run.lane_registers,
        lane_actors=run.lane_actors,
        lane_end=run.lane_end,
        lane_key=run.lane_key,
        lane_resume=run.lane_resume,
        lane_status=run.lane_status,
        lane_states=run.lane_states,
        lane_watched=run.lane_watched,
        lane_legs=run.lane_legs,
        lane_actions=run.lane_actions,
        lane_pages=run.lane_pages,
        told_pages=run.told_pages,
    )


@inlined
def take_up(run: Run, lane: int) -> None:
    """Go on with the run of a lane: at its current sample, before which nobody looks back further than lanes do.

    The impacts among others so far are left out: they only are on record, and that is another run's.
    """
    run.status[Status.SHADED] = -1
    run.status[Status.BLOWS] = 0
    for actor in range(run.lane_legs.shape[1]):
        for column in range(run.legs.shape[1]):
            run.legs[actor, column] = run.lane_legs[lane, actor, column]
    now, back = int(run.status[Status.SAMPLE]), run.lane_states.shape[1]
    for sample in range(max(now - back + 1, 0), now + 1):
        row = sample & (back - 1)
        for actor in range(run.states.shape[1]):
            for column in range(run.states.shape[2]):
                run.states[sample, actor, column] = run.lane_states[lane, row, actor, column]
    for rule in range(run.watched.shape[1]):
        run.watched[now, rule] = run.lane_watched[lane, rule]


@inlined
def take_orders(plan: Plan, run: Run, lane: int) -> None:
    """What has been decided for the turns from the current sample to the next pause."""
    now, kept = int(run.status[Status.SAMPLE]), run.lane_actions.shape[1]
    for turn in range(now, min(now + plan.layout.pause, len(run.actions))):
        row = turn & (kept - 1)
        for number in range(run.actions.shape[1]):
            run.actions[turn, number] = run.lane_actions[lane, row, number]


@inlined
def note_commands(plan: Plan, run: Run, turn: int) -> None:
    """Keep what everybody is commanded in the coming step, number `turn` since a pause; of who leaves, that it does: no
    number. Who does what is decided outside needs no more than that. Where that is not all, a note says so.
    """
    sample = int(run.status[Status.SAMPLE])
    for actor in range(len(plan.kinds)):
        at, slots = int(run.told_at[actor]), run.actors[actor]
        leaves = slots[Slot.LEAVING] != 0.0
        goes = not leaves and run.states[sample, actor, State.PRESENT] != 0.0
        throttle, brake, steer = slots[Slot.THROTTLE], slots[Slot.BRAKE], slots[Slot.STEER]
        if at < 0:
            number = -1 - at
            asked, pressed = run.actions[sample, number], run.actions[sample, number + 1]
            known = goes and throttle == asked and brake == pressed and steer == run.actions[sample, number + 2]
        else:
            run.told[turn, at], run.told[turn, at + 1] = throttle - brake if goes else math.nan, steer
            known = leaves or (goes and (brake == 0.0 or throttle == 0.0) and throttle >= 0.0 and brake >= 0.0)
        other = slots[Slot.FREE] != 0.0 or slots[Slot.TRACK] != 0.0 or slots[Slot.REVERSE] != 0.0
        if not known or other or slots[Slot.SET_SPEED] != NO_SPEED or slots[Slot.STOP] != 0.0:
            run.status[Status.UNTOLD] = 1


@inlined
def lay_down(run: Run, lane: int, first: int) -> None:
    """Leave a run in its lane, where the samples before `first` stand already."""
    for actor in range(run.lane_legs.shape[1]):
        for column in range(run.legs.shape[1]):
            run.lane_legs[lane, actor, column] = run.legs[actor, column]
    now, back = int(run.status[Status.SAMPLE]), run.lane_states.shape[1]
    for sample in range(max(now - back + 1, first), now + 1):
        row = sample & (back - 1)
        for actor in range(run.states.shape[1]):
            for column in range(run.states.shape[2]):
                run.lane_states[lane, row, actor, column] = run.states[sample, actor, column]
    looked = now - (1 if run.status[Status.CONTACT_ONE] >= 0 else 0)
    for rule in range(run.watched.shape[1]):
        run.lane_watched[lane, rule] = run.watched[looked, rule]
