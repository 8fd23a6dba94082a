"""Vocabulary of a Scenic file: names that its driving library shares with this language, and replacements for the rest.

The module also collects the head of a file and its inexpressible parts, and names the parts of our road.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from cortex_dsl.semantics.model.values import Centerline, DirectionField, Region, Value
from cortex_dsl.semantics.names.builtins import BUILTINS
from cortex_dsl.source import Source, Span
from cortex_dsl.syntax import nodes
from engine.errors import Signal
from engine.road.network import Intersection, Lane, LaneGroup, LaneRole, Maneuver, Network, Road
from engine.road.sections import LaneSection
from engine.tables import ROAD_REGION
from engine.vocabulary import ActorKind, ManeuverType

SHARED_FUNCTIONS = frozenset(
    {
        "Range", "Normal", "TruncatedNormal", "Uniform", "Discrete", "DiscreteRange", "abs", "min", "max", "sum",
        "hypot", "sin", "cos", "round", "len", "filter", "map", "any", "all", "range", "list", "tuple", "localPath",
        "withinDistanceToAnyObjs", "withinDistanceToAnyCars", "withinDistanceToAnyPedestrians",
        "withinDistanceToObjsInLane", "resample", "SetThrottleAction", "SetBrakeAction", "SetSpeedAction",
        "SetReverseAction", "SetWalkingSpeedAction",
    }
)  # fmt: skip
"""Scenic has them with the same arguments, by position."""

MATH = frozenset({"sqrt", "tan", "asin", "acos", "atan", "atan2", "exp", "log", "floor", "ceil"})
"""Python's `math` has them."""

SEARCHED = {"VerifaiRange": "Range", "VerifaiDiscreteRange": "DiscreteRange", "VerifaiOptions": "Uniform"}

BEHAVIOURS: Mapping[str, tuple[str, ...]] = {
    "FollowTrajectoryBehavior": ("target_speed", "trajectory"),
    "TurnBehavior": ("trajectory", "target_speed"),
    "FollowLaneBehavior": ("target_speed", "laneToFollow", "", "", "is_oppositeTraffic"),
    "LaneChangeBehavior": ("laneSectionToSwitch", "is_oppositeTraffic", "target_speed"),
    "DriveAvoidingCollisions": ("target_speed", "avoidance_threshold"),
    "ConstantThrottleBehavior": ("x",),
}
"""Behaviours of both libraries: their shared parameters in the order of ours; "" for one that Scenic's lacks."""

ALIASES = {"speed": "target_speed", "threshold_distance": "thresholdDistance"}


@dataclass(frozen=True)
class ScenicReplacement:
    """A behaviour of our library, written for Scenic."""

    parameters: tuple[str, ...]
    """Parameters in the order of ours, with their defaults; "" for an omitted parameter."""
    body: tuple[str, ...]
    lacks: str = ""
    """Missing part of the behaviour; "" if it is equivalent."""


STAND_INS: Mapping[str, ScenicReplacement] = {
    "IdleBehavior": ScenicReplacement((), ("while True:", "    wait")),
    "BrakeBehavior": ScenicReplacement(
        ("pedal=1",), ("while True:", "    take SetBrakeAction(pedal)"), "the pedal stays pressed when it is over"
    ),
    "ConstantSpeedBehavior": ScenicReplacement(("speed",), ("while True:", "    take SetSpeedAction(speed)")),
    "CarFollowingBehavior": ScenicReplacement(
        ("target_speed=10", "trajectory=None"),
        (
            "if trajectory is None:",
            "    do FollowLaneBehavior(target_speed=target_speed)",
            "else:",
            "    do FollowTrajectoryBehavior(target_speed=target_speed, trajectory=trajectory)",
        ),
        "it keeps its speed, even behind other actors",
    ),
    "GapAcceptanceBehavior": ScenicReplacement(
        ("target_speed=10", "trajectory=None"),
        ("do FollowTrajectoryBehavior(target_speed=target_speed, trajectory=trajectory)",),
        "it never gives way",
    ),
    **dict.fromkeys(
        ("GivingWayBehavior", "AutopilotBehavior"),
        ScenicReplacement(
            ("target_speed=10", "trajectory=None"),
            (
                "if trajectory is None:",
                "    do FollowLaneBehavior(target_speed=target_speed)",
                "else:",
                "    do FollowTrajectoryBehavior(target_speed=target_speed, trajectory=trajectory)",
            ),
            "it neither gives way nor keeps its distance",
        ),
    ),
    "EmergencyBrakeBehavior": ScenicReplacement(
        ("behavior",), ("do behavior",), "it drives as the behavior that it is given, without an emergency brake"
    ),
    **dict.fromkeys(
        ("RSSBehavior", "CarefulDriverBehavior", "FuzzySafetyBehavior"),
        ScenicReplacement(
            ("behavior",), ("do behavior",), "it drives as the behavior that it is given, and brakes for no other actor"
        ),
    ),
    "LaneChoosingBehavior": ScenicReplacement(
        ("target_speed=10",),
        ("do FollowLaneBehavior(target_speed=target_speed)",),
        "it keeps its lane and its speed, even behind other actors",
    ),
    "WalkForwardBehavior": ScenicReplacement(
        ("speed=0.5",),
        ("while True:", "    take SetWalkingDirectionAction(self.heading), SetWalkingSpeedAction(speed)"),
    ),
    "CrossingBehavior": ScenicReplacement(
        ("reference_actor", "min_speed=1", "threshold=10", ""),
        (
            "while (distance from self to reference_actor) > threshold:",
            "    wait",
            "while True:",
            "    take SetWalkingDirectionAction(self.heading), SetWalkingSpeedAction(min_speed)",
        ),
        "it walks at its least speed, and does not time its arrival",
    ),
}

