"""The lexer that compiles each terminal once reads what Lark's own reads."""

from pathlib import Path

import pytest
from lark import Lark, Token
from lark.exceptions import UnexpectedInput

from cortex_dsl.resources import resource
from cortex_dsl.syntax.layout import Indenter, lay_out
from cortex_dsl.syntax.terminals import TerminalLexer, first_of

ROOT = Path(__file__).parents[3]
BAD = ROOT.glob("tests/**/mistakes/*.scn")
TEXTS = sorted([*ROOT.glob("examples/*.scn"), *ROOT.glob("tests/agreement/*.scn"), *BAD])


@pytest.fixture(scope="module")
def parsers() -> list[tuple[Lark, Indenter]]:
    """Lark's own lexer, then ours."""
    grammar = resource("grammar/cortex.lark").read_text(encoding="utf-8")
    made = []
    for plugins in ({}, {"ContextualLexer": TerminalLexer}):
        indenter = Indenter()
        lark = Lark(grammar, parser="lalr", lexer="contextual", postlex=indenter, _plugins=plugins)
        made.append((lark, indenter))
    return made


def read(lark: Lark, indenter: Indenter, text: str) -> list[object]:
    """Tokens with their places, up to the first that cannot be read."""
    indenter.begin(lay_out(text), text)
    seen: list[object] = []
    try:
        for token in lark.parse_interactive(text).iter_parse():
            seen += [told(token)]
    except UnexpectedInput as error:
        seen += [type(error).__name__, error.pos_in_stream, error.line, error.column]
    return seen


def told(token: Token) -> tuple[object, ...]:
    return token.type, str(token), token.start_pos, token.line, token.column, token.end_line, token.end_column


@pytest.mark.parametrize("path", TEXTS, ids=lambda path: path.stem)
def test_reads_what_lark_reads(parsers: list[tuple[Lark, Indenter]], path: Path) -> None:
    """The same tokens at the same places, good files and bad."""
    text = path.read_bytes().decode("utf-8", errors="replace")
    theirs, ours = (read(*parser, text) for parser in parsers)
    assert ours == theirs
    assert ours


@pytest.mark.parametrize(
    ("regex", "first"),
    [
        (r"in\b", "i"),
        (r"is[ \t]+not\b", "i"),
        (r"map(?=[ \t]+(?:a|b))", "m"),
        (r"ab|cd", None),
        (r"a[(]|b", None),
        (r"a\(|b", None),
        (r"a*b", None),
        (r"(?:ab|ac)", None),
        (r"[^\W\d]\w*", None),
        (r"\d+", None),
    ],
)
def test_first_letter_is_certain(regex: str, first: str | None) -> None:
    """A terminal is passed over by its first letter only where every match has it."""
    assert first_of(regex) == first
