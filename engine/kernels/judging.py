"""Expectations and search objectives of a run, evaluated when the run is over.

Rules are evaluated in each sample, and once more at the instant of the ego's first contact: `append_contact_sample`
stores that instant in place of the next sample, in which nothing is driven any more, and `step_on` removes it again. So
a formula has the values of samples 0 to the last, then contact; a reducer takes the same values, at their times. Only
`final` stops at the last sample, as `record final` does.

A number that is NaN breaks the run: it is an error, and never a result.
"""

import math

from engine.judged import NAMED_RESULTS
from engine.kernels.conflict import post_encroachment_time, relative_speed, snapshot
from engine.kernels.evaluate import run_segment
from engine.kernels.jit import deferred, inlined, kernel
from engine.kernels.run_state import Plan, Run, Status, column_of
from engine.kernels.temporal import MARGIN, TRUTH, work_out
from engine.outcomes import PAIRS
from engine.tables import Floats, Segment
from engine.vocabulary import Column, Reducer, State

_NAMES = [row.name for row in PAIRS]
NEAREST, AT = _NAMES.index("min_distance"), _NAMES.index("min_distance_time")
COLUMNS = tuple(_NAMES.index(row.name) if row.name in _NAMES else -1 for row in NAMED_RESULTS)
"""Column of each named result among those of a pair; -1 for results that are computed here."""
DELTA_V, ENCROACHMENT = ([row.name for row in NAMED_RESULTS].index(n) for n in ("delta_v", "post_encroachment_time"))

# -- the instant of contact --------------------------------------------------------------------------------------------


@deferred()
def append_contact_sample(run: Run) -> None:
    """Write the instant of the ego's first contact as the next sample, for one evaluation of all rules; motion is
    linear.
    """
    sample = run.status[Status.SAMPLE]
    for actor in range(run.states.shape[1]):
        for column in range(run.states.shape[2]):
            before, after = run.states[sample, actor, column], run.states[sample + 1, actor, column]
            run.beyond[actor, column] = after
            run.states[sample + 1, actor, column] = before + run.end[1] * (after - before)
        if run.beyond[actor, State.PRESENT] != 0.0:
            run.states[sample + 1, actor, State.PRESENT] = run.states[sample, actor, State.PRESENT]
    run.status[Status.AT_CONTACT], run.status[Status.SHADED] = 1, -1


@deferred()
def step_on(run: Run) -> None:
    """Restore the sample after contact, as it would be if the ego had touched nobody."""
    sample = run.status[Status.SAMPLE]
    for actor in range(run.states.shape[1]):
        for column in range(run.states.shape[2]):
            run.states[sample, actor, column] = run.beyond[actor, column]
    run.status[Status.AT_CONTACT], run.status[Status.SHADED] = 0, -1


# -- when the run is over ----------------------------------------------------------------------------------------------


@kernel
def judge(plan: Plan, run: Run, pairs: Floats, outlines: Floats, sought: Floats, broken: Floats) -> int:
    """Write the value of each objective of a measured run into `sought`, and 1.0 into `broken` for a broken
    expectation, else 0.0. Return the first objective whose number is NaN, or -1.

    `pairs` (pairs, len(PAIRS)): the metrics of the run; `outlines` as in `pair.measure_pair`; `sought` and `broken`
    (objectives,).
    """
    touched = run.status[Status.CONTACT_ONE] >= 0
    last = (run.status[Status.SAMPLE] - (1 if touched else 0)) // plan.layout.hold
    seen = last + (1 if touched else 0)
    template = run.status[Status.TEMPLATE]
    if len(plan.formula) > 0:
        work_out(plan.formula, run.watched, seen, TRUTH, run.formula_values)
        for objective in range(len(plan.objective_root)):
            if plan.objective_root[objective] >= 0:
                broken[objective] = 1.0 if run.formula_values[0, plan.objective_root[objective]] < 0.0 else 0.0
        work_out(plan.formula, run.watched, seen, MARGIN, run.formula_values)
        for objective in range(len(plan.objective_root)):
            if plan.objective_root[objective] >= 0:
                sought[objective] = run.formula_values[0, plan.objective_root[objective]]
    _read(plan, run, last, seen, pairs, outlines)
    for objective in range(len(plan.objective_root)):
        start, end = plan.objective_segment[template, objective, 0], plan.objective_segment[template, objective, 1]
        if start >= 0:
            run_segment(plan.code, start, end, run.final, plan.pool, plan.road)
            sought[objective] = run.final[plan.objective_segment[template, objective, Segment.RESULT]]
    for objective in range(len(sought)):
        if math.isnan(sought[objective]):
            return objective
    return -1


