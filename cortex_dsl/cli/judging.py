"""Parts of the commands that judge drivers, `test`, `compare` and `suite`: values of options, outputs, progress,
computing time, and exit codes.
"""

import os
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from shlex import join
from typing import TYPE_CHECKING, Any

from cortex_dsl.console.terminal import Exit, Terminal, UsageError, gravest
from cortex_dsl.console.user_files import check_writable

if TYPE_CHECKING:
    from cortex_dsl.api.scenario import Scenario
    from cortex_dsl.report.blocks import Title
    from cortex_dsl.report.terminal.gate_view import GateProgress


@contextmanager
def usage_errors() -> Generator[None]:
    """Turn a mistake on the command line or in a path into a UsageError."""
    from cortex_dsl.api.baseline import BaselineError
    from cortex_dsl.api.contenders import NotComparableError
    from cortex_dsl.api.scenario_files import NoSuchPathError
    from engine.errors import ArgumentError, InterchangeError, UnreadableFileError
    from engine.extras import MissingExtraError
    from engine.search.store import StoreError
    from engine.search.workers import WorkersLostError

    solvable = (
        ArgumentError,
        BaselineError,
        InterchangeError,
        MissingExtraError,
        NoSuchPathError,
        NotComparableError,
        StoreError,
        UnreadableFileError,
        WorkersLostError,
    )
    try:
        yield
    except solvable as error:
        raise UsageError(error.message, error.cure) from error


def read_by(name: str, *others: str) -> Callable[[str], Any]:
    """Return the parser of a value by a function of `cortex_dsl.api.limits`, to which `others` are passed, too."""

    def parse(text: str) -> Any:
        from cortex_dsl.api import limits

        with usage_errors():
            return getattr(limits, name)(text, *others)

    return parse


def check_output(path: Path | None) -> None:
    """Check that a file can be written, before anything runs.

    Raises:
        UsageError: it cannot.
    """
    if path is None:
        return
    if path.is_dir():
        raise UsageError(f"cannot write `{path}`: it is a folder", "name a file")
    if not path.parent.is_dir():
        raise UsageError(f"cannot write `{path}`: there is no folder `{path.parent}`", "make it, or name another one")
    check_writable(path)


def print_results(view: "Title", out: Path | None, terminal: Terminal) -> None:
    """Print a view, and the folder of the results if there is one."""
    from cortex_dsl.report.terminal.render import rendered

    terminal.out.print(rendered(view, terminal.out.width, ascii_only=terminal.out.options.ascii_only))
    if out is not None:
        terminal.out.print(f"results: {out}", style="quiet", soft_wrap=True)


WITHOUT_EFFECT = ("--jobs", "--out", "--junit", "--summary", "--format", "--table")
"""Options with a value that change no result."""


def command_of(name: str, words: Sequence[str]) -> str:
    """Return the command that gives the same results, from the words as typed."""
    kept: list[str] = []
    skip = False
    for word in words:
        if skip or word in ("--json", "--no-colour"):
            skip = False
        elif word in WITHOUT_EFFECT:
            skip = True
        elif word.partition("=")[0] not in WITHOUT_EFFECT:
            kept.append(word)
    return join(["cortexc", name, *kept])


def cpu_seconds() -> float:
    """Return the CPU time of this process and of its processes that have ended [s]."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def effort_file(started: float) -> dict[str, bytes]:
    """Return `effort.json` by its name: computing time since `started` (of `cpu_seconds`), versions and platform.

    It is a file of its own, so that equal commands give equal documents.
    """
    from cortex_dsl.report.documents import EFFORT, document
    from engine.search.manifest import machine, versions_of

    content = {
        "cpu_seconds": cpu_seconds() - started,
        "versions": versions_of(),
        "platform": machine(),
    }
    return {EFFORT: f"{document('effort', content)}\n".encode()}


def judged_exit(applies: Mapping[Exit, object], *, interrupted: bool) -> Exit:
    """Return the gravest exit code that applies; what was interrupted has no verdict."""
    return Exit.INTERRUPTED if interrupted else gravest(code for code, holds in applies.items() if holds)


def compiling(progress: "GateProgress", terminal: Terminal) -> "Callable[[Scenario], None]":
    """Return a callback that compiles the kernels of a scenario before its first run, beside the progress."""
    from cortex_dsl.console.kernels import SEARCH, compile_kernels, find_missing_kernels

    def prepare(scenario: "Scenario") -> None:
        if find_missing_kernels(SEARCH, scenario.program, scenario.config) is not None:
            with progress.paused():
                compile_kernels(terminal, SEARCH, scenario.program, scenario.config)

    return prepare
