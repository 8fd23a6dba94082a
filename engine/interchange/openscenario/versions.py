"""Differences between the versions of OpenSCENARIO XML that affect the writers.

Source: the schemas of OpenSCENARIO 1.0.0, 1.1.0, 1.2.0 and 1.3.0 (ASAM e.V.).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from engine.interchange.contract import ExportOptions

BEFORE = 0.001
"""Time by which a "greater than" condition precedes its instant [s]: above readers' tolerance, below any step."""


@dataclass(frozen=True, kw_only=True)
class Version:
    """One version, by the properties that a writer needs."""

    name: str
    minor: int
    priority: str
    """Priority of an event that replaces active events: 1.2 renamed it."""
    rule: str
    """Rule of a condition that holds from a value on: 1.0 has no "greater or equal"."""
    integer: str
    """Type of a parameter that is a whole number: 1.2 renamed it."""
    straight_distance: str
    """Type of a straight distance."""
    distance_attributes: Mapping[str, str]
    """Attributes of a condition that make its distance or time to collision straight."""
    trajectory_in_reference: bool
    """True if a trajectory is in a `TrajectoryRef`."""
    vehicle_mass: bool
    """True if a vehicle has a mass."""
    pedestrian_model: bool
    """True if a pedestrian must name a model."""
    reverse_speed: bool
    """True if an initial speed may be negative: ScenarioRunner, which requires 1.0, rejects it."""
    late_entities: bool
    """True if an entity may appear later: ScenarioRunner, which requires 1.0, places every entity at the start."""
    has_expressions: bool
    """True if an attribute may be a formula, not only a bare parameter."""
    has_constraints: bool
    """True if a parameter may state its range."""
    whole_environment: bool
    """True if an environment must state time of day, sun, fog, rain and road."""
    has_distributions: bool
    """True if files of parameter values exist."""

    def time_value(self, seconds: float) -> float:
        """Return the value to compare with for a condition that holds from an instant on [s]."""
        return seconds if self.rule == "greaterOrEqual" else seconds - BEFORE


_FIRST = Version(
    name="1.0",
    minor=0,
    priority="overwrite",
    rule="greaterThan",
    integer="integer",
    straight_distance="cartesianDistance",
    distance_attributes=MappingProxyType({"alongRoute": "false"}),
    trajectory_in_reference=False,
    vehicle_mass=False,
    pedestrian_model=True,
    reverse_speed=False,
    late_entities=False,
    has_expressions=False,
    has_constraints=False,
    whole_environment=True,
    has_distributions=False,
)
_SECOND = replace(
    _FIRST,
    name="1.1",
    minor=1,
    rule="greaterOrEqual",
    straight_distance="euclidianDistance",
    distance_attributes=MappingProxyType({"relativeDistanceType": "euclidianDistance"}),
    trajectory_in_reference=True,
    vehicle_mass=True,
    pedestrian_model=False,
    reverse_speed=True,
    late_entities=True,
    has_expressions=True,
    has_constraints=True,
    whole_environment=False,
    has_distributions=True,
)
_THIRD = replace(_SECOND, name="1.2", minor=2, priority="override", integer="int")
_FOURTH = replace(_THIRD, name="1.3", minor=3)

VERSIONS: Mapping[str, Version] = MappingProxyType({each.name: each for each in (_FIRST, _SECOND, _THIRD, _FOURTH)})
"""Versions by name, each as a change of the one before. The names are those of `engine.interchange.contract`."""


def version_of(options: ExportOptions) -> Version:
    """Return the requested version."""
    return VERSIONS[options.osc]
