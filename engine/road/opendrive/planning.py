"""What a file of given contents comes to: its lanes with their centre lines, junctions and surfaces. Takes long, and is
done once.
"""

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import combinations, pairwise
from pathlib import Path

import numpy as np

from engine.frozen import frozen
from engine.interchange.contract import InterchangeError
from engine.maps import digest_of
from engine.opendrive.read import OdrNetwork, read_opendrive
from engine.opendrive.speeds import limit_at
from engine.road.network import Lines
from engine.road.opendrive.fitting import Stretch, centre_line, stretches
from engine.road.opendrive.lanes import THROUGH, FileLane, Part
from engine.road.opendrive.linking import Links, Way
from engine.road.opendrive.surfaces import LEAST_WIDTH, NoSurface, border, lies_in, overlap, ring_of, strip_between, union
from engine.road.paths import Primitive
from engine.road.regions import Shape
from engine.tables import Floats

WIDEST = 1000.0
"""No lane is wider [m]."""
SAME = 1e-6
"""Points nearer to one another are one [m]."""
WORTH_A_REMARK = 0.005
"""A jump from here on is told [m]."""
OVERLAP = 5.0
"""So much that two junctions have in common is told [m^2]; neighbours touch."""


@frozen
class LanePlan:
    """One lane as it will be."""

    lane: FileLane
    line: tuple[Primitive, ...]
    """Its centre, as its traffic runs."""
    shape: Shape
    bounds: tuple[Floats, Floats]
    """To the left and to the right of its traffic, with as many points each, as it runs."""
    width: float
    number: int
    name: str
    left: int | None
    right: int | None
    speed_limit: float | None
    """Where the lane is longest, in the middle [m/s]."""


@frozen
class Plan:
    """A file's lanes, junctions and surfaces."""

    links: Links
    lanes: tuple[LanePlan, ...]
    junctions: Mapping[str, tuple[Way, ...]]
    areas: Mapping[str, Shape]
    surface: Shape
    drawn: Lines
    left_hand: bool
    remarks: tuple[str, ...]


@lru_cache(maxsize=8)
def plan_of(path: str, digest: str) -> Plan:
    """The plan of a file of this digest, which may be kept for as long as there are files of it.

    Raises:
        InterchangeError: it is no OpenDRIVE file that can be driven on, or another one came into its place meanwhile.
    """
    network = read_opendrive(path)
    if digest_of(Path(path)) != digest:
        raise InterchangeError("the file changed while it was read", "start again once it is written", Path(path).name)
    links = Links(network)
    if not links.lanes:
        raise InterchangeError(
            "there is no lane to drive on in it", 'write lanes of the type "driving" into its roads', Path(path).name
        )
    rows, jumps = zip(*(lane_stretches(links, lane) for lane in links.lanes), strict=True)
    borders = [(border(each, outer=False), border(each, outer=True)) for each in rows]
    _refuse_wide(links, borders)
    lanes = tuple(_lane_plans(links, rows, borders))
    junctions: dict[str, list[Way]] = defaultdict(list)
    for way in links.ways:
        junctions[way.junction].append(way)
    rings = [ring_of(*each) for each in borders]
    inside: dict[str, list[Floats]] = defaultdict(list)
    for lane, ring in zip(links.lanes, rings, strict=True):
        inside[network.roads[lane.road].junction].append(ring)
    try:
        surface, kerbs = union(rings)
    except NoSurface as lost:
        raise _without_surface(links, rings, lost, Path(path).name) from None
    areas = {junction: _area(inside[junction]) for junction in junctions}
    left_hand = any(road.left_hand for road in network.roads.values())
    return Plan(
        links,
        lanes,
        {junction: tuple(ways) for junction, ways in junctions.items() if areas[junction] is not None},
        {junction: area for junction, area in areas.items() if area is not None},
        surface,
        Lines(kerbs, *_lines(links, borders)),
        left_hand,
        (
            *network.remarks,
            *on_jumps(jumps),
            *on_gaps(network),
            *on_links(network),
            *on_sides(network),
            *on_widths(links, borders),
            *on_junctions(network, junctions, areas),
        ),
    )


def lane_stretches(links: Links, lane: FileLane) -> tuple[tuple[Stretch, ...], float]:
    """All of a lane, and by how much it jumps aside at most [m]."""
    sections = links.sections[lane.road]
    return stretches(sections.road, [(*sections.rows[part.section], part.lane) for part in lane.parts])


def _refuse_wide(links: Links, borders: Sequence[tuple[Floats, Floats]]) -> None:
    """Raises InterchangeError where a lane is wider than any is."""
    for lane, (inner, outer) in zip(links.lanes, borders, strict=True):
        if (width := float(np.hypot(*(outer - inner).T).max(initial=0.0))) > WIDEST:
            road = links.sections[lane.road].road
            message = f"lane {lane.parts[0].lane} of road `{road.id[:40]}` is {width:.4g} m wide"
            raise InterchangeError(message, f"write widths of at most {WIDEST:g} m", road.place)


