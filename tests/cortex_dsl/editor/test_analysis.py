"""Answers about a text: right where it is whole, and never an exception where it is not."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cortex_dsl.editor.analysis import Analysis, View, analyse
from cortex_dsl.editor.completion import complete, mended
from cortex_dsl.editor.hover import hover
from cortex_dsl.editor.navigation import definition, outline, references
from cortex_dsl.editor.open_files import Positions
from cortex_dsl.editor.place import place_of
from cortex_dsl.editor.server import cures
from cortex_dsl.semantics.evaluation.attributes import attribute_names
from cortex_dsl.semantics.model.context import Cancelled
from cortex_dsl.semantics.names.attribute_docs import ATTRIBUTE_DOCS
from cortex_dsl.semantics.names.properties import FLAGS, PROPERTIES
from cortex_dsl.source import Source, Span
from tests.laws import examples

PIECES = [
    "ego",
    "x",
    "=",
    "new Car",
    "at",
    "with speed",
    "(",
    ")",
    "[",
    ":",
    ",",
    ".",
    "5",
    "m",
    "km/h",
    "\n",
    "\n    ",
]
PIECES += ["behavior B(a):", "try:", "do", "take", "require", '"', '"""', "#", "lambda m: m.", "param P = Range(1, 2)"]
PIECES += ["import", "class C(Car):", "scenario S():", "setup:", "terminate when", "globalParameters.", "Uniform(*"]


def view_of(text, *, before=None):
    """A text in the editor; where it has no tree, with that of `before`."""
    analysis = analyse("own.scn", text)
    if analysis.module is None and before is not None:
        analysis = analyse("own.scn", before)
    return View("own.scn", text, analysis)


def ask_everything(view, offset):
    complete(view, offset)
    hover(view, offset)
    definition(view, offset)
    references(view, offset)
    outline(view)


@examples(60)
@given(st.lists(st.sampled_from(PIECES), max_size=25).map(" ".join), st.floats(0, 1))
def test_no_text_is_too_broken_to_ask_about(text, where):
    analysis = analyse("own.scn", text)
    view = View("own.scn", text, analysis)
    ask_everything(view, int(where * len(text)))
    list(cures(analysis.source, analysis.diagnostics, Span(0, len(text))))


def test_every_beginning_of_a_file_can_be_asked_about(left_turn):
    """What is typed from its first to its last line, with the tree of the last good text."""
    good = analyse("own.scn", left_turn)
    for end in range(0, len(left_turn), 37):
        ask_everything(View("own.scn", left_turn[:end], good), end)


@pytest.mark.parametrize(
    ("argument", "said"), [("friction", "Factor on everybody's grip"), ("sight", "a length"), ("light", "0 to 1")]
)
def test_arguments_of_the_environment_are_no_properties(argument, said):
    view = view_of("environment(friction=0.4, sight=60 m, light=0.5)\nego = new Car on road, with friction 0.7\n")
    found = hover(view, view.text.index(argument))
    assert found is not None
    assert f"environment({argument}=…)" in found.text
    assert said in found.text
    other = hover(view, view.text.rindex("friction"))
    assert other is not None
    assert "with friction" in other.text


def test_values_are_known_although_the_file_has_errors(left_turn):
    view = view_of(left_turn.replace("with speed EGO_SPEED", "with sped EGO_SPEED"))
    assert [d.code for d in view.analysis.diagnostics if d.severity.value == "error"] == ["SCN204"]
    found = hover(view, view.text.index("egoInitLane.centerline"))
    assert found is not None
    assert "a lane, such as `north.in.1`" in found.text


def test_a_newer_text_stops_the_compilation(left_turn):
    with pytest.raises(Cancelled):
        analyse("own.scn", left_turn, lambda: True)


def test_imports_can_come_from_anywhere():
    """Open files need not be saved."""

    class Shelf:
        def find(self, importer, paths):
            return paths[0]

        def read(self, name):
            return Source(name, "slow = 3 m/s\n")

        def identity(self, name):
            return name

        def beside(self, importer, path):
            return []

    analysis = analyse("own.scn", "from cars import slow\nx = slow\n", files=Shelf())
    target = definition(View("own.scn", "from cars import slow\nx = slow\n", analysis), 26)
    assert target is not None
    assert (target.file, target.text[target.span.start : target.span.end]) == ("cars.scn", "slow")


@pytest.mark.parametrize(
    ("broken", "whole"),
    [
        ("x = ego.|", "x = ego"),
        ("x = f(ego.|)", "x = f(ego)"),
        ("x = [f(ego.sp|, 3)]", "x = [f(ego)]"),
        ("if self.|:\n    wait", "if self:\n    wait"),
        ("new Car at p.|,\n  with speed 3", "new Car at p,\n  with speed 3"),
    ],
)
def test_a_text_is_mended_before_its_dot(broken, whole):
    offset, text = broken.index("|"), broken.replace("|", "")
    view = View("own.scn", text, Analysis(Source("own.scn", "")))
    place = place_of(view, offset)
    assert place is not None
    assert mended(view, place, place.left[-1].start) == whole


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("terminate ", {"when", "after", "simulation", "simulation when"}),
        ("x = a offset ", {"by", "along"}),
        ("require (distance ", {"from", "to", "past"}),
        ("require (ego can ", {"see"}),
        ("param ", set()),
        ("behavior ", set()),
    ],
)
def test_phrases_are_completed(line, words):
    assert {each.label for each in complete(view_of(line), len(line))} == words


def test_a_property_is_offered_once():
    text = "x = new Car at p, with speed 3, with "
    assert "speed" not in {each.label for each in complete(view_of(text), len(text))}


def test_inner_names_hide_outer_ones():
    text = "m = 3 m\nxs = [1, 2]\ny = [m for m in xs]\nz = m\nbehavior B(z):\n    do z\n"
    view = view_of(text)

    def line_of(offset):
        target = definition(view, offset)
        assert target is not None
        return text.count("\n", 0, target.span.start)

    assert line_of(text.index("[m for") + 1) == 2
    assert line_of(text.index("z = m") + 4) == 0
    assert line_of(text.index("do z") + 3) == 4
    assert len(references(view, 0)) == 2


def test_every_attribute_has_a_sentence():
    assert attribute_names() <= {*ATTRIBUTE_DOCS, *PROPERTIES, *FLAGS}


@given(st.text(alphabet="a\n\r\N{AUTOMOBILE}ß\t", max_size=40), st.sampled_from(["utf-8", "utf-16", "utf-32"]))
def test_positions_and_offsets_are_inverse(text, encoding):
    positions = Positions(text, encoding)
    for offset in range(len(text) + 1):
        if text[offset - 1 : offset + 1] != "\r\n":
            assert positions.offset(*positions.position(offset)) == offset


def test_positions_beyond_the_text_are_at_its_end():
    positions = Positions("ab\ncd")
    assert [positions.offset(0, 99), positions.offset(99, 0)] == [2, 5]
