"""Executors of simulations: threads of this process, processes of this machine, or a Dask cluster.

The unit of work is a batch of scenes, and a batch is a pure function of program, settings, genomes and stream keys: a
result does not depend on the executor, and a batch that was lost with its worker is repeated. Workers return rows; only
the process that started the search writes. Ctrl-C goes to the process that started them, and they end with that
process.
"""

import logging
import multiprocessing
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import Executor, Future, InvalidStateError, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from itertools import pairwise
from multiprocessing import resource_tracker
from multiprocessing.process import BaseProcess
from queue import SimpleQueue
from typing import Any, Literal, NoReturn, TypeVar

from engine.assessment import Evaluate, concatenate
from engine.config import Config
from engine.errors import CortexError
from engine.extras import needed
from engine.outcomes import Assessment
from engine.program import Program
from engine.search.protocol import DEFAULT_OBJECTIVES
from engine.tables import Floats, Ints

# -- Ctrl-C ------------------------------------------------------------------------------------------------------------


def serve_parent() -> None:
    """Prepare a worker process: it ignores Ctrl-C, which its parent handles, and ends when its parent ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=lambda: (parent.join(), os._exit(1)), daemon=True).start()


@contextmanager
def unheard_by_children() -> Generator[None]:
    """Block Ctrl-C while child processes start, so that they never receive it; this process receives it afterwards.

    The resource tracker of multiprocessing starts before, because it would unblock Ctrl-C.
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


# -- workers -----------------------------------------------------------------------------------------------------------

Value = TypeVar("Value")
Kind = Literal["threads", "processes", "dask"]

BATCHES = 2
"""Batches per worker: workers end at about the same time, and little is lost with a batch."""
SMALLEST = 8
"""Minimum number of scenes in a batch, if there are enough: a message takes as long as about ten scenes."""
LARGEST = 2000
"""Scenes of a batch at most, so that Ctrl-C is answered soon."""
CONNECT = 10.0
"""Timeout for the connection to a scheduler [s]."""


class WorkersLostError(CortexError):
    """Workers cannot be reached, or died; the message has the reason and the cure."""


@dataclass(frozen=True)
class Workers:
    """Executor of the simulations of a search."""

    kind: Kind = "threads"
    jobs: int = 1
    address: str = "local"
    """Address of a Dask scheduler; `local` starts a cluster of `jobs` processes for the time of the search."""


def workers_for(engine: str, jobs: int) -> Workers:
    """Return the workers for a host: kernels of `batch` release the interpreter's lock, steps of the world do not."""
    return Workers("processes" if engine == "world" and jobs > 1 else "threads", jobs)


@contextmanager
def open_workers(workers: Workers) -> Generator[Executor | None]:
    """Open an executor while the block runs; None if threads of the evaluator run the simulations.

    Raises:
        MissingExtraError: Dask is not installed.
        WorkersLostError: the scheduler does not answer, or no local cluster starts.
    """
    if workers.kind == "threads":
        yield None
    elif workers.kind == "processes":
        with process_pool(workers.jobs) as pool:
            yield pool
    else:
        with _dask(workers) as executor:
            yield executor


@contextmanager
def process_pool(jobs: int) -> Generator[Executor]:
    """Start a pool of local processes.

    They are spawned, because a forked process would inherit the locks of running threads. An exception in the block
    ends them at once, whatever they do: a batch may take a minute, and the start of a process takes seconds.
    """
    pool = ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn"), serve_parent)
    try:
        yield pool
    except BaseException:
        _end_workers(pool)
        raise
    finally:
        if getattr(pool, "_broken", False):
            _end_workers(pool)
        pool.shutdown(cancel_futures=True)


def _end_workers(pool: ProcessPoolExecutor) -> None:
    """End the processes of a pool, so that `shutdown` does not wait for their work.

    Python 3.14 has `terminate_workers`. A process may end amid a result, for whose rest the pool would wait: our end of
    that pipe is closed. Versions before 3.11.5 also wait until somebody reads the work that is left
    (https://github.com/python/cpython/issues/94777), so its pipe is closed, too.
    """
    processes: dict[int, BaseProcess] | None = getattr(pool, "_processes", None)
    for process in list((processes or {}).values()):
        process.terminate()
    results: Any = getattr(pool, "_result_queue", None)
    if results is not None:
        results._writer.close()
    queue: Any = getattr(pool, "_call_queue", None)
    if sys.version_info < (3, 11, 5) and queue is not None:
        queue._reader.close()


@contextmanager
def _dask(workers: Workers) -> Generator[Executor]:
    distributed = needed("distributed", "`--dask` needs", "dist")
    with ExitStack() as stack:
        try:
            place: Any = workers.address
            if place == "local":
                with unheard_by_children():
                    place = stack.enter_context(_cluster(distributed, workers.jobs))
            client = stack.enter_context(distributed.Client(place, timeout=CONNECT, set_as_default=False))
        except (OSError, ValueError, TimeoutError) as error:
            raise WorkersLostError(
                f"there is no Dask scheduler at `{workers.address}` ({_first_line(error)})",
                "start one with `dask scheduler` and name what it prints, such as `--dask tcp://127.0.0.1:8786`, "
                "or give `--dask local`",
            ) from error
        yield DaskExecutor(client)


