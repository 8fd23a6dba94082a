"""Interval versions of the instructions about outlines: rectangles (x, y, heading, length, width)."""

from collections.abc import Iterator, Sequence

import numpy as np

from engine.feasibility.intervals import Interval, truth
from engine.feasibility.places import SLACK, numbers
from engine.tables import Floats, RoadTables


def outline_points(box: Sequence[Interval]) -> Iterator[tuple[Interval, Interval]]:
    """Boxes around the four corners of an outline and around its centre."""
    x, y, heading, length, width = box
    known = numbers(*box)
    middle, turn = 0.5 * (heading.low + heading.high), 0.5 * (heading.high - heading.low)
    half = 0.25 * (length.low + length.high), 0.25 * (width.low + width.high)
    reach = np.hypot(*half)
    # A turn moves a corner along its circle, a change of size along its sides.
    moved = turn * reach + 0.25 * (length.high - length.low) + 0.25 * (width.high - width.low) + SLACK
    for along, across in ((0.0, 0.0), (1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)):
        ahead, left = along * half[0], across * half[1]
        shift = ahead * np.cos(middle) - left * np.sin(middle), ahead * np.sin(middle) + left * np.cos(middle)
        margin = np.zeros(len(moved)) if along == 0.0 else moved
        yield (
            Interval(x.low + shift[0] - margin, x.high + shift[0] + margin, ~known),
            Interval(y.low + shift[1] - margin, y.high + shift[1] + margin, ~known),
        )


def largest(size: Interval) -> Floats:
    return np.maximum(np.abs(size.low), np.abs(size.high))


def circles(box: Sequence[Interval]) -> tuple[Floats, Floats]:
    """Radii of a circle that lies in an outline, and of one that holds it."""
    least = np.maximum(np.minimum(box[3].low, box[4].low), 0.0)
    return 0.5 * least, 0.5 * np.hypot(largest(box[3]), largest(box[4]))


def _between_centres(a: Sequence[Interval], b: Sequence[Interval]) -> tuple[Floats, Floats]:
    """Least and greatest distance between two points."""
    gaps = [np.maximum(np.maximum(p.low - q.high, q.low - p.high), 0.0) for p, q in zip(a[:2], b[:2], strict=True)]
    spans = [np.maximum(p.high - q.low, q.high - p.low) for p, q in zip(a[:2], b[:2], strict=True)]
    return np.hypot(*gaps) - SLACK, np.hypot(*spans) + SLACK


def between_outlines(_road: RoadTables, operands: Sequence[Interval]) -> Sequence[Interval]:
    a, b = operands[:5], operands[5:]
    known = numbers(*operands)
    near, far = _between_centres(a, b)
    (inner_a, outer_a), (inner_b, outer_b) = circles(a), circles(b)
    low = np.where(known, np.maximum(near - outer_a - outer_b, 0.0), 0.0)
    high = np.where(known, np.maximum(far - inner_a - inner_b, 0.0), np.inf)
    return [Interval(low, high, ~known)]


def sees(_road: RoadTables, operands: Sequence[Interval]) -> Sequence[Interval]:
    viewer, outline = operands[:5], operands[5:]
    near = _between_centres(viewer, outline)[0] - circles(outline)[1]
    never = numbers(*operands) & (near > viewer[4].high)
    return [truth(np.zeros(len(never), dtype=bool), never)]
