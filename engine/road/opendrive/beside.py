"""Surfaces of a file beside its lanes: sidewalks, shoulders, parking rows, bicycle lanes, kerbs, and its crossings."""

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import groupby

import numpy as np

from engine.errors import quoted
from engine.frozen import frozen
from engine.opendrive.near_roads import OdrCrossing
from engine.opendrive.roads import OdrRoad
from engine.road.areas import CARRIAGEWAY
from engine.road.network import LANE_TYPES, Surface, SurfaceKind
from engine.road.opendrive.fitting import Stretch, centre_line, stretches
from engine.road.opendrive.lanes import DRIVABLE, THROUGH, Lanes, Part, Sections
from engine.road.opendrive.surfaces import NoSurface, border, shape_of_outline, shape_of_polygon, shapely
from engine.road.paths import Pose, Primitive
from engine.road.regions import Shape, distance
from engine.road.streets import KERB_STRIP, strip_along
from engine.tables import Floats

BESIDE: Mapping[str, SurfaceKind] = {each: kind for kind, types in LANE_TYPES.items() for each in types}
"""Kinds of surfaces by the types of lanes; Scenic counts borders and parking rows as shoulders, too."""
SHORTEST = 0.05
"""Least length of a surface [m]."""
SMALLEST = 0.1
"""Least area of a crossing [m^2]."""
NEAR = 3.0
"""Largest distance of the end of a crossing from its sidewalk [m]; *ours*: a kerb ramp and the kerb."""


@frozen
class SurfacePlan:
    """The plan of one surface."""

    kind: SurfaceKind
    road: str
    """Id of its road in the file."""
    forward: bool
    """True beside the lanes in the direction of the reference line."""
    line: tuple[Primitive, ...]
    """Centre line, with the traffic beside it; over a crossing, across the road from the right to the left."""
    shape: Shape
    width: float


def surfaces_of(lanes: Lanes) -> tuple[tuple[SurfacePlan, ...], tuple[str, ...]]:
    """Return the surfaces of all roads, crossings last, and a remark on those that cannot be drawn."""
    found = [each for sections in lanes.sections.values() for each in _beside(sections)]
    found += [_crossing(road, each) for road in lanes.network.roads.values() for each in road.crossings]
    lost = [each for each in found if isinstance(each, str)]
    more = f" (so are {len(lost) - 1} more)" if lost[1:] else ""
    remarks = tuple(f"{each} is left out, as its area cannot be computed{more}" for each in lost[:1])
    return tuple(each for each in found if isinstance(each, SurfacePlan)), remarks


# -- strips along a road -----------------------------------------------------------------------------------------------


def _beside(sections: Sections) -> Iterator[SurfacePlan | str | None]:
    """Yield the strips of a road on both sides, and its kerbs; the name of a strip without a computable area."""
    for side in (-1, 1):
        strips = [_strip(sections, kind, chain) for kind, chain in _chains(sections, side)]
        yield from strips
        is_ordinary = sections.road.junction == THROUGH
        if is_ordinary and not any(each.kind is SurfaceKind.CURB for each in strips if isinstance(each, SurfacePlan)):
            yield from (_kerb(sections, chain) for chain in _outermost(sections, side))


def _chains(sections: Sections, side: int) -> Iterator[tuple[SurfaceKind, list[Part]]]:
    """Yield the strips of one side (1: left): the n-th lanes of one kind, through adjacent sections."""
    places: dict[tuple[SurfaceKind, int], list[Part]] = defaultdict(list)
    for index, (section, _) in enumerate(sections.rows):
        seen: dict[SurfaceKind, int] = defaultdict(int)
        for number in sorted((each for each in section.lanes if each * side > 0), key=abs):
            if (kind := BESIDE.get(section.lanes[number].type)) is not None:
                places[kind, seen[kind]].append(Part(index, number))
                seen[kind] += 1
    for (kind, _), parts in places.items():
        yield from ((kind, chain) for chain in _adjacent(parts))


def _outermost(sections: Sections, side: int) -> Iterator[list[Part]]:
    """Yield the outermost lanes of the carriageway of one side, through adjacent sections."""
    parts: list[Part] = []
    for index, (section, _) in enumerate(sections.rows):
        own = sorted((each for each in section.lanes if each * side > 0), key=abs)
        kinds = [(number, section.lanes[number].type) for number in own]
        driven = [number for number, kind in kinds if kind in DRIVABLE]
        beside = [number for number, kind in kinds if BESIDE.get(kind) in CARRIAGEWAY]
        walked = [abs(number) for number, kind in kinds if BESIDE.get(kind) is SurfaceKind.SIDEWALK]
        within = [each for each in (*driven, *beside) if each in driven or abs(each) < min(walked, default=math.inf)]
        if driven:
            parts.append(Part(index, max(within, key=abs)))
    yield from _adjacent(parts)


