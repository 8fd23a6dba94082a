"""Would a competent driver have avoided a collision? One case is driven again with a reference driver at the wheel.

The ego's path is the one that it took, carried on as it would have gone on without contact; only its motion along that
path differs. Up to the moment when the reference driver brakes everything is as it was; from then on the others go on
behaving, and react, if they react to anything, to the ego of the reference driver. That driver brakes as the ramp
allows, and no less than the ego has done since, up to full braking: who takes over does not let go of the pedal. Full
braking is that of the reference driver, of the ego's own brakes, or what its tyres hold, whichever is least.

To brake earlier is not always better, as who brakes later may pass before the other: all moments are tried.

Perception: at a sample a conflict is in sight when the ego could see the other, wherever it looks, and one of these
holds. Within the horizon the outlines would touch if the ego went on along its path at its present speed and the other
kept its speed and the rate at which it has just been turning (the constant turn rate and velocity model of Schubert,
Richter and Wanielik (2008), "Comparison and evaluation of advanced motion models for vehicle tracking"). Or the other
leads, nearer than the horizon, and brakes harder than the driver takes for usual, as UN R157 has it. A conflict is
perceived when it has been in sight for the whole time of perception.
"""

import math
from typing import NamedTuple

from engine.kernels.approach import first_contact
from engine.kernels.bicycle import Vehicle
from engine.kernels.conflict import snapshot, time_gap
from engine.kernels.geometry import Box, outline_at, shortest_turn
from engine.kernels.jit import inlined, kernel
from engine.kernels.noticing import notices
from engine.kernels.rollout import advance, begin
from engine.kernels.stage import REPLACED, RUNNING, Plan, Run, Slot, Status, column_of, vehicle_of
from engine.tables import Floats, Ints
from engine.vocabulary import ActorKind, Column, EndReason, State

WAY, PATH_X, PATH_Y, PATH_HEADING, OWN = range(5)
"""Columns of the ego's path: arc length of its centre [m], its poses, and by how much it slowed down itself in the step
after [m/s^2]; a row for each sample."""
PATH_COLUMNS = 5
NEVER = -1
"""No such sample."""
COASTING = 0.5
"""Who slows down by more brakes [m/s^2]; *ours*."""


class Driver(NamedTuple):
    """How the reference driver drives."""

    perception: float
    """Time that a conflict must be in sight to be perceived [s]."""
    reaction: float
    """From then until the brakes take hold [s]."""
    deceleration: float
    """Of full braking [m/s^2]."""
    ramp: float
    """From the first touch of the pedal to full braking [s]."""
    horizon: float
    """How far ahead a conflict is in sight [s]."""
    alarming: float
    """Deceleration of a leader beyond which there is a conflict, whatever the distance [m/s^2]."""
    reach: float
    """How far anything can be seen [m]."""


class Case(NamedTuple):
    """One scene: variant, scene values, stream key."""

    variant: int
    values: Floats
    key: Ints


class Weighed(NamedTuple):
    """What the reference driver made of a case, in samples of it; `NEVER` where there is none."""

    contact: int
    """The sample after first contact; `NEVER`: the ego touched nobody, and nothing else is known."""
    perceived: int
    """At which the conflict had been perceived."""
    braking: int
    """From which the reference driver brakes."""
    avoided: bool
    """Whether the ego then touches nobody."""
    latest: int
    """If avoided, the last sample up to which the driver may wait, every sample between avoiding contact; if not, the
    last one before `braking` that would have, else the first one after it; `NEVER`: there is none at all."""
    as_hard: bool
    """Whether the ego had braked, and at least as hard itself: it had come no farther."""
    lost: bool
    """Whether no sample at all avoids contact, nor full braking from the first sample on, without any ramp."""


class Outcome(NamedTuple):
    """One drive of the reference driver."""

    touched: bool
    way: float
    """Where along the path the ego was at the last sample before the contact of old [m]."""


@kernel
def weigh(plan: Plan, run: Run, case: Case, outlines: Floats, path: Floats, extra: int, driver: Driver) -> Weighed:
    """Drive a case as it was, find when its conflict is perceived, and drive it again with the reference driver.

    `run` and `path` (n, PATH_COLUMNS) have room for `extra` samples after the time limit; `outlines` (actors, 3) as in
    `pair.measure_pair`.
    """
    begin(plan, run, case.variant, case.values, case.key)
    scored = run.status[Status.END] == RUNNING
    advance(plan, run, plan.layout.last_sample + 1, scored)
    contact, other = int(run.status[Status.SAMPLE]), int(run.status[Status.CONTACT_OTHER])
    if run.status[Status.END] != EndReason.COLLISION:
        return Weighed(NEVER, NEVER, NEVER, False, NEVER, False, False)
    advance(plan, run, contact + extra, not scored)
    until = int(run.status[Status.SAMPLE])
    time_step = plan.layout.time_step
    _lay_path(run.states, until + 1, path, time_step)
    build_up = column_of(plan, run, 0, Column.PEDAL_TIME)
    driver = _in_its_car(driver, vehicle_of(plan, run, 0), build_up, plan.kinds[0] == ActorKind.PEDESTRIAN)
    perceived = _perceive(plan, run, contact, other, outlines, path[: until + 1], driver)
    braking = contact if perceived == NEVER else perceived + _samples(driver.reaction, time_step)
    begun = min(braking, contact)
    drive = _drive(plan, run, case, begun, contact, until, outlines, path, driver)
    as_hard = drive.touched and braking < contact - 1 and path[contact - 1, WAY] <= drive.way + 1e-6
    as_hard = as_hard and path[: contact - 1, OWN].max() > COASTING
    latest = _latest(plan, run, case, begun, not drive.touched, contact, until, outlines, path, driver)
    at_once = _brakes_like(driver, driver.deceleration, 0.0)
    lost = latest == NEVER and _drive(plan, run, case, 0, contact, until, outlines, path, at_once).touched
    if perceived == NEVER:
        return Weighed(contact, NEVER, NEVER, False, NEVER, False, lost)
    return Weighed(contact, perceived, braking, not drive.touched, latest, as_hard, lost)


