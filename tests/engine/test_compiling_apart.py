"""Kernels compiled in processes of their own: side by side, ended with whoever waits for them, never in the way."""

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from cortex_dsl.api.scenario import compile_text
from engine import compiling_apart
from engine.compiling_apart import PARTS, KernelDemand, Part, compile_apart, missing_kernels, stored_name, undrawn
from engine.kernels.jit import cache_folder
from engine.program import Program
from wheels.compile_kernels import deferred_names

SOURCE = """
param V = Range(1, 9) m/s
ego = new Car at (0 m, 0 m), with speed V
other = new Car at (0 m, 40 m), with speed V
"""
FURTHER = (
    SOURCE
    + """
third = new Car at (0 m, 60 m), with speed V
terminate when ego can see third
"""
)
"""Actors other than the ego may touch, and one is seen: deferred kernels."""
KERNELS = Path(compiling_apart.__file__).parent / "kernels"
LONG = 60.0
STARTED = 300.0
"""Time in which two processes start on a busy machine [s]."""


def note_first(demand: KernelDemand) -> None:
    _note("first")


def note_second(demand: KernelDemand) -> None:
    _note("second")


def fail(demand: KernelDemand) -> None:
    raise ValueError("as a kernel that cannot be compiled")


def write_slowly(demand: KernelDemand) -> None:
    """A process amid writing an entry, which ignores what it can."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    _note(f"entry.nbc.{os.getpid()}.0123456789ab")
    time.sleep(LONG)


def no_kernels(demand: KernelDemand) -> tuple[()]:
    return ()


FIRST, SECOND = Part(no_kernels, note_first), Part(no_kernels, note_second, beside=True)
SLOW, SLOW_BESIDE = Part(no_kernels, write_slowly), Part(no_kernels, write_slowly, beside=True)
FAILING = Part(no_kernels, fail)
SEARCH = tuple(PARTS[name] for name in ("sample", "simulate", "blame"))


def _note(name: str) -> None:
    folder = Path(os.environ["CORTEXC_CACHE"]) / "numba-0"
    (folder / name).write_text(str(os.getpid()))


WAITING = """
import sys
from pathlib import Path
from engine.compiling_apart import KernelDemand, compile_apart
from tests.engine.test_compiling_apart import SLOW, SLOW_BESIDE

if __name__ == "__main__":
    import signal
    def stop(number, frame):
        raise KeyboardInterrupt
    signal.signal(signal.SIGTERM, stop)
    compile_apart(KernelDemand((SLOW, SLOW_BESIDE)), Path(sys.argv[1]), lambda: None)
"""


@pytest.fixture(scope="module")
def program() -> Program:
    return compile_text(SOURCE).program


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (made := tmp_path / "numba-0").mkdir()
    return made


@pytest.mark.parametrize(("free", "processes"), [(1, 1), (2, 2)])
def test_parts_are_compiled_side_by_side_where_two_cores_are_free(
    folder: Path, monkeypatch: pytest.MonkeyPatch, free: int, processes: int
) -> None:
    """In the cache of the process that waits, whatever the environment names."""
    monkeypatch.setattr(compiling_apart, "cores", lambda: free)
    monkeypatch.setenv("CORTEXC_CACHE", str(folder / "elsewhere"))
    assert compile_apart(KernelDemand((SECOND, FIRST)), folder, lambda: None)
    assert len({(folder / name).read_text() for name in ("first", "second")}) == processes
    assert str(os.getpid()) not in {path.read_text() for path in folder.iterdir()}


def test_what_is_missing_is_what_is_stored_nowhere(program: Program, folder: Path, tmp_path: Path) -> None:
    """In the user's cache or in the package; a later scenario may need more than the first."""
    sees = compile_text(SOURCE + "terminate when ego can see other\n").program
    search, further = KernelDemand(SEARCH, program), KernelDemand(SEARCH, sees)
    few = len(search.kernels())
    assert missing_kernels(search, [folder]) == few
    store_kernels(search, folder)
    assert not missing_kernels(search, [folder])
    assert not missing_kernels(search, [tmp_path, folder])
    assert missing_kernels(further, [folder]) == 1
    store_kernels(further, folder)
    assert not missing_kernels(further, [folder])


def store_kernels(demand: KernelDemand, folder: Path) -> None:
    """Write empty files in place of compiled kernels."""
    for kernel in demand.kernels():
        file = folder / stored_name(kernel, "0123")
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("")


