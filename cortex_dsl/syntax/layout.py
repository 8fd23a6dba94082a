"""Indentation: which line belongs to which block, and the post-lexer that passes this to the grammar."""

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from lark import Token

from cortex_dsl.diagnostics import Diagnostic, Label
from cortex_dsl.source import Span
from cortex_dsl.syntax import errors
from cortex_dsl.syntax.errors import MAX_DEPTH
from cortex_dsl.syntax.scanning import Line, Scan, scan
from cortex_dsl.syntax.words import BLOCK_WORDS, RESERVED, SPECIFIER_WORDS
from engine.frozen import frozen

TAB_WIDTH = 8
_REQUIRING = {"_REQUIRE": True, "_REQUIRE_PROBABLY": True, "_EXPECT": True, "SEMICOLON": False}
"""First tokens of a `require` or an `expect`, and the token that ends a statement inside a line."""
_OPERAND = re.compile(
    r"\(|[ \t]+(?!(?:" + "|".join(sorted(RESERVED - {"False", "None", "True", "lambda", "new", "not"})) + "|along"
    r"|can[ \t]+see|deg|implies|intersects|not[ \t]+in|offset[ \t]+(?:along|by)|seconds|steps)\b)"
    r"(?:[\w(\"'\[{.]|[-+][^\s=])"
)
"""Pattern of the text after a temporal operator, which distinguishes it from a name of the same spelling."""
_UNFINISHED = re.compile(r"(?:[-+*/%@=<>]|\b(?:and|or|not|in|is|if|else|by|to|from|of|at))\Z")

_OBJECT = re.compile(r"\bnew\b|=[ \t]*[A-Z]\w*[ \t]+[a-z]")
"""An object in a line, with `new` or, by mistake, without it."""


@frozen
class Layout:
    """The logical lines of a file and how deep in blocks each is; of one length."""

    lines: tuple[Line, ...]
    levels: tuple[int, ...]
    hollow: frozenset[int]
    """Lines that end in a colon and have no block."""
    diagnostics: tuple[Diagnostic, ...]
    hopeless: bool = False

    def line_at(self, offset: int) -> int:
        """Index of the line that an offset lies in, or of the last before it."""
        low, high = 0, len(self.lines)
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (middle, high) if self.lines[middle].start <= offset else (low, middle)
        return low

    def block_end(self, index: int) -> int:
        """Index of the last line of the block that a line opens, or of the line itself."""
        last = index
        while last + 1 < len(self.lines) and self.levels[last + 1] > self.levels[index]:
            last += 1
        return last


def lay_out(text: str) -> Layout:
    """Logical lines with their levels, and everything that is wrong with brackets, quotes and indentation."""
    found = scan(text)
    if found.hopeless:
        return Layout((), (), frozenset(), found.diagnostics, hopeless=True)
    return _Arrangement(text, found).layout()


def _width(indent: str) -> int:
    return len(indent.expandtabs(TAB_WIDTH))


def _usual_indent(lines: Sequence[Line]) -> Line | None:
    """The first line indented by the kind of blank that most lines begin with; None if none is indented."""
    indented = [line for line in lines if line.indent]
    kinds = Counter(line.indent[0] for line in indented)
    return next((line for line in indented if kinds[line.indent[0]] == max(kinds.values())), None)


def _mixed(line: Line, usual: Line) -> Diagnostic:
    """Return the error of a line indented unlike most others.

    The depth is unknown after it, so it is the only error.
    """
    kinds = {" ": "spaces", "\t": "tabs"}
    found = " and ".join(kinds.get(kind, "others") for kind in sorted(set(line.indent)))
    label = Label(Span(usual.start - len(usual.indent), usual.start), "most lines are indented so")
    return errors.MIXED_INDENT.at(
        Span(line.start - len(line.indent), line.start),
        "tabs and spaces are mixed in the indentation",
        f"indented with {found}",
        secondary=[label] if usual is not line else [],
        reason=errors.MIXED_INDENT.reason,
        cure=f"indent every line with {kinds.get(usual.indent[0], 'spaces')}",
    )


