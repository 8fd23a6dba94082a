"""Verdicts of reference drivers on a collision: one drive each, as `engine.kernels.avoidance` drives.

The careful driver of UN R157 perceives conflicts of any kind (`engine.kernels.perception`). The others are models of
Mattas, Botzoris, Papadopoulou et al. (2021), "JRC-FSM" (commit 01b05c2), the code with which the Joint Research Centre
compared performance models for UN R157. They drive straight along a lane; here along the ego's path, where the other
has an arc length, a lateral offset and a relative heading. Each judges a sample as safe or not:

- `REGULATION` (UN R157, 5.2.5.2): not safe within the lateral margin if TTC <= closing speed / (2 * braking) + reaction
  + 0.1 s.
- `RESPONSIBILITY` (RSS): not safe nearer than both its longitudinal and its lateral safe distance.
- `FUZZY` (FSM): not safe if the other is in the way, or will be before the ego has passed it, and one of the fuzzy
  metrics PFS and CFS is above 0.
- `SKILLED` (CC): not safe without a lateral gap if TTC <= 2 s, or, as in Appendix 3 of the regulation, if a leader
  within 2 s of headway brakes by more than 5 m/s^2.

A driver's reaction lasts as many unsafe samples as its reaction time; then it brakes in each unsafe sample, harder by a
jerk, and holds its speed in safe ones. It brakes no less than the ego had begun to. Two differences from that code: an
actor that drives away is no risk by its TTC, and a driver judges only an actor that nothing hides. A situation that a
model does not cover gives a reason instead of an answer (`Answer`).
"""

import math
from typing import NamedTuple

from engine.kernels.avoidance import (
    Case,
    DriveMemory,
    Replayed,
    brake_from,
    carry_on,
    collides,
    found_fault,
    in_its_car,
    limited_to,
    place_ego,
    record_others,
    start_from,
    touches,
)
from engine.kernels.conflict import SAME_WAY
from engine.kernels.fault import EGO, STANDING
from engine.kernels.geometry import shortest_turn
from engine.kernels.jit import inlined, kernel
from engine.kernels.levels import follow_levels, has_levels, recall_levels
from engine.kernels.noticing import notices
from engine.kernels.perception import (
    NEVER,
    OWN,
    PATH_HEADING,
    PATH_X,
    PATH_Y,
    WAY,
    Driver,
    first_sample,
    perceive,
)
from engine.kernels.rollout import advance
from engine.kernels.rows import Requested, Window, note_outlines
from engine.kernels.run_state import Plan, Run, Status, vehicle_of
from engine.tables import Floats, Ints, ReferenceModel
from engine.vocabulary import ActorKind, Answer, ReferenceKind, State, Verdict

CAREFUL, REGULATION, RESPONSIBILITY, FUZZY, SKILLED = map(int, ReferenceKind)
NONE, AVOIDS, COLLIDES, STRUCK, NO_VEHICLE, CROSSING, GRIP, REVERSING = map(int, Answer)
LATELY = 4.0
"""Time before contact in which the other must not cross the ego's direction [s]: the horizon of the careful driver."""
MOST_MARGIN = 4.0
"""Largest margin that is looked for [s]."""


class Encounter(NamedTuple):
    """Ego and other at a sample, along the ego's path."""

    ahead: bool
    """True if the other's centre is not behind the ego's."""
    gap: float
    """Distance between the outlines along the path [m]; negative where they overlap."""
    beside: float
    """The same across the path [m]."""
    reach: float
    """Distance along the path until the ego has passed the other [m]."""
    speed: float
    """Speed of the ego [m/s]."""
    acceleration: float
    """Acceleration of the ego in the last step [m/s^2]."""
    lead: float
    """Speed of the other along the path [m/s]."""
    coming: float
    """Speed of the other towards the path [m/s]."""
    braking: float
    """Deceleration of the other [m/s^2]."""


class Onset(NamedTuple):
    """State of a driver when it first acts."""

    sample: int
    """`NEVER` if it does not act before the contact of the case."""
    unsafe: int
    """Unsafe samples before that sample."""


