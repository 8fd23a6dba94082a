"""Vocabulary of the whole engine: enumerations and column names. SI units only.

Kernels switch on these integers and index arrays with them, so a value here is part of the compiled program's meaning:
changing one changes `Program.digest` and the kernel cache key.
"""

from enum import IntEnum


class ActorKind(IntEnum):
    """Kind of an actor; one row of `engine.vehicles.MODELS` each."""

    CAR = 0
    TRUCK = 1
    BUS = 2
    MOTORCYCLE = 3
    BICYCLE = 4
    PEDESTRIAN = 5
    OBSTACLE = 6


class ManeuverType(IntEnum):
    """Direction in which a maneuver leaves the intersection, for its driver."""

    STRAIGHT = 0
    LEFT_TURN = 1
    RIGHT_TURN = 2
    U_TURN = 3


class GeneKind(IntEnum):
    """Encoding of a gene's value in a genome; an index gene stores the index of its option."""

    CONTINUOUS = 0
    INTEGER = 1
    INDEX = 2


class Distribution(IntEnum):
    """Distribution of a gene in a plain run, or of a nuisance value at every attempt."""

    UNIFORM = 0
    NORMAL = 1
    TRUNCATED_NORMAL = 2
    DISCRETE = 3


class Verdict(IntEnum):
    """The result of one evaluation. INFEASIBLE, EXHAUSTED, ABORTED and CONTROLLER score -1 and count as invalid."""

    VALID = 0
    INFEASIBLE = 1
    EXHAUSTED = 2
    ABORTED = 3
    ERROR = 4
    CONTROLLER = 5
    """A controller failed in the scene, each time."""


class EndReason(IntEnum):
    """Reason for the end of the scored run."""

    COLLISION = 0
    OTHER_COLLISION = 1
    """Reserved: no run ends so, as a contact between other actors does not end a run."""
    RULE = 2
    TIMEOUT = 3
    ALL_DONE = 4
    STUCK = 5
    """A behaviour ran its whole instruction budget in one step without taking an action."""
    BROKEN = 6
    """A state, or what a condition says, became NaN: the run is an error, never a result."""
    ABORTED = 7
    """A requirement on the run broke: the run is invalid."""
    BUILDING = 8
    """The ego ran into a building: a collision without a pair."""


class Side(IntEnum):
    """Side of an actor's outline, for its driver."""

    FRONT = 0
    LEFT = 1
    REAR = 2
    RIGHT = 3


class Fault(IntEnum):
    """Responsible actor of a collision: the ego, or it was struck (`engine.kernels.fault`)."""

    EGO = 0
    STRUCK_FROM_BEHIND = 1
    STRUCK_STANDING = 2


class Blame(IntEnum):
    """Verdict on one simulation by a set of reference drivers (`engine.verdicts.blame`)."""

    NONE = -1
    """The ego did not collide."""
    AVOIDABLE = 0
    """A collision that every driver of the set avoids, among those whose range covers it."""
    UNAVOIDABLE = 1
    """A collision that none of these drivers avoids."""
    STRUCK = 2
    """No failure of the ego: it was struck from behind, or while it stood where standing is permitted."""
    DISPUTED = 3
    """A collision that some of these drivers avoid."""
    NO_MODEL = 4
    """A collision that the range of no driver of the set covers."""


BLAMEWORTHY = (Blame.AVOIDABLE, Blame.DISPUTED)
"""Verdicts that come first in an order of failures; all others follow as equals."""


class Answer(IntEnum):
    """Result of one reference driver in one simulation (`engine.kernels.references`)."""

    NONE = -1
    """The ego did not collide."""
    AVOIDS = 0
    COLLIDES = 1
    STRUCK = 2
    """No failure of the ego, as in `Blame`: no driver is asked."""
    NO_VEHICLE = 3
    """Out of range: the ego or the other is a pedestrian or a bicycle."""
    CROSSING = 4
    """Out of range: the other crossed the ego's direction, or came towards it, within the last seconds."""
    GRIP = 5
    """Out of range: the ego's brakes or the road give less than the driver's full braking."""
    REVERSING = 6
    """Out of range: the ego reversed."""


class ReferenceKind(IntEnum):
    """Kind of a reference driver: how it judges a situation (`engine.kernels.references`)."""

    CAREFUL = 0
    """Careful driver of UN R157, Annex 4, Appendix 3, for situations of any kind (`engine.avoidability`)."""
    REGULATION = 1
    """UN R157, 5.2.5.2."""
    RESPONSIBILITY = 2
    """Responsibility-sensitive safety."""
    FUZZY = 3
    """Fuzzy safety model."""
    SKILLED = 4
    """Careful driver of UN R157 as the Joint Research Centre wrote it, for cut-ins and leaders."""


class RuleKind(IntEnum):
    """Effect of a rule that is evaluated in every sample."""

    TERMINATE = 0
    """True ends the run."""
    ABORT = 1
    """True makes the run invalid."""
    WATCH = 2
    """The value is stored."""


