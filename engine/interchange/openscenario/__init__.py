"""ASAM OpenSCENARIO XML 1.0 to 1.3: a recording as a scenario for other players.

versions (differences) -> document (shared parts) -> write (an exact replay) | maneuvers (intentions of actors); read,
check.
"""

from engine.interchange.openscenario.write import write_trajectories

__all__ = ["write_trajectories"]