def _cluster(distributed: Any, jobs: int) -> Any:
    """Return a local cluster of processes with its own scheduler.

    Errors are reported by cortexc, so the cluster's own log is off, and so is its warning about slow scratch folders.
    """
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Creating scratch directories")
        try:
            return distributed.LocalCluster(
                n_workers=jobs,
                threads_per_worker=1,
                host="127.0.0.1",
                dashboard_address="127.0.0.1:0",
                silence_logs=logging.CRITICAL,
            )
        except RuntimeError as error:
            raise _lost(f"the workers of a Dask cluster did not start ({_first_line(error)})") from error


class DaskExecutor(Executor):
    """Functions that the workers of a Dask client run, as futures of the standard library.

    Dask's own executor reports an error for a result if the worker that holds it is killed at that moment.
    """

    def __init__(self, client: Any) -> None:
        self._client = client

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> "Future[Any]":
        future: Future[Any] = Future()
        theirs = self._client.submit(fn, *args, pure=False, **kwargs)
        theirs.add_done_callback(partial(_hand_on, future))
        future.add_done_callback(lambda ended: theirs.cancel() if ended.cancelled() else None)
        return future


def _hand_on(future: "Future[Any]", theirs: Any) -> None:
    """Pass the result of a Dask future on, in a thread of Dask; a lost result is computed again."""
    try:
        settle = partial(future.set_result, theirs.result())
    except BaseException as error:
        settle = partial(future.set_exception, error)
    with suppress(InvalidStateError):  # the future was cancelled
        settle()


def _first_line(error: Exception) -> str:
    return str(error).split("\n", 1)[0] or type(error).__name__


# -- batches ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Job:
    """Common arguments of all batches of a search. Two jobs are equal if they give the same results."""

    program: Program
    config: Config
    profile: str
    objective: tuple[str, ...] = DEFAULT_OBJECTIVES

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Job) and self._decides == other._decides

    def __hash__(self) -> int:
        return hash(self._decides)

    @property
    def _decides(self) -> tuple[str, Config, str, tuple[str, ...]]:
        return self.program.digest, self.config, self.profile, self.objective


def work(job: Job, genomes: Floats, keys: Ints) -> Assessment:
    """Run one batch in the current process."""
    return _evaluator(job)(genomes, keys)


@lru_cache(maxsize=8)
def _evaluator(job: Job) -> Evaluate:
    from engine.risk import PROFILES
    from engine.search.evaluator import make_evaluator
    from engine.search.objectives import objectives

    return make_evaluator(job.program, job.config, PROFILES[job.profile], objectives(job.program, job.objective))


def spread(
    executor: Executor,
    workers: Workers,
    program: Program,
    config: Config,
    profile: str,
    objective: Sequence[str] = DEFAULT_OBJECTIVES,
) -> Evaluate:
    """Return an evaluator whose batches an executor runs.

    Raises (when called):
        WorkersLostError: a worker was killed, and none is left to repeat its batch.
    """
    job = Job(program, replace(config, search=replace(config.search, jobs=1)), profile, tuple(objective))

    def evaluate(genomes: Floats, keys: Ints) -> Assessment:
        batches = [(job, genomes[start:end], keys[start:end]) for start, end in batches_of(len(genomes), workers.jobs)]
        return concatenate(apart(_results, executor, batches)) if batches else work(job, genomes, keys)

    return evaluate


def apart(function: Callable[..., Value], *arguments: Any, **named: Any) -> Value:
    """Return the result of a function, or raise its exception, from a call in a separate thread.

    A wait for futures takes their locks. Ctrl-C, which only the main thread receives, may come just after it has taken
    a lock: then no thread can complete that future, and the threads that try prevent the process from ending.
    """
    answers: SimpleQueue[Callable[[], Value]] = SimpleQueue()

    def answer() -> None:
        try:
            value = function(*arguments, **named)
            answers.put(lambda: value)
        except BaseException as error:
            answers.put(partial(_raise, error))

    threading.Thread(target=answer, daemon=True).start()
    return answers.get()()


def _raise(error: BaseException) -> NoReturn:
    raise error


def _results(executor: Executor, batches: Sequence[tuple[Job, Floats, Ints]]) -> list[Assessment]:
    """Return results in the order of the batches, whichever ended first."""
    futures: list[Future[Assessment]] = []
    try:
        futures += (executor.submit(work, *batch) for batch in batches)
        return [future.result() for future in futures]
    except Exception as error:
        if tells_of_a_kill(error):
            raise _lost("a worker process was killed") from error
        raise
    finally:
        for future in futures:
            future.cancel()


def tells_of_a_kill(error: Exception) -> bool:
    """Return True if work failed because its worker was killed: a local process, or several workers of Dask in turn."""
    return isinstance(error, BrokenProcessPool) or type(error).__name__ == "KilledWorker"  # Dask need not be there


def _lost(message: str) -> WorkersLostError:
    return WorkersLostError(
        message, "what was finished is kept: check their memory, then continue with `cortexc resume`"
    )


def batches_of(rows: int, workers: int) -> list[tuple[int, int]]:
    """Return ranges of rows of nearly equal size."""
    count = min(BATCHES * max(1, workers), -(-rows // SMALLEST))
    count = max(count, -(-rows // LARGEST))
    edges = [rows * number // count for number in range(count + 1)] if count else [0]
    return list(pairwise(edges))
