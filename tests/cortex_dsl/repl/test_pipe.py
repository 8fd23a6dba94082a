"""Sessions whose input is a script: what they print, and their exit codes."""

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.fork_server import Ended

from .conftest import LEFT_TURN, ROOT

Piped = Callable[..., Ended]


def test_a_fine_script_is_quiet(piped: Piped) -> None:
    """No banner, no prompts, no echo."""
    done = piped("param V = Range(1, 9) m/s\nego = new Car on road,\n    with speed V\nV * 2\n")
    assert (done.status, done.out, done.err) == (0, "a speed, 2 to 18 m/s\n", "")


@pytest.mark.parametrize(
    ("script", "code"),
    [
        ("", 0),
        (":quit\nnonsense here\n", 0),
        ("x = 1 m + 1 s\ny = 2\n", 1),
        (":nonsense\n", 1),
        ("param V = Range(1, 9) m/s\nego = new Car on road\nrequire V > 5 m/s\nrequire V < 4 m/s\n:sample 100\n", 3),
        ("\x00\x07\ud800", 1),
    ],
    ids=["empty", "quit", "mistake", "command", "no scene", "garbage"],
)
def test_exit_codes(piped: Piped, script: str, code: int) -> None:
    """Mistakes come before a scene that was not found; what follows a mistake is done all the same."""
    done = piped(script.encode("utf-8", errors="surrogatepass"))
    assert done.status == code, done.err
    assert "Traceback" not in done.err


def test_a_file_and_a_script(piped: Piped, tmp_path: Path) -> None:
    """`cortexc repl FILE < script` goes on where the file ends."""
    done = piped(f":save {tmp_path / 'copy.scn'}\nrequire EGO_SPEED > 70 km/h\n", LEFT_TURN)
    assert done.status == 0, done.err
    assert "of draws accepted" in done.out
    assert (tmp_path / "copy.scn").read_text() == LEFT_TURN.read_text()


def test_a_file_that_does_not_exist(piped: Piped) -> None:
    """A usage error, as everywhere."""
    done = piped("", "nowhere.scn")
    assert done.status == 2
    assert "there is no file" in done.err


def test_an_interrupt_ends_a_script(tmp_path: Path) -> None:
    """SIGINT while a pipe is being read: 130, no traceback."""
    process = subprocess.Popen(
        [sys.executable, "-m", "cortex_dsl", "repl"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write(":seed\n")
    process.stdin.flush()
    assert process.stdout.readline() == "seed 0\n"
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=300)
    assert process.returncode == 130
    assert "Traceback" not in err


@pytest.mark.parametrize("name", [".", "/", "~nobody-of-that-name/x", "a\0b"])
@pytest.mark.parametrize("command", [":save", ":save!", ":load"])
def test_odd_paths_are_refused(piped: Piped, command: str, name: str) -> None:
    """What cannot be a scenario's file is said in a line, and the session goes on."""
    done = piped(f"x = 1\n{command} {name}\n2 m\n")
    assert (done.status, done.out) == (1, "a length, 2 m\n")
    assert "a bug" not in done.err
    assert done.err