@kernel
def verdict_rows(
    plan: Plan,
    scenes: Requested,
    reach: Floats,
    window: Window,
    memory: DriveMemory,
    driver: Driver,
    models: Floats,
    out: Ints,
    margins: Floats,
) -> None:
    """Write the `Answer` of each model (m, len(ReferenceModel)) to each valid scene of a window into `out` (n, m).

    `driver`: the careful driver. `reach` (n,): sight of each ego [m]. `margins`: no rows, or (n,): the margin of the
    careful driver [s], up to `MOST_MARGIN`, in scenes in which the models agree; NaN if it perceives nothing, minus
    infinity if braking at no moment avoids contact.
    """
    onsets = memory.onsets
    for row in range(window.first, window.last):
        if scenes.verdict[row] == Verdict.VALID:
            case = Case(int(scenes.variant[row]), scenes.values[row], scenes.keys[row], scenes.actions[row])
            limited = limited_to(driver, min(driver.reach, reach[row]))
            margin = _judge(plan, memory, case, limited, models, onsets, out[row], len(margins) > 0)
            if len(margins) > 0:
                margins[row] = margin


@inlined
def model_of(models: Floats, number: int) -> ReferenceModel:
    row = models[number]
    return ReferenceModel(
        int(row[0]),
        row[1],
        row[2],
        row[3],
        row[4],
        row[5],
        row[6],
        row[7],
        row[8],
        row[9],
        row[10],
        row[11],
        row[12],
        row[13],
        row[14],
    )


@kernel
def _judge(
    plan: Plan,
    memory: DriveMemory,
    case: Case,
    driver: Driver,
    models: Floats,
    onsets: Ints,
    answers: Ints,
    measured: bool,
) -> float:
    """Write the answer of each model to a case; return the margin of the careful driver [s] if it is `measured`."""
    run, outlines, path, time_step = memory.run, memory.outlines, memory.path, plan.layout.time_step
    if not collides(plan, run, memory, case):
        return math.nan
    note_outlines(plan, run, outlines)
    if found_fault(plan, run, outlines) != EGO:
        answers[:] = STRUCK
        return math.nan
    contact, other = int(run.status[Status.SAMPLE]), int(run.status[Status.CONTACT_OTHER])
    careful, others = _find_ranges(plan, run, contact, other, models, answers)
    reaction = first_sample(driver.reaction, time_step)
    # The careful driver brakes at contact or after it for a conflict that it perceives later than this.
    latest = contact - reaction
    in_time = latest > first_sample(driver.perception, time_step)
    if not others and not measured and not in_time:
        return math.nan
    driver = in_its_car(plan, run, driver)
    until = carry_on(plan, run, memory, driver)
    path = path[: until + 1]
    perceived = NEVER
    if careful or measured:
        perceived = perceive(plan, run, contact if measured else latest, other, outlines, path, driver)
    for number in range(len(models)):
        if answers[number] == NONE and models[number, 0] != CAREFUL:
            model = model_of(models, number)
            onset = _first_act(plan, run, contact, other, outlines, path, memory.own, model, driver.reach)
            onsets[number, 0], onsets[number, 1] = onset.sample, onset.unsafe
    many = others or measured
    if memory.independent and memory.touching and many:
        record_others(plan, run, memory, case, contact, until)
    # Otherwise a single drive costs as much as to record the others.
    recorded = memory.independent and (many or not memory.touching)
    again = Replayed(case, contact, until, outlines, path, memory.own, recorded, memory.checkpoints)
    braking = contact if perceived == NEVER else min(contact, perceived + reaction)
    touched = braking >= contact or brake_from(plan, run, again, braking, driver).touched
    for number in range(len(models)):
        if models[number, 0] == CAREFUL:
            answers[number] = COLLIDES if touched else AVOIDS
        elif answers[number] == NONE:
            onset = Onset(int(onsets[number, 0]), int(onsets[number, 1]))
            hit = onset.sample == NEVER or _drives_into(
                plan, run, again, other, model_of(models, number), onset, driver.reach
            )
            answers[number] = COLLIDES if hit else AVOIDS
    if not measured or perceived == NEVER or not _agree(answers):
        return math.nan
    found = _latest_braking(plan, run, again, braking, touched, driver)
    return (found - (perceived + reaction)) * time_step if found != NEVER else -math.inf


