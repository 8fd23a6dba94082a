"""Compilation of a search's kernels in separate processes before it begins: on two cores, sampler and host in parallel.

The processes leave compiled kernels in the cache, from which this one loads them. It only waits, so that Ctrl-C and
SIGTERM take effect at once: in the compiling process, LLVM works for up to twenty seconds before Python handles them.
"""

import math
import multiprocessing
import os
import tempfile
import time
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from multiprocessing.connection import wait
from multiprocessing.context import SpawnProcess
from pathlib import Path
from typing import NamedTuple, cast

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
GRACE = 5.0
"""Time that a stopped process has to end [s]."""
UNFINISHED = "*.nbc.{}.*"
"""Files that a process of this number is writing; `engine.kernels.numba_internals` names them."""
ABANDONED = 3600.0
"""Age from which on an unfinished file is removed [s]."""
CARS = (("ego", -20.0, 1.0, 0.0), ("other", 20.0, -1.0, math.pi))
"""Name, x at the start [m], motion per row [m] and heading [rad] of two cars on one line."""
KERNEL_PACKAGE = "engine.kernels"
Kernel = Callable[..., object]


@dataclass(frozen=True)
class KernelDemand:
    """Kernels that a command calls: those of parts of its work, and those of its program."""

    parts: "tuple[Part, ...]"
    """Rows of `PARTS`."""
    program: Program | None = None
    """None if recordings are assessed."""
    config: Config = field(default_factory=Config)

    @property
    def groups(self) -> "list[tuple[Part, ...]]":
        """Return the parts that each process compiles. Sampling calls kernels of the host for fair starts only."""
        together = tuple(part for part in self.parts if not part.beside)
        beside = tuple(part for part in self.parts if part.beside)
        divided = together and beside and cores() > 1 and not (self.program and self.program.settings.fair)
        return [together, beside] if divided else [self.parts]

    def kernels(self) -> set[Kernel]:
        """Return the kernels of all parts; none with a numba that stores them elsewhere."""
        import numba

        from engine.kernels.jit import is_known

        return {each for part in self.parts for each in part.kernels(self) if is_known(numba.__version__)}


class Part(NamedTuple):
    """Kernels that one call compiles."""

    kernels: Callable[[KernelDemand], Iterable[Kernel]]
    """Kernels that are stored, if their compilation takes long."""
    compile: Callable[[KernelDemand], None]
    beside: bool = False
    """True if a separate process compiles them, as they contain no kernel of other parts."""


def _sampling_kernels(demand: KernelDemand) -> Iterator[Kernel]:
    from engine.kernels.attempts import sample_rows
    from engine.kernels.evaluate import geometry_kernels
    from engine.kernels.random_numbers import fill_uniform

    yield from (sample_rows, fill_uniform)
    if demand.program is not None:
        yield from geometry_kernels(demand.program.code.scene_code)


def _sample(demand: KernelDemand) -> None:
    from engine.sampling import draw_genomes, sample

    program, keys = cast("Program", demand.program), key_rows(0, Method.SAMPLE, 0, 0, range(1))
    draw_genomes(program.space, keys)
    sample(program, np.array([program.space.low]), keys, demand.config.simulation)


def _weighing_kernels(demand: KernelDemand) -> Iterator[Kernel]:
    from engine.kernels.attempts import weigh_rows
    from engine.kernels.evaluate import geometry_kernels

    yield weigh_rows
    if demand.program is not None:
        yield from geometry_kernels(demand.program.code.scene_code)


def _weigh(demand: KernelDemand) -> None:
    from engine.acceptance import measure_acceptance

    measure_acceptance(cast("Program", demand.program), 1)


def _simulating_kernels(demand: KernelDemand) -> Iterator[Kernel]:
    from engine.host import deferred_kernels
    from engine.kernels.fault import fault_of
    from engine.kernels.pair import measure_pair
    from engine.kernels.rollout import advance, begin
    from engine.kernels.rows import measure_run, simulate_rows

    yield from (simulate_rows, begin, advance, measure_run, measure_pair, fault_of)
    if demand.program is not None:
        yield from deferred_kernels(demand.program, pause=len(demand.program.controls))


def _simulate(demand: KernelDemand) -> None:
    """Run one invalid scene, which needs no compiled kernel."""
    from engine.batch import simulate
    from engine.driving.stepping import ParallelRuns

    program, config = cast("Program", demand.program), demand.config
    simulate(program, undrawn(program), config.simulation, 1, config.contact)
    if program.controls:
        runs, slot = ParallelRuns(program, 1, config.simulation, config.contact), np.zeros(1, dtype=np.int64)
        runs.place(slot, undrawn(program))
        runs.observe(0, np.zeros(1, dtype=bool))
        runs.step()


def _blaming_kernels(_demand: KernelDemand) -> Iterator[Kernel]:
    from engine.kernels.adapted import counterfactual_rows
    from engine.kernels.avoidance import reference_rows
    from engine.kernels.references import verdict_rows

    yield from (verdict_rows, reference_rows, counterfactual_rows)


