"""Names of the elements of a scenario that this reader reads; `engine.unread` notes all other elements."""

from collections.abc import Collection, Mapping

from engine.interchange.openscenario.read.actions import ACTED_ON
from engine.interchange.openscenario.read.entities import BODIES
from engine.interchange.openscenario.read.motion import KINDS

READ: Mapping[str, Collection[str] | None] = dict.fromkeys(
    (
        *("OpenSCENARIO", "FileHeader", "ParameterDeclarations", "CatalogLocations", "RoadNetwork", "LogicFile"),
        *("Entities", "ScenarioObject", "CatalogReference", "Properties", "Property", *BODIES, "BoundingBox", "Center"),
        *("Dimensions", "Performance", "Axles", "FrontAxle", "RearAxle", "Storyboard", "Init", "Actions", "Private"),
        *("PrivateAction", "GlobalAction", "EntityAction", *ACTED_ON, "Position", *KINDS, "Orientation"),
        *("LongitudinalAction", "LateralAction", "RoutingAction", "SpeedActionDynamics", "SpeedActionTarget"),
        *("AbsoluteTargetSpeed", "Trajectory", "TrajectoryRef", "Shape", "Polyline", "Vertex", "TimeReference"),
        *("Timing", "TrajectoryFollowingMode", "Story", "Act", "ManeuverGroup", "Actors", "EntityRef", "Maneuver"),
        *("Event", "Action", "StartTrigger", "StopTrigger", "ConditionGroup", "Condition", "ByValueCondition"),
        *(
            "ParameterDeclaration",
            "ParameterAssignment",
            "SimulationTimeCondition",
            "EnvironmentAction",
            "Environment",
            "Weather",
            "ParameterAssignments",
        ),
    )
) | {
    "WorldPosition": ("x", "y", "z", "h"),
    "RelativeWorldPosition": ("entityRef", "dx", "dy"),
    "RelativeObjectPosition": ("entityRef", "dx", "dy"),
    "Orientation": ("type", "h"),
    "Trajectory": ("name",),
    "SpeedActionDynamics": ("dynamicsShape", "dynamicsDimension"),
}
"""Elements of a scenario that are read, or contain elements that are read, and the attributes that are read of elements
whose other attributes change a run.
"""
REMARKED = ("TrafficSignals", "ByEntityCondition")
"""Elements with remarks of their own, in addition to actions that are not replayed."""
