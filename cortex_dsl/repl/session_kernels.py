"""The kernels of a session: compiled while the user types, or when a command needs them, and counted meanwhile."""

import threading
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from engine.program import Program

if TYPE_CHECKING:
    from cortex_dsl.api.scenario import Scenario
    from cortex_dsl.console.kernels import MissingKernels
    from cortex_dsl.console.terminal import Terminal
    from engine.config import Config

TINY = """map intersection(ways=4)
param V = Range(1, 9) m/s
ego = new Car on road, with speed V
require V > 2 m/s
terminate after 1 s
"""
"""A scenario that needs the kernels of every scenario."""
PATIENCE, PULSE = 0.6, 0.1
"""Time after which a wait is explained, and between two looks at its end [s]."""
SESSION = ("sample", "weigh", "simulate", "blame")
"""Parts of `engine.compiling_apart.PARTS` that a session calls."""


@dataclass
class Kernels:
    """Kernels that are compiled in the background from `start` on, or when they are first needed."""

    thread: threading.Thread | None = None
    missing: "MissingKernels | None" = None
    """Kernels that are being compiled in the background."""
    left: threading.Event = field(default_factory=threading.Event)
    """Set when the session ends."""
    failed: list[BaseException] = field(default_factory=list)
    heard: ExitStack = field(default_factory=ExitStack)
    listening: bool = False
    told: bool = False
    """Whether the present command has said that it waits."""

    def start(self) -> None:
        self.thread = threading.Thread(target=self._work, daemon=True)
        self.thread.start()

    @property
    def ready(self) -> bool:
        """Return whether no work is left to wait for; without a background, work is done when it is needed."""
        return self.thread is None or not self.thread.is_alive()

    def stop(self) -> None:
        """End the processes that compile, as the session ends."""
        self.left.set()
        while self.thread is not None and self.missing is not None:
            self.thread.join(PULSE)

    def wait(
        self,
        terminal: "Terminal",
        parts: tuple[str, ...] = (),
        program: Program | None = None,
        config: "Config | None" = None,
    ) -> None:
        """Wait for the background, then compile the remaining `parts` of `engine.compiling_apart.PARTS`.

        Ctrl-C ends the waiting, and not the work of the background.
        """
        from cortex_dsl.console.kernels import compile_kernels

        self.listen(terminal)
        if self.thread is not None:
            self._wait_for(self.thread, terminal)
        if compile_kernels(terminal, parts, program, config):
            self.told = True

    def _wait_for(self, thread: threading.Thread, terminal: "Terminal") -> None:
        from cortex_dsl.console.kernels import show_compilation

        thread.join(PATIENCE)
        if thread.is_alive():
            self.told = True
            if self.missing is None:
                terminal.err.print("loading kernels …", style="quiet")
        while thread.is_alive():
            if (missing := self.missing) is not None:
                with show_compilation(terminal, missing) as progress:
                    while self.missing is not None:
                        thread.join(PULSE)
                        progress.tell()
            thread.join(PULSE)

    def listen(self, terminal: "Terminal") -> None:
        """Until the command is over, say so once when it has to wait for a kernel that is in no cache."""
        if self.listening:
            return
        from cortex_dsl.report.terminal.kernel_progress import COMPILING
        from engine.compiling import before_compiling

        def tell() -> None:
            if not self.told and threading.current_thread() is not self.thread:
                self.told = True
                terminal.err.print(COMPILING, style="quiet")

        self.heard.enter_context(before_compiling(tell))
        self.listening = True

    def over(self) -> None:
        """A command is done."""
        self.heard.close()
        self.listening = self.told = False

    def _work(self) -> None:
        try:
            from cortex_dsl.api.loading import compile_text

            scenario = compile_text(TINY)
            self._compile(scenario)
            warm_up(scenario)
        except BaseException as error:  # the code that needs a kernel gets the same error and shows it
            self.failed.append(error)

    def _compile(self, scenario: "Scenario") -> None:
        """Compile in processes of their own, so that Python answers each key meanwhile."""
        from cortex_dsl.console.kernels import find_missing_kernels
        from engine.compiling_apart import compile_apart

        self.missing = find_missing_kernels(SESSION, scenario.program, scenario.config)
        try:
            if self.missing is not None:
                compile_apart(self.missing.demand, self.missing.folder, self._go_on)
        finally:
            self.missing = None

    def _go_on(self) -> None:
        if self.left.is_set():
            raise SystemExit


def warm_up(scenario: "Scenario") -> None:
    """Load, or compile, all that a session calls."""
    from engine.acceptance import measure_acceptance
    from engine.avoidability import avoidability

    measure_acceptance(scenario.program, 1)
    scenes = scenario.sample(1)
    scenario.simulate(scenes)
    scenario.watch(scenes)
    avoidability(scenario.program, scenes, scenario.config.simulation)
