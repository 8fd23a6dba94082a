"""The weather of a recording as the `EnvironmentAction` of a scenario: grip as a factor, sight as the range of fog.

Version 1.0 requires a whole environment: a time of day, a sun and precipitation. Without data it is a clear noon.
"""

from collections.abc import Iterator

from engine.interchange.openscenario.versions import Version
from engine.interchange.recording import Recording, Surroundings
from engine.interchange.xml_writing import Element, child

CLEAR = 100_000.0
"""`visualRange` without fog [m], for versions that require it."""
NOON = "2020-06-21T12:00:00"


def add_environment(actions: Element, recording: Recording, version: Version) -> None:
    """Write the weather as the first of the actions of `Init`; nothing if the recording has none."""
    said = recording.surroundings
    if said is None or said.friction is said.sight is None:
        return
    holder = child(child(actions, "GlobalAction"), "EnvironmentAction")
    environment = child(holder, "Environment", name="environment")
    if version.whole_environment:
        child(environment, "TimeOfDay", animation="false", dateTime=NOON)
    _add_weather(environment, said, version)
    if said.friction is not None or version.whole_environment:
        factor = 1.0 if said.friction is None else said.friction
        child(environment, "RoadCondition", frictionScaleFactor=factor)


def _add_weather(environment: Element, said: Surroundings, version: Version) -> None:
    sight = CLEAR if said.sight is None else said.sight
    if version.whole_environment:
        weather = child(environment, "Weather", cloudState="free")
        child(weather, "Sun", intensity=1.0, azimuth=0.0, elevation=1.0)
        child(weather, "Fog", visualRange=sight)
        child(weather, "Precipitation", precipitationType="dry", intensity=0.0)
    elif said.sight is not None:
        child(child(environment, "Weather"), "Fog", visualRange=sight)


def remarks_on_environment(recording: Recording) -> Iterator[str]:
    """Yield a remark for each property of the weather that OpenSCENARIO cannot express."""
    said = recording.surroundings
    if said is not None and said.light is not None:
        yield f"OpenSCENARIO has no place for `light` of the environment, {said.light:g}: it is left out"
