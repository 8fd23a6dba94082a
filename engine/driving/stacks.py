"""A driver in its own process, in any language: `--ego process:COMMAND`.

The command is started unchanged, without a shell. It gets two pipes by their numbers, in `CORTEXC_READ` and
`CORTEXC_WRITE`; its output goes to a file, which error messages quote. Protocol, version 1:

1. We write one line of JSON: `version`, `controller`, `lanes` n, `observations` and `actions` (name and unit each, for
   actions `low` and `high`), `time_step` and `every` [s].
2. It answers with one line of JSON, `{"version": 1}`. If our line has `"warning": true`, warnings are read:
   with `"warning": true` in its own line, its actions have one more column, above 0.5 where it warns.
3. At each question we write, little-endian and without gaps: the number of the question (int64), the time of each lane
   [s] (n float64), the stream keys of their scenes (n x 6 int64), the lanes in which a new scene begins (n bytes, 0 or
   1), those that are asked (n bytes), and what they observe (n x d float64).
4. It answers with its actions (n x a float64); rows of lanes that are not asked are left.
5. We close the pipe when there is nothing more to ask. It ends.

A question about many lanes is half a megabyte, and to send it takes longer than a step. So, where the system has memory
that two processes share, our first line says as `memory` its `size` and from which byte on each part of a question, and
the `actions`, stand in it; `CORTEXC_MEMORY` is its number. A stack that adds `"memory": true` to its own first line is
sent the number of each question alone, reads the rest there, leaves its actions there, and answers with one byte.

A stack is killed with all processes that it has started, if it dies, hangs up, takes longer than `LATE` and `EACH` over
an answer, or answers more than it was asked; processes that have left its session, such as daemons, are not killed. A
stack that only starts another, and ends with exit code 0, has not died.
"""

import json
import math
import mmap
import os
import select
import shlex
import shutil
import signal
import subprocess
import tempfile
import time
import weakref
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from itertools import accumulate
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from engine.errors import ControllerError, LostError
from engine.strict_json import json_text
from engine.tables import Bools, Floats, Ints

# -- the process of a stack --------------------------------------------------------------------------------------------

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
            raise _not_started(command[0], (error.strerror or str(error)).lower()) from error
        ours.pop_all()  # `Process.close` closes them
    os.set_blocking(write, False)
    _widen(write)
    return Process(process, read, write, log, memory)


def _not_started(program: str, reason: str) -> ControllerError:
    cure = "name a program that there is, as `process:./my_stack --fast`"
    return ControllerError(f"`{program}` cannot be started: {reason}", cure)


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


VERSION = 1
LATE = 30.0
"""Time limit of an answer [s], plus `EACH` per row."""
EACH = 1.0
"""Additional time per row that is asked [s]; a stack that takes longer counts as stopped."""
BEGINNING = 120.0
"""Time limit of the answer to the first line [s]; the stack may load weights."""
GLANCE = 0.25
"""Interval of the checks whether a stack that does not answer is alive [s]."""
STARTS = 3
"""Maximum number of starts without an answer."""
TAIL = 300
"""Maximum number of characters of its output that a message quotes."""


