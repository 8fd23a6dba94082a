"""Actors of a recording at different heights: on a bridge and below it. All others are judged in a plane.

Two actors that are at different heights at all places at which they are near one another are no pair.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from engine.errors import cited
from engine.interchange.tables.track import TableTrack
from engine.tables import Floats
from engine.vocabulary import LEVEL

SLOPE = 0.15
"""Largest slope of a road [m/m]: largest difference of height per distance of two actors on one level."""
AROUND = 2.0
"""Largest excess over the least distance of two actors at which they count as near [m]."""
MOST_NAMED = 3
"""Maximum number of pairs that a remark names."""


def height_between(
    one: TableTrack, other: TableTrack, begin: float = -np.inf, end: float = np.inf
) -> tuple[float, bool]:
    """Return the height of `other` above `one` at the nearest place with different levels [m], 0 without any, and True
    if levels differ at all places at which the two are near one another.

    begin, end [s]: the interval that is compared.
    """
    if one.height is None or other.height is None:
        return 0.0, False
    first, last = max(one.time[0], other.time[0], begin), min(one.time[-1], other.time[-1], end)
    time = np.unique(np.concatenate([each.time[(each.time >= first) & (each.time <= last)] for each in (one, other)]))
    if not len(time):
        return 0.0, False
    places = [
        np.stack([np.interp(time, track.time, column) for column in (*track.positions.T, height)])
        for track, height in ((one, one.height), (other, other.height))
    ]
    x, y, above = places[1] - places[0]
    way = np.hypot(x, y)
    near = way <= way.min() + AROUND
    apart = np.abs(above[near]) >= LEVEL + SLOPE * way[near]  # False of NaN
    if not apart.any():
        return 0.0, False
    return float(above[near][apart][way[near][apart].argmin()]), bool(apart.all())


def height_ranges(tracks: Sequence[TableTrack]) -> Floats:
    """Return the least and the greatest height of each track (tracks, 2) [m]; inf and -inf if it is unknown."""
    ends = ((np.nanmin, np.inf), (np.nanmax, -np.inf))
    heights = [np.zeros(0) if track.height is None else track.height for track in tracks]
    return np.array([[end(height, initial=beyond) for end, beyond in ends] for height in heights])


def may_be_apart(tracks: Sequence[TableTrack]) -> bool:
    """Return True if two of the tracks may be on different levels."""
    low, high = height_ranges(tracks).T
    return bool(high.max() - low.min() >= LEVEL)


def on_one_level(tracks: list[TableTrack]) -> tuple[list[TableTrack], tuple[str, ...]]:
    """Return the tracks, the ego's first, without those on another level than the ego, and remarks on them."""
    if not may_be_apart(tracks):
        return tracks, ()
    found = [(track, *height_between(tracks[0], track)) for track in tracks[1:]]
    remaining = [tracks[0], *(track for track, _, throughout in found if not throughout)]
    remarks = [
        *level_remarks([(tracks[0].name, track.name, above) for track, above, throughout in found if throughout]),
        *(
            f"{cited(track.name)} is on another level than {cited(tracks[0].name)} for a part of their way: both are "
            "judged in one plane"
            for track, above, throughout in found
            if above and not throughout
        ),
    ]
    return remaining, tuple(remarks)


def level_remarks(pairs: Sequence[tuple[str, str, float]]) -> Iterator[str]:
    """Yield the remark on pairs on different levels; a pair is both names, and the height of the second above the first
    [m].
    """
    said = [
        f"{cited(other)} is {abs(above):.1f} m {'above' if above > 0.0 else 'below'} {cited(one)}"
        for one, other, above in pairs[:MOST_NAMED]
    ]
    if said:
        more = f", and {len(pairs) - MOST_NAMED:,} more pairs" if len(pairs) > MOST_NAMED else ""
        yield f"not on one level, and not judged: {'; '.join(said)}{more}"
