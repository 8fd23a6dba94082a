"""`cortexc` as a process that is at work at once: a fork of this one, which has imported and compiled already.

Starting Python and loading kernels takes longer than what is to be disturbed, and most kills would hit that.
"""

import io
import multiprocessing
import os
import signal
import sys
import tempfile
import threading
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from functools import cache
from multiprocessing.context import ForkProcess
from pathlib import Path
from typing import IO

from benchmarks.kills import children_of
from cortex_dsl.__main__ import process
from cortex_dsl.cli import main

FILE = Path("examples/left_turn.scn").resolve()


class DiffersError(Exception):
    """Something was lost, or is another."""


@dataclass(frozen=True)
class Command:
    """One `cortexc`, in a session of its own, and what it says on stderr."""

    process: ForkProcess
    said: IO[bytes]

    def ended(self) -> int:
        """Wait for it, and return its exit code.

        Raises:
            DiffersError: it answered with a traceback.
        """
        self.process.join()
        self.said.seek(0)
        said = self.said.read().decode(errors="replace")
        self.said.close()
        if "Traceback" in said or "a bug in cortexc" in said:
            raise DiffersError(said[-2000:])
        return self.process.exitcode or 0

    def killed_after(self, seconds: float, child: bool = False) -> bool:
        """Kill it, or one of its children alone, after some time; whether there was one to kill."""
        self.process.join(seconds)
        assert self.process.pid is not None
        if self.process.exitcode is not None:
            self.ended()
            return False
        if child:
            victims = children_of(self.process.pid)[-1:]
            for victim in victims:
                os.kill(victim, signal.SIGKILL)
            return bool(victims)
        os.killpg(self.process.pid, signal.SIGKILL)
        self.process.join()
        self.said.close()
        return True


def command(*words: object) -> Command:
    """Start `cortexc` with these words."""
    warm()
    said = tempfile.TemporaryFile()  # noqa: SIM115 - open as long as the command
    started = multiprocessing.get_context("fork").Process(target=_run, args=(list(map(str, words)), said))
    started.start()
    while os.getpgid(started.pid or 0) != started.pid:  # a group that is killed must not be ours
        os.sched_yield()
    return Command(started, said)


def _run(words: list[str], said: IO[bytes]) -> None:
    """Be `cortexc`, in this fork."""
    os.setsid()
    with Path(os.devnull).open("r+b") as nowhere:
        for stream, its in ((0, nowhere), (1, nowhere), (2, said)):
            os.dup2(its.fileno(), stream)
    sys.stdin, sys.stdout, sys.stderr = (os.fdopen(number, mode) for number, mode in ((0, "r"), (1, "w"), (2, "w")))
    sys.argv = ["cortexc", *words]
    sys.exit(process())


@cache
def warm() -> None:
    """Load what commands need, once, in one thread: what has threads cannot be forked."""
    with tempfile.TemporaryDirectory() as folder, redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
        run, few = str(Path(folder, "run")), ("--generations", "1", "--population", "4", "--seed", "1", "--jobs", "1")
        for words in (
            [str(FILE), "--ga", *few, "--out", run],
            ["export", run, "--to", "xosc,csv,commonroad", "--out", str(Path(folder, "cases"))],
            ["study", str(FILE), "--methods", "ga,random", "--runs", "1", *few, "--out", str(Path(folder, "study"))],
        ):
            main(words)
    assert threading.active_count() == 1