CLASSES = frozenset({"Car", "Pedestrian", "Object", "Point", "OrientedPoint"})
"""Classes that Scenic's driving library has."""
WHEELED = frozenset({ActorKind.CAR, ActorKind.TRUCK, ActorKind.BUS, ActorKind.MOTORCYCLE, ActorKind.BICYCLE})

ROAD_ATTRIBUTES = frozenset(
    {"startLane", "connectingLane", "endLane", "centerline", "lane", "laneSection", "laneGroup", "road", "type"}
)
"""Attributes that lead from one part of the road to another by the same name in both."""
OBJECT_ATTRIBUTES = frozenset(
    {
        "position", "speed", "width", "length", "lane", "_lane", "laneSection", "_laneSection", "laneGroup",
        "_laneGroup", "road", "_road", "oppositeLaneGroup", "_oppositeLaneGroup", "distanceToClosest", "viewAngle",
        "visibleDistance", "laneToLeft", "_laneToLeft", "laneToRight", "_laneToRight", "fasterLane", "_fasterLane",
        "slowerLane", "_slowerLane", "behavior", "name", "velocity", "visibleRegion", "angularSpeed",
    }
)  # fmt: skip
"""Attributes of objects, and of the lanes that they are on, that mean the same in both."""

NO_LONGER = frozenset({"regionContainedIn", "requireVisible", "physics", "rolename", "heading", "position"})
"""Properties that are said otherwise, or that every object gets."""
LEFT_OUT_PARAMS = frozenset({"map", "carla_map", "map_options", "use2DMap", "timestep", "time_step"})
"""Params that the head of the file sets."""

# -- collected while a file is written: lines for its head, and inexpressible parts ------------------------------------


class Unsaid(Signal):
    """Scenic has no words for an expression."""

    def __init__(self, what: str, span: Span) -> None:
        self.what = what
        """Of which a sentence can say "Scenic has no …"."""
        self.span = span
        super().__init__(what)


@dataclass
class OutputBuffer:
    """Filled from top to bottom; its order is that of the file."""

    source: Source
    lookups: dict[str, str] = field(default_factory=dict)
    """Value by name: the parts of the road that the file names."""
    mathematics: set[str] = field(default_factory=set)
    classes: dict[str, str] = field(default_factory=dict)
    """Base by name: classes that Scenic's library has not."""
    stand_ins: dict[str, None] = field(default_factory=dict)
    """Behaviours that the file has to bring along."""
    remarks: dict[str, None] = field(default_factory=dict)

    def remark(self, text: str, span: Span | None = None) -> None:
        """Add a remark, with its line in the file of the author."""
        place = "" if span is None else f"line {self.source.position(span.start).line}: "
        self.remarks[f"{place}{text}"] = None

    def free_name(self, wanted: str) -> str:
        """Return a name like the wanted one that the author's file does not use."""
        name = re.sub(r"\W+", "_", wanted)
        while re.search(rf"\b{name}\b", self.source.whole):
            name += "_"
        return name


def verbatim(text: str) -> nodes.Name:
    """Return a text that is written to the file unchanged: the printer of trees writes names as they are."""
    return nodes.Name(text, span=NOWHERE)


def comments(text: str) -> tuple[nodes.Statement, ...]:
    """Return every line of a text behind a number sign, as comments."""
    return tuple(nodes.ExpressionStatement(verbatim(f"# {each}".rstrip()), span=NOWHERE) for each in text.splitlines())


def is_comment(node: nodes.Statement) -> bool:
    value = node.value if isinstance(node, nodes.ExpressionStatement) else None
    return isinstance(value, nodes.Name) and value.id.startswith("#")


NOWHERE = Span(0, 0)

# -- arguments of a call in Scenic's form: names of parameters are ours, their order is shared -------------------------


