"""A text as the lexer sees it, with offsets: what stands at a place, also where the text is broken."""

import re
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

from pygments.token import Comment, Keyword, Name, Operator, String, Whitespace, _TokenType

from cortex_dsl.editor.lexer import ScnLexer
from cortex_dsl.source import Span

_WORD = re.compile(r"[^\W\d]\w*")
_LEXER = ScnLexer()


@dataclass(frozen=True)
class Token:
    kind: _TokenType
    text: str
    start: int

    @property
    def end(self) -> int:
        return self.start + len(self.text)

    @property
    def span(self) -> Span:
        return Span(self.start, self.end)

    @property
    def is_name(self) -> bool:
        return self.kind in Name and _WORD.fullmatch(self.text) is not None

    @property
    def is_keyword(self) -> bool:
        return (self.kind in Keyword or self.kind is Operator.Word) and not self.is_unit

    @property
    def is_unit(self) -> bool:
        return self.kind is Keyword.Type

    @property
    def is_text(self) -> bool:
        return self.kind in Comment or self.kind in String


def tokens_of(text: str) -> tuple[Token, ...]:
    """Everything but blanks."""
    found = _LEXER.get_tokens_unprocessed(text)
    return tuple(Token(kind, value, start) for start, kind, value in found if kind is not Whitespace and value.strip())


def index_at(tokens: Sequence[Token], offset: int) -> int:
    """Index of the token that an offset lies in or at the end of, the right one first; -1 if it lies in none."""
    index = bisect_right(tokens, offset, key=lambda token: token.start) - 1
    if index >= 0 and offset < tokens[index].end:
        token = tokens[index]
        before = tokens[index - 1] if index else None
        ends_word = before is not None and before.end == offset and before.text[-1:].isalnum()
        return index - 1 if ends_word and offset == token.start and not token.text[0].isalnum() else index
    return index if index >= 0 and offset == tokens[index].end else -1


def word_before(text: str, offset: int) -> str:
    """The part of a word that ends at an offset."""
    found = re.search(r"\w*\Z", text[:offset])
    return found.group() if found else ""
