"""Read a Lanelet2 map by the package `lanelet2`: lanelets, their references in the routing graph, and traffic rules.

A map lies at an origin (UTM), or in the local coordinates of Autoware's tags `local_x` and `local_y`. References come
from the routing graph of a vehicle; speeds are those of speed limits, not those of the law of a country.
Source: Poggenhans et al., "Lanelet2: A high-definition map framework for the future of automated driving", 2018.
"""

import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from xml.etree.ElementTree import Element, ElementTree, SubElement

import numpy as np

from engine.errors import InterchangeError, quoted
from engine.extras import needed
from engine.frozen import frozen
from engine.tables import Floats
from engine.xml import Node, read_xml

WHO, EXTRA, PACKAGE = "`map lanelet2` needs", "lanelet2", "lanelet2"
DRIVABLE = frozenset({"road", "highway"})
"""Subtypes of lanelets that become lanes of motor vehicles."""
STRIPS = ("bicycle_lane", "crosswalk", "walkway", "road_shoulder")
"""Subtypes of lanelets that become surfaces beside or across the lanes; Autoware adds `road_shoulder`."""
LOCAL = ("local_x", "local_y")
KM_H = 1.0 / 3.6
"""1 km/h, the unit of the package's speed limits [m/s]."""
FARTHEST = 1e6
"""Largest local coordinate [m]."""
MOST_NOTES = 5
"""Maximum number of kinds of broken elements that are named; further ones are counted."""
ELEMENT = re.compile(r"Error (?:parsing|reading) primitive (?:with id )?(\d+)(?: from file)?: ")
"""Beginning of an error of the package, with the id of the element."""
NETCONVERT = (
    "it holds streets without the shape of their lanes: convert it with SUMO, as in `netconvert --osm-files FILE.osm "
    '--opendrive-output FILE.xodr`, and write `map opendrive("FILE.xodr")`'
)


@frozen
class Lanelet:
    """A lanelet in its own direction; bounds are (n, 3) [m]."""

    id: int
    subtype: str
    left: Floats
    right: Floats
    centre: Floats
    """(n, 2) centre line of the package, which has the points of both bounds [m]."""
    bounds: tuple[int, int]
    """Ids of its left and right bound."""
    following: tuple[int, ...] = ()
    """Lanelets into which traffic continues without a change of lane."""
    beside: tuple[int | None, int | None] = (None, None)
    """Left and right neighbour in the same direction, whether lanes may be changed or not."""
    conflicting: tuple[int, ...] = ()
    """Lanelets on the road that overlap it."""
    speed_limit: float | None = None
    """[m/s]"""
    turn: str = ""
    """Autoware's `turn_direction`: it runs through an intersection."""


@frozen
class Light:
    """A traffic light, and the lanelets that it applies to."""

    id: int
    x: float
    y: float
    lanelets: tuple[int, ...]


@frozen
class Priority:
    """A right of way: lanelets that have it, and those that yield."""

    first: frozenset[int]
    yields: frozenset[int]


@frozen
class LaneletMap:
    """Lanelets in the order of their ids, lights, and rules."""

    lanelets: tuple[Lanelet, ...]
    lights: tuple[Light, ...] = ()
    priorities: tuple[Priority, ...] = ()
    notes: tuple[str, ...] = ()
    """Broken references, a sentence each."""
    unread: Mapping[str, int] | None = None
    """Number of lanelets of other subtypes, and of rules of other kinds, by kind."""


