"""A recording as a scenario: all actors replay the recording, with params around it for a search.

With its params at the recorded values (0 m, pace 1) a run of it is the recording again. Without a known road, all
positions are moved and turned together so that the ego begins on a straight one; neither distances nor any metric
change by that.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from textwrap import wrap

import numpy as np

from cortex_dsl.semantics.acting.replaying import HEAD
from cortex_dsl.semantics.names.builtins import TOP_SPEED
from cortex_dsl.source import Source
from cortex_dsl.syntax.errors import MAX_BYTES
from cortex_dsl.syntax.formatting import format_source
from engine.errors import InterchangeError
from engine.interchange.contract import Export
from engine.interchange.openscenario.document import unique_names
from engine.interchange.recording import RecordedActor, Recording
from engine.tables import Floats
from engine.vehicles import MODELS
from engine.vocabulary import ActorKind, State

DIGITS = 9
"""Decimals of positions, headings and speeds [m, rad, m/s]."""
AROUND = 0.5
"""Range of a varied start along the way, ahead or behind, in seconds of the mean speed."""
LEAST, MOST = 1.0, 10.0
"""Bounds of that range [m]."""
PACES = 0.9, 1.1
STEPS = 1e-4, 1.0
"""Time steps that a scenario may have [s]."""
ROOM = 0.9
"""Share of the largest scenario that is filled with tracks."""
ROAD_MARGIN = 100.0
LANE = 3.5
"""Width of a lane of the straight road [m]."""
WIDTH = 96


def write_recorded(recording: Recording, stem: str, road_file: str | None, partner: int) -> Export:
    """Return `<stem>.scn`.

    `road_file` is the `.xodr` next to it, if the recording has one; `partner` is the actor of the search, in addition
    to the ego.

    Raises:
        InterchangeError: the ego is not there from the beginning, or its track alone is too long.
    """
    recording.refuse_broken()
    recording = recording.from_zero()
    if not recording.there[0, 0]:
        raise InterchangeError("the ego is not there at the beginning", "begin later, by --window")
    shown = recording if road_file is not None else _on_a_road(recording)
    present = [actor for actor in range(len(recording.actors)) if recording.there[0, actor]]
    roles = [_Role(actor, name) for actor, name in zip(present, _names(recording, present), strict=True)]
    tracks = {role.actor: _track(shown, role) for role in roles}
    used = list(_fitting(recording, roles, tracks, partner))
    lines = [
        *_head(recording, stem, used, partner),
        *_road(shown, road_file),
        *(line for role in used for line in tracks[role.actor]),
        *(line for role in used if role.actor in (0, partner) for line in _params(shown, role)),
        *(line for role in used for line in _object(shown, role, searched=role.actor in (0, partner))),
        "",
        f"simulation(time_step={_step(recording)!r} s, max_time={_number(_end(recording) + 1.0)} s)",
    ]
    remarks = (*_remarks(recording, roles, used), *(() if road_file else (NO_ROAD,)))
    name = f"{stem}.scn"
    return Export({name: format_source(Source(name, "\n".join(lines) + "\n"))}, remarks)


NO_ROAD = "no road was recorded: a straight one is drawn under the ego, and positions are turned to it"


@dataclass(frozen=True)
class _Role:
    """An actor that is present at the beginning."""

    actor: int
    name: str
    """Name of its variable."""

    @property
    def param(self) -> str:
        return self.name.upper()

    @property
    def track(self) -> str:
        return f"{self.param}_TRACK"


def _names(recording: Recording, actors: Sequence[int]) -> tuple[str, ...]:
    """Variables: the ego first, the others after their kinds, so that none is a word of the language."""
    words = (f"{recording.actors[actor].kind.name}_{recording.actors[actor].name}".lower() for actor in actors[1:])
    return ("ego", *unique_names(words))


def _on_a_road(recording: Recording) -> Recording:
    """Turned and moved so that the ego begins on the right lane of a straight road, and heads along it."""
    states = recording.states.copy()
    x, y, heading = states[0, 0, [State.X, State.Y, State.HEADING]]
    cos, sin = math.cos(heading), math.sin(heading)
    off_x, off_y = states[:, :, State.X] - x, states[:, :, State.Y] - y
    states[:, :, State.X] = cos * off_x + sin * off_y
    states[:, :, State.Y] = cos * off_y - sin * off_x - 0.5 * LANE
    states[:, :, State.HEADING] -= heading
    return replace(recording, states=states)


# -- text of each actor ------------------------------------------------------------------------------------------------


def _rows(recording: Recording, actor: int) -> Floats:
    """Return the rows (samples, 5) of the first stretch in which an actor is present."""
    first, last = recording.stretches(actor)[0]
    states = recording.states[first : last + 1, actor]
    columns = states[:, [State.X, State.Y, State.HEADING, State.SPEED]]
    return np.column_stack([recording.time[first : last + 1], np.round(columns, DIGITS)])


def _moves(rows: Floats) -> bool:
    return len(rows) > 1 and bool((rows[:, 1:] != rows[0, 1:]).any())


def _is_replayed(recording: Recording, role: _Role) -> bool:
    """Return whether an actor has a track: an actor that always stands has none, and a thing never has one."""
    rows = _rows(recording, role.actor)
    stays = not _moves(rows) and len(rows) == len(recording)
    return len(rows) > 1 and not stays and recording.actors[role.actor].kind != ActorKind.OBSTACLE


def _track(recording: Recording, role: _Role) -> list[str]:
    if not _is_replayed(recording, role):
        return []
    rows = (",".join(map(_number, row)) for row in _rows(recording, role.actor).tolist())
    return ["", f'{role.track} = """', HEAD, *rows, '"""']


def _params(recording: Recording, role: _Role) -> Iterator[str]:
    """Yield the params of start offset along the way and of pace, with ranges around the recorded values."""
    if _is_replayed(recording, role):
        speed = float(np.abs(_rows(recording, role.actor)[:, 4]).mean())
        ahead = round(min(MOST, max(LEAST, AROUND * speed)), 1)
        yield ""
        yield f"param {role.param}_AHEAD = Range({-ahead:g}, {ahead:g}) m"
        yield f"param {role.param}_PACE = Range({PACES[0]:g}, {PACES[1]:g})"


def _object(recording: Recording, role: _Role, *, searched: bool) -> Iterator[str]:
    """Yield a new object, its size, and its behaviour."""
    actor, rows = recording.actors[role.actor], _rows(recording, role.actor)
    replayed = _is_replayed(recording, role)
    searched = searched and replayed
    track = f"{role.track}, {role.param}_PACE" if searched else role.track
    _, x, y, heading, speed = rows[0].tolist()
    place = f"({_number(x)}, {_number(y)})"
    turn = f"{_number(heading)} rad"
    if searched:
        place = f"({place} offset along {turn} by 0 @ {role.param}_AHEAD)"
    pace = f" * {role.param}_PACE" if searched else ""
    said = [
        f"facing {turn}",
        *([f"with speed {_number(max(speed, 0.0))} m/s{pace}"] if replayed else []),
        *_body(actor, float(rows[:, 4].max())),
        "with regionContainedIn None",
        *(["with allowCollisions True"] if _overlaps(recording, role.actor) else []),
        *([f"with behavior ReplayBehavior({track})"] if replayed else []),
    ]
    yield ""
    yield f"{role.name} = new {actor.kind.name.capitalize()} at {place},"
    for number, each in enumerate(said, 1):
        yield f"    {each}{',' if number < len(said) else ''}"


def _body(actor: RecordedActor, fastest: float) -> Iterator[str]:
    yield f"with length {_number(actor.length)} m, with width {_number(actor.width)} m"
    if MODELS[actor.kind].rear_to_center:
        yield f"with rearToCenter {_number(actor.rear_to_center)} m, with wheelbase {_number(actor.wheelbase)} m"
    if fastest * PACES[1] > MODELS[actor.kind].top_speed:
        yield f"with topSpeed {_number(min(TOP_SPEED, math.ceil(fastest * PACES[1])))} m/s"


def _overlaps(recording: Recording, actor: int) -> bool:
    """Return whether another actor is so near at the beginning that outlines may overlap when starts are varied."""
    x, y = recording.states[0, :, State.X], recording.states[0, :, State.Y]
    size = np.array([math.hypot(each.length, each.width) for each in recording.actors])
    near = np.hypot(x - x[actor], y - y[actor]) < 0.5 * (size + size[actor])
    return bool((near & recording.there[0]).sum() > 1)


# -- text around the actors --------------------------------------------------------------------------------------------


def _head(recording: Recording, stem: str, used: Sequence[_Role], partner: int) -> Iterator[str]:
    searched = [role for role in used if role.actor in (0, partner) and _is_replayed(recording, role)]
    names = " and ".join(role.name for role in searched)
    reported = (
        f"Recorded: {len(used)} actors over {_number(_end(recording))} s. Params move the starts of {names} along their"
        " ways, and let time pass faster or slower for them."
        if searched
        else f"Recorded: {len(used)} actors over {_number(_end(recording))} s, none of which moves."
    )
    seen = " ".join(f"-p {role.param}_AHEAD=0 -p {role.param}_PACE=1" for role in searched)
    yield f'"""{_plain(recording.name)}'
    yield ""
    yield from wrap(reported, WIDTH)
    if searched:
        yield f"As recorded: cortexc {_plain(stem)}.scn {seen}"
    yield '"""'


