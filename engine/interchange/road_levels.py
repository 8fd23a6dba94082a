"""Roads of a recording that pass over one another."""

from engine.errors import InterchangeError
from engine.maps import digest_of
from engine.opendrive.roads import OdrNetwork


def level_notes(road: OdrNetwork) -> tuple[str, ...]:
    """Return the notes on pairs of roads that cross at different heights; () if heights are unknown."""
    from engine.road.opendrive.network import contents_of

    if not any(row.a or row.b for each in road.roads.values() for row in each.heights):
        return ()
    try:
        levels = contents_of(str(road.path), digest_of(road.path)).text["levels"]
    except InterchangeError:
        return ()
    return tuple(f"{sentence}: all traffic is judged in one plane" for sentence in levels)