class _Arrangement:
    """One walk over the lines with a stack of open blocks."""

    def __init__(self, text: str, found: Scan) -> None:
        self.text = text
        self.diagnostics = list(found.diagnostics)
        self.lines: list[Line] = []
        self.levels: list[int] = []
        self.hollow: set[int] = set()
        self.blocks: list[tuple[int, int]] = [(0, 0)]
        """Width and level of each open block; a stray indentation has the level of the block around it."""
        self.usual = _usual_indent(found.lines)
        self.found = found

    def layout(self) -> Layout:
        for line in self.found.lines:
            if self.belongs_to_broken(line):
                self.lines[-1] = replace(self.lines[-1], stop=line.stop)
                continue
            if self.usual is not None and set(line.indent) - {self.usual.indent[0]}:
                mixed = _mixed(line, self.usual)
                return Layout((), (), frozenset(), (*self.found.diagnostics, mixed), hopeless=True)
            level = self.level(line)
            if self.belongs_to_broken(line):
                self.blocks.pop()
                self.lines[-1] = replace(self.lines[-1], stop=line.stop)
                continue
            if level > MAX_DEPTH:
                return Layout((), (), frozenset(), (self.too_deep(line),), hopeless=True)
            self.lines.append(line)
            self.levels.append(level)
        if self.lines and self.lines[-1].opens:
            self.missing_body()
        return Layout(tuple(self.lines), tuple(self.levels), frozenset(self.hollow), tuple(self.diagnostics))

    def belongs_to_broken(self, line: Line) -> bool:
        """Return whether the line continues one with wrong brackets or quotes."""
        if not self.lines:
            return False
        previous = self.lines[-1]
        return previous.broken and not previous.opens and _width(line.indent) > _width(previous.indent)

    def level(self, line: Line) -> int:
        width, (current, level) = _width(line.indent), self.blocks[-1]
        previous = self.lines[-1] if self.lines else None
        if previous is not None and previous.opens and width <= current:
            self.missing_body()
        if width > current:
            opens = previous is not None and (previous.opens or previous.word in BLOCK_WORDS)
            if not opens:
                self.stray_indent(line, previous)
            self.blocks.append((width, level + 1 if opens else level))
        elif width < current:
            self.close_blocks(line, width)
        return self.blocks[-1][1]

    def close_blocks(self, line: Line, width: int) -> None:
        closed = self.blocks[-1]
        while self.blocks[-1][0] > width:
            closed = self.blocks.pop()
        if self.blocks[-1][0] == width:
            return
        self.blocks.append((width, closed[1]))
        self.diagnostics.append(
            errors.WRONG_DEDENT.at(
                Span(line.start - len(line.indent), line.start),
                "the indentation of this line fits no block",
                f"{width} columns",
                reason=f"the lines around it are indented by {self.blocks[-2][0]} and {closed[0]} columns",
                cure="align it with the block that it belongs to",
            )
        )

    def stray_indent(self, line: Line, previous: Line | None) -> None:
        if (
            previous is not None
            and line.word in SPECIFIER_WORDS
            and _OBJECT.search(self.text, previous.start, previous.end)
        ):
            self.diagnostics.append(
                errors.MISSING_COMMA.at(
                    Span(previous.end, previous.end),
                    "missing comma between specifiers",
                    "a line that continues ends in `,`",
                    secondary=[Label(Span(line.start, line.start + len(line.word)), "the next specifier")],
                    cure="write a `,` at the end of the line",
                )
            )
            # The specifiers below belong to it, so they go unread.
            self.lines[-1] = replace(previous, broken=True)
            return
        if previous is not None and _UNFINISHED.search(self.text, previous.start, previous.end):
            self.diagnostics.append(
                errors.STRAY_INDENT.at(
                    Span(previous.end, previous.end),
                    "this expression ends in the middle",
                    "the line ends here",
                    secondary=[Label(Span(line.start, line.end), "meant to belong to it?")],
                    reason="an expression continues over several lines only inside brackets",
                    cure="put it into `(` and `)`",
                )
            )
            self.lines[-1] = replace(previous, broken=True)
            return
        label = Label(Span(previous.start, previous.end), "this line opens no block") if previous else None
        self.diagnostics.append(
            errors.STRAY_INDENT.at(
                Span(line.start - len(line.indent), line.start),
                "this line is indented, but no block begins here",
                "unexpected indentation",
                secondary=[label] if label else [],
                reason="only a line that ends in `:` is followed by deeper lines" if previous else "",
                cure="remove the spaces at its beginning",
            )
        )

    def missing_body(self) -> None:
        line = self.lines[-1]
        if line.word not in BLOCK_WORDS:
            return  # no block was meant; the grammar reports the error
        self.hollow.add(len(self.lines) - 1)
        self.diagnostics.append(
            errors.MISSING_BODY.at(
                Span(line.end - 1, line.end),
                f"`{line.word}` has no block" if line.word else "a block is missing",
                "expected an indented line after this",
                reason=errors.MISSING_BODY.reason,
                cure="indent the lines that belong to it by four spaces (write `pass` if there are none)",
            )
        )

    def too_deep(self, line: Line) -> Diagnostic:
        return errors.TOO_DEEP.at(
            Span(line.start, line.end),
            f"blocks are nested more than {MAX_DEPTH} deep",
            "one too many",
            reason=errors.TOO_DEEP.reason,
            cure="move inner blocks into a behavior of their own",
        )


