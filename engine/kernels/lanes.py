"""Runs side by side: what a run needs from one pause to the next lies in its lane, while one memory serves all in turn.

A step of many runs is one call: `rollout.advance` takes up one lane after the other, runs it on to its next pause or to
its end, and lays it down. So the same code serves a lone run and many. A lane holds where its run stands, not how it
came there: a run that has ended is judged by running it again, alone, from what was decided in it. What is worked on
stays in the cache. Such runs take their turns at every sample (`Layout.hold` is 1).
"""

from engine.kernels.jit import inlined
from engine.kernels.stage import RUNNING, Plan, Run, Status

EMPTY = -2
"""In the place of the end of a run, in a lane that has none."""


@inlined
def rests(run: Run, lane: int) -> bool:
    """Whether a lane has no run that goes on."""
    return bool(run.lane_live[lane, end_of(run)] != RUNNING)


@inlined
def end_of(run: Run) -> int:
    """Where in a lane the end of its run stands."""
    return int(run.lane_live.shape[1] - len(run.status) + Status.END)


@inlined
def take_up(run: Run, lane: int) -> None:
    """Go on with the run of a lane: at its current sample, before which nobody looks back further than lanes do.

    The impacts among others so far are left out: they only are on record, and that is another run's.
    """
    for i in range(len(run.live)):
        run.live[i] = run.lane_live[lane, i]
    run.status[Status.SHADED] = -1
    run.status[Status.BLOWS] = 0
    for actor in range(run.lane_legs.shape[1]):
        for column in range(run.legs.shape[1]):
            run.legs[actor, column] = run.lane_legs[lane, actor, column]
    now, back = int(run.status[Status.SAMPLE]), run.lane_states.shape[1]
    for sample in range(max(now - back + 1, 0), now + 1):
        for actor in range(run.states.shape[1]):
            for column in range(run.states.shape[2]):
                run.states[sample, actor, column] = run.lane_states[lane, sample % back, actor, column]
    for rule in range(run.watched.shape[1]):
        run.watched[now, rule] = run.lane_watched[lane, rule]


@inlined
def take_orders(plan: Plan, run: Run, lane: int) -> None:
    """What has been decided for the turns from the current sample to the next pause."""
    now, kept = int(run.status[Status.SAMPLE]), run.lane_actions.shape[1]
    for turn in range(now, min(now + plan.layout.pause, len(run.actions))):
        for number in range(run.actions.shape[1]):
            run.actions[turn, number] = run.lane_actions[lane, turn % kept, number]


@inlined
def lay_down(run: Run, lane: int, start: int, first: int) -> None:
    """Leave a run in its lane, where the first `start` words of `live` lie already, and the samples before `first`."""
    for i in range(start, len(run.live)):
        run.lane_live[lane, i] = run.live[i]
    for actor in range(run.lane_legs.shape[1]):
        for column in range(run.legs.shape[1]):
            run.lane_legs[lane, actor, column] = run.legs[actor, column]
    now, back = int(run.status[Status.SAMPLE]), run.lane_states.shape[1]
    for sample in range(max(now - back + 1, first), now + 1):
        for actor in range(run.states.shape[1]):
            for column in range(run.states.shape[2]):
                run.lane_states[lane, sample % back, actor, column] = run.states[sample, actor, column]
    looked = now - (1 if run.status[Status.CONTACT_ONE] >= 0 else 0)
    for rule in range(run.watched.shape[1]):
        run.lane_watched[lane, rule] = run.watched[looked, rule]
