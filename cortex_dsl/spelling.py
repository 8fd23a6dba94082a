"""The answer to a misspelt or foreign word: the nearest correct word, the synonym of this language, or a list."""

from collections.abc import Iterable, Mapping
from types import MappingProxyType

from engine.errors import nearest

ELSEWHERE: Mapping[str, str] = MappingProxyType(
    {
        "inf": "numbers are finite here: write a large one, or leave the limit out",
        "nan": "every number has a value here",
        "print": "write `record ego.speed` to have a value shown when a run is over",
        "distance": "write `distance from a to b`, without the brackets of a call",
        "math": "functions such as `sqrt`, `sin` and `abs` are built in: write them without `math.`",
        "np": "functions such as `sqrt`, `sin` and `abs` are built in",
        "random": "write a distribution, such as `Range(low, high)` or `Uniform(a, b)`",
        "sleep": "write `do IdleBehavior() for 3 s`",
        "choose": "name what to choose from, as in `do choose A(), B()`",
        "shuffle": "name what to run, as in `do shuffle A(), B()`",
        "light": "write `signals()` to have lights; `FollowLaneBehavior(5 m/s, obey_signals=True)` stops at red ones",
        **dict.fromkeys(("pavement", "footpath", "footway"), "write `sidewalk`, and `sidewalk=2 m` in the `map` line"),
        **dict.fromkeys(("crosswalk", "zebra"), "write `crossing`, with `sidewalk=2 m, crossings=True` in `map`"),
        **dict.fromkeys(("cycleLane", "bicycleLane"), "write `bikeLane`, and `bike_lane=1.8 m` in the `map` line"),
        "kerb": "write `curb`, the region of all kerbs, or `lane.group.curb`",
        "verge": "write `shoulder`, and `shoulder=1.5 m` in the `map` line",
        **dict.fromkeys(
            ("SetPositionAction", "OffsetAction", "SetTransformAction", "ActorTransformSetter"),
            "no object jumps during a run: place it with `at` before the run, and drive or walk there",
        ),
        **dict.fromkeys(
            ("BasicAgentBehavior", "BasicAgent", "LocalPlanner"),
            "write `with behavior FollowLaneBehavior(10 m/s)`, or `AutopilotBehavior`, which gives way",
        ),
        **dict.fromkeys(
            ("TimeSeries", "VerifaiTimeSeries"),
            "a param has one value for the whole run; what a behavior draws it draws anew each time, as in "
            "`take SetThrottleAction(Range(0, 1))`",
        ),
        "SetHandBrakeAction": "a vehicle has one brake: `SetBrakeAction(1)`",
        "SetAutopilotAction": "give it a behavior: `AutopilotBehavior()`",
        "PolygonalVectorField": "write a `VectorField`, with a function that tests where it is: `p in region`",
        "angularSpeed": "a vehicle turns by its wheels: `take SetSteerAction(5 deg)`",
        **dict.fromkeys(("collision", "CollisionTest"), "contact is always detected, and ends the run"),
        **dict.fromkeys(
            ("ttc", "TTC", "min_ttc", "InTimeToArrivalToVehicle", "TimeToCollisionCondition"),
            "write `timeToCollision(ego, other)`; the least of a run is `least(timeToCollision(ego, other))`, in "
            "`maximize` and `minimize`",
        ),
        **dict.fromkeys(("pet", "PET"), "`maximize` and `minimize` have `post_encroachment_time`, the least of a run"),
        **dict.fromkeys(
            ("thw", "THW", "headway", "TimeHeadwayCondition"), "write `(distance from ego to other) / ego.speed`"
        ),
        **dict.fromkeys(
            ("TrafficManager", "traffic_manager", "tm"),
            "each vehicle has a driver of its own: `with behavior AutopilotBehavior()`",
        ),
        **dict.fromkeys(
            ("VehicleControl", "RegulatedControlAction", "apply_control"),
            "write `take SetThrottleAction(0.5), SetSteerAction(2 deg)`",
        ),
        **dict.fromkeys(
            ("AccelerateToVelocity", "AccelerateToCatchUp"),
            "write `do ConstantThrottleBehavior(0.5) until self.speed > 10 m/s`",
        ),
        **dict.fromkeys(
            ("InTriggerDistanceToVehicle", "InTriggerDistanceToLocation", "RelativeDistanceCondition", "get_distance"),
            "write a condition, as in `(distance from ego to other) < 10 m`",
        ),
        "InTriggerDistanceToNextIntersection": "write a condition, as in `(distance from ego to intersection) < 10 m`",
        **dict.fromkeys(("carla", "world", "client"), "nothing is imported: road, vehicles and drivers are built in"),
        **dict.fromkeys(
            ("blueprint", "blueprint_library", "spawn_actor", "ActorSource"),
            "a class says what an object is, as in `new Truck on road, with length 9 m`",
        ),
        **dict.fromkeys(
            ("weather", "Weather", "WeatherParameters", "EnvironmentAction"),
            "before all objects write `environment(friction=0.6, sight=50 m, light=0.5)`",
        ),
        **dict.fromkeys(("egoSpeed", "ego_speed", "get_speed", "get_velocity"), "write `ego.speed`"),
        **dict.fromkeys(("get_location", "get_transform"), "write `ego.position` and `ego.heading`"),
        **dict.fromkeys(
            ("simulationTime", "SimulationTimeCondition", "GameTime", "game_time", "elapsed_seconds"),
            "write `simulation().currentTime`, which counts steps",
        ),
        **dict.fromkeys(("timestep", "dt", "fixed_delta_seconds"), "write `simulation().timestep`"),
        "is_junction": "write `ego in intersection`",
        "TriggerVelocity": "write a condition, as in `ego.speed > 10 m/s`",
        "StandStill": "write a condition, as in `ego.speed < 0.1 m/s`",
        **dict.fromkeys(("TimeOut", "timeout"), "write `terminate after 20 s`"),
        "MaxVelocityTest": "write `require always ego.speed < 50 km/h`",
        **dict.fromkeys(("OffRoadTest", "KeepLaneTest"), "write `require always ego in road`"),
        **dict.fromkeys(("VerifaiParameter", "VerifaiSampler"), "write a distribution, such as `Range(low, high)`"),
        **dict.fromkeys(
            ("specification", "falsifier", "rho"),
            "write `expect` with a condition: a search looks for runs that break it",
        ),
        **dict.fromkeys(
            ("north", "east", "south", "west"),
            "write an angle, from east to north: `0 deg` is east, `90 deg` north, `180 deg` west, `-90 deg` south; an "
            'arm of an intersection is a text, as in `intersection.route("south", "north")`',
        ),
        "STRAIGHT": "write `ManeuverType.STRAIGHT`",
        "LEFT_TURN": "write `ManeuverType.LEFT_TURN`",
        "RIGHT_TURN": "write `ManeuverType.RIGHT_TURN`",
        "U_TURN": "write `ManeuverType.U_TURN`",
    }
)
"""Names of Scenic and Python that do not exist here, and their replacements."""

