"""What a run reads and what it writes: `Plan` is shared by all runs of a program, `Run` is the memory of one.

Registers of step code: literals | variant values | scene values | locals | temporaries. The scene values begin with
one block of `vocabulary.Column` per actor, so an actor's properties are read where behaviours read them too.
"""

import math
from enum import IntEnum
from typing import NamedTuple

from engine.handles import Slots, handle, slotted
from engine.kernels.bicycle import GRAVITY, Vehicle, clip
from engine.kernels.geometry import Box
from engine.kernels.jit import inlined
from engine.tables import Floats, Ints, RoadTables
from engine.vocabulary import Column, State

COLUMNS = len(Column)


@handle
class Layout(NamedTuple):
    """Where things lie in the registers, and the numbers that govern a run."""

    variant_values: int
    """First register of the variant values …"""
    scene_values: int
    """… of the scene values …"""
    locals: int
    """… and of the locals."""
    time_step: float
    """[s]"""
    last_sample: int
    """The sample at which the time limit ends a run."""
    budget: int
    """Instructions that one turn may take."""
    intersections: int
    """Regions 1 to so many of the road are intersections."""
    lasting: int
    """1 where temporal requirements, objectives or records are declared, so that a run goes on for the ego alone."""
    restitution: float
    """Of impacts among others …"""
    contact_friction: float
    """… and the friction of outlines on one another."""
    rolling: float
    """Rolling resistance of wheels without a driver, as a share of the weight on them."""
    judged: int
    """1 where objectives are declared, so that rules are looked at once more at the ego's first contact."""
    drivers_go_on: int
    """1 where the driver of a struck body drives on once its wheels grip again."""
    hold: int
    """Steps from one turn of rules, monitors and behaviours to the next; 1 unless a run is made again in finer ones."""
    pedals_stay: int
    """1 where pedals stay as they were set last, 0 where they are let go before each turn."""
    pause: int
    """Turns from one pause of a run to the next, in which its drivers are asked outside; 0: it never pauses."""


@handle
class Plan(NamedTuple):
    """Everything about a program that its runs read; made by `engine.host.plan`."""

    code: Ints
    """(n, 6) `CodeTables.step_code`."""
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
    """(readings, 2) `Reducer`, and a rule, or of RESULT a row of `engine.named_results`."""
    monitors: Ints
    """(templates, monitors) `CodeTables.monitor_entry`."""
    monitor_blocks: Ints
    """(templates, monitors)"""
    monitor_started: Ints
    """(monitors,) `Turns`: which of them run from the start, and when their turns come."""
    present: Ints
    """(actors,) 1 for those that take part from the start."""
    kinds: Ints
    """(actors,) `ActorKind`"""
    gyration: Floats
    """(actors,): yaw inertia over mass times the squared diagonal of the outline."""
    slides: Ints
    """(actors,) 1 for those whose tyres slip (`kernels.dynamics`), in runs that are made again to see why."""
    road: RoadTables
    layout: Layout


class Memory(IntEnum):
    """Columns of `Run.actors`: what an actor carries from sample to sample beside its recorded state."""

    REAR_X = 0
    """Middle of the rear axle [m]; what is integrated, so that no rounding is made by going through the centre."""
    REAR_Y = 1
    COS = 2
    """Of the heading."""
    SIN = 3
    THROTTLE = 4
    """Pedals of this step."""
    BRAKE = 5
    STEER = 6
    """Steering angle last asked for [rad]; stays until the next."""
    SET_SPEED = 7
    """Speed to take at once [m/s], or `NO_SPEED`."""
    LEFT_ROAD = 8
    """When the centre was first seen outside the road [s]; NaN if never."""
    ROUTE_DONE = 9
    """1 while the path followed last has been followed to its end."""
    LEAVING = 10
    """1 once the actor's way through the scene is over: absent from the next sample on."""
    FREE = 11
    """0: driven; 1: loose after an impact among others, moved by `kernels.impacts.motion`; else moved from outside."""
    AWAITED = 12
    """1 for an actor that has not come into the scene yet."""
    DRIFT_SPEED = 13
    """Of a car whose tyres slip: speed of its centre [m/s], angle from its heading to its motion [rad] …"""
    DRIFT_ANGLE = 14
    YAW_RATE = 15
    """… yaw rate and speeds of its wheels [rad/s]."""
    FRONT_WHEEL = 16
    REAR_WHEEL = 17
    REVERSE = 18
    """1 while the gear is the reverse one; stays until the next. `vocabulary.FOR_ONE_STEP`: in this turn alone."""
    OFFSET = 19
    """How far left of its path an actor is to follow it in this step [m]."""
    PATH = 20
    """1 more than the path that its driver followed last; 0: none."""
    TRACK = 21
    """1 more than the place in the pool of the recorded track that it moves along in this turn; 0: none …"""
    TRACK_TIME = 22
    """… the time of the track at the beginning of the turn [s], and how many times as fast that passes."""
    PACE = 23
    STOP = 24
    """Brake pedal of this step alone, where pedals stay; what was asked for before holds beside it."""
    INSIDE = 25
    """1 of one that was inside another, the ego left out, when the later of the two came into the scene; else 0, and -1
    until others first touch.
    """


POST_IMPACT, HOSTED, REPLACED = 1.0, 2.0, 3.0
"""Values of `Memory.FREE`. While another driver moves the ego (`REPLACED`), impacts act on the others as usual."""


