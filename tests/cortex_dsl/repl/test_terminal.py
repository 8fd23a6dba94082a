"""Sessions at a real pseudo-terminal, seen through a terminal emulator."""

import os
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pexpect
import pyte
import pytest

from .conftest import LEFT_TURN, ROOT

UP, CTRL_C, CTRL_D = "\x1b[A", "\x03", "\x04"
PATIENCE = 300.0
"""Seconds that kernels may take to be compiled, and a session to end, however busy the machine is."""


def hear_interrupts() -> None:
    """In a child: let Ctrl-C reach it, though a shell that runs the tests in the background has it ignored."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


class Screen:
    """A session and what its user sees."""

    def __init__(self, folder: Path, *arguments: str, term: str = "xterm-256color", columns: int = 100) -> None:
        environment = {**os.environ, "TERM": term, "PYTHONPATH": str(ROOT), "XDG_STATE_HOME": str(folder / "state")}
        for name in ("NO_COLOR", "COLUMNS", "LINES"):
            environment.pop(name, None)
        self.process = pexpect.spawn(
            sys.executable,
            ["-m", "cortex_dsl", "repl", *arguments],
            dimensions=(60, columns),
            env=environment,
            cwd=str(folder),
            timeout=PATIENCE,
            preexec_fn=hear_interrupts,
        )
        self.screen = pyte.Screen(columns, 60)
        self.screen.write_process_input = self.process.send  # pyright: ignore[reportAttributeAccessIssue]  # pyte asks for it
        self.stream = pyte.ByteStream(self.screen)

    @property
    def text(self) -> str:
        return "\n".join(line.rstrip() for line in self.screen.display)

    def send(self, keys: str, expected: str, times: int = 1) -> None:
        """Type, and wait until a text stands on the screen so many times."""
        self.process.send(keys)
        self.wait(expected, times)

    def wait(self, expected: str, times: int = 1) -> None:
        self._read_until(lambda: self.text.count(expected) >= times)
        assert "Traceback" not in self.text

    def press_ctrl_d(self) -> None:
        """At an empty prompt: between two prompts the terminal itself takes the key, and the session never sees it."""
        self._read_until(lambda: self.screen.display[self.screen.cursor.y].strip() == "scn>")
        self.process.send(CTRL_D)

    def _read_until(self, is_there: Callable[[], bool]) -> None:
        deadline = time.monotonic() + PATIENCE
        while not is_there():
            assert time.monotonic() < deadline, self.text
            try:
                self.stream.feed(self.process.read_nonblocking(65536, 0.05))
            except pexpect.TIMEOUT:
                continue
            except pexpect.EOF:
                assert is_there(), self.text

    def end(self) -> int:
        self.process.expect(pexpect.EOF, timeout=PATIENCE)
        self.process.close()
        return int(self.process.exitstatus or 0)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Where the session is started."""
    return tmp_path


def test_typing_at_a_terminal(folder: Path) -> None:
    """Tab completes, a mistake comes back by arrow up, a block ends with a blank line, Ctrl-D asks once."""
    screen = Screen(folder, columns=80)
    screen.wait("still to come: ego")
    screen.send("param SPEED = Range(5, 80) km/h\r", "1 param")
    screen.send("require SPE\t", "require SPEED")
    screen.send("D > 50 km/h\r", "did you mean `SPEED`")
    screen.send(UP, "scn> require SPEEDD > 50 km/h", 2)
    screen.send("\x01" + "\x1b[C" * 13 + "\x1b[3~\r", "of draws accepted")
    screen.send("behavior Go():\r", "...")
    screen.send("wait\r\r", "scn>", 5)
    screen.send("ego = new Car on road,\r", "...", 3)
    screen.send("with speed SPEED\r", "1 actor")
    screen.send(":lits\r", "did you mean `:list`")
    screen.send("half a li" + CTRL_C, "scn> half a li")
    screen.press_ctrl_d()
    screen.wait("not saved")
    screen.press_ctrl_d()
    assert screen.end() == 0
    assert "require SPEEDD > 50 km/h" in (folder / "state" / "cortexc" / "history").read_text()


def test_ctrl_c_ends_a_search_and_not_the_session(folder: Path) -> None:
    """What was found until then is shown, and the session goes on."""
    screen = Screen(folder, str(LEFT_TURN), columns=120)
    screen.wait("accepted")
    screen.send(":ga 5000\r", "generation 1")
    screen.send(CTRL_C, "interrupted")
    screen.send(":seed\r", "seed 0\n")
    screen.press_ctrl_d()
    assert screen.end() == 0


def test_a_dumb_terminal(folder: Path) -> None:
    """Prompts, but nothing that moves a cursor or colours a word."""
    screen = Screen(folder, term="dumb")
    screen.wait("scn>")
    screen.send("behavior Go():\r    wait\r\r", "scn>", 2)
    screen.send("V * 2\r", "SCN201")
    screen.send(CTRL_C, "scn>", 4)
    screen.send(":list\r", "behavior Go():", 2)
    screen.press_ctrl_d()
    screen.wait("not saved")
    screen.press_ctrl_d()
    raw = screen.process.read()
    assert b"\x1b" not in raw
    assert screen.end() == 0


def test_a_history_that_cannot_be_written(folder: Path) -> None:
    """The session keeps its history for itself."""
    (folder / "state").write_text("a file where a folder should be")
    screen = Screen(folder)
    screen.send("x = 1 m\r", "session *")
    screen.send(UP, "scn> x = 1 m", 2)
    screen.send(CTRL_C + CTRL_D, "not saved")
    screen.press_ctrl_d()
    assert screen.end() == 0


def test_odd_moments(folder: Path) -> None:
    """The window changes in the middle of a block, the session is stopped and goes on, Ctrl-D does not lose a block,
    Ctrl-C while nothing runs and bytes that are no text do no harm, and the file disappears.
    """
    (folder / "a.scn").write_text("x = 1 m\n")
    screen = Screen(folder, "a.scn")
    screen.wait("still to come: ego")
    screen.send("behavior Go():\r", "...")
    screen.process.send("wai")
    for columns, lines in ((20, 20), (10, 5), (100, 60)):
        screen.process.setwinsize(lines, columns)
    for number in (signal.SIGTSTP, signal.SIGCONT):
        screen.process.kill(number)
    screen.process.send(CTRL_D)
    screen.send("t\r\r", "scn>", 2)
    screen.send(":list\r", "wait", 2)
    screen.process.send(CTRL_C + CTRL_C)
    os.write(screen.process.child_fd, b"y = 1 \xff\xfe m\r")
    screen.wait("SCN118")
    (folder / "a.scn").unlink()
    screen.send(":load b.scn\r", "N]")
    screen.send("y\r", "there is no file `b.scn`")
    screen.send(":save\r", "saved a.scn")
    screen.press_ctrl_d()
    assert screen.end() == 0
    assert "behavior Go():\n    wait\n" in (folder / "a.scn").read_text()