SYNONYMS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "velocity": ("speed", "target_speed"),
        "initialspeed": ("speed",),
        "maxspeed": ("target_speed",),
        "speedlimit": ("target_speed",),
        "orientation": ("heading",),
        "rotation": ("heading",),
        "angle": ("heading",),
        "yaw": ("heading",),
        "direction": ("heading",),
        "location": ("position",),
        "pos": ("position",),
        "controller": ("behavior",),
        "behaviour": ("behavior",),
        "route": ("trajectory",),
        "path": ("trajectory",),
        "waypoints": ("trajectory",),
        "arms": ("ways",),
        "legs": ("ways",),
        "roads": ("ways",),
        "radius": ("corner_radius",),
        "numlanes": ("lanes",),
        "leftlane": ("laneToLeft", "adjacentLanes"),
        "rightlane": ("laneToRight", "adjacentLanes"),
        "next": ("successors",),
        "previous": ("predecessors",),
        "trafficlight": ("signals", "signal"),
        "trafficlights": ("signals", "signal"),
        "brake": ("SetBrakeAction",),
        "accelerate": ("SetThrottleAction",),
        "throttle": ("SetThrottleAction",),
        "steer": ("SetSteerAction",),
        "vehicle": ("Car",),
        **dict.fromkeys(("sedan", "suv", "taxi", "automobile", "auto", "jeep"), ("Car",)),
        **dict.fromkeys(("van", "lorry", "hgv", "pickup", "trailer", "tractor", "semi", "ambulance"), ("Truck",)),
        **dict.fromkeys(("coach", "tram", "minibus"), ("Bus",)),
        **dict.fromkeys(("motorbike", "moped", "scooter"), ("Motorcycle",)),
        **dict.fromkeys(("bike", "cycle"), ("Bicycle",)),
        **dict.fromkeys(("child", "kid", "human", "man", "woman", "jogger"), ("Pedestrian",)),
        **dict.fromkeys(
            ("box", "crate", "wall", "pole", "cone", "barrier", "prop", "trash", "debris", "garbage", "kiosk", "bench"),
            ("Obstacle",),
        ),
        **dict.fromkeys(("vendingmachine", "trafficwarning", "trafficcone", "mailbox", "container"), ("Obstacle",)),
        "cyclist": ("Bicycle",),
        "person": ("Pedestrian",),
        "walker": ("Pedestrian",),
        **dict.fromkeys(("npc", "npccar", "lead", "leadcar", "egocar", "egovehicle"), ("Car",)),
        "way": ("ways", "road"),
        "waypoint": ("OrientedPoint",),
        "hero": ("ego",),
        "deceleration": ("maxBraking",),
        "idle": ("IdleBehavior",),
        **dict.fromkeys(
            ("idm", "idmbehavior", "followleadbehavior", "followleader", "followvehicle", "followvehiclebehavior"),
            ("CarFollowingBehavior",),
        ),
        **dict.fromkeys(
            ("basicagent", "basicagentbehavior", "behavioragent", "changeautopilot"), ("AutopilotBehavior",)
        ),
        **dict.fromkeys(("drivingbehavior", "changeautopilot", "setautopilot"), ("AutopilotBehavior",)),
        **dict.fromkeys(("stopbehavior", "stopvehicle", "brakingbehavior", "handbrakevehicle"), ("BrakeBehavior",)),
        **dict.fromkeys(("emergencystop", "decelerate"), ("BrakeBehavior",)),
        **dict.fromkeys(
            ("keepvelocity", "constantvelocityagent", "constantvelocitybehavior"), ("ConstantSpeedBehavior",)
        ),
        **dict.fromkeys(
            ("waypointfollower", "followwaypointsbehavior", "trackwaypointsaction", "setdestination", "localplanner"),
            ("FollowTrajectoryBehavior",),
        ),
        **dict.fromkeys(("lanechange", "cutin", "cutinbehavior", "overtakebehavior"), ("LaneChangeBehavior",)),
        **dict.fromkeys(("syncarrival", "crosswalkbehavior"), ("CrossingBehavior",)),
        **dict.fromkeys(("yieldbehavior", "givewaybehavior"), ("GivingWayBehavior",)),
        "accelerateforwardbehavior": ("ConstantThrottleBehavior",),
        **dict.fromkeys(("walkbehavior", "walkercontrol"), ("WalkForwardBehavior",)),
        "setwalkaction": ("SetWalkingSpeedAction",),
        "setgearaction": ("SetReverseAction",),
        "settrafficlightaction": ("setClosestTrafficLightStatus",),
    }
)
"""Common names of things that have another name here; small letters, no underscores."""

