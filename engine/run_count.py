"""Count of runs while a command works: hosts report finished runs, and a progress display listens."""

from collections.abc import Callable, Generator
from contextlib import contextmanager

_listeners: list[Callable[[int], None]] = []


def report_runs(count: int) -> None:
    """Report that `count` runs have ended."""
    for listener in _listeners:
        listener(count)


@contextmanager
def counting(listener: Callable[[int], None]) -> Generator[None]:
    """Call `listener` with the number of runs that have ended, in the thread that simulates, within the block."""
    _listeners.append(listener)
    try:
        yield
    finally:
        _listeners.remove(listener)
