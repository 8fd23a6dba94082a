r"""Logical lines: the bounds of statements, before any grammar.

A line continues inside brackets, after a `\` at its end, and after a comma if the next line is indented deeper.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from cortex_dsl.diagnostics import Diagnostic, Label
from cortex_dsl.source import Span
from cortex_dsl.syntax import errors
from cortex_dsl.syntax.errors import MAX_DEPTH
from cortex_dsl.syntax.words import GUARDS
from engine.errors import Signal
from engine.frozen import frozen

PAIRS = {"(": ")", "[": "]", "{": "}"}

_PIECE = re.compile(
    r"""(?P<comment>\#[^\n]*)
    |(?P<string>\"\"\"[^\\"]*(?:(?:\\[\s\S]|"(?!""))[^\\"]*)*\"\"\"
        |'''[^\\']*(?:(?:\\[\s\S]|'(?!''))[^\\']*)*'''
        |"(?!"")(?:[^"\\\n]|\\\r?\n|\\[^\n])*"
        |'(?!'')(?:[^'\\\n]|\\\r?\n|\\[^\n])*')
    |(?P<unclosed>\"\"\"[\s\S]*|'''[\s\S]*|["'][^\n]*)
    |(?P<open>[(\[{])
    |(?P<close>[)\]}])
    |(?P<newline>\r?\n)
    |(?P<space>(?:[ \t\f\ufeff]|\\\r?\n)+)
    |(?P<other>[^\#"'()\[\]{}\s\\\ufeff,:]+|[\s\S])""",
    re.VERBOSE,
)
_NEXT_LINE = re.compile(r"(?:[ \t\f]*(?:#[^\n]*)?\r?\n)*(?P<indent>[ \t\f]*)(?=[^\s#])")
_STATEMENT = re.compile(
    r"(?:(?:behavior|model|param|require|terminate|take|do|if|while|try|interrupt|abort|wait|map)\b[ \t]*[\w(\[:]"
    r"|(?:wait|abort|terminate|pass|break|continue|return)[ \t]*(?:#|\r?\n|\Z)"
    r"|(?:class|import|monitor|scenario|record|mutate|override|domain|expect|maximize|minimize)\b[ \t]+[\w\"']"
    r"|(?:setup|compose)[ \t]*:"
    r"|[^\W\d]\w*[ \t]+=[ \t])"
)


@frozen
class Line:
    """A logical line, from its first character to one past its last that is no comment."""

    start: int
    end: int
    stop: int
    """Offset of the line break that ends it, or the length of the text."""
    indent: str
    word: str
    """The word that it begins with, or an empty string."""
    opens: bool
    """Whether it ends in a colon."""
    broken: bool
    """Whether an error was reported for it, so that its grammar is not checked."""


@frozen
class Scan:
    lines: tuple[Line, ...]
    diagnostics: tuple[Diagnostic, ...]
    hopeless: bool = False
    """Whether nesting exceeded its limit, so that nothing else is reported."""


class _NestingError(Signal):
    pass


def scan(text: str) -> Scan:
    """Logical lines of a text. Where brackets do not match, lines that look like statements end them."""
    scanner = _Scanner(text, suspicious=False)
    try:
        scanner.run()
        if scanner.mismatched:
            scanner = _Scanner(text, suspicious=True)
            scanner.run()
    except _NestingError:
        return Scan((), (scanner.diagnostics[-1],), hopeless=True)
    return Scan(tuple(scanner.lines), tuple(scanner.diagnostics))


@dataclass
class _Scanner:
    text: str
    suspicious: bool
    """Whether a line that looks like a statement ends open brackets."""
    lines: list[Line] = field(default_factory=list)
    diagnostics: list[Diagnostic] = field(default_factory=list)
    mismatched: bool = False
    brackets: list[int] = field(default_factory=list)
    start: int = -1
    end: int = 0
    broken: bool = False

    def run(self) -> None:
        for match in _PIECE.finditer(self.text):
            kind = match.lastgroup
            if kind == "newline":
                self.line_break(match)
            elif kind not in ("space", "comment"):
                self.piece(kind or "", match)
        if self.start >= 0:
            self.finish(len(self.text))

    def piece(self, kind: str, match: re.Match[str]) -> None:
        if self.start < 0:
            self.start, self.broken = match.start(), False
        self.end = match.end()
        if kind == "open":
            self.open(match.start())
        elif kind == "close":
            self.close(match.start())
        elif kind == "unclosed":
            self.unclosed_string(match)

    def open(self, offset: int) -> None:
        self.brackets.append(offset)
        if len(self.brackets) > MAX_DEPTH:
            self.diagnostics.append(
                errors.TOO_DEEP.at(
                    Span(offset, offset + 1),
                    f"brackets are nested more than {MAX_DEPTH} deep",
                    "one too many",
                    reason=errors.TOO_DEEP.reason,
                    cure="give inner parts a name of their own",
                )
            )
            raise _NestingError

    def close(self, offset: int) -> None:
        found = self.text[offset]
        if self.brackets and PAIRS[self.text[self.brackets[-1]]] == found:
            self.brackets.pop()
            return
        reported, self.mismatched, self.broken = self.broken, True, True
        span = Span(offset, offset + 1)
        if reported:
            self.brackets = self.brackets[:-1]
            return
        if not self.brackets:
            message = f"`{found}` closes nothing"
            cure = "remove it, or write the bracket that it should close"
            self.diagnostics.append(errors.WRONG_BRACKET.at(span, message, "no bracket is open here", cure=cure))
            return
        opening = self.brackets[-1]
        self.brackets = self.brackets[: self.partner(found)]
        wanted = PAIRS[self.text[opening]]
        self.diagnostics.append(
            errors.WRONG_BRACKET.at(
                span,
                f"`{found}` does not close `{self.text[opening]}`",
                f"expected `{wanted}`",
                secondary=[Label(Span(opening, opening + 1), "opened here")],
                cure=f"close it with `{wanted}`",
            )
        )

    def partner(self, found: str) -> int:
        """Return the index of the innermost open bracket of the same kind, or else of the innermost one."""
        same = [index for index, offset in enumerate(self.brackets) if PAIRS[self.text[offset]] == found]
        return same[-1] if same else len(self.brackets) - 1

    def unclosed_string(self, match: re.Match[str]) -> None:
        opening = match.group()
        quotes = opening[:3] if opening[:3] in ('"""', "'''") else opening[0]
        self.end = match.start() + len(opening.rstrip())
        where = "the file" if len(quotes) == 3 else "the line"
        self.diagnostics.append(
            errors.UNCLOSED_STRING.at(
                Span(match.start(), match.start() + len(quotes)),
                "this string is never closed",
                "begins here",
                reason=f"{where} ends before another {quotes}",
                cure=f"write {quotes} where the string ends",
            )
        )
        # The string most likely contains the closing bracket, or an earlier line has an open one.
        self.mismatched |= bool(self.brackets)
        self.brackets.clear()
        self.broken = True

    def line_break(self, match: re.Match[str]) -> None:
        if self.start < 0:
            return
        following = _NEXT_LINE.match(self.text, match.end())
        if self.brackets:
            if not (self.suspicious and following and self.begins_statement(following)):
                return
        elif following and self.text[self.end - 1] == "," and len(following["indent"]) > len(self.indent()):
            return
        self.finish(match.start())

    def begins_statement(self, following: re.Match[str]) -> bool:
        shallow = len(following["indent"]) <= len(self.indent())
        return shallow and _STATEMENT.match(self.text, following.end()) is not None

    def indent(self) -> str:
        return self.text[self.text.rfind("\n", 0, self.start) + 1 : self.start].lstrip("\ufeff")

    def finish(self, stop: int) -> None:
        if self.brackets:
            self.unclosed_brackets()
        word = re.match(r"[^\W\d]\w*", self.text[self.start : self.start + 40])
        self.lines.append(
            Line(
                start=self.start,
                end=self.end,
                stop=stop,
                indent=self.indent(),
                word=word.group() if word else "",
                opens=self.text[self.end - 1] == ":" and not (word and word.group() in GUARDS),
                broken=self.broken,
            )
        )
        self.start = -1

    def unclosed_brackets(self) -> None:
        self.mismatched = self.broken = True
        wanted = "".join(PAIRS[self.text[offset]] for offset in reversed(self.brackets))
        places = [Label(Span(offset, offset + 1), "never closed") for offset in reversed(self.brackets[-3:])]
        self.diagnostics.append(
            errors.UNCLOSED_BRACKET.at(
                Span(self.end, self.end),
                f"`{self.text[self.brackets[-1]]}` is never closed",
                f"expected `{wanted}`" if len(wanted) <= 5 else "expected closing brackets",
                secondary=places,
                cure=f"write `{wanted}` where it ends" if len(wanted) <= 5 else "",
            )
        )
        self.brackets.clear()


def pieces(text: str, start: int, end: int) -> Iterator[tuple[str, int]]:
    """Kind and offset of every piece of a stretch of text (kinds: the groups of the pattern)."""
    for match in _PIECE.finditer(text, start, end):
        yield match.lastgroup or "", match.start()
