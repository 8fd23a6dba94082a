"""Buildings, crossings, traffic lights and signs near roads. Source: ASAM OpenDRIVE 1.7.0, chapters 13 and 14."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from typing import NamedTuple

from engine.errors import InterchangeError, cited, quoted
from engine.opendrive.curves import Pose
from engine.xml import Node


class OdrSignal(NamedTuple):
    """One signal, or a further place at which it applies."""

    id: str
    name: str
    country: str
    type: str
    """Number of the country's catalogue, or OpenDRIVE's own: 1000001 is a traffic light of three colours."""
    subtype: str
    value: float | None
    """Value such as a speed, in the file's unit; None without a number."""
    is_dynamic: bool
    s: float
    t: float
    """Place in the road [m]."""
    along: bool | None
    """True if it applies to traffic along the reference line, False to opposite traffic; None: to both."""
    lanes: tuple[tuple[int, int], ...]
    """First and last lane of each range to which it applies; () for all lanes."""


class Signals(NamedTuple):
    """Signals of one road."""

    own: tuple[OdrSignal, ...]
    references: tuple[OdrSignal, ...]
    """References to signals of other roads: their id, and the place and traffic to which they apply here."""
    unread: int
    """Number of signals without an id or a place, or with lanes that are not numbers."""
    valueless: int
    """Number of signals with a value that is not a number."""


NONE = Signals((), (), 0, 0)
ORIENTATIONS: Mapping[str, bool | None] = {"+": True, "-": False}
NOWHERE = ((0, 0),)
"""Lanes of a signal that applies to none at its own place, as in CARLA's towns; references state where it applies."""


def road_signals(road: Node) -> Signals:
    """Return the signals of a `road`."""
    below = road.find("signals")
    if below is None:
        return NONE
    own, references, unread, valueless = list[OdrSignal](), list[OdrSignal](), 0, 0
    for node in below.every("signal", "signalReference"):
        try:
            signal = _read(node)
        except InterchangeError:
            unread += 1
            continue
        (own if node.tag == "signal" else references).append(signal)
        valueless += signal.value is None and bool(node.attributes.get("value"))
    return Signals(tuple(own), tuple(references), unread, valueless)


def _read(node: Node) -> OdrSignal:
    """Return one signal.

    Raises:
        InterchangeError: it has no id or no place, or lanes that are not numbers.
    """
    return OdrSignal(
        node.text("id"),
        node.text("name", ""),
        node.text("country", ""),
        node.text("type", ""),
        node.text("subtype", ""),
        _value(node),
        node.text("dynamic", "no") == "yes",
        node.number("s", low=0.0),
        node.number("t"),
        ORIENTATIONS.get(node.text("orientation", "none")),
        tuple((each.integer("fromLane"), each.integer("toLane")) for each in node.every("validity")),
    )


def _value(node: Node) -> float | None:
    with suppress(InterchangeError):
        return node.number("value")
    return None


def counting(found: Signals, known: Mapping[str, OdrSignal]) -> Iterator[OdrSignal]:
    """Yield signals at the places at which they apply; a reference to an unknown signal is skipped."""
    yield from (each for each in found.own if each.lanes != NOWHERE)
    for each in (each for each in found.references if each.lanes != NOWHERE):
        if (of := known.get(each.id)) is not None:
            yield of._replace(s=each.s, t=each.t, along=each.along, lanes=each.lanes)


def signal_remarks(every: Collection[Signals], known: Mapping[str, OdrSignal]) -> Iterator[str]:
    """Yield remarks on omitted signals of all roads, with their numbers."""
    if unread := sum(each.unread for each in every):
        yield f"signals are left out whose id, place or lanes cannot be read: {unread}"
    if valueless := sum(each.valueless for each in every):
        yield f"values of signals that are not numbers are left out: {valueless}"
    if lost := sum(of.id not in known for each in every for of in each.references):
        yield f"references are left out to signals that are not there, or cannot be read: {lost}"


# -- buildings ---------------------------------------------------------------------------------------------------------

OVERHEAD = 4.0
"""Height from which on a building is overhead [m]: the greatest height of a truck (Directive 96/53/EC, annex I)."""
LARGEST_BUILDING = 10_000.0
"""Length or width [m]."""


BUILDING, CROSSWALK, OBSTACLE, PARKED = "building", "crosswalk", "obstacle", "parkedCar"
"""Types of objects that are read; an obstacle only with the subtype of a parked car."""


