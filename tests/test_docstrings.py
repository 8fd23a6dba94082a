"""The first words of docstrings and notes: a verb for a function, a noun for a field or constant."""

import ast
import re
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
FUNCTION_WORDS = {"Of", "Who", "Whom", "Whose", "Where", "So", "What"}
"""First words of a function's docstring that has no verb there; also after `Return`, in lower case."""
NOTE_WORDS = {
    *("Of", "Who", "Whom", "Whose", "Where", "So", "And", "Or", "But"),
    *("For", "From", "With", "Without", "By", "In", "On", "At", "To", "As", "Until", "Since", "Behind", "Beside"),
}
"""First words of a note, the string after an assignment, that has no noun there."""
OLD_NAMES = {
    *("lay_leg", "along_leg", "on_leg", "outline_on_leg", "embody", "takes_part"),
    *("note_walls", "met_up_to", "stays_off", "LOOSE", "step_loose", "write_loose"),
    *("_may_go_on", "_loosen", "settle_others", "wedged", "touch_down", "Pushed"),
    *("built_up", "Blow", "toss_coins", "look_at", "look_past", "look_around"),
    *("blame_rows", "drive_again", "Stay", "Crowd", "Stage", "lane_with"),
    *("telling", "told", "rests", "take_up", "lay_down", "begin_lanes", "Orders"),
    *("TOLD", "told_at", "told_pages", "note_decisions", "tell_decisions", "note_asked"),
    *("note_running", "Seat", "is_hopeless", "asked_patiently", "Drives", "anew"),
    *("afresh", "KeptActions", "keep_others", "keep_worst", "how_again", "kept_actions"),
    *("Kept", "Weighing", "weigh", "_weigh_attempt", "_weigh_scene", "Sought"),
    *("insist_on", "_let_go_of_the_dead", "nobody", "Making", "asks_road", "taken_for"),
    *("Superseded", "Sorted", "Spot", "Work", "Sheet", "StandIn"),
    *("_hear_stops", "Rest"),
}
"""Identifiers that standard terms of the field have replaced."""
FUNCTIONS = 0
"""Number of functions with such a docstring."""
NOTES = 0
"""Number of such notes."""


def _first_word(text: str) -> str:
    """Return the first word of a text; for `Return what ...`, the second word, capitalised."""
    evasive = re.match(r"\W*Return (what|who|whom|whose|where)\b", text)
    return evasive[1].capitalize() if evasive else re.sub(r"^\W*(\w*).*", r"\1", text, flags=re.DOTALL)


def _functions(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Yield line and docstring of each function that has a docstring."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and (text := ast.get_docstring(node)):
            yield node.lineno, text


def _notes(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Yield line and text of each note."""
    for scope in ast.walk(tree):
        for before, after in pairwise(scope.body if isinstance(scope, ast.Module | ast.ClassDef) else ()):
            match before, after:
                case ast.Assign() | ast.AnnAssign(), ast.Expr(value=ast.Constant(value=str(text))):
                    yield after.lineno, text
                case _:
                    pass


def _check(name: str, found: list[str], count: int) -> None:
    """Fail if more places are found than `count`, and ask for a lower count if fewer are."""
    assert len(found) <= count, f"{name}: {len(found)} > {count}; begin with a verb or noun:\n" + "\n".join(found)
    assert len(found) == count, f"{name}: fewer than before; set {name} to {len(found)} in the same commit"


def test_counts_of_first_words() -> None:
    """The number of texts without a verb or noun at the beginning falls, and never rises."""
    functions, notes = list[str](), list[str]()
    for path in sorted(path for package in ("cortex_dsl", "engine") for path in (ROOT / package).rglob("*.py")):
        tree, place = ast.parse(path.read_bytes()), path.relative_to(ROOT)
        functions += [f"{place}:{line}" for line, text in _functions(tree) if _first_word(text) in FUNCTION_WORDS]
        notes += [f"{place}:{line}" for line, text in _notes(tree) if _first_word(text) in NOTE_WORDS]
    _check("FUNCTIONS", functions, FUNCTIONS)
    _check("NOTES", notes, NOTES)


def _identifiers(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Yield line and name of each function, class, argument, variable and attribute."""
    for node in ast.walk(tree):
        match node:
            case ast.Name(id=name) | ast.Attribute(attr=name) | ast.arg(arg=name):
                yield node.lineno, name
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name):
                yield node.lineno, name
            case _:
                pass


def test_replaced_names_stay_away() -> None:
    """No identifier of the product has a name that a standard term has replaced."""
    paths = sorted(path for package in ("cortex_dsl", "engine") for path in (ROOT / package).rglob("*.py"))
    found = [
        f"{path.relative_to(ROOT)}:{line} {name}"
        for path in paths
        for line, name in _identifiers(ast.parse(path.read_bytes()))
        if name in OLD_NAMES
    ]
    assert found == []


@pytest.mark.parametrize(("found", "says"), [(3, "begin with a verb"), (1, "set NOTES to 1")])
def test_a_changed_count_fails(found: int, says: str) -> None:
    """A larger count names the places, a smaller one the new constant."""
    with pytest.raises(AssertionError, match=says):
        _check("NOTES", ["engine/a.py:1"] * found, 2)


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("Return the distance [m].", "Return"),
        ("What a driver\nsees.", "What"),
        ("Return what a driver sees.", "What"),
        ("(n,) True if it is valid", "n"),
        ("… and the engine's.", "and"),
        ("", ""),
    ],
)
def test_first_word(text: str, word: str) -> None:
    """The first word is found behind brackets, and behind `Return` before a relative pronoun."""
    assert _first_word(text) == word


def test_notes_are_strings_after_assignments() -> None:
    """A docstring, a second string and a string inside a function are no notes."""
    source = (
        '"""A"""\nx = 1\n"""B"""\n"""C"""\nclass D:\n    """E"""\n    y: int\n    """F"""\ndef g():\n    z = 1\n    "H"'
    )
    assert list(_notes(ast.parse(source))) == [(3, "B"), (8, "F")]
