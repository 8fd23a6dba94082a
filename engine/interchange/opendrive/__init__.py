"""Our roads as ASAM OpenDRIVE 1.7: every arm, every link between junctions and every turn of a lane is a road there.

Sources: ASAM OpenDRIVE 1.7.0, User Guide and schema (2021).
"""

from engine.interchange.opendrive.document import write_opendrive
from engine.interchange.opendrive.places import LanePlace, RoadMap, RoadPlace, road_map
from engine.interchange.opendrive.signals import SignalGroup, signal_groups

__all__ = [
    "LanePlace",
    "RoadMap",
    "RoadPlace",
    "SignalGroup",
    "road_map",
    "signal_groups",
    "write_opendrive",
]
