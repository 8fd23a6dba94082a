"""A case in OpenSCENARIO's maneuver mode, with files of its parameters' values.

numbers (what depends on params) -> triggers, starts, driving (one actor) -> planning (all of them) -> files
"""

from cortex_dsl.exports.maneuvers.files import maneuver_files
from cortex_dsl.exports.maneuvers.planning import maneuver_plan

__all__ = ["maneuver_files", "maneuver_plan"]
