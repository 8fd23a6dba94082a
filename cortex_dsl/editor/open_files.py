"""Files that are open in the editor, each with its latest text and its analysis; positions in them."""

import asyncio
import logging
import re
from bisect import bisect_right
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from cortex_dsl.editor.analysis import Analysis, View, analyse
from cortex_dsl.files import Folder
from cortex_dsl.semantics.model.context import Cancelled
from cortex_dsl.source import Source
from cortex_dsl.syntax.reading import decode

# -- Character offsets and the positions of the language server protocol, which counts in units of an encoding ---------

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


# -- Open files --------------------------------------------------------------------------------------------------------

_LOG = logging.getLogger(__name__)
PAUSE = 0.15
"""Seconds without a keystroke after which a text is compiled."""
PATIENCE = 2.0
"""Seconds that a request waits for the compilation of the text that it is about."""


@dataclass(frozen=True)
class Buffers(Folder):
    """The files of this computer, as they are in the editor where it has them open."""

    texts: Mapping[str, str] = field(default_factory=dict)
    """Texts by identity."""

    def read(self, name: str) -> Source:
        text = self.texts.get(self.identity(name))
        return super().read(name) if text is None else decode(name, text.encode("utf-8", errors="replace"))


@dataclass
class OpenFile:
    """One file. Its text is replaced with every change; `generation` counts them."""

    uri: str
    name: str
    text: str
    generation: int = 0
    latest: Analysis = field(default_factory=lambda: Analysis(Source("", "")))
    """Analysis of the last compiled text."""
    tree: Analysis = field(default_factory=lambda: Analysis(Source("", "")))
    """Analysis of the last text with a syntax tree."""
    checking: "asyncio.Task[None] | None" = None
    closed: bool = False
    files: Buffers = Buffers()
    """Source of its imports."""
    _view: View | None = None

    @property
    def view(self) -> View:
        """Return the present text with its analysis; the same object until one of them changes."""
        if self._view is None or self._view.text is not self.text or self._view.analysis is not self.tree:
            self._view = View(self.name, self.text, self.tree, self.files)
        return self._view

    def positions(self, encoding: str) -> Positions:
        return Positions(self.text, encoding)

    def change(self, text: str) -> None:
        self.text = text
        self.generation += 1

    def imports(self, other: "OpenFile") -> bool:
        """Return whether it imported another file at its last compilation."""
        read = {self.files.identity(each.name) for each in self.latest.source.imported}
        return self.files.identity(other.name) in read

    def check(self, publish: Callable[["OpenFile"], None], pause: float = PAUSE) -> None:
        """Compile the text soon, off the loop, and call `publish`; a compilation of an older text is dropped."""
        if self.checking is not None:
            self.checking.cancel()
        self.checking = asyncio.create_task(self._check(self.generation, publish, pause))

    async def _check(self, generation: int, publish: Callable[["OpenFile"], None], pause: float) -> None:
        def superseded() -> bool:
            return self.closed or self.generation != generation

        await asyncio.sleep(pause)
        try:
            found = await asyncio.to_thread(analyse, self.name, self.text, superseded, self.files)
        except Cancelled:
            return
        except Exception:
            _LOG.exception("a bug in cortexc, not in %s; please report it", self.name)
            return
        if superseded():
            return
        self.latest = found
        self.tree = found if found.module is not None else self.tree
        publish(self)

    async def settled(self) -> View:
        """The view once its text is compiled, or as it is when that takes too long."""
        if self.checking is not None and not self.checking.done():
            await asyncio.wait({self.checking}, timeout=PATIENCE)
        return self.view
