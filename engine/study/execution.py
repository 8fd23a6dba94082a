"""Execution of a plan: in this process, in several, or by any executor. Results do not depend on the choice.

The unit of work is a whole run. A worker is a process, as half of a search is Python code; it ignores Ctrl-C, and ends
when the work ends, or with the process that started it.
"""

from collections.abc import Callable, Collection, Iterable
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from itertools import islice
from typing import TYPE_CHECKING

from engine.search.store import StoreError
from engine.search.workers import apart, process_pool, tells_of_a_kill, unheard_by_children
from engine.study.plan import Address, Plan, Task

if TYPE_CHECKING:
    from engine.study.run_records import Finished

AHEAD = 2
"""Runs in hand for each worker, so that none waits."""

OnRun = Callable[["Finished"], None]


def perform(task: Task) -> "Finished":
    """Perform one run and return its record. Except for the seconds, it is a pure function of the task.

    Raises:
        KeyboardInterrupt: Ctrl-C.
    """
    from engine.search.run import search
    from engine.study.run_records import finished

    method, aims = task.address.method, task.objective
    campaign = search(task.program, method, task.config, task.profile, objective=aims)
    if campaign.stopped:
        raise KeyboardInterrupt
    return finished(task.address, campaign)


def perform_all(
    plan: Plan,
    on_run: OnRun,
    jobs: int = 1,
    done: Collection[Address] = (),
    executor: Executor | None = None,
) -> None:
    """Perform every run of the plan that is not `done`, and pass each to `on_run` in this thread, in any order.

    `executor` performs them, `jobs` at a time; without one they run here (1 job) or in local processes. Ctrl-C and
    exceptions of `on_run` end the work and are passed on; runs in flight are lost.

    Raises:
        StoreError: a worker was killed.
    """
    skip = frozenset(done)
    tasks = (plan.task(address) for address in plan.addresses() if address not in skip)
    if executor is not None:
        _drain(executor, tasks, jobs, on_run)
    elif jobs == 1:
        for task in tasks:
            on_run(perform(task))
    else:
        with process_pool(jobs) as pool:
            _drain(pool, tasks, jobs, on_run)


def _drain(executor: Executor, tasks: Iterable[Task], jobs: int, on_run: OnRun) -> None:
    """Submit tasks so that `jobs` workers stay busy until none is left."""
    queue = iter(tasks)
    pending: set[Future[Finished]] = set()
    try:
        while True:
            with unheard_by_children():
                pending |= {executor.submit(perform, task) for task in islice(queue, AHEAD * jobs - len(pending))}
            if not pending:
                return
            finished, pending = apart(wait, pending, return_when=FIRST_COMPLETED)
            for future in finished:
                on_run(future.result())
    except Exception as error:
        if tells_of_a_kill(error):
            raise StoreError(
                "a worker process was killed", "what was finished is kept; free some memory and go on"
            ) from error
        raise
    finally:
        for future in pending:
            future.cancel()
