"""Maps of Lanelet2 for tests: an intersection of four arms, written point by point."""

import math
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any
from xml.sax.saxutils import quoteattr

ORIGIN = (49.0, 8.4)
ARMS = ("east", "north", "west", "south")
FAR, NEAR = 60.0, 12.0
"""Distance of the ends of an arm from the centre [m]."""

Point = tuple[float, float]


@dataclass
class Writer:
    """A file under construction; points at one place are one node."""

    projector: Any = None
    """Projector of the package, for latitude and longitude; None: local coordinates alone."""
    nodes: dict[tuple[int, int], int] = field(default_factory=dict)
    text: list[str] = field(default_factory=list)
    ways: dict[tuple[int, ...], int] = field(default_factory=dict)
    count: int = 0

    def number(self) -> int:
        self.count += 1
        return self.count

    def node(self, point: Point, height: float) -> int:
        key = (round(point[0] * 1e6), round(point[1] * 1e6))
        if key not in self.nodes:
            self.nodes[key] = self.number()
            x, y = point
            place = 'lat="" lon=""'
            if self.projector is not None:
                gps = self.projector.reverse(import_module("lanelet2.core").BasicPoint3d(x, y, 0.0))
                place = f'lat="{gps.lat!r}" lon="{gps.lon!r}"'
            local = "" if self.projector else f'<tag k="local_x" v="{x!r}"/><tag k="local_y" v="{y!r}"/>'
            self.text.append(f'<node id="{self.nodes[key]}" {place}>{local}<tag k="ele" v="{height}"/></node>')
        return self.nodes[key]

    def way(self, points: list[Point], height: float = 0.0) -> int:
        nodes = tuple(self.node(point, height) for point in points)
        for way in (nodes, nodes[::-1]):
            if way in self.ways:
                return self.ways[way]
        self.ways[nodes] = self.number()
        inner = "".join(f'<nd ref="{node}"/>' for node in nodes)
        self.text.append(f'<way id="{self.ways[nodes]}">{inner}<tag k="type" v="line_thin"/></way>')
        return self.ways[nodes]

    def relation(self, kind: str, members: list[tuple[str, int, str]], **tags: str) -> int:
        number = self.number()
        inner = "".join(f'<member type="{what}" ref="{to}" role="{role}"/>' for what, to, role in members)
        inner += "".join(f"<tag k={quoteattr(k)} v={quoteattr(v)}/>" for k, v in {"type": kind, **tags}.items())
        self.text.append(f'<relation id="{number}">{inner}</relation>')
        return number

    def lanelet(
        self,
        left: list[Point],
        right: list[Point],
        subtype: str,
        rules: tuple[int, ...] = (),
        height: float = 0.0,
        **tags: str,
    ) -> int:
        members = [("way", self.way(left, height), "left"), ("way", self.way(right, height), "right")]
        members += [("relation", rule, "regulatory_element") for rule in rules]
        return self.relation("lanelet", members, subtype=subtype, location="urban", one_way="yes", **tags)

    @property
    def osm(self) -> str:
        return '<?xml version="1.0" encoding="UTF-8"?>\n<osm version="0.6">\n' + "\n".join(self.text) + "\n</osm>\n"


def turned(point: Point, angle: float) -> Point:
    x, y = point
    return x * math.cos(angle) - y * math.sin(angle), x * math.sin(angle) + y * math.cos(angle)