def read_lanelets(path: Path, origin: tuple[float, float] | None) -> LaneletMap:
    """Return the lanelets of a file; `origin`: latitude and longitude of (0, 0) [deg], None for local coordinates.

    Raises:
        InterchangeError: it cannot be read, has no lanelets, or lacks coordinates.
        MissingExtraError: the package is not installed.
    """
    root, file = read_xml(path, "osm"), path.name
    if not any(_tags(node).get("type") == "lanelet" for node in root.every("relation")):
        raise InterchangeError("there is no lanelet in it", NETCONVERT.replace("FILE", path.stem), file)
    io, projection = _module("io"), _module("projection")
    local = projection.LocalCartesianProjector(io.Origin(0.0, 0.0)) if origin is None else None
    project = local if origin is None else projection.UtmProjector(io.Origin(*origin))
    with TemporaryDirectory() as folder:
        copy = Path(folder) / "map.osm"
        places, lost = _write_whole(root, local, copy)
        try:
            found, errors = io.loadRobust(str(copy), project)
        except RuntimeError as error:
            raise InterchangeError(_short(str(error)), "name a map in the format of Lanelet2 (OSM)", file) from None
    if local is not None:
        for point in found.pointLayer:
            point.x, point.y, point.z = places[point.id]
    notes = tuple(_notes([*lost, *[str(each).strip() for each in errors][1:]]))
    return _contents(found, notes, file)


def _module(name: str) -> Any:
    return needed(f"lanelet2.{name}", WHO, EXTRA, PACKAGE)


def _tags(node: Node) -> dict[str, str]:
    return {tag.text("k"): tag.text("v") for tag in node.every("tag")}


def _short(text: str) -> str:
    """Return an error of the package as one line."""
    return " ".join(text.split())[:160]


def _notes(errors: Sequence[str]) -> Iterator[str]:
    """Yield a sentence for each kind of broken element, with the first one and the number of others."""
    found: dict[str, list[str]] = {}
    for each in errors:
        match = ELEMENT.search(each)
        number = match.group(1) if match else ""
        reason = _short(each.replace(match.group(0), "") if match else each).removeprefix("- ")
        found.setdefault(reason, []).append(number)
    for reason, numbers in list(found.items())[:MOST_NOTES]:
        more = f" and {len(numbers) - 1} more" if len(numbers) > 1 else ""
        yield f"element {numbers[0]}{more}: {reason}" if numbers[0] else reason
    if len(found) > MOST_NOTES:
        yield f"{len(found) - MOST_NOTES} more kinds of broken elements"


Places = dict[int, tuple[float, float, float]]


def _write_whole(root: Node, local: Any, copy: Path) -> tuple[Places, list[str]]:
    """Write the points, ways, lanelets and rules of a file whose references are whole; return what was left out.

    The package reads the copy: it ends the process at a lanelet without bounds, and turns bounds by their places while
    it reads, so that points cannot be moved afterwards. `local`: the projector by which points get the latitude and
    longitude of their local coordinates, which are returned by the id of the point [m]; else None.

    Raises:
        InterchangeError: a point has no coordinates.
    """
    made, places, lost = Element("osm"), Places(), list[str]()
    for node in root.every("node"):
        attributes, number = dict(node.attributes), _id(node, "id")
        places[number] = (0.0, 0.0, 0.0)
        if local is not None:
            x, y, _ = places[number] = _local_place(node)
            gps = local.reverse(_module("core").BasicPoint3d(x, y, 0.0))
            attributes |= {"lat": repr(gps.lat), "lon": repr(gps.lon)}
        else:
            for name, most in (("lat", 90.0), ("lon", 180.0)):
                node.number(name, low=-most, high=most)
        _copy(made, node, attributes, node.children)
    ways = set[int]()
    for way in root.every("way"):
        there = [each for each in way.children if each.tag != "nd" or _id(each, "ref") in places]
        if len(there) < len(way.children):
            lost.append(f"Error parsing primitive {way.text('id')}: a way names points that are not there")
        if sum(each.tag == "nd" for each in there) > 1:
            ways.add(_id(way, "id"))
            _copy(made, way, dict(way.attributes), there)
    relations = [(each, _tags(each).get("type", "")) for each in root.every("relation")]
    known = {_id(each, "id") for each, kind in relations if kind in ("lanelet", "regulatory_element")}
    for relation, kind in relations:
        there = [each for each in relation.children if each.tag != "member" or _is_there(each, places, ways, known)]
        roles = [each.text("role", "") for each in there if each.tag == "member"]
        if kind == "lanelet" and not {"left", "right"} <= set(roles):
            lost.append(f"Error parsing primitive {relation.text('id')}: a lanelet names bounds that are not there")
        elif kind in ("lanelet", "regulatory_element"):
            if len(there) < len(relation.children):
                lost.append(f"Error parsing primitive {relation.text('id')}: it names elements that are not there")
            _copy(made, relation, dict(relation.attributes), there)
    ElementTree(made).write(copy, encoding="utf-8", xml_declaration=True)
    return places, lost


