"""Tests of scenario files: run each file, and decide whether its limits are kept. Prints nothing.

The result of a file depends on the file and the plan only, neither on other files nor on the number of workers.
"""

import math
import os
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, Protocol, TypeVar

from cortex_dsl.api.file_check import GatePlan, check_file
from cortex_dsl.api.limits import BUDGET, Budget, bound_of, budget_of, probability_of
from cortex_dsl.api.scenario_files import ScenarioFile, scenario_files
from cortex_dsl.api.seeded_runs import OnRuns, Prepare, check_seed
from cortex_dsl.report.findings.gate_report import FileResult, GateReport, Kind
from engine.driving.named import driver_of
from engine.errors import ArgumentError

ALONE = 1.0
"""Time [s] after which further files are given to processes of their own, whose start takes about as long."""
OnFile = Callable[[FileResult], None]


def run_tests(
    paths: str | Path | Iterable[str | Path],
    *,
    exclude: Sequence[str] = (),
    budget: int | str = BUDGET,
    seed: int = 0,
    allow_collisions: bool = False,
    bounds: Sequence[str] = (),
    max_probability: float | None = None,
    of: str | None = None,
    undecided_passes: bool = False,
    ego: object = None,
    jobs: int = 1,
) -> GateReport:
    """Run scenario files, and return for each whether its limits are kept.

    Args:
        paths: a file or folder, or several.
        exclude: patterns of files to leave out.
        budget: runs of each file, or a time for all files such as `"90s"`.
        seed: seed of the first run.
        allow_collisions: whether a file without an `expect` may have contacts of the ego.
        bounds: bounds on results, such as `"delta_v <= 10 km/h"`.
        max_probability: largest probability of a failure of the `expect` called `of`, or of a contact of the ego.
        of: see `max_probability`.
        undecided_passes: whether a probability passes if the runs do not decide it.
        ego: driver, as for `Scenario.driven_by`.
        jobs: processes; the result does not depend on it.

    Raises:
        ArgumentError: a limit cannot be read, or no file has the `expect` called `of`.
        NoSuchPathError: a path does not exist, or a folder has no scenario.
        ControllerError: the driver cannot drive a file.
    """
    named = [paths] if isinstance(paths, str | Path) else list(paths)
    plan = GatePlan(
        budget=budget_of(budget),
        seed=seed,
        allow_collisions=allow_collisions,
        bounds=tuple(map(bound_of, bounds)),
        max_probability=None if max_probability is None else probability_of(max_probability),
        of=of,
        undecided_passes=undecided_passes,
        driver=driver_of(ego),
        jobs=jobs,
    )
    return run_plan(scenario_files(named, exclude), plan)


def run_plan(
    files: Sequence[ScenarioFile],
    plan: GatePlan,
    on_file: OnFile | None = None,
    on_runs: OnRuns | None = None,
    prepare: Prepare | None = None,
) -> GateReport:
    """Run all files, and return the report; `on_file` is called with each result, in the order of the files.

    `prepare` is called with each scenario that this process runs, before its first run. A KeyboardInterrupt ends the
    test; the report then has the files that are done.

    Raises:
        ArgumentError: no file has the `expect` whose probability is limited.
        ControllerError: the driver cannot be asked.
        WorkersLostError: a worker process was killed.
    """
    check_seed(plan.seed)
    started, results = time.monotonic(), list[FileResult]()
    is_whole = False
    with suppress(KeyboardInterrupt):  # the results of finished files are not lost
        for result in results_of_files(check_file, files, plan, started, on_runs, prepare):
            results.append(result)
            if on_file is not None:
                on_file(result)
        is_whole = True
    not_run = 0 if is_whole else len(files) - len(results)
    results = _without_libraries(results)
    if is_whole:
        _check_name(results, plan)
    return GateReport(
        files=tuple(results),
        not_run=not_run,
        seed=plan.seed,
        budget=plan.budget.text,
        timed=math.isfinite(plan.budget.seconds),
        undecided_passes=plan.undecided_passes,
        seconds=time.monotonic() - started,
    )


