"""The way back: scenarios of timed polylines and the roads they play on, read as if strangers had written them.

xml, node (safe reading) -> parameters, catalogs -> planview, opendrive, positions -> entities, storyboard,
trajectories, tracks, motion, timeline -> openscenario. Whatever is wrong with a file is an `InterchangeError`.
"""

from engine.interchange.reading.opendrive import OdrLane, OdrNetwork, OdrRoad, OdrSection, read_opendrive
from engine.interchange.reading.openscenario import Imported, read_openscenario
from engine.interchange.reading.planview import Pose
from engine.interchange.reading.xml import LIMITS, Limits, read_xml

__all__ = [
    "LIMITS",
    "Imported",
    "Limits",
    "OdrLane",
    "OdrNetwork",
    "OdrRoad",
    "OdrSection",
    "Pose",
    "read_opendrive",
    "read_openscenario",
    "read_xml",
]
