"""Sessions at a real pseudo-terminal, seen through a terminal emulator."""

import fcntl
import os
import select
import signal
import struct
import termios
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pyte
import pytest

from tests.fork_server import RUN, ForkServer

from .conftest import LEFT_TURN

UP, CTRL_C, CTRL_D = "\x1b[A", "\x03", "\x04"
PATIENCE = 300.0
"""Seconds that kernels may take to be compiled, and a session to end, however busy the machine is."""


class Screen:
    """A session and what its user sees."""

    def __init__(
        self, server: ForkServer, folder: Path, *arguments: str, term: str = "xterm-256color", columns: int = 100
    ) -> None:
        environment: dict[str, Any] = dict.fromkeys(("NO_COLOR", "COLUMNS", "LINES"))
        environment |= {"TERM": term, "XDG_STATE_HOME": str(folder / "state")}
        self.ours, self.theirs = os.openpty()
        self.set_size(60, columns)
        files = [os.ttyname(self.theirs)] * 3
        self.session = server.start(RUN, "repl", *arguments, at=folder, files=files, alone=True, **environment)
        self.raw, self.has_ended = b"", False
        self.screen = pyte.Screen(columns, 60)
        self.screen.write_process_input = self.type  # pyright: ignore[reportAttributeAccessIssue]  # pyte asks for it
        self.stream = pyte.ByteStream(self.screen)

    def set_size(self, lines: int, columns: int) -> None:
        fcntl.ioctl(self.theirs, termios.TIOCSWINSZ, struct.pack("HHHH", lines, columns, 0, 0))

    @property
    def text(self) -> str:
        return "\n".join(line.rstrip() for line in self.screen.display)

    def type(self, keys: str | bytes) -> None:
        os.write(self.ours, keys.encode() if isinstance(keys, str) else keys)

    def send(self, keys: str, expected: str, times: int = 1) -> None:
        """Type, and wait until a text stands on the screen so many times."""
        self.type(keys)
        self.wait(expected, times)

    def wait(self, expected: str, times: int = 1) -> None:
        self._read_until(lambda: self.text.count(expected) >= times)
        assert "Traceback" not in self.text

    def press_ctrl_d(self, expected: str = "") -> None:
        """Type it at an empty prompt: between two prompts the terminal itself takes the key, and the session never sees
        it. `expected`: a text that the session answers; "": the session ends.
        """
        self._read_until(lambda: self.screen.display[self.screen.cursor.y].strip() == "scn>")
        self.send(CTRL_D, expected)

    def _read_until(self, is_there: Callable[[], bool]) -> None:
        deadline = time.monotonic() + PATIENCE
        while not is_there():
            assert time.monotonic() < deadline, self.text
            self._read(0.05)

    def _read(self, patience: float) -> bool:
        """Show what the session has written meanwhile; False once its terminal is closed."""
        try:
            read = os.read(self.ours, 65536) if select.select([self.ours], [], [], patience)[0] else b""
        except OSError:
            return False
        self.raw += read
        self.stream.feed(read)
        return True

    def end(self) -> int:
        """Return the exit status, once the session has ended."""
        self.has_ended = True
        os.close(self.theirs)
        deadline = time.monotonic() + PATIENCE
        while self._read(0.05):
            if time.monotonic() > deadline:
                os.kill(self.session.pid, signal.SIGKILL)
                self.session.end()
                raise AssertionError(f"the session did not end:\n{self.text}")
        os.close(self.ours)
        return self.session.end().status


Start = Callable[..., Screen]


@pytest.fixture
def start(command_server: ForkServer, tmp_path: Path) -> Iterator[Start]:
    """Start a session with these arguments at a terminal of its own; one that a failed test has left is killed."""
    screens: list[Screen] = []

    def begin(*arguments: str, **options: Any) -> Screen:
        screens.append(Screen(command_server, tmp_path, *arguments, **options))
        return screens[-1]

    yield begin
    for screen in screens:
        if not screen.has_ended:
            os.kill(screen.session.pid, signal.SIGKILL)
            screen.end()


