"""Whatever happens to one chunk, the session goes on."""

from pathlib import Path

import pytest

from cortex_dsl.console.terminal import Terminal
from cortex_dsl.repl import commands, loop
from cortex_dsl.repl.state import State


class Script:
    """Chunks from a list; an exception in it is raised."""

    def __init__(self, *chunks: str | type[BaseException] | None) -> None:
        self.chunks = list(chunks)

    def read(self) -> str | None:
        chunk = self.chunks.pop(0) if self.chunks else None
        if isinstance(chunk, type):
            raise chunk
        return chunk


def state_with(*, interactive: bool) -> State:
    return State(Terminal(colour=False), interactive=interactive)


def test_a_bug_is_reported_and_the_session_goes_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """70 at the end of a script; what comes after the bug is done."""

    def broken(state: State, chunk: str) -> None:
        raise RuntimeError("oh")

    monkeypatch.delenv("CORTEXC_DEBUG", raising=False)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr(loop, "execute", broken)
    state = state_with(interactive=False)
    assert loop.run(state, Script(":list", "x = 1 m")) == 70
    assert state.draft.text == "x = 1 m\n"
    err = capsys.readouterr().err
    assert "a bug in cortexc" in err
    assert "Traceback" not in err


def test_an_interrupt_leaves_a_script_and_not_a_terminal() -> None:
    """130 is up to the command around it."""
    with pytest.raises(KeyboardInterrupt):
        loop.run(state_with(interactive=False), Script(KeyboardInterrupt))
    assert loop.run(state_with(interactive=True), Script(KeyboardInterrupt, "quit")) == 0


@pytest.mark.parametrize("leave", [None, ":quit"])
def test_unsaved_work_is_asked_for_once(leave: str | None, capsys: pytest.CaptureFixture[str]) -> None:
    """Ctrl-D or :quit; whatever is entered in between begins the asking anew."""
    script = Script("x = 1 m", leave, ":seed", leave, leave, ":seed 9")
    state = state_with(interactive=True)
    assert loop.run(state, script) == 0
    assert capsys.readouterr().out.count("not saved") == 2
    assert state.seed == 0


def test_every_command_has_its_function() -> None:
    """A row carries the function of its own name."""
    for row in commands.COMMANDS.values():
        assert getattr(row.function, "__name__", "") == f"do_{row.name}"
    assert set(commands.SAME.values()) <= set(commands.COMMANDS)
