"""Inputs and memory of runs: `Plan` is shared by all runs of a program, `Run` is the memory of a single run.

Registers of step code: literals | variant values | scene values | locals | temporaries. The scene values begin with one
block of `vocabulary.Column` per actor, so that engine and behaviours read an actor's properties at the same place.
"""

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from engine.handles import Slots, handle, slotted
from engine.kernels.bicycle import GRAVITY, Vehicle, clip
from engine.kernels.geometry import Box
from engine.kernels.jit import inlined
from engine.kernels.swept import Swept
from engine.tables import Floats, Ints, RoadTables
from engine.vocabulary import LEVEL, Column, State

COLUMNS = len(Column)


@handle
class Layout(NamedTuple):
    """Places in the registers, and numbers that govern a run."""

    variant_values: int
    """First register of the variant values."""
    scene_values: int
    """First register of the scene values."""
    locals: int
    """First register of the locals."""
    time_step: float
    """[s]"""
    last_sample: int
    """The sample at which the time limit ends a run."""
    budget: int
    """Maximum number of instructions in a turn."""
    intersections: int
    """Last region of the road that is an intersection; the first is 1."""
    lasting: int
    """1 if temporal requirements, objectives or records are declared, so that a run continues for the ego alone."""
    restitution: float
    """Restitution of impacts between other actors."""
    contact_friction: float
    """Friction between outlines in contact."""
    rolling: float
    """Rolling resistance of wheels without a driver, as a share of their load."""
    judged: int
    """1 if objectives are declared, so that rules are evaluated once more at the ego's first contact."""
    drivers_go_on: int
    """1 if the driver of a struck body continues once its wheels grip again."""
    hold: int
    """Steps from a turn of rules, monitors and behaviours to the next; 1 unless a run is repeated in finer steps."""
    pedals_stay: int
    """1 if pedals stay as last set, 0 if they are released before each turn."""
    pause: int
    """Turns from a pause of a run, for external decisions, to the next; 0: no pauses."""
    measures: int
    """`Measure`s of a run that are computed."""


@handle
class Plan(NamedTuple):
    """Everything about a program that its runs read; made by `engine.host.plan`."""

    code: Ints
    """(n * ROW_WIDTH,) `CodeTables.step_code`, row after row, with fused instructions (`engine.host.fuse`)."""
    pool: Floats
    variant_values: Floats
    """(variants, n_variant_values)"""
    variant_template: Ints
    """(variants,)"""
    entries: Ints
    """(templates, actors) `CodeTables.behaviour_entry`."""
    main_blocks: Ints
    """(templates, actors)"""
    rules: Ints
    """(templates, rules, 3) `CodeTables.rule_segment`."""
    rule_kinds: Ints
    """(rules,) `RuleKind`"""
    formula: Ints
    """(n, 3) `CodeTables.formula`."""
    temporal_root: Ints
    """(temporals,)"""
    temporal_rule: Ints
    """(temporals,)"""
    objective_root: Ints
    """(objectives,) `ObjectiveTables.root`"""
    objective_segment: Ints
    """(templates, objectives, 3) `ObjectiveTables.segment`"""
    readings: Ints
    """(readings, 2) `Reducer`, and a rule, or for RESULT a row of `engine.judged`."""
    monitors: Ints
    """(templates, monitors) `CodeTables.monitor_entry`."""
    monitor_blocks: Ints
    """(templates, monitors)"""
    monitor_started: Ints
    """(monitors,) `Turns`: the monitors that run from the start, and the place of their turns."""
    present: Ints
    """(actors,) 1 for those that take part from the start."""
    kinds: Ints
    """(actors,) `ActorKind`"""
    gyration: Floats
    """(actors,): yaw inertia over mass times the squared diagonal of the outline."""
    slides: Ints
    """(actors,) 1 for cars with slipping tyres (`kernels.dynamics`), in runs that are repeated to explain them."""
    road: RoadTables
    layout: Layout