class Status(IntEnum):
    """Entries of `Run.status`."""

    SAMPLE = 0
    """The current sample k; `states[: k + 1]` are recorded."""
    END = 1
    """`EndReason` of the scored run, or `RUNNING`."""
    DETAIL = 2
    """Rule that ended the run, or row of step code where it got stuck; else -1."""
    CONTACT_ONE = 3
    """The ego and whom it touched, or -1."""
    CONTACT_OTHER = 4
    TEMPLATE = 5
    DRAWS = 6
    """Random numbers that behaviours have drawn."""
    SHADED = 7
    """The sample whose outlines stand in `Run.shades`, or -1."""
    OTHERS_ONE = 8
    """The first two without the ego that touched, lower actor first, or -1."""
    OTHERS_OTHER = 9
    IMPACTS = 10
    """Rows of `Run.impacts` that are filled."""
    AT_CONTACT = 11
    """1 while the row of the current sample holds the instant of the ego's first contact."""
    PAUSED = 12
    """1 between the rules and the turns of a sample, while drivers are asked outside."""
    TURN = 13
    """The actor whose turn it is."""
    ARRIVALS = 14
    """How many ways have come to their ends in this turn."""
    UNTOLD = 15
    """1 after anything but stored commands has moved an actor."""


RUNNING = -1
"""No end yet."""
NO_SPEED = -1e300
"""No speed was set. (Not NaN: a speed that is NaN must break the run.)"""


@slotted("registers", "resume", "actors", "status", "end", "key")
class Run(NamedTuple):
    """The memory of one run; made by `engine.host.memory`, filled by `rollout.begin`, used again for the next."""

    states: Floats
    """(samples, actors, len(State)): the record. Row 0 is the start; the row after the current one may be written."""
    registers: Floats
    resume: Ints
    """(blocks,): row at which each block goes on, -1 while it is not running."""
    actors: Floats
    """(actors, len(Slot))"""
    status: Ints
    """(len(Status),) int64"""
    end: Floats
    """(3,): the ego's first contact or the end of the scored run [s]; the part of the last step that came before it, in
    (0, 1] for contact, 0 for an end at a sample; and when two others touched first [s], NaN: never."""
    segments: Floats
    """(actors, len(MotionSegment)); no rows in parallel runs in which only the ego can be struck."""
    impacts: Floats
    """(MAX_BLOWS, len(Blow)), of which `Status.IMPACTS` rows are filled."""
    key: Ints
    """(6,) int64: `StreamKey` of the scene."""
    watched: Floats
    """(samples, rules): at each sample up to the end of the scored run the value of every rule of kind WATCH; other
    columns are undefined. Without such rules there is no memory at all."""
    worth: Floats
    """(2, formula rows): working memory for `kernels.temporal` …"""
    decided: Ints
    """… (temporals,) int64, too."""
    beyond: Floats
    """(actors, len(State)): the row of the sample after contact, while the instant of contact stands there …"""
    final: Floats
    """… (registers,): those of what is worked out when the run is over; both are empty without objectives."""
    shades: Floats
    """(actors * `tables.SHADE`,): the outlines that hide, of the sample `Status.SHADED`."""
    actions: Floats
    """(samples, numbers): what is decided outside, turn by turn (`Op.ACTION`); no rows where a program decides all."""
    command_columns: Ints
    """(actors,): first column of the commands of an actor, or -1 - its first number among `actions`."""
    slot_registers: Floats
    """(slots, ...) of the parallel runs: the arrays that differ between their states; no slots in a single run."""
    slot_actors: Floats
    slot_end: Floats
    slot_key: Ints
    slot_resume: Ints
    slot_status: Ints
    slot_states: Floats
    """(slots, rows, actors, len(State)): the current sample, and earlier ones that a driver still reads. Sample k is in
    row k % rows, where rows is a power of two."""
    slot_watched: Floats
    """(slots, rules): values at the last sample at which rules were evaluated."""
    slot_segments: Floats
    """(slots, actors, len(MotionSegment)): segments of released bodies; no rows if others cannot touch."""
    slot_actions: Floats
    """(slots, rows, numbers): decisions for the coming turns; turn k in row k % rows, where rows is a power of two."""
    slot_pages: Ints
    """(slots, n): numbers of the pages of each slot, in order; -1: none."""
    command_pages: Floats
    """(pages, slots.PAGE, pause, columns): commands of each step (`slots.note_commands`)."""
    slots: "Slots[Run]" = Slots()
    """The states of the parallel runs: handles with rows of the first six `slot_` fields, which share all other arrays.
    Pages are read from the run that has the memory: they may move in memory between calls."""


@inlined
def column_of(plan: Plan, run: Run, actor: int, column: int) -> float:
    """A property of an actor in this scene."""
    return run.registers[plan.layout.scene_values + actor * COLUMNS + column]


@inlined
def vehicle_of(plan: Plan, run: Run, actor: int) -> Vehicle:
    """What an actor's body can do."""
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
    """An actor's outline at a recorded sample."""
    return Box(
        run.states[sample, actor, State.X],
        run.states[sample, actor, State.Y],
        run.states[sample, actor, State.HEADING],
        column_of(plan, run, actor, Column.LENGTH),
        column_of(plan, run, actor, Column.WIDTH),
    )


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
    run.actors[actor, Memory.AWAITED] = 1.0 - present
    run.actors[actor, Memory.INSIDE] = -1.0


@inlined
def end_run(plan: Plan, run: Run, reason: int, detail: int, part_of_step: float) -> None:
    """Note how and when the scored run ended: in the current sample, or in a part of the step after it."""
    run.status[Status.END] = reason
    run.status[Status.DETAIL] = detail
    run.end[0] = (run.status[Status.SAMPLE] + part_of_step) * plan.layout.time_step
    run.end[1] = part_of_step