def _plain(text: str) -> str:
    return "".join(letter if letter.isprintable() and letter not in '"\\' else "_" for letter in text)


def _road(recording: Recording, road_file: str | None) -> Iterator[str]:
    if road_file is not None:
        yield f'map opendrive("{road_file}")'
        return
    there = recording.states[recording.there]
    reach = float(np.abs(there[:, [State.X, State.Y]]).max()) + ROAD_MARGIN
    yield f"map road(lanes=1, length={min(100_000.0, 2.0 * math.ceil(reach)):g} m)"


def _end(recording: Recording) -> float:
    return float(recording.time[-1])


def _step(recording: Recording) -> float:
    return min(STEPS[1], max(STEPS[0], float(recording.step)))


def _number(value: float) -> str:
    """Return a number as text: without a fraction if it is whole; never in powers of ten."""
    text = f"{value:.{DIGITS}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def _fitting(
    recording: Recording, roles: Sequence[_Role], tracks: dict[int, list[str]], partner: int
) -> Iterator[_Role]:
    """Return the roles whose tracks fit in a scenario: the ego, its partner, then the actors nearest to the ego.

    Raises:
        InterchangeError: those two alone are too much.
    """
    left = ROOM * MAX_BYTES
    way = recording.states[:, :, [State.X, State.Y]]
    apart = np.hypot(*np.moveaxis(way - way[:, :1], 2, 0))
    nearest = np.where(recording.there, apart, np.inf).min(axis=0)
    used: set[int] = set()
    for role in sorted(roles, key=lambda role: (role.actor not in (0, partner), nearest[role.actor])):
        left -= sum(map(len, tracks[role.actor])) + len(tracks[role.actor]) + 400
        if left < 0.0 and role.actor in (0, partner):
            raise InterchangeError("it is too long for a scenario", "take a part of it, by --window")
        if left >= 0.0:
            used.add(role.actor)
    return (role for role in roles if role.actor in used)