def _without_surface(links: Links, rings: Sequence[Floats], lost: NoSurface, file: str) -> InterchangeError:
    """Return the error about lanes whose surface is missing: it names one of them, unless no lane has any."""
    if lost.part is None:
        return InterchangeError("no lane in it has a width", "give its lanes a <width> above 0 m", file)
    lane = links.lanes[next((index for index, ring in enumerate(rings) if lies_in(ring, lost.part)), 0)]
    road = links.sections[lane.road].road
    what = f"the surface of lane {lane.parts[0].lane} of road `{road.id[:40]}` cannot be computed"
    return InterchangeError(what, "correct the widths and the reference line of that road", road.place)


def _area(rings: Sequence[Floats]) -> Shape | None:
    """What the lanes of a junction cover; None where they have no width."""
    try:
        return union(rings)[0]
    except NoSurface:
        return None


def _lane_plans(
    links: Links, rows: Sequence[Sequence[Stretch]], borders: Sequence[tuple[Floats, Floats]]
) -> Iterator[LanePlan]:
    seen: dict[str, int] = defaultdict(int)
    for index, lane in enumerate(links.lanes):
        line = centre_line(rows[index])
        name, seen[lane.road] = f"road{lane.road}.lane{seen[lane.road]}", seen[lane.road] + 1
        widths = [row.width(0.5 * (row.start + row.end)) for row in rows[index]]
        lengths = [row.end - row.start for row in rows[index]]
        longest = lane.parts[int(np.argmax([_length(links, lane, part.section) for part in lane.parts]))]
        sections = links.sections[lane.road]
        beside = sections.drivable(longest.section)
        outward = [number for number in beside if number * longest.lane > 0 and abs(number) >= abs(longest.lane)]
        left, right = _neighbours(links, lane, longest, beside)
        yield LanePlan(
            lane,
            tuple(line if lane.forward else [each.turned() for each in reversed(line)]),
            strip_between(*borders[index]),
            _bounds(lane, *borders[index]),
            float(np.average(widths, weights=lengths)) or 0.1,
            len(outward),
            name,
            left,
            right,
            _speed_limit(links, lane, longest),
        )


def _bounds(lane: FileLane, inner: Floats, outer: Floats) -> tuple[Floats, Floats]:
    """Its borders as traffic sees them; pairs of points that are those before them are left out."""
    left, right = (inner, outer) if lane.parts[0].lane < 0 else (outer, inner)
    new = (np.hypot(*np.diff(left, axis=0).T) > SAME) | (np.hypot(*np.diff(right, axis=0).T) > SAME)
    kept = np.concatenate([[True], new])
    left, right = left[kept], right[kept]
    return (left, right) if lane.forward else (right[::-1], left[::-1])


def _speed_limit(links: Links, lane: FileLane, at: Part) -> float | None:
    sections = links.sections[lane.road]
    row, end = sections.rows[at.section]
    return limit_at(0.5 * (row.start + end), row.lanes[at.lane].speeds, sections.road.speeds)


def _length(links: Links, lane: FileLane, section: int) -> float:
    row, end = links.sections[lane.road].rows[section]
    return end - row.start


def _neighbours(links: Links, lane: FileLane, at: tuple[int, int], beside: Sequence[int]) -> list[int | None]:
    """Lanes to the left and right where the lane is longest."""
    section, number = at
    side = 1 if number > 0 else -1
    inner, outer = (number - side if number != side else -side), number + side
    left, right = (inner, outer) if (number < 0) == lane.forward else (outer, inner)
    of = links.lane_of
    return [of.get((lane.road, (section, each))) if each in beside else None for each in (left, right)]  # type: ignore[call-overload]


def _lines(links: Links, borders: Sequence[tuple[Floats, Floats]]) -> tuple[tuple[Floats, ...], tuple[Floats, ...]]:
    """Middle lines, and lines between lanes of one direction, outside junctions."""
    middle: list[Floats] = []
    between: list[Floats] = []
    for lane, (inner, _) in zip(links.lanes, borders, strict=True):
        sections = links.sections[lane.road]
        if sections.road.junction != THROUGH:
            continue
        inmost = min(abs(part.lane) for part in lane.parts) == 1
        if not inmost:
            between.append(inner)
        elif lane.forward and _is_two_way(links, lane):
            middle.append(inner)
    return tuple(middle), tuple(between)


def _is_two_way(links: Links, lane: FileLane) -> bool:
    section, number = lane.parts[0]
    return any(other * number < 0 for other in links.sections[lane.road].drivable(section))


# -- what is odd about a file, and was mended or left out: a sentence each ---------------------------------------------


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
        yield f"a link {_of(lost[0], lost)} leads to something that does not exist: its lanes end"
    lost = [each.junction for each in network.connections if not {each.incoming, each.connecting} <= there["road"]]
    if lost:
        yield f"junction `{lost[0][:40]}` joins roads that do not exist: these connections are not used"


def on_sides(network: OdrNetwork) -> Iterator[str]:
    """On a file in which some roads keep left and others right."""
    left = [road.id for road in network.roads.values() if road.left_hand]
    if left and len(left) < len(network.roads):
        yield f"traffic keeps left only on {len(left)} of {len(network.roads)} roads, such as `{left[0][:40]}`"


def on_widths(links: Links, borders: Sequence[tuple[Floats, Floats]]) -> Iterator[str]:
    """On lanes outside junctions that have no width anywhere."""
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
    """On junctions without lanes to drive on, and on such as lie in one another's place."""
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
