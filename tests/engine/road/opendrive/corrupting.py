"""Links of a road file, each corrupted in turn: left out, in part or as a whole, or leading somewhere else."""

from collections.abc import Callable, Iterator
from copy import deepcopy
from functools import partial
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from engine.frozen import frozen

Change = Callable[[Element, Element], None]
FLIPPED = {"start": "end", "end": "start"}


@frozen
class Corrupted:
    """A file with one link that is wrong."""

    what: str
    names: frozenset[str]
    """Ids of the roads and the junction that the link is about."""
    text: str


def corruptions(text: str) -> Iterator[Corrupted]:
    """Yield every one of a file."""
    root = ElementTree.fromstring(text)
    for number, (element, names) in enumerate(_links(root)):
        for what, change in _changes(element):
            other = deepcopy(root)
            place, _ = list(_links(other))[number]
            change(other, place)
            told = f"{what} of <{element.tag} {' '.join(f'{k}={v}' for k, v in element.items())}>, {sorted(names)}"
            yield Corrupted(told, frozenset(names), ElementTree.tostring(other, encoding="unicode"))


def _links(root: Element) -> Iterator[tuple[Element, set[str]]]:
    """Yield each element that says how roads or lanes go on, with the ids of those that it is about."""
    for road in root.iter("road"):
        for end in road.findall("link/*"):
            yield end, {road.get("id", ""), end.get("elementId", "")}
        beside = {end.get("elementId", "") for end in road.findall("link/*")}
        for end in road.findall("lanes/laneSection/*/lane/link/*"):
            yield end, {road.get("id", ""), *beside}
    for junction in root.iter("junction"):
        for connection in junction.iter("connection"):
            names = {connection.get(name, "") for name in ("incomingRoad", "connectingRoad", "linkedRoad")}
            for element in connection.iter():
                yield element, names | {junction.get("id", "")}


def _changes(element: Element) -> Iterator[tuple[str, Change]]:
    yield "all", _remove
    for name in [each for each, _ in element.items() if (element.tag, each) != ("connection", "id")]:
        yield f"no {name}", partial(_drop, name)
        if name == "contactPoint":
            yield "the far end", partial(_put, name, FLIPPED[element.get(name, "")])
        elif name in {"id", "from", "to"}:
            yield f"another {name}", partial(_put, name, str(-int(element.get(name, "1"))))
            yield f"no such {name}", partial(_put, name, "9")
        elif name in {"elementId", "incomingRoad", "connectingRoad", "linkedRoad"}:
            yield f"no such {name}", partial(_put, name, "977")


def _drop(name: str, _: Element, element: Element) -> None:
    del element.attrib[name]


def _put(name: str, value: str, _: Element, element: Element) -> None:
    element.set(name, value)


def _remove(root: Element, element: Element) -> None:
    for parent in root.iter():
        if element in list(parent):
            parent.remove(element)
            return