class Memory(IntEnum):
    """Columns of `Run.actors`: state that an actor carries between samples in addition to its recorded state."""

    REAR_X = 0
    """Middle of the rear axle [m]; it is integrated itself, which avoids rounding by conversion from the centre."""
    REAR_Y = 1
    COS = 2
    """Cosine of the heading."""
    SIN = 3
    THROTTLE = 4
    """Pedals of this step."""
    BRAKE = 5
    STEER = 6
    """Last demanded steering angle [rad]; stays until the next."""
    SET_SPEED = 7
    """Speed to assume at once [m/s], or `NO_SPEED`."""
    LEFT_ROAD = 8
    """Time at which the centre was first outside the road [s]; NaN if never."""
    ROUTE_DONE = 9
    """1 while the path followed last has been followed to its end."""
    LEAVING = 10
    """1 once the actor's part in the scene is over: absent from the next sample on."""
    FREE = 11
    """0: driven; 1: released after an impact between others, moved by `kernels.impacts.motion`; else moved from
    outside.
    """
    AWAITED = 12
    """1 for an actor that has not entered the scene yet."""
    DRIFT_SPEED = 13
    """Speed of the centre [m/s] of a car with slipping tyres, and angle from its heading to its motion [rad]."""
    DRIFT_ANGLE = 14
    YAW_RATE = 15
    """Yaw rate and wheel speeds of a car with slipping tyres [rad/s]."""
    FRONT_WHEEL = 16
    REAR_WHEEL = 17
    REVERSE = 18
    """1 in reverse gear; stays until the next change. `vocabulary.FOR_ONE_STEP`: in this turn only."""
    OFFSET = 19
    """Offset to the left of its path at which an actor follows it in this step [m]."""
    PATH = 20
    """1 + the path that its driver followed last; 0: none."""
    TRACK = 21
    """1 + the place in the pool of the recorded track that it follows in this turn; 0: none."""
    TRACK_TIME = 22
    """Time of the track at the begin of the turn [s], and the factor at which that time passes."""
    PACE = 23
    STOP = 24
    """Brake pedal of this step only, for pedals that stay; the earlier demand stays in force too."""
    INSIDE = 25
    """1 for an actor that overlapped another, except the ego, when the later of the two entered the scene; else 0; -1
    until others first touch.
    """
    ASIDE = 26
    """Offset to the left of its path that an actor approaches along a curve [m], in this turn, or `NO_OFFSET`."""
    CURVE_OWNER = 27
    """1 + the register of progress of the follower that began the curve; 0: no curve."""
    CURVE_START = 28
    """Arc length at which the curve begins [m], offset [m] and slope there, and length of the curve [m]."""
    CURVE_OFFSET = 29
    CURVE_SLOPE = 30
    CURVE_LENGTH = 31
    HEIGHT = 32
    """Height of the road at the actor [m] (`kernels.levels`); 0 on a road without bridges."""


POST_IMPACT, HOSTED, REPLACED = 1.0, 2.0, 3.0
"""Values of `Memory.FREE`. While another driver moves the ego (`REPLACED`), impacts act on the others as usual."""


class Status(IntEnum):
    """Entries of `Run.status`."""

    SAMPLE = 0
    """The current sample k; `states[: k + 1]` are recorded."""
    END = 1
    """`EndReason` of the scored run, or `RUNNING`."""
    DETAIL = 2
    """Rule that ended the run, or row of step code at which its budget ended; else -1."""
    CONTACT_ONE = 3
    """The ego and the actor that it touched, or -1."""
    CONTACT_OTHER = 4
    TEMPLATE = 5
    DRAWS = 6
    """Random numbers that behaviours have drawn."""
    SHADED = 7
    """Sample of the outlines in `Run.shades`, or -1."""
    OTHERS_ONE = 8
    """First two actors in contact without the ego, lower actor first, or -1."""
    OTHERS_OTHER = 9
    IMPACTS = 10
    """Rows of `Run.impacts` that are filled."""
    AT_CONTACT = 11
    """1 while the row of the current sample holds the instant of the ego's first contact."""
    PAUSED = 12
    """1 between the rules and the turns of a sample, while external drivers are asked."""
    TURN = 13
    """Actor of the current turn."""
    ARRIVALS = 14
    """Number of ways that reached their ends in this turn."""
    UNTOLD = 15
    """1 after anything but stored commands has moved an actor."""