def _blame(demand: KernelDemand) -> None:
    from engine.avoidability import avoidability
    from engine.counterfactuals import counterfactuals
    from engine.verdicts import blame

    program, config = cast("Program", demand.program), demand.config
    blame(program, undrawn(program), config.simulation, config.contact)
    avoidability(program, undrawn(program), config.simulation, contact=config.contact)
    counterfactuals(program, undrawn(program), config.simulation, config.contact)


def _metric_kernels(_demand: KernelDemand) -> Iterator[Kernel]:
    from engine.kernels import approach, conflict, encroachment, evasion, pair, safe_distance

    yield from (approach.search_contact_of, pair.measure_pair, safe_distance.is_dangerous)
    yield from (conflict.snapshot, conflict.time_to_collision, conflict.required_deceleration, encroachment.stays)
    yield from (evasion.braking_needed, evasion.swerving_needed, evasion.time_to_brake, evasion.time_to_steer)


def _measure(_demand: KernelDemand) -> None:
    from engine.interchange.measuring import measure
    from engine.interchange.sources import read_recording

    with _head_on() as path:
        measure(read_recording(path).recording)


def _pair_kernels(_demand: KernelDemand) -> Iterator[Kernel]:
    from engine.kernels.every_pair import judge_windows, near_windows
    from engine.kernels.pair import measure_pair

    yield from (judge_windows, near_windows, measure_pair)


def _rank(_demand: KernelDemand) -> None:
    from engine.interchange.every_pair import rank_pairs
    from engine.interchange.sources import read_traffic

    with _head_on() as path:
        rank_pairs(read_traffic(path))


@contextmanager
def _head_on() -> Generator[Path]:
    """Yield a table of two cars that drive towards each other."""
    places = ((k, car) for k in range(30) for car in CARS)
    rows = (f"{k / 10},{name},{x + v * k},0,{10 * abs(v)},{turn}" for k, (name, x, v, turn) in places)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "head_on.csv"
        path.write_text("\n".join(["time,actor,x,y,speed,heading", *rows]), encoding="utf-8")
        yield path


PARTS: dict[str, Part] = {
    "sample": Part(_sampling_kernels, _sample, beside=True),
    "weigh": Part(_weighing_kernels, _weigh),
    "simulate": Part(_simulating_kernels, _simulate),
    "blame": Part(_blaming_kernels, _blame),
    "metrics": Part(_metric_kernels, _measure),
    "pairs": Part(_pair_kernels, _rank),
}


def undrawn(program: Program) -> Scenes:
    """Return one invalid scene, made without a kernel."""
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


def compile_apart(demand: KernelDemand, folder: Path, tell: Callable[[], None]) -> bool:
    """Compile the demanded kernels with progress reports; return True if every process ended without an error.

    `folder`: the folder of this version's kernels.
    """
    context = multiprocessing.get_context("spawn")
    processes = [context.Process(target=_compile, args=(g, demand, str(folder.parent))) for g in demand.groups]
    _remove_parts(folder.rglob(UNFINISHED.format("*")), older_than=time.time() - ABANDONED)
    try:
        _start(processes)
        while running := [process.sentinel for process in processes if process.is_alive()]:
            wait(running, timeout=PULSE)
            tell()
    except OSError:  # no process can be started: kernels are compiled on demand
        return False
    finally:
        _stop(processes, folder)
    return all(process.exitcode == 0 for process in processes)


def missing_kernels(demand: KernelDemand, folders: Sequence[Path]) -> int:
    """Return the number of kernels that are stored in none of the folders."""
    return sum(not any(is_stored(kernel, folder) for folder in folders) for kernel in demand.kernels())


def is_stored(kernel: Kernel, folder: Path) -> bool:
    """Return True if machine code of a kernel is in a folder."""
    return any(folder.glob(stored_name(kernel, "*")))


def stored_name(kernel: Kernel, key: str) -> str:
    """Return the path of a kernel's machine code in the folder of a version; `key` identifies its argument types."""
    *folders, module = kernel.__module__.removeprefix(f"{KERNEL_PACKAGE}.").split(".")
    return "/".join([*folders, module, f"{module}.{kernel.__name__}.{key}.nbc"])


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _start(processes: list[SpawnProcess]) -> None:
    from engine.search.workers import unheard_by_children

    with unheard_by_children():
        for process in processes:
            process.start()


def _compile(parts: tuple[Part, ...], demand: KernelDemand, root: str) -> None:
    """Compile parts in this process, into the cache of the process that started it."""
    from engine.search.workers import serve_parent

    os.environ[ENVIRONMENT_VARIABLE] = root
    serve_parent()
    try:
        for part in parts:
            part.compile(demand)
    except Exception:  # the process that needs the kernel gets the same error, and shows it
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
        if stopped:
            _remove_parts(folder.rglob(UNFINISHED.format(process.pid)))


def _remove_parts(files: Iterable[Path], older_than: float = math.inf) -> None:
    for file in files:
        with suppress(OSError):
            if file.stat().st_mtime < older_than:
                file.unlink()


def count_kernels(folder: Path) -> int:
    """Return the number of compiled kernels in a folder."""
    return sum(1 for _ in folder.rglob("*.nbc"))
