"""`format_copy`: `format_source` for the copies of one scenario, of which only the first is parsed.

Copies differ in numbers, in short texts (the address of a stream) and in comments. None of these changes the kinds of
the tokens, so the tokens of the first copy, moved to their places in another one, are those of the other one. A line
that gets too long is wrapped as always: the layout itself is made anew for each copy.
"""

import re
from bisect import bisect_right
from contextlib import suppress
from dataclasses import dataclass, field
from functools import lru_cache
from math import isfinite

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
    |(?<![\w.])(?P<number>(?:\d[\d_]*\.?[\d_]*|\.\d[\d_]*)(?:[eE][-+]?\d+)?)""",
    re.VERBOSE,
)
"""What may differ has a name; the other texts are matched because a `#` or a digit in them is none."""


def format_copy(source: Source) -> str:
    """Return the text of a copy in the one layout. It is parsed unless one of the same shape was.

    Raises:
        CompileError: the first copy of this shape does not parse.
    """
    return format_tokens(source, _read)


@dataclass(frozen=True)
class _Shape:
    """A text in parts, between which its literals stand."""

    kinds: tuple[str, ...]
    """Kind of each literal."""
    parts: tuple[str, ...]
    """One more than literals."""
    source: Source = field(compare=False)
    starts: tuple[int, ...] = field(compare=False)
    """Offset of each part."""


@dataclass(frozen=True)
class _Place:
    """Offset of an end of a token: from the beginning of a part."""

    part: int
    offset: int


def _shape(source: Source) -> _Shape:
    found = [match for match in _LITERAL.finditer(source.text) if match.lastgroup]
    starts = (0, *(match.end() for match in found))
    stops = (*(match.start() for match in found), len(source.text))
    parts = tuple(source.text[start:stop] for start, stop in zip(starts, stops, strict=True))
    return _Shape(tuple(map(_kind, found)), parts, source, starts)


def _kind(literal: re.Match[str]) -> str:
    """Name of the kind of a literal, or its own text where it may be a number that the parser refuses."""
    kind = literal.lastgroup or ""
    if kind == "number":
        with suppress(ValueError):
            return kind if isfinite(float(literal.group())) else literal.group()
        return literal.group()
    return kind


def _read(source: Source) -> list[Token]:
    shape = _shape(source)
    places = _places(shape)
    if places is None:
        return read_tokens(source)
    spans = ((kind, *(shape.starts[end.part] + end.offset for end in ends)) for kind, *ends in places)
    return [Token(kind, source.text[start:end], start, 1, 1, 1, 1, end) for kind, start, end in spans]


@lru_cache(maxsize=64)
def _places(shape: _Shape) -> tuple[tuple[str, _Place, _Place], ...] | None:
    """Kind and place of each token, the same in all texts of this shape; None if a token ends within a literal.

    Raises:
        CompileError: the text does not parse.
    """
    parse(shape.source)
    places: list[tuple[str, _Place, _Place]] = []
    for token in read_tokens(shape.source):
        start, end = token.start_pos or 0, token.end_pos or 0
        first, last = _place(shape, start), _place(shape, end)
        if first is None or last is None or shape.source.text[start:end] != token:
            return None
        places.append((token.type, first, last))
    return tuple(places)


def _place(shape: _Shape, offset: int) -> _Place | None:
    part = bisect_right(shape.starts, offset) - 1
    within = offset - shape.starts[part]
    return _Place(part, within) if within <= len(shape.parts[part]) else None
