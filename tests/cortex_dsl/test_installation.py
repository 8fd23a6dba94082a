"""Somebody's own folder `engine` stands before ours: the reason and the cure are said, in Python and by the command."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from cortex_dsl.installation import check_engine, errors
from engine.errors import CortexError

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "left_turn.scn"
LOAD = f"import cortex_dsl as cx; cx.load({str(EXAMPLE)!r})"
CAUGHT = """
import sys
import cortex_dsl as cx
assert cx.__version__
try:
    cx.load("x.scn")
except cx.CortexError as error:
    print(error.message)
    print(error.cure)
assert "engine" not in sys.modules
import engine
assert engine.MINE
"""
CURE = "another package or folder called `engine` hides it; install cortexc in an environment of its own"


@pytest.fixture(params=["engine/__init__.py", "engine.py"])
def folder(tmp_path: Path, request: pytest.FixtureRequest) -> Path:
    """A working folder with somebody's `engine` in it."""
    file = tmp_path / request.param
    file.parent.mkdir(exist_ok=True)
    file.write_text("MINE = True\n")
    return tmp_path


def python(folder: Path, *words: str | Path) -> subprocess.CompletedProcess[str]:
    """Python, started in a folder."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, *map(str, words)]
    return subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=300, check=False
    )


def test_ours_is_found() -> None:
    """Here nothing hides it."""
    check_engine()
    assert errors().CortexError is CortexError


def test_the_first_use_in_python_says_why(folder: Path) -> None:
    """And no `No module named engine.frozen`."""
    done = python(folder, "-c", LOAD)
    assert done.returncode == 1
    assert "HiddenEngineError: cortexc: its package `engine` should be at" in done.stderr
    assert CURE in done.stderr
    assert "ModuleNotFoundError" not in done.stderr


def test_it_is_caught_like_any_other(folder: Path) -> None:
    """By the name that the front door has; the other package stays what it is."""
    done = python(folder, "-c", CAUGHT)
    assert done.returncode == 0, done.stderr
    message, cure = done.stdout.splitlines()
    assert message.startswith(
        f"its package `engine` should be at {ROOT / 'engine'} but was found at {folder.resolve()}"
    )
    assert cure == CURE


def test_the_command_says_why(folder: Path) -> None:
    """In its own way, two lines that name the other one, and as its one document."""
    done = python(folder, "-m", "cortex_dsl", EXAMPLE)
    assert done.returncode == 2
    assert str(folder / "engine") in done.stderr
    assert len(done.stderr.splitlines()) == 2
    assert done.stderr.startswith("cortexc: its package `engine` should be at ")
    assert done.stderr.endswith(f"  help: {CURE}\n")
    assert '"schema": "cortexc/error"' in python(folder, "-m", "cortex_dsl", EXAMPLE, "--check", "--json").stdout
