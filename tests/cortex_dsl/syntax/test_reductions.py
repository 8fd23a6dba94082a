"""The parse loop gives the trees, the places and the errors of Lark's own loop."""

from functools import cache
from pathlib import Path
from typing import Any

from hypothesis import given
from hypothesis import strategies as st
from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedInput, UnexpectedToken

from cortex_dsl.syntax.layout import Indenter, lay_out
from cortex_dsl.syntax.reductions import Reductions
from tests.laws import examples

ROOT = Path(__file__).parents[3]
TEXTS = [
    path.read_text(encoding="utf-8", errors="replace")
    for folder in ("examples", "benchmarks", "cortex_dsl/codes")
    for path in sorted((ROOT / folder).rglob("*.scn"))
]


@cache
def parsers() -> tuple[tuple[Lark, Indenter], tuple[Lark, Indenter], Reductions]:
    """Return Lark with its own loop, Lark with ours, and our tables."""

    def made() -> tuple[Lark, Indenter]:
        indenter = Indenter()
        grammar = (ROOT / "grammar" / "cortex.lark").read_text(encoding="utf-8")
        options: dict[str, Any] = {"parser": "lalr", "lexer": "contextual", "postlex": indenter}
        return Lark(grammar, propagate_positions=True, maybe_placeholders=True, **options), indenter

    plain, ours = made(), made()
    return plain, ours, Reductions(ours[0].parse_interactive(""))


def outcome(text: str, *, fast: bool) -> Any:
    """Return the tree with its places, or the error, and what the parser has read and accepts there."""
    plain, ours, reductions = parsers()
    lark, indenter = ours if fast else plain
    indenter.begin(lay_out(text), text)
    run = lark.parse_interactive(text)
    try:
        if fast:
            reductions.exhaust(run)
        else:
            run.exhaust_lexer()
        return placed(run.feed_eof())
    except UnexpectedInput as error:
        values = [placed(value) for value in run.parser_state.value_stack]
        at = len(run.parser_state.state_stack), values, sorted(run.accepts())
        if isinstance(error, UnexpectedToken):
            return "token", error.token, error.token.start_pos, at
        return type(error).__name__, error.pos_in_stream, at


def placed(value: Any) -> Any:
    """Return a tree as nested tuples, with the places of trees and tokens."""
    if isinstance(value, Token):
        return value.type, str(value), value.start_pos, value.end_pos
    if not isinstance(value, Tree):
        return value
    meta = value.meta
    place = None if meta.empty else (meta.start_pos, meta.end_pos)
    return value.data, place, tuple(map(placed, value.children))


def test_all_files_have_the_trees_of_lark() -> None:
    assert len(TEXTS) > 100
    for text in TEXTS:
        assert outcome(text, fast=True) == outcome(text, fast=False)


@examples(60)
@given(st.sampled_from(TEXTS), st.data())
def test_damaged_texts_have_the_errors_of_lark(text: str, data: st.DataObject) -> None:
    """Texts without a piece, or with a piece of another text in its place."""
    start = data.draw(st.integers(0, len(text)))
    end = data.draw(st.integers(start, min(len(text), start + 40)))
    other = data.draw(st.sampled_from(TEXTS))
    first = data.draw(st.integers(0, len(other)))
    piece = other[first : first + data.draw(st.integers(0, 20))]
    damaged = text[:start] + piece + text[end:]
    assert outcome(damaged, fast=True) == outcome(damaged, fast=False)
