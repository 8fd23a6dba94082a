"""When a chunk of typed lines is whole, and how chunks are read where there is no editing: a pipe, a dumb terminal."""

import re
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum
from itertools import pairwise

from cortex_dsl.repl.state import State

BARE_COMMANDS = ("help", "quit", "exit")
"""Commands that are understood without their colon."""
CONTINUING = re.compile(r"(?:elif|else|interrupt|except|finally)\b")
"""Words that go on with a block at its own depth."""
_PIECE = re.compile(
    r"""(?P<long>\"\"\"(?:[^\\]|\\[\s\S])*?\"\"\"|'''(?:[^\\]|\\[\s\S])*?''')"""
    r"""|(?P<unclosed>(?:\"\"\"|''')[\s\S]*)"""
    r"""|(?P<text>"(?:[^"\\\n]|\\.)*"?|'(?:[^'\\\n]|\\.)*'?)"""
    r"""|(?P<comment>\#[^\n]*)|(?P<bracket>[()\[\]{}])|(?P<line>\n)|(?P<blank>[ \t\r]+)|(?P<other>[^\s"'#()\[\]{}]+)"""
)


class Open(Enum):
    """Why a chunk is not whole yet."""

    NO = "no"
    LINE = "line"
    """The line itself continues: after a bracket, a text, a comma or a backslash."""
    BLOCK = "block"
    """A colon has opened a block, which ends with a blank line or a dedent."""


def openness(text: str) -> Open:
    """Return whether more lines belong to the typed text."""
    depth, block, last = 0, False, ""
    for piece in _PIECE.finditer(text):
        kind, value = piece.lastgroup, piece.group()
        if kind == "unclosed":
            return Open.LINE
        if kind == "bracket":
            depth = max(0, depth + (1 if value in "([{" else -1))
        elif kind == "line":
            block = block or (last == ":" and depth == 0)
        if kind not in ("blank", "comment", "line"):
            last = value[-1]
    if depth or last in (",", "\\"):
        return Open.LINE
    return Open.BLOCK if block or last == ":" else Open.NO


def parted(text: str) -> list[str]:
    """Return the parts of a text between its commas; commas inside brackets and strings do not separate."""
    depth, ends = 0, []
    for piece in _PIECE.finditer(text):
        kind, value = piece.lastgroup, piece.group()
        if kind == "bracket":
            depth += 1 if value in "([{" else -1
        elif kind == "other" and depth == 0:
            ends += [piece.start() + place for place, letter in enumerate(value) if letter == ","]
    return [text[start + 1 : end].strip() for start, end in pairwise([-1, *ends, len(text)])]


def is_command(text: str) -> bool:
    """Return whether a chunk is a command to the session and no part of the scenario."""
    return text.lstrip().startswith(":") or text.strip() in BARE_COMMANDS


def is_whole(text: str) -> bool:
    """Return whether the typed text can be entered: a block once a blank line or a dedented one ends it."""
    if is_command(text) and "\n" not in text.strip():
        return True
    lines = text.split("\n")
    match openness(text):
        case Open.LINE:
            return len(lines) > 1 and not lines[-1].strip() and not lines[-2].strip()
        case Open.BLOCK:
            return len(lines) > 1 and (not lines[-1].strip() or _dedents(lines[-1]))
    return True


def _dedents(line: str) -> bool:
    return line[:1] not in (" ", "\t", "") and not CONTINUING.match(line) and not line.rstrip().endswith(":")


@dataclass
class ChunkReader:
    """Chunks out of single lines. `readline` answers as that of files does: an empty text at the end."""

    readline: Callable[[], str]
    prompt: Callable[[bool], None]
    """Callback before a line is read; its argument is whether the line continues a chunk."""
    blank_ends: bool
    """Whether a blank line ends a block, as people type; in files, blocks have blank lines inside."""
    read_ahead: list[str] = field(default_factory=list)
    """A line that was read too far."""

    def read(self) -> str | None:
        """The next chunk; None at the end."""
        lines: list[str] = []
        while True:
            line = self._line(bool(lines))
            if line is None:
                return "\n".join(lines).rstrip("\n") if lines else None
            if self._is_next(lines, line):
                self.read_ahead.append(line)
                return "\n".join(lines).rstrip("\n")
            if not lines and not line.strip():
                continue
            lines.append(line)
            if self._ends(lines):
                return "\n".join(lines).rstrip("\n")

    def _line(self, more: bool) -> str | None:
        if self.read_ahead:
            return self.read_ahead.pop()
        self.prompt(more)
        line = self.readline()
        return line.rstrip("\r\n") if line else None

    def _is_next(self, lines: list[str], line: str) -> bool:
        """Return whether a line is the beginning of another chunk."""
        if not lines or not line.strip():
            return False
        if _only_comments(lines):
            return is_command(line)
        text = "\n".join(lines)
        at_edge = line[0] not in " \t" and not CONTINUING.match(line)
        return openness(text) is Open.BLOCK and at_edge

    def _ends(self, lines: list[str]) -> bool:
        """Return whether the chunk is complete with its last line."""
        if is_command(lines[0]) and len(lines) == 1:
            return True
        if _only_comments(lines):
            return self.blank_ends
        match openness("\n".join(lines)):
            case Open.LINE:
                return False
            case Open.BLOCK:
                return self.blank_ends and not lines[-1].strip()
        return True


def _only_comments(lines: list[str]) -> bool:
    return all(not line.strip() or line.lstrip().startswith("#") for line in lines)


# -- input without editing: from a pipe, or from a terminal that can do nothing ----------------------------------------

PROMPT, MORE = "scn> ", "...  "


@dataclass
class PlainInput:
    """Chunks from standard input; prompts only where that is a terminal."""

    state: State

    def __post_init__(self) -> None:
        self._reader = ChunkReader(sys.stdin.readline, self._prompt, blank_ends=self.state.interactive)

    def read(self) -> str | None:
        self._show_proposal()
        try:
            chunk = self._reader.read()
        except KeyboardInterrupt:
            self._say("\n")
            raise
        if chunk is None:
            self._say("\n")
        return chunk

    def _show_proposal(self) -> None:
        """There is no putting of text into a line here: it is shown, and the next chunk replaces it."""
        proposal, self.state.proposal = self.state.proposal, ""
        if proposal and self.state.interactive:
            self.state.terminal.out.print(proposal, soft_wrap=True)
            self.state.terminal.out.print("what you enter next replaces it", style="quiet")

    def _prompt(self, more: bool) -> None:
        self._say(MORE if more else PROMPT)

    def _say(self, text: str) -> None:
        if self.state.interactive:
            sys.stdout.write(text)
        sys.stdout.flush()
