"""The interface of all formats: options, exported files with remarks, and findings of a check."""

from collections.abc import Mapping
from dataclasses import dataclass

from engine.errors import InterchangeError

OSC_VERSIONS = ("1.0", "1.1", "1.2", "1.3")
"""Versions of OpenSCENARIO XML: the rows of `openscenario.versions`. CARLA's ScenarioRunner reads 1.0 only."""
MODES = ("trajectory", "maneuver")
PLAYERS = ("carla",)
"""Tools that want a replay written for them alone."""
AFTER_CONTACT = ("through", "stop", "physics")
"""Motion of a replay after first contact: actors pass through each other, so that outlines overlap; actors stand; or
contact physics, which keeps outlines apart.
"""


@dataclass(frozen=True)
class ExportOptions:
    """Options of an export; each format reads those that it supports."""

    osc: str = "1.2"
    """Version of OpenSCENARIO XML, one of `OSC_VERSIONS`."""
    mode: str = "trajectory"
    """`trajectory` replays a case exactly; `maneuver` uses speeds, routes and triggers, for variation in other tools.
    """
    player: str | None = None
    """One of `PLAYERS`, for which an `.xosc` and its road are adapted; None: according to the standard."""
    after_contact: str | None = None
    """One of `AFTER_CONTACT`; None: `through` in an `.xosc` that replays, contact physics in recordings."""

    def __post_init__(self) -> None:
        if self.osc not in OSC_VERSIONS:
            raise InterchangeError(
                f"there is no OpenSCENARIO {self.osc} here", f"name one of {', '.join(OSC_VERSIONS)}"
            )
        if self.mode not in MODES:
            raise InterchangeError(f"there is no mode `{self.mode}`", f"name one of {', '.join(MODES)}")
        if self.after_contact not in (None, *AFTER_CONTACT):
            raise InterchangeError(
                f"nobody goes on `{self.after_contact}` after contact", f"name one of {', '.join(AFTER_CONTACT)}"
            )
        if self.mode == "maneuver" and self.after_contact is not None:
            raise InterchangeError(
                "in maneuver mode the player says what follows contact", "leave after_contact out, or the mode"
            )
        self._check_player()

    def _check_player(self) -> None:
        if self.player is None:
            return
        if self.player not in PLAYERS:
            raise InterchangeError(f"nothing is written for `{self.player}`", f"name one of {', '.join(PLAYERS)}")
        if self.osc != "1.0":
            raise InterchangeError(f"CARLA's ScenarioRunner does not read OpenSCENARIO {self.osc}", "take version 1.0")
        if self.mode != "trajectory":
            raise InterchangeError(
                "CARLA's ScenarioRunner fails at every route of maneuver mode, since August 2025",
                "leave the mode out: trajectories are replayed exactly",
            )


@dataclass(frozen=True)
class Export:
    """Files to be written side by side."""

    files: Mapping[str, str | bytes]
    """Contents by file name; the main file is the first."""
    remarks: tuple[str, ...] = ()
    """Facts that the format cannot express, or expresses differently, each as one sentence without a full stop; it
    begins with a small letter unless with a name.
    """


@dataclass(frozen=True)
class Finding:
    """One defect with place, reason and cure."""

    place: str
    """File, and element or line: `case.xosc, Private of ego`."""
    reason: str
    cure: str = ""


OURS = "this is a bug in cortexc: please report it"
"""Cure for a defect of a file that cortexc has just written."""
