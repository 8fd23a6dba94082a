"""Notice before a kernel is compiled, by numba's own event, which a kernel from the cache does not trigger."""

from collections.abc import Callable, Generator
from contextlib import contextmanager
from typing import Any, cast

from numba.core import event as events
from numba.core.event import Event, Listener

EVENT = "numba:compile"
UNTYPED = cast("Any", events)


class _BeforeCompiling(Listener):
    """https://numba.readthedocs.io/en/stable/developer/event_api.html"""

    def __init__(self, tell: Callable[[], None]) -> None:
        self._tell = tell

    def on_start(self, event: Event) -> None:  # noqa: ARG002 - which kernel it is does not matter
        self._tell()

    def on_end(self, event: Event) -> None: ...


@contextmanager
def before_compiling(tell: Callable[[], None]) -> Generator[None]:
    """Call `tell` before each compilation within the block, in the thread that waits for it."""
    listener = _BeforeCompiling(tell)
    UNTYPED.register(EVENT, listener)
    try:
        yield
    finally:
        UNTYPED.unregister(EVENT, listener)
