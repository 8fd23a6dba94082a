"""How CommonRoad writes numbers, points and states."""

from collections.abc import Mapping

from engine.interchange.xml_text import Element, child, decimal


def add_text(parent: Element, tag: str, text: str) -> None:
    child(parent, tag).text = text


def add_point(parent: Element, x: float, y: float) -> None:
    point = child(parent, "point")
    add_text(point, "x", decimal(x))
    add_text(point, "y", decimal(y))


def add_exact(parent: Element, values: Mapping[str, float]) -> None:
    """A child with an exact value for each name."""
    for tag, value in values.items():
        add_text(child(parent, tag), "exact", decimal(value))


def add_interval(parent: Element, tag: str, start: float, end: float) -> None:
    interval = child(parent, tag)
    add_text(interval, "intervalStart", decimal(start))
    add_text(interval, "intervalEnd", decimal(end))


def add_rectangle(parent: Element, length: float, width: float) -> Element:
    rectangle = child(parent, "rectangle")
    add_text(rectangle, "length", decimal(length))
    add_text(rectangle, "width", decimal(width))
    return rectangle
