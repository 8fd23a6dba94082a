"""A process that imports once what many others need, and forks one of them for each piece of code.

What Python, numba and the kernels need to start is then paid once, not for each process that a test kills or asks.
"""

import json
import os
import select
import signal
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
SERVING = """
import json, os, sys, traceback

def begin(code, words, folder, environment, files, alone):
    if alone:
        os.setsid()  # a terminal that is opened now belongs to this process
    for number, (name, flags) in enumerate(zip(files, (os.O_RDONLY, os.O_RDWR, os.O_RDWR))):
        os.dup2(os.open(name, flags), number)
    sys.stdin = sys.__stdin__ = open(0, closefd=False)
    sys.stdout = sys.__stdout__ = open(1, "w", closefd=False)
    sys.stderr = sys.__stderr__ = open(2, "w", 1, errors="backslashreplace", closefd=False)
    os.chdir(folder)
    for name, value in environment.items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value
    sys.argv[:] = ["-c", *words]
    exec(code, names)

def end(*request):
    status = 0
    try:
        begin(*request)
    except SystemExit as left:
        status = left.code if isinstance(left.code, int) else int(left.code is not None)
        if isinstance(left.code, str):
            print(left.code, file=sys.stderr)
    except BaseException:
        traceback.print_exc()
        status = 1
    try:
        sys.stdout.flush()
        sys.stderr.flush()
    finally:
        os._exit(status)

names = {"__name__": "__main__"}
exec(sys.argv[1], names)
for line in sys.stdin:
    child = os.fork()
    if child == 0:
        end(*json.loads(line))
    print(child, file=sys.__stdout__, flush=True)
    status = None
    while status is None or os.WIFSTOPPED(status):
        _, status = os.waitpid(child, os.WUNTRACED)
        print(status, file=sys.__stdout__, flush=True)
"""
COMMAND = """
import contextlib, io, os, sys, tempfile
from cortex_dsl.__main__ import process
from cortex_dsl.cli import main
import cortex_dsl.repl.loop, prompt_toolkit.shortcuts
from tests.children import obey_modes

with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
    search = ("--ga", "--generations", "1", "--population", "10", "--jobs", "1", "--out", folder + "/run")
    assert main([{example!r}, *search]) == 0
""".format(example=str(ROOT / "examples" / "left_turn.scn"))
"""Loads what the command and its session need; `process()` then is `cortexc` with the words of `sys.argv`."""
RUN = "sys.exit(process())"
PATIENCE = 600.0
"""Longest wait for an answer [s]; before the first one the prelude may compile kernels."""


@dataclass(frozen=True)
class Ended:
    """What a process left: its exit status, below 0 for the signal that killed it, and what it said."""

    status: int
    out: str
    err: str


@dataclass(frozen=True)
class Running:
    """A process that was forked; the next one begins when this one has ended."""

    pid: int
    server: "ForkServer"

    def is_running(self) -> bool:
        """Return whether the process has neither stopped nor ended."""
        return not self.server.has_answer()

    def wait_until_stopped(self) -> None:
        """Return once the process has stopped itself; fail if it ends before."""
        status = self.server.answer(self.pid)
        assert os.WIFSTOPPED(status), self.server.ended(status)

    def end(self) -> Ended:
        """Wait until the process has ended."""
        status = self.server.answer(self.pid)
        while os.WIFSTOPPED(status):
            status = self.server.answer(self.pid)
        return self.server.ended(status)


class ForkServer:
    """A process that has run `prelude` and forks for each piece of code; to be used in a `with`."""

    def __init__(self, prelude: str, folder: Path, *flags: str, environment: dict[str, str] | None = None) -> None:
        """`folder`: an empty one, to stand in and to keep what processes read and say; `flags` are Python's."""
        self.given, self.said = folder / "in", (folder / "out", folder / "err")
        command = [sys.executable, *flags, "-c", SERVING, prelude]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, cwd=folder, env=environment, stdin=pipe, stdout=pipe, text=True)
        self.heard = b""

    def start(
        self,
        code: str,
        *words: object,
        at: Path | None = None,
        given: str | bytes = "",
        files: Sequence[str] = (),
        alone: bool = False,
        **environment: str | None,
    ) -> Running:
        """Start code that knows the prelude's names, with these arguments and changes of the environment.

        It reads `given` and its output is kept, or it has three `files` of its own; `alone`: in its own session.
        """
        self.given.write_bytes(given.encode() if isinstance(given, str) else given)
        for file in self.said:
            file.write_text("", encoding="utf-8")
        streams = [*files] or [str(self.given), *map(str, self.said)]
        request = [code, [str(word) for word in words], str(at or Path.cwd()), environment, streams, alone]
        assert self.process.stdin is not None
        self.process.stdin.write(json.dumps(request) + "\n")
        self.process.stdin.flush()
        return Running(self.answer(self.process.pid), self)

    def run(self, code: str, *words: object, **options: Any) -> Ended:
        """As `start`, and wait until the process has ended."""
        return self.start(code, *words, **options).end()

    def answer(self, pid: int) -> int:
        """Return the next number that the server tells: of a process, or how it stopped or ended.

        If there is none within `PATIENCE`, kill the process `pid` and raise TimeoutError with what it said.
        """
        assert self.process.stdout is not None
        pipe, patience = self.process.stdout.fileno(), PATIENCE
        while b"\n" not in self.heard:
            if not select.select([pipe], [], [], patience)[0]:
                os.kill(pid, signal.SIGKILL)
                if pid != self.process.pid:
                    self.answer(self.process.pid)  # its status, so that the next answer is that of the next process
                said = "".join(file.read_text(encoding="utf-8", errors="replace") for file in self.said)
                raise TimeoutError(f"process {pid} did nothing for {patience:g} s, and was killed; it said {said!r}")
            part = os.read(pipe, 4096)
            assert part, "the server has ended"
            self.heard += part
        line, _, self.heard = self.heard.partition(b"\n")
        return int(line)

    def has_answer(self) -> bool:
        """Return whether there is an answer that nobody has read."""
        assert self.process.stdout is not None
        return b"\n" in self.heard or bool(select.select([self.process.stdout], [], [], 0.0)[0])

    def ended(self, status: int) -> Ended:
        """Return what a process left, by its status as `waitpid` tells it."""
        out, err = (file.read_text(encoding="utf-8") for file in self.said)
        return Ended(os.waitstatus_to_exitcode(status) if not os.WIFSTOPPED(status) else status, out, err)

    def __enter__(self) -> "ForkServer":
        return self

    def __exit__(self, *_: object) -> None:
        self.process.communicate()
        assert self.process.returncode == os.EX_OK