@inlined
def _in_its_car(driver: Driver, vehicle: Vehicle, build_up: float, on_foot: bool) -> Driver:
    """The reference driver with the brakes and the tyres of the ego, whose full brakes take a time to build up [s]."""
    hardest = vehicle.max_braking if on_foot else min(vehicle.max_braking, vehicle.grip)
    braking = min(driver.deceleration, hardest)
    share = braking / vehicle.max_braking if vehicle.max_braking > 0.0 else 0.0
    return _brakes_like(driver, braking, max(driver.ramp, build_up * share))


@inlined
def _brakes_like(driver: Driver, braking: float, ramp: float) -> Driver:
    """The same driver with other brakes [m/s^2, s]."""
    return Driver(driver.perception, driver.reaction, braking, ramp, driver.horizon, driver.alarming, driver.reach)


@inlined
def _samples(time: float, time_step: float) -> int:
    """The first sample that is not before a time."""
    return math.ceil(time / time_step - 1e-9)


@inlined
def _lay_path(states: Floats, samples: int, path: Floats, time_step: float) -> None:
    way = 0.0
    for k in range(samples):
        if k > 0:
            x, y = states[k, 0, State.X] - states[k - 1, 0, State.X], states[k, 0, State.Y] - states[k - 1, 0, State.Y]
            way += math.sqrt(x * x + y * y)
        path[k, WAY] = way
        path[k, PATH_X], path[k, PATH_Y] = states[k, 0, State.X], states[k, 0, State.Y]
        path[k, PATH_HEADING] = states[k, 0, State.HEADING]
        after = states[k + 1, 0, State.SPEED] if k + 1 < samples else states[k, 0, State.SPEED]
        path[k, OWN] = max(0.0, states[k, 0, State.SPEED] - after) / time_step


@kernel
def _pose(path: Floats, way: float, length: float, width: float) -> Box:
    """The ego's outline at an arc length of its path; beyond the end straight on."""
    low, high = 0, len(path) - 1
    while high - low > 1:
        middle = (low + high) // 2
        if path[middle, WAY] <= way:
            low = middle
        else:
            high = middle
    span = path[high, WAY] - path[low, WAY]
    heading = path[low, PATH_HEADING]
    if way > path[high, WAY] or span <= 0.0:
        beyond, heading = max(0.0, way - path[high, WAY]), path[high, PATH_HEADING]
        x, y = path[high, PATH_X] + beyond * math.cos(heading), path[high, PATH_Y] + beyond * math.sin(heading)
        return Box(x, y, heading, length, width)
    part = (way - path[low, WAY]) / span
    return Box(
        path[low, PATH_X] + part * (path[high, PATH_X] - path[low, PATH_X]),
        path[low, PATH_Y] + part * (path[high, PATH_Y] - path[low, PATH_Y]),
        heading + part * shortest_turn(heading, path[high, PATH_HEADING]),
        length,
        width,
    )


# -- perception -------------------------------------------------------------------------------------------------------


@kernel
def _perceive(plan: Plan, run: Run, contact: int, other: int, outlines: Floats, path: Floats, driver: Driver) -> int:
    """The first sample before contact at which the conflict has been in sight for the time of perception."""
    time_step = plan.layout.time_step
    needed, seen = _samples(driver.perception, time_step), 0
    for k in range(contact):
        conflict = _conflicts(run.states, k, other, outlines, path, time_step, driver)
        if conflict and notices(plan, run, k, 0, other, driver.reach):
            seen += 1
        else:
            seen = 0
        if seen > needed:
            return k
    return NEVER


@inlined
def _conflicts(
    states: Floats, k: int, other: int, outlines: Floats, path: Floats, time_step: float, driver: Driver
) -> bool:
    """Whether there is anything to perceive at sample k: contact ahead, or a leader that brakes hard."""
    if states[k, 0, State.PRESENT] == 0.0 or states[k, other, State.PRESENT] == 0.0:
        return False
    if k > 0 and states[k, other, State.ACCELERATION] < -driver.alarming:
        now = snapshot(states, k + 1, k, 0.0, time_step, other, outlines)
        if time_gap(now) < driver.horizon:
            return True
    return _would_touch(states, k, other, outlines, path, time_step, driver.horizon)


