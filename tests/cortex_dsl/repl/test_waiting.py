"""No command waits for kernels without saying so."""

import pytest
from numba import njit

from cortex_dsl.console.terminal import Terminal
from cortex_dsl.repl.state import Kernels
from cortex_dsl.report.terminal.kernel_progress import COMPILING


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
