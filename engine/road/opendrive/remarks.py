"""Defects of a file that were corrected or omitted, a sentence each."""

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, pairwise

import numpy as np

from engine.errors import cited, quoted
from engine.opendrive.curves import Piece, Pose
from engine.opendrive.roads import OdrNetwork
from engine.road.opendrive.beside import BESIDE
from engine.road.opendrive.drawing import DrawnLane
from engine.road.opendrive.lanes import DRIVABLE, THROUGH, FileLane
from engine.road.opendrive.linking import Links, Way
from engine.road.opendrive.surfaces import LEAST_WIDTH, overlap
from engine.road.regions import Shape
from engine.tables import Floats
from engine.unread import Kind

WORTH_A_REMARK = 0.005
"""Jump from which on a remark reports it [m]."""
UNROUNDED = 0.01
"""Largest rounding error of lengths in files [m]."""
TOUCHING, ALIGNED = 0.1, math.radians(5.0)
"""Largest distance and angle between the end of a lane and the start of the next one [m, rad]."""
FOR_NOBODY = frozenset({"none", "curb", "median", "restricted"})
"""Types of lanes on which there is no traffic."""
OVERLAP = 5.0
"""Least common area of two junctions that is reported [m^2]; neighbours touch."""


def remarks_on(
    network: OdrNetwork,
    links: Links,
    found: Sequence[DrawnLane],
    left_out: Sequence[FileLane],
    ways: Mapping[str, Sequence[Way]],
    areas: Mapping[str, Shape | None],
) -> Iterator[str]:
    """Yield all remarks; `links` belong to the lanes in `found`, `left_out` are the omitted lanes."""
    yield from network.remarks
    yield from on_lengths(links)
    yield from on_sections(network)
    yield from on_lanes(left_out)
    yield from on_jumps([each.jump for each in found])
    yield from on_gaps(network)
    yield from on_links(network)
    yield from on_ends(links)
    yield from on_sides(network)
    yield from on_widths(links, [(each.inner, each.outer) for each in found])
    yield from on_junctions(network, ways, areas)


def unread_lanes(network: OdrNetwork) -> Iterator[Kind]:
    """Yield the types of lanes whose traffic is not simulated here."""
    lines: dict[str, dict[int, str]] = defaultdict(dict)
    for road in network.roads.values():
        for lane in (lane for section in road.sections for lane in section.lanes.values()):
            if lane.id and lane.type not in FOR_NOBODY | DRIVABLE | BESIDE.keys():
                lines[lane.type].setdefault(lane.line, road.id)
    for kind, of in lines.items():
        place = f"line {min(of)} in road {cited(of[min(of)])}"
        yield Kind(f"lane of type {quoted(kind)[1:-1]}", len(of), place)


def on_jumps(jumps: Sequence[float]) -> Iterator[str]:
    far = [jump for jump in jumps if jump > WORTH_A_REMARK]
    if far:
        count, is_ = ("1 lane jumps", "is") if len(far) == 1 else (f"{len(far)} lanes jump", "are")
        yield f"{count} aside between two sections, by up to {max(far):.2f} m, and {is_} evened out"


def on_gaps(network: OdrNetwork) -> Iterator[str]:
    """Yield a remark on pieces of reference lines that do not begin at the end of the piece before."""
    gaps = {
        road.id: max(
            (max(math.dist(one.pose(two.s)[:2], two.start[:2]), _hole(one, two)) for one, two in pairwise(road.pieces)),
            default=0.0,
        )
        for road in network.roads.values()
    }
    broken = [road for road, gap in gaps.items() if gap > WORTH_A_REMARK]
    if broken:
        first = max(broken, key=lambda road: gaps[road])
        yield f"the reference line {_of(first, broken)} is broken, by up to {gaps[first]:.3g} m"


def _hole(one: Piece, two: Piece) -> float:
    """Return the gap between the end of a piece and the next piece along the road [m]; 0 if it is rounding."""
    missing = two.s - one.s - one.length
    return missing if missing > UNROUNDED else 0.0


def on_lengths(links: Links) -> Iterator[str]:
    """Yield a remark on roads without a length."""
    if short := [road for road in links.network.roads if road not in links.sections]:
        more = f" and {len(short) - 1} more have" if short[1:] else " has"
        yield f"road `{short[0][:40]}`{more} no length: it is left out"


def on_sections(network: OdrNetwork) -> Iterator[str]:
    """Yield a remark on sections that begin after the end of their road."""
    roads = [road for road in network.roads.values() if road.length > 0.0]
    late = [(road, each) for road in roads for each in road.sections if each.start >= road.length + WORTH_A_REMARK]
    for road, section in late[:1]:
        more = f" (so are {len(late) - 1} more)" if late[1:] else ""
        where = f"begins at s = {section.start:g} m, beyond the end of the road at {road.length:g} m"
        yield f"a section of road `{road.id[:40]}` {where}: it is left out{more}"


def on_lanes(left_out: Sequence[FileLane]) -> Iterator[str]:
    """Yield a remark on lanes that cannot be driven."""
    for lane in left_out[:1]:
        more = f" and {len(left_out) - 1} more are" if left_out[1:] else " is"
        yield (
            f"lane {lane.first.lane} of road `{lane.road[:40]}`{more} left out: its middle has no length, or runs "
            "backwards in a curve that is tighter than the lane is far out"
        )