RUNNING = -1
"""No end yet."""
NO_OFFSET = NO_SPEED = -1e300
"""No speed and no offset was set. (Not NaN: a number that is NaN must break the run.)"""


@slotted("registers", "resume", "actors", "status", "end", "key")
class Run(NamedTuple):
    """The memory of a run; created by `engine.host.memory`, filled by `rollout.begin`, used again for the next."""

    states: Floats
    """(samples, actors, len(State)): the record. Row 0 is the start; the row after the current one may be written."""
    registers: Floats
    resume: Ints
    """(blocks,): row at which each block continues, -1 while it is not running."""
    actors: Floats
    """(actors, len(Slot))"""
    status: Ints
    """(len(Status),) int64"""
    end: Floats
    """(3,): time of the ego's first contact or the end of the scored run [s]; the part of the last step before it, in
    (0, 1] for contact, 0 for an end at a sample; and the time of the first contact of two others [s], NaN: never.
    """
    segments: Floats
    """(actors, len(MotionSegment)); no rows in parallel runs in which only the ego can be struck."""
    impacts: Floats
    """(MAX_IMPACTS, len(ImpactRecord)), of which `Status.IMPACTS` rows are filled."""
    key: Ints
    """(6,) int64: `StreamKey` of the scene."""
    watched: Floats
    """(samples, rules): value of every rule of kind WATCH at each sample up to the end of the scored run; other columns
    are undefined. No rows without such rules.
    """
    formula_values: Floats
    """(2, formula rows): working memory for `kernels.temporal`."""
    formula_decided: Ints
    """(temporals,) int64: working memory for `kernels.temporal`."""
    beyond: Floats
    """(actors, len(State)): the row of the sample after contact, while its place holds the instant of contact; empty
    without objectives.
    """
    final: Floats
    """(registers,): registers for the evaluation when the run is over; empty without objectives."""
    shades: Floats
    """(actors * `tables.SHADE`,): the outlines that hide, of the sample `Status.SHADED`."""
    areas: Floats
    """(actors * actors, `crossing.KEPT`): the last search for the area of each two actors."""
    swept: Swept
    """Working memory for conflict gaps, for motions of one sample where none are measured."""
    sweep_order: Ints
    """(actors,): all actors, sorted by the beginnings of their spans in the last step (`impacts.sweep`)."""
    sweep_spans: Floats
    """(actors, 2): beginning and end of the span of each actor in the step, on one axis [m]."""
    actions: Floats
    """(samples, numbers): external decisions, turn by turn (`Op.ACTION`); no rows if a program has none."""
    command_columns: Ints
    """(actors,): first column of the commands of an actor, or -1 - its first number among `actions`; no entries if
    states are stored in place of commands.
    """
    heights: Floats
    """(samples + 1, 2 * actors): working memory for `kernels.levels`; no rows without levels."""
    slot_registers: Floats
    """(slots, ...) of the parallel runs: the arrays that differ between their states; no slots in a single run."""
    slot_actors: Floats
    slot_end: Floats
    slot_key: Ints
    slot_resume: Ints
    slot_status: Ints
    slot_states: Floats
    """(slots, rows, actors, len(State)): the current sample, and earlier samples that a driver still reads. Sample k is
    in row k % rows, with rows a power of two.
    """
    slot_watched: Floats
    """(slots, rules): values at the last sample at which rules were evaluated."""
    slot_touching: Floats
    """(slots, rules): values at the ego's first contact; no slots without objectives."""
    slot_segments: Floats
    """(slots, actors, len(MotionSegment)): segments of released bodies; no rows if other actors cannot touch."""
    slot_actions: Floats
    """(slots, rows, numbers): decisions for the coming turns; turn k in row k % rows, with rows a power of two."""
    slot_pages: Ints
    """(slots, n): numbers of the pages of each slot, in order; -1: none."""
    command_pages: Floats
    """(pages, slots.PAGE, pause, columns): commands or states of each step, then the values of the rules if they are
    judged after the run (`slots.note_commands`).
    """
    slots: "Slots[Run]" = Slots()
    """The states of the parallel runs: handles with rows of the first six `slot_` fields, which share all other arrays.
    Pages are read from the run that owns the memory: they may move in memory between calls.
    """