def _id(node: Node, name: str) -> int:
    """Return an id, which has up to 64 bits."""
    text = node.text(name)
    if not re.fullmatch(r"-?\d{1,19}", text, re.ASCII) or abs(int(text)) >= 2**63:
        raise node.error(f"{name}={quoted(text)} is no id", "write a whole number of up to 64 bits")
    return int(text)


def _copy(made: Element, node: Node, attributes: dict[str, str], children: Sequence[Node]) -> None:
    child = SubElement(made, node.tag, attributes)
    for part in children:
        SubElement(child, part.tag, dict(part.attributes))


def _is_there(member: Node, places: Places, ways: set[int], relations: set[int]) -> bool:
    of_kind = {"node": places, "way": ways, "relation": relations}.get(member.text("type", ""), ())
    return _id(member, "ref") in of_kind


def _local_place(node: Node) -> tuple[float, float, float]:
    """Return the local coordinates and the height of a point [m]."""
    tags = _tags(node)
    try:
        x, y = (float(tags[name]) for name in LOCAL)
    except (KeyError, ValueError):
        cure = "give the place of (0, 0) as latitude and longitude, as in `origin=(49.0, 8.4)`"
        raise node.error("a point has no `local_x` and `local_y`", cure) from None
    if not max(abs(x), abs(y)) <= FARTHEST:
        raise node.error("a point is too far away", f"give local coordinates of up to {FARTHEST:g} m")
    return x, y, _number(tags.get("ele", ""))


def _number(text: str) -> float:
    """Return the number of a text; 0 of any other text."""
    try:
        value = float(text)
    except ValueError:
        return 0.0
    return value if math.isfinite(value) else 0.0


# -- lanelets ----------------------------------------------------------------------------------------------------------


def _contents(found: Any, notes: tuple[str, ...], file: str) -> LaneletMap:
    rules = _module("traffic_rules")
    of_vehicles = rules.create(rules.Locations.Germany, rules.Participants.Vehicle)
    graph = _module("routing").RoutingGraph(found, of_vehicles)
    every = sorted(found.laneletLayer, key=lambda each: each.id)
    subtypes = {each.id: _attribute(each, "subtype") for each in every}
    broken = [each.id for each in every if not _has_shape(each)]
    kept = [each for each in every if subtypes[each.id] in {*DRIVABLE, *STRIPS} and each.id not in set(broken)]
    drivable = {each.id for each in kept if subtypes[each.id] in DRIVABLE}
    unread = Counter(f"lanelets of subtype `{kind or '(none)'}`" for kind in subtypes.values())
    for kind in (*DRIVABLE, *STRIPS):
        unread.pop(f"lanelets of subtype `{kind}`", None)
    unread.update(_unread_rules(found))
    lost = (f"{_listed(broken)} without an area" for _ in broken[:1])
    if not drivable:
        subtypes_there = ", ".join(sorted({f"`{kind}`" for kind in subtypes.values()}))
        cure = "a lanelet for vehicles has the subtype `road` or `highway`"
        raise InterchangeError(f"no lanelet is a road: there are {subtypes_there}", cure, file)
    return LaneletMap(
        tuple(_lanelet(each, subtypes[each.id], graph, of_vehicles, drivable) for each in kept),
        tuple(_lights(kept)),
        tuple(_priorities(found, drivable)),
        (*notes, *lost),
        dict(sorted(unread.items())),
    )


