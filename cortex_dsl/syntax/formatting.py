"""One layout for every file: `format_source`. Comments and the spelling of numbers, units and strings are unchanged.

`pieces` sets spaces; this module sets line breaks and the layout between lines and over several lines. At most
two blank lines follow each other, none follows a line that opens a block, and definitions have one around them. The `=`
of params on consecutive lines are aligned; those of assignments too, if the author aligned one of them.
"""

import re
from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import dropwhile
from math import isfinite
from typing import TYPE_CHECKING, TypeAlias

from lark import Token

from cortex_dsl.source import Source
from cortex_dsl.syntax import parse
from cortex_dsl.syntax.layout import TAB_WIDTH
from cortex_dsl.syntax.parser import read_tokens
from cortex_dsl.syntax.pieces import Comment, Group, Node, Piece, comments_in, leading, nodes_of, tidy

if TYPE_CHECKING:
    from lark import Token


# -- ends of lines in a statement --------------------------------------------------------------------------------------


WIDTH = 120
STEP = 4
_JOINTS = {"_AND", "_OR", "_FOR", "_IF", "_ELSE"}


def flat(nodes: Sequence[Node]) -> str:
    """Text of nodes on one line."""
    return "".join(_flat(node, first=number == 0) for number, node in enumerate(nodes))


def _flat(node: Node, first: bool) -> str:
    lead = leading(node)
    space = "" if first else " " * (lead.space + lead.pad)
    if isinstance(node, Piece):
        return space + node.text
    return space + node.open.text + flat(_content(node)) + node.close.text


def _content(group: Group) -> Sequence[Node]:
    """The nodes of a group without a comma at its end that changes nothing."""
    commas = sum(isinstance(node, Piece) and node.kind == "COMMA" for node in group.nodes)
    pair = group.open.kind == "LPAR" and not group.called and commas == 1  # `(x,)` is a tuple
    return group.nodes[:-1] if group.takes_comma and _is_comma(group.nodes[-1]) and not pair else group.nodes


def _is_comma(node: Node, *kinds: str) -> bool:
    return isinstance(node, Piece) and node.kind in (kinds or ("COMMA",))


def width(text: str) -> int:
    """Columns of a text up to its first line break."""
    end = text.find("\n")
    return len(text) if end < 0 else end


def separators(nodes: Sequence[Node]) -> list[int]:
    """Places of the commas at which a statement may be parted: those before specifiers, or else those of a list."""
    inner = range(len(nodes) - 1)
    special = [place for place in inner if _is_comma(nodes[place], "_COMMA_SPECIFIER")]
    equals = [place for place in inner if _is_comma(nodes[place], "_EQUAL", "AUGMENTED_ASSIGN")]
    return special or [place for place in inner if _is_comma(nodes[place]) and place > (equals or [-1])[0]]


def is_parted(nodes: Sequence[Node]) -> bool:
    """Return whether the author ended a line after one of its separators."""
    return any(leading(nodes[place + 1]).broken for place in separators(nodes))


def wrap(nodes: Sequence[Node], indent: int) -> str:
    """The lines of a statement, without the last line break."""
    page = _Page(indent, wide=indent + width(flat(nodes)) > WIDTH)
    ends = separators(nodes) if page.wide or is_parted(nodes) else []
    for number, segment in enumerate(_split(nodes, ends)):
        if number:
            page.end_line(leading(segment[0]).comments, indent + STEP)
        page.write(segment, indent + STEP * bool(number), indent + STEP)
    return page.text()


def _split(nodes: Sequence[Node], ends: Sequence[int]) -> list[Sequence[Node]]:
    starts = [0, *(end + 1 for end in ends)]
    return [nodes[start:end] for start, end in zip(starts, [*starts[1:], len(nodes)], strict=True)]


