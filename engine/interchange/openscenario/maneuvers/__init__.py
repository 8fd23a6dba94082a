"""Maneuver mode of OpenSCENARIO: what actors intend, in speeds, routes and triggers over parameters.

formula -> plan -> bends (who plans) | places, conditions -> storyboard -> writing (who writes); distributions
"""

from engine.interchange.openscenario.maneuvers.distributions import champions_file, is_listed, ranges_file
from engine.interchange.openscenario.maneuvers.plan import ManeuverPlan
from engine.interchange.openscenario.maneuvers.writing import write_maneuvers

__all__ = ["ManeuverPlan", "champions_file", "is_listed", "ranges_file", "write_maneuvers"]
