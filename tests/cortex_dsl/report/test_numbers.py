"""Numbers, curves, drawings: the small pieces of every view."""

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cortex_dsl.report.documents import document
from cortex_dsl.report.findings.readable import (
    column_decimals,
    counted,
    duration,
    fixed,
    percent,
    short_names,
    significant,
)
from cortex_dsl.report.terminal.canvas import Canvas, Window
from cortex_dsl.report.terminal.theme import bar, sparkline
from engine.streams import StreamKey
from engine.strict_json import plain
from engine.vocabulary import Verdict


@pytest.mark.parametrize(
    ("value", "decimals", "text"),
    [(1234.5, 1, "1,234.5"), (-0.001, 2, "0.00"), (-1.5, 1, "-1.5"), (math.nan, 2, "–"), (math.inf, 1, "∞")],
)
def test_fixed(value: float, decimals: int, text: str) -> None:
    """Thousands stand apart, zero has no sign, what does not exist is a dash."""
    assert fixed(value, decimals) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (5.0, "5"), (0.12345, "0.1235"), (80.0, "80"), (100000.0, "100000"), (1e9, "1.000e+09")],
)
def test_significant(value: float, text: str) -> None:
    """Four digits, no idle zeros."""
    assert significant(value) == text


@pytest.mark.parametrize(("low", "high", "decimals"), [(5, 80, 2), (0, 1, 3), (0, 10000, 0), (2, 2, 2)])
def test_column_decimals(low: float, high: float, decimals: int) -> None:
    """About three digits over the range."""
    assert column_decimals(low, high) == decimals


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.84, "0.8 s"), (42, "42 s"), (59.9, "1 min 00 s"), (185, "3 min 05 s"), (7800, "2 h 10 min")],
)
def test_duration(seconds: float, text: str) -> None:
    """The unit follows the size, and rounding never yields 60."""
    assert duration(seconds) == text


def test_counts() -> None:
    """One is singular."""
    assert (counted(1, "scene"), counted(2, "scene"), counted(1000, "scene")) == ("1 scene", "2 scenes", "1,000 scenes")
    assert percent(0.2571) == "25.7 %"


@given(st.lists(st.floats(allow_nan=True, allow_infinity=True), max_size=300), st.integers(1, 60))
def test_sparkline_has_its_width(values: list[float], width: int) -> None:
    """At most `width` characters, one a value where there are fewer, whatever the values."""
    assert len(sparkline(values, width)) == min(len(values), width)


def test_sparkline_follows_the_values() -> None:
    """Lowest, middle, highest, and a gap."""
    assert sparkline([0, 1, math.nan, 2], 10) == "▁▅ █"


def test_a_flat_sparkline_lies_low_or_as_high_as_it_is() -> None:
    """Nothing at all is drawn as nothing; from zero up, a constant is full height."""
    assert sparkline([0, 0], 10, low=0.0) == "▁▁"
    assert sparkline([5, 5], 10, low=0.0) == "██"


@given(st.floats(0, 1), st.integers(1, 40))
def test_bar_never_overflows(share: float, width: int) -> None:
    """A bar is as long as its share, and never empty for more than nothing."""
    text = bar(share, 1.0, width)
    assert len(text) <= width
    assert bool(text) == (share > 0)


def test_canvas_draws_at_the_given_place() -> None:
    """A line along the middle row, north up, and a mark over it."""
    canvas = Canvas(10, 5, Window(0.0, 0.0, 1.0))
    canvas.line([(-9.5, 0.5), (9.5, 0.5)], "road")
    canvas.mark((0.0, 9.0), "N", "title")
    rows = [text.plain for text in canvas.lines()]
    assert rows[0].strip() == "N"
    assert [bool(row.strip()) for row in rows] == [True, False, True, False, False]
    assert all(len(row) == 10 for row in rows)


@given(st.lists(st.tuples(st.floats(-1e4, 1e4), st.floats(-1e4, 1e4)), min_size=2, max_size=6), st.integers(1, 3))
def test_canvas_shows_only_what_is_visible(points: list[tuple[float, float]], on: int) -> None:
    """Lines may leave the drawing; nothing outside is kept."""
    canvas = Canvas(8, 4, Window(0.0, 0.0, 0.1))
    canvas.line(points, "road", on=on, off=1)
    assert all(0 <= row < 4 and 0 <= column < 8 for row, column in canvas.dots)


def test_documents_are_json_whatever_is_in_them() -> None:
    """Arrays, enumerations, keys and numbers that do not exist become what JSON can hold."""
    key = StreamKey(1, 2, 3, 4, 5, 6)
    text = document(
        "run", {"a": np.array([1.0, np.nan]), "v": Verdict.EXHAUSTED, "k": key, "n": np.int64(3), "i": math.inf}
    )
    value = json.loads(text)
    assert value["schema"] == "cortexc/run"
    assert value["schema_version"] == 1
    assert (value["a"], value["v"], value["k"]["rollout"], value["n"], value["i"]) == (
        [1.0, None],
        "exhausted",
        6,
        3,
        None,
    )


@given(
    st.recursive(
        st.floats() | st.integers() | st.text(), lambda inner: st.lists(inner) | st.tuples(inner), max_leaves=9
    )
)
def test_plain_never_leaves_anything_behind(value: object) -> None:
    """Whatever is given can be written as strict JSON."""
    json.dumps(plain(value), allow_nan=False)


@given(st.sets(st.text("ab_1", min_size=1, max_size=30), min_size=1, max_size=12), st.integers(3, 12))
def test_short_names_stay_different(names: set[str], room: int) -> None:
    """Whatever the middle of a long name is; a name that fits stays as it is."""
    every = sorted(names)
    short = short_names(every, room)
    assert len(set(short)) == len(every)
    assert all(new == name for name, new in zip(every, short, strict=True) if len(name) <= room)
