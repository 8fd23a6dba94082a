"""Check that the speeds in files of cortexc lead from vertex to vertex, up to first contact. Metres, seconds, m/s.

A simulated step of length h that ends at speed v, with acceleration a, is v h - a h²/2 long, for any speed set at once
before it, and leads along the mean of both headings; a pedestrian turns first (`engine.kernels.bicycle`). Recordings of
other tools have noise, and no pedals: there, steps and the whole way fit roughly. A step in which a body slides after
an impact is measured by its vertices. Vertices of other files are checked for leaps, which no simulator would make.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from engine.interchange.openscenario.read.motion import Polyline
from engine.interchange.openscenario.read.samples import Part, centers, usual_step
from engine.interchange.own_metadata import Carried
from engine.interchange.recording import SAME_INSTANT, RecordedActor
from engine.kernels.approach import search_contact
from engine.tables import SLIDING, Floats
from engine.vocabulary import ActorKind, State

FITS = 1e-6
"""Largest distance between the end of a simulated step and the next vertex [m]; runs of cortexc reach 2e-9 m."""
FASTEST = 200.0
"""Largest speed that the language lets an actor be set to [m/s]."""
NOISE, NOISY_SHARE = 0.1, 0.2
"""Tolerance of one step of a recording by another tool [m], plus that share of its way."""
MISFIT = "the speeds it carries do not fit its vertices, which are believed"
DRIFT, DRIFT_SHARE = 0.2, 0.02
"""Tolerance of the way of all its steps [m], plus that share."""


class Scored(NamedTuple):
    """Limits for the check of speeds: first contact by the vertices, after which they follow from no rule."""

    last: float
    """Sample at or after contact [s]; infinite without contact."""
    step: float
    """Usual time between two samples [s]; a longer time is an absence of the actor."""
    fastest: float
    """Largest speed by the vertices, of all actors [m/s]."""


class Belief(NamedTuple):
    """Result of the check of one actor's speeds."""

    believed: bool
    remark: str = ""


class _Steps(NamedTuple):
    """Steps from each sample to the next, one row each."""

    begin: Floats
    end: Floats
    way: Floats
    """Way along the heading."""
    aside: Floats
    turn: Floats
    speed: Floats
    """Stored speed at its end; `acceleration`: stored acceleration."""
    acceleration: Floats
    before: Floats
    """Stored speed at its beginning."""
    rounding: Floats

    @property
    def length(self) -> Floats:
        return self.end - self.begin

    def only(self, rows: np.ndarray) -> "_Steps":
        return _Steps(*(column[rows] for column in self))


def belief(carried: Carried, actor: RecordedActor, poses: Floats, scored: Scored) -> Belief:
    """Compare an actor's stored data with `poses` (samples, 3) of its vertices at these samples."""
    steps, speeds = _steps(carried, actor.kind, poses), carried.columns[State.SPEED]
    together = steps.length < 1.5 * scored.step
    if State.PRESENT in carried.columns:
        together &= carried.columns[State.PRESENT][1:] != SLIDING
    driven = steps.only(together & (steps.end < scored.last - SAME_INSTANT))
    ours = State.STEER in carried.columns
    wrong = _wrong(driven, actor) if ours else _rough(driven)
    if wrong is None:
        last = together & (np.abs(steps.end - scored.last) <= SAME_INSTANT)
        wrong = _wrong_at_contact(steps.only(last), actor, scored.step)
    if wrong is not None:
        return Belief(False, f"{MISFIT}: {wrong}")
    too_fast = np.flatnonzero(np.abs(speeds) > _limits(carried.time, actor, scored))
    if len(too_fast):
        when, speed = carried.time[too_fast[0]], speeds[too_fast[0]]
        return Belief(False, f"{MISFIT}: it carries {speed:.4g} m/s at {when:g} s")
    return Belief(True, _set_at_once(driven, np.concatenate([[True], ~together]), steps) if ours else "")