def synthetic(kind: str, offset: int) -> Token:
    """Return a token without text."""
    return Token(kind, "None" if kind == "CONSTANT" else "", offset, 1, 1, 1, 1, offset)


class Indenter:
    """Lark's post-lexer: retains the line breaks that end a logical line and adds tokens that open and close blocks.

    Temporal operators are names outside a `require` and an `expect`.

    It stores the layout of the present text, so it serves one parse at a time.
    """

    always_accept = ("_NEWLINE",)

    def __init__(self) -> None:
        self.begin(Layout((), (), frozenset(), ()), "")

    def begin(self, layout: Layout, text: str) -> None:
        self.layout = layout
        self.text = text
        self.levels = list(layout.levels)
        self.breaks = {line.stop: index for index, line in enumerate(layout.lines)}
        self.ended = -1
        """Index of the last line whose end was passed on."""
        self.resumed = -1
        """Index of the last line that was skipped after an error."""
        self.requiring = False
        """Whether what is read belongs to a `require` or an `expect`, the places of temporal operators."""
        self.making = [False]
        """For each open bracket, whether a `new` stands in it, so that a comma may go on with its specifiers."""

    def process(self, stream: Iterable[Token]) -> Iterator[Token]:
        for token in stream:
            if token.type in _REQUIRING:
                self.requiring = _REQUIRING[token.type]
            self.follow_brackets(token.type)
            if token.type == "TEMPORAL" and not self.is_operator(token):
                yield token.update(type="NAME")
            elif token.type == "_COMMA_SPECIFIER" and not self.making[-1]:
                yield token.update(type="COMMA")
            elif token.type != "_NEWLINE":
                yield token
            elif (index := self.breaks.get(token.start_pos or 0)) is not None:
                yield from self.line_end(index)
        if self.ended < len(self.layout.lines) - 1:
            yield from self.line_end(len(self.layout.lines) - 1)

    def follow_brackets(self, kind: str) -> None:
        if kind in ("LPAR", "LSQB", "LBRACE"):
            self.making.append(False)
        elif kind in ("RPAR", "RSQB", "RBRACE") and len(self.making) > 1:
            self.making.pop()
        elif kind in ("_NEW", "_OVERRIDE"):
            self.making[-1] = True

    def is_operator(self, word: Token) -> bool:
        """Return whether `always`, `eventually` or `next` is an operator: its place allows it, and a value follows."""
        return self.requiring and _OPERAND.match(self.text, word.end_pos or 0) is not None

    def line_end(self, index: int) -> Iterator[Token]:
        self.ended = index
        self.requiring, self.making = False, [False]
        end = self.layout.lines[index].end
        kinds = ["_NEWLINE"]
        if index in self.layout.hollow:
            kinds += ["_INDENT", "_PASS", "_NEWLINE", "_DEDENT"]
        following = self.levels[index + 1] if index + 1 < len(self.levels) else 0
        step = following - self.levels[index]
        kinds += ["_INDENT"] * step + ["_DEDENT"] * -step
        for kind in kinds:
            yield synthetic(kind, end)
