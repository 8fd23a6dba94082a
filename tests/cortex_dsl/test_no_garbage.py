"""While a text is compiled the collector is off, and afterwards as it was."""

import gc
from collections.abc import Iterator
from contextlib import suppress
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


def circles_after(text: str) -> int:
    """How many objects only the collector can free, once a text was compiled."""
    gc.collect()
    gc.disable()
    with suppress(CompileError):
        compile_source(Source("a.scn", text))
    return gc.collect()


PARTS = {
    "draws": "x{0} = Normal({0}, 1)\n",
    "objects": "c{0} = new Car at ({0}00, 0), facing 10 deg, with regionContainedIn None\n",
    "functions": "def f{0}(x):\n    return x + {0}\ny{0} = f{0}({0})\n",
    "behaviors": "behavior B{0}(v):\n    do FollowLaneBehavior(v) for {0} s\nb{0} = B{0}(9)\n",
    "requirements": "require always ego.speed < {0} + 40 m/s\n",
    "choices": "z{0} = Uniform(1, {0}.5)\nrequire z{0} > 0\n",
    "mistakes": "w{0} = Range(unknown{0}, 1)\n",
}


@pytest.mark.parametrize("part", PARTS.values(), ids=PARTS)
def test_what_a_compilation_leaves_is_freed_by_reference_counts(part: str) -> None:
    """Else a large file costs a look at all of it once it is compiled, and many variants keep all that each made."""
    file = "ego = new Car at (0, 0)\n{}".format
    few, many = (circles_after(file("".join(part.format(i) for i in range(1, n)))) for n in (2, 9))
    assert many <= few + 3
