"""Charts as SVG: courses over generations or time, with bands, and box plots. Colours come from the style sheet.

A chart keeps its scales in `data-` attributes, so that a script can set a cursor where a value is.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from cortex_dsl.report.findings.readable import significant
from cortex_dsl.report.page.markup import Element, Node, element
from cortex_dsl.report.page.scene_svg import number, points_text
from engine.tables import Floats

LEFT, RIGHT, TOP, BOTTOM = 46, 12, 12, 30
"""Room around a chart for its scales [px]."""
TICKS = 4
STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)


@dataclass(frozen=True)
class Course:
    """A line of a chart; a NaN interrupts it. `low` and `high` bound a band around it, if there are any."""

    name: str
    style: str
    x: Floats
    y: Floats
    low: Floats | None = None
    high: Floats | None = None
    dots: bool = False
    """Points that are not joined."""


@dataclass(frozen=True)
class Scale:
    """From values to places along one side of a chart [px]."""

    low: float
    high: float
    start: float
    end: float
    ticks: tuple[float, ...] = field(default=())

    def __call__(self, value: float) -> float:
        return self.start + (value - self.low) / (self.high - self.low) * (self.end - self.start)

    def all(self, values: Floats) -> Floats:
        return self.start + (values - self.low) / (self.high - self.low) * (self.end - self.start)


@dataclass(frozen=True)
class Mark:
    """A moment to show across the chart: a dashed line, or a lighter stretch from it to the end."""

    x: float
    style: str
    to_end: bool = False


def line_chart(
    courses: Sequence[Course],
    title: str,
    *,
    size: tuple[int, int] = (360, 190),
    x_label: str = "",
    x_range: tuple[float, float] | None = None,
    marks: Sequence[Mark] = (),
    cursor: bool = False,
) -> Element:
    """Return courses over a common x; the scale of y includes 0. `size`: width and height [px]."""
    width, height = size
    across, up = _x_scale(courses, x_range, width), _y_scale(courses, height)
    return element(
        "svg",
        element("title", title),
        [_shade(mark, across, height) for mark in marks if mark.to_end],
        _grid(across, up, width, height, x_label),
        [_band(course, across, up) for course in courses if course.low is not None],
        [_course(course, across, up) for course in courses],
        [_mark(mark, across, height) for mark in marks if not mark.to_end],
        _cursor(across, height) if cursor else None,
        viewBox=f"0 0 {width} {height}",
        class_="chart",
        role="img",
        xmlns="http://www.w3.org/2000/svg",
        data_low=repr(across.low),
        data_high=repr(across.high),
        data_start=number(across.start),
        data_end=number(across.end),
    )


def nice_ticks(low: float, high: float, count: int = TICKS) -> tuple[float, ...]:
    """Round numbers that enclose [low, high] in about `count` steps."""
    if not high > low:
        low, high = (low - 0.5, high + 0.5) if low else (0.0, 1.0)
    raw = (high - low) / count
    power = 10.0 ** math.floor(math.log10(raw))
    step = power * next(s for s in STEPS if s * power >= raw * (1 - 1e-9))
    first, last = math.floor(low / step + 1e-9), math.ceil(high / step - 1e-9)
    return tuple(round(step * k, 10) for k in range(first, last + 1))


def vertical(low: float, high: float, height: int, count: int = TICKS) -> Scale:
    """A scale of round numbers along the left side."""
    ticks = nice_ticks(low, high, count)
    return Scale(ticks[0], ticks[-1], height - BOTTOM, TOP, ticks)


def _x_scale(courses: Sequence[Course], x_range: tuple[float, float] | None, width: int) -> Scale:
    values = np.concatenate([np.zeros(0), *(course.x for course in courses)])
    values = values if len(values) else np.zeros(1)
    low, high = x_range or (float(values.min()), float(values.max()))
    high = high if high > low else low + 1.0
    ticks = tuple(tick for tick in nice_ticks(low, high, 6) if low - 1e-9 <= tick <= high + 1e-9)
    if len(values) and np.array_equal(values, np.round(values)):  # generations are counted in whole numbers
        ticks = tuple(tick for tick in ticks if tick == round(tick))
    return Scale(low, high, LEFT, width - RIGHT, ticks)


def _y_scale(courses: Sequence[Course], height: int) -> Scale:
    parts = [part for course in courses for part in (course.y, course.low, course.high) if part is not None]
    values = np.concatenate(parts) if parts else np.zeros(0)
    values = values[np.isfinite(values)]
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
    return vertical(min(0.0, low), high, height)


def _grid(across: Scale, up: Scale, width: int, height: int, x_label: str) -> Element:
    right, bottom = width - RIGHT, height - BOTTOM
    return element(
        "g",
        [_rule(LEFT, up(tick), right, up(tick), "rule" if tick else "rule base") for tick in up.ticks],
        [_text(LEFT - 6, up(tick) + 4, significant(tick), "end") for tick in up.ticks],
        [_text(across(tick), bottom + 15, significant(tick), "middle") for tick in across.ticks],
        _text(right, height - 4, x_label, "end", "axis-name") if x_label else None,
        class_="grid",
    )


def _text(x: float, y: float, text: str, anchor: str, name: str | None = None) -> Element:
    return element("text", text, x=number(x), y=number(y), text_anchor=anchor, class_=name)


def _rule(x1: float, y1: float, x2: float, y2: float, name: str) -> Element:
    return element("line", x1=number(x1), y1=number(y1), x2=number(x2), y2=number(y2), class_=name)


def _course(course: Course, across: Scale, up: Scale) -> Node:
    points = np.column_stack([across.all(course.x), up.all(course.y)])
    if course.dots:
        there = points[np.isfinite(points[:, 1])]
        return [element("circle", cx=number(x), cy=number(y), r=2, class_=f"dot {course.style}") for x, y in there]
    return [
        element("polyline", points=points_text(part, 1), class_=f"course {course.style}")
        for part in _unbroken(points)
        if len(part)
    ]


def _band(course: Course, across: Scale, up: Scale) -> Node:
    assert course.low is not None
    assert course.high is not None
    there = np.isfinite(course.low) & np.isfinite(course.high)
    x = across.all(course.x[there])
    edge = np.concatenate([up.all(course.low[there]), up.all(course.high[there])[::-1]])
    points = points_text(np.column_stack([np.concatenate([x, x[::-1]]), edge]), 1)
    return element("polygon", points=points, class_=f"band {course.style}")


def _unbroken(points: Floats) -> list[Floats]:
    """The stretches between points that are not numbers."""
    gaps = [-1, *np.flatnonzero(~np.isfinite(points).all(axis=1)).tolist(), len(points)]
    return [points[start + 1 : end] for start, end in pairwise(gaps)]


def _shade(mark: Mark, across: Scale, height: int) -> Element:
    x = across(mark.x)
    return element(
        "rect",
        x=number(x),
        y=TOP,
        width=number(max(0.0, across.end - x)),
        height=height - TOP - BOTTOM,
        class_=mark.style,
    )


def _mark(mark: Mark, across: Scale, height: int) -> Element:
    return _rule(across(mark.x), TOP, across(mark.x), height - BOTTOM, f"mark {mark.style}")


def _cursor(across: Scale, height: int) -> Element:
    """A line that a script moves; without one it lies at the start."""
    line = _rule(0, TOP, 0, height - BOTTOM, "cursor-line")
    return element("g", line, class_="cursor", transform=f"translate({number(across.start)} 0)")


@dataclass(frozen=True)
class Box:
    """Statistics of one sample in a box plot."""

    name: str
    style: str
    values: Floats


def box_chart(
    boxes: Sequence[Box],
    title: str,
    *,
    width: int = 360,
    height: int = 220,
    stars: Sequence[tuple[int, int, str]] = (),
) -> Element:
    """Draw box plots side by side: median, quartiles, whiskers within 1.5 times the box, outliers as dots.

    `stars`: (box, box, text) comparisons, drawn as brackets above. Tukey (1977), "Exploratory Data Analysis".
    """
    values = np.concatenate([box.values[np.isfinite(box.values)] for box in boxes]) if boxes else np.zeros(0)
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
    room = 0.12 * (high - low) * len(stars)
    up = vertical(low, high + room, height)
    step = (width - LEFT - RIGHT) / max(1, len(boxes))
    centres = [LEFT + step * (k + 0.5) for k in range(len(boxes))]
    top = [_bracket(centres, first, second, text, 14 + 16 * k) for k, (first, second, text) in enumerate(stars)]
    return element(
        "svg",
        element("title", title),
        _grid(Scale(0, 1, LEFT, width - RIGHT), up, width, height, ""),
        [_box(box, x, min(46.0, 0.6 * step), up) for box, x in zip(boxes, centres, strict=True)],
        [_text(x, height - BOTTOM + 15, box.name, "middle") for box, x in zip(boxes, centres, strict=True)],
        top,
        viewBox=f"0 0 {width} {height}",
        class_="chart",
        role="img",
        xmlns="http://www.w3.org/2000/svg",
    )


def _box(box: Box, x: float, width: float, up: Scale) -> Node:
    values = box.values[np.isfinite(box.values)]
    if not len(values):
        return None
    first, middle, third = np.quantile(values, [0.25, 0.5, 0.75])
    reach = 1.5 * (third - first)
    inside = values[(values >= first - reach) & (values <= third + reach)]
    low, high = (up(float(v)) for v in (inside.min(), inside.max()))
    beyond = values[(values < first - reach) | (values > third + reach)]
    return element(
        "g",
        _rule(x, low, x, up(first), "whisker"),
        _rule(x, up(third), x, high, "whisker"),
        element(
            "rect",
            x=number(x - width / 2),
            y=number(up(third)),
            width=number(width),
            height=number(max(1.0, up(first) - up(third))),
            class_="box",
        ),
        _rule(x - width / 2, up(middle), x + width / 2, up(middle), "median"),
        [element("circle", cx=number(x), cy=number(up(v)), r=2, class_="dot") for v in beyond.tolist()],
        class_=f"boxed {box.style}",
    )


def _bracket(centres: Sequence[float], first: int, second: int, text: str, y: float) -> Element:
    a, b = centres[first], centres[second]
    path = f"M{number(a)} {number(y + 5)}V{number(y)}H{number(b)}V{number(y + 5)}"
    return element("g", element("path", d=path), _text((a + b) / 2, y - 2, text, "middle"), class_="bracket")
