"""A network as text and arrays, and back: the cached form of a file's roads, in the process and in the user's cache.

A new network passes through `Contents`, too, so a cached network equals the built one, bit for bit. A file of the cache
is a digest and its content: the key of the entry, the text, all arrays. Any other file is rejected.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from hashlib import blake2b
from itertools import pairwise
from typing import Any

import numpy as np

from engine.frozen import frozen
from engine.maps import MapFile
from engine.road.network import (
    Arm,
    Intersection,
    Lane,
    LaneGroup,
    LaneRole,
    Lines,
    Links,
    Maneuver,
    Network,
    Road,
    RoadSign,
    Surface,
    SurfaceKind,
)
from engine.road.paths import PathBook, Primitive
from engine.road.regions import Shape
from engine.tables import Floats
from engine.vocabulary import HeightColumn, ManeuverType

DIGEST = 32
"""Length of a digest [bytes]."""
WORD = 8
"""Bytes of a count in a file."""
ONE_LANE = ("name", "width", "path", "region", "road", "number", "forward")
ONE_MANEUVER = ("name", "start", "connecting", "end", "intersection_id")
ONE_SIGN = ("id", "name", "country", "type", "subtype", "value", "road", "x", "y", "lanes")
ONE_SURFACE = ("name", "width", "road", "forward", "intersection_id", "ends", "arm")
LINKED = ("maneuvers", "intersection", "successors", "predecessors", "default_route", "conflicts")
SHAPED = (("edges", 4), ("hull", 8), ("triangles", 6), ("cores", 4))
"""Arrays of a shape, and their columns."""
SAID = ("remarks", "levels", "unread")
DRAWN = ("kerbs", "middle", "between")


@frozen
class Contents:
    """A network without its specification."""

    text: Mapping[str, Any]
    """Values that JSON can represent."""
    arrays: Mapping[str, Floats]
    """Rows of all pieces, such as the primitives of all paths; `text` has the length of each piece."""

    @property
    def intersections(self) -> int:
        return len(self.text["intersections"])


def packed(network: Network, gap: float, turn: float) -> Contents:
    """Return the contents of a network that no scenario has used yet; `gap` and `turn` are those of its paths."""
    paths, links = network.paths, network.links
    pieces = dict(_pieces(network))
    joined = {path: parts for path in range(len(paths)) if (parts := paths.parts(path)) != (path,)}
    text = {
        "left_hand": network.left_hand,
        **{name: getattr(network, name) for name in SAID},
        "joints": (gap, turn),
        "joined": [(path, *parts) for path, parts in joined.items()],
        "lanes": [(each.role.value, *(getattr(each, name) for name in ONE_LANE)) for each in network.lanes],
        "maneuvers": [(int(each.type), *(getattr(each, name) for name in ONE_MANEUVER)) for each in network.maneuvers],
        "roads": [_road_row(each) for each in network.roads],
        "connecting": [_road_row(each) for each in network.connecting_roads],
        "intersections": [
            (each.name, each.center, each.region, [_leg_row(leg) for leg in each.legs])
            for each in network.intersections
        ],
        "links": {name: getattr(links, name) for name in LINKED},
        "beside": None if links.beside is None else [(lane, *both) for lane, both in links.beside.items()],
        "gives_way": links.gives_way,
        "signs": [tuple(getattr(sign, name) for name in ONE_SIGN) for sign in network.signs],
        "surfaces": [(each.kind.value, *(getattr(each, name) for name in ONE_SURFACE)) for each in network.surfaces],
        "limits": list(network.speed_limits.items()),
        "bounded": list(network.bounds),
        "is_drawn": network.drawn is not None,
        "counts": {name: [len(piece) for piece in found] for name, (found, _) in pieces.items()},
    }
    arrays = {
        name: np.concatenate([np.asarray(piece, dtype=np.float64).reshape(-1, columns) for piece in found])
        if found
        else np.zeros((0, columns))
        for name, (found, columns) in pieces.items()
    }
    return Contents(json.loads(json.dumps(text)), arrays)


def _pieces(network: Network) -> Iterator[tuple[str, tuple[Sequence[Any], int]]]:
    """Yield names of arrays with their pieces and number of columns."""
    paths, regions, bounds = network.paths, network.regions, network.bounds.values()
    yield "paths", ([paths.primitives(path) for path in range(len(paths))], 5)
    for name, columns in SHAPED:
        yield name, ([getattr(regions.shape(region), name) for region in range(len(regions))], columns)
        kerbs = [] if network.between_kerbs is None else [getattr(network.between_kerbs, name)]
        yield f"kerbs_{name}", (kerbs, columns)
        yield f"surface_{name}", ([getattr(each.shape, name) for each in network.surfaces], columns)
    yield "surface_paths", ([each.line for each in network.surfaces], 5)
    yield "left", ([left for left, _ in bounds], 2)
    yield "right", ([right for _, right in bounds], 2)
    yield "heights", ([network.heights], len(HeightColumn))
    for name in DRAWN:
        yield name, (() if network.drawn is None else getattr(network.drawn, name), 2)


def _road_row(road: Road) -> tuple[Any, ...]:
    return road.name, [lane.id for lane in road.forward.lanes], [lane.id for lane in road.backward.lanes]


def _leg_row(leg: Arm) -> tuple[Any, ...]:
    incoming, outgoing = ([lane.id for lane in lanes] for lanes in (leg.incoming_lanes, leg.outgoing_lanes))
    return leg.name, leg.heading, leg.length, incoming, outgoing, leg.neighbour, leg.phase


# -- and back ----------------------------------------------------------------------------------------------------------


def unpacked(contents: Contents, spec: MapFile) -> Network:
    """Return a new network with these contents, as a scenario adds its own joined paths."""
    text = contents.text
    said = {name: _tuple_of(text[name]) for name in SAID}
    network = Network(spec, text["left_hand"], _paths(contents), **said)
    for shape in zip(*(_parts(contents, name) for name, _ in SHAPED), strict=True):
        network.regions.add(Shape(*shape))
    network.lanes = tuple(
        Lane(network, index, row[1], LaneRole(row[0]), *row[2:]) for index, row in enumerate(text["lanes"])
    )
    network.maneuvers = tuple(
        Maneuver(network, index, row[1], ManeuverType(row[0]), *row[2:]) for index, row in enumerate(text["maneuvers"])
    )
    network.roads = tuple(_road(network, *row) for row in text["roads"])
    network.connecting_roads = tuple(_road(network, *row) for row in text["connecting"])
    network.intersections = tuple(
        _intersection(network, index, *row) for index, row in enumerate(text["intersections"])
    )
    network.links = _links(text)
    network.heights = contents.arrays["heights"]
    network.signs = tuple(RoadSign(*map(_tuple_of, row)) for row in text["signs"])
    between = zip(*(_parts(contents, f"kerbs_{name}") for name, _ in SHAPED), strict=True)
    network.between_kerbs = next((Shape(*parts) for parts in between), None)
    network.lay = lambda network: tuple(_surfaces(network, contents))
    network.speed_limits = dict(text["limits"])
    bounds = zip(_parts(contents, "left"), _parts(contents, "right"), strict=True)
    network.bounds = dict(zip(text["bounded"], bounds, strict=True))
    if text["is_drawn"]:
        network.drawn = Lines(*(tuple(_parts(contents, name)) for name in DRAWN))
    return network


def _parts(contents: Contents, name: str) -> list[Floats]:
    ends = np.cumsum([0, *contents.text["counts"][name]]).tolist()
    return [contents.arrays[name][start:end] for start, end in pairwise(ends)]


def _paths(contents: Contents) -> PathBook:
    joined = {tuple(parts): path for path, *parts in contents.text["joined"]}
    return PathBook(*contents.text["joints"]).filled(_lines(contents, "paths"), joined)


def _lines(contents: Contents, name: str) -> list[tuple[Primitive, ...]]:
    return [tuple(map(Primitive._make, part.tolist())) for part in _parts(contents, name)]


def _surfaces(network: Network, contents: Contents) -> Iterator[Surface]:
    shapes = zip(*(_parts(contents, f"surface_{name}") for name, _ in SHAPED), strict=True)
    rows = zip(contents.text["surfaces"], _lines(contents, "surface_paths"), shapes, strict=True)
    for index, ((kind, name, *about), line, shape) in enumerate(rows):
        yield Surface(network, index, SurfaceKind(kind), name, line, Shape(*shape), *map(_tuple_of, about))


def _road(network: Network, name: str, forward: Sequence[int], backward: Sequence[int]) -> Road:
    ahead, back = (
        LaneGroup(network, name, way, tuple(network.lanes[index] for index in lanes))
        for way, lanes in ((True, forward), (False, backward))
    )
    return Road(network, name, ahead, back, ())


def _intersection(
    network: Network, index: int, name: str, center: Sequence[float], region: int, legs: Sequence[Sequence[Any]]
) -> Intersection:
    x, y = center
    return Intersection(network, index, name, 0, index, (x, y), region, tuple(_leg(network, *leg) for leg in legs))


def _leg(
    network: Network,
    name: str,
    heading: float,
    length: float,
    incoming: Sequence[int],
    outgoing: Sequence[int],
    *rest: int,
) -> Arm:
    first, last = (tuple(network.lanes[lane] for lane in lanes) for lanes in (incoming, outgoing))
    return Arm(name, heading, length, first, last, *rest)  # type: ignore[arg-type]


def _links(text: Mapping[str, Any]) -> Links:
    rows: dict[str, list[Any]] = {name: [_tuple_of(each) for each in text["links"][name]] for name in LINKED}
    beside = None if text["beside"] is None else {lane: (left, right) for lane, left, right in text["beside"]}
    gives_way = None if text["gives_way"] is None else [tuple(each) for each in text["gives_way"]]
    return Links(**rows, beside=beside, gives_way=gives_way)


def _tuple_of(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value  # type: ignore[arg-type]


# -- as a file ---------------------------------------------------------------------------------------------------------


def to_bytes(contents: Contents, key: str) -> bytes:
    """Return the file of an entry of the cache."""
    text = dict(contents.text) | {"key": key, "arrays": {name: each.shape for name, each in contents.arrays.items()}}
    head = json.dumps(text).encode()
    head += b" " * (-(len(head) + WORD) % WORD)
    body = len(head).to_bytes(WORD, "little") + head + b"".join(each.tobytes() for each in contents.arrays.values())
    return blake2b(body, digest_size=DIGEST).digest() + body


def from_bytes(file: bytes, key: str) -> Contents | None:
    """Read a cached road; return None if the file is damaged or has another key."""
    body = memoryview(bytearray(file))[DIGEST:]
    if len(body) < WORD or blake2b(body, digest_size=DIGEST).digest() != file[:DIGEST]:
        return None
    end = WORD + int.from_bytes(body[:WORD], "little")
    text: dict[str, Any] = json.loads(bytes(body[WORD:end]))
    if text["key"] != key:
        return None
    arrays: dict[str, Floats] = {}
    for name, (rows, columns) in text["arrays"].items():
        flat: Floats = np.frombuffer(body, dtype=np.float64, count=rows * columns, offset=end)
        arrays[name] = flat.reshape(rows, columns)
        end += flat.nbytes
    return Contents(text, arrays)