@dataclass(eq=False)
class Stack:
    """A controller that is a process; it is started at the first question."""

    command: tuple[str, ...]
    _header: dict[str, Any] = field(default_factory=dict)
    _running: Process | None = None
    _columns: int = 0
    """Number of actions of a lane in its answers."""
    _starts: int = 0
    """Number of starts since it last answered a question."""
    _fresh: Bools = field(default_factory=lambda: np.zeros(0, dtype=bool))
    _keys: Ints = field(default_factory=lambda: np.zeros((0, 6), dtype=np.int64))
    _said: str = ""
    """Its output, once it has failed."""

    def meet(self, header: Mapping[str, Any]) -> None:
        """Set the header of the questions; a process with another header is closed, and started again at the next
        question.
        """
        if dict(header) != self._header:
            self.close()
            self._header = dict(header)
            self._fresh = np.zeros(header["lanes"], dtype=bool)
            self._keys = np.zeros((header["lanes"], 6), dtype=np.int64)

    def reset(self, lanes: Ints, keys: Ints) -> None:
        """Note the lanes in which new scenes begin, for the next question."""
        self._fresh[lanes] = True
        self._keys[lanes] = keys

    def act(self, observations: Floats, active: Bools, times: Floats | None = None) -> Floats:
        """Ask the stack.

        Raises:
            LostError: it has ended, or is late.
            ControllerError: it cannot be started, or speaks another version.
        """
        running = self._running or self._start()
        number, count = np.array([running.questions], dtype="<i8"), len(active)
        question: tuple[NDArray[Any], ...] = (
            number,
            (np.zeros(count) if times is None else times).astype("<f8", copy=False),
            self._keys.astype("<i8", copy=False),
            self._fresh,
            active,
            observations.astype("<f8", copy=False),
        )
        limit = LATE + EACH * int(np.count_nonzero(active))
        if running.memory is None:
            answer = self._answer(running, question, 8 * count * self._columns, limit)
            return np.frombuffer(answer, dtype="<f8").reshape(count, -1)
        views = running.memory.views
        for view, part in zip(views.values(), question, strict=False):
            view[:] = part
        self._answer(running, (number,), 1, limit)
        return views["actions"].ravel()[: count * self._columns].reshape(count, -1).copy()

    def _answer(self, running: Process, question: Sequence[NDArray[Any]], size: int, limit: float) -> bytes:
        """Send a question, and return its answer of `size` bytes from the pipe."""
        self._nothing_left(running, size)
        answer = self._exchange(running, [np.ascontiguousarray(each).data.cast("B") for each in question], size, limit)
        running.questions += 1
        self._starts, self._fresh[:] = 0, False
        return answer

    def close(self) -> None:
        """End the stack."""
        running, self._running = self._running, None
        if running is not None:
            running.close()

    # -- the process -------------------------------------------------------------------------------------------------

    def _start(self) -> Process:
        if os.name != "posix":
            raise ControllerError("a process drives by pipes, which this system does not pass on", "drive in Python")
        if self._starts == STARTS:
            raise ControllerError(
                f"`{shlex.join(self.command)}` was started {STARTS} times and never answered{self._said}",
                "what was finished before is kept; correct it, and go on with `cortexc resume`",
            )
        self._starts += 1
        self._fresh[:] = True  # a new process knows nothing of the scenes in progress
        actions = len(self._header["actions"]) + ("warning" in self._header)
        sizes = self._header["lanes"], len(self._header["observations"]), actions
        running = self._running = start(self.command, Memory.of(*sizes))
        weakref.finalize(self, running.close)
        memory = {} if running.memory is None else {"memory": running.memory.layout}
        line = json_text(self._header | memory, ascii_only=True).encode() + b"\n"
        if not self._shares(self._exchange(running, [memoryview(line)], -1, BEGINNING), offered=bool(memory)):
            running.memory = None
        return running

    def _shares(self, answer: bytes, *, offered: bool) -> bool:
        """Return True if a stack shares the memory, according to the line with which it answers the header.

        Raises:
            ControllerError: it uses another version, or shares memory that was not offered.
        """
        said: Any = {}
        try:
            said = json.loads(answer)
            version = said["version"]
        except (ValueError, KeyError, TypeError, RecursionError):
            version = answer[:80].decode(errors="replace")
        if type(version) is not int or version != VERSION:  # true equals 1, too
            self.close()
            raise ControllerError(
                f"`{shlex.join(self.command)}` speaks version {version!r} of the protocol; this is version {VERSION}",
                f'let it answer the first line with {{"version": {VERSION}}}',
            )
        self._columns = len(self._header["actions"])
        if said.get("warning") is True and "warning" in self._header:
            self._columns += 1
        shares = said.get("memory") is True
        if shares and not offered:
            self.close()
            raise ControllerError(
                f"`{shlex.join(self.command)}` would share memory, of which this system has none for two processes",
                'where our first line has no `memory`, let it answer {"version": 1} and read questions from the pipe',
            )
        return shares

    def _exchange(self, running: Process, question: list[memoryview], size: int, limit: float) -> bytes:
        """Write a question, part by part, and return `size` bytes, or a line if `size` is -1."""
        end = time.monotonic() + limit
        try:
            self._send(running, question, end)
            return self._receive(running, size, end)
        except (OSError, EOFError) as error:
            late = isinstance(error, TimeoutError)
            with suppress(subprocess.TimeoutExpired):
                running.process.wait(0.0 if late else 1.0)
            code = running.process.poll()
            what = f"took longer than {limit:g} s over {_asked_for(size, error)}" if late else _ending(code)
            raise self._lost(
                running, what, self._whole(size) if late and size >= 0 else "look for what ends it, or run it by itself"
            ) from error

    def _lost(self, running: Process, what: str, cure: str) -> LostError:
        """End a stack, and return the error for it."""
        self._log_of(running)
        self.close()
        kind = f"`{shlex.join(self.command)}` {what}"
        return LostError(f"{kind}{self._said}", cure, kind=kind)

    def _nothing_left(self, running: Process, size: int) -> None:
        """Check that the pipe is empty before a question: earlier bytes would be read as its answer.

        Raises:
            LostError: the stack has answered more than it was asked.
        """
        poll = select.poll()
        poll.register(running.read, select.POLLIN)
        if any(event & select.POLLIN for _, event in poll.poll(0)):
            raise self._lost(
                running, f"gave more than the {size:,} byte{'s' * (size > 1)} of an answer", self._whole(size)
            )

    def _whole(self, size: int) -> str:
        if size == 1:
            return "write one byte for each question, once its actions stand in the memory"
        rows, columns = self._header["lanes"], len(self._header["actions"])
        return f"write {size:,} bytes for each question, {rows} rows of {columns} float64, and flush them"

    def _send(self, running: Process, question: list[memoryview], end: float) -> None:
        while question:
            self._wait(running, running.write, select.POLLOUT, end)
            written = os.writev(running.write, question)
            while question and written >= len(question[0]):
                written -= len(question.pop(0))
            if written:
                question[0] = question[0][written:]

    def _receive(self, running: Process, size: int, end: float) -> bytes:
        parts: list[bytes] = []
        there = 0
        while there < size or (size < 0 and not (parts and parts[-1].endswith(b"\n"))):
            self._wait(running, running.read, select.POLLIN, end, there)
            part = os.read(running.read, size - there if size >= 0 else 1)
            if not part:
                raise EOFError
            parts.append(part)
            there += len(part)
        return b"".join(parts)

    def _wait(self, running: Process, pipe: int, event: int, end: float, there: int = 0) -> None:
        """Wait for an event of a pipe. Another process may hold the far end open after the stack has died.

        Raises:
            TimeoutError: the time `end` has passed; `there` bytes had arrived.
            EOFError: the stack has died.
        """
        poll = select.poll()
        poll.register(pipe, event)
        while not poll.poll(1000.0 * max(0.0, min(GLANCE, end - time.monotonic()))):
            if running.process.poll() and not poll.poll(0):
                raise EOFError
            if time.monotonic() >= end:
                raise TimeoutError(there)

    # -- what it printed ---------------------------------------------------------------------------------------------

    def _log_of(self, running: Process) -> None:
        running.log.seek(0)
        text = running.log.read().decode(errors="replace").strip()
        self._said = (
            f"; it printed: …{text[-TAIL:]}"
            if len(text) > TAIL
            else f"; it printed: {text}"
            if text
            else "; it printed nothing"
        )