def _listed(ids: Sequence[int]) -> str:
    return f"lanelet {ids[0]}" if len(ids) == 1 else f"lanelet {ids[0]} and {len(ids) - 1} more are"


def _attribute(element: Any, name: str) -> str:
    return str(element.attributes[name]) if name in element.attributes else ""


def _points(line: Any) -> Floats:
    """Return (n, 3) the points of a bound, without repetitions."""
    return distinct(np.array([(point.x, point.y, point.z) for point in line]).reshape(-1, 3))


def distinct(line: Floats) -> Floats:
    """Return a polyline without points that repeat the place of the point before."""
    new = np.hypot(*np.diff(line[:, :2], axis=0).T) > SAME
    return line[np.concatenate([[True], new])] if len(line) else line


SAME = 1e-6
"""Distance below which points are equal [m]."""


def _has_shape(lanelet: Any) -> bool:
    left, right = _points(lanelet.leftBound), _points(lanelet.rightBound)
    return len(left) > 1 and len(right) > 1 and bool(np.isfinite(left).all() and np.isfinite(right).all())


def _lanelet(each: Any, subtype: str, graph: Any, rules: Any, drivable: set[int]) -> Lanelet:
    centre: Floats = np.array([(point.x, point.y) for point in each.centerline])
    shape = _points(each.leftBound), _points(each.rightBound), centre, (each.leftBound.id, each.rightBound.id)
    if each.id not in drivable:
        return Lanelet(each.id, subtype, *shape)
    following = tuple(sorted(other.id for other in graph.following(each) if other.id in drivable))
    conflicting = {other.id for other in graph.conflicting(each)} & drivable
    left = graph.left(each) or graph.adjacentLeft(each)
    right = graph.right(each) or graph.adjacentRight(each)
    beside = tuple(None if other is None or other.id not in drivable else other.id for other in (left, right))
    has_limit = len(each.speedLimits()) > 0 or "speed_limit" in each.attributes
    limit = rules.speedLimit(each).speedLimit * KM_H if has_limit else None
    turn = _attribute(each, "turn_direction")
    return Lanelet(each.id, subtype, *shape, following, beside, tuple(sorted(conflicting)), limit, turn)  # type: ignore[arg-type]


# -- rules -------------------------------------------------------------------------------------------------------------


READ_RULES = ("traffic_light", "right_of_way", "speed_limit")


def _unread_rules(found: Any) -> Counter[str]:
    kinds = (_attribute(each, "subtype") for each in found.regulatoryElementLayer)
    return Counter(f"rules of subtype `{kind}`" for kind in kinds if kind not in READ_RULES)


def _lights(lanelets: Sequence[Any]) -> Iterator[Light]:
    """Yield each light once, at the first point of its first line."""
    applies: dict[int, list[int]] = {}
    places: dict[int, tuple[float, float]] = {}
    for lanelet in lanelets:
        for rule in lanelet.trafficLights():
            for line in rule.trafficLights:
                points = list(line)
                if points:
                    places.setdefault(line.id, (points[0].x, points[0].y))
                    applies.setdefault(line.id, []).append(lanelet.id)
    for number in sorted(places):
        yield Light(number, *places[number], tuple(dict.fromkeys(applies[number])))


def _priorities(found: Any, drivable: set[int]) -> Iterator[Priority]:
    core = _module("core")
    for rule in sorted(found.regulatoryElementLayer, key=lambda each: each.id):
        if isinstance(rule, core.RightOfWay):
            first = frozenset(each.id for each in rule.rightOfWayLanelets()) & drivable
            yields = frozenset(each.id for each in rule.yieldLanelets()) & drivable
            if first and yields:
                yield Priority(first, yields)