MOST_CHOICES = 24
"""Names that an answer lists; of more, none would be read."""


_RANGES: Mapping[str, str] = MappingProxyType(
    {
        "speed": "Range(20, 60) km/h",
        "veloc": "Range(20, 60) km/h",
        "dist": "Range(5, 40) m",
        "gap": "Range(2, 10) m",
        "brak": "Range(0, 1)",
        "throttle": "Range(0, 1)",
        "time": "Range(0, 3) s",
        "delay": "Range(0, 3) s",
        "angle": "Range(-10, 10) deg",
    }
)
"""Ranges as they are usual for params of which the name has a part."""


def likely_range(param: str) -> str:
    """A range that a param of this name may have."""
    return next((usual for part, usual in _RANGES.items() if part in param.lower()), "Range(LOW, HIGH)")


def class_called(word: str, classes: Iterable[str]) -> str | None:
    """Return the class that a common word means, such as `Truck` for `lorry`; None for other words."""
    known = {name.lower(): name for name in classes}
    folded = word.lower().replace("_", "").rstrip("0123456789")
    return next((known[n.lower()] for n in (folded, *SYNONYMS.get(folded, ())) if n.lower() in known), None)


def did_you_mean(word: str, candidates: Iterable[str]) -> str:
    """A sentence for a diagnostic's cure: the nearest name, or the list of valid ones when it is short."""
    choices = sorted(set(candidates))
    folded = word.lower().replace("_", "")
    same = next((choice for choice in choices if choice.lower().replace("_", "") == folded), None)
    if same is None and word in ELSEWHERE:
        return ELSEWHERE[word]
    meant = same or next((name for name in SYNONYMS.get(folded, ()) if name in choices), None)
    if (match := meant or nearest(word, choices)) is not None:
        return f"did you mean `{match}`?"
    if 0 < len(choices) <= MOST_CHOICES:
        return "valid here: " + ", ".join(f"`{choice}`" for choice in choices)
    return ""
