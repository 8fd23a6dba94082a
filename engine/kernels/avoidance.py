"""Avoidability of a collision by a competent driver: a case is driven again with a reference driver.

The ego's path is that of the case, continued as if there were no contact; only its motion along that path differs.
Until the reference driver brakes, everything is as in the case; from then on the others continue to behave, and react,
if they react to anything, to the ego of the reference driver. That driver brakes as the ramp permits, and at least as
hard as the ego in the case, up to full braking, since a driver taking over does not release the pedal. Full braking is
that of the reference driver, of the ego's own brakes, or the grip of its tyres, whichever is least.

Where nothing that the others do depends on the ego, they move alike in every drive: then only the ego is moved. Where
something does, the state of the run is stored at each sample of the case, and each drive continues from there.

Earlier braking is not always better, since an ego braking later may pass before the other: all moments are tried.
`engine.kernels.references` omits these trials: a single drive answers yes or no, for thousands of collisions in the
time of a few runs each.

An ego in reverse is followed along the same path, by its absolute speed. `engine.kernels.perception` defines when the
conflict is perceived.
"""

import math
from typing import NamedTuple

from engine.kernels.approach import first_contact
from engine.kernels.fault import STANDING, fault_of
from engine.kernels.geometry import Box, outline_at
from engine.kernels.jit import inlined, kernel
from engine.kernels.levels import (
    follow_levels,
    has_levels,
    measure_on_levels,
    recall_levels,
    restore_levels,
    trace_levels,
)
from engine.kernels.pair import measure_pair
from engine.kernels.perception import (
    COURSE,
    NEVER,
    OWN,
    WAY,
    Driver,
    first_sample,
    is_in_sight,
    lay_path,
    perceive,
    pose_at,
    reached,
)
from engine.kernels.rollout import advance, begin
from engine.kernels.rows import Requested, Window, note_outlines
from engine.kernels.run_state import (
    REPLACED,
    RUNNING,
    Memory,
    Plan,
    Run,
    Status,
    column_of,
    on_one_level,
    vehicle_of,
)
from engine.tables import Floats, Ints
from engine.vocabulary import ActorKind, Column, EndReason, State, Verdict

COASTING = 0.5
"""Deceleration above which an actor uses its brakes [m/s^2]; a choice of cortexc."""
AFTERWARDS = 6.0
"""Time for which a case is followed after contact [s], as for stopping from 130 km/h on a dry road; longer if the
reference driver needs longer to stop.
"""
LONGEST = 60.0
"""Upper bound of that time [s]: on a road without grip nothing ever stops."""


class Case(NamedTuple):
    """A scene: variant, scene values, stream key, and external decisions."""

    variant: int
    values: Floats
    key: Ints
    actions: Floats


class Checkpoints(NamedTuple):
    """State of a run at each sample up to contact; no rows where the others do not depend on the ego."""

    registers: Floats
    """(samples, registers)"""
    resume: Ints
    """(samples, blocks)"""
    status: Ints
    """(samples, len(Status))"""
    end: Floats
    """(samples, 3)"""
    actors: Floats
    """(samples, actors, len(Memory))"""
    segments: Floats
    """(samples, actors, len(MotionSegment)); no actors where others cannot touch."""
    impacts: Floats
    """(samples, MAX_IMPACTS, len(ImpactRecord)); no impacts where others cannot touch."""
    states: Floats
    """(samples, actors, len(State)) before the turns of the sample."""
    record: Floats
    """(samples, actors, len(State)) after the turns of the sample."""


class DriveMemory(NamedTuple):
    """Reusable memory of the drives of a case, for up to `LONGEST` after the time limit."""

    run: Run
    outlines: Floats
    """(actors, 3)"""
    path: Floats
    """(n, PATH_COLUMNS) Path of the ego."""
    own: Floats
    """(n, len(State)) Motion of the ego in the case."""
    independent: bool
    """True if nothing that the others do depends on the ego."""
    touching: bool
    """True if the others may touch each other or a building."""
    onsets: Ints
    """(models, 2) First act of each model (`engine.kernels.references`)."""
    conflicts: Floats
    """(n,) Distances of a conflict (`engine.kernels.adapted`)."""
    checkpoints: Checkpoints


