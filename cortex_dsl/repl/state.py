"""The state of a session: the one mutable object that entries and commands work on.

It contains the draft, its diagnostics, the results of the last search, and the kernels that the session compiles.
"""

import threading
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from cortex_dsl.console.terminal import Terminal, UsageError
from cortex_dsl.diagnostics import CompileError, Diagnostic, Severity
from cortex_dsl.pipeline import Compiled, compile_source
from cortex_dsl.repl.draft import Draft, History
from cortex_dsl.report.terminal.diagnostics_view import print_diagnostics
from cortex_dsl.semantics.errors.names import DEAD_GENE, EMPTY_FILE, UNUSED_BEHAVIOUR, UNUSED_GENE, UNUSED_NAME
from cortex_dsl.semantics.errors.runs import UNUSED_MONITOR
from cortex_dsl.semantics.errors.scene import DEFAULT_MAP, NO_EGO
from cortex_dsl.source import Source
from cortex_dsl.syntax.reading import decode
from engine.program import Program

if TYPE_CHECKING:
    from cortex_dsl.api.scenario import Scenario
    from cortex_dsl.console.kernels import MissingKernels
    from cortex_dsl.console.terminal import Terminal
    from cortex_dsl.report.findings.cases_found import CaseFound
    from engine.acceptance import AcceptanceStatistics
    from engine.config import Config
    from engine.search.campaign import Campaign


# -- kernels of a session ----------------------------------------------------------------------------------------------


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
    reported: bool = False
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
            self.reported = True

    def _wait_for(self, thread: threading.Thread, terminal: "Terminal") -> None:
        from cortex_dsl.console.kernels import show_compilation

        thread.join(PATIENCE)
        if thread.is_alive():
            self.reported = True
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
            if not self.reported and threading.current_thread() is not self.thread:
                self.reported = True
                terminal.err.print(COMPILING, style="quiet")

        self.heard.enter_context(before_compiling(tell))
        self.listening = True

    def over(self) -> None:
        """A command is done."""
        self.heard.close()
        self.listening = self.reported = False

    def _work(self) -> None:
        try:
            from cortex_dsl.api.scenario import compile_text

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
    scenes = scenario.scene_of_seed()
    scenario.simulate(scenes)
    scenario.watch(scenes)
    avoidability(scenario.program, scenes, scenario.config.simulation)


# -- a draft, compiled: its errors, and parts that are merely still missing --------------------------------------------

STILL_TO_COME = (NO_EGO.code, EMPTY_FILE.code)
OF_THE_WHOLE = (
    DEFAULT_MAP.code,
    UNUSED_BEHAVIOUR.code,
    UNUSED_MONITOR.code,
    UNUSED_GENE.code,
    DEAD_GENE.code,
    UNUSED_NAME.code,
)
"""Remarks that make sense when a scenario is complete."""
STAND_IN = "\nego = new Car on road, with regionContainedIn None\n"
"""Takes the place of an ego that is still to come, so that requirements on params alone can be tested."""


@dataclass(frozen=True)
class Checked:
    """A draft with the diagnostics of the compiler."""

    draft: Draft
    source: Source
    compiled: Compiled | None = None
    errors: tuple[Diagnostic, ...] = ()
    remarks: tuple[Diagnostic, ...] = ()
    """Warnings and notes."""
    missing: bool = False
    """Whether there is no ego yet."""
    overrides: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def weighable(self) -> Program | None:
        """The program on which requirements can be tested; None where there is none."""
        if self.compiled is not None:
            return self.compiled.program
        waits = self.missing and not self.errors and self.source.text
        return _with_stand_in(self.source, self.overrides) if waits else None


def check(draft: Draft, name: str, overrides: Mapping[str, str]) -> Checked:
    """Compile a draft; `overrides` are params that are held. Mistakes of the overrides are errors, too."""
    if not draft.text.strip():
        return Checked(draft, Source(name, ""), missing=True, overrides=overrides)
    try:
        source = decode(name, draft.text.encode("utf-8", errors="replace"))
        compiled = compile_source(source, overrides)
    except CompileError as error:
        return _failed(draft, error, overrides)
    return Checked(draft, compiled.source, compiled, (), compiled.diagnostics, overrides=overrides)


def _failed(draft: Draft, error: CompileError, overrides: Mapping[str, str]) -> Checked:
    grave = tuple(d for d in error.diagnostics if d.severity is Severity.ERROR)
    remarks = tuple(d for d in error.diagnostics if d.severity is not Severity.ERROR)
    wrong = tuple(d for d in grave if d.code not in STILL_TO_COME)
    return Checked(draft, error.source, None, wrong, remarks, len(wrong) < len(grave), overrides)


def _with_stand_in(source: Source, overrides: Mapping[str, str]) -> Program | None:
    try:
        return compile_source(Source(source.name, source.text + STAND_IN), overrides).program
    except CompileError:
        return None


def new_errors(before: Checked, after: Checked) -> tuple[Diagnostic, ...]:
    """Return the errors that the draft did not have before.

    A file that is loaded with errors can be corrected one by one.
    """
    known = {(d.code, d.message) for d in before.errors}
    return tuple(d for d in after.errors if (d.code, d.message) not in known)


