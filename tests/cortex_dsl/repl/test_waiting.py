"""No command waits for kernels without saying so, and how many there are."""

import os
import re
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from numba import njit

from cortex_dsl.console.terminal import Terminal
from cortex_dsl.repl import state
from cortex_dsl.repl.state import Kernels
from cortex_dsl.report.terminal.kernel_progress import COMPILED, COMPILING
from engine import compiling_apart
from engine.compiling_apart import KernelDemand, Part, stored_name
from engine.kernels import jit

LONG = 60.0
"""Time that a compilation takes, if nobody ends it [s]."""


def first() -> None: ...


def second() -> None: ...


def kernels_of(_demand: KernelDemand) -> tuple[Callable[..., object], ...]:
    return first, second


def store(_demand: KernelDemand) -> None:
    """Leave what stands for two compiled kernels."""
    for kernel in (first, second):
        _note(stored_name(kernel, "0"))


def store_slowly(_demand: KernelDemand) -> None:
    _note(f"{stored_name(first, '0')}.{os.getpid()}.0123456789ab")
    time.sleep(LONG)


def _note(name: str) -> None:
    file = Path(os.environ["CORTEXC_CACHE"]) / "numba-0" / name
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache, in which a session finds none of its two kernels."""
    (made := tmp_path / "numba-0").mkdir()
    monkeypatch.setenv("CORTEXC_CACHE", str(tmp_path))
    monkeypatch.setattr(jit, "cache_folder", lambda: made)
    monkeypatch.setattr(jit, "packaged", lambda: None)
    monkeypatch.setattr(state, "SESSION", ("weigh",))
    monkeypatch.setattr(state, "warm_up", lambda scenario: None)
    monkeypatch.setattr(state, "PATIENCE", 0.0)
    return made


@pytest.mark.parametrize("background", [False, True])
def test_kernels_are_counted(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *, background: bool
) -> None:
    """As commands count them, whether they are compiled when a command needs them or since the session began."""
    monkeypatch.setitem(compiling_apart.PARTS, "weigh", Part(kernels_of, store))
    kernels = Kernels()
    if background:
        kernels.start()
    for _ in range(2):
        kernels.wait(Terminal(colour=False), ("weigh",))
    said = capsys.readouterr().err.replace("loading kernels …\n", "")
    assert said.startswith(COMPILING)
    assert re.findall(r"kernels: (\d of \d), \d+ s", said)[-1:] == ["2 of 2"]
    assert said.count(COMPILING) == 1
    assert not COMPILED.sub("", said)
    assert not kernels.failed


def test_the_end_of_a_session_ends_what_it_compiles(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Long before the compilation would, and without a part of a file."""
    monkeypatch.setitem(compiling_apart.PARTS, "weigh", Part(kernels_of, store_slowly))
    kernels = Kernels()
    kernels.start()
    assert kernels.thread is not None
    while not list(folder.rglob("*.nbc.*")):
        assert kernels.thread.is_alive()
        time.sleep(0.05)
    kernels.stop()
    assert not list(folder.rglob("*.nbc*"))
    kernels.thread.join(LONG)
    assert [type(error) for error in kernels.failed] == [SystemExit]


def test_a_compilation_is_told_once_a_command(capsys: pytest.CaptureFixture[str]) -> None:
    """Before the first kernel that is in no cache, and again in the next command that has to wait for one."""
    kernels, terminal = Kernels(), Terminal(colour=False)
    for expected in (1, 2):
        kernels.wait(terminal)
        kernels.wait(terminal)
        for number in range(2):
            njit(lambda x: x + number)(1.0)  # noqa: B023 - each is compiled for itself
        assert capsys.readouterr().err.count(COMPILING) == 1, expected
        kernels.over()
    njit(lambda x: x - 1)(1.0)
    assert not capsys.readouterr().err


def test_what_is_ready_is_not_told(capsys: pytest.CaptureFixture[str]) -> None:
    """A kernel that was compiled before makes nobody wait."""
    ready = njit(lambda x: x + 1)
    ready(1.0)
    kernels = Kernels()
    kernels.wait(Terminal(colour=False))
    ready(2.0)
    kernels.over()
    assert COMPILING not in capsys.readouterr().err