def on_links(network: OdrNetwork) -> Iterator[str]:
    """Yield remarks on links to missing roads and junctions, and on junctions of kinds that are not supported."""
    there = {"road": set(network.roads), "junction": set(network.junctions)}
    lost = [
        road.id
        for road in network.roads.values()
        if any(end.id not in there.get(end.kind, ()) for end in (road.predecessor, road.successor) if end is not None)
    ]
    if lost:
        yield f"a link {_of(lost[0], lost)} leads to something that does not exist: its lanes end"
    lost = [each.junction for each in network.connections if not {each.incoming, each.connecting} <= there["road"]]
    if lost:
        yield f"junction `{lost[0][:40]}` joins roads that do not exist: these connections are not used"
    yield from on_lane_links(network)
    for kind in dict.fromkeys(network.junction_types.values()):
        alike = [junction for junction, each in network.junction_types.items() if each == kind]
        more = f" and {len(alike) - 1} more" if alike[1:] else ""
        yield f"no lane leads through junction `{alike[0][:40]}`{more} of the type {cited(kind)}, which is not read"


def on_lane_links(network: OdrNetwork) -> Iterator[str]:
    """Yield a remark on connections that name lanes missing in their roads."""
    lost = [
        (each.junction, lane, road)
        for each in network.connections
        for road, lanes in ((each.incoming, each.lanes), (each.connecting, each.lanes.values()))
        if road in network.roads
        for lane in lanes
        if all(lane not in section.lanes for section in network.roads[road].sections)
    ]
    for junction, lane, road in lost[:1]:
        more = f" (so do {len(lost) - 1} more)" if lost[1:] else ""
        yield (
            f"a connection of junction `{junction[:40]}` names lane {lane} of road `{road[:40]}`, which has no such "
            f"lane: the link is not used{more}"
        )


def on_ends(links: Links) -> Iterator[str]:
    """Yield remarks on links that name the wrong end of a road, and on lanes that meet without a link."""
    wrong = [
        (end.road, joint.road)
        for end, joint in links.joints.items()
        if (said := links.stated(end)) is not None
        and (said.id, said.at_start) != (joint.road, None if said.at_start is None else joint.at_start)
    ]
    if wrong:
        one, other = wrong[0]
        yield (
            f"a link {_of(one, [road for road, _ in wrong])} names an end that lies elsewhere: the end of road "
            f"`{other[:40]}` that lies there is taken"
        )
    if moved := [links.lanes[each].road for each in links.contradicted]:
        yield f"links of lanes {_of(moved[0], moved)} contradict one another: those that fit are taken"
    if loose := list(unlinked(links)):
        before, after = (links.lanes[each] for each in loose[0])
        more = f" (so do {len(loose) - 1} more)" if loose[1:] else ""
        yield (
            f"lane {before.last.lane} of road `{before.road[:40]}` ends where lane {after.first.lane} of road "
            f"`{after.road[:40]}` begins, and no link joins them{more}"
        )


def unlinked(links: Links) -> Iterator[tuple[int, int]]:
    """Yield lanes that end where another lane begins, if no link joins them and one of them leads nowhere else."""
    onward: dict[int, set[int]] = {index: set(links.successors.get(index, ())) for index in range(len(links.lanes))}
    inbound: dict[int, set[int]] = defaultdict(set)
    for way in links.ways:
        onward[way.start].add(way.connecting)
    for before, following in onward.items():
        for after in following:
            inbound[after].add(before)
    starts: dict[tuple[int, int], list[int]] = defaultdict(list)
    for index, (start, _) in enumerate(links.poses):
        starts[_cell(start)].append(index)
    for before, (_, end) in enumerate(links.poses):
        column, row = _cell(end)
        around = [each for i in (-1, 0, 1) for j in (-1, 0, 1) for each in starts.get((column + i, row + j), ())]
        for after in around:
            if after == before or after in onward[before] or not links.follows(before, after, TOUCHING, ALIGNED):
                continue
            leads_on = any(links.follows(before, each) for each in onward[before])
            if not leads_on or not any(links.follows(each, after) for each in inbound[after]):
                yield before, after


def _cell(pose: Pose) -> tuple[int, int]:
    return round(pose.x / TOUCHING), round(pose.y / TOUCHING)


def on_sides(network: OdrNetwork) -> Iterator[str]:
    """Yield a remark on a file with both left-hand and right-hand roads."""
    left = [road.id for road in network.roads.values() if road.left_hand]
    if left and len(left) < len(network.roads):
        yield f"traffic keeps left only on {len(left)} of {len(network.roads)} roads, such as `{left[0][:40]}`"


def on_widths(links: Links, borders: Sequence[tuple[Floats, Floats]]) -> Iterator[str]:
    """Yield a remark on lanes outside junctions that have no width anywhere."""
    narrow = [
        links.sections[lane.road].road
        for lane, (inner, outer) in zip(links.lanes, borders, strict=True)
        if float(np.hypot(*(outer - inner).T).max(initial=0.0)) < LEAST_WIDTH
    ]
    if lost := list(dict.fromkeys(road.id for road in narrow if road.junction == THROUGH)):
        yield f"a lane {_of(lost[0], lost)} has no width: no vehicle fits into it"


def on_junctions(
    network: OdrNetwork, ways: Mapping[str, Sequence[Way]], areas: Mapping[str, Shape | None]
) -> Iterator[str]:
    """Yield remarks on junctions without drivable lanes, and on overlapping junctions."""
    for junction, area in areas.items():
        if area is None:
            yield f"no lane of junction `{junction[:40]}` has a width: it is not used"
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
