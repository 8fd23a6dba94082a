"""The words of the domain that the whole engine shares: enumerations and column names. SI units only.

Kernels switch on these integers and index arrays with them, so a value here is part of the compiled program's
meaning: changing one changes `Program.digest` and the kernel cache key.
"""

from enum import IntEnum


class ActorKind(IntEnum):
    """What an actor is; one row of `engine.vehicles.MODELS` each."""

    CAR = 0
    TRUCK = 1
    BUS = 2
    MOTORCYCLE = 3
    BICYCLE = 4
    PEDESTRIAN = 5
    OBSTACLE = 6


class ManeuverType(IntEnum):
    """How a maneuver leaves the intersection, seen by its driver."""

    STRAIGHT = 0
    LEFT_TURN = 1
    RIGHT_TURN = 2
    U_TURN = 3


class GeneKind(IntEnum):
    """How a gene's value is read from a genome; an index gene stores the index of its option."""

    CONTINUOUS = 0
    INTEGER = 1
    INDEX = 2


class Distribution(IntEnum):
    """How a gene is drawn in a plain run, or a nuisance value at every attempt."""

    UNIFORM = 0
    NORMAL = 1
    TRUNCATED_NORMAL = 2
    DISCRETE = 3


class Verdict(IntEnum):
    """The result of one evaluation. INFEASIBLE, EXHAUSTED and ABORTED score -1 and count as invalid."""

    VALID = 0
    INFEASIBLE = 1
    EXHAUSTED = 2
    ABORTED = 3
    ERROR = 4


class EndReason(IntEnum):
    """Why a run stopped being scored."""

    COLLISION = 0
    OTHER_COLLISION = 1
    """Of old journals only: two others touched. Today they crash and the run goes on."""
    RULE = 2
    TIMEOUT = 3
    ALL_DONE = 4
    STUCK = 5
    """A behaviour ran its whole instruction budget in one step without taking an action."""
    BROKEN = 6
    """A state became NaN: the run is an error, never a result."""
    ABORTED = 7
    """A requirement on the run broke: the run is invalid."""
    BUILDING = 8
    """The ego ran into a building: a crash, of no pair."""


class Side(IntEnum):
    """Where another is on an actor's outline, seen by its driver."""

    FRONT = 0
    LEFT = 1
    REAR = 2
    RIGHT = 3


class RuleKind(IntEnum):
    """The effect of a rule that is looked at in every sample."""

    TERMINATE = 0
    """True ends the run."""
    ABORT = 1
    """True makes the run invalid."""
    WATCH = 2
    """The value is kept."""


class TemporalOp(IntEnum):
    """Nodes of a temporal formula, read over the samples of a finite run (LTL on finite traces).

    Source: De Giacomo and Vardi, Linear Temporal Logic and Linear Dynamic Logic on Finite Traces, IJCAI 2013.
    """

    ATOM = 0
    NOT = 1
    AND = 2
    OR = 3
    IMPLIES = 4
    NEXT = 5
    """There is a next sample, and it holds there."""
    ALWAYS = 6
    EVENTUALLY = 7
    UNTIL = 8
    """The second holds at some sample, and the first at all samples before."""


class Purpose(IntEnum):
    """What a random stream is for; part of its key, so that no two purposes ever share numbers."""

    OPERATOR = 0
    SCENE = 1
    BEHAVIOUR = 2


class Method(IntEnum):
    """The method that asked for an evaluation; part of a stream's key. A value never changes: journals depend on it.

    These are numbered here as they always were. A search method that is not among them is numbered by its name
    (`engine.streams.method_number`), so that a new one needs no value.
    """

    SINGLE = 0
    SAMPLE = 1
    RANDOM = 2
    GA = 3
    SOBOL = 4
    HALTON = 5
    LHS = 6
    CROSS_ENTROPY = 7
    ANNEALING = 8
    DIFFERENTIAL_EVOLUTION = 9
    CMAES = 10
    NSGA2 = 11
    MAP_ELITES = 12
    CMA_ME = 13
    NICHING = 14
    CUSTOM = 15
    """The low four bits of every method that is numbered by its name; alone, every searcher of another package in
    journals from before there were such numbers."""


class Column(IntEnum):
    """Columns of one actor's block in a scene: `values[actor * len(Column) + column]`. SI, angles in radians."""

    X = 0
    """Centre of the outline [m]."""
    Y = 1
    HEADING = 2
    """Anticlockwise from +x [rad]."""
    SPEED = 3
    """Longitudinal speed of the rear axle at t = 0 [m/s]."""
    LENGTH = 4
    WIDTH = 5
    WHEELBASE = 6
    REAR_TO_CENTER = 7
    """How far ahead of the rear axle the outline's centre lies [m]."""
    MASS = 8
    MAX_STEER = 9
    MAX_ACCELERATION = 10
    MAX_BRAKING = 11
    """Deceleration at full pedal [m/s^2]."""
    FRICTION = 12
    """Friction coefficient mu between tyre and road."""
    VIEW_ANGLE = 13
    VIEW_DISTANCE = 14
    OCCLUDING = 15
    """1.0 where the body hides what is behind it, else 0.0."""
    FIXED = 16
    """1.0 where no impact moves the body, else 0.0."""
    TOP_SPEED = 17
    """[m/s]"""
    STEER_RATE = 18
    """How fast the steering angle may change [rad/s]."""
    PEDAL_TIME = 19
    """From no pedal to a full one [s]; 0: at once."""
    DRAG = 20
    """Deceleration of who rolls without pedals [m/s^2]."""


