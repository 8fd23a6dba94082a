"""Lark's scanner without its first cost: in each state the accepted tokens are tried one by one.

Lark joins them to one expression per state. A file of a few lines meets dozens of states, and compiling their
expressions takes several times as long as reading it. In a long text each state recurs: after `_PATIENCE` tokens its
expression is compiled as usual. Both ways the first token that fits is taken, in the same order.
"""

import re
from functools import cache
from typing import Any

from lark.lexer import BasicLexer, ContextualLexer, Scanner, TerminalDef
from lark.utils import TextSlice

_PATIENCE = 100
"""Number of tokens in a state that are found one by one."""

_compiled = cache(re.compile)


@cache
def beginning(pattern: str) -> str:
    """Characters with which all that fits a regular expression begins, as far as they are easily known."""
    plain = re.sub(r"\\.|\[[^\]]*\]", "", pattern)
    while plain != (plain := re.sub(r"\([^()]*\)", "", plain)):
        pass
    if "|" in plain:
        return ""
    letters = re.match(r"[A-Za-z,=]*(?![A-Za-z,=?*+{])", pattern)
    return letters.group() if letters else ""


def _steps(terminal: TerminalDef) -> tuple[str, str, str]:
    """The name of a token, how it begins, and its expression: none where it is no more than that."""
    pattern = terminal.pattern
    if pattern.type == "str":
        return terminal.name, pattern.value, ""
    return terminal.name, beginning(pattern.to_regexp()), pattern.to_regexp()


class PatientScanner:
    """Finds the token at a place; `match` as in `Scanner`."""

    def __init__(self, terminals: list[TerminalDef]) -> None:
        self.allowed_types = {each.name for each in terminals}
        self._terminals, self._steps = terminals, [_steps(each) for each in terminals]
        self._patience = _PATIENCE
        self._joined: Scanner | None = None

    def match(self, text: TextSlice[Any], pos: int) -> tuple[str, str] | None:
        """The first token that fits and its kind."""
        if self._joined is not None:
            return self._joined.match(text, pos)
        self._patience -= 1
        if not self._patience:
            self._joined = Scanner(self._terminals, 0, re, use_bytes=False)
        whole, end = text.text, text.end
        for name, start, pattern in self._steps:
            if whole.startswith(start, pos, end):
                if not pattern:
                    return start, name
                if (found := _compiled(pattern).match(whole, pos, end)) is not None:
                    return found.group(), name
        return None


class _Lexer(BasicLexer):
    def _build_scanner(self) -> Any:
        """Build the scanner for one parser state.

        No keyword needs a callback, since no name matches a keyword's plain text.
        """
        self.callback = dict(self.user_callbacks)
        return PatientScanner(list(self.terminals))


class Lexers(ContextualLexer):
    """The lexers of all places."""

    BasicLexer = _Lexer
