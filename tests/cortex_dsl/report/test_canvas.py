"""Drawings of characters."""

import pytest

from cortex_dsl.report.blocks import KeyMoment
from cortex_dsl.report.findings.readable import shortened
from cortex_dsl.report.terminal.canvas import Canvas, Window
from cortex_dsl.report.terminal.scene_view import LIGHTS, actor_mark, moment_mark


def test_empty_rows_around_a_drawing_are_left_out() -> None:
    """Those within it stay."""
    canvas = Canvas(10, 9, Window(0.0, 0.0, 1.0))
    assert canvas.cropped() == []
    canvas.mark((0.0, 8.0), "A", "")
    canvas.mark((0.0, -4.0), "B", "")
    rows = [line.plain.strip() for line in canvas.cropped(ascii_only=True)]
    assert (rows[0], rows[-1]) == ("A", "B")
    assert rows[1:-1] == [""] * (len(rows) - 2)
    assert 2 < len(rows) < 9


@pytest.mark.parametrize(
    ("text", "room", "shown"),
    [("all of it", 9, "all of it"), ("not all of it", 9, "not all …"), ("unbreakable", 6, "unbre…"), ("word", 1, "…")],
)
def test_words_are_left_out_whole(text: str, room: int, shown: str) -> None:
    """Only a word that is too long by itself is cut."""
    assert shortened(text, room) == shown
    assert len(shown) <= max(room, 1)


def test_every_mark_of_a_drawing_is_its_own() -> None:
    """Actors, lights, contacts and closest approaches, with signs or with plain letters."""
    lights = [mark for mark, _ in LIGHTS.values()]
    moments = [
        moment_mark(KeyMoment(0, contact, (0.0, 0.0)), ascii_only=plain)
        for contact in (False, True)
        for plain in (False, True)
    ]
    marks = [*map(actor_mark, range(54)), *lights, *moments]
    assert len(set(marks)) == len(marks)
