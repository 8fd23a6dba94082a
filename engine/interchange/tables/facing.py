"""Assumed headings of actors that never move, and the pairs whose contact depends on the assumption.

A standing actor without a recorded heading is assumed to face along the nearest traffic, as parked cars mostly do, with
a remark. A contact that occurs with this heading but not with every heading is not reported: that pair is omitted.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np

from engine.errors import InterchangeError, cited
from engine.interchange.motion import MOVING, along
from engine.interchange.tables.track import TableTrack, Tracks
from engine.tables import Floats
from engine.vocabulary import ActorKind, State

MOST_SAMPLES = 100_000
"""Maximum number of traffic samples in the search for the nearest."""
MOST_NAMED = 8
TURNS = 12
"""Number of headings that are tried for a contact: 15 degrees apart, as an outline rotated by half a turn is equal."""
CURE = "add a column `heading`"


def with_assumed_headings(tracks: Tracks) -> Tracks:
    """Return tracks without NaN in headings, and remarks on the actors with an assumed heading, or omitted ones."""
    unknown = [track for track in tracks.tracks if np.isnan(track.heading).any()]
    if not unknown:
        return tracks
    traffic = _traffic(tracks.tracks)
    if not len(traffic):
        return _without_traffic(tracks, unknown)
    found = tuple(_facing(track, traffic) if np.isnan(track.heading).any() else track for track in tracks.tracks)
    said = (
        f"no motion shows the heading of {_named(unknown)}: that of the nearest traffic is assumed; {CURE} to state it"
    )
    return replace(tracks, tracks=found, remarks=(*tracks.remarks, said))


def _traffic(tracks: Iterable[TableTrack]) -> Floats:
    """Return x, y and heading (rows, 3) of all moving actors: vehicles, or walkers if no vehicle moves."""
    rows: dict[bool, list[Floats]] = {True: [], False: []}
    for track in tracks:
        moves = ~np.isnan(track.heading) & (np.abs(track.speed) > MOVING)
        walks = track.kind == ActorKind.PEDESTRIAN
        rows[walks].append(np.column_stack([track.positions, track.heading])[moves])
    vehicles, walkers = (np.concatenate([np.zeros((0, 3)), *rows[each]]) for each in (False, True))
    found = vehicles if len(vehicles) else walkers
    return found[:: 1 + len(found) // MOST_SAMPLES]


def _facing(track: TableTrack, traffic: Floats) -> TableTrack:
    unknown = np.isnan(track.heading)
    heading, positions = track.heading.copy(), track.positions.copy()
    edges = np.flatnonzero(np.diff(unknown.astype(np.int8), prepend=0, append=0)).reshape(-1, 2)
    for begin, end in edges.tolist():
        place = np.median(positions[begin:end], axis=0)
        nearest = int(((traffic[:, :2] - place) ** 2).sum(axis=1).argmin())
        heading[begin:end] = traffic[nearest, 2]
        positions[begin:end] -= track.ahead * along(heading[begin:end])
    return replace(track, heading=heading, positions=positions, assumed=unknown)


def _without_traffic(tracks: Tracks, unknown: Sequence[TableTrack]) -> Tracks:
    """Return the tracks of the actors with a heading, or of a single actor, whose heading has no influence.

    Raises:
        InterchangeError: nothing shows the heading of the ego, or of any of several actors.
    """
    if len(tracks.tracks) == 1:
        return replace(tracks, tracks=tuple(replace(each, heading=np.nan_to_num(each.heading)) for each in unknown))
    if len(unknown) == len(tracks.tracks) or any(track.is_ego for track in unknown):
        raise InterchangeError(f"nothing shows the heading of {_named(unknown)}: nobody moves", CURE, tracks.file)
    left = tuple(track for track in tracks.tracks if not np.isnan(track.heading).any())
    said = f"no motion shows the heading of {_named(unknown)}, and no traffic: no pair of it is evaluated; {CURE}"
    return replace(tracks, tracks=left, remarks=(*tracks.remarks, said))


def _named(tracks: Sequence[TableTrack]) -> str:
    more = f" and {len(tracks) - MOST_NAMED:,} more" if len(tracks) > MOST_NAMED else ""
    return ", ".join(cited(track.name) for track in tracks[:MOST_NAMED]) + more


# -- pairs that an assumption decides ----------------------------------------------------------------------------------


def decides(pair: Sequence[TableTrack], states: Floats) -> tuple[bool, bool]:
    """Return True if two actors touch with the assumed headings, and True if they do with some headings only.

    `states` (samples, 2, len(State)): those of both. `TURNS` headings of the actor without one are tried.
    """
    from engine.kernels.approach import search_contact_of

    outlines = np.array([[track.length, track.width] for track in pair])
    reach = np.hypot(*outlines.T).sum() / 2.0
    there = (states[:, :, State.PRESENT] != 0.0).all(axis=1)
    places = states[:, :, [State.X, State.Y]]
    apart = np.hypot(*(places[:, 1] - places[:, 0]).T)
    step = np.hypot(*np.diff(places, axis=0).reshape(-1, 2).T).max(initial=0.0)
    if not there.any() or apart[there].min() > reach + 2.0 * step:
        return False, False
    turned = [number for number, track in enumerate(pair) if track.assumed is not None and track.assumed.any()]
    touches: list[bool] = []
    for turn in range(TURNS):
        now = states.copy()
        now[:, turned, State.HEADING] += turn * math.pi / TURNS
        touches.append(search_contact_of(now, outlines, 0, 1).sample >= 0)
    return touches[0], any(touches) and not all(touches)


def undecided(pair: Sequence[TableTrack]) -> str:
    """Return the remark on a pair that is set aside."""
    who = next(track.name for track in pair if track.assumed is not None and track.assumed.any())
    one, other = (cited(track.name) for track in pair)
    return f"whether {one} and {other} touch depends on the heading of {cited(who)}: the pair is not evaluated; {CURE}"


def set_aside(
    tracks: list[TableTrack], states_of: Callable[[Sequence[TableTrack]], Floats], file: str
) -> tuple[list[TableTrack], tuple[str, ...]]:
    """Return the tracks, the ego's first, without actors that touch the ego only with an assumed heading.

    Raises:
        InterchangeError: no actor is left with the ego.
    """
    remaining, remarks = tracks[:1], list[str]()
    for track in tracks[1:]:
        pair = (tracks[0], track)
        touch = depends = False
        if any(each.assumed is not None and each.assumed.any() for each in pair):
            touch, depends = decides(pair, states_of(pair))
        if touch and depends:
            remarks.append(undecided(pair))
            continue
        if depends:
            remarks.append(f"with another heading {cited(tracks[0].name)} and {cited(track.name)} would touch")
        remaining.append(track)
    if len(remaining) == 1 and len(tracks) > 1:
        message, _, cure = remarks[0].partition(": the pair is not evaluated; ")
        raise InterchangeError(message, cure, file)
    return remaining, tuple(remarks)
