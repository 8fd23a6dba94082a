"""The lexer loses no character, knows every keyword of the grammar, and finds nothing wrong with a right file."""

import re
from importlib.metadata import entry_points
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pygments.token import Comment, Error, Keyword, Name, Number, Operator, String

from cortex_dsl.editor.lexer import ScnLexer
from cortex_dsl.semantics.names.builtins import BUILTINS, Kind
from cortex_dsl.syntax.literals import UNIT_WORDS
from cortex_dsl.syntax.words import KEYWORDS, RESERVED, Role

ROOT = Path(__file__).parents[3]
EXAMPLES = sorted((ROOT / "examples").glob("*.scn"))
FOREIGN = {"False", "None", "True", "assert", "async", "await", "def", "del", "except", "finally", "global", "nonlocal"}
FOREIGN |= {"raise", "yield"}
"""Reserved words that are no keywords of ours."""
GENERATED = st.lists(
    st.sampled_from([*(k.phrase for k in KEYWORDS), *BUILTINS, *UNIT_WORDS, "x", "3", "4.5", '"', "'''", '"""'])
    | st.sampled_from([*"()[]{}:;,.=<>+-*/%@#\\\n\t ", "\r\n", "lambda x:", "$", "µ", "\N{BYTE ORDER MARK}"])
    | st.text(max_size=3)
).map(" ".join)


def lexed(text):
    return [(token, value) for _, token, value in ScnLexer().get_tokens_unprocessed(text)]


def words(text):
    """Kind of each word that is no blank."""
    return [(value, token) for token, value in lexed(text) if value.strip()]


@given(GENERATED)
def test_no_character_is_lost(text):
    assert "".join(value for _, value in lexed(text)) == text


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_the_examples_hold_no_errors(path):
    assert [value for token, value in lexed(path.read_text()) if token in Error] == []


@pytest.mark.parametrize("keyword", KEYWORDS, ids=lambda k: f"{k.role.value}-{k.phrase}")
def test_every_construct_begins_with_a_keyword(keyword):
    """Its form, put where it belongs, holds its phrase as a keyword."""
    before = "" if keyword.role in (Role.STATEMENT, Role.ACT, Role.CLAUSE) else "x = y, "
    found = [value for value, token in words(before + keyword.form) if token in Keyword or token in Operator]
    assert set(keyword.words) <= set(" ".join(found).split())


def test_every_keyword_of_the_grammar_is_one_here():
    """Words of the terminals that begin with an underscore or name a word operator."""
    grammar = (ROOT / "grammar" / "cortex.lark").read_text()
    section = grammar[grammar.index("// Never names") : grammar.index("// -- numbers, units, text")]
    terminals = re.findall(r"^_?[A-Z_]+(?:\.\d+)?: /(.*)/$", section, re.MULTILINE)
    plain = [re.sub(r"\(\?[!=].*", "", t).replace(r"[ \t]+", " ").replace(r"\b", " ") for t in terminals]
    found = {word for pattern in plain for word in re.findall(r"\b[a-z]{2,}", pattern)}
    known = {word for keyword in KEYWORDS for word in keyword.words}
    assert len(found) > 50
    assert found - known <= RESERVED


def test_every_reserved_word_of_ours_is_explained():
    assert {word for keyword in KEYWORDS for word in keyword.words} >= RESERVED - FOREIGN


@pytest.mark.parametrize("unit", UNIT_WORDS)
@pytest.mark.parametrize("value", ["3", "Range(1, 2)"])
def test_a_unit_is_one_after_a_number_or_a_call(unit, value):
    assert (unit, Keyword.Type) in words(f"x = {value} {unit}")


def test_words_of_position_stay_names():
    for line in ("record = 3", "map.x = 1", "take, wait = 1, 2", "steps = 4", "x = next + before"):
        assert not [v for v, token in words(line) if token in Keyword or token in Operator.Word]
    assert ("min", Name.Builtin) in words("x = min(3, 4)")
    assert ("m", Name) in words("x = m")


def test_builtins_are_coloured_by_kind():
    for builtin in BUILTINS.values():
        (token,) = {token for value, token in words(f"x = {builtin.name}") if value == builtin.name}
        assert token in (Name.Class if builtin.kind is Kind.CLASS else Name)
        assert token is not Name


def test_the_complete_language():
    tokens = dict(words('class Taxi(Car):\n    """A taxi."""\n    speed: Range(3, 9) m/s  # slow\n'))
    assert tokens["class"] in Keyword
    assert tokens["Taxi"] is Name.Class
    assert tokens['"""A taxi."""'] is String.Doc
    assert tokens["speed"] is Name.Attribute
    assert tokens["9"] is Number
    assert tokens["# slow"] is Comment.Single


def test_pygments_finds_it():
    assert "cortex_dsl.editor.lexer:ScnLexer" in {e.value for e in entry_points(group="pygments.lexers")}
