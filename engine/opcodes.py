"""The instructions that a compiled program is made of.

Kernels switch on these integers: a value is part of the program's meaning, as those of `engine.vocabulary` are.
"""

from collections.abc import Mapping
from enum import IntEnum
from typing import NamedTuple


class Op(IntEnum):
    """Instructions. A row of code is `(op, dst, a, b, c, d)`; operands are register numbers unless stated otherwise.

    Three families: arithmetic and geometry (used by scene code and by behaviour code), reads of the running simulation
    (behaviour code only), control flow (behaviour code only). A truth is 1.0, 0.0, or NaN if
    it depends on a NaN.
    """

    # -- arithmetic: dst <- f(a, b, c)
    MOVE = 0
    ADD = 1
    SUB = 2
    MUL = 3
    DIV = 4
    MOD = 5
    FLOORDIV = 6
    POW = 7
    NEG = 8
    ABS = 9
    MIN = 10
    MAX = 11
    SQRT = 12
    SIN = 13
    COS = 14
    TAN = 15
    ASIN = 16
    ACOS = 17
    ATAN = 18
    ATAN2 = 19
    EXP = 20
    LOG = 21
    FLOOR = 22
    CEIL = 23
    ROUND = 24
    HYPOT = 25
    WRAP = 26
    """dst <- angle a wrapped to [-pi, pi)."""
    LT = 27
    LE = 28
    EQ = 29
    NE = 30
    AND = 31
    OR = 32
    NOT = 33
    SELECT = 34
    """dst <- b if a else c."""
    TABLE = 35
    """dst <- pool[a (an integer, not a register) + int(register b)]: the numeric options of a discrete choice."""
    NORMAL_QUANTILE = 36
    """dst <- standard normal quantile of a; turns a uniform draw into a normal one."""
    NORMAL_CDF = 37

    # -- geometry: packed operands name the first of consecutive registers
    PATH_POSE = 40
    """dst..dst+2 <- x, y, heading on path a at arc length b (clamped to the path)."""
    PATH_LENGTH = 41
    """dst <- length of path a."""
    PATH_DISTANCE = 42
    """dst <- distance from (b, c) to path a."""
    REGION_SAMPLE = 43
    """dst..dst+1 <- point of region a, uniform by area, from uniform numbers b and c."""
    REGION_DISTANCE = 44
    """dst <- distance from (b, c) to region a; 0 inside."""
    REGION_CONTAINS = 45
    """dst <- 1 if (b, c) is in region a, else 0."""
    REGION_CONTAINS_BOX = 46
    """dst <- 1 if the outline at b..b+4 (x, y, heading, length, width) is wholly in region a, else 0."""
    BOX_DISTANCE = 47
    """dst <- distance between the outlines at a..a+4 and b..b+4; 0 when they touch."""
    CAN_SEE = 48
    """dst <- 1 if the viewer at a..a+5 (x, y, heading, view angle, view distance; its number below, or -1) sees the
    outline at b..b+4 past buildings and the outlines at c (their number, then for each x, y, heading, length, width,
    and 1 if it hides), else 0.
    """
    ROAD_HEADING = 49
    """dst <- direction of the lane nearest to (a, b)."""
    ROAD_FOLLOW = 50
    """dst..dst+2 <- pose reached from (a, b) by going c along the lane's direction, keeping the lateral offset."""
    LANE_ROUTE = 51
    """dst <- path id of the default route (lane, straight where it can, lane) of the lane nearest to pose a..a+2."""
    PATH_PROJECT = 52
    """dst <- arc length of the point of path a nearest to (b, c)."""
    REGION_BOX_DISTANCE = 53
    """dst <- distance between region a and the outline at b..b+4; 0 when they touch or overlap."""
    LANE_NEAREST = 54
    """dst <- id of the lane nearest to pose a..a+2."""
    REGION_DEPTH = 55
    """dst <- depth of (b, c) in region a; outside minus the distance to it."""
    REGION_BOX_DEPTH = 56
    """dst <- depth of the outline at b..b+4 in region a; minus the distance by which it sticks out."""

    # -- the running simulation
    STATE = 60
    """dst <- State column b of actor a (both integers, not registers)."""
    TIME = 61
    RANDOM = 62
    """dst <- the next uniform number of this scene's behaviour stream."""
    WITHIN = 63
    """dst <- withinDistanceToAnyObjs: 1 if actor a (integer) sees an actor whose centre is nearer than b, else 0."""
    LEAD = 64
    """dst..dst+1 <- gap along path b between the outline of actor a (integer) and that of the nearest present actor
    ahead on it that is not hidden from a, nor farther than c, and that actor's speed along the path; infinity and 0
    without an actor ahead.
    """
    TTC = 65
    """dst <- exact time to collision of the outlines of actors a and b (integers; b = -1: the least over all others) at
    constant velocities; infinity if they would never touch, 0 when they do. c = 1 (integer): actors hidden from a, or
    farther than d, do not count.
    """
    IS_RUNNING = 66
    """dst <- 1 if block a (integer) has started and not ended, else 0."""
    SEES = 67
    """dst <- 1 if actor a (integer) sees actor b (integer) past all others and buildings, else 0; for -1, which is no
    actor, the view is packed at c (x, y, heading, view angle, view distance), and the outline at d.
    """
    NOTICES = 68
    """dst <- 1 if nothing hides actor b (integer) from actor a (integer), in any direction of view up to distance c,
    else 0.
    """
    TOUCHES = 69
    """dst <- 1 if the ego has touched actor a (integer), or any actor or building (a = -1), else 0; contact ends the
    run, so it is 1 at that instant only.
    """
    VELOCITY = 70
    """dst..dst+2 <- velocity x, y of actor a (integer), of its rear axle, or of the centre of a sliding body; and its
    yaw rate in the step that ended at the sample.
    """

    ACTION = 71
    """dst <- external decision number a (integer) at this turn."""
    CROSSING = 72
    """dst..dst+10 <- `kernels.crossing.Crossing` of actors a and b (integers); a's perception of b is packed at c, as
    `kernels.crossing.Foresight`.
    """

    # -- control: jumps are absolute rows of the code
    JUMP = 80
    """Go to row a."""
    JUMP_UNLESS = 81
    """Go to row b unless register a is true."""
    JUMP_IF_RUNNING = 82
    """Go to row b if block a has started and not ended."""
    SET_RESUME = 83
    """Block a will continue at row b (b = -1: it is not running)."""
    RESUME = 84
    """Go to the row at which block a continues."""
    YIELD = 85
    """End the actor's turn; block a continues at the next row in the next step."""
    COMMAND = 86
    """Set command a (a `Command`, integer) from register b."""
    FOLLOW = 87
    """One step of path following: path a, target speed b, lateral limit c; dst stores the arc length reached (negative:
    not yet projected). At the path's end: mark the route done and go to row d.
    """
    HOLD_SPEED = 88
    """One step of speed control without steering: target speed a."""
    TERMINATE = 89
    """End the run; rule number a is the reason, and its kind determines the validity of the run."""
    HALT = 90
    """End the behaviour. An actor whose route is done leaves the scene; any other actor coasts."""
    END = 91
    """End of a segment of pure code (a requirement, a termination rule, scene outputs)."""
    SPAWN = 92
    """Actor a (integer), absent until now, takes part from this sample on."""
    REPLAY = 93
    """One step along the recorded track at pool[a] (an integer, see `kernels.replay`), with time b times as fast as
    that of the run; dst stores the progress. At its end: mark the route done and go to row c.
    """
    JUMP_IF_FALSE = 94
    """Go to row b if register a is false; go on if it is true or undefined."""


