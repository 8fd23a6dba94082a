"""What differs between the versions of OpenSCENARIO XML, as far as it concerns what is written here.

Source: the schemas of OpenSCENARIO 1.0.0, 1.1.0, 1.2.0 and 1.3.0 (ASAM e.V.).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from engine.interchange.contract import ExportOptions

BEFORE = 0.001
"""How long before its instant a "greater than" condition is set [s]: above readers' tolerance, below any step."""


@dataclass(frozen=True, kw_only=True)
class Version:
    """One version, by what a writer must know of it."""

    name: str
    minor: int
    priority: str
    """Of an event that takes over from others: 1.2 renamed it."""
    rule: str
    """Of a condition that holds from a value on: 1.0 knows no "greater or equal"."""
    integer: str
    """The type of a parameter that is a whole number: 1.2 renamed it."""
    straight_distance: str
    """The type of a distance as the crow flies."""
    distance_attributes: Mapping[str, str]
    """How a condition on a distance or a time to collision says that it is taken as the crow flies."""
    trajectory_in_reference: bool
    """Whether a trajectory stands in a `TrajectoryRef`."""
    vehicle_mass: bool
    """Whether a vehicle has a mass."""
    pedestrian_model: bool
    """Whether a pedestrian must name a model."""
    reverse_speed: bool
    """Whether a start with negative speed can be said: ScenarioRunner, which insists on 1.0, refuses it."""
    late_entities: bool
    """Whether an entity that comes later is nowhere before: ScenarioRunner, which needs 1.0, places every entity."""
    has_expressions: bool
    """Whether an attribute may be a formula, not a bare parameter only."""
    has_constraints: bool
    """Whether a parameter may say its range."""
    whole_environment: bool
    """Whether an environment must say everything: time of day, sun, fog, rain and road."""
    has_distributions: bool
    """Whether there are files of parameter values."""

    def time_value(self, seconds: float) -> float:
        """What to compare with for a condition to hold from an instant on [s]."""
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
"""By name; each says what it changes of the one before. The names are those of `engine.interchange.contract`."""


def version_of(options: ExportOptions) -> Version:
    """The version that is asked for."""
    return VERSIONS[options.osc]
