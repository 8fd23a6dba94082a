"""Compiling kernels while the user types, since the very first time takes half a minute."""

import threading
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cortex_dsl.cli.terminal import Terminal

TINY = """map intersection(ways=4)
param V = Range(1, 9) m/s
ego = new Car on road, with speed V
require V > 2 m/s
terminate after 1 s
"""
"""A scenario that needs every kernel."""


PATIENCE = 0.6
"""Seconds of waiting after which a word is due."""


@dataclass
class Kernels:
    """Kernels that are compiled in the background from `start` on, or by whoever needs them first."""

    thread: threading.Thread | None = None
    cold: bool = False
    """Whether they have to be compiled, not only loaded."""
    failed: list[BaseException] = field(default_factory=list)

    def start(self) -> None:
        self.thread = threading.Thread(target=self._work, daemon=True)
        self.thread.start()

    @property
    def ready(self) -> bool:
        """Whether nothing has to be waited for; without a background, work is done when it is needed."""
        return self.thread is None or not self.thread.is_alive()

    def wait(self, terminal: "Terminal") -> None:
        """Until they are there; Ctrl-C ends the waiting, not the work."""
        if self.thread is None:
            self._announce(terminal)
            return
        self.thread.join(PATIENCE)
        if self.thread.is_alive():
            what = "compiling kernels (once, about half a minute)" if self.cold else "loading kernels"
            terminal.err.print(f"{what} …", style="quiet")
        while self.thread.is_alive():
            self.thread.join(0.1)

    def _announce(self, terminal: "Terminal") -> None:
        """Nothing was begun: whoever waits will compile, which is said once."""
        from cortex_dsl.cli.simulation import announce_compilation

        self.cold = self.cold or announce_compilation(terminal)

    def _work(self) -> None:
        try:
            from engine.kernels.jit import kernels_are_cached

            self.cold = not kernels_are_cached()
            warm_up()
        except BaseException as error:  # whoever needs a kernel meets the same error and tells it
            self.failed.append(error)


def warm_up() -> None:
    """Load, or compile, all that a session calls."""
    from cortex_dsl.api.scenario import compile_text
    from engine.blame import weigh

    scenario = compile_text(TINY)
    weigh(scenario.program, 1)
    scenes = scenario.sample(1)
    scenario.simulate(scenes)
    scenario.watch(scenes)