def by_position(node: nodes.Call, name: str) -> tuple[nodes.Argument, ...]:
    """The arguments without names, which Scenic does not share, each in its place."""
    parameters = BUILTINS[name].parameters
    places = {each: place for place, row in enumerate(parameters) for each in (row.name, *row.aliases)}
    plain = [each for each in node.arguments if each.name is None]
    named = sorted((each for each in node.arguments if each.name), key=lambda each: places[each.name or ""])
    if [places[each.name or ""] for each in named] != list(range(len(plain), len(node.arguments))):
        raise Unsaid(f"an argument of `{name}` after one that is left out", node.span)
    return (*plain, *(replace(each, name=None) for each in named))


def the_one(node: nodes.Call) -> nodes.Argument:
    """Return the single argument of an action."""
    (argument,) = node.arguments
    if isinstance(argument.value, nodes.Starred):
        raise Unsaid("arguments of an action in a list", node.span)
    return argument


def left_out(argument: nodes.Argument, number: int, name: str) -> str:
    parameters = BUILTINS[name].parameters
    return f"`{argument.name or parameters[number].name}`, which Scenic's does not have"


# -- how Scenic finds a part of our road in the exported map: by a point that no other part has ------------------------


def place_text(sheet: OutputBuffer, network: Network, value: Value) -> str | None:
    """An expression of Scenic for a part of the road, or a list of such; None if the value is nothing of the kind."""
    match value:
        case Lane() if value.role is LaneRole.CONNECTING:
            maneuver = next(each for each in network.maneuvers if each.connecting == value.id)
            return f"{_maneuver(sheet, maneuver)}.connectingLane"
        case Lane():
            return _lane(sheet, value)
        case Maneuver():
            return _maneuver(sheet, value)
        case LaneSection():
            return _named(sheet, f"section_{value.name}", f"network.laneSectionAt({_middle(value.lane)})")
        case LaneGroup():
            return _named(sheet, f"group_{value.name}", f"network.laneGroupAt({_middle(value.lanes[0])})")
        case Road():
            return _named(sheet, f"road_{value.name}", f"network.roadAt({_middle(value.lanes[0])})")
        case Intersection():
            return _intersection(sheet, value)
        case Network():
            return "network"
        case Centerline():
            return f"{place_text(sheet, network, value.lane)}.centerline"
        case Region():
            return _region(sheet, network, value)
        case DirectionField():
            return "roadDirection"
        case ManeuverType():
            return f"ManeuverType.{value.name}"
        case tuple() if value:
            texts = [place_text(sheet, network, item) for item in value]
            return None if None in texts else f"[{', '.join(text for text in texts if text is not None)}]"
    return None


def _lane(sheet: OutputBuffer, lane: Lane) -> str:
    return _named(sheet, f"lane_{lane.name}", f"network.laneAt({_middle(lane)})")


def _maneuver(sheet: OutputBuffer, maneuver: Maneuver) -> str:
    start, end = _lane(sheet, maneuver.start_lane), _lane(sheet, maneuver.end_lane)
    found = f"next(m for m in {start}.maneuvers if m.endLane is {end})"
    return _named(sheet, f"maneuver_{maneuver.start_lane.name}_to_{maneuver.end_lane.name}", found)


def _intersection(sheet: OutputBuffer, intersection: Intersection) -> str:
    only = len(intersection.network.intersections) == 1
    name = "intersection" if only else f"intersection_{intersection.name}"
    x, y = intersection.center
    found = f"network.intersectionAt(({x!r}, {y!r}))"
    if only:  # the name that the author's file has for it, too
        sheet.lookups.setdefault(name, found)
        return name
    return _named(sheet, name, found)


def area_of(sheet: OutputBuffer, intersection: Intersection) -> str:
    """Return the outline of an intersection, to a millionth of a metre.

    Scenic's own outline is up to 0.08 m off: it uses twenty points of each lane of the map.
    """
    edges = intersection.network.regions.shape(intersection.region).edges[:, :2]
    corners = ", ".join(f"({round(x, 6)}, {round(y, 6)})" for x, y in edges.tolist())
    only = len(intersection.network.intersections) == 1
    name = "area_of_intersection" if only else f"area_of_{intersection.name}"
    return _named(sheet, name, f"PolygonalRegion([{corners}])")


def _region(sheet: OutputBuffer, network: Network, region: Region) -> str | None:
    if region.id == ROAD_REGION:
        return "road"
    for element in (*network.intersections, *network.lanes):
        if element.region == region.id:
            return place_text(sheet, network, element)
    return None


def _named(sheet: OutputBuffer, wanted: str, value: str) -> str:
    """The name of a part of the road, which is looked up once, at the top of the file."""
    known = {found: name for name, found in sheet.lookups.items()}
    if value not in known:
        known[value] = sheet.free_name(wanted)
        sheet.lookups[known[value]] = value
    return known[value]


def _middle(lane: Lane) -> str:
    """A point that lies on this lane alone."""
    pose = lane.network.paths.pose(lane.path, 0.5 * lane.length)
    return f"({pose.x!r}, {pose.y!r})"