class State(IntEnum):
    """Columns of an actor's state and of a trajectory sample. Position is the centre of the outline."""

    X = 0
    Y = 1
    HEADING = 2
    SPEED = 3
    STEER = 4
    ACCELERATION = 5
    """Longitudinal acceleration applied over the step that ended at this sample [m/s^2]."""
    THROTTLE = 6
    BRAKE = 7
    PRESENT = 8
    """1 while the actor takes part, `tables.SLIDING` while loose after an impact; 0 after it has left the scene."""


class Command(IntEnum):
    """What an action sets. A pedal lasts one step; a steering angle and a gear stay until the next."""

    THROTTLE = 0
    BRAKE = 1
    STEER = 2
    SPEED = 3
    REVERSE = 4


class Op(IntEnum):
    """Instructions. A row of code is `(op, dst, a, b, c, d)`; operands are register numbers unless said otherwise.

    Three families: arithmetic and geometry (used by scene code and by behaviour code), reads of the running
    simulation (behaviour code only), control flow (behaviour code only). Truth is 1.0 / 0.0.
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
    """Angle a brought into [-pi, pi)."""
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
    """dst <- whether (b, c) lies in region a."""
    REGION_CONTAINS_BOX = 46
    """dst <- whether the outline at b..b+4 (x, y, heading, length, width) lies wholly in region a."""
    BOX_DISTANCE = 47
    """dst <- distance between the outlines at a..a+4 and b..b+4; 0 when they touch."""
    CAN_SEE = 48
    """dst <- whether the viewer at a..a+5 (x, y, heading, view angle, view distance; its number below, or -1) sees the
    outline at b..b+4 past buildings and the outlines at c: how many, then x, y, heading, length, width, and whether it
    hides, of each."""
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

    # -- the running simulation
    STATE = 60
    """dst <- State column b of actor a (both integers, not registers)."""
    TIME = 61
    RANDOM = 62
    """dst <- the next uniform number of this scene's behaviour stream."""
    WITHIN = 63
    """dst <- withinDistanceToAnyObjs: does actor a (integer) see another whose centre is nearer than b?"""
    LEAD = 64
    """dst..dst+1 <- gap along path b between the outline of actor a (integer) and that of the nearest present actor
    ahead on it that is not hidden from a, nor farther off than c, and that actor's speed along the path; infinity and 0
    with no actor ahead."""
    TTC = 65
    """dst <- exact time to collision of the outlines of actors a and b (integers; b = -1: the least over all others)
    at constant velocities; infinity if they would never touch, 0 when they do. c = 1 (integer): who is hidden from a,
    or farther off than d, does not count."""
    IS_RUNNING = 66
    """dst <- whether block a (integer) has started and not ended."""
    SEES = 67
    """dst <- whether actor a (integer) sees actor b (integer) past all others and buildings; of -1, which is no actor,
    the view is packed at c (x, y, heading, view angle, view distance), and the outline at d."""
    NOTICES = 68
    """dst <- whether nothing hides actor b (integer) from actor a (integer), wherever a looks as far as c."""

    # -- control: jumps are absolute rows of the code
    JUMP = 80
    """Go to row a."""
    JUMP_UNLESS = 81
    """Go to row b unless register a is true."""
    JUMP_IF_RUNNING = 82
    """Go to row b if block a has started and not ended."""
    SET_RESUME = 83
    """Block a will go on at row b (b = -1: it is not running)."""
    RESUME = 84
    """Go to where block a will go on."""
    YIELD = 85
    """The actor's turn is over; block a goes on at the next row in the next step."""
    COMMAND = 86
    """Set command a (a `Command`, integer) from register b."""
    FOLLOW = 87
    """One step of path following: path a, target speed b, lateral limit c; dst keeps the arc length reached
    (negative: not yet projected). At the path's end: mark the route done and go to row d."""
    HOLD_SPEED = 88
    """One step of speed control without steering: target speed a."""
    TERMINATE = 89
    """End the run; rule number a is the reason, and its kind says whether the run is valid."""
    HALT = 90
    """The behaviour is over. An actor whose route is done leaves the scene; any other coasts."""
    END = 91
    """End of a segment of pure code (a requirement, a termination rule, scene outputs)."""
    SPAWN = 92
    """Actor a (integer), absent until now, takes part from this sample on."""
