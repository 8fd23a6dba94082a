"""What only reads the language answers at once: it never loads what takes long to load."""

import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = """
import sys
from cortex_dsl.cli import main
code = main(sys.argv[2:])
loaded = sorted(set(sys.argv[1].split(",")) & set(sys.modules))
sys.exit(f"loaded: {loaded}" if loaded else code)
"""


def run(forbidden: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", PROGRAM, forbidden, *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)


@pytest.mark.parametrize("arguments", [["--help"], ["--version"]])
def test_help_loads_nothing(arguments: list[str]) -> None:
    """Help needs neither numbers nor a parser nor a renderer."""
    done = run("numba,scipy,pymunk,numpy,lark,rich", *arguments)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("arguments", [["--check"], ["--emit", "tree"], ["--emit", "ast"], ["--emit", "program"]])
def test_compiling_never_loads_the_kernels(arguments: list[str], left_turn: Path) -> None:
    """The compiler is free of numba, scipy and pymunk."""
    done = run("numba,scipy,pymunk", str(left_turn), *arguments)
    assert done.returncode == 0, done.stderr


def test_a_usage_error_loads_nothing() -> None:
    """A slip on the command line is answered before anything is loaded."""
    done = run("numba,scipy,pymunk,numpy,lark,rich", "a.scn", "--population", "1")
    assert done.returncode == 2, done.stderr
