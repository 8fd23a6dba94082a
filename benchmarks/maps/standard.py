"""How far do lanes end from where ASAM OpenDRIVE puts them? By its formulas, straight from the XML.

Independent of our reader: a place at (s, t) lies t to the left of the reference line at s, at right angles to it, and
the middle of a lane at t = offset + the widths of the lanes inside it + half its own (ASAM OpenDRIVE 1.8, reference
line coordinates, lane offset and lane width). Lines and arcs, which are all that CARLA's towns have; ends on other
curves are counted apart.
"""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from engine.maps import digest_of
from engine.road import build_network
from engine.road.opendrive.network import map_file
from engine.road.opendrive.planning import plan_of

CLOSE = 1e-9
"""Rounding of a place along a road [m]."""


def compare_with_standard(paths: Sequence[Path]) -> int:
    """Print by file how far the ends of lanes lie from the standard's, and which lane's most."""
    for path in paths:
        found = list(ends(path))
        known = [(apart, lane) for apart, lane in found if not math.isnan(apart)]
        apart, lane = max(known, default=(0.0, "none"))
        others = sum(each > 0.01 for each, _ in known)
        print(f"{path.name:24} {len(known)} ends of lanes, {len(found) - len(known)} more on other curves; "
              f"{others} further away than 1 cm, at most {1000.0 * apart:.1f} mm ({lane})", flush=True)  # fmt: skip
    return 0


def ends(path: Path) -> Iterator[tuple[float, str]]:
    """Of both ends of every lane, how far it lies from the standard's [m], and the lane's name."""
    network, links = build_network(map_file(path, path.name)), plan_of(str(path), digest_of(path)).links
    roads = {road.get("id"): road for road in ElementTree.parse(path).getroot().iter("road")}
    for lane in network.lanes:
        drawn = links.lanes[lane.id]
        road = roads[drawn.road]
        starts = [_number(each, "s") for each in road.iter("laneSection")]
        stops = [*starts[1:], _number(road, "length")]
        for part, along, at_start in ((drawn.first, 0.0, True), (drawn.last, lane.length, False)):
            row = links.sections[drawn.road].rows[part.section][0]
            section = min(range(len(starts)), key=lambda i, row=row: abs(starts[i] - row.start))
            s = starts[section] if at_start is drawn.forward else stops[section]
            pose = network.paths.pose(lane.path, along)
            place = _middle(road, section, part.lane, s)
            yield (math.nan if place is None else math.dist(place, (pose.x, pose.y))), lane.name


def _middle(road: Element, section: int, lane: int, s: float) -> tuple[float, float] | None:
    """Of a lane at s; None on curves that are neither lines nor arcs."""
    here = list(road.iter("laneSection"))[section]
    side = 1 if lane > 0 else -1
    lanes = {int(_number(each, "id")): each for each in here.iter("lane")}
    widths = [
        _cubic(lanes[side * inner].findall("width"), "sOffset", s - _number(here, "s"))
        for inner in range(1, abs(lane) + 1)
    ]
    t = _cubic(road.findall("lanes/laneOffset"), "s", s) + side * (sum(widths) - 0.5 * widths[-1])
    pose = _pose(road, s)
    return None if pose is None else (pose[0] - t * math.sin(pose[2]), pose[1] + t * math.cos(pose[2]))


def _pose(road: Element, s: float) -> tuple[float, float, float] | None:
    """Of the reference line."""
    piece = [each for each in road.iter("geometry") if _number(each, "s") <= s + CLOSE][-1]
    ds, x, y, heading = s - _number(piece, "s"), _number(piece, "x"), _number(piece, "y"), _number(piece, "hdg")
    k = float(piece[0].get("curvature", "0"))
    if piece[0].tag == "line" or (piece[0].tag == "arc" and k == 0.0):
        return x + ds * math.cos(heading), y + ds * math.sin(heading), heading
    if piece[0].tag != "arc":
        return None
    after = heading + k * ds
    return x + (math.sin(after) - math.sin(heading)) / k, y - (math.cos(after) - math.cos(heading)) / k, after


def _cubic(rows: Sequence[Element], start: str, s: float) -> float:
    """The cubic a + b ds + c ds² + d ds³ of the last row that begins by then; 0 without one."""
    begun = [row for row in rows if _number(row, start) <= s + CLOSE]
    if not begun:
        return 0.0
    ds = s - _number(begun[-1], start)
    return sum(_number(begun[-1], name) * ds**power for power, name in enumerate("abcd"))


def _number(element: Element, name: str) -> float:
    return float(element.get(name, "nan"))
