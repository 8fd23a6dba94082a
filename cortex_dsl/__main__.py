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
from pathlib import Path
from unicodedata import normalize

from cortex_dsl.signals import install_handlers, remove_handlers

INTERRUPTED, TERMINATED = 128 + signal.SIGINT, 128 + signal.SIGTERM
"""Exit codes after a signal, as a shell counts them."""
NEW_BEFORE_A_LOOK = 500_000
"""Objects that are made before Python looks for garbage among them."""


def process() -> int:
    """Run the command line of this process and return its exit code."""
    _open_streams()
    _start_light()
    received: list[int] = []
    try:
        install_handlers(received)
        from cortex_dsl.cli import main

        code = main()
        _let_streams_end()
    except KeyboardInterrupt:  # before `main` or after it, or a second time while it reports the first
        code = INTERRUPTED
        with contextlib.suppress(OSError):
            sys.stderr.write("cortexc: interrupted\n")
    remove_handlers()
    return TERMINATED if received and code == INTERRUPTED else code


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
    from cortex_dsl.plain_text import ASCII

    if not isinstance(error, UnicodeEncodeError):
        raise error
    lacking = error.object[error.start : error.end]
    plain = (ASCII.get(sign) or normalize("NFKD", sign).encode("ascii", "ignore").decode() or "?" for sign in lacking)
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


def _let_streams_end() -> None:
    """Prevent another failure when Python closes a stdout whose reader has left, or whose disk is full."""
    try:
        sys.stdout.flush()
    except OSError:
        with contextlib.suppress(OSError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    sys.exit(process())
