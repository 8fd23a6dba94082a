"""The context of a syntax error, as the rules that explain it need it: the line in words, and where reading stopped."""

import re
from functools import cached_property

from cortex_dsl.source import Source, Span
from cortex_dsl.syntax.layout import Layout
from cortex_dsl.syntax.scanning import Line
from engine.frozen import frozen

_WORD = re.compile(
    r"""(?P<comment>\#[^\n]*|\s+|\\\r?\n)
    |(?P<string>\"\"\"[\s\S]*?\"\"\"|'''[\s\S]*?'''|"(?:[^"\\\n]|\\.)*"|'(?:[^'\\\n]|\\.)*')
    |(?P<number>(?:\d[\d_]*\.?[\d_]*|\.\d[\d_]*)(?:[eE][-+]?\d+)?)
    |(?P<name>[^\W\d]\w*)
    |(?P<sign>&&|\|\||\+\+|--|\*\*=?|//=?|[-+*/%<>=!]=|<>|->|:=|[\s\S])""",
    re.VERBOSE,
)


@frozen
class Word:
    """A token as a person sees it. Kinds: string, number, name, sign, and end (of a line or the file)."""

    kind: str
    text: str
    span: Span


@frozen
class ErrorContext:
    """Place at which parsing stopped, and the accepted tokens there."""

    source: Source
    layout: Layout
    index: int
    offset: int
    accepts: frozenset[str]
    """Kinds of tokens that the grammar would have taken."""

    @property
    def line(self) -> Line:
        return self.layout.lines[self.index]

    @cached_property
    def words(self) -> tuple[Word, ...]:
        """The logical line, token by token, with its end."""
        found = [
            Word(match.lastgroup or "", match.group(), Span(match.start(), match.end()))
            for match in _WORD.finditer(self.source.text, self.line.start, self.line.end)
            if match.lastgroup != "comment"
        ]
        return (*found, Word("end", "", Span(self.line.end, self.line.end)))

    @cached_property
    def place(self) -> int:
        """Return the index into `words` of the first one that does not fit."""
        return next((i for i, word in enumerate(self.words) if word.span.end > self.offset), len(self.words) - 1)

    @property
    def found(self) -> Word:
        return self.words[self.place]

    @property
    def before(self) -> Word | None:
        """The last word that fitted."""
        return self.words[self.place - 1] if self.place else None

    @property
    def after(self) -> Word | None:
        return self.words[self.place + 1] if self.place + 1 < len(self.words) else None

    @property
    def first(self) -> Word:
        return self.words[0]

    @cached_property
    def bracket(self) -> Word | None:
        """The innermost bracket that is open where reading stopped."""
        open_brackets: list[Word] = []
        for word in self.words[: self.place]:
            if word.kind == "sign" and word.text in "([{":
                open_brackets.append(word)
            elif word.kind == "sign" and word.text in ")]}" and open_brackets:
                open_brackets.pop()
        return open_brackets[-1] if open_brackets else None

    @property
    def wants_value(self) -> bool:
        """Return whether an expression could begin here."""
        return "NUMBER" in self.accepts

    @property
    def wants_operator(self) -> bool:
        """Return whether an expression has just ended here."""
        return "PLUS" in self.accepts and not self.wants_value