def road_objects(road: Node) -> tuple[list[Node], list[Node]]:
    """Return the walls of a road, which are buildings and parked cars, and its crossings; others count as left out."""
    objects = road.find("objects")
    found = objects.every("object") if objects else []
    walls = [each for each in found if _is_wall(each)]
    crossings = [each for each in found if each.text("type", "") == CROSSWALK]
    for each in found:
        if each not in walls and each not in crossings:
            each.leave_out()
    return walls, crossings


def _is_wall(node: Node) -> bool:
    if node.text("type", "") != OBSTACLE or node.text("subtype", "") != PARKED:
        return node.text("type", "") == BUILDING
    for name in ("id", "name", "height", "pitch", "roll", "orientation"):
        node.text(name, "")  # they say nothing about a car
    return True


def building_row(node: Node, reference: Callable[[float], Pose], longest: float) -> list[tuple[float, ...]]:
    """Return its row of `OdrNetwork.buildings`; [] if it is overhead.

    `reference`: the pose of the road's reference line at a place, which is at most `longest` [m].

    Raises:
        InterchangeError: it is not a rectangle, or has no place.
    """
    if node.number("zOffset", 0.0) >= OVERHEAD:
        return []
    if "radius" in node.attributes or node.every("outline", "outlines", "repeat"):
        raise node.error(
            "this building is not a rectangle", 'give it a length and a width, without "radius" or outlines'
        )
    s, t = node.number("s", low=0.0, high=longest), node.number("t")
    pose = reference(s).moved(0.0, t, node.number("hdg", 0.0))
    sizes = (node.number(name, low=0.01, high=LARGEST_BUILDING) for name in ("length", "width"))
    return [(*pose, *sizes)]


# -- crossings ---------------------------------------------------------------------------------------------------------


class OdrCrossing(NamedTuple):
    """A crossing for people on foot."""

    id: str
    name: str
    s: float
    """Place on the reference line [m]."""
    corners: tuple[tuple[float, float], ...]
    """Corners of its outline in order [m]."""


NO_AREA = ("zOffset", "height", "pitch", "roll", "orientation", "length", "width", "subtype", "dynamic", "validLength")
"""Attributes of a crossing that do not change its area, the last ones beside an outline; they count as read."""
FEWEST = 3
"""Least number of corners of an outline."""


def crossing_of(node: Node, reference: Callable[[float], Pose], longest: float) -> OdrCrossing:
    """Return a crossing by its outline, else by its length and width.

    `reference`: the pose of the road's reference line at a place, which is at most `longest` [m].

    Raises:
        InterchangeError: it has no place, or no area.
    """
    for name in NO_AREA:
        node.text(name, "")
    s, t = node.number("s", low=0.0, high=longest), node.number("t")
    there = reference(s).moved(0.0, t, node.number("hdg", 0.0))
    outlines = [*node.every("outline"), *(each for group in node.every("outlines") for each in group.every("outline"))]
    if outlines:
        corners = [_corner(each, there, reference, longest) for each in outlines[0].every("cornerRoad", "cornerLocal")]
    else:
        length, width = (node.number(name, low=0.01, high=LARGEST_BUILDING) / 2.0 for name in ("length", "width"))
        corners = [
            there.moved(u, v) for u, v in ((length, width), (-length, width), (-length, -width), (length, -width))
        ]
    ring = [(pose.x, pose.y) for pose in corners]
    distinct = [each for i, each in enumerate(ring) if each != ring[i - 1]]
    if len(distinct) < FEWEST:
        raise node.error(f"the outline of this crossing has {len(distinct)} corners", f"write {FEWEST} or more")
    return OdrCrossing(node.text("id", ""), node.text("name", ""), s, tuple(distinct))


def _corner(node: Node, there: Pose, reference: Callable[[float], Pose], longest: float) -> Pose:
    if "u" in node.attributes:
        return there.moved(node.number("u"), node.number("v"))
    return reference(node.number("s", low=0.0, high=longest)).moved(0.0, node.number("t"))


def on_crossings(unread: Sequence[str]) -> Iterator[str]:
    """Yield the sentence about crossings that are left out, which names the first."""
    if unread:
        first = f"{unread[0]} (so are {len(unread) - 1} more)" if unread[1:] else unread[0]
        yield f"crossings are left out that have no place or no area: {first}"


# -- remarks on buildings ----------------------------------------------------------------------------------------------


def on_buildings(unread: Sequence[str]) -> Iterator[str]:
    """Yield the sentence about those that are left out, which names the first."""
    if unread:
        first = f"{cited(unread[0])} and {len(unread) - 1} more" if unread[1:] else quoted(unread[0])
        yield f"buildings that are not rectangles, or have no place, are left out: {first}"