def remarks_on(checked: Checked, index: int) -> list[Diagnostic]:
    """Return the warnings and notes about the lines of one entry."""
    first, last = checked.draft.first_lines[index : index + 2]
    fitting = (d for d in checked.remarks if d.severity is not Severity.HINT and d.code not in OF_THE_WHOLE)
    return [d for d in fitting if first <= checked.source.row(d.label.span.start) < last]


# -- results of a search -----------------------------------------------------------------------------------------------


@dataclass
class LastSearch:
    """A search, and the scenario as it was then."""

    scenario: "Scenario"
    campaign: "Campaign"
    draft: Draft
    settings: str
    """How it was searched, in one line."""
    known: "tuple[CaseFound, ...] | None" = None
    """Facts about its worst cases, once they are requested."""


# -- the state ---------------------------------------------------------------------------------------------------------

UNNAMED = "session"
"""Name in messages of a scenario that is in no file."""
LIKE = "such as `ego = new Car on road`"


@dataclass
class State:
    """Everything that a session knows."""

    terminal: Terminal
    interactive: bool = False
    """Whether a user can answer questions."""
    history: History = field(default_factory=History)
    file: Path | None = None
    on_disk: str = ""
    """Text of the file when the session last read or wrote it."""
    saved: Draft = field(default_factory=Draft)
    """The draft that is in the file."""
    overrides: Mapping[str, str] = field(default_factory=dict)
    """Params that are held."""
    seed: int = 0
    scenes_tried: int = 0
    """Draws of the params that `:scene` has looked at, those without a scene among them."""
    scenes_shown: int = 0
    """How many scenes of the present draft were looked at."""
    editing: int | None = None
    """The entry that the next chunk takes the place of."""
    proposal: str = ""
    """Text to put into the next prompt."""
    kernels: Kernels = field(default_factory=Kernels)
    mistakes: int = 0
    """Entries and commands that were refused."""
    bugs: int = 0
    found: LastSearch | None = None
    """Results of the last search."""
    no_scene: bool = False
    """Whether the last command that needed a scene found none."""
    leaving: bool = False
    _checked: Checked | None = None
    _weighings: "list[AcceptanceStatistics]" = field(default_factory=list)

    @property
    def draft(self) -> Draft:
        return self.history.present

    @property
    def name(self) -> str:
        return UNNAMED if self.file is None else str(self.file)

    @property
    def unsaved(self) -> bool:
        return self.draft != self.saved

    @property
    def checked(self) -> Checked:
        """Return the diagnostics of the present draft."""
        if self._checked is None or self._checked.draft != self.draft:
            self._checked = check(self.draft, self.name, self.overrides)
        return self._checked

    def adopt(self, history: History, checked: Checked | None = None) -> None:
        """Go on with another draft."""
        self.history = history
        self._checked = checked
        self.scenes_tried = self.scenes_shown = 0

    def hold(self, overrides: Mapping[str, str], checked: Checked) -> None:
        """Go on with other params held."""
        self.overrides = overrides
        self._checked = checked
        self.scenes_tried = self.scenes_shown = 0

    def weighing(self, program: "Program") -> "AcceptanceStatistics":
        """Return the acceptance of a program's requirements on 10,000 draws; the last programs are cached."""
        for known in self._weighings:
            if known.program is program:
                return known
        from engine.acceptance import measure_acceptance

        weighing = measure_acceptance(program, seed=self.seed)
        self._weighings = [*self._weighings[-2:], weighing]
        return weighing

    def forget_weighings(self) -> None:
        self._weighings = []

    @property
    def acceptance(self) -> float | None:
        """Share of draws that the draft accepts; None while it is not known."""
        program = self.checked.weighable
        return self.weighing(program).acceptance if program is not None and self.kernels.ready else None

    def scenario(self, parts: tuple[str, ...]) -> "Scenario":
        """The draft, ready for `parts` of `engine.compiling_apart.PARTS`.

        Raises:
            UsageError: it is not complete.
        """
        compiled = self.checked.compiled
        if compiled is None:
            raise self.not_ready()
        return self.scenario_of(compiled, parts)

    def scenario_of(self, compiled: Compiled, parts: tuple[str, ...]) -> "Scenario":
        """A compiled text by the settings of the session, once the kernels are there."""
        from cortex_dsl.api.scenario import Scenario, in_file
        from engine.config import Config, SimulationConfig

        config = Config(simulation=in_file(SimulationConfig(), compiled.program.settings))
        self.kernels.wait(self.terminal, parts, compiled.program, config)
        return Scenario(compiled, config, self.overrides)

    def not_ready(self) -> UsageError:
        """Return why no scene can be sampled yet."""
        if self.checked.errors:
            return UsageError("the scenario has errors", "`:check` shows them, `:edit N` corrects an entry")
        return UsageError("still to come: an ego", LIKE)


def refuse(state: State, source: Source, diagnostics: Sequence[Diagnostic]) -> None:
    """Show the errors."""
    state.mistakes += 1
    state.terminal.out.file.flush()
    print_diagnostics(source, diagnostics, state.terminal.err)


def whole_number(text: str, default: int, what: str, most: int) -> int:
    """A count from 1 to `most`; without a text the default.

    Raises:
        UsageError: the text is no such count.
    """
    digits = text.replace(",", "").replace("_", "")
    if not text:
        return default
    if not digits.isascii() or not digits.isdigit() or not 1 <= int(digits[:12]) <= most:
        raise UsageError(f"{what} must be a whole number from 1 to {most:,}, not `{text}`")
    return int(digits)
