"""A place in a statement: the tokens before it, the open brackets, and the callee."""

import re
from dataclasses import dataclass

from pygments.token import Number

from cortex_dsl.editor.analysis import View
from cortex_dsl.editor.lexer import Token, word_before

CLOSERS = {"(": ")", "[": "]", "{": "}"}
_WORDS = re.compile(r"(?:[a-z]+[ \t]+)+\Z")


@dataclass(frozen=True)
class Place:
    """A place that is being written at."""

    offset: int
    word: str
    """The part of a word that is there already."""
    left: tuple[Token, ...]
    """Tokens of the statement so far, without that word."""
    open: tuple[int, ...]
    """Indices in `left` of the brackets that are open."""
    indent: str
    phrase: tuple[str, ...]
    """Small words directly before, on this line."""

    @property
    def start(self) -> int:
        return self.offset - len(self.word)

    @property
    def before(self) -> Token | None:
        return self.left[-1] if self.left else None

    @property
    def previous(self) -> str:
        """Return the text of the previous token, with each run of blanks replaced by a single blank."""
        return " ".join(self.left[-1].text.split()) if self.left else ""

    @property
    def after_number(self) -> bool:
        return self.before is not None and self.before.kind in Number

    @property
    def after_value(self) -> bool:
        """Return whether an operator can follow."""
        if self.before is None:
            return False
        named = self.before.is_name or self.before.is_unit or self.before.kind in Number or self.before.is_text
        return named or self.previous in (")", "]", "}", "True", "False", "None")

    @property
    def callee(self) -> int:
        """Return the index of the word that the arguments belong to; -1 outside of calls."""
        if not self.open or self.left[self.open[-1]].text != "(" or not self.open[-1]:
            return -1
        return self.open[-1] - 1 if self.left[self.open[-1] - 1].text.isidentifier() else -1

    @property
    def argument(self) -> int:
        """Return the index of the argument in its call, from 0."""
        depth, count = 0, 0
        for token in self.left[self.open[-1] + 1 :] if self.open else ():
            depth += (token.text in CLOSERS) - (token.text in CLOSERS.values())
            count += depth == 0 and token.text == ","
        return count

    @property
    def in_new(self) -> bool:
        """Return whether specifiers can be here."""
        since = self.open[-1] if self.open else -1
        return any(token.text in ("new", "override") for token in self.left[since + 1 :])

    @property
    def closed_call(self) -> str:
        """Name of the call that ends directly before; empty if none does."""
        depth = 0
        for index in range(len(self.left) - 1, -1, -1):
            text = self.left[index].text
            depth += (text in ")]}") - (text in "([{")
            if depth == 0:
                called = index and text == "(" and self.left[index - 1].is_name
                return self.left[index - 1].text if called else ""
        return ""


def place_of(view: View, offset: int) -> Place | None:
    """The place at an offset; None inside of text and comments."""
    word = word_before(view.text, offset)
    start = offset - len(word)
    inside = next((t for t in view.tokens if t.start < offset <= t.end and t.is_text), None)
    if inside is not None and (offset < inside.end or inside.text.startswith("#")):
        return None
    left, brackets = _statement(view, start)
    line = view.text.rfind("\n", 0, start) + 1
    indent = view.text[line:start][: len(view.text[line:start]) - len(view.text[line:start].lstrip())]
    phrase = _WORDS.search(view.text[line:start])
    return Place(offset, word, left, brackets, indent, tuple(phrase.group().split()) if phrase else ())


def _statement(view: View, start: int) -> tuple[tuple[Token, ...], tuple[int, ...]]:
    """Tokens before an offset that belong to the same statement, and which of them are open brackets."""
    left: list[Token] = []
    brackets: list[int] = []
    for token in view.tokens:
        if token.start >= start:
            break
        if left and not brackets and _ends(view.text, left[-1], token.start):
            left = []
        if token.text in CLOSERS:
            brackets.append(len(left))
        elif token.text in CLOSERS.values() and brackets:
            brackets.pop()
        if not token.text.startswith("#"):
            left.append(token)
    if left and not brackets and _ends(view.text, left[-1], start):
        left = []
    return tuple(left), tuple(brackets)


def _ends(text: str, token: Token, following: int) -> bool:
    """Return whether a statement ends between a token and an offset."""
    if token.text == ";":
        return True
    between = text[token.end : following]
    return "\n" in between and token.text != "," and not between.lstrip(" \t").startswith("\\")