def _steps(carried: Carried, kind: ActorKind, poses: Floats) -> _Steps:
    change, turn = np.diff(poses, axis=0), np.diff(poses[:, 2])
    on_foot = kind == ActorKind.PEDESTRIAN
    heading = poses[1:, 2] - (0.0 if on_foot else turn / 2.0)
    cos, sin = np.cos(heading), np.sin(heading)
    arc = 1.0 if on_foot else np.sinc(turn / (2.0 * np.pi))
    speed = carried.columns[State.SPEED]
    return _Steps(
        begin=carried.time[:-1],
        end=carried.time[1:],
        way=(change[:, 0] * cos + change[:, 1] * sin) / arc,
        aside=change[:, 1] * cos - change[:, 0] * sin,
        turn=turn,
        speed=speed[1:],
        acceleration=carried.columns[State.ACCELERATION][1:],
        before=speed[:-1],
        rounding=1e-15 * np.abs(poses[1:, :2]).max(axis=1, initial=1.0),
    )


def _wrong(steps: _Steps, actor: RecordedActor) -> str | None:
    """Return a message on the first step that the simulation could not make, or None."""
    h = steps.length
    off = np.abs(steps.way - (steps.speed * h - steps.acceleration * h * h / 2.0))
    strong = max(actor.max_acceleration, actor.max_braking) * (1.0 + FITS) + FITS
    off = np.maximum(off, np.abs(steps.aside)) - 10.0 * steps.rounding
    stopping = np.where(steps.speed == 0.0, strong * h * h / 8.0, 0.0)  # an actor that stops within the step
    return _described(steps, (off > FITS + stopping) | (np.abs(steps.acceleration) > strong))


def _rough(steps: _Steps) -> str | None:
    """Return a message on the first step that noise does not explain, or the last if the whole way differs."""
    off = steps.way - (steps.speed + steps.before) / 2.0 * steps.length
    wrong = np.abs(off) > NOISE + NOISY_SHARE * np.abs(steps.way)
    if abs(off.sum()) > DRIFT + DRIFT_SHARE * np.abs(steps.way).sum():
        wrong[-1:] = True
    return _described(steps, wrong)


def _wrong_at_contact(steps: _Steps, actor: RecordedActor, step: float) -> str | None:
    """Return a message unless the speed at contact is between the speeds before and after the whole step."""
    mean = steps.way / steps.length
    slack = max(actor.max_acceleration, actor.max_braking) * step + 100.0 * steps.rounding / steps.length
    slack = slack + abs(actor.rear_to_center) * (steps.turn / steps.length) ** 2 * step + FITS
    low, high = np.minimum(mean, steps.before) - slack, np.maximum(mean, steps.before) + slack
    return _described(steps, (steps.speed < low) | (steps.speed > high))


def _described(steps: _Steps, wrong: np.ndarray) -> str | None:
    if not wrong.any():
        return None
    row = int(wrong.argmax())
    if abs(steps.aside[row]) > max(abs(steps.way[row]), FITS):
        return f"at {steps.end[row]:.3f} s it lies {abs(steps.aside[row]):.3g} m aside of its way"
    moves, carries = steps.way[row] / steps.length[row], steps.speed[row]
    return f"at {steps.end[row]:.3f} s it moves at {moves:.5g} m/s and carries {carries:.5g} m/s"


def _limits(times: Floats, actor: RecordedActor, scored: Scored) -> Floats:
    """Return limits of speeds that follow from no step: those at an actor's appearance, and those after contact."""
    top = max(min(actor.max_speed, FASTEST), scored.fastest) + FITS
    return np.where(times > scored.last + SAME_INSTANT, 2.0 * scored.fastest + 1.0, top)