def _adjacent(parts: Sequence[Part]) -> Iterator[list[Part]]:
    """Yield the parts, cut where a section is missing between them."""
    for _, chain in groupby(enumerate(parts), key=lambda each: each[1].section - each[0]):
        yield [part for _, part in chain]


def _stretches(sections: Sections, chain: Sequence[Part]) -> tuple[Stretch, ...]:
    return stretches(sections.road, [(*sections.rows[part.section], part.lane) for part in chain])[0]


def _strip(sections: Sections, kind: SurfaceKind, chain: Sequence[Part]) -> SurfacePlan | str | None:
    """Return the strip of lanes of one kind; its name if its area cannot be computed; None without an area."""
    rows, road = _stretches(sections, chain), sections.road
    if not rows:
        return None
    try:
        shape = shape_of_outline(border(rows, outer=False), border(rows, outer=True))
    except NoSurface:
        return f"the {kind.value} of lane {chain[0].lane} of road `{road.id[:40]}`"
    widths = [row.width(0.5 * (row.start + row.end)) for row in rows]
    width = float(np.average(widths, weights=[row.end - row.start for row in rows]))
    return None if shape is None else _planned(kind, sections, chain[0].lane, rows, shape, width)


def _kerb(sections: Sections, chain: Sequence[Part]) -> SurfacePlan | None:
    """Return the outer border of lanes as a kerb."""
    rows = tuple(replace(row, inner=row.outer, jump=0.0) for row in _stretches(sections, chain))
    return _planned(SurfaceKind.CURB, sections, chain[0].lane, rows, None, KERB_STRIP)


def _planned(
    kind: SurfaceKind, sections: Sections, lane: int, rows: Sequence[Stretch], shape: Shape | None, width: float
) -> SurfacePlan | None:
    """Return the plan of a strip, by default the strip of that width along its line; None without a length."""
    road, line = sections.road, tuple(centre_line(rows))
    if sum(each.length for each in line) < SHORTEST:
        return None
    forward = not road.against(lane)
    if not forward:
        line = tuple(each.turned() for each in reversed(line))
    shape = shape or strip_along(line, width)
    return SurfacePlan(kind, road.id, forward, line, shape, width)


# -- crossings ---------------------------------------------------------------------------------------------------------


def _crossing(road: OdrRoad, crossing: OdrCrossing) -> SurfacePlan | str | None:
    """Return the surface of a crossing, which is walked along that of its axes which leads across the road."""
    polygon = shapely.make_valid(shapely.Polygon(crossing.corners))
    if polygon.area < SMALLEST:
        return f"the crossing {quoted(crossing.name or crossing.id)} of road `{road.id[:40]}`"
    try:
        shape = shape_of_polygon(polygon)
    except NoSurface:
        return f"the crossing {quoted(crossing.name or crossing.id)} of road `{road.id[:40]}`"
    across = road.reference(crossing.s).heading + 0.5 * math.pi
    corners = np.array(polygon.minimum_rotated_rectangle.exterior.coords)[:4]
    sides = corners[[1, 2]] - corners[[0, 1]]
    turned = sides @ np.array([math.cos(across), math.sin(across)]) / np.hypot(*sides.T)
    along = int(np.argmax(np.abs(turned)))
    way = sides[along] * np.sign(turned[along])
    x, y = (corners.mean(axis=0) - 0.5 * way).tolist()
    line = Primitive(x, y, math.atan2(way[1], way[0]), 0.0, float(np.hypot(*way)))
    return SurfacePlan(SurfaceKind.CROSSING, road.id, True, (line,), shape, float(np.hypot(*sides[1 - along])))


@frozen
class Sidewalks:
    """The sidewalks of a network, with the boxes around them."""

    surfaces: tuple[Surface, ...]

    @cached_property
    def boxes(self) -> Floats:
        """Return (n, 4) least x, least y, greatest x, greatest y."""
        corners = [each.shape.edges[:, :2] for each in self.surfaces]
        return np.array([[*each.min(axis=0), *each.max(axis=0)] for each in corners]).reshape(-1, 4)

    def nearest(self, pose: Pose) -> int | None:
        """Return the surface nearest to the end of a crossing; None if all are farther than `NEAR`."""
        at = np.array([pose.x, pose.y])
        around = (self.boxes[:, :2] <= at + NEAR) & (self.boxes[:, 2:] >= at - NEAR)
        near = [self.surfaces[each] for each in np.flatnonzero(around.all(axis=1)).tolist()]
        away = [(distance(each.shape, pose.x, pose.y), each.id) for each in near]
        least = min(away, default=(math.inf, 0))
        return least[1] if least[0] <= NEAR else None
