"""Roads of every kind, and positions read from a document by a few lines of their own, as the standard defines them."""

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from hypothesis import strategies as st

from engine.maps import RoadSpec


@st.composite
def specs(draw: Callable) -> RoadSpec:
    """Specifications that fit, of up to four intersections."""
    number = draw(st.integers(1, 4))
    width, radius = draw(st.floats(2.0, 5.0)), draw(st.just(0.0) | st.floats(0.5, 15.0))
    return RoadSpec(
        ways=draw(st.sampled_from([3, 4])),
        lanes=number,
        lane_width=width,
        corner_radius=radius,
        approach=draw(st.floats(1.0, 6.0)),
        rows=draw(st.integers(1, 2)),
        cols=draw(st.integers(1, 2)),
        block=2.0 * (number * width + radius) + draw(st.floats(8.0, 100.0)),
        left_hand=draw(st.booleans()),
    )


@dataclass(frozen=True)
class Place:
    point: complex
    heading: float
    """Of traffic [rad]."""


class Document:
    """A document by its ids."""

    def __init__(self, text: str) -> None:
        self.root = ElementTree.fromstring(text)
        self.roads = {road.attrib["id"]: road for road in self.root.iter("road")}
        self.junctions = {junction.attrib["id"]: junction for junction in self.root.findall("junction")}

    def lane(self, road: str, lane: int) -> Element:
        return next(each for each in self.roads[road].iter("lane") if each.attrib["id"] == str(lane))

    def place(self, road: str, lane: int, s: float) -> Place:
        """The middle of a lane at arc length `s` of its road."""
        element = self.roads[road]
        side = 1 if lane > 0 else -1
        widths = [number(self.lane(road, i).find("width"), "a") for i in range(side, lane, side)]
        offset = sum(number(each, "a") for each in element.iter("laneOffset"))
        middle = offset + side * (sum(widths) + 0.5 * number(self.lane(road, lane).find("width"), "a"))
        point, heading = self.reference(road, s)
        with_s = (lane > 0) == (element.attrib["rule"] == "LHT")
        return Place(point + middle * 1j * cmath.exp(1j * heading), heading if with_s else heading + math.pi)

    def reference(self, road: str, s: float) -> tuple[complex, float]:
        """Point and heading of the reference line."""
        pieces = list(self.roads[road].iter("geometry"))
        piece = [each for each in pieces if number(each, "s") <= s][-1]
        start, heading = complex(number(piece, "x"), number(piece, "y")), number(piece, "hdg")
        along, arc = s - number(piece, "s"), piece.find("arc")
        if arc is None:
            return start + along * cmath.exp(1j * heading), heading
        turn = along * number(arc, "curvature")
        centre = start + 1j * cmath.exp(1j * heading) / number(arc, "curvature")
        return centre + (start - centre) * cmath.exp(1j * turn), heading + turn

    def lane_ids(self, road: str) -> list[int]:
        return [int(lane.attrib["id"]) for lane in self.roads[road].iter("lane")]


def number(element: Element | None, name: str) -> float:
    assert element is not None
    return float(element.attrib[name])


def only(element: Element, path: str) -> Element:
    (found,) = element.findall(path)
    return found