@inlined
def _agree(answers: Ints) -> bool:
    """Return True unless some drivers avoid contact and some do not."""
    avoids = collide = False
    for answer in answers:
        avoids = avoids or answer == AVOIDS
        collide = collide or answer == COLLIDES
    return not (avoids and collide)


@inlined
def _find_ranges(plan: Plan, run: Run, contact: int, other: int, models: Floats, answers: Ints) -> tuple[bool, bool]:
    """Write the reason of each model whose range the collision exceeds; for the careful driver write that it collides.

    Return whether the careful driver is among the models, and whether another one covers the collision.
    """
    careful, others = False, False
    vehicle = vehicle_of(plan, run, 0)
    available = min(vehicle.max_braking, vehicle.grip)
    reason = NONE
    mine, kind = plan.kinds[0], plan.kinds[other]
    if mine >= ActorKind.BICYCLE or kind == ActorKind.BICYCLE or kind == ActorKind.PEDESTRIAN:
        reason = NO_VEHICLE
    else:
        for k in range(max(0, contact - first_sample(LATELY, plan.layout.time_step)), contact):
            if run.states[k, 0, State.SPEED] < -STANDING:
                reason = REVERSING
            elif reason == NONE and run.states[k, other, State.PRESENT] != 0.0:
                turned = shortest_turn(run.states[k, 0, State.HEADING], run.states[k, other, State.HEADING])
                speed = run.states[k, other, State.SPEED]
                if (speed > STANDING and abs(turned) > SAME_WAY) or (speed < -STANDING):
                    reason = CROSSING
    for number in range(len(models)):
        if models[number, 0] == CAREFUL:
            careful, answers[number] = True, COLLIDES
        else:
            short = reason == NONE and available < model_of(models, number).braking
            answers[number] = GRIP if short else reason
            others = others or answers[number] == NONE
    return careful, others


# -- how a model sees a sample -----------------------------------------------------------------------------------------


@inlined
def _nearest_row(path: Floats, near: int, x: float, y: float) -> int:
    """Return the row of the path that is nearest to a point, searched downhill from the row `near`; -1: among all."""
    best = math.inf
    if near < 0:
        near = 0
        for row in range(len(path)):
            apart = (path[row, PATH_X] - x) ** 2 + (path[row, PATH_Y] - y) ** 2
            if apart < best:
                best, near = apart, row
        return near
    best = (path[near, PATH_X] - x) ** 2 + (path[near, PATH_Y] - y) ** 2
    for row in range(near + 1, len(path)):
        apart = (path[row, PATH_X] - x) ** 2 + (path[row, PATH_Y] - y) ** 2
        if apart > best:
            break
        best, near = apart, row
    for row in range(near - 1, -1, -1):
        apart = (path[row, PATH_X] - x) ** 2 + (path[row, PATH_Y] - y) ** 2
        if apart > best:
            break
        best, near = apart, row
    return near


@inlined
def _meet(
    states: Floats,
    k: int,
    other: int,
    outlines: Floats,
    path: Floats,
    near: int,
    way: float,
    speed: float,
    acceleration: float,
) -> Encounter:
    """Return the encounter at sample k; `near`: row of the path nearest to the other."""
    heading = path[near, PATH_HEADING]
    cos, sin = math.cos(heading), math.sin(heading)
    x, y = states[k, other, State.X] - path[near, PATH_X], states[k, other, State.Y] - path[near, PATH_Y]
    along, across = path[near, WAY] + cos * x + sin * y - way, cos * y - sin * x
    turned = states[k, other, State.HEADING] - heading
    ahead, aside = math.cos(turned), math.sin(turned)
    length, width, theirs = outlines[other, 0], outlines[other, 1], states[k, other, State.SPEED]
    long = 0.5 * (outlines[0, 0] + length * abs(ahead) + width * abs(aside))
    wide = 0.5 * (outlines[0, 1] + length * abs(aside) + width * abs(ahead))
    return Encounter(
        ahead=along >= 0.0,
        gap=abs(along) - long,
        beside=abs(across) - wide,
        reach=abs(along) + long,
        speed=speed,
        acceleration=acceleration,
        lead=theirs * ahead,
        coming=-math.copysign(1.0, across) * theirs * aside,
        braking=-states[k, other, State.ACCELERATION],
    )


