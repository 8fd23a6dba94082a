"""Worker processes and Ctrl-C: it is for whoever started them, and they do not outlive that one."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker


def serve_parent() -> None:
    """First call in a worker: Ctrl-C is for the parent; and where that is gone, there is nobody to work for."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=lambda: (parent.join(), os._exit(1)), daemon=True).start()


@contextmanager
def unheard_by_children() -> Iterator[None]:
    """Hold Ctrl-C back for a moment: processes that are started meanwhile never hear it, this one does afterwards.

    The helper of multiprocessing that comes with the first process is started before: it would let Ctrl-C in again.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