ROW_WIDTH = 6
"""Numbers in a row of code: op, dst, a, b, c, d."""


class Fused(IntEnum):
    """Instructions that the interpreter of step code executes at once; no program contains them (`engine.host.fuse`).

    A row of code with such a number stands for its own instruction and those of the rows after it, which keep their
    places: their operands are read from there, and jumps may lead to them.
    """

    IS_FAR = 100
    """The distance of an actor from a place, compared with a number: rows of `FUSIONS`."""
    ARE_FAR = 101
    """The distance of two actors, compared with a number."""
    HANDLE = 102
    """The test of a handler of `try` that asks for actors within a distance."""
    FOLLOW_ON = 103
    """A step of path following that ends the turn."""


FUSIONS: Mapping[Fused, tuple[Op, ...]] = {
    Fused.IS_FAR: (Op.STATE, Op.SUB, Op.STATE, Op.SUB, Op.HYPOT, Op.LT),
    Fused.ARE_FAR: (Op.STATE, Op.STATE, Op.SUB, Op.STATE, Op.STATE, Op.SUB, Op.HYPOT, Op.LT),
    Fused.HANDLE: (Op.JUMP_IF_RUNNING, Op.WITHIN, Op.JUMP_UNLESS),
    Fused.FOLLOW_ON: (Op.FOLLOW, Op.YIELD),
}
"""Sequences of instructions that are executed as one."""


