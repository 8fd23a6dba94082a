"""Signals beside roads: traffic lights, and signs. Source: ASAM OpenDRIVE 1.7.0, chapter 14."""

from collections.abc import Collection, Iterator, Mapping
from contextlib import suppress
from typing import NamedTuple

from engine.interchange.contract import InterchangeError
from engine.interchange.xml import Node


class OdrSignal(NamedTuple):
    """One signal, or a further place at which it counts."""

    id: str
    name: str
    country: str
    type: str
    """A number of the country's, or OpenDRIVE's own: 1000001 is a traffic light of three colours."""
    subtype: str
    value: float | None
    """Such as a speed, in the file's unit; None where there is none, or no number."""
    is_dynamic: bool
    s: float
    t: float
    """Place in the road [m]."""
    along: bool | None
    """Whether it counts for traffic that runs as the reference line does; None: for both ways."""
    lanes: tuple[tuple[int, int], ...]
    """First and last lane for which it counts; without any it counts for all."""


class Signals(NamedTuple):
    """Of one road."""

    own: tuple[OdrSignal, ...]
    references: tuple[OdrSignal, ...]
    """Of signals that stand elsewhere: their id, and where and for whom they count here."""
    unread: int
    """Without an id or a place, or with lanes that are no numbers."""
    valueless: int
    """With a value that is no number."""


NONE = Signals((), (), 0, 0)
ORIENTATIONS: Mapping[str, bool | None] = {"+": True, "-": False}
NOWHERE = ((0, 0),)
"""The lanes of a signal that counts for none where it stands, as in CARLA's towns: references say where it does."""


def road_signals(road: Node) -> Signals:
    """Those of a `road`."""
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
    """Raises InterchangeError: it has no id or no place, or lanes that are no numbers."""
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
    """Signals at the places at which they count; a reference to none is left out."""
    yield from (each for each in found.own if each.lanes != NOWHERE)
    for each in (each for each in found.references if each.lanes != NOWHERE):
        if (of := known.get(each.id)) is not None:
            yield of._replace(s=each.s, t=each.t, along=each.along, lanes=each.lanes)


def signal_remarks(every: Collection[Signals], known: Mapping[str, OdrSignal]) -> Iterator[str]:
    """On what is left out of the signals of all roads, and how many times."""
    if unread := sum(each.unread for each in every):
        yield f"signals are left out whose id, place or lanes cannot be read: {unread}"
    if valueless := sum(each.valueless for each in every):
        yield f"values of signals that are not numbers are left out: {valueless}"
    if lost := sum(of.id not in known for each in every for of in each.references):
        yield f"references are left out to signals that are not there, or cannot be read: {lost}"
