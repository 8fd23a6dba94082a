"""Hypothesis draws the same few examples on every push, and many new ones in a night; a slow example is no failure.

What failed in a night is kept in `build/failures` of the checkout and tried first in the next.

What can be made again (parser tables, compiled kernels, proofs, lists of fonts), and what Dask leaves, is kept in
`build/cache` of the checkout, so that no test depends on what lies in the user's cache, and none leaves anything there.

A shell that runs the suite in the background has it ignore Ctrl-C, and `nohup` the end of a session: every process that
a test starts would too.
"""

import gc
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings
from hypothesis.database import DirectoryBasedExampleDatabase

from cortex_dsl.__main__ import NEW_BEFORE_A_LOOK
from engine.user_cache import ENVIRONMENT_VARIABLE
from tests.fork_server import COMMAND, ForkServer
from tests.runs import LEFT_TURN, SEARCH, STUDY, shared, small_designs

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
BUILD = Path(__file__).parent.parent / "build"
CACHE, FAILURES = BUILD / "cache", BUILD / "failures"
os.environ.setdefault(ENVIRONMENT_VARIABLE, str(CACHE))
os.environ.setdefault("MPLCONFIGDIR", str(CACHE / "matplotlib"))
os.environ.setdefault("DASK_TEMPORARY_DIRECTORY", str(CACHE / "dask"))
READING = ("tests/cortex_dsl/syntax/", "tests/engine/road/", "tests/cortex_dsl/semantics/")
"""Tests that need no kernel, or none that takes long; some of the last folder do, for which it is there by then."""
COMMON = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow], print_blob=True)
settings.register_profile("push", COMMON, derandomize=True, database=None, max_examples=25)
settings.register_profile("quick", settings.get_profile("push"), max_examples=10)
STORE = DirectoryBasedExampleDatabase(FAILURES)
settings.register_profile("night", COMMON, derandomize=False, database=STORE, max_examples=1000)
settings.load_profile("push")


@pytest.fixture(scope="session")
def command_server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ForkServer]:
    """A process that has loaded what `cortexc` needs, and forks; `RUN` is the command."""
    environment = os.environ | {"PYTHONPATH": str(BUILD.parent)}
    with ForkServer(COMMAND, tmp_path_factory.mktemp("command"), environment=environment) as server:
        yield server


@pytest.fixture(scope="session")
def ga_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished search of the example by the genetic algorithm; whoever writes into it takes a copy."""
    return shared(tmp_path_factory, "ga", LEFT_TURN, *SEARCH, "--json")


@pytest.fixture(scope="session")
def small_study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished study of the example, two runs of each method; whoever writes into it takes a copy."""
    return shared(tmp_path_factory, "study", "study", LEFT_TURN, *STUDY)


@pytest.fixture(scope="module")
def small_design() -> Iterator[None]:
    """As `small_designs`, for all tests of a module."""
    with small_designs():
        yield


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put what waits for no kernel in the middle, where the second of two workers begins: meanwhile the first compiles
    kernels for both. Otherwise both would compile all of them, two minutes each where none is cached.
    """
    reading = [item for folder in READING for item in items if item.nodeid.startswith(folder)]
    others = [item for item in items if not item.nodeid.startswith(READING)]
    middle = len(items) // 2
    items[:] = [*others[:middle], *reading, *others[middle:]]


def pytest_collection_finish() -> None:
    """Look for garbage seldom, and never among what lives until the end, such as thousands of tests."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(NEW_BEFORE_A_LOOK)
