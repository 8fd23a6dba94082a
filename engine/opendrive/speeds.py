"""Speed limits of roads and lanes. Source: ASAM OpenDRIVE 1.7.0, sections 10.4 (road type) and 11.8.6 (lane speed)."""

import bisect
import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from engine.xml import Node

UNITS = {"m/s": 1.0, "km/h": 1.0 / 3.6, "mph": 0.44704}
"""[m/s]"""


class SpeedFrom(NamedTuple):
    """Speed limit from a place on, up to the next place."""

    start: float
    """[m]"""
    limit: float | None
    """[m/s]; None without a limit, or if none is stated."""


def road_speeds(road: Node) -> tuple[SpeedFrom, ...]:
    """Return the speed limits of a road by its types."""
    found = (SpeedFrom(each.number("s", 0.0, low=0.0), _limit(each.find("speed"))) for each in road.every("type"))
    return tuple(sorted(found, key=lambda each: each.start))


def lane_speeds(lane: Node, start: float) -> tuple[SpeedFrom, ...]:
    """Return the speed limits of a lane in a section that begins at `start`."""
    found = (SpeedFrom(start + each.number("sOffset", 0.0, low=0.0), _limit(each)) for each in lane.every("speed"))
    return tuple(sorted(found, key=lambda each: each.start))


def _limit(node: Node | None) -> float | None:
    """Return the limit [m/s] of `max`: a number; None for `no limit`, `undefined` and all other texts."""
    try:
        value = math.nan if node is None else float(node.text("max", "nan"))
    except ValueError:
        return None
    limit = value * (UNITS.get(node.text("unit", "m/s"), math.nan) if node else math.nan)
    return limit if 0.0 < limit < math.inf else None


def limit_at(s: float, *rows: Sequence[SpeedFrom]) -> float | None:
    """Return the limit at a place [m/s]: that of the first rows with a limit there."""
    return next((limit for limit in _limits(s, rows) if limit is not None), None)


def _limits(s: float, rows: Sequence[Sequence[SpeedFrom]]) -> Iterator[float | None]:
    for each in rows:
        begun = bisect.bisect_right(each, s, key=lambda row: row.start)
        yield each[begun - 1].limit if begun else None
