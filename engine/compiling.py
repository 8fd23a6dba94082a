"""A word before a kernel is compiled: numba's own event, which a kernel that comes from the cache does not set off."""

from collections.abc import Callable

from numba.core.event import Event, Listener, register


class _BeforeCompiling(Listener):
    """https://numba.readthedocs.io/en/stable/developer/event_api.html"""

    def __init__(self, tell: Callable[[], None]) -> None:
        self._tell = tell

    def on_start(self, event: Event) -> None:  # noqa: ARG002 - which kernel it is does not matter
        self._tell()

    def on_end(self, event: Event) -> None: ...


def before_compiling(tell: Callable[[], None]) -> None:
    """Call `tell` from now on before each compilation, in the thread that has to wait for it."""
    register("numba:compile", _BeforeCompiling(tell))