@inlined
def _demand(model: ReferenceModel, met: Encounter) -> float:
    """Return the braking that a model wants at an unsafe sample [m/s^2]; 0: the sample is safe."""
    if not met.ahead:
        return 0.0
    if model.kind == REGULATION:
        return model.braking if _is_regulated(model, met) else 0.0
    if model.kind == RESPONSIBILITY:
        return model.braking if _is_near(model, met) else 0.0
    if model.kind == FUZZY:
        return _fuzzy(model, met)
    return model.braking if _is_critical(model, met) else 0.0


@inlined
def _is_regulated(model: ReferenceModel, met: Encounter) -> bool:
    closing = met.speed - met.lead
    if met.beside > model.margin or closing <= 0.0:
        return False
    return abs(met.gap) / closing <= closing / (2.0 * model.own) + model.reaction + model.spare


@inlined
def _is_near(model: ReferenceModel, met: Encounter) -> bool:
    """Return True if both distances are below those of definitions 1 and 6 of Shalev-Shwartz et al. (2017)."""
    time, faster = model.reaction, met.speed + model.reaction * model.speeding_up
    distance = met.speed * time + 0.5 * model.speeding_up * time * time + faster * faster / (2.0 * model.own)
    if met.gap >= distance - met.lead * met.lead / (2.0 * model.theirs):
        return False
    aside = abs(met.coming)
    drifting = aside + model.lateral * time
    safe = model.margin + 0.5 * (aside + drifting) * time + drifting * drifting / (2.0 * model.lateral)
    return met.beside < safe


@inlined
def _is_critical(model: ReferenceModel, met: Encounter) -> bool:
    closing = met.speed - met.lead
    if met.beside > model.margin:
        return False
    if closing > 0.0 and abs(met.gap) / closing <= model.critical:
        return True
    return met.braking > model.alarming and met.gap < met.speed * model.critical


@inlined
def _fuzzy(model: ReferenceModel, met: Encounter) -> float:
    """Return the braking by the metrics PFS and CFS of Mattas et al. (2020) [m/s^2]."""
    closing = met.speed - met.lead
    if met.beside > 0.0:
        if met.coming <= 0.0 or closing <= 0.0:
            return 0.0
        if met.beside / met.coming > met.reach / closing + model.spare:
            return 0.0
    critical = _critical_metric(model, met)
    if critical > 0.0:
        return model.comfortable + critical * (model.own - model.comfortable)
    return _proactive_metric(model, met) * model.comfortable


@inlined
def _proactive_metric(model: ReferenceModel, met: Encounter) -> float:
    reach = met.speed * model.reaction - met.lead * met.lead / (2.0 * model.theirs)
    safe = reach + met.speed * met.speed / (2.0 * model.comfortable) + model.room
    return _share(met.gap - model.room, reach + met.speed * met.speed / (2.0 * model.own), safe)


@inlined
def _critical_metric(model: ReferenceModel, met: Encounter) -> float:
    if met.speed <= met.lead:
        return 0.0
    slowing = max(met.acceleration, -model.comfortable)
    after = met.speed + model.reaction * slowing
    if after < met.lead:
        stops = (met.speed - met.lead) ** 2 / abs(2.0 * met.acceleration)
        return 1.0 if met.gap < stops else 0.0
    gone = (met.speed + 0.5 * slowing * model.reaction - met.lead) * model.reaction
    left = (after - met.lead) ** 2
    return _share(met.gap, gone + left / (2.0 * model.own), gone + left / (2.0 * model.comfortable))


@inlined
def _share(gap: float, unsafe: float, safe: float) -> float:
    """Return 1 below an unsafe gap, 0 above a safe one, and a linear value between."""
    if gap > safe:
        return 0.0
    return 1.0 if gap < unsafe else (safe - gap) / (safe - unsafe)


# -- how a model drives ------------------------------------------------------------------------------------------------


