"""The process of a stack: its start, its pipes and shared memory, and its end (`engine.driving.stacks`).

It gets two pipes and, if the system supports it, shared memory; its output goes to a log. At the end its whole session
is killed.
"""

import math
import mmap
import os
import signal
import subprocess
import tempfile
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from itertools import accumulate
from typing import IO

import numpy as np

from engine.errors import ControllerError

ROOM = 1 << 20
"""Size of the pipe to it [bytes]; Linux provides 65,536 by default, and to users at most this size."""
ALIGNED = 64
"""Alignment of each part of a question in memory [bytes]."""


class Memory:
    """Shared memory of questions and answers: `views` are their parts, in the order of the protocol."""

    def __init__(self, lanes: int, observations: int, actions: int) -> None:
        parts: dict[str, tuple[tuple[int, ...], str]] = {
            "number": ((1,), "<i8"),
            "times": ((lanes,), "<f8"),
            "keys": ((lanes, 6), "<i8"),
            "fresh": ((lanes,), "?"),
            "asked": ((lanes,), "?"),
            "observations": ((lanes, observations), "<f8"),
            "actions": ((lanes, actions), "<f8"),
        }
        bytes_of = (np.dtype(kind).itemsize * math.prod(shape) for shape, kind in parts.values())
        *starts, size = accumulate((-(-each // ALIGNED) * ALIGNED for each in bytes_of), initial=0)
        self.layout = {"size": size, **dict(zip(parts, starts, strict=True))}
        """Layout for the stack: size, and first byte of each part [bytes]."""
        self.descriptor = os.memfd_create("cortexc", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        try:
            os.ftruncate(self.descriptor, size)
            _seal(self.descriptor)
            room = mmap.mmap(self.descriptor, size)
        except (AttributeError, OSError):
            os.close(self.descriptor)
            raise
        self.views = {name: np.ndarray(*part, room, self.layout[name]) for name, part in parts.items()}

    @staticmethod
    def of(lanes: int, observations: int, actions: int) -> "Memory | None":
        """Return new memory; None if the system has none that two processes share."""
        try:
            return Memory(lanes, observations, actions)
        except (AttributeError, OSError):
            return None


def _seal(descriptor: int) -> None:
    """Fix the size of memory: the system kills a process that reads memory after it was cut off."""
    import fcntl

    fcntl.fcntl(descriptor, fcntl.F_ADD_SEALS, fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW | fcntl.F_SEAL_SEAL)


@dataclass
class Process:
    """A stack that has been started."""

    process: "subprocess.Popen[bytes]"
    read: int
    write: int
    log: IO[bytes]
    memory: Memory | None
    """Memory for questions and answers; None if the pipes carry them."""
    questions: int = 0
    closed: bool = False

    def close(self, patience: float = 0.5) -> None:
        """Close the pipes, and kill a process that does not end within `patience` [s]."""
        if self.closed:
            return
        self.closed = True
        for pipe in (self.read, self.write):
            with suppress(OSError):
                os.close(pipe)
        with suppress(subprocess.TimeoutExpired):
            self.process.wait(patience)
        with suppress(OSError):
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()
        self.log.close()
        self.memory = None


def start(command: Sequence[str], memory: Memory | None) -> Process:
    """Start a stack.

    Raises:
        ControllerError: it cannot be started.
    """
    with ExitStack() as ours, ExitStack() as theirs:
        numbers = {} if memory is None else {"CORTEXC_MEMORY": memory.descriptor}
        if memory is not None:
            theirs.callback(os.close, memory.descriptor)
        try:
            numbers["CORTEXC_READ"], write = _pipe(theirs, ours)
            read, numbers["CORTEXC_WRITE"] = _pipe(ours, theirs)
            log = ours.enter_context(tempfile.TemporaryFile())
            process = subprocess.Popen(  # noqa: S603 - the very command that the user names
                command,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                env={**os.environ, **{name: str(number) for name, number in numbers.items()}},
                pass_fds=tuple(numbers.values()),
                start_new_session=True,
            )
        except OSError as error:
            raise ControllerError(
                f"`{command[0]}` cannot be started: {(error.strerror or str(error)).lower()}",
                "name a program that there is, as `process:./my_stack --fast`",
            ) from error
        ours.pop_all()  # `Process.close` closes them
    os.set_blocking(write, False)
    _widen(write)
    return Process(process, read, write, log, memory)


def _pipe(reads: ExitStack, writes: ExitStack) -> tuple[int, int]:
    """Return the ends of a pipe, each closed with its stack."""
    read, write = os.pipe()
    reads.callback(os.close, read)
    writes.callback(os.close, write)
    return read, write


def _widen(pipe: int) -> None:
    """Enlarge a pipe to hold a whole question, if the system permits, so that the process wakes once per question."""
    with suppress(ImportError, AttributeError, OSError):
        import fcntl

        fcntl.fcntl(pipe, fcntl.F_SETPIPE_SZ, ROOM)
