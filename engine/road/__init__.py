"""Gridded intersections: lanes, maneuvers, paths as chains of lines and arcs, regions. Pure Python and numpy."""

from engine.road.build import build_network
from engine.road.errors import RoadError
from engine.road.network import Intersection, Lane, LaneRole, Leg, Maneuver, Network
from engine.road.outline import Outline, outline
from engine.road.overlap import Strip, conflict_areas
from engine.road.paths import PathBook, Pose, Primitive
from engine.road.regions import RegionBook
from engine.road.tables import road_tables

__all__ = [
    "Intersection",
    "Lane",
    "LaneRole",
    "Leg",
    "Maneuver",
    "Network",
    "Outline",
    "PathBook",
    "Pose",
    "Primitive",
    "RegionBook",
    "RoadError",
    "Strip",
    "build_network",
    "conflict_areas",
    "outline",
    "road_tables",
]
