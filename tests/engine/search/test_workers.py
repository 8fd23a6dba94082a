"""Wherever simulations run, in threads, processes or a Dask cluster that loses a worker, the journal is the same."""

import json
import os
import signal
import sqlite3
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cortex_dsl import Scenario, load
from cortex_dsl.api.run_folder import SearchOptions, search_and_keep
from engine.extras import MissingExtraError
from engine.search.campaign import Progress
from engine.search.workers import (
    LARGEST,
    DaskExecutor,
    Job,
    Workers,
    WorkersLostError,
    apart,
    batches_of,
    open_workers,
    process_pool,
    spread,
    work,
    workers_for,
)

ROOT = Path(__file__).parents[3]
EXAMPLE = ROOT / "examples" / "left_turn.scn"
RESULTS = ("generation", "individual", "simulation")


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    scenario = load(EXAMPLE)
    search = replace(scenario.config.search, generations=5, population=120, seed=4, probes=2)
    return replace(scenario, config=replace(scenario.config, search=search))


def tables(run: Path) -> dict[str, list[Any]]:
    with closing(sqlite3.connect(run / "journal.sqlite")) as connection:
        return {table: connection.execute(f"SELECT * FROM {table}").fetchall() for table in RESULTS}


@pytest.fixture(scope="module")
def alone(scenario: Scenario, tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Any]]:
    """The tables of a search on one thread."""
    folder = tmp_path_factory.mktemp("alone")
    search_and_keep(scenario, "niching", folder)
    return tables(folder)


def test_processes_write_the_same_journal(scenario: Scenario, alone: dict[str, list[Any]], tmp_path: Path) -> None:
    """Two processes, row by row; the same for threads."""
    for kind in ("threads", "processes"):
        (tmp_path / kind).mkdir()
        search_and_keep(scenario, "niching", tmp_path / kind, SearchOptions(workers=Workers(kind, 2)))
        assert tables(tmp_path / kind) == alone


def test_the_world_in_processes(scenario: Scenario, tmp_path: Path) -> None:
    """The host whose steps are Python runs in processes where there are several workers, to the same rows."""
    assert workers_for("world", 2) == Workers("processes", 2)
    assert workers_for("world", 1).kind == workers_for("batch", 4).kind == "threads"
    search = replace(scenario.config.search, engine="world", generations=2, population=20)
    world = replace(scenario, config=replace(scenario.config, search=search))
    for jobs in (1, 2):
        (tmp_path / str(jobs)).mkdir()
        search_and_keep(world, "random", tmp_path / str(jobs), SearchOptions(workers=workers_for("world", jobs)))
    assert tables(tmp_path / "1") == tables(tmp_path / "2")


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[tuple[str, list["subprocess.Popen[Any]"]]]:
    """A scheduler and two workers on loopback, each a process of its own: its address, and the workers."""
    pytest.importorskip("distributed")
    file, local = tmp_path / "scheduler.json", tmp_path / "dask"
    command = [sys.executable, "-W", "ignore", "-m"]
    quiet: dict[str, Any] = {
        "stdout": subprocess.DEVNULL,
        "stderr": subprocess.DEVNULL,
        "cwd": Path(__file__).parents[3],
    }
    head = [
        "distributed.cli.dask_scheduler",
        "--host",
        "127.0.0.1",
        "--port",
        "0",
        "--no-dashboard",
        "--idle-timeout",
        "60",
    ]
    hand = ["distributed.cli.dask_worker", "--nthreads", "1", "--no-nanny", "--no-dashboard", "--host", "127.0.0.1"]
    hand += ["--death-timeout", "30"]  # nothing is left behind, whatever ends the tests
    scheduler = ["--scheduler-file", str(file)]
    everyone: list[subprocess.Popen[Any]] = [subprocess.Popen([*command, *head, *scheduler], **quiet)]
    try:
        deadline = time.monotonic() + 60
        while not (file.exists() and file.read_text().strip()):
            assert time.monotonic() < deadline
            time.sleep(0.05)
        spawn = [*command, *hand, *scheduler, "--local-directory", str(local)]
        everyone += [subprocess.Popen(spawn, **quiet) for _ in range(2)]
        yield json.loads(file.read_text())["address"], everyone[1:]
    finally:
        for process in everyone:
            process.kill()
            process.wait()