def _remarks(recording: Recording, roles: Sequence[_Role], used: Sequence[_Role]) -> Iterator[str]:
    """Yield remarks on actors that are omitted, or whose motion differs from the recording."""
    actors = recording.actors
    there = {role.actor for role in roles}
    if late := [actor.name for number, actor in enumerate(actors) if number not in there]:
        yield f"not there at the beginning, and left out of the scenario: {_some(late)}"
    if crowd := [actors[role.actor].name for role in roles if role not in used]:
        yield f"no room for their tracks in a scenario: {_some(crowd)}"
    if gone := [actors[role.actor].name for role in used if len(recording.stretches(role.actor)) > 1]:
        yield f"actors that disappear for a while stay away in the scenario: {_some(gone)}"
    if recording.step != _step(recording):
        yield f"a scenario runs in steps of {STEPS[0]:g} to {STEPS[1]:g} s: {_step(recording):g} s is taken"
    if back := [actors[role.actor].name for role in used if recording.states[0, role.actor, State.SPEED] < 0.0]:
        yield f"no actor starts backwards in a scenario; at the first sample these stand still: {_some(back)}"


def _some(names: Sequence[str]) -> str:
    return ", ".join(names[:5]) + (f" and {len(names) - 5:,} more" if len(names) > 5 else "")
