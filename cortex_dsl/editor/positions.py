"""Character offsets and the positions of the language server protocol, which counts in units of an encoding."""

import re
from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property

_BREAK = re.compile(r"\r\n|\r|\n")


@dataclass(frozen=True)
class Positions:
    """One text. Lines and columns count from 0; a column counts units of `encoding`: `utf-8`, `utf-16` or `utf-32`."""

    text: str
    encoding: str = "utf-16"

    @cached_property
    def starts(self) -> tuple[int, ...]:
        return (0, *(found.end() for found in _BREAK.finditer(self.text)))

    def position(self, offset: int) -> tuple[int, int]:
        offset = max(0, min(offset, len(self.text)))
        line = bisect_right(self.starts, offset) - 1
        return line, sum(map(self.units, self.text[self.starts[line] : offset]))

    def offset(self, line: int, column: int) -> int:
        """The nearest offset: positions beyond the end of a line are at its end."""
        if line >= len(self.starts):
            return len(self.text)
        start = self.starts[line]
        following = _BREAK.search(self.text, start)
        end = following.start() if following else len(self.text)
        for offset in range(start, end):
            if column <= 0:
                return offset
            column -= self.units(self.text[offset])
        return end

    def units(self, character: str) -> int:
        code = ord(character)
        if self.encoding == "utf-32":
            return 1
        if self.encoding == "utf-8":
            return 1 + (code > 0x7F) + (code > 0x7FF) + (code > 0xFFFF)
        return 1 + (code > 0xFFFF)