@inlined
def _read(plan: Plan, run: Run, last: int, seen: int, pairs: Floats, outlines: Floats) -> None:
    """Write the registers for the objectives, whose first locals are the readings of the run."""
    for register in range(len(run.registers)):
        run.final[register] = run.registers[register]
    for reading in range(len(plan.readings)):
        kind, of = int(plan.readings[reading, 0]), int(plan.readings[reading, 1])
        if kind == Reducer.RESULT:
            value = _result(plan, run, of, pairs, outlines)
        else:
            value = reduced(kind, run.watched, of, last, seen, plan.layout.time_step * plan.layout.hold, run.end[0])
        run.final[plan.layout.locals + reading] = value


@kernel
def reduced(kind: int, watched: Floats, rule: int, last: int, seen: int, step: float, end: float) -> float:
    """Return a reduction of a rule's values at samples 0 to `last`, a `step` [s] apart, and, if `seen` is greater, at
    the `end` [s] of the run; in between they are linear. NaN if a value that counts is NaN.
    """
    if kind == Reducer.FINAL:
        return watched[last, rule]
    if kind == Reducer.INITIAL:
        return watched[0, rule]
    if kind == Reducer.CONTACT:
        return watched[seen, rule] if seen > last else math.inf
    before = least = largest = watched[0, rule]
    total = 0.0
    for sample in range(1, seen + 1):
        value = watched[sample, rule]
        if math.isnan(value) or math.isnan(least):
            return math.nan
        least, largest = min(least, value), max(largest, value)
        total += 0.5 * (before + value) * (step if sample <= last else end - last * step)
        before = value
    if kind == Reducer.LEAST:
        return least
    if kind == Reducer.LARGEST:
        return largest
    time = end if seen > last else last * step
    return total if kind == Reducer.TOTAL else total / time if time > 0.0 else least


@inlined
def _result(plan: Plan, run: Run, name: int, pairs: Floats, outlines: Floats) -> float:
    """Return a named result of the pair whose other actor came nearest to the ego."""
    nearest = 0
    for pair in range(1, len(pairs)):
        if pairs[pair, NEAREST] < pairs[nearest, NEAREST]:
            nearest = pair
    if name == DELTA_V:
        return _delta_v(plan, run, nearest + 1, pairs[nearest, AT], outlines)
    if name == ENCROACHMENT:
        return _encroachment(plan, run, nearest + 1, pairs[nearest, NEAREST], outlines)
    return pairs[nearest, COLUMNS[name]] if COLUMNS[name] >= 0 else run.end[0]


@inlined
def _shared(run: Run, other: int) -> tuple[int, int]:
    """Return the first sample at which both the ego and another are present, and the number of such samples without a
    gap.
    """
    samples = int(run.status[Status.SAMPLE]) + (0 if run.end[1] > 0.0 else 1)
    first, count = 0, 0
    for sample in range(samples):
        there = run.states[sample, 0, State.PRESENT] != 0.0 and run.states[sample, other, State.PRESENT] != 0.0
        if there and count == 0:
            first, count = sample, 1
        elif there:
            count += 1
        elif count > 0:
            break
    return first, count


@kernel
def _delta_v(plan: Plan, run: Run, other: int, time: float, outlines: Floats) -> float:
    """Return |v| m_other / (m_ego + m_other) at the instant of MD [m/s]: delta-v of a central impact without rebound.

    Laureshyn et al. (2017), "In search of the severity dimension of traffic events", Accid. Anal. Prev. 98: Delta-V0.
    """
    first, together = _shared(run, other)
    if together == 0:
        return 0.0
    step = plan.layout.time_step
    steps = min(max(time / step - first, 0.0), together - 1.0)
    now = snapshot(run.states[first:], together, int(steps), steps - int(steps), step, other, outlines)
    own, theirs = column_of(plan, run, 0, Column.MASS), column_of(plan, run, other, Column.MASS)
    return relative_speed(now) / (1.0 + own / theirs)


@kernel
def _encroachment(plan: Plan, run: Run, other: int, distance: float, outlines: Floats) -> float:
    """Return the magnitude of PET by shift [s] (`conflict.post_encroachment_time`): 0 on contact, infinite if the two
    share no place.
    """
    if distance == 0.0:
        return 0.0
    first, together = _shared(run, other)
    if together == 0:
        return math.inf
    return abs(post_encroachment_time(run.states[first:], together, plan.layout.time_step, other, outlines))
