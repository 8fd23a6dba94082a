"""A run, sample by sample: the common definition of a step for all hosts.

At sample k (1) the state is recorded, and the scenario of the run has its turn, with the scenarios that it runs, (2)
all rules are evaluated, and the first true ending rule ends the run; then follow the time limit and the monitors in
their order, (3) behaviours act in the order of their actors, (4) unless one of these ended the run, all actors step,
and first contact is searched for in (t_k, t_k+1]. Between samples a centre and its heading move linearly. When the run
is over, its temporal requirements are judged over the samples up to the last before contact, or the end; if a file has
objectives, its rules are evaluated once more at that contact (`kernels.judging`).

How a host uses it:

    plan = engine.host.plan(program, config)            # once a program
    run = engine.host.memory(program, samples)          # once a thread; `samples` rows of record
    begin(plan, run, variant, values, key, actions)     # once a scene
    advance(plan, run, until, True)                     # to the ego's contact, the end, or sample `until`

`run.status` is the progress of the run (`run_state.Status`), `run.states[: sample + 1]` is its record. At the ego's
first contact in (t_k, t_k+1] the current sample is k + 1: its row holds the states that all actors would have without
that contact.

A contact of two other actors does not end the run: `kernels.impacts.motion` resolves it. In that step, too, contacts of
the ego are computed on the straight lines between the samples.

Contact physics after the ego's contact is not scored. A world host marks the bodies that it moves itself
(`run.actors[i, Slot.FREE] = HOSTED`), writes their states into the current row k, and calls `advance(plan, run, k + 1,
False)` for each further sample: all others continue to behave and step, free bodies do neither, and the host writes
their rows of sample k + 1. Monitors do not run then, and no new actor enters.
"""

import math

from engine.kernels.behaviour import HALTED, OUT_OF_BUDGET, RULE_TRIGGERED, UNDEFINED, Turn, interpret
from engine.kernels.impacts.motion import resolve_other_impacts
from engine.kernels.impacts.sweep import FirstContact, search_contact
from engine.kernels.jit import deferred, inlined, shared
from engine.kernels.judging import append_contact_sample, step_on
from engine.kernels.levels import enter_level, has_levels, keep_levels
from engine.kernels.motion import step
from engine.kernels.run_state import NO_OFFSET, NO_SPEED, REPLACED, RUNNING, Memory, Plan, Run, Status, end_run, place
from engine.kernels.slots import PAGE, continue_run, is_idle, leave_run, note_commands
from engine.kernels.temporal import UNKNOWN, find_broken
from engine.tables import Floats, Ints, Segment
from engine.vocabulary import EndReason, RuleKind, State, Turns


@shared
def begin(plan: Plan, run: Run, variant: int, values: Floats, key: Ints, actions: Floats) -> None:
    """Set up a scene: its variant, its values (n_values,), its stream key (6,), and the external decisions `actions`
    (turns, numbers), of which the last turn is repeated. Literals are already in the registers.
    """
    for i in range(plan.variant_values.shape[1]):
        run.registers[plan.layout.variant_values + i] = plan.variant_values[variant, i]
    for i in range(len(values)):
        run.registers[plan.layout.scene_values + i] = values[i]
    run.registers[plan.layout.locals :] = 0.0
    for i in range(len(key)):
        run.key[i] = key[i]
    for turn in range(len(run.actions) if len(actions) > 0 else 0):
        for number in range(run.actions.shape[1]):
            run.actions[turn, number] = actions[min(turn, len(actions) - 1), number]
    run.resume[:] = -1
    run.status[:] = -1
    run.status[Status.SAMPLE] = 0
    run.status[Status.DRAWS] = run.status[Status.IMPACTS] = run.status[Status.PAUSED] = run.status[Status.UNTOLD] = 0
    template = plan.variant_template[variant]
    run.status[Status.TEMPLATE] = template
    run.end[0], run.end[1], run.end[2] = 0.0, 0.0, math.nan
    for actor in range(len(plan.kinds)):
        run.resume[plan.main_blocks[template, actor]] = plan.entries[template, actor]
        place(plan, run, 0, actor, float(plan.present[actor]))
        if has_levels(plan):
            enter_level(plan, run, 0, actor)
    for monitor in range(len(plan.monitor_started)):
        if plan.monitor_started[monitor] == Turns.FROM_START or plan.monitor_started[monitor] == Turns.BEFORE_RULES:
            run.resume[plan.monitor_blocks[template, monitor]] = plan.monitors[template, monitor]