class ReferenceDrive(NamedTuple):
    """Result of the reference driver in a case, in samples of the case; `NEVER` for samples that do not exist."""

    contact: int
    """Sample after first contact; `NEVER`: the ego touched nobody, and nothing else is known."""
    time: float
    """Time of contact [s]."""
    fault: int
    """`Fault`"""
    perceived: int
    """Sample at which the conflict was perceived."""
    braking: int
    """Sample at which the reference driver begins to brake."""
    avoided: bool
    """True if the ego then touches nobody."""
    latest: int
    """If avoided, the last sample up to which the driver may wait, every sample in between also avoiding contact; if
    not, the last sample before `braking` that would avoid it, else the first after it; `NEVER` if there is none.
    """
    as_hard: bool
    """True if the ego itself braked at least as hard: the reference driver stays no farther behind."""
    helpless: bool
    """True if no sample avoids contact, nor does full braking without a ramp from the first sample on."""
    too_late: bool
    """True if the scene begins too late: the ego drives, and either the conflict is in sight at the first sample, or
    the ego collides even with full braking from that sample on.
    """


class Replayed(NamedTuple):
    """A case as recorded, from which every drive of the reference driver begins."""

    case: Case
    contact: int
    """Sample after first contact."""
    until: int
    """Last sample of a drive."""
    outlines: Floats
    path: Floats
    """(until + 1, PATH_COLUMNS) path of the ego."""
    own: Floats
    """(n, len(State)) motion of the ego."""
    recorded: bool
    """True if `Run.states` holds the motion of the others in every drive."""
    checkpoints: Checkpoints
    """Samples from which a drive continues; without rows, each begins anew."""


class Braked(NamedTuple):
    """Result of one drive of the reference driver."""

    touched: bool
    at: int
    """Sample of the comparison with the case: that of contact, or the last before the contact of the case."""
    way: float
    """Arc length of the ego along the path at that sample [m]."""
    speed: float
    """Speed of the ego at contact, or at the end [m/s]."""


@kernel
def resimulate_with_reference(plan: Plan, memory: DriveMemory, case: Case, driver: Driver) -> ReferenceDrive:
    """Drive a case as it was, find when its conflict is perceived, and drive it again with the reference driver."""
    run, outlines, path = memory.run, memory.outlines, memory.path
    if not collides(plan, run, memory, case):
        return ReferenceDrive(NEVER, math.nan, NEVER, NEVER, NEVER, False, NEVER, False, False, False)
    note_outlines(plan, run, outlines)
    contact, other = int(run.status[Status.SAMPLE]), int(run.status[Status.CONTACT_OTHER])
    time, time_step = run.end[0], plan.layout.time_step
    fault = found_fault(plan, run, outlines)
    driver = in_its_car(plan, run, driver)
    until = carry_on(plan, run, memory, driver)
    path = path[: until + 1]
    perceived = perceive(plan, run, contact, other, outlines, path, driver)
    starts_in_it = is_in_sight(plan, run, 0, other, outlines, path, driver)
    driving = abs(run.states[0, 0, State.SPEED]) > STANDING
    if memory.independent and memory.touching:
        record_others(plan, run, memory, case, contact, until)
    again = Replayed(case, contact, until, outlines, path, memory.own, memory.independent, memory.checkpoints)
    braking = contact if perceived == NEVER else perceived + first_sample(driver.reaction, time_step)
    begun = min(braking, contact)
    drive = brake_from(plan, run, again, begun, driver)
    as_hard = drive.touched and braking < contact - 1 and path[drive.at, WAY] <= drive.way + 1e-6
    as_hard = as_hard and _brakes_before(path, drive.at)
    latest = _latest(plan, run, again, begun, not drive.touched, driver)
    helpless, too_late = False, False
    if latest == NEVER:
        start = min(begun, 0)  # no literal zero: numba would compile `advance` once more, for nearly a minute
        at_once = brake_from(plan, run, again, start, brakes_like(driver, driver.deceleration, 0.0))
        helpless = at_once.touched
        too_late = helpless and driving and (starts_in_it or at_once.speed > STANDING)
    if perceived == NEVER:
        return ReferenceDrive(contact, time, fault, NEVER, NEVER, False, NEVER, False, helpless, too_late)
    avoided = not drive.touched
    return ReferenceDrive(contact, time, fault, perceived, braking, avoided, latest, as_hard, helpless, too_late)


