"""Actors of a recording at different heights: on a bridge and below it. All else is judged in one plane.

Two that are at different heights wherever they are near one another are no pair.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from engine.interchange.contract import cited
from engine.interchange.road_levels import LEVEL
from engine.interchange.tables.track import TableTrack
from engine.tables import Floats

SLOPE = 0.15
"""Steepest road: so much may two on one level differ in height per metre between them."""
AROUND = 2.0
"""Two are near one another where they are at most so much farther apart than at their nearest [m]."""
MOST_NAMED = 3
"""Pairs that a remark names."""


def height_between(
    one: TableTrack, other: TableTrack, begin: float = -np.inf, end: float = np.inf
) -> tuple[float, bool]:
    """Return the height of `other` above `one` at the nearest place where levels differ [m], 0 without any, and whether
    they differ wherever the two are near one another.

    begin, end [s]: when they are looked at.
    """
    heights = (one.height, other.height)
    time = np.union1d(one.time, other.time)
    first, last = max(one.time[0], other.time[0], begin), min(one.time[-1], other.time[-1], end)
    time = time[(time >= first) & (time <= last)]
    if not len(time):
        return 0.0, False
    places: list[Floats] = []
    for track, height in zip((one, other), heights, strict=True):
        if height is None:
            return 0.0, False
        places.append(np.stack([np.interp(time, track.time, column) for column in (*track.positions.T, height)]))
    x, y, above = places[1] - places[0]
    way = np.hypot(x, y)
    near = way <= way.min() + AROUND
    apart = np.abs(above[near]) >= LEVEL + SLOPE * way[near]  # False of NaN
    if not apart.any():
        return 0.0, False
    return float(above[near][apart][way[near][apart].argmin()]), bool(apart.all())


def may_be_apart(tracks: Sequence[TableTrack]) -> bool:
    """Return True if two of these may be on different levels."""
    heights = [track.height for track in tracks if track.height is not None]
    known = np.concatenate([np.zeros(0), *heights])
    known = known[np.isfinite(known)]
    return len(known) > 0 and float(np.ptp(known)) >= LEVEL


def on_one_level(tracks: list[TableTrack]) -> tuple[list[TableTrack], tuple[str, ...]]:
    """Return the tracks, the ego's first, without those on other levels than it, and remarks on them."""
    if not may_be_apart(tracks):
        return tracks, ()
    found = [(track, *height_between(tracks[0], track)) for track in tracks[1:]]
    kept = [tracks[0], *(track for track, _, throughout in found if not throughout)]
    remarks = [
        *level_remarks([(tracks[0].name, track.name, above) for track, above, throughout in found if throughout]),
        *(
            f"{cited(track.name)} is on another level than {cited(tracks[0].name)} for a part of their way: both are "
            "judged in one plane"
            for track, above, throughout in found
            if above and not throughout
        ),
    ]
    return kept, tuple(remarks)


def level_remarks(pairs: Sequence[tuple[str, str, float]]) -> Iterator[str]:
    """Yield the remark on pairs on different levels: both names, and how far the second is above the first [m]."""
    said = [
        f"{cited(other)} is {abs(above):.1f} m {'above' if above > 0.0 else 'below'} {cited(one)}"
        for one, other, above in pairs[:MOST_NAMED]
    ]
    if said:
        more = f", and {len(pairs) - MOST_NAMED:,} more pairs" if len(pairs) > MOST_NAMED else ""
        yield f"not on one level, and not judged: {'; '.join(said)}{more}"
