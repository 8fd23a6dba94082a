"""Input without editing: from a pipe, or from a terminal that can do nothing."""

import sys
from dataclasses import dataclass

from cortex_dsl.repl.desk import Desk
from cortex_dsl.repl.reading import ChunkReader

PROMPT, MORE = "scn> ", "...  "


@dataclass
class PlainInput:
    """Chunks from standard input; prompts only where somebody sits there."""

    desk: Desk

    def __post_init__(self) -> None:
        self._reader = ChunkReader(sys.stdin.readline, self._prompt, blank_ends=self.desk.interactive)

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
        proposal, self.desk.proposal = self.desk.proposal, ""
        if proposal and self.desk.interactive:
            self.desk.terminal.out.print(proposal, soft_wrap=True)
            self.desk.terminal.out.print("what you enter next replaces it", style="quiet")

    def _prompt(self, more: bool) -> None:
        self._say(MORE if more else PROMPT)

    def _say(self, text: str) -> None:
        if self.desk.interactive:
            sys.stdout.write(text)
        sys.stdout.flush()