class _Page:
    """Lines in the making."""

    def __init__(self, indent: int, wide: bool) -> None:
        self.wide = wide
        """Whether backslashes at the ends of lines are kept."""
        self.lines: list[str] = []
        self.line = " " * indent
        self.fresh = True
        """Whether nothing stands on the current line yet."""

    def text(self) -> str:
        return "\n".join([*self.lines, self.line])

    @property
    def column(self) -> int:
        return len(self.line) - self.line.rfind("\n") - 1

    def put(self, text: str, lead: Piece) -> None:
        self.line += ("" if self.fresh else " " * (lead.space + lead.pad)) + text
        self.fresh = False

    def end_line(self, comments: Sequence[Comment], indent: int, last: int | None = None) -> None:
        """End the line with its trailing comment, and write the comments on lines of their own."""
        for number, comment in enumerate(comments):
            if number or comment.alone:
                self.new_line(indent)
                self.line += comment.text
            else:
                self.line += "  " + comment.text
        self.new_line(indent if last is None else last)

    def new_line(self, indent: int) -> None:
        self.lines.append(self.line)
        self.line = " " * indent
        self.fresh = True

    def write(self, nodes: Sequence[Node], indent: int, hang: int, after: int = 0) -> None:
        """Write nodes of one stretch, with brackets that close at `indent`; `after` columns are needed after it."""
        for number, node in enumerate(nodes):
            lead = leading(node)
            if lead.comments and not self.fresh:
                self.end_line(lead.comments, hang)
            elif lead.continued and self.wide and not self.fresh and hang > indent - STEP:
                self.line += " \\"
                self.new_line(hang)
            if isinstance(node, Piece):
                self.put(node.text, node)
            elif node.forced or not self.fits(node, nodes[number + 1 :], after):
                self.explode(node, indent)
            else:
                self.put(_flat(node, first=True), lead)

    def fits(self, group: Group, following: Sequence[Node], after: int) -> bool:
        """Return whether a group fits on this line, with the text up to the next bracket."""
        end = next((number for number, node in enumerate(following) if isinstance(node, Group)), len(following))
        rest = width(flat(following[:end])) + (after if end == len(following) else 2)
        return self.column + 1 + width(_flat(group, first=True)) + rest <= WIDTH

    def explode(self, group: Group, indent: int) -> None:
        """A group with its items on lines of their own."""
        self.put(group.open.text, group.open)
        inner = indent + STEP
        comments: tuple[Comment, ...] = ()
        items = _items(group)
        for number, (item, comma) in enumerate(items):
            self.end_line((*comments, *leading(item[0]).comments), inner)
            self.item(item, inner)
            comments = comma.comments if comma is not None else ()
            if number < len(items) - 1 or _ends_in_comma(group, items):
                self.line += ","
        self.end_line((*comments, *group.close.comments), inner, indent)
        self.put(group.close.text, group.close)

    def item(self, nodes: Sequence[Node], indent: int) -> None:
        """An item of a group; at the beginning of a line, its first comments are written already."""
        wide = indent + width(flat(nodes)) + 1 > WIDTH
        ends = [place - 1 for place in range(1, len(nodes)) if _is_comma(nodes[place], *_JOINTS)] if wide else []
        special = [place for place in range(len(nodes)) if _is_comma(nodes[place], "_COMMA_SPECIFIER")] if wide else []
        deeper = STEP if special else 0
        for number, segment in enumerate(_split(nodes, special or ends)):
            if number:
                self.end_line(leading(segment[0]).comments, indent + deeper)
            place = indent + deeper * bool(number)
            self.write(segment, place, indent + deeper, after=1)


def _ends_in_comma(group: Group, items: Sequence[tuple[Sequence[Node], Piece | None]]) -> bool:
    """Return whether a comma is after the last item when the items have lines of their own."""
    written = items[-1][1] is not None
    return (len(items) > 1 or (written and not group.called)) if group.takes_comma else written


def _items(group: Group) -> list[tuple[Sequence[Node], Piece | None]]:
    """The items of a group, each with the comma behind it."""
    places = [place for place, node in enumerate(group.nodes) if _is_comma(node)]
    items = [segment for segment in _split(group.nodes, places) if segment]
    return [
        (segment[:-1], segment[-1]) if isinstance(segment[-1], Piece) and _is_comma(segment[-1]) else (segment, None)
        for segment in items
    ]


