"""A session without a terminal, and sessions that are processes of their own."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from cortex_dsl.console.terminal import Terminal
from cortex_dsl.repl.loop import do
from cortex_dsl.repl.state import State
from tests.fork_server import RUN, Ended, ForkServer

ROOT = Path(__file__).parents[3]
LEFT_TURN = ROOT / "examples" / "left_turn.scn"


@dataclass(frozen=True)
class Said:
    """What a session printed."""

    out: str
    err: str


@dataclass(frozen=True)
class Talk:
    """A state, and a way to enter chunks."""

    state: State
    capsys: pytest.CaptureFixture[str]

    def __call__(self, *chunks: str) -> Said:
        self.capsys.readouterr()
        for chunk in chunks:
            do(self.state, chunk)
        captured = self.capsys.readouterr()
        assert not self.state.bugs, captured.err
        return Said(captured.out, captured.err)

    @property
    def text(self) -> str:
        return self.state.draft.text


@pytest.fixture
def talk(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Talk:
    """A session as from a pipe, 100 columns wide and 25 lines high."""
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.setenv("LINES", "25")
    return Talk(State(Terminal(colour=False)), capsys)


@pytest.fixture
def piped(command_server: ForkServer, tmp_path: Path) -> Callable[..., Ended]:
    """`cortexc repl ARGUMENTS < script`, in a folder of its own."""

    def run(script: str | bytes, *arguments: object, **environment: str) -> Ended:
        return command_server.run(RUN, "repl", *arguments, at=tmp_path, given=script, COLUMNS="100", **environment)

    return run