class Instruction(NamedTuple):
    """Operands and results of an instruction."""

    operands: tuple[int, ...]
    """Number of consecutive registers that each of a, b, c, d names; `NUMBER` for an integer, `MANY` where the first
    register holds their number or the instruction's docstring says it."""
    results: int = 1
    """Number of consecutive registers that it writes from dst on."""


NUMBER, MANY = 0, -1
INSTRUCTIONS: Mapping[Op, Instruction] = {
    Op.TABLE: Instruction((NUMBER, 1)),
    Op.PATH_POSE: Instruction((1, 1), 3),
    Op.PATH_LENGTH: Instruction((1,)),
    Op.PATH_DISTANCE: Instruction((1, 1, 1)),
    Op.PATH_PROJECT: Instruction((1, 1, 1)),
    Op.REGION_SAMPLE: Instruction((1, 1, 1), 2),
    Op.REGION_DISTANCE: Instruction((1, 1, 1)),
    Op.REGION_CONTAINS: Instruction((1, 1, 1)),
    Op.REGION_CONTAINS_BOX: Instruction((1, 5)),
    Op.REGION_BOX_DISTANCE: Instruction((1, 5)),
    Op.REGION_DEPTH: Instruction((1, 1, 1)),
    Op.REGION_BOX_DEPTH: Instruction((1, 5)),
    Op.BOX_DISTANCE: Instruction((5, 5)),
    Op.CAN_SEE: Instruction((6, 5, MANY)),
    Op.ROAD_HEADING: Instruction((1, 1)),
    Op.ROAD_FOLLOW: Instruction((1, 1, 1), 3),
    Op.LANE_ROUTE: Instruction((3,)),
    Op.LANE_NEAREST: Instruction((3,)),
    Op.STATE: Instruction((NUMBER, NUMBER)),
    Op.TIME: Instruction(()),
    Op.RANDOM: Instruction(()),
    Op.WITHIN: Instruction((NUMBER, 1)),
    Op.LEAD: Instruction((NUMBER, 1, 1), 2),
    Op.TTC: Instruction((NUMBER, NUMBER, NUMBER, 1)),
    Op.IS_RUNNING: Instruction((NUMBER,)),
    Op.SEES: Instruction((NUMBER, NUMBER, 5, 5)),
    Op.NOTICES: Instruction((NUMBER, NUMBER, 1)),
    Op.TOUCHES: Instruction((NUMBER,)),
    Op.VELOCITY: Instruction((NUMBER,), 3),
    Op.ACTION: Instruction((NUMBER,)),
    Op.CROSSING: Instruction((NUMBER, NUMBER, MANY), 11),
    Op.JUMP: Instruction((NUMBER,), 0),
    Op.JUMP_UNLESS: Instruction((1, NUMBER), 0),
    Op.JUMP_IF_RUNNING: Instruction((NUMBER, NUMBER), 0),
    Op.JUMP_IF_FALSE: Instruction((1, NUMBER), 0),
    Op.SET_RESUME: Instruction((NUMBER, NUMBER), 0),
    Op.RESUME: Instruction((NUMBER,), 0),
    Op.YIELD: Instruction((NUMBER,), 0),
    Op.COMMAND: Instruction((NUMBER, 1), 0),
    Op.FOLLOW: Instruction((1, 1, 1, NUMBER)),
    Op.HOLD_SPEED: Instruction((1,), 0),
    Op.TERMINATE: Instruction((NUMBER,), 0),
    Op.HALT: Instruction((), 0),
    Op.END: Instruction((), 0),
    Op.SPAWN: Instruction((NUMBER,), 0),
    Op.REPLAY: Instruction((NUMBER, 1, NUMBER)),
}
"""Every instruction but the scalar ones, which are rows of `engine.operators`."""
