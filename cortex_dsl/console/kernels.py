"""Compile kernels before a command needs them, and show the user what it waits for."""

from dataclasses import replace

from cortex_dsl.console.terminal import Terminal
from engine.config import Config
from engine.program import Program

SAMPLE, SEARCH, RUN = ("sample", "weigh"), ("sample", "simulate", "blame"), ("sample", "simulate", "metrics")
METRICS, PAIRS = ("metrics",), ("pairs",)
"""What commands do, as names of `engine.compiling_apart.PARTS`."""


def compile_kernels(
    terminal: Terminal, parts: tuple[str, ...], program: Program | None = None, config: Config | None = None
) -> None:
    """Compile now what a command will call, so that pace and remaining time are shown without that.

    `program`: what will be sampled or simulated; None for recordings.
    """
    from engine.compiling_apart import PARTS, KernelDemand, compile_apart, count_kernels, missing_kernels
    from engine.kernels.jit import cache_folder, packaged
    from engine.user_cache import cache_roots

    folder, first_root, carried = cache_folder(), next(cache_roots(), None), packaged()
    demand = KernelDemand(tuple(PARTS[name] for name in parts), program, replace(config or Config(), driver=None))
    if not (missing := missing_kernels(demand, [folder, *([carried.folder] if carried else [])])):
        return
    from cortex_dsl.report.terminal.kernel_progress import COMPILING, KernelProgress

    terminal.err.print(COMPILING, style="quiet")
    if first_root is not None and folder.parent != first_root:
        why = f"kernels are stored in {folder}: {first_root} cannot be written, is full or belongs to another user"
        terminal.note(why, "warn")
    with KernelProgress(terminal.err, folder, count_kernels(folder), missing) as progress:
        compile_apart(demand, folder, progress.tell)
    if not count_kernels(folder):
        why = f"compiled kernels could not be stored in {folder}: each start compiles them again"
        terminal.note(why, "warn")
