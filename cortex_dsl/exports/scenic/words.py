"""Names in Scenic: what its driving library shares with this language, and what stands in for the rest."""

from collections.abc import Mapping
from dataclasses import dataclass

from engine.vocabulary import ActorKind

SHARED_FUNCTIONS = frozenset(
    {
        "Range", "Normal", "TruncatedNormal", "Uniform", "Discrete", "DiscreteRange", "abs", "min", "max", "sum",
        "hypot", "sin", "cos", "round", "len", "filter", "map", "any", "all", "range", "list", "tuple", "localPath",
        "withinDistanceToAnyObjs", "withinDistanceToAnyCars", "withinDistanceToAnyPedestrians",
        "withinDistanceToObjsInLane", "SetThrottleAction", "SetBrakeAction", "SetSpeedAction",
    }
)  # fmt: skip
"""Scenic has them with the same arguments, by position."""

MATH = frozenset({"sqrt", "tan", "asin", "acos", "atan", "atan2", "exp", "log", "floor", "ceil"})
"""Python's `math` has them."""

SEARCHED = {"VerifaiRange": "Range", "VerifaiDiscreteRange": "DiscreteRange", "VerifaiOptions": "Uniform"}

BEHAVIOURS: Mapping[str, tuple[str, ...]] = {
    "FollowTrajectoryBehavior": ("target_speed", "trajectory"),
    "FollowLaneBehavior": ("target_speed", "laneToFollow", "", "", "is_oppositeTraffic"),
    "LaneChangeBehavior": ("laneSectionToSwitch", "is_oppositeTraffic", "target_speed"),
    "DriveAvoidingCollisions": ("target_speed", "avoidance_threshold"),
    "ConstantThrottleBehavior": ("x",),
}
"""Behaviours of both libraries: their shared parameters in the order of ours; "" is one that Scenic's has not."""

ALIASES = {"speed": "target_speed", "threshold_distance": "thresholdDistance"}


@dataclass(frozen=True)
class StandIn:
    """A behaviour of our library, written for Scenic."""

    parameters: tuple[str, ...]
    """In the order of ours, with their defaults; "" is one that is left out."""
    body: tuple[str, ...]
    lacks: str = ""
    """What it does not do; "" where it does the same."""


STAND_INS: Mapping[str, StandIn] = {
    "IdleBehavior": StandIn((), ("while True:", "    wait")),
    "BrakeBehavior": StandIn(("pedal=1",), ("while True:", "    take SetBrakeAction(pedal)")),
    "ConstantSpeedBehavior": StandIn(("speed",), ("while True:", "    take SetSpeedAction(speed)")),
    "CarFollowingBehavior": StandIn(
        ("target_speed=10", "trajectory=None"),
        (
            "if trajectory is None:",
            "    do FollowLaneBehavior(target_speed=target_speed)",
            "else:",
            "    do FollowTrajectoryBehavior(target_speed=target_speed, trajectory=trajectory)",
        ),
        "it keeps its speed whoever is ahead",
    ),
    "GapAcceptanceBehavior": StandIn(
        ("target_speed=10", "trajectory=None"),
        ("do FollowTrajectoryBehavior(target_speed=target_speed, trajectory=trajectory)",),
        "it gives way to nobody",
    ),
    "EmergencyBrakeBehavior": StandIn(
        ("behavior",), ("do behavior",), "it drives as the behavior that it is given, without an emergency brake"
    ),
    "WalkForwardBehavior": StandIn(
        ("speed=0.5",),
        ("while True:", "    take SetWalkingDirectionAction(self.heading), SetWalkingSpeedAction(speed)"),
    ),
    "CrossingBehavior": StandIn(
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
        "slowerLane", "_slowerLane", "behavior", "name",
    }
)  # fmt: skip
"""Attributes of objects, and of the lanes that they are on, that mean the same in both."""

NO_LONGER = frozenset({"regionContainedIn", "requireVisible", "physics", "rolename", "heading", "position"})
"""Properties that are said otherwise, or that every object gets."""
LEFT_OUT_PARAMS = frozenset({"map", "carla_map", "map_options", "use2DMap", "timestep", "time_step"})
"""Params that the head of the file sets."""
