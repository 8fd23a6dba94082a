"""Gridded intersections: lanes, maneuvers, paths as chains of lines and arcs, regions. Pure Python and numpy."""

from engine.road.build import build_network
from engine.road.network import Intersection, Lane, LaneRole, Leg, Maneuver, Network, road_tables
from engine.road.paths import PathBook, Pose, Primitive
from engine.road.regions import RegionBook
from engine.road.specification import RoadError

__all__ = [
    "Intersection",
    "Lane",
    "LaneRole",
    "Leg",
    "Maneuver",
    "Network",
    "PathBook",
    "Pose",
    "Primitive",
    "RegionBook",
    "RoadError",
    "build_network",
    "road_tables",
]
