"""Lark's contextual lexer, made for short commands: nothing is compiled before a text needs it, and nothing twice.

Lark joins the terminals that each of the parser's states accepts into one pattern a state, so most terminals are
compiled dozens of times, which takes longer than reading a scenario. Here each is a pattern of its own, tried in Lark's
order if it can begin with the character that stands there.
"""

import re
from collections.abc import Collection, Iterable, Mapping
from functools import cached_property
from string import ascii_letters
from typing import Any

from lark.common import LexerConf
from lark.lexer import AbstractBasicLexer, BasicLexer, ContextualLexer, PatternStr, TerminalDef
from lark.utils import TextSlice

LETTERS = frozenset(ascii_letters)
QUANTIFIERS = frozenset("*?+{")
PLAIN_MARKS = re.compile(r"\\.|\[(?:\\.|[^\\\]])*\]")
"""What holds marks of a pattern that mean themselves: escapes, and sets of characters."""


class Terminal:
    """One terminal, compiled when it is first tried."""

    def __init__(self, definition: TerminalDef, flags: int) -> None:
        self.name = definition.name
        self.text = definition.pattern.to_regexp()
        self.flags = flags
        self.first = definition.pattern.value[0] if isinstance(definition.pattern, PatternStr) else first_of(self.text)

    @cached_property
    def pattern(self) -> re.Pattern[str]:
        return re.compile(self.text, self.flags)


def first_of(regex: str) -> str | None:
    """The one letter that every match begins with; None where there may be several, or it is not obvious."""
    depth = 0
    for mark in PLAIN_MARKS.sub("", regex):
        depth += (mark == "(") - (mark == ")")
        if mark == "|" and depth == 0:
            return None
    letter, following = regex[:1], regex[1:2]
    return letter if letter in LETTERS and following not in QUANTIFIERS else None


class Scanner:
    """The terminals that one state of the parser accepts, in the order in which they are tried."""

    def __init__(self, terminals: Iterable[Terminal]) -> None:
        self.terminals = tuple(terminals)
        self.allowed_types = {terminal.name for terminal in self.terminals}
        self._by_first: dict[str, tuple[Terminal, ...]] = {}

    def match(self, text: TextSlice, pos: int) -> tuple[str, str] | None:
        """The text at an offset and its terminal."""
        for terminal in self._candidates(text.text[pos]):
            if found := terminal.pattern.match(text.text, pos, text.end):
                return found[0], terminal.name
        return None

    def _candidates(self, mark: str) -> tuple[Terminal, ...]:
        if mark not in self._by_first:
            self._by_first[mark] = tuple(t for t in self.terminals if t.first is None or t.first == mark)
        return self._by_first[mark]


class StateLexer(BasicLexer):
    """What is read in one state of the parser."""

    def __init__(self, conf: LexerConf, scanner: Scanner, newlines: frozenset[str]) -> None:
        self._scanner: Any = scanner
        self.newline_types = newlines
        self.ignore_types = frozenset(conf.ignore)
        self.terminals_by_name = conf.terminals_by_name
        self.callback = {}


class TerminalLexer(ContextualLexer):
    """For Lark's `_plugins`; the grammar has no terminal that is a special case of another one of its priority."""

    def __init__(
        self, conf: LexerConf, states: Mapping[int, Collection[str]], always_accept: Collection[str] = ()
    ) -> None:
        definitions = sorted(conf.terminals, key=_rank)
        self.conf = conf
        self.terminals = [Terminal(definition, conf.g_regex_flags) for definition in definitions]
        self.newlines = frozenset(t.name for t in self.terminals if _has_newline(t.text))
        self.lexers = _StateLexers(self, states, {*conf.ignore, *always_accept})
        self.root_lexer = self.lexer_of({t.name for t in self.terminals})

    def lexer_of(self, names: Collection[str]) -> StateLexer:
        return StateLexer(self.conf, Scanner(t for t in self.terminals if t.name in names), self.newlines)


class _StateLexers(dict[int, AbstractBasicLexer]):
    """By state, each made when the parser first gets there."""

    def __init__(self, whole: TerminalLexer, states: Mapping[int, Collection[str]], always: Collection[str]) -> None:
        super().__init__()
        self.whole, self.states, self.always = whole, states, always

    def __missing__(self, state: int) -> StateLexer:
        made = self[state] = self.whole.lexer_of({*self.states[state], *self.always})
        return made


def _rank(terminal: TerminalDef) -> tuple[int, int, int, str]:
    """Lark's order of trying."""
    pattern = terminal.pattern
    return -terminal.priority, -pattern.max_width, -len(pattern.value), terminal.name


def _has_newline(regex: str) -> bool:
    """Whether a match may hold a line break."""
    return any(mark in regex for mark in ("\n", "\\n", "\\s", "\\S", "[^", "(?s"))
