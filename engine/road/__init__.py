"""Roads from specifications: lanes, maneuvers, paths as chains of lines and arcs, regions. Pure Python and numpy."""

from engine.road.arrays import road_tables
from engine.road.build import build_network
from engine.road.network import Intersection, Lane, LaneRole, Maneuver, Network, Road
from engine.road.paths import PathBook, Pose, Primitive
from engine.road.specification import RoadError

__all__ = [
    "Intersection",
    "Lane",
    "LaneRole",
    "Maneuver",
    "Network",
    "PathBook",
    "Pose",
    "Primitive",
    "Road",
    "RoadError",
    "build_network",
    "road_tables",
]
