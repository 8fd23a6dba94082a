"""Processes that are forked from one that is loaded: the one that never ends is told."""

from pathlib import Path

import pytest

from tests import fork_server
from tests.fork_server import ForkServer


def test_a_process_that_hangs_is_killed_and_the_next_one_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also one that has stopped itself; the error holds what it printed."""
    with ForkServer("import os, signal, sys, time", tmp_path) as server:
        assert server.run("print(1)").out == "1\n"
        monkeypatch.setattr(fork_server, "PATIENCE", 0.3)
        for code in ("time.sleep(600)", "os.kill(os.getpid(), signal.SIGSTOP)"):
            with pytest.raises(TimeoutError, match=r"did nothing for 0\.3 s, and was killed; it said 'begins"):
                server.run(f"print('begins', flush=True); {code}")
        monkeypatch.undo()
        assert server.run("sys.exit(3)").status == 3