MAX_BLANK = 2
"""Maximum number of consecutive blank lines."""
_BOM = "\ufeff"


def format_source(source: Source) -> str:
    """The text of a file in the one layout; formatting that again changes nothing. Line breaks stay of their kind.

    Raises:
        CompileError: the file does not parse.
    """
    from cortex_dsl.syntax import parse
    from cortex_dsl.syntax.parser import read_tokens

    parse(source)
    return format_tokens(source, read_tokens)


def format_tokens(source: Source, read: "Callable[[Source], Sequence[Token]]") -> str:
    """Return the text of a file in the one layout; `read` returns the tokens of its text with plain line breaks."""
    plain = source.text.removeprefix(_BOM).replace("\r\n", "\n")
    text = _format(list(_lines(read(Source(source.name, plain)), plain)), plain)
    if "\r\n" in source.text and source.text.find("\r\n") < source.text.find("\n"):
        text = text.replace("\n", "\r\n")
    return _BOM + text if source.text.startswith(_BOM) else text


@dataclass(frozen=True)
class _Line:
    """A logical line, its nesting level, and its place in the file."""

    nodes: tuple[Node, ...]
    level: int
    start: int
    end: int
    indent: int
    """Columns of its indentation in the file."""
    aligned: bool
    """Whether more than one space is before its first `=`."""

    @property
    def defines(self) -> bool:
        """Return whether it begins a definition, which has a blank line before and after it."""
        first = self.nodes[0]
        return isinstance(first, Piece) and first.kind in ("_BEHAVIOR", "_CLASS", "_MONITOR", "_SCENARIO")


def _lines(tokens: Sequence["Token"], text: str) -> Iterator[_Line]:
    level, line = 0, list["Token"]()
    for token in tokens:
        if token.type == "_NEWLINE":
            yield _line(line, level, text)
            line = []
        elif token.type in ("_INDENT", "_DEDENT"):
            level += 1 if token.type == "_INDENT" else -1
        else:
            line.append(token)


def _line(tokens: list["Token"], level: int, text: str) -> _Line:
    start, end = tokens[0].start_pos or 0, tokens[-1].end_pos or 0
    indent = text[text.rfind("\n", 0, start) + 1 : start]
    equal = next((token.start_pos or 0 for token in tokens if token.type == "_EQUAL"), 0)
    content = tokens[:-1] if tokens[-1].type == "SEMICOLON" else tokens
    return _Line(nodes_of(content, text), level, start, end, _columns(indent), text[max(equal - 2, 0) : equal] == "  ")


def _columns(indent: str) -> int:
    return len(indent.lstrip(_BOM).expandtabs(TAB_WIDTH))


def _format(lines: list[_Line], text: str) -> str:
    pads = _alignment(lines, text)
    written = _stripped(_between(text[: lines[0].start] if lines else text + "\n", [0], 0), end=not lines)
    around: list[_Line] = []
    for number, line in enumerate(lines):
        last = number + 1 == len(lines)
        around = [*around[: line.level], line]
        behind, _, gap = text[line.end : None if last else lines[number + 1].start].partition("\n")
        comment = "".join("  " + each.text for each in comments_in(behind))
        written.append(wrap(_padded(line.nodes, pads[number]), line.level * STEP) + comment)
        if last:
            written += _stripped(_between(gap + "\n", [each.indent for each in around], 0), start=False)
            continue
        following = lines[number + 1]
        between = list(_between(gap, [each.indent for each in around], following.level))
        if following.level > line.level:
            between = _stripped(between, end=False)
        elif any(each.defines for each in (following, *around[following.level :])):
            between = _set_apart(between, following.level)
        written += between
    return "\n".join(written) + "\n" if written else ""


# -- between the lines -----------------------------------------------------------------------------------------------


