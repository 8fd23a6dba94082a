"""Lanes of a file with their stretches, borders and centre lines; and lanes that cannot be drawn."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from engine.errors import InterchangeError
from engine.frozen import frozen
from engine.opendrive.roads import OdrNetwork, OdrSection
from engine.road.opendrive.fitting import Stretch, centre_line, stretches
from engine.road.opendrive.lanes import FileLane
from engine.road.opendrive.linking import Links
from engine.road.opendrive.surfaces import APART, border, places, strip_between
from engine.road.paths import Primitive
from engine.tables import Floats, Ints

WIDEST = 1000.0
"""Maximum width of a lane [m]."""
SHORTEST = 1e-3
"""Minimum length of a lane [m]."""
BACKWARDS = 1.0
"""Distance that a middle may run against its road [m]; corners of public maps reach half of that."""
LONGEST = 500_000.0
"""Maximum length of all curved lanes of a map [m]; they take about 10 s."""
NOTHING = 1e-9


@frozen
class DrawnLane:
    """One lane, in the direction of its reference line."""

    rows: tuple[Stretch, ...]
    jump: float
    """Largest lateral jump of the line [m]."""
    inner: Floats
    """(n, 2) Border nearer to the reference line."""
    outer: Floats
    """(n, 2) Border farther from the reference line."""
    line: tuple[Primitive, ...]
    """Its centre."""


def lane_stretches(links: Links, lane: FileLane) -> tuple[tuple[Stretch, ...], float]:
    """Return all of a lane, and by how much it jumps aside at most [m]."""
    sections = links.sections[lane.road]
    return stretches(sections.road, [(*sections.rows[part.section], part.lane) for part in lane.parts])


def drawn(network: OdrNetwork) -> tuple[Links, tuple[DrawnLane, ...], tuple[FileLane, ...]]:
    """Return the drivable lanes, their links, and the omitted lanes.

    Raises:
        InterchangeError: there is no lane, a lane is too wide, or there are too many.
    """
    left_out: list[FileLane] = []
    while True:
        links = Links(network)
        if not links.lanes:
            cure = 'write lanes of the type "driving" into its roads'
            raise InterchangeError("there is no lane to drive on in it", cure, network.file)
        rows = [lane_stretches(links, lane) for lane in links.lanes]
        _refuse_long(network, [row for found, _ in rows for row in found])
        found = [_drawn(links, lane, *each) for lane, each in zip(links.lanes, rows, strict=True)]
        broken = [lane for lane, each in zip(links.lanes, found, strict=True) if each is None]
        if not broken:
            return links, tuple(each for each in found if each is not None), tuple(left_out)
        left_out += broken
        network = _without(network, links, broken)


def _drawn(links: Links, lane: FileLane, rows: tuple[Stretch, ...], jump: float) -> DrawnLane | None:
    """Return a lane; None if its middle runs backwards, or nowhere."""
    if not rows:
        return None
    inner, outer = border(rows, outer=False), border(rows, outer=True)
    _refuse_wide(links, lane, inner, outer)
    joints = np.cumsum([len(places(row)) + 1 for row in rows[:-1]], dtype=np.int64) - 1
    if _backwards(inner, outer, joints, 1.0 if lane.parts[0].lane > 0 else -1.0) > BACKWARDS:
        return None
    line = tuple(centre_line(rows))
    if sum(each.length for each in line) < SHORTEST or not len(strip_between(inner, outer).triangles):
        return None
    return DrawnLane(rows, jump, inner, outer, line)


def _backwards(inner: Floats, outer: Floats, joints: Ints, side: float) -> float:
    """Return the distance that the middle of a lane runs against its reference line [m]; `side`: 1 left of it, -1
    right.

    Steps over the `joints` of two stretches do not count: pieces of a reference line may overlap.
    """
    step = 0.5 * np.diff(inner + outer, axis=0)
    across = 0.5 * (outer[1:] + outer[:-1] - inner[1:] - inner[:-1])
    width = np.hypot(*across.T)
    along = side * (step[:, 0] * across[:, 1] - step[:, 1] * across[:, 0]) / np.maximum(width, NOTHING)
    along[joints] = 0.0
    return float(-along[(along < 0.0) & (width > NOTHING)].sum())


def _refuse_long(network: OdrNetwork, rows: Sequence[Stretch]) -> None:
    """Raise InterchangeError where the work for a map would have no end."""
    length = sum(row.end - row.start for row in rows if not row.is_plain)
    if length > LONGEST or len(rows) * APART > LONGEST:
        message = f"its curved lanes are {length / 1000.0:,.0f} km long, in {len(rows):,} pieces"
        raise InterchangeError(message, "cut the map down to the roads that are needed", network.file)


def _refuse_wide(links: Links, lane: FileLane, inner: Floats, outer: Floats) -> None:
    """Raise InterchangeError where a lane is wider than any is."""
    if (width := float(np.hypot(*(outer - inner).T).max(initial=0.0))) > WIDEST:
        road = links.sections[lane.road].road
        message = f"lane {lane.parts[0].lane} of road `{road.id[:40]}` is {width:.4g} m wide"
        raise InterchangeError(message, f"write widths of at most {WIDEST:g} m", road.place)


def _without(network: OdrNetwork, links: Links, lanes: Sequence[FileLane]) -> OdrNetwork:
    """Return a network in which some lanes keep their widths but are not drivable."""
    roads = dict(network.roads)
    for lane in lanes:
        parts = {links.sections[lane.road].rows[part.section][0].start: part.lane for part in lane.parts}
        road = roads[lane.road]
        sections = tuple(_closed(each, parts[each.start]) if each.start in parts else each for each in road.sections)
        roads[lane.road] = replace(road, sections=sections)
    return replace(network, roads=roads)


def _closed(section: OdrSection, lane: int) -> OdrSection:
    return replace(section, lanes={**section.lanes, lane: replace(section.lanes[lane], type="none")})