@kernel
def _would_touch(
    states: Floats, k: int, other: int, outlines: Floats, path: Floats, time_step: float, horizon: float
) -> bool:
    """Whether the outlines would touch within the horizon if both went on as they do at sample k."""
    speed = states[k, 0, State.SPEED]
    theirs, heading = states[k, other, State.SPEED], states[k, other, State.HEADING]
    turn = shortest_turn(states[max(k - 1, 0), other, State.HEADING], heading)
    ahead = outlines[other, 2]
    x = states[k, other, State.X] - ahead * math.cos(heading)
    y = states[k, other, State.Y] - ahead * math.sin(heading)
    length, width = outlines[other, 0], outlines[other, 1]
    ego = _pose(path, path[k, WAY], outlines[0, 0], outlines[0, 1])
    them = Box(states[k, other, State.X], states[k, other, State.Y], heading, length, width)
    for step in range(_samples(horizon, time_step)):
        x += theirs * time_step * math.cos(heading + 0.5 * turn)
        y += theirs * time_step * math.sin(heading + 0.5 * turn)
        heading += turn
        ego_after = _pose(path, path[k, WAY] + (step + 1) * speed * time_step, outlines[0, 0], outlines[0, 1])
        after = Box(x + ahead * math.cos(heading), y + ahead * math.sin(heading), heading, length, width)
        if first_contact(ego, ego_after, them, after) >= 0.0:
            return True
        ego, them = ego_after, after
    return False


# -- the reference driver ---------------------------------------------------------------------------------------------


@kernel
def _drive(
    plan: Plan,
    run: Run,
    case: Case,
    braking: int,
    contact: int,
    until: int,
    outlines: Floats,
    path: Floats,
    driver: Driver,
) -> Outcome:
    """Drive a case as it was up to the sample `braking`, then brake along the path; on to the sample `until`."""
    begin(plan, run, case.variant, case.values, case.key)
    scored = run.status[Status.END] == RUNNING
    if braking >= contact:
        return Outcome(True, path[contact - 1, WAY])
    advance(plan, run, braking, scored)
    run.actors[0, Slot.FREE] = REPLACED
    time_step, states = plan.layout.time_step, run.states
    way, speed = path[braking, WAY], states[braking, 0, State.SPEED]
    held = path[max(braking - 1, 0), OWN]
    way_before = way
    for k in range(braking, until):
        middle = (k - braking + 0.5) * time_step
        held = max(held, path[k, OWN]) if k < contact else held
        pedal = driver.deceleration * (min(1.0, middle / driver.ramp) if driver.ramp > 0.0 else 1.0)
        slower = max(0.0, speed - max(min(held, driver.deceleration), pedal) * time_step)
        way += 0.5 * (speed + slower) * time_step
        speed = slower
        _place(states, k + 1, _pose(path[: until + 1], way, outlines[0, 0], outlines[0, 1]), speed)
        advance(plan, run, k + 1, not scored)
        if k + 1 == contact - 1:
            way_before = way
        if _touches(states, k, outlines):
            return Outcome(True, way_before if k + 1 >= contact - 1 else math.inf)
    return Outcome(False, way_before)


@inlined
def _place(states: Floats, sample: int, pose: Box, speed: float) -> None:
    for column in range(states.shape[2]):
        states[sample, 0, column] = 0.0
    states[sample, 0, State.X], states[sample, 0, State.Y] = pose.x, pose.y
    states[sample, 0, State.HEADING], states[sample, 0, State.SPEED] = pose.heading, speed
    states[sample, 0, State.PRESENT] = 1.0


@inlined
def _touches(states: Floats, k: int, outlines: Floats) -> bool:
    """Whether the ego touches anybody in the step after sample k."""
    touched = False
    for other in range(1, states.shape[1]):
        if states[k, other, State.PRESENT] != 0.0 and states[k + 1, other, State.PRESENT] != 0.0:
            ego, ego_after = outline_at(states, k, 0, outlines), outline_at(states, k + 1, 0, outlines)
            them, after = outline_at(states, k, other, outlines), outline_at(states, k + 1, other, outlines)
            touched = touched or first_contact(ego, ego_after, them, after) >= 0.0
    return touched


@kernel
def _latest(
    plan: Plan,
    run: Run,
    case: Case,
    braking: int,
    avoided: bool,
    contact: int,
    until: int,
    outlines: Floats,
    path: Floats,
    driver: Driver,
) -> int:
    """How long braking may wait, or which other moment would have been the right one; see `Weighed.latest`."""
    if avoided:
        for k in range(braking + 1, contact):
            if _drive(plan, run, case, k, contact, until, outlines, path, driver).touched:
                return k - 1
        return contact - 1
    for k in range(braking - 1, -1, -1):
        if not _drive(plan, run, case, k, contact, until, outlines, path, driver).touched:
            return k
    for k in range(braking + 1, contact):
        if not _drive(plan, run, case, k, contact, until, outlines, path, driver).touched:
            return k
    return NEVER