@kernel
def _first_act(
    plan: Plan,
    run: Run,
    contact: int,
    other: int,
    outlines: Floats,
    path: Floats,
    own: Floats,
    model: ReferenceModel,
    reach: float,
) -> Onset:
    """Return when a driver first acts in a case: it brakes, or lifts its foot if the model does."""
    time_step, near, unsafe = plan.layout.time_step, -1, 0
    delay = 0 if model.release > 0.0 else first_sample(model.reaction, time_step)
    for k in range(contact):
        if run.states[k, other, State.PRESENT] == 0.0 or run.states[k, 0, State.PRESENT] == 0.0:
            continue
        near = _nearest_row(path, near, run.states[k, other, State.X], run.states[k, other, State.Y])
        speed = abs(own[k, State.SPEED])
        acceleration = (speed - abs(own[k - 1, State.SPEED])) / time_step if k > 0 else 0.0
        met = _meet(run.states, k, other, outlines, path, near, path[k, WAY], speed, acceleration)
        if has_levels(plan):
            recall_levels(plan, run, k)
        if _demand(model, met) > 0.0 and notices(plan, run, k, 0, other, reach):
            if unsafe >= delay:
                return Onset(k, unsafe)
            unsafe += 1
    return Onset(NEVER, unsafe)


@kernel
def _drives_into(
    plan: Plan, run: Run, again: Replayed, other: int, model: ReferenceModel, onset: Onset, reach: float
) -> bool:
    """Drive a case as recorded up to the first act of a model, then by the model; return True if the ego touches any
    actor.
    """
    contact, outlines, path, first = again.contact, again.outlines, again.path, onset.sample
    time_step, states = plan.layout.time_step, run.states
    scored = start_from(plan, run, again, first)
    vehicle = vehicle_of(plan, run, 0)
    available = min(vehicle.max_braking, vehicle.grip)
    delay, unsafe, near = first_sample(model.reaction, time_step), onset.unsafe, -1
    way, speed = path[first, WAY], abs(again.own[first, State.SPEED])
    acceleration = (speed - abs(again.own[first - 1, State.SPEED])) / time_step if first > 0 else 0.0
    held, pedal = path[max(first - 1, 0), OWN], 0.0
    for k in range(first, again.until):
        demand, wanted = 0.0, 0.0
        if states[k, other, State.PRESENT] != 0.0:
            near = _nearest_row(path, near, states[k, other, State.X], states[k, other, State.Y])
            met = _meet(states, k, other, outlines, path, near, way, speed, acceleration)
            demand = _demand(model, met)
        if demand > 0.0 and notices(plan, run, k, 0, other, reach):
            if unsafe < delay:
                unsafe, wanted, pedal = unsafe + 1, model.release, model.release
            else:
                pedal = wanted = min(pedal + model.jerk * time_step, demand)
        held = max(held, path[k, OWN]) if k < contact else held
        slower = max(0.0, speed - max(min(held, available), wanted) * time_step)
        way += 0.5 * (speed + slower) * time_step
        acceleration, speed = (slower - speed) / time_step, slower
        place_ego(states, k + 1, path, way, outlines, speed)
        if not again.recorded:
            advance(plan, run, k + 1, not scored)
        elif has_levels(plan):
            follow_levels(plan, run, k + 1)
        if touches(run, k, outlines):
            return True
    return False


@kernel
def _latest_braking(plan: Plan, run: Run, again: Replayed, braking: int, touched: bool, driver: Driver) -> int:
    """Return `ReferenceDrive.latest`, found by steps that double and then halve.

    It is that of every sample tried, except where avoidance returns within such a step.
    """
    if not touched:
        end = min(again.contact, braking + first_sample(MOST_MARGIN, plan.layout.time_step) + 1)
        return _last_good(plan, run, again, braking, end, driver)
    bad, step, sample = braking, 1, braking - 1
    while sample >= 0:
        if not brake_from(plan, run, again, sample, driver).touched:
            return _last_good(plan, run, again, sample, bad, driver)
        bad, step = sample, 2 * step
        sample = 0 if 0 < sample < step else sample - step
    step, sample = 1, braking + 1
    while sample < again.contact:
        if not brake_from(plan, run, again, sample, driver).touched:
            return sample
        sample, step = sample + step, 2 * step
    return NEVER


@inlined
def _last_good(plan: Plan, run: Run, again: Replayed, good: int, bad: int, driver: Driver) -> int:
    """Return the last sample from `good` on, before `bad`, at which braking avoids contact."""
    step = 1
    while bad - good > 1:
        sample = min(good + step, (good + bad) // 2)
        if brake_from(plan, run, again, sample, driver).touched:
            bad = sample
        else:
            good, step = sample, 2 * step
    return good
