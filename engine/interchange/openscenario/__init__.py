"""ASAM OpenSCENARIO XML 1.0 to 1.3: a recording as a scenario for other players.

versions (what differs) -> names, document, entities (shared parts) -> trajectory, storyboard, signals -> writing
"""

from engine.interchange.openscenario.write import write_trajectories

__all__ = ["write_trajectories"]