class Turns(IntEnum):
    """Time of the turns of a coroutine without an actor."""

    LATER = 0
    """Turns after the rules, once it has been started."""
    FROM_START = 1
    """Turns after the rules."""
    BEFORE_RULES = 2
    """Turns before the rules, so that rules see its effects; only for the first coroutine."""
    CALLED = 3
    """Turns within those of another coroutine, once it has been started."""

    @property
    def words(self) -> str:
        """Return the text for listings, after a name."""
        return {Turns.LATER: "", Turns.CALLED: ", advanced by another"}.get(self, ", from the start")


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


class Sense(IntEnum):
    """Kinds of objectives of a file."""

    EXPECT = 0
    """A formula should hold: smaller values are worse violations."""
    MAXIMIZE = 1
    MINIMIZE = 2


RECORDS, EGOCENTRIC = OBSERVABLE = ("records", "egocentric")
"""Observations of a controller: the file's records over time, or the view from its own actor."""

OBJECTIVES = ("risk", "avoidable", "conflict", "severity", "injury", "controller")
"""Objectives that exist for every file; no objective of a file has such a name."""


class Reducer(IntEnum):
    """Reduction of a finished run to one number."""

    LARGEST = 0
    """Largest value of a rule, up to contact or the end."""
    LEAST = 1
    FINAL = 2
    """Value at the last sample before contact, or the end."""
    MEAN = 3
    """Mean over time."""
    TOTAL = 4
    """Its integral over time."""
    RESULT = 5
    """A result by name: a row of `engine.judged`."""
    INITIAL = 6
    """Value at the first sample."""
    CONTACT = 7
    """Value at the instant of the ego's first contact; infinite without one."""


class Purpose(IntEnum):
    """Purpose of a random stream; part of its key, so that no two purposes ever share numbers."""

    OPERATOR = 0
    SCENE = 1
    BEHAVIOUR = 2


class Method(IntEnum):
    """Method that requests an evaluation; part of a stream's key. A value never changes: journals depend on it.

    Search methods outside this list are numbered by their names (`engine.streams.method_number`), so a new method needs
    no value.
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
    journals without such numbers.
    """


class Measure(IntEnum):
    """Measures of a finished run that are computed only where they are requested; a set of them is a sum."""

    SIGHT = 1
    """When the ego first saw each other actor, and how long it was hidden."""
    GRIP = 2
    """Use of grip by each actor with tyres."""
    FAULT = 4
    """Fault of a collision."""
    GAPS = 8
    """PET by area of the ego and each other actor."""


STORED = Measure.SIGHT | Measure.GRIP | Measure.FAULT
"""Measures that results contain unless others are requested."""


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
    """Distance of the outline's centre ahead of the rear axle [m]."""
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
    """1.0 if the body hides actors behind it, else 0.0."""
    FIXED = 16
    """1.0 if no impact moves the body, else 0.0."""
    TOP_SPEED = 17
    """[m/s]"""
    STEER_RATE = 18
    """Largest rate of the steering angle [rad/s]."""
    PEDAL_TIME = 19
    """Time from no pedal to full pedal [s]; 0: at once."""
    DRAG = 20
    """Deceleration while rolling without pedals [m/s^2]."""


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
    """1 while the actor is present; `tables.SLIDING` at the end of a step in which it slid after an impact; 0 after it
    has left the scene.
    """


class Command(IntEnum):
    """Command of an action. A pedal, and an offset to the left of the followed path, last one step; a steering angle
    and a gear stay until the next command. If pedals stay, too, `STOP` brakes for one step. `BACK` with `FOR_ONE_STEP`
    engages the reverse gear for one step. `ASIDE`: an offset that the follower approaches along a smooth curve.
    """

    THROTTLE = 0
    BRAKE = 1
    STEER = 2
    SPEED = 3
    REVERSE = 4
    OFFSET = 5
    STOP = 6
    BACK = 7
    ASIDE = 8


class HeightColumn(IntEnum):
    """Columns of `RoadTables.heights`: a point on the centre of a lane [m], its slopes, and the lane's number."""

    X = 0
    Y = 1
    HEIGHT = 2
    SLOPE_X = 3
    SLOPE_Y = 4
    LANE = 5


LEVEL = 2.5
"""Least difference of height between two actors on different levels [m]: the headroom of a car."""
LEVEL_REACH = 5.0
"""Largest distance at which an object is on the level of a road [m]: from the road that its `level` names, or from the
centre of a lane, of a pedestrian or an obstacle; *ours*: half a wide lane, a kerb and a sidewalk.
"""

SAME_WAY = 0.5
"""Cosine of the angle between two headings from which actors count as going the same way, or opposite ways."""
FOR_ONE_STEP = 2.0
"""Value of a reverse gear for one step; 1 is a reverse gear that stays engaged."""
