"""Roads of a recording that pass over one another, and the heights of its actors."""

import numpy as np

from engine.errors import InterchangeError
from engine.maps import MapFile, MapSpec, digest_of
from engine.opendrive.roads import OdrNetwork
from engine.tables import Floats, Ints


def road_heights(road: MapSpec | None, kinds: Ints, states: Floats, first_lanes: Ints | None = None) -> Floats | None:
    """Return (samples, actors) heights of the road at all actors of a record [m]; None on a road without bridges."""
    if not isinstance(road, MapFile):
        return None
    from engine.host import heights_of, plain
    from engine.road import build_network, road_tables

    try:
        tables = road_tables(build_network(road))
        tables = tables if first_lanes is None else tables._replace(first_lanes=first_lanes)
        return heights_of(plain(tables), kinds, np.ascontiguousarray(states))
    except InterchangeError:
        return None


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
