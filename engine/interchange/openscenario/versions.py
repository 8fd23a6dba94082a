"""What differs between the versions of OpenSCENARIO XML, as far as it concerns what is written here.

Source: the schemas of OpenSCENARIO 1.0.0, 1.1.0, 1.2.0 and 1.3.0 (ASAM e.V.).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from engine.interchange.export import ExportOptions

BEFORE = 0.001
"""How long before its instant a "greater than" condition is set [s]: above readers' tolerance, below any step."""


@dataclass(frozen=True)
class Version:
    """One version, by what a writer must know of it."""

    name: str
    minor: int
    priority: str
    """Of an event that takes over from others: 1.2 renamed it."""
    rule: str
    """Of a condition on the time: 1.0 knows no "greater or equal"."""
    trajectory_in_reference: bool
    """Whether a trajectory stands in a `TrajectoryRef`."""
    vehicle_mass: bool
    """Whether a vehicle has a mass."""
    pedestrian_model: bool
    """Whether a pedestrian must name a model."""
    reverse_speed: bool
    """Whether a start with negative speed can be said: ScenarioRunner, which insists on 1.0, refuses it."""

    def time_value(self, seconds: float) -> float:
        """What to compare with for a condition to hold from an instant on [s]."""
        return seconds if self.rule == "greaterOrEqual" else seconds - BEFORE


VERSIONS: Mapping[str, Version] = MappingProxyType(
    {
        "1.0": Version("1.0", 0, "overwrite", "greaterThan", False, False, True, False),
        "1.1": Version("1.1", 1, "overwrite", "greaterOrEqual", True, True, False, True),
        "1.2": Version("1.2", 2, "override", "greaterOrEqual", True, True, False, True),
        "1.3": Version("1.3", 3, "override", "greaterOrEqual", True, True, False, True),
    }
)


def version_of(options: ExportOptions) -> Version:
    """The version that is asked for."""
    return VERSIONS[options.osc]