@inlined
def column_of(plan: Plan, run: Run, actor: int, column: int) -> float:
    """Return a property of an actor in this scene."""
    return run.registers[np.uintp(plan.layout.scene_values + actor * COLUMNS + column)]


@inlined
def current_sample(run: Run) -> int:
    """Return the current sample. The compiler learns that it is not negative, so that no index counts from the end.

    Instructions read it from memory: for a variable the compiler would compute before each turn everything that any
    instruction might derive from it.
    """
    return int(np.int64(np.uint32(run.status[Status.SAMPLE])))


@inlined
def vehicle_of(plan: Plan, run: Run, actor: int) -> Vehicle:
    """Return the vehicle parameters of an actor."""
    return Vehicle(
        wheelbase=column_of(plan, run, actor, Column.WHEELBASE),
        max_steer=column_of(plan, run, actor, Column.MAX_STEER),
        steer_rate=column_of(plan, run, actor, Column.STEER_RATE),
        max_acceleration=column_of(plan, run, actor, Column.MAX_ACCELERATION),
        max_braking=column_of(plan, run, actor, Column.MAX_BRAKING),
        grip=GRAVITY * column_of(plan, run, actor, Column.FRICTION),
        max_speed=column_of(plan, run, actor, Column.TOP_SPEED),
    )


@inlined
def outline_of(plan: Plan, run: Run, sample: int, actor: int) -> Box:
    """Return an actor's outline at a recorded sample."""
    return Box(
        run.states[sample, actor, State.X],
        run.states[sample, actor, State.Y],
        run.states[sample, actor, State.HEADING],
        column_of(plan, run, actor, Column.LENGTH),
        column_of(plan, run, actor, Column.WIDTH),
    )


@inlined
def on_one_level(run: Run, one: int, other: int) -> bool:
    """Return True if two actors are on one level at the sample of their `Memory.HEIGHT`: the current sample, or that to
    which `kernels.levels` has set the heights.
    """
    return abs(run.actors[one, Memory.HEIGHT] - run.actors[other, Memory.HEIGHT]) < LEVEL


@inlined
def place(plan: Plan, run: Run, sample: int, actor: int, present: float) -> None:
    """Put an actor where its scene has it, from this sample on or (`present` = 0) for later; none starts backwards."""
    states = run.states
    states[sample, actor, :] = 0.0
    x, y = column_of(plan, run, actor, Column.X), column_of(plan, run, actor, Column.Y)
    heading = column_of(plan, run, actor, Column.HEADING)
    states[sample, actor, State.X] = x
    states[sample, actor, State.Y] = y
    states[sample, actor, State.HEADING] = heading
    top_speed = column_of(plan, run, actor, Column.TOP_SPEED)
    speed = column_of(plan, run, actor, Column.SPEED)
    states[sample, actor, State.SPEED] = clip(speed, 0.0, top_speed) if speed < math.inf else speed  # breaks the run
    states[sample, actor, State.PRESENT] = present
    to_center = column_of(plan, run, actor, Column.REAR_TO_CENTER)
    cos, sin = math.cos(heading), math.sin(heading)
    run.actors[actor, :] = 0.0
    run.actors[actor, Memory.REAR_X] = x - to_center * cos
    run.actors[actor, Memory.REAR_Y] = y - to_center * sin
    run.actors[actor, Memory.COS], run.actors[actor, Memory.SIN] = cos, sin
    run.actors[actor, Memory.LEFT_ROAD] = math.nan
    run.actors[actor, Memory.ASIDE] = NO_OFFSET
    run.actors[actor, Memory.AWAITED] = 1.0 - present
    run.actors[actor, Memory.INSIDE] = -1.0


@inlined
def end_run(plan: Plan, run: Run, reason: int, detail: int, part_of_step: float) -> None:
    """Note how and when the scored run ended: in the current sample, or in a part of the step after it."""
    run.status[Status.END] = reason
    run.status[Status.DETAIL] = detail
    run.end[0] = (run.status[Status.SAMPLE] + part_of_step) * plan.layout.time_step
    run.end[1] = part_of_step
