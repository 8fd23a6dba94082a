"""Compile kernels before a command needs them, and show the user what it waits for."""

from dataclasses import replace

from cortex_dsl.console.terminal import Terminal
from engine.config import Config
from engine.program import Program


def announce_compilation(terminal: Terminal) -> bool:
    """Say that the first command after an installation or update compiles kernels, before it seems to hang."""
    from engine.kernels.jit import kernels_are_cached

    if kernels_are_cached():
        return False
    from cortex_dsl.report.terminal.kernel_progress import COMPILING

    terminal.err.print(COMPILING, style="quiet")
    return True


def compile_kernels(program: Program, config: Config, terminal: Terminal, blamed: bool = True) -> None:
    """Compile now what a run or search will need, so that pace and remaining time are shown without that.

    `blamed`: whether collisions are examined for who could have avoided them.
    """
    from engine.compiling_apart import Needed, compile_apart, count_kernels, missing_kernels
    from engine.kernels.jit import cache_folder, packaged
    from engine.user_cache import cache_roots

    folder, first_root = cache_folder(), next(cache_roots(), None)
    needed = Needed(program, replace(config, driver=None), blamed)
    if packaged() is not None or not (missing := missing_kernels(needed, folder)):
        return
    from cortex_dsl.report.terminal.kernel_progress import COMPILING, KernelProgress

    terminal.err.print(COMPILING, style="quiet")
    if first_root is not None and folder.parent != first_root:
        why = f"kernels are stored in {folder}: {first_root} cannot be written, is full or belongs to another user"
        terminal.err.print(why, style="warn", soft_wrap=True)
    with KernelProgress(terminal.err, folder, count_kernels(folder), missing) as progress:
        compile_apart(needed, folder, progress.tell)
    if not count_kernels(folder):
        why = f"compiled kernels could not be stored in {folder}: each start compiles them again"
        terminal.err.print(why, style="warn", soft_wrap=True)