class Plan(Protocol):
    """Settings of a command on files: the budget, and the number of threads or processes."""

    @property
    def budget(self) -> Budget: ...
    @property
    def jobs(self) -> int: ...


JobT = TypeVar("JobT")
ResultT = TypeVar("ResultT")
Judge = Callable[..., ResultT]
"""Function of a file or another job, the plan, the seconds of the job, `OnRuns` and `Prepare`."""


def results_of_files(
    judge: Judge[ResultT],
    files: Sequence[JobT],
    plan: Plan,
    started: float,
    on_runs: OnRuns | None,
    prepare: Prepare | None,
    lost: Callable[[JobT], ResultT] | None = None,
) -> Iterator[ResultT]:
    """Yield the results in order: of the first files from this process, of the rest from processes of their own.

    `lost` returns the result of a file whose process ended; with it and several jobs, all files run in processes of
    their own, so that a driver that ends its process ends no other.

    Raises:
        WorkersLostError: a worker process was killed, and there is no `lost`.
    """
    share = plan.budget.seconds * min(plan.jobs, len(files)) / len(files)
    alone = _with_jobs(plan, plan.jobs if len(files) == 1 else 1)
    if lost is not None and plan.jobs > 1:
        yield from _apart(judge, files, alone, min(plan.jobs, len(files)), share, lost)
        return
    for number, file in enumerate(files):
        if plan.jobs > 1 and len(files) - number > 1 and time.monotonic() - started > ALONE:
            workers = min(plan.jobs, len(files) - number)
            yield from _apart(judge, files[number:], _with_jobs(plan, 1), workers, share)
            return
        yield judge(file, alone, share, on_runs, prepare)


def _with_jobs(plan: Any, jobs: int) -> Any:
    return replace(plan, jobs=jobs)


def _apart(
    judge: Judge[ResultT],
    files: Sequence[JobT],
    plan: Plan,
    workers: int,
    share: float,
    lost: Callable[[JobT], ResultT] | None = None,
) -> Iterator[ResultT]:
    """Yield the results of files that processes of their own run.

    If one of them is killed, each file without a result runs once more in a process of its own; `lost` is the result
    of one that is killed again.

    Raises:
        WorkersLostError: one of them was killed, and there is no `lost`.
    """
    from engine.search.workers import WorkersLostError, apart, process_pool, tells_of_a_kill

    done, futures = 0, list[Future[ResultT]]()
    try:
        with process_pool(workers) as pool:
            futures += [pool.submit(judge, file, plan, share) for file in files]
            try:
                for future in futures:
                    result = apart(future.result)
                    done += 1
                    yield result
            finally:
                for future in futures:
                    future.cancel()
    except Exception as error:
        if not tells_of_a_kill(error):
            raise
        if lost is None:
            raise WorkersLostError("a worker process was killed", "check the memory, or give --jobs 1") from error
        if len(files) == 1:
            yield lost(files[0])
            return
        for file, future in zip(files[done:], futures[done:], strict=True):
            if future.done() and not future.cancelled() and future.exception() is None:
                yield future.result()
            else:
                yield from _apart(judge, [file], plan, 1, share, lost)


def _without_libraries(results: Sequence[FileResult]) -> list[FileResult]:
    """Return the results without files that others import and that are no scenarios of their own.

    Only a file that was found in a folder is left out.
    """
    imported = {name for result in results for name in result.imports}
    return [
        result
        for result in results
        if not (result.found and result.error is not None and os.path.realpath(result.path) in imported)
    ]


def _check_name(results: Sequence[FileResult], plan: GatePlan) -> None:
    """Check that a file has the `expect` whose probability is limited.

    Raises:
        ArgumentError: none has it; the cure lists the names that exist.
    """
    checks = [check for result in results for check in result.checks if check.kind in (Kind.EXPECT, Kind.PROBABILITY)]
    names = sorted({check.name for check in checks})
    if plan.of is not None and plan.of not in names and not any(result.error for result in results):
        cure = f"there are {', '.join(names)}" if names else "no file has an `expect`; leave --of out for contacts"
        raise ArgumentError(f"--of: no file has an `expect` called `{plan.of}`", cure)
