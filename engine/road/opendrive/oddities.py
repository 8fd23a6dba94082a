"""What is odd about a file of roads, and was mended or left out: a sentence each."""

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, pairwise

import numpy as np

from engine.opendrive.read import OdrNetwork
from engine.road.opendrive.linking import THROUGH, Links, Way
from engine.road.opendrive.surfaces import LEAST_WIDTH, overlap
from engine.road.regions import Shape
from engine.tables import Floats

WORTH_A_REMARK = 0.005
"""A jump from here on is told [m]."""
OVERLAP = 5.0
"""So much that two junctions have in common is told [m^2]; neighbours touch."""


def on_jumps(jumps: Sequence[float]) -> Iterator[str]:
    far = [jump for jump in jumps if jump > WORTH_A_REMARK]
    if far:
        count, is_ = ("1 lane jumps", "is") if len(far) == 1 else (f"{len(far)} lanes jump", "are")
        yield f"{count} aside between two sections, by up to {max(far):.2f} m, and {is_} evened out"


def on_gaps(network: OdrNetwork) -> Iterator[str]:
    """On pieces of reference lines that do not begin where the ones before them end."""
    gaps = {
        road.id: max((math.dist(one.pose(two.s)[:2], two.start[:2]) for one, two in pairwise(road.pieces)), default=0.0)
        for road in network.roads.values()
    }
    broken = [road for road, gap in gaps.items() if gap > WORTH_A_REMARK]
    if broken:
        first = max(broken, key=lambda road: gaps[road])
        yield f"the reference line {_of(first, broken)} is broken, by up to {gaps[first]:.3g} m"


def on_links(network: OdrNetwork) -> Iterator[str]:
    """On what leads to roads and junctions that are not there."""
    there = {"road": set(network.roads), "junction": set(network.junctions)}
    lost = [
        road.id
        for road in network.roads.values()
        if any(end.id not in there.get(end.kind, ()) for end in (road.predecessor, road.successor) if end is not None)
    ]
    if lost:
        yield f"a link {_of(lost[0], lost)} leads to what is not there: its lanes end"
    lost = [each.junction for each in network.connections if not {each.incoming, each.connecting} <= there["road"]]
    if lost:
        yield f"junction `{lost[0][:40]}` joins roads that are not there: nobody goes that way"


def on_sides(network: OdrNetwork) -> Iterator[str]:
    """On a file in which some roads keep left and others right."""
    left = [road.id for road in network.roads.values() if road.left_hand]
    if left and len(left) < len(network.roads):
        yield f"traffic keeps left on {len(left)} of {len(network.roads)} roads alone, such as `{left[0][:40]}`"


def on_widths(links: Links, borders: Sequence[tuple[Floats, Floats]]) -> Iterator[str]:
    """On lanes outside junctions that have no width anywhere."""
    narrow = [
        links.sections[lane.road].road
        for lane, (inner, outer) in zip(links.lanes, borders, strict=True)
        if float(np.hypot(*(outer - inner).T).max(initial=0.0)) < LEAST_WIDTH
    ]
    if lost := list(dict.fromkeys(road.id for road in narrow if road.junction == THROUGH)):
        yield f"a lane {_of(lost[0], lost)} has no width: nobody fits into it"


def on_junctions(
    network: OdrNetwork, ways: Mapping[str, Sequence[Way]], areas: Mapping[str, Shape | None]
) -> Iterator[str]:
    """On junctions without lanes to drive on, and on such as lie in one another's place."""
    for junction, area in areas.items():
        if area is None:
            yield f"no lane of junction `{junction[:40]}` has a width: nobody goes that way"
    there = {road: each.junction for road, each in network.roads.items()}
    meant = [each.junction for each in network.connections if there.get(each.connecting, THROUGH) != THROUGH]
    if shut := [junction for junction in dict.fromkeys(meant) if junction not in ways]:
        more = f" and {len(shut) - 1} more" if shut[1:] else ""
        yield f"no lane leads through junction `{shut[0][:40]}`{more}: its links do not fit its roads"
    for (one, first), (other, second) in combinations(areas.items(), 2):
        if first is not None and second is not None and (common := overlap(first, second)) > OVERLAP:
            yield (
                f"junctions `{one[:40]}` and `{other[:40]}` have {common:.0f} m^2 in common: who is in one gives no "
                "way to those in the other"
            )


def _of(first: str, all_of_them: Sequence[str]) -> str:
    more = f" and {len(all_of_them) - 1} more" if len(all_of_them) > 1 else ""
    return f"of road `{first[:40]}`{more}"