def curve(first: Point, last: Point, heading: float, end: float, count: int) -> list[Point]:
    """Return points of a cubic from a pose to another one."""
    reach = 0.55 * math.dist(first, last) * (0.75 if abs(math.remainder(end - heading, math.tau)) > 0.1 else 0.6)
    a = (first[0] + reach * math.cos(heading), first[1] + reach * math.sin(heading))
    b = (last[0] - reach * math.cos(end), last[1] - reach * math.sin(end))
    rows: list[Point] = []
    for i in range(count + 1):
        u = i / count
        w = (1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u * u * (1 - u), u**3
        rows.append(
            (
                sum(k * p[0] for k, p in zip(w, (first, a, b, last), strict=True)),
                sum(k * p[1] for k, p in zip(w, (first, a, b, last), strict=True)),
            )
        )
    return [first, *rows[1:-1], last]


@dataclass
class Crossing:
    """An intersection, with ids of its lanelets by what they are."""

    osm: str
    incoming: dict[str, int]
    outgoing: dict[str, int]
    inside: dict[tuple[str, str], int]
    """By the arms from which and into which they lead."""
    others: dict[str, int]
    light: int


def crossing(
    projector: Any = None, *, width: float = 3.5, turn: float = 0.0, left_hand: bool = False, points: int = 12
) -> Crossing:
    """Return an intersection of four arms, one lane in each direction, with a light, a priority, and strips."""
    file, sign = Writer(projector), -1.0 if left_hand else 1.0
    at = {arm: turn + number * math.pi / 2 for number, arm in enumerate(ARMS)}

    def place(arm: str, out: float, side: float) -> Point:
        """`side`: to the right of traffic that leaves, mirrored for traffic that keeps left."""
        return turned((out, -side * sign), at[arm])

    posts = [file.way([place("south", NEAR, -8.0), place("south", NEAR, -8.6)])]
    light = file.relation("regulatory_element", [("way", posts[0], "refers")], subtype="traffic_light")
    incoming, outgoing = dict[str, int](), dict[str, int]()

    def bounds(first: list[Point], second: list[Point]) -> tuple[list[Point], list[Point]]:
        return (second, first) if left_hand else (first, second)

    for arm in ARMS:
        middle = [place(arm, FAR, 0.0), place(arm, NEAR, 0.0)]
        inward = [place(arm, FAR, -width), place(arm, NEAR, -width)]
        outward = [place(arm, FAR, width), place(arm, NEAR, width)]
        rules = (light,) if arm == "south" else ()
        incoming[arm] = file.lanelet(*bounds(middle, inward), "road", rules, speed_limit="30")
        outgoing[arm] = file.lanelet(*bounds(middle[::-1], outward[::-1]), "road")
    inside = dict[tuple[str, str], int]()
    for start in ARMS:
        for end in ARMS:
            if start != end:
                heading, last = at[start] + math.pi, at[end]
                inner = curve(place(start, NEAR, 0.0), place(end, NEAR, 0.0), heading, last, points)
                outer = curve(place(start, NEAR, -width), place(end, NEAR, width), heading, last, points)
                inside[start, end] = file.lanelet(*bounds(inner, outer), "road")
    first = [incoming["east"], incoming["west"]]
    yields = [incoming["north"], incoming["south"]]
    file.relation(
        "regulatory_element",
        [*(("relation", each, "right_of_way") for each in first), *(("relation", each, "yield") for each in yields)],
        subtype="right_of_way",
    )
    edge, walk = width + 1.5, width + 3.5
    strips = {
        "bicycle_lane": (
            [place("east", FAR, width), place("east", NEAR, width)],
            [place("east", FAR, edge), place("east", NEAR, edge)],
        ),
        "walkway": (
            [place("east", FAR, edge), place("east", NEAR, edge)],
            [place("east", FAR, walk), place("east", NEAR, walk)],
        ),
        "road_shoulder": (
            [place("west", FAR, width), place("west", NEAR, width)],
            [place("west", FAR, edge), place("west", NEAR, edge)],
        ),
        "crosswalk": (
            [place("east", 16.0, edge), place("east", 16.0, -edge)],
            [place("east", 20.0, edge), place("east", 20.0, -edge)],
        ),
    }
    others = {kind: file.lanelet(*lines, kind) for kind, lines in strips.items()}
    others["rail"] = file.lanelet([(80.0, 80.0), (90.0, 80.0)], [(80.0, 78.0), (90.0, 78.0)], "rail")
    return Crossing(file.osm, incoming, outgoing, inside, others, light)


def bridge(height: float) -> str:
    """Return two roads of which one crosses the other one at a height [m]."""
    file = Writer()
    for x, y, heading, up in ((-60.0, 0.0, 0.0, 0.0), (0.0, -60.0, math.pi / 2, height)):
        dx, dy = math.cos(heading), math.sin(heading)
        lines = [[(x + s * dx - side * dy, y + s * dy + side * dx) for s in (0.0, 120.0)] for side in (2.0, -2.0)]
        file.lanelet(lines[0], lines[1], "road", height=up)
    return file.osm
