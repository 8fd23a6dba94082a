"""What a format's module is asked for, and what it answers."""

from collections.abc import Mapping
from dataclasses import dataclass

from engine.interchange.errors import InterchangeError

OSC_VERSIONS = ("1.0", "1.1", "1.2", "1.3")
"""Of OpenSCENARIO XML: the rows of `openscenario.versions`. CARLA's ScenarioRunner reads 1.0 only."""
MODES = ("trajectory", "maneuver")


@dataclass(frozen=True)
class ExportOptions:
    """How to write; each format reads what concerns it."""

    osc: str = "1.2"
    """Version of OpenSCENARIO XML, one of `OSC_VERSIONS`."""
    mode: str = "trajectory"
    """`trajectory` replays a case exactly; `maneuver` says it in speeds, routes and triggers, for others to vary."""

    def __post_init__(self) -> None:
        if self.osc not in OSC_VERSIONS:
            raise InterchangeError(
                f"there is no OpenSCENARIO {self.osc} here", f"name one of {', '.join(OSC_VERSIONS)}"
            )
        if self.mode not in MODES:
            raise InterchangeError(f"there is no mode `{self.mode}`", f"name one of {', '.join(MODES)}")


@dataclass(frozen=True)
class Export:
    """Files to be written side by side."""

    files: Mapping[str, str | bytes]
    """Contents by file name, the one to open first."""
    remarks: tuple[str, ...] = ()
    """What the format cannot carry, or carries otherwise, each as one sentence that names it: without a full stop, and
    beginning with a small letter unless a name stands there.
    """
