"""The interface of all formats: options, exported files with remarks, findings of a check, and the error for a file
that cannot be read or written, with reason, place and cure.
"""

from collections.abc import Generator, Iterable, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from engine.errors import CortexError, nearest

# -- errors, and how text from other tools is shown --------------------------------------------------------------------

MOST_CHOICES = 12
MOST_COMPARED = 2000
"""Maximum number of names with which an unknown name is compared."""
MOST_LETTERS = 60
"""Largest length of a quoted text from another tool's file."""


class InterchangeError(CortexError):
    """A file cannot be read, or a format cannot express a case; the error has the reason, the place and the cure."""

    def __init__(self, message: str, cure: str, place: str = "") -> None:
        super().__init__(message, cure)
        self.place = place
        """File, and line or element if known: `case.xosc, line 12`."""

    def __str__(self) -> str:
        return f"{self.place}: {super().__str__()}" if self.place else super().__str__()


def quoted(text: str) -> str:
    """Return a text from another tool's file in quotes, cut to the length of a message, without control characters."""
    cut = text if len(text) <= MOST_LETTERS else text[: MOST_LETTERS - 1] + "…"
    return '"' + "".join(letter if letter.isprintable() else "?" for letter in cut) + '"'


def cited(name: str) -> str:
    """Return a name from another tool's file between backquotes, cut and cleaned as `quoted` does."""
    return f"`{quoted(name)[1:-1]}`"


@contextmanager
def reading(path: Path, wanted: str = "a recording") -> Generator[None]:
    """Read a file inside this block; errors of the system become an InterchangeError."""
    try:
        if not path.is_file():
            what = "this is not a file" if path.exists() else "there is no such file"
            raise InterchangeError(what, f"name {wanted}", str(path))
        yield
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise InterchangeError(f"it cannot be read: {reason}", "solve that, or copy the file", path.name) from None


def near_name(word: str, names: Iterable[str]) -> str | None:
    """Return the name that `word` was probably meant to be, or None; of both only a bounded part is compared."""
    return nearest(word[:MOST_LETTERS], islice(names, MOST_COMPARED))


def name_cure(word: str, names: Iterable[str]) -> str:
    """Return the cure for an unknown name: the nearest name, or all names; "" if there are none."""
    choices = list(islice(dict.fromkeys(names), MOST_COMPARED))
    if near := near_name(word, choices):
        return f"did you mean `{near}`?"
    if not choices:
        return ""
    rest = " and others" if len(choices) > MOST_CHOICES else ""
    verb = "is" if len(choices) == 1 else "are"
    return f"there {verb} " + ", ".join(f"`{name}`" for name in choices[:MOST_CHOICES]) + rest


# -- questions and answers ---------------------------------------------------------------------------------------------

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
