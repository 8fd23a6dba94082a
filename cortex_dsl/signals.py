"""Signals of the process: SIGINT and SIGTERM raise KeyboardInterrupt at a place where no caller drops the exception.

The handler reads the frames of the stack. A flag that loops poll would need no frames, but it answers too late: the
import of numba takes 2 to 3 s and a kernel compiles for up to 10 s without a call of our code, and so may a driver of a
user; a handler that returns does not end `sleep`, `select` or the wait for an event (PEP 475).
"""

import os
import signal
from importlib.machinery import ExtensionFileLoader
from types import FrameType

A_MOMENT = 0.001
"""Delay before a signal that arrived at an unsafe time is delivered again [s]."""
IMPORTS_OF_EXTENSIONS = (ExtensionFileLoader.create_module.__code__, ExtensionFileLoader.exec_module.__code__)
"""Functions of Python that are on the stack while an extension module is imported."""
UNSAFE_NAMES = ("typeof_pyval", "_numba_unpickle", "__del__")
"""Names of functions of Python that numba's machine code calls for arguments and results of kernels, and of the method
that Python calls when an object is freed.
"""
UNSAFE_FUNCTIONS = {
    ("importlib._bootstrap", "cb"),
    ("_weakrefset", "_remove"),
    ("weakref", "remove"),
    ("weakref", "__call__"),
    ("concurrent.futures.process", "weakref_cb"),
    ("concurrent.futures.thread", "weakref_cb"),
    ("multiprocessing.popen_spawn_posix", "_launch"),
}
"""Functions of Python's library, each with its module: callbacks of weak references (of import locks, weak sets,
dictionaries, finalizers and pools), and the function that starts a process and writes what the process reads first.
"""
BINDINGS = tuple(f"{os.sep}{part}{os.sep}" for part in ("pymunk", f"llvmlite{os.sep}binding"))
"""Parts of the paths of packages whose objects stand for objects of a library in C."""


def install_handlers(received: list[int]) -> None:
    """Make SIGTERM, by which schedulers stop a job, act like Ctrl-C, and append it to `received` when it arrives."""

    def stop(number: int, frame: FrameType | None) -> None:
        if _drops_exceptions(frame):
            signal.signal(signal.SIGALRM, lambda _, later: stop(number, later))
            signal.setitimer(signal.ITIMER_REAL, A_MOMENT)
            return
        if number == signal.SIGTERM:
            received.append(number)
        raise KeyboardInterrupt

    for number, usual in ((signal.SIGINT, signal.default_int_handler), (signal.SIGTERM, signal.SIG_DFL)):
        if signal.getsignal(number) is usual:
            signal.signal(number, stop)


def remove_handlers() -> None:
    """Let a signal end the process without a word: while Python closes down, an exception would print a traceback."""
    for number in (signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, signal.SIG_DFL)


def _drops_exceptions(frame: FrameType | None) -> bool:
    """Return True if an exception in a frame would not reach the command, as one of its callers drops it.

    Of a hundred interrupts of a search three were lost while numpy checked whether an operand is an array, as it treats
    every exception there as a no: it looks an attribute up, for which the classes of enumerations have a `__getattr__`
    in Python until Python 3.11. An extension module replaces an exception during its import by an error of its own:
    numpy advises to install it anew. Machine code of numba crashes after an exception in what it calls to read and make
    records. Pymunk prints the exceptions of its callbacks; it and llvmlite print an error when an object is freed that
    was half made. Python prints those of `__del__` and of callbacks of weak references, and goes on. A new process
    whose parent stops before it has written what the process reads first prints an error of its own.
    """
    if frame is not None and str(frame.f_globals.get("__name__", "")).startswith("namedtuple_"):
        return True
    stack = []
    while frame is not None:
        stack.append((frame.f_globals.get("__name__"), frame.f_code))
        frame = frame.f_back
    if any(code.co_name == "__getattr__" for _, code in stack[:2]):
        return True
    return any(
        code in IMPORTS_OF_EXTENSIONS
        or code.co_name in UNSAFE_NAMES
        or (module, code.co_name) in UNSAFE_FUNCTIONS
        or any(part in code.co_filename for part in BINDINGS)
        for module, code in stack
    )
