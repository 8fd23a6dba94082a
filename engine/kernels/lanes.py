"""Runs side by side: what a run needs from one pause to the next lies in its lane, while one memory serves all in turn.

A step of many runs is one call: `rollout.advance` takes up one lane after the other, runs it on to its next pause, and
lays it down. So the same code serves a lone run and many, a lane holds what is needed and no more, and what is worked
on stays in the cache. Such runs take their turns at every sample (`Layout.hold` is 1).
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
def take_up(plan: Plan, run: Run, lane: int) -> None:
    """Go on with the run of a lane: at its current sample, before which there is no record."""
    for i in range(len(run.live)):
        run.live[i] = run.lane_live[lane, i]
    run.status[Status.SHADED] = -1
    for actor in range(run.lane_legs.shape[1]):
        for column in range(run.legs.shape[1]):
            run.legs[actor, column] = run.lane_legs[lane, actor, column]
    for blow in range(min(run.status[Status.BLOWS], run.lane_blows.shape[1])):
        for column in range(run.impacts.shape[1]):
            run.impacts[blow, column] = run.lane_blows[lane, blow, column]
    sample = int(run.status[Status.SAMPLE])
    _recall(run, lane, sample, sample)
    for turn in range(sample, min(sample + max(plan.layout.pause, 1), len(run.actions))):
        for number in range(run.actions.shape[1]):
            run.actions[turn, number] = run.lane_actions[lane, turn, number]


@inlined
def lay_down(run: Run, lane: int, start: int) -> None:
    """Leave a run in its lane; the first `start` words of `live` lie there already."""
    for i in range(start, len(run.live)):
        run.lane_live[lane, i] = run.live[i]
    for actor in range(run.lane_legs.shape[1]):
        for column in range(run.legs.shape[1]):
            run.lane_legs[lane, actor, column] = run.legs[actor, column]
    for blow in range(min(run.status[Status.BLOWS], run.lane_blows.shape[1])):
        for column in range(run.impacts.shape[1]):
            run.lane_blows[lane, blow, column] = run.impacts[blow, column]


@inlined
def record_lane(run: Run, lane: int, first: int) -> None:
    """Keep the samples from `first` on in a lane; of a run that is over, take up those before, too."""
    for sample in range(first, run.status[Status.SAMPLE] + 1):
        for actor in range(run.states.shape[1]):
            for column in range(run.states.shape[2]):
                run.lane_states[lane, sample, actor, column] = run.states[sample, actor, column]
        for rule in range(run.watched.shape[1]):
            run.lane_watched[lane, sample, rule] = run.watched[sample, rule]
    if run.status[Status.END] != RUNNING:
        _recall(run, lane, 0, first - 1)


@inlined
def _recall(run: Run, lane: int, first: int, last: int) -> None:
    """Take up what a lane has on record of some samples."""
    for sample in range(first, last + 1):
        for actor in range(run.states.shape[1]):
            for column in range(run.states.shape[2]):
                run.states[sample, actor, column] = run.lane_states[lane, sample, actor, column]
        for rule in range(run.watched.shape[1]):
            run.watched[sample, rule] = run.lane_watched[lane, sample, rule]
