"""What only reads the language answers at once: it never loads what takes long to load."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.fork_server import ForkServer

LEAVES_ALONE = """
import gc, os, signal, sys

def state():
    handlers = {number: signal.getsignal(number) for number in signal.valid_signals()}
    streams = (sys.stdin, sys.stdout, sys.stderr)
    errors = tuple(stream.errors for stream in streams)
    return dict(os.environ), gc.get_threshold(), streams, errors, handlers, os.getcwd()

main(["--help"])
before = state()
code = main(sys.argv[1:])
assert state() == before, [pair for pair in zip(before, state()) if pair[0] != pair[1]]
sys.exit(code)
"""
PROGRAM = """
import sys
from cortex_dsl.cli import main
code = main(sys.argv[2:])
loaded = sorted(set(sys.argv[1].split(",")) & set(sys.modules))
sys.exit(f"loaded: {loaded}" if loaded else code)
"""


def run(forbidden: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", PROGRAM, forbidden, *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)


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


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (["--check"], 0),
        (["--emit", "tree"], 0),
        ([], 0),
        (["--ga", "--generations", "2", "--population", "10", "--out", "run"], 0),
        (["--no-such-option"], 2),
    ],
)
def test_main_leaves_the_process_alone(
    arguments: list[str], code: int, command_server: ForkServer, left_turn: Path, tmp_path: Path
) -> None:
    """Environment, collector of garbage, streams, signal handlers and folder are as before: `main` is a function
    that tests and notebooks call, too.
    """
    ended = command_server.run(LEAVES_ALONE, left_turn, *arguments, at=tmp_path)
    assert ended.status == code, ended.err


def test_the_process_sets_itself_up() -> None:
    """What a command of its own spares itself is set up before anything else is imported."""
    program = """
import gc, os, runpy, sys
sys.argv = ["cortexc", "--version"]
try:
    runpy.run_module("cortex_dsl", run_name="__main__")
except SystemExit as end:
    assert end.code == 0
assert os.environ["OPENBLAS_NUM_THREADS"] == "1"
from cortex_dsl.__main__ import NEW_BEFORE_A_LOOK
assert gc.get_threshold()[0] == NEW_BEFORE_A_LOOK
assert sys.stdout.errors == "plain"
"""
    environment = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, env=environment, check=False)
    assert done.returncode == 0, done.stderr


OPENS_NO_PAGE = """
import sys
opened = []
sys.addaudithook(lambda event, found: opened.append(str(found[0])) if event in ("open", "os.listdir") else None)
from cortex_dsl.cli import main
from cortex_dsl.installation import HOME
main(sys.argv[1:])
pages = [name for name in opened if name.startswith(str(HOME / "cortex_dsl" / "codes"))]
sys.exit(f"opened: {pages}" if pages or sys.argv[1] not in opened else 0)
"""


@pytest.mark.parametrize("text", ["x = 3 +\n", "ego = new Car on road\nrequire ego.sped < 3 m/s\n", "# later\n"])
def test_a_check_opens_no_page_of_a_code(text: str, tmp_path: Path) -> None:
    """Only `explain` and the site read the folders of diagnostics: a check that reports a code opens none."""
    own = tmp_path / "own.scn"
    own.write_text(text)
    command = [sys.executable, "-c", OPENS_NO_PAGE, str(own), "--check"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