@kernel
def reference_rows(
    plan: Plan, scenes: Requested, reach: Floats, window: Window, memory: DriveMemory, driver: Driver, out: Floats
) -> None:
    """Write the `ReferenceDrive` of each valid scene of a window into `out` (n, fields); `reach` (n,): sight of each
    ego [m].
    """
    for row in range(window.first, window.last):
        if scenes.verdict[row] == Verdict.VALID:
            case = Case(int(scenes.variant[row]), scenes.values[row], scenes.keys[row], scenes.actions[row])
            again = resimulate_with_reference(plan, memory, case, limited_to(driver, min(driver.reach, reach[row])))
            out[row, 0], out[row, 1], out[row, 2] = again.contact, again.time, again.fault
            out[row, 3], out[row, 4], out[row, 5] = again.perceived, again.braking, again.avoided
            out[row, 6], out[row, 7], out[row, 8] = again.latest, again.as_hard, again.helpless
            out[row, 9] = again.too_late


@inlined
def collides(plan: Plan, run: Run, memory: DriveMemory, case: Case) -> bool:
    """Run a case as recorded up to the end of the scored run; return True if the ego collides.

    The state at each sample is stored if there are checkpoints.
    """
    begin(plan, run, case.variant, case.values, case.key, case.actions)
    scored, sample = run.status[Status.END] == RUNNING, 0  # not the literal True: numba would compile `advance` again
    count = len(memory.checkpoints.states)
    while run.status[Status.END] == RUNNING:
        if count > 0:
            _store(run, memory.checkpoints, sample)
        sample = sample + 1 if count > 0 else plan.layout.last_sample + 1
        advance(plan, run, sample, scored)
    return run.status[Status.END] == EndReason.COLLISION


@inlined
def _store(run: Run, to: Checkpoints, k: int) -> None:
    """Store the state of a run at the sample k, before its turns."""
    copy_row(run.registers, to.registers[k])
    copy_row(run.resume, to.resume[k])
    copy_row(run.status, to.status[k])
    copy_row(run.end, to.end[k])
    _copy_rows(run.actors, to.actors[k])
    _copy_rows(run.segments, to.segments[k])
    _copy_rows(run.impacts, to.impacts[k])
    _copy_rows(run.states[k], to.states[k])
    if k > 0:
        _copy_rows(run.states[k - 1], to.record[k - 1])


@kernel
def _restore(run: Run, since: Checkpoints, k: int) -> None:
    """Restore the state of a run at the sample k; its key and its decisions are the same in all drives."""
    copy_row(since.registers[k], run.registers)
    copy_row(since.resume[k], run.resume)
    copy_row(since.status[k], run.status)
    copy_row(since.end[k], run.end)
    run.status[Status.SHADED] = -1
    _copy_rows(since.actors[k], run.actors)
    _copy_rows(since.segments[k], run.segments)
    _copy_rows(since.impacts[k], run.impacts)
    for sample in range(k):
        _copy_rows(since.record[sample], run.states[sample])
    _copy_rows(since.states[k], run.states[k])


@inlined
def _copy_rows(source: Floats, target: Floats) -> None:
    for row in range(min(len(source), len(target))):
        copy_row(source[row], target[row])


@inlined
def _brakes_before(path: Floats, sample: int) -> bool:
    """Return True if the ego itself brakes before a sample.

    A loop, since `max` of an array has the cached code import scipy: 0.7 s of CPU time on the first call.
    """
    for k in range(sample):  # noqa: SIM110 - a kernel has no generators
        if path[k, OWN] > COASTING:
            return True
    return False


@inlined
def found_fault(plan: Plan, run: Run, outlines: Floats) -> int:
    """Return the `Fault` of the contact at which a run has just ended."""
    contact, other = int(run.status[Status.SAMPLE]), int(run.status[Status.CONTACT_OTHER])
    if has_levels(plan):
        measure_on_levels(plan, run, contact + 1)
    met = measure_pair(run.states, contact, plan.layout.time_step, other, outlines, True, run.end[1])
    fault = fault_of(
        run.states, contact - 1, plan.layout.time_step, other, outlines, met, plan.road, plan.layout.intersections
    )
    if has_levels(plan):
        restore_levels(plan, run, contact + 1)
    return fault


