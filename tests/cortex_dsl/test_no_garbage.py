"""While a text is compiled the collector is off, and afterwards as it was."""

import gc
from collections.abc import Iterator
from threading import Event, Thread

import pytest

from cortex_dsl.diagnostics import CompileError
from cortex_dsl.no_garbage import no_garbage_collected
from cortex_dsl.pipeline import compile_source
from cortex_dsl.source import Source


@pytest.fixture(autouse=True)
def _as_it_was() -> Iterator[None]:
    was_on = gc.isenabled()
    yield
    (gc.enable if was_on else gc.disable)()


@pytest.mark.parametrize("on", [True, False])
@pytest.mark.parametrize("text", ["ego = new Car at (0, 0)\n", "ego = new Car at nowhere_at_all\n"])
def test_the_collector_is_as_it_was_after_a_compilation(on: bool, text: str) -> None:
    """Also after one with errors, and where it was off before; within, it is off."""
    (gc.enable if on else gc.disable)()
    within = []
    try:
        compile_source(Source("a.scn", text), observe=lambda *_: within.append(gc.isenabled()))
    except CompileError:
        assert "nowhere" in text
    assert within
    assert not any(within)
    assert gc.isenabled() is on


def test_the_collector_is_off_until_the_last_compilation_is_done() -> None:
    """Two threads, of which the one that began first ends first."""
    gc.enable()
    begun, go = Event(), Event()

    def second() -> None:
        with no_garbage_collected():
            begun.set()
            go.wait(10.0)

    thread = Thread(target=second)
    with no_garbage_collected():
        thread.start()
        assert begun.wait(10.0)
    assert not gc.isenabled()
    go.set()
    thread.join()
    assert gc.isenabled()
