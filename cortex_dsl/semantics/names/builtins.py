"""All built-in names: one row each, with its hover text and reference.

Functions of numbers are rows of `engine.operators`. A new distribution, action or library behaviour starts with a row
here; `functions`, `driving`,
`random_values`, `following`, `caution` and `giving_way` hold what the rows do.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from enum import Enum

from cortex_dsl.ir import Dimension
from cortex_dsl.semantics.quantities.units import ACCELERATION, ANGLE, LENGTH, PURE, SPEED, TIME
from engine.frozen import frozen
from engine.judged import NAMED_RESULTS
from engine.operators import OPERATORS, Function
from engine.vocabulary import Command


class Kind(Enum):
    FUNCTION = "function"
    DISTRIBUTION = "distribution"
    CLASS = "class"
    ACTION = "action"
    BEHAVIOUR = "behavior"
    CONSTANT = "constant"


@frozen
class Parameter:
    """One argument. A dimension says that it is a number: bare ones adopt it."""

    name: str
    dimension: Dimension | None = None
    default: str | None = None
    """Default as users see it; None if the argument is required."""
    low: float = float("-inf")
    high: float = float("inf")
    aliases: tuple[str, ...] = ()
    meaning: str = ""
    """Meaning of the number, if its name and dimension leave it open."""


@frozen
class Builtin:
    name: str
    kind: Kind
    doc: str
    parameters: tuple[Parameter, ...] = ()
    variadic: bool = False
    command: Command | None = None

    @property
    def signature(self) -> str:
        """`Range(low, high)`."""
        shown = [p.name if p.default is None else f"{p.name}={p.default}" for p in self.parameters]
        if self.kind in (Kind.CLASS, Kind.CONSTANT):
            return self.name
        return f"{self.name}({', '.join([*shown, *(['...'] if self.variadic else [])])})"

    def parameter(self, name: str) -> Parameter:
        """Return the parameter of a name."""
        return next(each for each in self.parameters if each.name == name)


def _function(name: str, doc: str, *parameters: str, variadic: bool = False) -> Builtin:
    return Builtin(name, Kind.FUNCTION, doc, tuple(map(Parameter, parameters)), variadic)


def _distribution(name: str, doc: str, *parameters: str, variadic: bool = False) -> Builtin:
    return Builtin(name, Kind.DISTRIBUTION, doc, tuple(map(Parameter, parameters)), variadic)


def _class(name: str, doc: str) -> Builtin:
    return Builtin(name, Kind.CLASS, doc)


def _constant(name: str, doc: str) -> Builtin:
    return Builtin(name, Kind.CONSTANT, doc)


def _action(name: str, doc: str, parameter: Parameter, command: Command) -> Builtin:
    return Builtin(name, Kind.ACTION, doc, (parameter,), command=command)


def _behaviour(name: str, doc: str, *parameters: Parameter) -> Builtin:
    return Builtin(name, Kind.BEHAVIOUR, doc, parameters)


def _near(name: str, doc: str, who: str) -> Builtin:
    distance = Parameter("thresholdDistance", LENGTH, low=0.0, aliases=("threshold_distance",))
    return Builtin(name, Kind.FUNCTION, doc, (Parameter(who), distance))


WIDEST = 10.0
"""Largest offset from its path that an actor accepts [m]."""
LONGEST_PATH = 100e3
"""Largest length of a segment of a path [m]."""
TOP_SPEED = 200.0
"""Above this no vehicle on a road goes [m/s]: a number beyond it is a slip."""
_SPEED = Parameter("target_speed", SPEED, "10 m/s", low=0.0, high=TOP_SPEED, aliases=("speed",))
_LATERAL = Parameter("max_lateral", ACCELERATION, "3 m/s^2", low=0.0)
_OBEY = Parameter("obey_signals", default="False")
_LIMIT = Parameter("respect_speed_limit", default="False")
_OPPOSITE = Parameter("is_oppositeTraffic", default="False")
_DURATION = Parameter("duration", TIME, "3.5 s", low=0.5)
_LANE = Parameter("laneToFollow", default="the lane it is on")
_SIGHT = (
    Parameter("range", LENGTH, "as far as one sees", low=0.0),
    Parameter("field_of_view", ANGLE, "360 deg", low=0.0),
    Parameter("latency", TIME, "0 s", low=0.0),
)
_INNER = Parameter("behavior")
_BRAKE = "a pedal from 0 to 1; 1 brakes with the `maxBraking` of the vehicle"
_THROTTLE = "a pedal from 0 to 1; 1 accelerates with the `maxAcceleration` of the vehicle"
_OFFSET = Parameter("offset", LENGTH, "none", low=-WIDEST, high=WIDEST)
_WALK = Parameter("speed", SPEED, "by `age`", low=0.0, high=TOP_SPEED, aliases=("target_speed",))
_GROUP = Parameter("in_group", default="False")
_YIELDS = Parameter("yields_at_crossings", default="True")
_REACH = Parameter("distance", LENGTH, "100 m", low=0.0)
_RADIUS = Parameter("radius", LENGTH, low=-1e9, high=1e9)
_EXTENT = (
    Parameter("angle", ANGLE, "none", low=0.0, high=math.tau, meaning="an angle above 0, up to 360 deg"),
    Parameter("length", LENGTH, "none", low=0.0, high=LONGEST_PATH),
)


def _car_following(acceleration: str, deceleration: str) -> tuple[Parameter, ...]:
    """Return the parameters of the intelligent driver model except the target speed."""
    return (
        Parameter("trajectory", default="the lane it is on"),
        Parameter("time_headway", TIME, "1.6 s", low=0.0),
        Parameter("min_gap", LENGTH, "2 m", low=0.0),
        Parameter("max_acceleration", ACCELERATION, acceleration, low=0.01),
        Parameter("comfortable_deceleration", ACCELERATION, deceleration, low=0.01),
        Parameter("exponent", PURE, "4", low=0.1),
    )


_ROWS = (
    # -- distributions
    _distribution("Range", "Uniform over an interval.", "low", "high"),
    _distribution("Normal", "Normal (Gaussian).", "mean", "stdDev"),
    _distribution("TruncatedNormal", "Normal confined to an interval.", "mean", "stdDev", "low", "high"),
    _distribution("Uniform", "One of the given values, all equally likely.", variadic=True),
    _distribution("Discrete", "One of the keys of a dictionary, as likely as its weight says.", "weights"),
    _distribution("DiscreteRange", "A whole number of an interval, ends included.", "low", "high"),
    _distribution("VerifaiRange", "Scenic's spelling of `Range` for searched params.", "low", "high"),
    _distribution("VerifaiDiscreteRange", "Scenic's spelling of `DiscreteRange` for searched params.", "low", "high"),
    _distribution("VerifaiOptions", "Scenic's spelling of `Uniform` for searched params.", variadic=True),
    _distribution("Fixed", "Given values one after the other, one each time this place is evaluated.", variadic=True),
    Builtin("WalkingSpeed", Kind.DISTRIBUTION, "Speed at which a person of an age in years crosses a road.",
            (Parameter("age", PURE, low=3.0, high=110.0, meaning="an age in years, from 3 to 110"),)),
    _function("resample", "A drawn number once more: drawn from the same distribution, by itself.", "x"),
    # -- mathematics
    *(
        _function(row.name, row.doc, *row.parameters, variadic=not row.parameters)
        for row in (operator.spelling for operator in OPERATORS.values())
        if isinstance(row, Function)
    ),
    _function("sum", "Sum of a list of numbers.", "items"),
    # -- texts and classes
    _function("int", "The whole part of a number, towards zero; of a text, the whole number in it.", "x"),
    _function("float", "The number that a text holds; a number as it is.", "x"),
    _function("str", "A value as text.", "x"),
    _function("isinstance", "Whether something is of a class, or of one of several.", "x", "classinfo"),
    # -- lists
    _function("len", "Number of items of a list.", "items"),
    _function("filter", "Items of a list for which a function is true.", "function", "items"),
    _function("map", "What a function makes of every item of a list.", "function", "items"),
    _function("any", "Whether one item of a list is true.", "items"),
    _function("all", "Whether every item of a list is true.", "items"),
    _function("range", "Whole numbers below an end, or from a start to below an end.", variadic=True),
    _function("list", "The items of a list.", "items"),
    _function("tuple", "The items of a list.", "items"),
    _function("Color", "A colour, as Scenic's scripts give it: red, green, blue.", variadic=True),
    # -- regions and fields
    _function("Vector", "A place `(x, y)`, as Scenic's scripts write it; a third number, its height, must be 0.",
              variadic=True),
    _function("CircularRegion", "All that is no farther from a place than a radius.", "center", "radius"),
    _function("SectorRegion", "The part of a circle that opens by an angle around a heading.",
              "center", "radius", "heading", "angle"),
    _function("RectangularRegion", "A rectangle around a place.", "position", "heading", "width", "length"),
    _function("PolygonalRegion", "What the corners of a polygon surround.", "points"),
    _function("PolylineRegion", "A line through points: places on it head along it.", "points"),
    # -- paths
    Builtin("Path", Kind.FUNCTION, "A path from a pose on: lengths of lines, arcs and clothoids, one after another.",
            (Parameter("start"), Parameter("segments"))),
    Builtin("Arc", Kind.FUNCTION, "A part of a circle in a path, to the left of a positive radius.",
            (_RADIUS, *_EXTENT)),
    Builtin("Clothoid", Kind.FUNCTION, "A part of a path whose curvature changes linearly; `none` is straight.",
            (replace(_RADIUS, name="start_radius"), replace(_RADIUS, name="end_radius"), *_EXTENT)),
    Builtin("VectorField", Kind.FUNCTION, "A heading at every point, by a function of the point.",
            (Parameter("name"), Parameter("value"), Parameter("minSteps", default="4"),
             Parameter("defaultStepSize", default="5 m"))),
    _function("Workspace", "A region that all objects must lie in, once it is called `workspace`.", "region"),
    # -- the running simulation
    _function("simulation", "The running simulation: `simulation().currentTime` counts its steps."),
    Builtin(
        "withinDistanceToAnyObjs",
        Kind.FUNCTION,
        "Whether an object sees another whose centre is nearer than a distance.",
        (Parameter("vehicle"), Parameter("thresholdDistance", LENGTH, low=0.0, aliases=("threshold_distance",))),
    ),
    _near("withinDistanceToAnyCars", "Whether another vehicle, seen or not, is nearer than a distance.", "car"),
    _near("withinDistanceToAnyPedestrians", "Whether a person whom a vehicle sees is near its front.", "vehicle"),
    _near("withinDistanceToObjsInLane", "Whether a vehicle sees another near it in its lane, or in its intersection.",
          "vehicle"),
    Builtin("timeToCollision", Kind.FUNCTION, "Time until an object touches another (or any) if all keep their speed.",
            (Parameter("object"), Parameter("other", default="any"))),
    # -- traffic lights
    _near("withinDistanceToTrafficLight", "Whether the light at the end of its lane is near a vehicle.", "vehicle"),
    _near("withinDistanceToRedYellowTrafficLight", "Whether that light is near and red or yellow.", "vehicle"),
    Builtin("getClosestTrafficLightStatus", Kind.FUNCTION,
            'What the light at the end of its lane shows: "green", "yellow", "red", or "None" without one.',
            (Parameter("vehicle"), _REACH)),
    Builtin("setClosestTrafficLightStatus", Kind.FUNCTION, "Set the light at the end of a vehicle's lane.",
            (Parameter("vehicle"), Parameter("color"), _REACH)),
    _function("getTrafficLightStatus", "What a light shows.", "signal"),
    _function("setTrafficLightStatus", "Set a light; it goes on when its plan changes it next.", "signal", "color"),
    _function("setAllIntersectionTrafficLightsStatus", "Set all lights of an intersection.", "intersection", "color"),
    _function("freezeTrafficLights", "Stop the clock of all lights; they can still be set."),
    _function("unfreezeTrafficLights", "Let the clock of all lights go on."),
    _function("localPath", "A file beside this one; only there so that Scenic's scripts run.", "path"),
    # -- actions
    _action("SetThrottleAction", "Throttle, 0 to 1, for one step; until the next in files with a `model` line.",
            Parameter("throttle", PURE, low=0.0, high=1.0, meaning=_THROTTLE), Command.THROTTLE),
    _action("SetBrakeAction", "Brake pedal, 0 to 1, for one step; until the next in files with a `model` line.",
            Parameter("brake", PURE, low=0.0, high=1.0, meaning=_BRAKE), Command.BRAKE),
    _action("SetSteerAction", "Steering angle, positive to the left; stays until the next.", Parameter("steer", ANGLE),
            Command.STEER),
    _action("SetReverseAction", "Put the reverse gear in (`True`) or out; stays until the next.", Parameter("reverse"),
            Command.REVERSE),
    _action("SetSpeedAction", "Set the speed at once.", Parameter("speed", SPEED, low=0.0, high=TOP_SPEED),
            Command.SPEED),
    _action("SetWalkingDirectionAction", "Turn a pedestrian into a direction, in which it goes on.",
            Parameter("heading", ANGLE), Command.STEER),
    _action("SetWalkingSpeedAction", "Set the speed of a pedestrian, who keeps it.",
            Parameter("speed", SPEED, low=0.0, high=TOP_SPEED), Command.SPEED),
    Builtin("OpenDoorAction", Kind.ACTION, "Open a door of a parked vehicle, once: it then stays as it is.",
            (Parameter("side"), Parameter("angle", ANGLE, "70 deg", 0.0, math.pi / 2.0),
             Parameter("time", TIME, "1 s", low=0.05))),
    Builtin("SetVelocityAction", Kind.ACTION,
            "Set the velocity, x to the east and y to the north: that of a vehicle along its heading.",
            (Parameter("xVel", SPEED, low=-TOP_SPEED, high=TOP_SPEED),
             Parameter("yVel", SPEED, low=-TOP_SPEED, high=TOP_SPEED),
             Parameter("zVel", default="0 m/s")), command=Command.SPEED),
    # -- library behaviours
    _behaviour("FollowTrajectoryBehavior", "Follow connected lanes, or a `Path`, to its end, slower in turns.",
               _SPEED, Parameter("trajectory"), _LATERAL, _OBEY, _LIMIT, _OFFSET),
    _behaviour("FollowLaneBehavior", "Follow the lane and whatever comes after it, straight on where that can be.",
               _SPEED, _LANE, _LATERAL, _OBEY, _OPPOSITE, _LIMIT, _OFFSET),
    _behaviour("TurnBehavior", "Follow a list of connected lanes for as long as the actor is in an intersection.",
               Parameter("trajectory"), Parameter("target_speed", SPEED, "6 m/s", low=0.0, high=TOP_SPEED), _LATERAL,
               _OFFSET),
    _behaviour("CarFollowingBehavior", "Follow a lane or trajectory behind the actor ahead on it (IDM).",
               _SPEED, *_car_following("0.73 m/s^2", "1.67 m/s^2"), _LATERAL, _OBEY, _LIMIT, _OFFSET),
    _behaviour("GapAcceptanceBehavior", "Follow a trajectory; give way at intersections until the gap is long enough.",
               _SPEED, Parameter("trajectory"), Parameter("critical_gap", TIME, "4.1 to 6.5 s by maneuver", low=0.0),
               _LATERAL, _OBEY, _LIMIT, _OFFSET, _YIELDS),
    _behaviour("GivingWayBehavior", "Follow a lane or trajectory; stop before where ways cross until it can clear it.",
               _SPEED, *_car_following("3 m/s^2", "3 m/s^2"), _LATERAL, _OBEY, _LIMIT, *_SIGHT, _OFFSET, _YIELDS),
    _behaviour("AutopilotBehavior", "Drive as `GivingWayBehavior` does; in Scenic it is the simulator's own driver.",
               _SPEED, Parameter("trajectory", default="the lane it is on"), _OFFSET, _YIELDS),
    _behaviour("LaneChangeBehavior", "Move over to another lane; ends when settled in it.",
               Parameter("laneSectionToSwitch"), _OPPOSITE, _SPEED, _DURATION, _LIMIT, _OFFSET),
    _behaviour("LaneChoosingBehavior", "Follow a lane (IDM), or one beside it that is better (MOBIL).",
               _SPEED, *_car_following("0.73 m/s^2", "1.67 m/s^2")[1:], Parameter("politeness", PURE, "0.2", low=0.0),
               Parameter("advantage", ACCELERATION, "0.1 m/s^2", low=0.0),
               Parameter("safe_deceleration", ACCELERATION, "4 m/s^2", low=0.0), _DURATION, _LATERAL, _OBEY, _LIMIT,
               _OFFSET),
    _behaviour("EmergencyBrakeBehavior", "Run another behavior; brake fully while a collision is close.",
               _INNER, Parameter("threshold", TIME, "as UN R157", low=0.0),
               Parameter("brake", PURE, "1", 0.0, 1.0, meaning=_BRAKE),
               Parameter("reference_deceleration", ACCELERATION, "6 m/s^2", 0.1),
               Parameter("delay", TIME, "0.35 s", low=0.0), Parameter("min_speed", SPEED, "0 m/s", 0.0, TOP_SPEED),
               Parameter("max_speed", SPEED, "none", 0.0, TOP_SPEED), *_SIGHT, Parameter("foresees", default="True"),
               Parameter("warning_ttc", TIME, "none", low=0.0), _YIELDS),
    _behaviour("ManualBrakeBehavior", "Run another behavior; brake as a person does after its first warning.",
               _INNER, Parameter("deceleration", ACCELERATION, "4 m/s^2", low=0.0),
               Parameter("delay", TIME, "1.2 s", low=0.0)),
    _behaviour("RSSBehavior", "Run another behavior; brake where responsibility-sensitive safety calls it dangerous.",
               _INNER, Parameter("response", TIME, "1 s", low=0.0),
               Parameter("leader_braking", ACCELERATION, "8 m/s^2", 0.1),
               Parameter("least_braking", ACCELERATION, "4 m/s^2", 0.1), _YIELDS),
    _behaviour("CarefulDriverBehavior", "Run another behavior; brake as the careful human driver of UN R157.",
               _INNER, Parameter("perception", TIME, "0.4 s", low=0.0), Parameter("delay", TIME, "0.75 s", low=0.0),
               Parameter("reference_deceleration", ACCELERATION, "0.774 * 9.81 m/s^2", 0.1), _YIELDS),
    _behaviour("FuzzySafetyBehavior", "Run another behavior; brake by the fuzzy safety model of UN R157.",
               _INNER, Parameter("delay", TIME, "0.75 s", low=0.0),
               Parameter("comfortable_deceleration", ACCELERATION, "4 m/s^2", low=0.01),
               Parameter("reference_deceleration", ACCELERATION, "6 m/s^2", 0.1),
               Parameter("leader_braking", ACCELERATION, "7 m/s^2", 0.1), _YIELDS),
    _behaviour("DriveAvoidingCollisions", "Follow the lane; brake fully while another vehicle is near.",
               Parameter("target_speed", SPEED, "25 m/s", 0.0, TOP_SPEED, ("speed",)),
               Parameter("avoidance_threshold", LENGTH, "10 m", low=0.0), _OFFSET),
    _behaviour("CyclingBehavior", "Ride at the edge of a lane or along a bicycle lane; look back before a turn across.",
               Parameter("target_speed", SPEED, "15 km/h", low=0.0, high=TOP_SPEED, aliases=("speed",)),
               *_car_following("1 m/s^2", "2 m/s^2"),
               Parameter("critical_gap", TIME, "4.1 to 6.5 s by maneuver", low=0.0),
               Parameter("edge", LENGTH, "1 m", low=0.0, high=WIDEST),
               Parameter("clearance", LENGTH, "0.5 m", low=0.0, high=WIDEST), _LATERAL, _OBEY, _LIMIT),
    _behaviour("ConstantThrottleBehavior", "Press the throttle for ever, without steering.",
               Parameter("x", PURE, low=0.0, high=1.0, meaning=_THROTTLE)),
    _behaviour("WalkForwardBehavior", "Walk straight ahead, for ever.",
               Parameter("speed", SPEED, "0.5 m/s", 0.0, TOP_SPEED)),
    _behaviour("WalkAlongBehavior", "Walk along a sidewalk, the way one faces, to its end.",
               Parameter("sidewalk"), _WALK, _GROUP, _OFFSET),
    _behaviour("UseCrossingBehavior", "Walk to the kerb, wait for a gap or for green, and cross the road.",
               Parameter("crossing"), _WALK, Parameter("gap", TIME, "its length / (1.2 m/s) + 3 s", low=0.0),
               Parameter("on_red", PURE, "0", 0.0, 1.0, meaning="a probability of walking on red, from 0 to 1"),
               _GROUP),
    _behaviour("CrossingBehavior", "Wait for another to come near, then cross its way as it arrives.",
               Parameter("reference_actor"), Parameter("min_speed", SPEED, "1 m/s", 0.0, TOP_SPEED),
               Parameter("threshold", LENGTH, "10 m", low=0.0),
               Parameter("final_speed", SPEED, "min_speed", 0.0, TOP_SPEED)),
    _behaviour("ConstantSpeedBehavior", "Hold a speed without steering, for ever.",
               Parameter("speed", SPEED, low=0.0, high=TOP_SPEED, aliases=("target_speed",))),
    _behaviour("BrakeBehavior", "Press the brake for ever.",
               Parameter("pedal", PURE, "1", 0.0, 1.0, ("brake",), _BRAKE)),
    _behaviour("AccelerateThenKeepBehavior", "Reach a speed over a distance, at a constant rate, and keep it.",
               Parameter("speed", SPEED, low=0.0, high=TOP_SPEED, aliases=("target_speed",)),
               Parameter("distance", LENGTH, low=0.01), Parameter("delay", TIME, "0 s", low=0.0)),
    _behaviour("BrakeToBehavior", "Brake down to a speed by a deceleration that builds up, and keep that speed.",
               Parameter("deceleration", ACCELERATION, low=0.0), Parameter("end_speed", SPEED, "0 m/s", 0.0, TOP_SPEED),
               Parameter("rise", TIME, "0 s", low=0.0), Parameter("delay", TIME, "0 s", low=0.0)),
    _behaviour("ExternalBehavior", "Do what a controller decides, which is named when the file is run (`--ego`).",
               Parameter("controller", default="the name of the object"),
               Parameter("trajectory", default="the lane it is on"), Parameter("actions", default='"pedals"'),
               Parameter("every", TIME, "each step", low=0.0), Parameter("delay", TIME, "0 s", low=0.0)),
    _behaviour("ReplayBehavior", "Move as recorded, from where it stands, to the end of the track.",
               Parameter("track"), Parameter("pace", PURE, "1", 0.01, 100.0)),
    _behaviour("IdleBehavior", "Do nothing, for ever: roll at constant speed."),
    # -- classes
    _class("Point", "A place."),
    _class("OrientedPoint", "A place with a heading."),
    _class("Car", "A passenger car (BMW 320i)."),
    _class("Truck", "A truck with two axles."),
    _class("Bus", "A city bus."),
    _class("Motorcycle", "A motorcycle with its rider."),
    _class("Bicycle", "A bicycle with its rider."),
    _class("Pedestrian", "A person on foot."),
    _class("Obstacle", "A thing in the way that never moves by itself."),
    _class("Object", "What classes without a base are made of: an `Obstacle`."),
    # -- constants
    _constant("network", "All roads: `network.intersections`, `network.lanes`."),
    _constant("intersection", "The intersection, when the map has just one."),
    _constant("road", "The region that all lanes and intersections cover."),
    _constant("sidewalk", "The region of all sidewalks."),
    _constant("curb", "All kerbs: the lines between carriageway and sidewalk."),
    _constant("shoulder", "The region of all shoulders, parking rows included."),
    _constant("roadOrShoulder", "The road with its shoulders, parking rows and bicycle lanes, up to the kerbs."),
    _constant("crossing", "The region of all crossings for people on foot."),
    _constant("bikeLane", "The region of all bicycle lanes."),
    _constant("parking", "The region of all parking rows."),
    _constant("roadDirection", "At every point the direction of the lane there."),
    _constant("ManeuverType", "`STRAIGHT`, `LEFT_TURN`, `RIGHT_TURN`, `U_TURN`."),
    _constant("globalParameters", "The params of this file, as attributes."),
    _constant("everywhere", "A region that holds all."),
    _constant("nowhere", "A region that holds nothing."),
    _constant("none", "No value; the same as `None`."),
    _constant("pi", "Ratio of a circle's circumference to its diameter."),
)  # fmt: skip

BUILTINS: dict[str, Builtin] = {row.name: row for row in _ROWS}

SPECIAL_NAMES = {
    "ego": "The vehicle under test: the first object of the scene.",
    "self": "Inside a behavior: the object that it drives.",
}
"""Names with a meaning of their own; `ego` is assigned by the file."""

REDUCERS: Mapping[str, str] = {
    "largest": "Largest value of the run, contact included.",
    "least": "Least value of the run, contact included.",
    "final": "Value at the last sample before the end.",
    "mean": "Mean over the time of the run.",
    "total": "Integral over the time of the run.",
}
"""Functions that reduce a value over a run to one number: only in `maximize` and `minimize`."""
OVER_RUN: Mapping[str, str] = {**REDUCERS, **{row.name: row.sentence for row in NAMED_RESULTS}}
"""Names with a meaning in a number of the whole run, unless the file redefines them."""

UNASSIGNABLE: Mapping[str, str] = {
    "self": "it is the object that a behavior drives",
    "none": "it means no value",
    "globalParameters": "it contains the params",
}
"""Names that a file cannot give a value to, and why."""


def names_of(kind: Kind) -> tuple[str, ...]:
    return tuple(row.name for row in _ROWS if row.kind is kind)
