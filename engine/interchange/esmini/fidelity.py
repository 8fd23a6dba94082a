"""The certificate of fidelity of an export: contact, partner and deviation, as esmini plays it.

In trajectory mode a player only follows; in maneuver mode it drives by itself, so tolerances are larger.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from engine.errors import InterchangeError
from engine.interchange.after_contact import shown_after_contact
from engine.interchange.contract import ExportOptions, Finding
from engine.interchange.esmini import Played, play
from engine.interchange.openscenario.document import entity_names
from engine.interchange.recording import SAME_INSTANT, RecordedCase, Recording
from engine.strict_json import json_text
from engine.tables import Floats
from engine.vocabulary import State

SUFFIX = ".fidelity.json"
VERSION = 1
"""Version of the certificate."""
WITHIN: Mapping[str, float] = {"trajectory": 0.02, "maneuver": 0.1}
"""Largest difference by mode between the contact times of esmini and of the run [s]."""
FINE: Mapping[str, float] = {"trajectory": 0.001, "maneuver": 0.005}
"""Step of esmini by mode where contact is detected [s]."""
AROUND = 0.5
"""Time before and after contact with that step in trajectory mode, and after it in maneuver mode [s]."""
OFF = 0.01
"""Deviation of a replay that is a finding [m]."""


@dataclass(frozen=True)
class Certificate:
    """Result of the playback of a file."""

    file: str
    content: Mapping[str, Any]
    """Content as JSON."""
    findings: tuple[Finding, ...]

    @property
    def text(self) -> str:
        return json_text(self.content, indent=1) + "\n"

    @property
    def line(self) -> str:
        """Return the result in words."""
        if (problem := self.content["problem"]) is not None:
            return f"not played: {problem}"
        theirs, off = self.content["contact"]["played"], self.content["deviation"]
        met = "no contact" if theirs is None else f"contact with {theirs['partner']} at {theirs['time']:.3f} s"
        agrees = "as in the run" if self.content["agrees"] else "OTHERWISE than in the run"
        return f"{met}, {agrees}; {off['place']:.2g} m off before it, at most"


def certified(library: Path, case: RecordedCase, files: Mapping[str, bytes], options: ExportOptions) -> Certificate:
    """Play the `.xosc` of a case, which `files` holds with its road."""
    name = f"{case.recording.name}.xosc"
    recording = case.replay.from_zero()
    shown = recording
    if options.mode == "trajectory":
        shown = shown_after_contact(recording, options.after_contact or "through")
    try:
        played = play(library, files, name, shown, _instants(shown, options.mode))
    except InterchangeError as error:
        content = _content(name, options, recording, None) | {"problem": error.message, "agrees": False}
        return Certificate(name, content, (Finding(name, error.message, error.cure),))
    content = _content(name, options, recording, played)
    return Certificate(name, content, tuple(_findings(name, content, options.mode)))


def _instants(recording: Recording, mode: str) -> Floats:
    """Return all samples, and between them steps fine enough to detect contact in time."""
    fine, contact = FINE[mode], recording.contact
    begin = 0.0 if mode == "maneuver" else math.inf if contact is None else contact.time - AROUND
    end = float(recording.time[-1]) if contact is None else contact.time + AROUND
    steps = np.arange(max(begin, 0.0), end, fine) if begin < end else np.zeros(0)
    times = np.sort(np.concatenate([recording.time, steps]))
    return times[np.diff(times, prepend=-1.0) > SAME_INSTANT]


def _content(name: str, options: ExportOptions, recording: Recording, played: Played | None) -> dict[str, Any]:
    after = "physics" if recording.contact is None else options.after_contact or "through"
    said: dict[str, Any] = {
        "certificate": VERSION,
        "file": name,
        "player": "esmini",
        "openscenario": options.osc,
        "mode": options.mode,
        "after_contact": after if options.mode == "trajectory" else None,
        "problem": None,
    }
    ours = _contact_of(recording)
    if played is None:
        return {**said, "contact": {"run": ours, "played": None}, "deviation": None}
    theirs = _contact_played(recording, played)
    return {
        **said,
        "contact": {"run": ours, "played": theirs},
        "deviation": _deviation(recording, played),
        "agrees": _agree(ours, theirs, WITHIN[options.mode]),
    }


def _contact_of(recording: Recording) -> dict[str, Any] | None:
    """Return time and partner of the ego's contact; None for a building, which is no entity of esmini."""
    contact = recording.contact
    if contact is None or len(contact.actors) < 2:
        return None
    return {"time": contact.time, "partner": entity_names(recording)[contact.actors[1]]}


def _contact_played(recording: Recording, played: Played) -> dict[str, Any] | None:
    ego, *_ = entity_names(recording)
    met = [(time, *(pair - {ego})) for pair, time in played.collisions.items() if ego in pair]
    return None if not met else dict(zip(("time", "partner"), min(met), strict=True))


def _agree(ours: Mapping[str, Any] | None, theirs: Mapping[str, Any] | None, within: float) -> bool:
    if ours is None or theirs is None:
        return ours is theirs
    return ours["partner"] == theirs["partner"] and abs(ours["time"] - theirs["time"]) <= within


def _deviation(recording: Recording, played: Played) -> dict[str, Any]:
    """Return the largest deviation of an actor at the samples up to contact, where both have it present [m], [rad],
    [s].
    """
    scored = recording.scored_samples()
    ours, times = recording.states[:scored], recording.time[:scored]
    used = np.searchsorted(played.instants, times - SAME_INSTANT)
    off = played.poses[used] - ours[:, :, State.X : State.HEADING + 1]
    place = np.hypot(off[:, :, 0], off[:, :, 1])
    turned = np.abs((off[:, :, 2] + np.pi) % (2.0 * np.pi) - np.pi)
    both = (ours[:, :, State.PRESENT] != 0.0) & np.isfinite(place)
    place, turned = np.where(both, place, 0.0), np.where(both, turned, 0.0)
    where = np.unravel_index(int(place.argmax()), place.shape)
    return {
        "place": float(place.max()),
        "heading": float(turned.max()),
        "actor": recording.actors[int(where[1])].name,
        "time": float(times[where[0]]),
    }


def _findings(name: str, content: Mapping[str, Any], mode: str) -> Iterator[Finding]:
    ours, theirs = content["contact"]["run"], content["contact"]["played"]
    if not content["agrees"]:
        reason = f"esmini sees {_said(theirs)}, the run had {_said(ours)}"
        cure = "take trajectory mode for an exact replay" if mode == "maneuver" else "leave --after-contact out"
        yield Finding(name, reason, cure)
    if mode == "trajectory" and content["deviation"]["place"] > OFF:
        off = content["deviation"]
        yield Finding(name, f"{off['actor']} is {off['place']:.3g} m off in esmini at {off['time']:.3f} s")


def _said(contact: Mapping[str, Any] | None) -> str:
    return (
        "no contact of the ego" if contact is None else f"contact with {contact['partner']} at {contact['time']:.3f} s"
    )
