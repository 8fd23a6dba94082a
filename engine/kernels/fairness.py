"""Fair starts: scenes in which an ego that brakes at once collides with nobody by its own fault.

The driver is that of `engine.kernels.avoidance` without times of perception and reaction: full braking from sample 0
on, as the ramp permits, along the path that the ego takes by itself without contact. Contact counts against the start
while the ego moves, unless the other comes from behind: an ego struck from behind, or while standing, was free to start
there. The first contact decides.
"""

from engine.kernels.approach import first_contact
from engine.kernels.avoidance import LONGEST, Case, DriveMemory, in_its_car, pressed, put
from engine.kernels.fault import STANDING
from engine.kernels.geometry import outline_at
from engine.kernels.jit import inlined, kernel
from engine.kernels.pair import REAR, side_of
from engine.kernels.perception import COURSE, Driver, first_sample, lay_path, pose_at, reached
from engine.kernels.rollout import advance, begin
from engine.kernels.rows import Requested, Window, note_outlines
from engine.kernels.run_state import REPLACED, RUNNING, Memory, Plan, Run, Status, on_one_level
from engine.tables import Floats, Ints
from engine.vocabulary import State, Verdict

NOBODY, BEHIND, IN_THE_WAY = range(3)
"""Contact of the ego, in ascending order of severity."""


@kernel
def fair_rows(plan: Plan, scenes: Requested, window: Window, memory: DriveMemory, driver: Driver, out: Ints) -> None:
    """Write 1 for each valid scene of a window that is a fair start, else 0."""
    for row in range(window.first, window.last):
        if scenes.verdict[row] == Verdict.VALID:
            case = Case(int(scenes.variant[row]), scenes.values[row], scenes.keys[row], scenes.actions[row])
            out[row] = 1 if _is_fair(plan, memory, case, driver) else 0


@kernel
def _is_fair(plan: Plan, memory: DriveMemory, case: Case, driver: Driver) -> bool:
    run, outlines, path = memory.run, memory.outlines, memory.path
    begin(plan, run, case.variant, case.values, case.key, case.actions)
    if run.states[0, 0, State.PRESENT] == 0.0:
        return True
    note_outlines(plan, run, outlines)
    unscored = run.status[Status.END] != RUNNING  # no literal truth: numba would compile `advance` once more
    driver, speed = in_its_car(plan, run, driver), abs(run.states[0, 0, State.SPEED])
    until = _standstill(speed, plan.layout.time_step, len(path) - 1, driver)
    advance(plan, run, until, unscored)
    lay_path(run.states, until + 1, path, plan.layout.time_step)
    begin(plan, run, case.variant, case.values, case.key, case.actions)
    run.actors[0, Memory.FREE] = REPLACED
    return not _strikes(plan, run, until, outlines, path[: until + 1], driver)


@inlined
def _standstill(speed: float, time_step: float, most: int, driver: Driver) -> int:
    """Return the sample at which the ego has stopped."""
    stopping = speed / driver.deceleration + driver.ramp if driver.deceleration > 0.0 else LONGEST
    return min(first_sample(min(stopping, LONGEST), time_step), most)


@inlined
def _strikes(plan: Plan, run: Run, until: int, outlines: Floats, path: Floats, driver: Driver) -> bool:
    """Return True if the ego, braking along its path, first touches an actor ahead or at its side while it moves."""
    time_step, states = plan.layout.time_step, run.states
    way, speed, met = 0.0, abs(states[0, 0, State.SPEED]), NOBODY
    for k in range(until):
        if met != NOBODY or speed < STANDING:
            break
        slower = max(0.0, speed - pressed(driver, (k + 0.5) * time_step) * time_step)
        way += 0.5 * (speed + slower) * time_step
        course = path[reached(path, way) + 1, COURSE]
        put(states, k + 1, pose_at(path, way, outlines[0, 0], outlines[0, 1]), course * slower)
        advance(plan, run, k + 1, run.status[Status.END] != RUNNING)
        for other in range(1, states.shape[1]):
            present = states[k, other, State.PRESENT] != 0.0 and states[k + 1, other, State.PRESENT] != 0.0
            if present and on_one_level(run, 0, other):
                met = max(met, _met(states, k, other, outlines))
        speed = slower
    return met == IN_THE_WAY


@inlined
def _met(states: Floats, k: int, other: int, outlines: Floats) -> int:
    """Return the contact of the ego with another in the step after sample k: `NOBODY`, `BEHIND` or `IN_THE_WAY`."""
    ego, them = outline_at(states, k, 0, outlines), outline_at(states, k, other, outlines)
    ego_after, after = outline_at(states, k + 1, 0, outlines), outline_at(states, k + 1, other, outlines)
    if first_contact(ego, ego_after, them, after) < 0.0:
        return NOBODY
    return BEHIND if side_of(ego, them) == REAR else IN_THE_WAY