def test_what_samplers_and_hosts_share_is_not_compiled_twice(program: Program, monkeypatch: pytest.MonkeyPatch) -> None:
    """Fair starts are driven while they are drawn."""
    monkeypatch.setattr(compiling_apart, "cores", lambda: 2)
    fair = compile_text("simulation(fair=True)\n" + SOURCE).program
    assert KernelDemand(SEARCH, program).groups == [SEARCH[1:], SEARCH[:1]]
    assert KernelDemand(SEARCH, fair).groups == [SEARCH]
    assert KernelDemand(SEARCH[:1], program).groups == [SEARCH[:1]]


@pytest.mark.parametrize("source", [SOURCE, FURTHER], ids=["two", "three"])
@pytest.mark.parametrize("name", PARTS)
def test_each_part_calls_its_kernels(name: str, source: str) -> None:
    """So those that are announced are stored afterwards, in whatever folder of the package they stand."""
    program = compile_text(source).program
    demand = KernelDemand((PARTS[name],), program)
    PARTS[name].compile(demand)
    assert not missing_kernels(demand, [cache_folder()])


def test_the_pattern_of_each_kernel_of_a_wheel_names_its_module() -> None:
    """Those in folders of modules, too."""
    names = deferred_names()
    assert "impacts/motion/motion.step_post_impact.*.nbc" in names
    assert all((KERNELS / Path(name).parent).with_suffix(".py").is_file() for name in names)


def test_what_nobody_finished_is_removed(folder: Path) -> None:
    """Files of a process that was killed; those of one that may still write stay."""
    old, new = folder / "one.nbc.7.0123456789ab", folder / "two.nbc.8.0123456789ab"
    for file in (old, new):
        file.write_text("")
    os.utime(old, (0, 0))
    assert compile_apart(KernelDemand((FIRST,)), folder, lambda: None)
    assert (old.exists(), new.exists()) == (False, True)


def test_a_failure_is_left_to_the_process_that_waits(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """It meets the same error where the kernel is needed, and shows it once."""
    assert not compile_apart(KernelDemand((FAILING, SECOND)), folder, lambda: None)
    assert "Traceback" not in capfd.readouterr().err


def test_no_process_is_no_error(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where none can be started, kernels are compiled where they are needed."""

    def refuse(processes: object) -> None:
        raise OSError("as a limit of processes does")

    monkeypatch.setattr(compiling_apart, "_start", refuse)
    assert not compile_apart(KernelDemand((FIRST,)), folder, lambda: None)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_a_stop_ends_all_processes(folder: Path, number: signal.Signals) -> None:
    """Within seconds, whatever they are at; of a stop that can be heard no part of a file is left either."""
    script = folder.parent / "waiting.py"
    script.write_text(WAITING)
    root = Path(__file__).parents[2]
    environment = {**os.environ, "PYTHONPATH": str(root)}
    process = subprocess.Popen([sys.executable, str(script), str(folder)], env=environment, stderr=subprocess.DEVNULL)
    try:
        expected = min(2, compiling_apart.cores())
        assert _within(STARTED, lambda: len(list(folder.glob("*.nbc.*"))) == expected)
        written = [int(path.read_text()) for path in folder.glob("*.nbc.*")]
        process.send_signal(number)
        process.wait(10)
        assert _within(10, lambda: not any(map(_is_alive, written)))
        assert number == signal.SIGKILL or not list(folder.iterdir())
    finally:
        process.kill()


def test_a_scene_that_nobody_drew_has_the_types_of_a_drawn_one(program: Program) -> None:
    """So kernels that take it are those that a search calls."""
    from engine.host import requested
    from engine.sampling import draw_genomes, sample
    from engine.streams import key_rows
    from engine.vocabulary import Method

    keys = key_rows(0, Method.SAMPLE, 0, 0, range(1))
    drawn = sample(program, draw_genomes(program.space, keys), keys)
    for one, other in zip(requested(program, undrawn(program)), requested(program, drawn), strict=True):
        assert (one.dtype, one.ndim, one.flags.c_contiguous) == (other.dtype, other.ndim, other.flags.c_contiguous)


def _within(seconds: float, holds: Callable[[], bool]) -> bool:
    end = time.monotonic() + seconds
    while not holds():
        if time.monotonic() > end:
            return False
        time.sleep(0.05)
    return True


def _is_alive(pid: int) -> bool:
    """Whether a process runs; one that has ended and is not waited for does not."""
    with contextlib.suppress(OSError):
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    return False
