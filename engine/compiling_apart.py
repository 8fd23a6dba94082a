"""Compile what a search needs in processes of their own, before it begins: on two cores sampler and host side by side.

The processes leave compiled kernels in the cache, from which this one loads them. It only waits, so that Ctrl-C and
SIGTERM are answered at once: within a process, LLVM works for up to twenty seconds before Python hears of them.
"""

import multiprocessing
import os
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import wait
from multiprocessing.context import SpawnProcess
from pathlib import Path

import numpy as np

from engine.config import Config
from engine.control import numbers_decided
from engine.program import Program
from engine.scenes import Scenes
from engine.streams import StreamKey, key_rows
from engine.user_cache import ENVIRONMENT_VARIABLE
from engine.vocabulary import Method, Verdict

PULSE = 0.5
"""Time between two reports of progress [s]."""
MARKS = {True: "compiled-searches", False: "compiled-runs"}
"""Empty files that say for what the kernels beside them are complete."""
KERNELS_OF_EVERY_PROGRAM = 9
"""Number of kernels that a search of any program needs, one of them for the collisions; a test counts them."""
GRACE = 5.0
"""Time that a stopped process has to end [s]."""


@dataclass(frozen=True)
class Needed:
    """What the kernels are compiled for."""

    program: Program
    config: Config
    blamed: bool = True
    """Whether collisions are examined for who could have avoided them."""

    @property
    def is_divided(self) -> bool:
        """True if sampling calls no kernel of the host, and the host needs no scene to compile its kernels."""
        return self.config.search.engine == "batch" and not self.program.settings.fair

    def own_kernels(self) -> set[Callable[..., object]]:
        """Return the kernels that only some programs need; none with a numba that stores them elsewhere."""
        import numba

        from engine.host import deferred_kernels
        from engine.kernels.evaluate import geometry_kernels
        from engine.kernels.jit import is_known
        from engine.kernels.rows import judge_rows

        if not is_known(numba.__version__):
            return set()
        own = {*deferred_kernels(self.program, pause=len(self.program.controls))}
        own |= geometry_kernels(self.program.code.scene_code)
        return own | {judge_rows} if len(self.program.judged) else own

    def sample(self) -> None:
        """Call all kernels that draw scenes for genomes."""
        from engine.sampling import sample

        keys = key_rows(0, Method.SAMPLE, 0, 0, range(1))
        sample(self.program, np.array([self.program.space.low]), keys, self.config.simulation)

    def simulate(self) -> None:
        """Call all kernels that run scenes, with one that is not valid."""
        from engine.avoidability import blame
        from engine.batch import simulate

        scene, config = undrawn(self.program), self.config
        simulate(self.program, scene, config.simulation, 1, config.contact)
        if self.program.controls:
            self._step()
        if self.blamed:
            blame(self.program, scene, config.simulation, config.contact)

    def _step(self) -> None:
        """Call the kernels of parallel runs, with a slot in which no run goes on."""
        from engine.driving.stepping import Lanes

        lanes, slot = Lanes(self.program, 1, self.config.simulation, self.config.contact), np.zeros(1, dtype=np.int64)
        lanes.place(slot, undrawn(self.program))
        lanes.observe(0, np.zeros(1, dtype=bool))
        lanes.step()


def undrawn(program: Program) -> Scenes:
    """Return one scene that is not valid, for which no kernel was called."""
    requirements = np.zeros((1, len(program.requirements)), dtype=np.int64)
    return Scenes(
        genomes=np.zeros((1, len(program.space))),
        keys=np.zeros((1, len(StreamKey._fields)), dtype=np.int64),
        verdict=np.full(1, int(Verdict.EXHAUSTED), dtype=np.int32),
        variant=np.full(1, -1, dtype=np.int32),
        values=np.full((1, program.code.output_register.shape[1]), np.nan),
        draws=np.zeros((1, 0)),
        attempts=np.zeros(1, dtype=np.int64),
        tested=requirements,
        failed=requirements,
        actions=np.zeros((1, 1, numbers_decided(program.controls))),
    )


Part = Callable[[Needed], None]
PARTS: tuple[Part, ...] = (Needed.simulate, Needed.sample)


def compile_apart(needed: Needed, folder: Path, tell: Callable[[], None], parts: tuple[Part, ...] = PARTS) -> bool:
    """Compile the parts, reporting now and then; return True if every process ended well.

    `folder`: the folder of this version's kernels.
    """
    divided = needed.is_divided and len(parts) > 1 and cores() > 1
    groups = [(part,) for part in parts] if divided else [parts]
    context = multiprocessing.get_context("spawn")
    processes = [context.Process(target=_compile, args=(group, needed, str(folder.parent))) for group in groups]
    try:
        _start(processes)
        while running := [process.sentinel for process in processes if process.is_alive()]:
            wait(running, timeout=PULSE)
            tell()
    except OSError:  # no process can be started: kernels are compiled where they are needed
        return False
    finally:
        _stop(processes, folder)
    done = all(process.exitcode == 0 for process in processes)
    with suppress(OSError):
        if done:
            (folder / MARKS[needed.blamed]).touch()
    return done


def missing_kernels(needed: Needed, folder: Path) -> int:
    """Return the number of kernels that are still to be compiled, as far as it is known.

    Counted are the kernels of every program, unless an earlier call compiled them all, and those of this one alone.
    """
    of_every = (folder / MARKS[True]).exists() or (not needed.blamed and (folder / MARKS[False]).exists())
    own = [kernel for kernel in needed.own_kernels() if not is_stored(kernel, folder)]
    return len(own) + (0 if of_every else KERNELS_OF_EVERY_PROGRAM - (not needed.blamed))


def is_stored(kernel: Callable[..., object], folder: Path) -> bool:
    """Return True if machine code of a kernel is in a folder."""
    module = kernel.__module__.rpartition(".")[2]
    return any(folder.glob(f"{module}/{module}.{kernel.__name__}.*.nbc"))


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _start(processes: list[SpawnProcess]) -> None:
    from engine.search.workers import unheard_by_children

    with unheard_by_children():
        for process in processes:
            process.start()


def _compile(parts: tuple[Part, ...], needed: Needed, root: str) -> None:
    """Compile parts in this process, into the cache of the process that started it."""
    from engine.search.workers import serve_parent

    os.environ[ENVIRONMENT_VARIABLE] = root
    serve_parent()
    try:
        for part in parts:
            part(needed)
    except Exception:  # whoever needs the kernel gets the same error, and shows it
        os._exit(1)


def _stop(processes: list[SpawnProcess], folder: Path) -> None:
    """End processes that still run, and remove the files that they were writing."""
    for process in processes:
        if process.pid is None:
            continue
        stopped = process.is_alive()
        if stopped:
            process.kill()
        process.join(GRACE)
        for unborn in folder.rglob(f"*.nbc.{process.pid}.*") if stopped else ():
            with suppress(OSError):
                unborn.unlink()


def count_kernels(folder: Path) -> int:
    """Return the number of compiled kernels in a folder."""
    return sum(1 for _ in folder.rglob("*.nbc"))