@inlined
def carry_on(plan: Plan, run: Run, memory: DriveMemory, driver: Driver) -> int:
    """Continue a run after its contact, for as long as drives are followed, and keep path and motion of the ego; return
    the last sample.
    """
    contact, path = int(run.status[Status.SAMPLE]), memory.path
    end = min(contact + _following(run.states, contact, plan.layout.time_step, driver), len(path) - 1)
    advance(plan, run, end, run.status[Status.END] == RUNNING)
    until = int(run.status[Status.SAMPLE])
    lay_path(run.states, until + 1, path, plan.layout.time_step)
    for k in range(until + 1):
        copy_row(run.states[k, 0], memory.own[k])
    if has_levels(plan):
        trace_levels(plan, run, until + 1)
    return until


@inlined
def copy_row(source: Floats | Ints, target: Floats | Ints) -> None:
    for column in range(len(source)):
        target[column] = source[column]


@kernel
def record_others(plan: Plan, run: Run, memory: DriveMemory, case: Case, contact: int, until: int) -> None:
    """Record the others anew up to the sample `until`, past the contact of the ego, with impacts among them."""
    begin(plan, run, case.variant, case.values, case.key, case.actions)
    scored = run.status[Status.END] == RUNNING
    advance(plan, run, contact - 1, scored)
    run.actors[0, Memory.FREE] = REPLACED
    for k in range(contact - 1, until):
        copy_row(memory.own[k + 1], run.states[k + 1, 0])
        advance(plan, run, k + 1, not scored)
    if has_levels(plan):
        trace_levels(plan, run, until + 1)


@inlined
def _following(states: Floats, contact: int, time_step: float, driver: Driver) -> int:
    """Return the number of samples after contact until the driver has stopped, whenever braking begins."""
    fastest = 0.0
    for k in range(contact):
        fastest = max(fastest, abs(states[k, 0, State.SPEED]))
    stopping = fastest / driver.deceleration + driver.ramp if driver.deceleration > 0.0 else math.inf
    return first_sample(min(max(AFTERWARDS, stopping), LONGEST), time_step)


@inlined
def in_its_car(plan: Plan, run: Run, driver: Driver) -> Driver:
    """Return the reference driver with brakes and tyres of the ego, including the build-up time of its pedal."""
    vehicle, build_up = vehicle_of(plan, run, 0), column_of(plan, run, 0, Column.PEDAL_TIME)
    on_foot = plan.kinds[0] == ActorKind.PEDESTRIAN
    hardest = vehicle.max_braking if on_foot else min(vehicle.max_braking, vehicle.grip)
    braking = min(driver.deceleration, hardest)
    share = braking / vehicle.max_braking if vehicle.max_braking > 0.0 else 0.0
    return brakes_like(driver, braking, max(driver.ramp, build_up * share))


@inlined
def limited_to(driver: Driver, reach: float) -> Driver:
    """Return the same driver with a distance of sight of at most `reach` [m]."""
    return Driver(
        driver.perception, driver.reaction, driver.deceleration, driver.ramp, driver.horizon, driver.alarming, reach
    )


@inlined
def brakes_like(driver: Driver, braking: float, ramp: float) -> Driver:
    """Return the same driver with other brakes [m/s^2] and ramp [s]."""
    return Driver(driver.perception, driver.reaction, braking, ramp, driver.horizon, driver.alarming, driver.reach)


# -- the reference driver ---------------------------------------------------------------------------------------------