def test_typing_at_a_terminal(start: Start, tmp_path: Path) -> None:
    """Tab completes, a mistake comes back by arrow up, a block ends with a blank line, Ctrl-D asks once."""
    screen = start(columns=80)
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
    screen.press_ctrl_d("not saved")
    screen.press_ctrl_d()
    assert screen.end() == 0
    assert "require SPEEDD > 50 km/h" in (tmp_path / "state" / "cortexc" / "history").read_text()


@pytest.mark.parametrize("typed", ["    wait", "\x1b[200~    wait\x1b[201~"])
def test_a_line_that_begins_with_blanks_is_taken_as_it_is(start: Start, tmp_path: Path, typed: str) -> None:
    """Typed or pasted, it replaces the indentation that Enter wrote."""
    screen = start(columns=80)
    screen.wait("still to come: ego")
    screen.send("behavior Go():\r", "...")
    screen.send(f"{typed}\r\r", "scn>", 2)
    screen.press_ctrl_d("not saved")
    screen.press_ctrl_d()
    assert screen.end() == 0
    history = (tmp_path / "state" / "cortexc" / "history").read_text()
    assert "+behavior Go():\n+    wait\n" in history


def test_ctrl_c_ends_a_search_and_not_the_session(start: Start) -> None:
    """What was found until then is shown, and the session goes on."""
    screen = start(str(LEFT_TURN), columns=120)
    screen.wait("accepted")
    screen.send(":ga 5000\r", "generation 1")
    screen.send(CTRL_C, "interrupted")
    screen.send(":seed\r", "seed 0\n")
    screen.press_ctrl_d()
    assert screen.end() == 0


def test_a_dumb_terminal(start: Start) -> None:
    """Prompts, but nothing that moves a cursor or colours a word."""
    screen = start(term="dumb")
    screen.wait("scn>")
    screen.send("behavior Go():\r    wait\r\r", "scn>", 2)
    screen.send("V * 2\r", "scn>", 3)
    assert "SCN201" in screen.text
    screen.send(CTRL_C, "scn>", 4)
    screen.send(":list\r", "behavior Go():", 2)
    screen.press_ctrl_d("not saved")
    screen.press_ctrl_d()
    assert screen.end() == 0
    assert b"\x1b" not in screen.raw


def test_a_history_that_cannot_be_written(start: Start, tmp_path: Path) -> None:
    """The session keeps its history for itself."""
    (tmp_path / "state").write_text("a file where a folder should be")
    screen = start()
    screen.send("x = 1 m\r", "session *")
    screen.send(UP, "scn> x = 1 m", 2)
    screen.type(CTRL_C)
    screen.press_ctrl_d("not saved")
    screen.press_ctrl_d()
    assert screen.end() == 0


def test_odd_moments(start: Start, tmp_path: Path) -> None:
    """The window changes in the middle of a block, the session is stopped and goes on, Ctrl-D does not lose a block,
    Ctrl-C while nothing runs and bytes that are no text do no harm, and the file disappears.
    """
    (tmp_path / "a.scn").write_text("x = 1 m\n")
    screen = start("a.scn")
    screen.wait("still to come: ego")
    screen.send("behavior Go():\r", "...")
    screen.type("wai")
    for columns, lines in ((20, 20), (10, 5), (100, 60)):
        screen.set_size(lines, columns)
    for number in (signal.SIGTSTP, signal.SIGCONT):
        os.kill(screen.session.pid, number)
    screen.type(CTRL_D)
    screen.send("t\r\r", "scn>", 2)
    screen.send(":list\r", "wait", 2)
    screen.type(CTRL_C + CTRL_C)
    screen.type(b"y = 1 \xff\xfe m\r")
    screen.wait("SCN118")
    (tmp_path / "a.scn").unlink()
    screen.send(":load b.scn\r", "N]")
    screen.send("y\r", "there is no file `b.scn`")
    screen.send(":save\r", "saved a.scn")
    screen.press_ctrl_d()
    assert screen.end() == 0
    assert "behavior Go():\n    wait\n" in (tmp_path / "a.scn").read_text()
