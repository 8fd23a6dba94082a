"""What our own files carry, held against the vertices of everybody: first contact is where speeds end to follow.

Vertices of others are looked at for leaps, which no simulator would make.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from engine.interchange.reading.belief import Scored, belief
from engine.interchange.reading.timeline import Part, centers, usual_step
from engine.interchange.reading.tracks import Path
from engine.interchange.recording import SAME_INSTANT
from engine.kernels.approach import search_contact
from engine.tables import Floats
from engine.vocabulary import State

LEAP = 0.5
"""A vertex this far from the middle of its neighbours is worth a remark [m] ..."""
HARD = 20.0
"""... unless an acceleration like this explains it [m/s^2]."""


def judged(parts: Sequence[Part], told: Floats) -> list[Part]:
    """The parts with their speeds believed or not, and remarks; `told` are the times that the file speaks of [s]."""
    if not any(part.carried for part in parts):
        contact = math.inf
        return [replace(part, remarks=(*part.remarks, *_leaps(part, contact))) for part in parts]
    scored = _scored(parts, told)
    return [_judged(part, scored) for part in parts]


def _judged(part: Part, scored: Scored) -> Part:
    if part.carried is None:
        return replace(part, remarks=(*part.remarks, *_leaps(part, scored.last)))
    name = part.entity.actor.name
    found = belief(part.carried, part.entity.actor, part.track.poses(part.carried.time), scored)
    said = (f"{name}: {found.remark}",) if found.remark else ()
    leaps = () if found.believed else _leaps(part, scored.last)
    return replace(part, believed=found.believed, remarks=(*part.remarks, *said, *leaps))


def _scored(parts: Sequence[Part], told: Floats) -> Scored:
    """Until contact by the vertices, at the first sample at which it has come."""
    poses = [part.track.poses(told) for part in parts]
    states = np.zeros((len(told), len(parts), len(State)))
    for index, part in enumerate(parts):
        states[:, index, [State.X, State.Y, State.HEADING]] = centers(poses[index], part.entity)
        states[:, index, State.PRESENT] = part.there(told)
    actors = [part.entity.actor for part in parts]
    touch = search_contact(states, np.array([[actor.length, actor.width] for actor in actors]))
    ways = np.array([np.hypot(*np.diff(each[:, :2], axis=0).T) for each in poses])
    present = states[1:, :, State.PRESENT] * states[:-1, :, State.PRESENT]
    fastest = float((ways.T * present / np.diff(told)[:, np.newaxis]).max(initial=0.0))
    last = math.inf
    if touch.sample >= 0:
        after = min(touch.sample + 1, len(told) - 1)
        time = told[touch.sample] + touch.part * (told[after] - told[touch.sample])
        last = float(told[np.searchsorted(told, time - 10.0 * SAME_INSTANT)])
    return Scored(last, usual_step(parts), fastest)


def _leaps(part: Part, until: float) -> tuple[str, ...]:
    """A remark where vertices of one polyline leap, before contact [s]."""
    found = [leap for leg in part.track.legs if isinstance(leg, Path) for leap in _leaps_of(leg, until)]
    if not found:
        return ()
    time, distance = max(found, key=lambda leap: leap[1])
    return (f"{part.entity.actor.name}: its vertex at {time:g} s lies {distance:.1f} m off the way of its neighbours",)


def _leaps_of(leg: Path, until: float) -> list[tuple[float, float]]:
    """Times and distances from the way between its neighbours."""
    times, places = leg.times, leg.poses[:, :2]
    if len(times) < 3:
        return []
    before, after = np.diff(times)[:-1], np.diff(times)[1:]
    share = (before / (before + after))[:, np.newaxis]
    off = np.hypot(*(places[1:-1] - places[:-2] - share * (places[2:] - places[:-2])).T)
    leaps = np.flatnonzero((off > LEAP + HARD * before * after / 2.0) & (times[2:] <= until))
    return [(float(times[1 + row]), float(off[row])) for row in leaps.tolist()]
