"""Centre lines of a file's lanes as chains of lines and arcs.

If a reference line is straight or an arc and a lane has a constant distance from it, the lane's centre is exactly a
line or an arc. All other centres (spirals, polynomials, lanes that widen) are approximated by biarcs: two arcs from
pose to pose, subdivided until they are within `TOLERANCE`.

Source of the biarc: Meek and Walton, "Approximating smooth planar curves by arc splines", 1995.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise

import numpy as np

from engine.frozen import frozen
from engine.opendrive.curves import Piece, Pose
from engine.opendrive.roads import Cubic, OdrLane, OdrRoad, OdrSection, in_effect
from engine.road.paths import PathBook, Primitive
from engine.tables import Floats

TOLERANCE = 0.005
"""Largest distance of a fitted centre line from the file's [m]."""
SHORTEST = 0.05
"""Length below which a stretch is not subdivided [m]: files have corners, which no arc fits."""
WELD = 20.0
"""Length over which a lateral jump between two sections is smoothed [m]."""
NOTHING = 1e-9
STEP = 1e-4
"""Step of the differences that give headings [m]."""


@frozen
class Term:
    """A share of a width, a border or an offset."""

    share: float
    cubic: Cubic
    is_width: bool
    """A width is never negative."""

    def at(self, s: float) -> float:
        value = self.cubic.at(s)
        return self.share * (max(value, 0.0) if self.is_width else value)

    @property
    def is_constant(self) -> bool:
        return self.cubic.b == self.cubic.c == self.cubic.d == 0.0


@frozen
class Stretch:
    """Part of a lane on which all descriptions are constant."""

    start: float
    """Beginning on the reference line [m]."""
    end: float
    piece: Piece
    inner: tuple[Term, ...]
    """Terms of the border nearer to the reference line, to its left."""
    outer: tuple[Term, ...]
    """Terms of the border farther from it."""
    jump: float = 0.0
    """Lateral shift of the centre at the beginning of a weld [m]."""
    weld: float = 0.0
    """Beginning of the weld on the reference line [m]."""

    @property
    def is_plain(self) -> bool:
        """Return True if its centre is a line or an arc."""
        steady = all(term.is_constant for term in (*self.inner, *self.outer))
        return steady and self.jump == 0.0 and self.piece.curvature is not None

    def border(self, s: float, *, outer: bool) -> float:
        """Return the offset of a border to the left of the reference line [m]."""
        return sum(term.at(s) for term in (self.outer if outer else self.inner))

    def centre(self, s: float) -> float:
        left = 0.5 * (self.border(s, outer=False) + self.border(s, outer=True))
        return left + self.jump * _fading((s - self.weld) / WELD) if self.jump else left

    def width(self, s: float) -> float:
        return abs(self.border(s, outer=True) - self.border(s, outer=False))

    def beside(self, s: float, left: float) -> tuple[float, float]:
        """Return the point `left` of the reference line [m]."""
        pose = self.piece.pose(s)
        return pose.x - left * math.sin(pose.heading), pose.y + left * math.cos(pose.heading)

    def pose(self, s: float) -> Pose:
        """Return the pose of the centre, in the direction of the reference line."""
        x, y = self.beside(s, self.centre(s))
        before, after = max(s - STEP, self.start), min(s + STEP, self.end)
        (x0, y0), (x1, y1) = (self.beside(each, self.centre(each)) for each in (before, after))
        return Pose(x, y, math.atan2(y1 - y0, x1 - x0))


def _fading(u: float) -> float:
    """Return a smooth decrease from 1 to 0 for u from 0 to 1."""
    u = min(max(u, 0.0), 1.0)
    return 1.0 - u * u * (3.0 - 2.0 * u)


def stretches(road: OdrRoad, parts: Sequence[tuple[OdrSection, float, int]]) -> tuple[tuple[Stretch, ...], float]:
    """Return all stretches of a lane along its road, welded, and the largest jump before welding [m].

    Parts are sections, their ends, and the lane's id in them.
    """
    rows: list[Stretch] = []
    largest, jump, weld = 0.0, 0.0, 0.0
    for section, end, lane in parts:
        for stretch in _stretches(road, section, end, lane):
            if rows and abs(leap := rows[-1].centre(stretch.start) - stretch.centre(stretch.start)) > TOLERANCE:
                largest, jump, weld = max(largest, abs(leap)), leap, stretch.start
            rows += _welded(stretch, jump, weld)
    return tuple(rows), largest


def _welded(stretch: Stretch, jump: float, weld: float) -> Iterator[Stretch]:
    if jump == 0.0 or stretch.start >= weld + WELD - NOTHING:
        yield stretch
        return
    cut = min(stretch.end, weld + WELD)
    parts = (stretch.piece, stretch.inner, stretch.outer)
    yield Stretch(stretch.start, cut, *parts, jump, weld)
    if stretch.end > cut + NOTHING:
        yield Stretch(cut, stretch.end, *parts)


