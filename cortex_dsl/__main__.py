"""`python -m cortex_dsl` is `cortexc`: a process of its own, which is set up here, and the command in it.

Nothing here is done to a process that calls `cortex_dsl.cli.main` itself.
"""

import atexit
import codecs
import contextlib
import gc
import os
import signal
import sys
from importlib.machinery import ExtensionFileLoader
from pathlib import Path
from types import FrameType
from unicodedata import normalize

INTERRUPTED, TERMINATED = 128 + signal.SIGINT, 128 + signal.SIGTERM
"""Exit codes after a signal, as a shell counts them."""
NEW_BEFORE_A_LOOK = 500_000
"""Objects that are made before Python looks for garbage among them."""
A_MOMENT = 0.001
"""Delay before a signal that arrived at an unsafe time is delivered again [s]."""
IMPORTS_OF_EXTENSIONS = (ExtensionFileLoader.create_module.__code__, ExtensionFileLoader.exec_module.__code__)
"""Functions of Python that are on the stack while an extension module is imported."""
CALLED_BY_NUMBA = ("typeof_pyval", "_numba_unpickle")
"""Functions of Python that numba's machine code calls for arguments and results of kernels."""
PLAIN = {"–": "-", "…": "...", "→": "->", "°": " deg", "∞": "inf", "·": "*", "≤": "<=", "≥": ">=", "×": "x", "±": "+-"}
"""ASCII for signs of reports."""
PYMUNK = f"{os.sep}pymunk{os.sep}"
"""Part of the path of the files of pymunk."""


def process() -> int:
    """Run the command line of this process and return its exit code."""
    _open_streams()
    _start_light()
    asked: list[int] = []
    try:
        _install_signal_handlers(asked)
        from cortex_dsl.cli import main

        code = main()
        _let_streams_end()
    except KeyboardInterrupt:  # before `main` or after it, or a second time while it reports the first
        code = INTERRUPTED
        with contextlib.suppress(OSError):
            sys.stderr.write("cortexc: interrupted\n")
    _remove_signal_handlers()
    return TERMINATED if asked and code == INTERRUPTED else code


def _open_streams() -> None:
    """Open null streams for a command that was started with `>&-`; write characters that a terminal lacks in others."""
    codecs.register_error("plain", _in_plain_characters)
    if sys.stdout is None:
        sys.stdout = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115 - open until the process ends
    if sys.stderr is None:
        sys.stderr = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115 - open until the process ends
    for stream in (sys.stdin, sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            reconfigure(errors="plain" if stream is not sys.stdin else "replace")


def _in_plain_characters(error: UnicodeError) -> tuple[str, int]:
    """Return text for characters that an encoding lacks: letters without accents, `?` for what has no other form."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    lacking = error.object[error.start : error.end]
    plain = (PLAIN.get(sign) or normalize("NFKD", sign).encode("ascii", "ignore").decode() or "?" for sign in lacking)
    return "".join(plain), error.end


def _start_light() -> None:
    """Switch off parts that this process does not need and that cost half the time of a short command.

    Threads for matrices only spin. Garbage collection finds nothing, again and again while the compiler makes objects
    that live until the end, and once more at the end, when all of them go anyway. (One collection, for two hundred
    variants on a town's roads, takes a twelfth of the time of their check.)
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    gc.set_threshold(NEW_BEFORE_A_LOOK)
    atexit.register(gc.freeze)


def _install_signal_handlers(came: list[int]) -> None:
    """Make SIGTERM, by which schedulers stop a job, act like Ctrl-C, and append it to `came` when it arrives.

    No signal is lost: an exception in a frame whose caller drops it would be.
    """

    def stop(number: int, frame: FrameType | None) -> None:
        if _drops_exceptions(frame):
            signal.signal(signal.SIGALRM, lambda _, later: stop(number, later))
            signal.setitimer(signal.ITIMER_REAL, A_MOMENT)
            return
        if number == signal.SIGTERM:
            came.append(number)
        raise KeyboardInterrupt

    for number, usual in ((signal.SIGINT, signal.default_int_handler), (signal.SIGTERM, signal.SIG_DFL)):
        if signal.getsignal(number) is usual:
            signal.signal(number, stop)


def _remove_signal_handlers() -> None:
    """Let a signal end the process without a word: while Python closes down, an exception would print a traceback."""
    for number in (signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, signal.SIG_DFL)


def _drops_exceptions(frame: FrameType | None) -> bool:
    """Return whether an exception in a frame would not reach the command, as one of its callers drops it.

    Of a hundred interrupts of a search three were lost while numpy checked whether an operand is an array, as it treats
    every exception there as a no: it looks an attribute up, for which the classes of enumerations have a `__getattr__`
    in Python until Python 3.11. An extension module replaces an exception during its import by an error of its own:
    numpy advises to install it anew. Machine code of numba crashes after an exception in what it calls to read and make
    records. Pymunk prints the exceptions of its callbacks, and frees objects that were half made.
    """
    if frame is not None and str(frame.f_globals.get("__name__", "")).startswith("namedtuple_"):
        return True
    stack = []
    while frame is not None:
        stack.append(frame.f_code)
        frame = frame.f_back
    if any(code.co_name == "__getattr__" for code in stack[:2]):
        return True
    return any(
        code in IMPORTS_OF_EXTENSIONS or code.co_name in CALLED_BY_NUMBA or PYMUNK in code.co_filename for code in stack
    )


def _let_streams_end() -> None:
    """Prevent another failure when Python closes a stdout whose reader has left, or whose disk is full."""
    try:
        sys.stdout.flush()
    except OSError:
        with contextlib.suppress(OSError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    sys.exit(process())