def _between(gap: str, indents: Sequence[int], level: int) -> Iterator[str]:
    """Yield comments and blank lines before a line of this level, below a line with blocks of these indentations."""
    blank = 0
    for raw in gap.split("\n")[:-1]:
        found = raw.strip(" \t\f\\" + _BOM)
        if found:
            yield " " * (STEP * _comment_level(raw, indents, level)) + tidy(found)
        blank = 0 if found else blank + 1
        if not found and blank <= MAX_BLANK and "\\" not in raw:
            yield ""


def _stripped(between: Iterable[str], *, start: bool = True, end: bool = True) -> list[str]:
    """Return the lines without blank lines at their beginning and end."""
    content = list(dropwhile(lambda line: start and not line, between))
    while end and content and not content[-1]:
        content.pop()
    return content


def _set_apart(between: list[str], level: int) -> list[str]:
    """Return the lines with at least one blank line, above the comments of the next statement."""
    if "" in between:
        return between
    own = (number for number, line in enumerate(between) if not line.startswith(" " * (STEP * level + 1)))
    place = next(own, len(between))
    return [*between[:place], "", *between[place:]]


def _comment_level(comment: str, indents: Sequence[int], following: int) -> int:
    """The block that a comment is indented like, among those that are open there."""
    columns = _columns(comment[: len(comment) - len(comment.lstrip())])
    fitting = [level for level in range(following, len(indents)) if indents[level] <= columns]
    return max(fitting, default=following)


# -- across the lines ------------------------------------------------------------------------------------------------


def _alignment(lines: Sequence[_Line], text: str) -> list[int]:
    """Return for every line the number of spaces before its `=`, in addition to the usual one."""
    pads: list[int] = []
    run: list[_Line] = []
    for number, line in enumerate(lines):
        run.append(line)
        following = lines[number + 1] if number + 1 < len(lines) else None
        if following is None or not _belong_together(line, following, text):
            wanted = _sort(line) == "_PARAM" or any(each.aligned for each in run)
            pads += _pads(run) if _sort(line) and wanted else [0] * len(run)
            run = []
    return pads


def _belong_together(line: _Line, following: _Line, text: str) -> bool:
    adjacent = text.count("\n", line.end, following.start) == 1
    return adjacent and line.level == following.level and _sort(line) == _sort(following) != ""


def _sort(line: _Line) -> str:
    """Return `_PARAM` or `NAME` for a param or an assignment of one name on a single line, else ""."""
    kinds = [node.kind if isinstance(node, Piece) else "" for node in line.nodes]
    plain = "SEMICOLON" not in kinds and not is_parted(line.nodes)
    if kinds[:1] == ["_PARAM"] and kinds[2:3] == ["_EQUAL"] and plain and "COMMA" not in kinds:
        return "_PARAM"
    return "NAME" if kinds[:2] == ["NAME", "_EQUAL"] and plain else ""


def _pads(run: Sequence[_Line]) -> list[int]:
    """Return the spaces that align the `=` of a run; a line that would become too long splits the run."""
    names = [width(flat(line.nodes[: _equal(line)])) for line in run]
    for number, line in enumerate(run):
        pad = max(names) - names[number]
        if separators(line.nodes) and line.level * STEP + width(flat(line.nodes)) + pad > WIDTH:
            return [*_pads(run[:number]), 0, *_pads(run[number + 1 :])]
    return [max(names) - name for name in names]


def _equal(line: _Line) -> int:
    return 2 if _sort(line) == "_PARAM" else 1


def _padded(nodes: tuple[Node, ...], pad: int) -> tuple[Node, ...]:
    """The nodes of a line, with more spaces before its first `=`."""
    for number, node in enumerate(nodes):
        if pad and isinstance(node, Piece) and node.kind == "_EQUAL":
            return (*nodes[:number], replace(node, pad=pad), *nodes[number + 1 :])
    return nodes


# -- copies of a scenario ----------------------------------------------------------------------------------------------


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
