"""Progress of compiling kernels: a line that is redrawn on a terminal, a line for each kernel elsewhere."""

import re
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from types import TracebackType

from rich.console import Console, RenderableType
from rich.live import Live
from rich.text import Text

COMPILING = "compiling the kernels that this command needs, once for each version …"
COMPILED = re.compile(rf"(?:{re.escape(COMPILING)}|kernels: \d+ of \d+, \d+ s)\n")
"""All that is written without a terminal while kernels are compiled."""


@dataclass
class KernelProgress:
    """Shows how many kernels are compiled, and for how long."""

    console: Console
    missing: int
    """Kernels that are expected. Kernels that others call are compiled with their callers and not counted."""
    still_missing: Callable[[], int]
    """Count of expected kernels that are not compiled yet."""
    kernels: int = 0
    """Kernels that have been compiled."""
    started: float = field(default_factory=time.monotonic)
    _live: Live | None = None

    def __enter__(self) -> "KernelProgress":
        if self.console.is_terminal:
            self._live = Live(console=self.console, transient=True, refresh_per_second=2, get_renderable=self._line)
            self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._live is not None:
            self._live.stop()
        self.tell()

    def tell(self) -> None:
        """Count the expected kernels that are compiled."""
        reported, self.kernels = self.kernels, self.missing - self.still_missing()
        if self._live is None and self.kernels != reported:
            self.console.print(self._line())

    def _line(self) -> RenderableType:
        seconds = time.monotonic() - self.started
        return Text(f"kernels: {self.kernels} of {self.missing}, {seconds:.0f} s", "quiet")