@shared
def advance(plan: Plan, run: Run, until: int, scored: bool) -> None:
    """Run to sample `until`; while scored, at most to the ego's first contact or to the end, and, if the plan has
    pauses, to the next pause: all rules have been evaluated, and no actor has acted. The next call continues from it.

    Unscored, there are no rules and no monitors, and no behaviour ends the run; contact is searched only among others,
    and only if the ego is `REPLACED`.

    Parallel runs are advanced one after the other; their temporal requirements are not judged, since they have no
    record.

    One flat loop covers the steps of all slots. With a loop over slots around a loop over steps, the compiler adds
    preparations per slot that pay off only over many steps; functions extracted from this body slow the batch host,
    because it holds values in registers. `benchmarks.environment` measures both.
    """
    slots = len(run.slots)
    its, slot, first, steps = run, -1, 0, slots == 0
    page, row = 0, 0
    while steps or slot < slots - 1:
        if not steps:
            slot += 1
            if is_idle(run, slot):
                continue
            its = run.slots[slot]
            continue_run(plan, its, slot)
            first = int(its.status[Status.SAMPLE])
            row = first // plan.layout.pause
            page, row = int(run.slot_pages[slot, row // PAGE]), row % PAGE
        steps = (its.status[Status.SAMPLE] < until and (its.status[Status.END] == RUNNING or not scored)) or its.status[
            Status.AT_CONTACT
        ] == 1
        if steps:
            if its.status[Status.SAMPLE] % plan.layout.hold == 0 or its.status[Status.AT_CONTACT] == 1:
                _take_turns(plan, its, scored)
            steps = not ((scored and its.status[Status.END] != RUNNING) or its.status[Status.PAUSED] == 1)
        if steps:
            if run.command_pages.shape[3] > 0:
                note_commands(plan, its, run, page, row, int(its.status[Status.SAMPLE]) - first)
            step(plan, its)
            if has_levels(plan):
                keep_levels(plan, its, int(its.status[Status.SAMPLE]) + 1)
            low, high = 0, len(plan.kinds)
            if not scored:
                low = 1 if its.actors[0, Memory.FREE] == REPLACED else high
            while low < high:
                met = search_contact(plan, its, low, high)
                high = 0
                if met.one == 0:
                    _note_contact(plan, its, met, scored)
                elif met.one > 0:
                    resolve_other_impacts(plan, its, int(its.status[Status.SAMPLE]), met.part, met.one, met.other)
                    high = 1  # the ego's own contact remains to be found
            its.status[Status.SAMPLE] += 1
            continue
        # The run has reached its end, a pause or `until`.
        if its.status[Status.AT_CONTACT] == 1:
            step_on(its)
        if slots > 0:
            leave_run(its, slot, first)
        elif scored and len(plan.temporal_root) > 0:
            judge_temporal(plan, its)


@inlined
def _note_contact(plan: Plan, run: Run, met: FirstContact, scored: bool) -> None:
    """End the run by the ego's contact in this step."""
    wall = met.other >= len(plan.kinds)
    end_run(plan, run, EndReason.BUILDING if wall else EndReason.COLLISION, -1, met.part)
    run.status[Status.CONTACT_ONE], run.status[Status.CONTACT_OTHER] = 0, -1 if wall else met.other
    if plan.layout.judged != 0 and scored:
        append_contact_sample(run)


@deferred()
def judge_temporal(plan: Plan, run: Run) -> None:
    """Let a run that has come to an end be aborted by a temporal requirement, at the sample that decided it."""
    reason = run.status[Status.END]
    if reason == RUNNING or reason == EndReason.ABORTED or reason == EndReason.BROKEN or reason == EndReason.STUCK:
        return
    last = run.status[Status.SAMPLE] - (1 if run.status[Status.CONTACT_ONE] >= 0 else 0)
    hold = plan.layout.hold
    broken = find_broken(
        plan.formula, plan.temporal_root, run.watched, last // hold, run.formula_values, run.formula_decided
    )
    if broken.temporal == UNKNOWN:
        end_run(plan, run, EndReason.BROKEN, -1, 0.0)
    elif broken.temporal >= 0:
        run.status[Status.SAMPLE] = broken.sample * hold
        run.status[Status.CONTACT_ONE] = run.status[Status.CONTACT_OTHER] = -1
        end_run(plan, run, EndReason.ABORTED, plan.temporal_rule[broken.temporal], 0.0)


# -- rules, monitors and behaviours -----------------------------------------------------------------------------------


@inlined
def _take_turns(plan: Plan, run: Run, scored: bool) -> None:
    """Execute the turn of the run's scenario, evaluate the rules, then execute all monitors and actors.

    They share a loop because the interpreter is copied into its caller. If that scenario ends the run, it does so after
    the rules have been evaluated: records get their last value, and permanent requirements count.
    """
    sample, template = int(run.status[Status.SAMPLE]), int(run.status[Status.TEMPLATE])
    rules = plan.rules.shape[1]
    leads = 1 if len(plan.monitor_started) > 0 and plan.monitor_started[0] == Turns.BEFORE_RULES else 0
    monitors, actors = leads + rules, rules + plan.monitors.shape[1]
    pauses = scored and plan.layout.pause > 0 and run.status[Status.PAUSED] == 0
    first = monitors if run.status[Status.PAUSED] == 1 else 0 if scored else actors
    if run.status[Status.AT_CONTACT] == 1:
        first = leads
    run.status[Status.PAUSED] = 0
    last_rule = -1
    for turn in range(first, actors + len(plan.kinds)):
        if turn == monitors and scored and run.status[Status.END] == RUNNING:
            if last_rule >= 0:
                _end_by_rule(plan, run, last_rule)
            elif sample >= plan.layout.last_sample:
                end_run(plan, run, EndReason.TIMEOUT, -1, 0.0)
        if turn >= monitors and scored and run.status[Status.END] != RUNNING:
            return
        if turn == monitors and pauses and sample % plan.layout.pause == 0:
            run.status[Status.PAUSED] = 1
            return
        coroutine = turn - rules if turn >= monitors else turn
        if turn >= actors:
            row = _first_row(plan, run, sample, template, turn - actors)
        elif turn >= leads and turn < monitors:
            row = int(plan.rules[template, turn - leads, Segment.START])
        elif plan.monitor_started[coroutine] == Turns.CALLED:
            continue
        else:
            row = int(run.resume[plan.monitor_blocks[template, coroutine]])
        if row < 0:
            continue
        result = interpret(plan, run, turn - actors, row)
        if turn >= leads and turn < monitors:
            _look(plan, run, sample, template, turn - leads, result)
        elif turn < leads and result.signal == RULE_TRIGGERED and plan.rule_kinds[result.detail] == RuleKind.TERMINATE:
            last_rule = result.detail
        else:
            _settle(plan, run, template, coroutine, result, scored)
    if scored and run.status[Status.END] == RUNNING and _is_over(plan, run, sample, template):
        end_run(plan, run, EndReason.ALL_DONE, -1, 0.0)


@inlined
def _first_row(plan: Plan, run: Run, sample: int, template: int, actor: int) -> int:
    """Return the row at which an actor's turn begins, -1 if it has none; reset everything that lasts one step."""
    if plan.layout.pedals_stay == 0:
        run.actors[actor, Memory.THROTTLE] = 0.0
        run.actors[actor, Memory.BRAKE] = 0.0
    run.actors[actor, Memory.SET_SPEED] = NO_SPEED
    run.actors[actor, Memory.OFFSET] = 0.0
    run.actors[actor, Memory.ASIDE] = NO_OFFSET
    run.actors[actor, Memory.TRACK] = 0.0
    run.actors[actor, Memory.STOP] = 0.0
    run.actors[actor, Memory.REVERSE] = 0.0 if run.actors[actor, Memory.REVERSE] != 1.0 else 1.0
    if run.states[sample, actor, State.PRESENT] == 0.0 or run.actors[actor, Memory.FREE] != 0.0:
        return -1
    return int(run.resume[plan.main_blocks[template, actor]])


@inlined
def _look(plan: Plan, run: Run, sample: int, template: int, rule: int, result: Turn) -> None:
    """Store the value of a rule, or let it end the run unless an earlier rule has."""
    value = run.registers[plan.rules[template, rule, Segment.RESULT]]
    if plan.rule_kinds[rule] == RuleKind.WATCH:
        touchdown = run.status[Status.AT_CONTACT] == 1
        row = (sample - 1) // plan.layout.hold + 1 if touchdown else sample // plan.layout.hold
        run.watched[row, rule] = value
    if run.status[Status.END] != RUNNING:
        return
    if result.signal == OUT_OF_BUDGET:
        end_run(plan, run, EndReason.STUCK, result.detail, 0.0)
    elif result.signal == UNDEFINED or (plan.rule_kinds[rule] != RuleKind.WATCH and math.isnan(value)):
        end_run(plan, run, EndReason.BROKEN, -1, 0.0)
    elif plan.rule_kinds[rule] != RuleKind.WATCH and value != 0.0:
        _end_by_rule(plan, run, rule)


@inlined
def _end_by_rule(plan: Plan, run: Run, rule: int) -> None:
    end_run(plan, run, EndReason.ABORTED if plan.rule_kinds[rule] == RuleKind.ABORT else EndReason.RULE, rule, 0.0)


@inlined
def _settle(plan: Plan, run: Run, template: int, coroutine: int, result: Turn, scored: bool) -> None:
    """Draw the consequences of how a turn ended; monitors are numbered before actors."""
    actor = coroutine - plan.monitors.shape[1]
    if result.signal == HALTED and actor < 0:
        run.resume[plan.monitor_blocks[template, coroutine]] = -1
    elif result.signal == HALTED:
        run.resume[plan.main_blocks[template, actor]] = -1
        run.actors[actor, Memory.LEAVING] = run.actors[actor, Memory.ROUTE_DONE]
    elif result.signal == RULE_TRIGGERED and scored:
        _end_by_rule(plan, run, result.detail)
    elif result.signal == OUT_OF_BUDGET and scored:
        end_run(plan, run, EndReason.STUCK, result.detail, 0.0)
    elif result.signal == UNDEFINED and scored:
        end_run(plan, run, EndReason.BROKEN, -1, 0.0)


@inlined
def _is_over(plan: Plan, run: Run, sample: int, template: int) -> bool:
    """Return True if the ego has left, or is alone (never with a single actor) and nothing declared evaluates the whole
    run.

    Actors that take part in the coming step count, and those that may still enter.
    """
    count = 0
    for actor in range(len(plan.kinds)):
        there = run.states[sample, actor, State.PRESENT] != 0.0 and run.actors[actor, Memory.LEAVING] == 0.0
        if not there and run.actors[actor, Memory.AWAITED] != 0.0:
            there = _running_monitors(plan, run, template) > 0
        if actor == 0 and not there:
            return True
        count += 1 if there else 0
    if count >= min(2, len(plan.kinds)):
        return False
    return plan.layout.lasting == 0 and _running_monitors(plan, run, template) == 0


@inlined
def _running_monitors(plan: Plan, run: Run, template: int) -> int:
    """Return the number of monitors that continue in a later step."""
    count = 0
    for monitor in range(len(plan.monitor_started)):
        count += 1 if run.resume[plan.monitor_blocks[template, monitor]] >= 0 else 0
    return count
