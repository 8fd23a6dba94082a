"""Export of roads as ASAM OpenDRIVE 1.7: every arm, every link between junctions and every turn of a lane is a road.

Sources: ASAM OpenDRIVE 1.7.0, User Guide and schema (2021).
"""

from engine.interchange.opendrive.places import SOMEWHERE, LanePlace, RoadMap, road_map
from engine.interchange.opendrive.write import SignalGroup, signal_groups, write_opendrive

__all__ = [
    "SOMEWHERE",
    "LanePlace",
    "RoadMap",
    "SignalGroup",
    "road_map",
    "signal_groups",
    "write_opendrive",
]