@kernel
def brake_from(plan: Plan, run: Run, again: Replayed, braking: int, driver: Driver) -> Braked:
    """Drive a case as recorded up to the sample `braking`, then brake along the path up to `again.until`."""
    contact, outlines, path = again.contact, again.outlines, again.path
    time_step, states = plan.layout.time_step, run.states
    if braking >= contact:
        return Braked(True, contact - 1, path[contact - 1, WAY], 0.0)
    scored = start_from(plan, run, again, braking)
    way, speed = path[braking, WAY], abs(states[braking, 0, State.SPEED])
    held = path[max(braking - 1, 0), OWN]
    at, way_then = braking, way
    for k in range(braking, again.until):
        middle = (k - braking + 0.5) * time_step
        held = max(held, path[k, OWN]) if k < contact else held
        slower = max(0.0, speed - max(min(held, driver.deceleration), pressed(driver, middle)) * time_step)
        way += 0.5 * (speed + slower) * time_step
        speed = slower
        place_ego(states, k + 1, path, way, outlines, speed)
        if not again.recorded:
            advance(plan, run, k + 1, not scored)
        elif has_levels(plan):
            follow_levels(plan, run, k + 1)
        if k + 1 < contact:
            at, way_then = k + 1, way
        if touches(run, k, outlines):
            return Braked(True, at, way_then, speed)
    return Braked(False, at, way_then, speed)


@inlined
def start_from(plan: Plan, run: Run, again: Replayed, sample: int) -> bool:
    """Bring the run to a sample of the case, from which the ego is placed; return whether its steps so far counted."""
    case = again.case
    resumes = not again.recorded and len(again.checkpoints.states) > 0
    if resumes:
        _restore(run, again.checkpoints, sample)
    elif not again.recorded:
        begin(plan, run, case.variant, case.values, case.key, case.actions)
    scored = again.recorded or run.status[Status.END] == RUNNING
    if again.recorded:
        copy_row(again.own[sample], run.states[sample, 0])
        if has_levels(plan):
            recall_levels(plan, run, sample)
    else:
        advance(plan, run, sample, scored)  # no step if the run is there already
        run.actors[0, Memory.FREE] = REPLACED
    return scored


@inlined
def pressed(driver: Driver, time: float) -> float:
    """Return the driver's deceleration `time` [s] after the first touch of the pedal [m/s^2]."""
    return driver.deceleration * (min(1.0, time / driver.ramp) if driver.ramp > 0.0 else 1.0)


@inlined
def place_ego(states: Floats, sample: int, path: Floats, way: float, outlines: Floats, speed: float) -> None:
    """Write the state of the ego after a way along its recorded path."""
    pose, course = pose_at(path, way, outlines[0, 0], outlines[0, 1]), path[reached(path, way) + 1, COURSE]
    put(states, sample, pose, course * speed)


@inlined
def put(states: Floats, sample: int, pose: Box, speed: float) -> None:
    for column in range(states.shape[2]):
        states[sample, 0, column] = 0.0
    states[sample, 0, State.X], states[sample, 0, State.Y] = pose.x, pose.y
    states[sample, 0, State.HEADING], states[sample, 0, State.SPEED] = pose.heading, speed
    states[sample, 0, State.PRESENT] = 1.0


@inlined
def touches(run: Run, k: int, outlines: Floats) -> bool:
    """Return True if the ego touches any actor in the step after sample k; heights are those after the step."""
    states, touched = run.states, False
    for other in range(1, states.shape[1]):
        present = states[k, other, State.PRESENT] != 0.0 and states[k + 1, other, State.PRESENT] != 0.0
        if present and on_one_level(run, 0, other):
            ego, ego_after = outline_at(states, k, 0, outlines), outline_at(states, k + 1, 0, outlines)
            them, after = outline_at(states, k, other, outlines), outline_at(states, k + 1, other, outlines)
            touched = touched or first_contact(ego, ego_after, them, after) >= 0.0
    return touched


@kernel
def _latest(plan: Plan, run: Run, again: Replayed, braking: int, avoided: bool, driver: Driver) -> int:
    """Return the last or nearest sample at which braking avoids contact; see `ReferenceDrive.latest`."""
    if avoided:
        for k in range(braking + 1, again.contact):
            if brake_from(plan, run, again, k, driver).touched:
                return k - 1
        return again.contact - 1
    for k in range(braking - 1, -1, -1):
        if not brake_from(plan, run, again, k, driver).touched:
            return k
    for k in range(braking + 1, again.contact):
        if not brake_from(plan, run, again, k, driver).touched:
            return k
    return NEVER