def _set_at_once(driven: _Steps, first: np.ndarray, steps: _Steps) -> str:
    """Return a remark for an actor that comes in faster than it ever drives: no step can confirm that."""
    rows = driven.only(np.isin(driven.begin, steps.begin[first[: len(steps.begin)]]))
    drives = rows.speed - rows.acceleration * rows.length
    odd = np.abs(drives - rows.before) > 1e-3
    odd &= np.abs(rows.before) > np.abs(driven.speed).max(initial=0.0) + 1e-3
    if not odd.any():
        return ""
    row = int(odd.argmax())
    return (
        f"it comes in at {rows.before[row]:.4g} m/s and drives off at {drives[row]:.4g} m/s, at {rows.begin[row]:g} s"
    )


# -- all actors together: first contact, and leaps ---------------------------------------------------------------------

LEAP = 0.5
"""Distance of a vertex from the middle of its neighbours from which on a remark names it [m]."""
HARD = 20.0
"""Acceleration that explains such a distance, without a remark [m/s^2]."""


def judged(parts: Sequence[Part], given: Floats) -> list[Part]:
    """Return the parts with their speeds believed or not, and remarks; `given`: the times in the file [s]."""
    if not any(part.carried for part in parts):
        contact = math.inf
        return [replace(part, remarks=(*part.remarks, *_leaps(part, contact))) for part in parts]
    scored = _scored(parts, given)
    return [_judged(part, scored) for part in parts]


def _judged(part: Part, scored: Scored) -> Part:
    if part.carried is None:
        return replace(part, remarks=(*part.remarks, *_leaps(part, scored.last)))
    name = part.entity.actor.name
    found = belief(part.carried, part.entity.actor, part.track.poses(part.carried.time), scored)
    said = (f"{name}: {found.remark}",) if found.remark else ()
    leaps = () if found.believed else _leaps(part, scored.last)
    return replace(part, believed=found.believed, remarks=(*part.remarks, *said, *leaps))


def _scored(parts: Sequence[Part], given: Floats) -> Scored:
    """Return the limits, up to the first sample at or after contact by the vertices."""
    poses = [part.track.poses(given) for part in parts]
    states = np.zeros((len(given), len(parts), len(State)))
    for index, part in enumerate(parts):
        states[:, index, [State.X, State.Y, State.HEADING]] = centers(poses[index], part.entity)
        states[:, index, State.PRESENT] = part.there(given)
    actors = [part.entity.actor for part in parts]
    touch = search_contact(states, np.array([[actor.length, actor.width] for actor in actors]))
    ways = np.array([np.hypot(*np.diff(each[:, :2], axis=0).T) for each in poses])
    present = states[1:, :, State.PRESENT] * states[:-1, :, State.PRESENT]
    fastest = float((ways.T * present / np.diff(given)[:, np.newaxis]).max(initial=0.0))
    last = math.inf
    if touch.sample >= 0:
        after = min(touch.sample + 1, len(given) - 1)
        time = given[touch.sample] + touch.part * (given[after] - given[touch.sample])
        last = float(given[np.searchsorted(given, time - 10.0 * SAME_INSTANT)])
    return Scored(last, usual_step(parts), fastest)


def _leaps(part: Part, until: float) -> tuple[str, ...]:
    """Return a remark if vertices of one polyline leap, before contact [s]."""
    found = [leap for leg in part.track.legs if isinstance(leg, Polyline) for leap in _leaps_of(leg, until)]
    if not found:
        return ()
    time, distance = max(found, key=lambda leap: leap[1])
    return (f"{part.entity.actor.name}: its vertex at {time:g} s lies {distance:.1f} m off the way of its neighbours",)


def _leaps_of(leg: Polyline, until: float) -> list[tuple[float, float]]:
    """Return times and distances from the way between the neighbours."""
    times, places = leg.times, leg.poses[:, :2]
    if len(times) < 3:
        return []
    before, after = np.diff(times)[:-1], np.diff(times)[1:]
    share = (before / (before + after))[:, np.newaxis]
    off = np.hypot(*(places[1:-1] - places[:-2] - share * (places[2:] - places[:-2])).T)
    leaps = np.flatnonzero((off > LEAP + HARD * before * after / 2.0) & (times[2:] <= until))
    return [(float(times[1 + row]), float(off[row])) for row in leaps.tolist()]
