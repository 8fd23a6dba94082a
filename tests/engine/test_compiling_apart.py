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

from cortex_dsl.api.loading import compile_text
from engine import compiling_apart
from engine.compiling_apart import Needed, compile_apart, missing_kernels, undrawn
from engine.config import Config, SearchConfig
from engine.program import Program

SOURCE = """
param V = Range(1, 9) m/s
ego = new Car at (0 m, 0 m), with speed V
other = new Car at (0 m, 40 m), with speed V
"""
LONG = 60.0
STARTED = 30.0
"""Time in which two processes start on a busy machine [s]."""


def note_first(needed: Needed) -> None:
    _note("first")


def note_second(needed: Needed) -> None:
    _note("second")


def fail(needed: Needed) -> None:
    raise ValueError("as a kernel that cannot be compiled")


def write_slowly(needed: Needed) -> None:
    """A process amid writing an entry, which ignores what it can."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    _note(f"entry.nbc.{os.getpid()}.0123456789ab")
    time.sleep(LONG)


def _note(name: str) -> None:
    folder = Path(os.environ["CORTEXC_CACHE"]) / "numba-0"
    (folder / name).write_text(str(os.getpid()))


WAITING = """
import sys
from pathlib import Path
from engine.compiling_apart import Needed, compile_apart
from engine.config import Config
from tests.engine.test_compiling_apart import SOURCE, write_slowly
from cortex_dsl import compile_text

if __name__ == "__main__":
    import signal
    def stop(number, frame):
        raise KeyboardInterrupt
    signal.signal(signal.SIGTERM, stop)
    program = compile_text(SOURCE).program
    parts = (write_slowly, write_slowly)
    compile_apart(Needed(program, Config()), Path(sys.argv[1]), lambda: None, parts)
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
    program: Program, folder: Path, monkeypatch: pytest.MonkeyPatch, free: int, processes: int
) -> None:
    """In the cache of the process that waits, whatever the environment names."""
    monkeypatch.setattr(compiling_apart, "cores", lambda: free)
    monkeypatch.setenv("CORTEXC_CACHE", str(folder / "elsewhere"))
    assert compile_apart(Needed(program, Config()), folder, lambda: None, (note_first, note_second))
    assert len({(folder / name).read_text() for name in ("first", "second")}) == processes
    assert str(os.getpid()) not in {path.read_text() for path in folder.iterdir()}


def test_what_is_complete_for_runs_is_not_for_searches(program: Program, folder: Path) -> None:
    """An interrupted compilation leaves kernels, but no mark: the next command goes on with it, and says so."""
    run, search = Needed(program, Config(), blamed=False), Needed(program, Config())
    for needed in (run, search):
        assert missing_kernels(needed, folder)
        assert compile_apart(needed, folder, lambda: None, (note_first,))
        store_own_kernels(needed, folder)
        assert not missing_kernels(run, folder)
        assert bool(missing_kernels(search, folder)) == (needed is run)


def test_what_only_some_programs_need_is_missed_where_it_is_not_stored(program: Program, folder: Path) -> None:
    """A later scenario may need more than the first: its wait is announced, too."""
    sees = Needed(compile_text(SOURCE + "terminate when ego can see other\n").program, Config())
    assert compile_apart(Needed(program, Config()), folder, lambda: None, (note_first,))
    store_own_kernels(Needed(program, Config()), folder)
    assert missing_kernels(sees, folder) == 1
    store_own_kernels(sees, folder)
    assert not missing_kernels(sees, folder)


def store_own_kernels(needed: Needed, folder: Path) -> None:
    """Write empty files in place of the compiled kernels that only this program needs."""
    for kernel in needed.own_kernels():
        module = kernel.__module__.rpartition(".")[2]
        (folder / module).mkdir(exist_ok=True)
        (folder / module / f"{module}.{kernel.__name__}.0123.nbc").write_text("")


def test_what_needs_scenes_is_not_divided(program: Program) -> None:
    """The world's host steps drawn scenes, and fair starts are driven while they are drawn."""
    assert Needed(program, Config()).is_divided
    assert not Needed(program, Config(search=SearchConfig(engine="world"))).is_divided


def test_a_failure_is_left_to_the_process_that_waits(
    program: Program, folder: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """It meets the same error where the kernel is needed, and shows it once."""
    assert not compile_apart(Needed(program, Config()), folder, lambda: None, (fail, note_second))
    assert "Traceback" not in capfd.readouterr().err
    assert missing_kernels(Needed(program, Config(), blamed=False), folder)


def test_no_process_is_no_error(program: Program, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where none can be started, kernels are compiled where they are needed."""

    def refuse(processes: object) -> None:
        raise OSError("as a limit of processes does")

    monkeypatch.setattr(compiling_apart, "_start", refuse)
    assert not compile_apart(Needed(program, Config()), folder, lambda: None, (note_first,))


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
