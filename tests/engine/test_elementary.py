"""How elementary functions round has a name: runs of machines with another name may differ, which is said."""

import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest

from engine.elementary import library

PLAIN = "glibc.cpu.hwcaps=-FMA,-AVX2"
"""Setting under which glibc uses the code for processors without fused multiply-add."""


def run(*words: object, tunables: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, *map(str, words)]
    environment = {**os.environ, "GLIBC_TUNABLES": tunables}
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=True)


def named(tunables: str) -> str:
    return run("-c", "from engine.elementary import library; print(library())", tunables=tunables).stdout.strip()


@pytest.fixture(scope="module")
def other() -> str:
    """Name of the library as it rounds without fused multiply-add."""
    if platform.libc_ver()[0] != "glibc" or named(PLAIN) == library():
        pytest.skip("this processor has no fused multiply-add, or its library does not use it")
    return named(PLAIN)


def test_the_name_is_that_of_every_process() -> None:
    assert named("") == library()


@pytest.mark.usefixtures("other")
def test_a_run_of_another_processor_is_no_damage(ga_run: Path) -> None:
    """Some of its simulations may have another result; the reason is named, and the journal holds."""
    words = ("-m", "cortex_dsl", "verify", ga_run, "--sample", 1000)
    here, there = (run(*words, tunables=tunables).stdout for tunables in ("", PLAIN))
    assert "as they were written" in here
    assert "as they were written" in there
    assert "something else" not in here
    assert "something else" not in there or f"libm {library()}" in there


def test_resuming_elsewhere_is_named(other: str, tmp_path: Path) -> None:
    """Before anything is computed."""
    words = ("-m", "cortex_dsl", "examples/left_turn.scn", "--random", "--generations", 1, "--population", 4)
    run(*words, "--out", tmp_path / "run", tunables=PLAIN)
    resumed = run("-m", "cortex_dsl", "resume", tmp_path / "run", "--generations", 2, tunables="")
    assert f"started with libm {other}" in resumed.stderr
