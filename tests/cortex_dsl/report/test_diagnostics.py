"""The renderer of diagnostics: places, marks, width, colour, data."""

import io
import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.cells import cell_len
from rich.console import Console

from cortex_dsl.diagnostics import Diagnostic, Label, Severity
from cortex_dsl.report.findings.snippet import as_json, render_text
from cortex_dsl.report.terminal.diagnostics_view import print_diagnostics
from cortex_dsl.source import Source, Span

TEXT = "first = 1\n\tsecond = größe(文字, 2)\nthird = [\n    4,\n    5,\n]\nlast = 6"


def spot(word: str, text: str = "", end: str = "") -> Label:
    start = TEXT.index(word)
    return Label(Span(start, TEXT.index(end) + len(end) if end else start + len(word)), text)


def drawn(label: Label, *secondary: Label, width: int = 80, **more: Any) -> list[str]:
    diagnostic = Diagnostic("SCN999", "wrong", label, secondary=secondary, **more)
    return render_text(Source("a.scn", TEXT), [diagnostic], width).splitlines()


def test_headline_marks_reason_and_cure() -> None:
    """One line says where and what; below stand the source, the marks, the reason and the cure."""
    assert drawn(spot("first", "here"), reason="because", cure="do so") == [
        "a.scn:1:1: error[SCN999]: wrong",
        "  |",
        "1 | first = 1",
        "  | ^^^^^ here",
        "  |",
        "  = because",
        "  = help: do so",
    ]


def test_tabs_and_wide_characters_keep_marks_below_their_text() -> None:
    """A tab is four cells, an ideograph two."""
    lines = drawn(spot("文字", "ideographs"), spot("2", "number"))
    assert lines[2] == "2 |     second = größe(文字, 2)"
    assert lines[3] == "  |                    ^^^^  - number"
    assert lines[4] == "  |                    |"
    assert lines[5] == "  |                    ideographs"


def test_a_span_over_lines_marks_its_first_and_last() -> None:
    """The lines between are left out."""
    assert drawn(spot("[", "a list", end="]"))[2:] == [
        "3 | third = [",
        "  |         ^",
        "...",
        "6 | ]",
        "  | ^ a list",
    ]


def test_labels_far_apart_are_parted_by_dots() -> None:
    """A secondary label shows its own line."""
    lines = drawn(spot("last", "again"), spot("first", "before"))
    assert lines[2:] == ["1 | first = 1", "  | ----- before", "...", "7 | last = 6", "  | ^^^^ again"]


def test_an_empty_span_is_one_caret_even_past_the_end() -> None:
    """What is missing is shown where it should stand."""
    end = len(TEXT)
    assert drawn(Label(Span(end, end), "missing"))[2:] == ["7 | last = 6", "  |         ^ missing"]


def test_a_long_line_is_cropped_around_its_mark() -> None:
    """The mark stays visible, and nothing is wider than the terminal."""
    text = "x = " + "a + " * 200 + "wrong" + " + b" * 200
    start = text.index("wrong")
    diagnostic = Diagnostic("SCN999", "wrong", Label(Span(start, start + 5), "here"))
    lines = render_text(Source("a.scn", text), [diagnostic], 60).splitlines()
    assert max(map(len, lines)) <= 60
    assert lines[2].startswith("1 | …")
    assert lines[2].endswith("…")
    assert lines[2][lines[3].index("^") :].startswith("wrong")


def test_control_characters_never_reach_the_terminal() -> None:
    """Neither from the source, nor from a message, nor from the name of the file."""
    diagnostic = Diagnostic("SCN999", "\x1b[2J", Label(Span(0, 1), "\x07"), reason="\x1b", cure="\u202e")
    text = render_text(Source("\x1b.scn", "x = \x1b[31m \u202e"), [diagnostic])
    assert all(character == "\n" or character.isprintable() for character in text)


def test_colour_changes_no_character() -> None:
    """What is printed in colour reads as what is printed without."""
    diagnostics = [
        Diagnostic("SCN999", "wrong [bold]", spot("first", "here"), severity, (spot("1", "one"),), "why", "how")
        for severity in Severity
    ]
    source = Source("a.scn", TEXT)
    plain, coloured = io.StringIO(), io.StringIO()
    print_diagnostics(source, diagnostics, Console(file=plain, width=80, color_system=None))
    print_diagnostics(
        source, diagnostics, Console(file=coloured, width=80, force_terminal=True, color_system="standard")
    )
    assert plain.getvalue().replace(" \n", "\n") == render_text(source, diagnostics, 80)
    assert "\x1b[" in coloured.getvalue()
    assert "warning[SCN999]" in plain.getvalue()


def test_as_json() -> None:
    """Lines and columns count from 1, and everything survives the way through a document."""
    diagnostic = Diagnostic("SCN999", "wrong", spot("second", "here"), Severity.WARNING, (spot("first"),), "why", "how")
    (found,) = json.loads(json.dumps(as_json(Source("a.scn", TEXT), [diagnostic])))
    assert found["code"] == "SCN999"
    assert found["severity"] == "warning"
    assert found["start"] == {"line": 2, "column": 2, "offset": 11}
    assert found["end"] == {"line": 2, "column": 8, "offset": 17}
    assert found["secondary"][0]["start"]["line"] == 1
    assert (found["label"], found["reason"], found["cure"]) == ("here", "why", "how")


@pytest.mark.parametrize("width", [1, 40])
def test_no_width_is_too_small(width: int) -> None:
    """A narrow terminal gets something, not an error."""
    assert drawn(spot("first", "a long text that cannot fit here at all"), width=width)


spans = st.builds(lambda start, length: Span(start, start + length), st.integers(-2, 24), st.integers(0, 12))
texts = st.text("ab \t\n\r文é\u0301\u200b\x00😀", max_size=20)


@given(texts, st.lists(spans, min_size=1, max_size=3), st.integers(1, 60))
def test_any_place_in_any_text_can_be_drawn(text: str, places: list[Span], width: int) -> None:
    """Spans may lie anywhere, overlap, and be empty."""
    first, *rest = (Label(span, "label") for span in places)
    lines = render_text(Source("a", text), [Diagnostic("SCN999", "wrong", first, secondary=tuple(rest))], width)
    assert lines.startswith("a:")
    assert all(cell_len(line) <= max(width, 60) for line in lines.splitlines()[1:])


def test_thousands_are_not_drawn() -> None:
    """Errors come before the rest, and what is left out is counted."""
    kinds = [Severity.HINT] * 4_000 + [Severity.ERROR] * 70
    found = [Diagnostic("SCN999", "wrong", spot("first"), severity=severity) for severity in kinds]
    stream = io.StringIO()
    print_diagnostics(Source("a.scn", TEXT), found, Console(file=stream, width=80))
    text = stream.getvalue()
    assert (text.count("error["), text.count("hint[")) == (70, 30)
    assert "and 3,970 more" in text


def test_a_long_headline_is_one_line_for_programs_and_broken_at_words_for_people() -> None:
    """What reads `file:line:column` from a pipe needs the whole; a terminal would cut words."""
    source = Source("a.scn", "ego = new Car\n")
    diagnostics = [Diagnostic("SCN999", "word " * 30 + "end", Label(Span(0, 3)))]
    shown = {}
    for terminal in (False, True):
        out = io.StringIO()
        print_diagnostics(source, diagnostics, Console(file=out, width=60, force_terminal=terminal, color_system=None))
        shown[terminal] = out.getvalue().splitlines()
    assert shown[False][0].endswith("word end")
    assert max(map(len, shown[True])) <= 60
    assert " ".join(shown[True]).split() == " ".join(shown[False]).split()
