"""`format_copy`: `format_source` for copies of one scenario; only the first copy is parsed.

Copies differ in numbers, in short texts (the address of a stream) and in comments. None of these changes the kinds of
the tokens, except for the sign of a number, which is left out of the parsed text. So the tokens of the first copy,
moved to their places in another copy, are the tokens of that copy. The layout itself is made anew for each copy: a line
that becomes too long is wrapped as usual.
"""

import re
from bisect import bisect_right
from contextlib import suppress
from dataclasses import dataclass, field
from functools import lru_cache
from math import isfinite
from typing import TypeAlias

from lark import Token

from cortex_dsl.source import Source
from cortex_dsl.syntax import parse
from cortex_dsl.syntax.formatting import format_tokens
from cortex_dsl.syntax.parser import read_tokens

_LITERAL = re.compile(
    r"""(?P<comment>\#[^\n]*)
    |(?<!\w)(?P<text>"(?!"")[^"\\{}\n]*"|'(?!'')[^'\\{}\n]*')
    |\"{3}(?:[^\\]|\\[\s\S])*?\"{3}|'{3}(?:[^\\]|\\[\s\S])*?'{3}
    |"(?:[^"\\\n]|\\\r?\n|\\[^\n])*"|'(?:[^'\\\n]|\\\r?\n|\\[^\n])*'
    |(?:(?<=[(,=])|(?<=[,=][ ])|(?<=\bfacing[ ]))(?P<sign>-)(?=[\d.])
    |(?<![\w.])(?P<number>(?:\d[\d_]*\.?[\d_]*|\.\d[\d_]*)(?:[eE][-+]?\d+)?)""",
    re.VERBOSE,
)
"""Variable parts of a text, by name; the other patterns match texts in which a `#` or a digit is none. A minus is a
sign if no value ends before it."""
_Place: TypeAlias = tuple[int, int]
"""A part of a text, and an offset in it."""


def format_copy(source: Source) -> str:
    """Return the text of a copy in the one layout; parse it unless a text of the same shape was parsed.

    Raises:
        CompileError: the first copy of this shape does not parse.
    """
    return format_tokens(source, _read)


@dataclass(frozen=True)
class _Shape:
    """A text without signs, in parts between which its literals stand."""

    kinds: tuple[str, ...]
    """Kind of each literal."""
    parts: tuple[str, ...]
    """One more than literals."""
    text: str = field(compare=False)
    starts: tuple[int, ...] = field(compare=False)
    """Offset of each part in that text."""


def _read(source: Source) -> list[Token]:
    signs, bare = _without_signs(source.text)
    shape = _shape(bare)
    places = _places(shape)
    if places is None:
        return read_tokens(source)
    tokens: list[Token] = []
    passed = 0
    for kind, first, last in places:
        start, end = (shape.starts[part] + offset for part, offset in (first, last))
        if passed < len(signs) and start == signs[passed]:
            tokens.append(_token("MINUS", "-", start + passed))
            passed += 1
        tokens.append(_token(kind, bare[start:end], start + passed))
    return tokens


def _token(kind: str, text: str, start: int) -> Token:
    return Token(kind, text, start, 1, 1, 1, 1, start + len(text))


def _without_signs(text: str) -> tuple[list[int], str]:
    """Return the offset of each signed number in the text without signs, and that text."""
    found = [match.start() for match in _LITERAL.finditer(text) if match.lastgroup == "sign"]
    bare = _LITERAL.sub(lambda match: "" if match.lastgroup == "sign" else match.group(), text)
    return [place - number for number, place in enumerate(found)], bare


def _shape(text: str) -> _Shape:
    found = [match for match in _LITERAL.finditer(text) if match.lastgroup]
    starts = (0, *(match.end() for match in found))
    stops = (*(match.start() for match in found), len(text))
    parts = tuple(text[start:stop] for start, stop in zip(starts, stops, strict=True))
    return _Shape(tuple(map(_kind, found)), parts, text, starts)


def _kind(literal: re.Match[str]) -> str:
    """Name of the kind of a literal, or its own text where it may be a number that the parser refuses."""
    kind = literal.lastgroup or ""
    if kind == "number":
        with suppress(ValueError):
            return kind if isfinite(float(literal.group())) else literal.group()
        return literal.group()
    return kind


@lru_cache(maxsize=64)
def _places(shape: _Shape) -> tuple[tuple[str, _Place, _Place], ...] | None:
    """Kind, start and end of each token, the same in all texts of this shape; None if a token ends within a literal.

    Raises:
        CompileError: the text does not parse.
    """
    source = Source("copy", shape.text)
    parse(source)
    places: list[tuple[str, _Place, _Place]] = []
    for token in read_tokens(source):
        start, end = token.start_pos or 0, token.end_pos or 0
        first, last = _place(shape, start), _place(shape, end)
        if first is None or last is None or shape.text[start:end] != token:
            return None
        places.append((token.type, first, last))
    return tuple(places)


def _place(shape: _Shape, offset: int) -> _Place | None:
    part = bisect_right(shape.starts, offset) - 1
    within = offset - shape.starts[part]
    return (part, within) if within <= len(shape.parts[part]) else None