def _asked_for(size: int, error: Exception) -> str:
    """Return a description of the answer that did not come in time; a `size` of -1 is a line."""
    there = error.args[0] if error.args else 0
    return "the first line" if size < 0 else f"an answer, of which {there:,} of {size:,} bytes came"


def _ending(code: int | None) -> str:
    if code is None:
        return "hung up"
    return f"was ended by signal {-code}" if code < 0 else f"ended with exit code {code}"


def stack_of(command: str) -> Stack:
    """Return the stack that a command starts.

    Raises:
        ControllerError: it is no command, or names no program.
    """
    try:
        words = tuple(shlex.split(command))
    except ValueError as error:
        raise ControllerError(f"`{command}` is not a command: {error}", "as in `process:./my_stack --fast`") from error
    if not words:
        raise ControllerError("`process:` names no command", "as in `process:./my_stack --fast`")
    if shutil.which(words[0]) is None:
        raise _not_started(
            words[0], "it is not executable" if Path(words[0]).is_file() else "no such file or directory"
        )
    return Stack(words)


def files_of(stack: Stack) -> tuple[str, ...]:
    """Return the files that its command names: program, script, configuration; else the program that PATH finds."""
    files = tuple(word for word in stack.command if Path(word).is_file())
    program = shutil.which(stack.command[0])
    return files or (() if program is None else (program,))
