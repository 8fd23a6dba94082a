"""A console that shows texts without effects: text from an untrusted file does not act on the terminal.

All output of views passes `render`, in pieces of text with a style. Styles and the moves of a progress line are ours;
texts may come from anywhere: escape sequences, C1 controls, characters that turn the direction of writing. It is a
module of its own, as rich is imported with the first drawn view.
"""

from collections.abc import Iterable
from typing import Any

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment

from cortex_dsl.plain_text import harmless


class HarmlessConsole(Console):
    """A console of rich; controls in a text become U+FFFD."""

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        """Pieces of text and controls, as rich makes them."""
        for piece in super().render(renderable, options):
            yield piece if piece.control or piece.text.isprintable() else Segment(harmless(piece.text), piece.style)

    def print(self, *objects: Any, crop: bool = False, **settings: Any) -> None:  # type: ignore[override]
        """Print objects; lines that may not be broken, such as commands to copy, are whole."""
        super().print(*objects, crop=crop, **settings)

    def on_broken_pipe(self) -> None:
        """Pass the error on to the command, which ends as after any other output; rich would end it with 1."""
        raise BrokenPipeError
