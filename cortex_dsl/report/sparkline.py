"""A curve in one line of block characters, and bars of eighths of a character."""

import math
from collections.abc import Sequence
from itertools import pairwise

LEVELS = "▁▂▃▄▅▆▇█"
EIGHTHS = " ▏▎▍▌▋▊▉█"


def sparkline(values: Sequence[float], width: int, low: float | None = None, high: float | None = None) -> str:
    """The values in `width` characters; a gap where there is none (NaN). Longer series are averaged into columns.

    `low` and `high` are the values of the lowest and the highest character, by default those of the series itself.
    """
    columns = _columns(values, width)
    finite = [v for v in columns if math.isfinite(v)]
    if not finite:
        return " " * len(columns)
    bottom = min(finite) if low is None else low
    top = max(finite) if high is None else high
    return "".join(_level(v, bottom, top) for v in columns)


def bar(value: float, full: float, width: int) -> str:
    """A bar for value / full, exact to an eighth of a character; something is shown for everything above zero."""
    share = value / full if full > 0 else 0.0
    if not math.isfinite(share) or share <= 0:
        return ""
    eighths = max(1, round(min(share, 1.0) * width * 8))
    return EIGHTHS[8] * (eighths // 8) + (EIGHTHS[eighths % 8] if eighths % 8 else "")


def _columns(values: Sequence[float], width: int) -> list[float]:
    if len(values) <= width:
        return [float(v) for v in values]
    edges = [round(i * len(values) / width) for i in range(width + 1)]
    return [_mean(values[a:b]) for a, b in pairwise(edges)]


def _mean(values: Sequence[float]) -> float:
    finite = [float(v) for v in values if math.isfinite(v)]
    return sum(finite) / len(finite) if finite else math.nan


def _level(value: float, bottom: float, top: float) -> str:
    if not math.isfinite(value):
        return " "
    half = top / 2 - bottom / 2  # halves, since a whole span may overflow
    share = (value / 2 - bottom / 2) / half if half > 0 else 0.0
    return LEVELS[max(0, min(7, int(share * 8)))]