def _stretches(road: OdrRoad, section: OdrSection, end: float, lane: int) -> Iterator[Stretch]:
    side = 1 if lane > 0 else -1
    rows = [section.lanes[number] for number in range(side, lane + side, side) if number in section.lanes]
    cuts = {section.start, end}
    cuts |= {piece.s for piece in road.pieces} | {each.start for each in road.offsets}
    cuts |= {each.start for row in rows for each in (*row.widths, *row.borders)}
    within = sorted(s for s in cuts if section.start - NOTHING <= s <= end + NOTHING)
    for first, last in pairwise(within):
        if last - first > NOTHING:
            middle = 0.5 * (first + last)
            offset = in_effect(road.offsets, middle)
            base = () if offset is None else (Term(1.0, offset, False),)
            inner, outer = _borders(base, rows, side, middle)
            yield Stretch(first, last, _piece(road, middle), inner, outer)


def _piece(road: OdrRoad, s: float) -> Piece:
    return next((piece for piece in reversed(road.pieces) if piece.s <= s), road.pieces[0])


def _borders(
    base: tuple[Term, ...], rows: Sequence[OdrLane], side: int, s: float
) -> tuple[tuple[Term, ...], tuple[Term, ...]]:
    """Return the borders of the last of these adjacent lanes, which are ordered from the middle outwards."""
    inner = outer = base
    for row in rows:
        inner = outer
        if (border := in_effect(row.borders, s)) is not None:
            outer = (*base, Term(1.0, border, False))
        elif (width := in_effect(row.widths, s)) is not None:
            outer = (*inner, Term(float(side), width, True))
    return inner, outer


# -- as lines and arcs -------------------------------------------------------------------------------------------------


def centre_line(rows: Sequence[Stretch]) -> list[Primitive]:
    """Return the centre of a lane, in the direction of the reference line."""
    chain: list[Primitive] = []
    for row in rows:
        chain += _plain(row) if row.is_plain else _fitted(row.pose, row.start, row.end)
    return chain


def _plain(row: Stretch) -> list[Primitive]:
    pose, left = row.piece.pose(row.start), row.centre(row.start)
    line = Primitive(*pose, row.piece.curvature or 0.0, row.end - row.start).beside(left)
    count = max(1, math.ceil(abs(line.curvature) * line.length / math.pi - NOTHING))
    pieces = [Primitive(*line.pose(line.length * i / count), line.curvature, line.length / count) for i in range(count)]
    return pieces if line.length > NOTHING else []


def _fitted(pose: Callable[[float], Pose], start: float, end: float) -> list[Primitive]:
    chain = biarc(pose(start), pose(end))
    if end - start < SHORTEST or (chain and _leaves(chain, pose, start, end) <= TOLERANCE):
        return chain
    middle = 0.5 * (start + end)
    return _fitted(pose, start, middle) + _fitted(pose, middle, end)


def _leaves(chain: Sequence[Primitive], pose: Callable[[float], Pose], start: float, end: float) -> float:
    """Return the distance of the curve from a chain, at places in between [m]."""
    return float(distances(chain, np.array([pose(s)[:2] for s in np.linspace(start, end, 7)[1:-1]])).max())


def distances(chain: Sequence[Primitive], points: Floats) -> Floats:
    """Return the distances of points (n, 2) from a chain [m]."""
    paths = PathBook()
    return paths.feet(paths.add(chain), *points.T).distance


def biarc(first: Pose, last: Pose) -> list[Primitive]:
    """Return two arcs between poses with a common tangent where they meet; both tangents have equal lengths."""
    dx, dy = last.x - first.x, last.y - first.y
    if math.hypot(dx, dy) < NOTHING:
        return []
    t1, t2 = ((math.cos(each.heading), math.sin(each.heading)) for each in (first, last))
    tx, ty = t1[0] + t2[0], t1[1] + t2[1]
    along, denominator = dx * tx + dy * ty, 2.0 * (1.0 - (t1[0] * t2[0] + t1[1] * t2[1]))
    square = dx * dx + dy * dy
    if denominator < NOTHING:
        ahead = dx * t2[0] + dy * t2[1]
        reach = square / (4.0 * ahead) if ahead > NOTHING else math.inf
    else:
        reach = (-along + math.sqrt(along * along + denominator * square)) / denominator
    if not 0.0 < reach < 1e6:
        return []
    x = 0.5 * (first.x + last.x + reach * (t1[0] - t2[0]))
    y = 0.5 * (first.y + last.y + reach * (t1[1] - t2[1]))
    one = _arc(first.x, first.y, first.heading, x, y)
    back = _arc(last.x, last.y, last.heading + math.pi, x, y)
    two = back.turned()
    two = two._replace(heading=math.remainder(two.heading, math.tau))
    return [each for each in (one, two) if each.length > NOTHING]


def _arc(x: float, y: float, heading: float, to_x: float, to_y: float) -> Primitive:
    """Return the line or arc from a pose to a point."""
    dx, dy = to_x - x, to_y - y
    ahead, left = dx * math.cos(heading) + dy * math.sin(heading), dy * math.cos(heading) - dx * math.sin(heading)
    chord = math.hypot(dx, dy)
    half = math.atan2(left, ahead)
    if abs(half) < NOTHING or chord < NOTHING:
        return Primitive(x, y, heading, 0.0, chord)
    curvature = 2.0 * math.sin(half) / chord
    return Primitive(x, y, heading, curvature, 2.0 * half / curvature)
