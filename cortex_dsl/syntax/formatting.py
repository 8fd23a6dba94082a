"""One layout for every file: `format_source`. Comments and the spelling of numbers, units and strings are unchanged.

`pieces` sets spaces, `wrapping` line breaks; this module sets the layout between lines and over several lines. At most
two blank lines follow each other, none follows a line that opens a block, and definitions have one around them. The `=`
of params on consecutive lines are aligned; those of assignments too, if the author aligned one of them.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import dropwhile
from typing import TYPE_CHECKING

from cortex_dsl.source import Source
from cortex_dsl.syntax.layout import TAB_WIDTH
from cortex_dsl.syntax.pieces import Node, Piece, comments_in, nodes_of, tidy
from cortex_dsl.syntax.wrapping import STEP, WIDTH, flat, is_parted, separators, width, wrap

if TYPE_CHECKING:
    from lark import Token

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
    kept = tokens[:-1] if tokens[-1].type == "SEMICOLON" else tokens
    return _Line(nodes_of(kept, text), level, start, end, _columns(indent), text[max(equal - 2, 0) : equal] == "  ")


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
    kept = list(dropwhile(lambda line: start and not line, between))
    while end and kept and not kept[-1]:
        kept.pop()
    return kept


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