def test_a_cluster_that_loses_a_worker(
    scenario: Scenario,
    alone: dict[str, list[Any]],
    cluster: tuple[str, list["subprocess.Popen[Any]"]],
    tmp_path: Path,
) -> None:
    """A worker is killed while it works; what it had is done again elsewhere, and the journal is the same."""
    address, workers = cluster

    def kill_one(progress: Progress) -> None:
        if progress.generation == 1:
            threading.Timer(0.005, workers[0].send_signal, (signal.SIGKILL,)).start()

    options = SearchOptions(on_generation=kill_one, workers=Workers("dask", 2, address))
    search_and_keep(scenario, "niching", tmp_path / "run", options)
    assert workers[0].wait(timeout=300) == -signal.SIGKILL
    assert workers[1].poll() is None
    assert tables(tmp_path / "run") == alone


def test_no_scheduler() -> None:
    """Nobody at the address: said with a cure."""
    pytest.importorskip("distributed")
    with (
        pytest.raises(WorkersLostError, match="no Dask scheduler at `nowhere`") as caught,
        open_workers(Workers("dask", 1, "nowhere")),
    ):
        pass
    assert "--dask local" in caught.value.cure


def test_without_dask(monkeypatch: pytest.MonkeyPatch) -> None:
    """The extra that is missing is named."""
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(MissingExtraError, match=r"\[dist\]"), open_workers(Workers("dask", 1)):
        pass


