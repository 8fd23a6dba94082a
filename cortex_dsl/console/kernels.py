"""Compile kernels before a command needs them, and show the progress to the user."""

import time
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from cortex_dsl.console.terminal import Terminal
from engine.config import Config
from engine.program import Program

if TYPE_CHECKING:
    from cortex_dsl.report.terminal.kernel_progress import KernelProgress
    from engine.compiling_apart import KernelDemand

SAMPLE, SEARCH, RUN = ("sample", "weigh"), ("sample", "simulate", "blame"), ("sample", "simulate", "metrics")
METRICS, PAIRS = ("metrics",), ("pairs",)
"""Work of commands, as names of `engine.compiling_apart.PARTS`."""


@dataclass(frozen=True)
class MissingKernels:
    """Kernels that a command will call, and that are stored nowhere."""

    demand: "KernelDemand"
    folders: tuple[Path, ...]
    """The cache of this version, and the folder of the kernels that the package carries, if there is one."""
    count: int
    started: float = field(default_factory=time.monotonic)
    """Time at which the compilation begins [s], by the monotonic clock."""

    @property
    def folder(self) -> Path:
        """Return the cache of this version."""
        return self.folders[0]

    def still_missing(self) -> int:
        """Return the number of kernels that are stored nowhere yet."""
        from engine.compiling_apart import missing_kernels

        return missing_kernels(self.demand, self.folders)


def compile_kernels(
    terminal: Terminal, parts: tuple[str, ...], program: Program | None = None, config: Config | None = None
) -> bool:
    """Compile now the kernels that a command will call, so that pace and remaining time exclude that.

    `program`: the program to sample or simulate; None for recordings. Returns True if kernels were missing.
    """
    from engine.compiling_apart import compile_apart

    if (missing := find_missing_kernels(parts, program, config)) is None:
        return False
    with show_compilation(terminal, missing) as progress:
        compile_apart(missing.demand, missing.folder, progress.tell)
    return True


def find_missing_kernels(
    parts: tuple[str, ...], program: Program | None = None, config: Config | None = None
) -> MissingKernels | None:
    """Return the kernels that are stored neither in the cache nor in the package; None if all of them are."""
    from engine.compiling_apart import PARTS, KernelDemand, missing_kernels
    from engine.kernels.jit import cache_folder, packaged

    carried = packaged()
    folders = (cache_folder(), *([carried.folder] if carried else []))
    demand = KernelDemand(tuple(PARTS[name] for name in parts), program, replace(config or Config(), driver=None))
    count = missing_kernels(demand, folders)
    return MissingKernels(demand, folders, count) if count else None


@contextmanager
def show_compilation(terminal: Terminal, missing: MissingKernels) -> Generator["KernelProgress"]:
    """Count the kernels while the block waits for them, and warn of a cache that does not keep them."""
    from cortex_dsl.report.terminal.kernel_progress import COMPILING, KernelProgress
    from engine.compiling_apart import count_kernels
    from engine.user_cache import cache_roots

    folder, first_root = missing.folder, next(cache_roots(), None)
    terminal.err.print(COMPILING, style="quiet")
    if first_root is not None and folder.parent != first_root:
        why = f"kernels are stored in {folder}: {first_root} cannot be written, is full or belongs to another user"
        terminal.note(why, "warn")
    with KernelProgress(terminal.err, missing.count, missing.still_missing, started=missing.started) as progress:
        yield progress
    if not count_kernels(folder):
        why = f"compiled kernels could not be stored in {folder}: each start compiles them again"
        terminal.note(why, "warn")