def _die(*_: object) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def test_a_process_that_is_killed(scenario: Scenario, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody is left to do its batch: an error with a cure, not a hang; the same where it died before it was asked."""
    monkeypatch.setattr("engine.search.workers.work", _die)
    scenes = scenario.sample(20)
    with process_pool(1) as pool:
        evaluate = spread(pool, Workers("processes", 1), scenario.program, scenario.config, "paper")
        for _ in range(2):
            with pytest.raises(WorkersLostError, match="killed") as caught:
                evaluate(scenes.genomes, scenes.keys)
            assert "resume" in caught.value.cure


class Lost:
    """A future of Dask that is done, and whose worker is killed before anybody asks for its result."""

    status, cancelled_by_us = "lost", False

    def __init__(self, answer: Callable[[], object]) -> None:
        self.result = answer

    def add_done_callback(self, function: Callable[["Lost"], None]) -> None:
        self.call = function

    def cancel(self) -> None:
        self.cancelled_by_us = True


def test_what_a_cluster_has_lost_is_asked_for_again() -> None:
    """Results and errors come as they are, whatever the state is meanwhile; what nobody waits for is given up."""

    def fails() -> object:
        raise ValueError("of a worker")

    made = [Lost(lambda: "found"), Lost(fails), Lost(lambda: "late")]
    futures = [DaskExecutor(SimpleNamespace(submit=lambda *_, each=each, **__: each)).submit(int) for each in made]
    futures[2].cancel()
    for each in made:
        each.call(each)
    assert futures[0].result() == "found"
    with pytest.raises(ValueError, match="of a worker"):
        futures[1].result()
    assert made[2].cancelled_by_us
    assert futures[2].cancelled()


def test_a_cluster_that_does_not_start(monkeypatch: pytest.MonkeyPatch) -> None:
    """As where one of its workers is killed before it has reported."""
    distributed = pytest.importorskip("distributed")

    def cluster(**_: object) -> None:
        raise RuntimeError("Nanny failed to start.")

    monkeypatch.setattr(distributed, "LocalCluster", cluster)
    with pytest.raises(WorkersLostError, match="Nanny failed to start"), open_workers(Workers("dask", 1)):
        pass


def said_by(folder: Path, program: str, *words: str) -> str:
    """Run a program that starts processes, from a file; return its output. It may say nothing on stderr, nor hang."""
    (folder / "program.py").write_text(program)
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    command = [sys.executable, "program.py", *words]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=300, check=True)
    assert done.stderr == ""
    return done.stdout


WAITING = """
import os, signal
from concurrent.futures.process import BrokenProcessPool
from engine.search.workers import process_pool

def die(load):
    os.kill(os.getpid(), signal.SIGKILL)

if __name__ == "__main__":
    with process_pool(1) as pool:
        futures = [pool.submit(die, bytes(4_000_000)) for _ in range(4)]
        try:
            futures[0].result()
        except BrokenProcessPool:
            print("broken")
    print("over")
"""


BUSY = """
import multiprocessing, sys, time
from pathlib import Path
from engine.search.workers import process_pool

def wait(_):
    Path("busy").touch()
    multiprocessing.parent_process().join()

if __name__ == "__main__":
    try:
        with process_pool(2) as pool:
            for number in range(8):
                pool.submit(wait, number)
            while sys.argv[1] == "busy" and not Path("busy").exists():
                time.sleep(0.01)
            raise KeyboardInterrupt
    except KeyboardInterrupt:
        print("over")
"""


@pytest.mark.parametrize("when", ["busy", "starting"])
def test_a_process_that_is_busy_is_not_waited_for(when: str, tmp_path: Path) -> None:
    """Neither one that works for as long as this process lives, nor one that still starts."""
    assert said_by(tmp_path, BUSY, when) == "over\n"


def test_a_killed_process_is_not_waited_for(tmp_path: Path) -> None:
    """A worker dies while more is on its way to it than a pipe holds: the pool still closes."""
    assert said_by(tmp_path, WAITING).split() == ["broken", "over"]


ANSWERING = """
from engine.search.workers import process_pool

def answer(size):
    return bytes(size)

if __name__ == "__main__":
    for _ in range(3):
        try:
            with process_pool(2) as pool:
                futures = [pool.submit(answer, 60_000_000) for _ in range(8)]
                futures[0].result()
                raise KeyboardInterrupt
        except KeyboardInterrupt:
            continue
    print("over")
"""


def test_a_process_that_is_ended_amid_its_answer_is_not_waited_for(tmp_path: Path) -> None:
    """Results are larger than a pipe, so that an interrupt of the block comes while one is being written."""
    assert said_by(tmp_path, ANSWERING) == "over\n"


class Backwards(Executor):
    """Runs what it is given only when it is asked for, the last first."""

    def __init__(self) -> None:
        self.waiting: list[Callable[[], None]] = []

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> "Future[Any]":
        future: Future[Any] = Future()
        self.waiting.append(lambda: future.set_result(fn(*args, **kwargs)))
        future.result = lambda timeout=None: self._late(future)  # type: ignore[method-assign]
        return future

    def _late(self, future: "Future[Any]") -> Any:
        while self.waiting:
            self.waiting.pop()()
        return Future.result(future)


def test_the_order_of_work_changes_nothing(scenario: Scenario) -> None:
    """Rows stand in the order of their keys, whichever batch was done first."""
    scenes = scenario.sample(50, seed=2)
    evaluate = spread(Backwards(), Workers("processes", 3), scenario.program, scenario.config, "paper")
    parted = evaluate(scenes.genomes, scenes.keys)
    together = work(Job(scenario.program, scenario.config, "paper"), scenes.genomes, scenes.keys)
    for name, column in vars(together).items():
        np.testing.assert_array_equal(getattr(parted, name), column)


class Noting(Backwards):
    """Who waits."""

    def __init__(self) -> None:
        super().__init__()
        self.waited: list[threading.Thread] = []

    def _late(self, future: "Future[Any]") -> Any:
        self.waited.append(threading.current_thread())
        return super()._late(future)


def test_the_main_thread_never_waits_for_a_future(scenario: Scenario) -> None:
    """Ctrl-C while it takes the lock of one would leave it locked, and the process would never end."""
    scenes, noting = scenario.sample(50, seed=2), Noting()
    spread(noting, Workers("processes", 3), scenario.program, scenario.config, "paper")(scenes.genomes, scenes.keys)
    assert noting.waited
    assert threading.main_thread() not in noting.waited


def test_what_is_raised_apart_is_raised_here() -> None:
    """With its message; and what is returned comes back."""
    assert apart(divmod, 7, 2) == (3, 1)
    with pytest.raises(ZeroDivisionError, match="zero"):
        apart(divmod, 7, 0)


def test_batches() -> None:
    """All rows once and in order, of nearly equal size, neither tiny nor so large that Ctrl-C must wait."""
    for rows in (0, 1, 7, 8, 9, 100, 5000, 100_001):
        for workers in (1, 2, 16):
            batches = batches_of(rows, workers)
            assert [row for start, end in batches for row in range(start, end)] == list(range(rows))
            sizes = [end - start for start, end in batches]
            assert not sizes or max(sizes) - min(sizes) <= 1
            assert max(sizes, default=0) <= LARGEST
    assert len(batches_of(1000, 2)) == 4
