"""Runs of a suite: all groups of its table, in its order. Prints nothing."""

import math
import re
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from shlex import join

from cortex_dsl.api.contenders import NotComparableError, Side, SideKind, contender, side_of
from cortex_dsl.api.limits import budget_of
from cortex_dsl.api.seeded_runs import OnRuns, Prepare, check_seed
from cortex_dsl.api.suite_cells import (
    BLIND_TURN,
    EGO_PATH,
    EGO_SPEED,
    NO_WARNING,
    RUNS,
    GroupRuns,
    SuitePlan,
    cell_result,
    has_path,
    not_run,
)
from cortex_dsl.api.suite_tables import LIGHT, WARNING, Group, Suite, matches, suite_of
from cortex_dsl.api.testing import results_of_files
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.report.findings.suite_report import GroupResult, Outcome, SuiteReport
from cortex_dsl.semantics.names.builtins import BUILTINS
from engine.driving.blocks import BLOCK as DRIVER_BLOCK
from engine.errors import ControllerError, CortexError
from engine.gates.ratings import Colour
from engine.vocabulary import RECORDS

LACKING = {
    WARNING: ("warning_ttc", NO_WARNING),
    LIGHT: ("LIGHT", "darkness: the driver does not state by `LIGHT` how its sensor depends on light"),
}
"""Word by which a behavior says that it has what cells need, and the reason where it does not."""
OnGroup = Callable[[GroupResult], None]


def run_suite(
    name: str,
    ego: str,
    *,
    only: Sequence[str] = (),
    budget: int | str = RUNS,
    seed: int = 0,
    block: int = DRIVER_BLOCK,
    observe: str = RECORDS,
    jobs: int = 1,
) -> SuiteReport:
    """Run the cells of a suite with a driver.

    Args:
        name: a suite of the package, or a folder with a `suite.toml`.
        ego: a driver (`python:…`, `process:…`) or a behavior of the language.
        only: patterns of cells or groups.
        budget: runs of each cell within the tolerances, or a time for all cells such as `"90s"`.
        seed: seed of the runs.
        block: scenes in one query of a driver.
        observe: what a driver observes, `records` or `egocentric`.
        jobs: processes; the result does not depend on it.

    Raises:
        SuiteError: there is no such suite, its table cannot be used, or a pattern matches no cell.
        ArgumentError: the driver names nothing, or a number cannot be.
        ControllerError: the driver cannot be loaded.
    """
    plan = SuitePlan(side_of(ego, None, block, observe), budget_of(budget), seed, jobs)
    suite = suite_of(name)
    return run_plan(suite.only(only) if only else suite, plan)


def run_plan(
    suite: Suite,
    plan: SuitePlan,
    on_group: OnGroup | None = None,
    on_runs: OnRuns | None = None,
    prepare: Prepare | None = None,
    command: Sequence[str] = (),
) -> SuiteReport:
    """Run all groups; `on_group` is called with each result, in the order of the table.

    A KeyboardInterrupt ends the run with the groups that are done.

    Raises:
        ArgumentError: the seed cannot be.
        SuiteError: a cell does not fit its scenario.
        WorkersLostError: a worker process was killed.
    """
    check_seed(plan.seed)
    started, results = time.monotonic(), list[GroupResult]()
    lost = None if plan.side.driver is None else _lost
    if lost is not None and plan.jobs > 1 and prepare is not None:
        _prepare_first(suite, plan, prepare)  # kernels are compiled with progress, and once for all processes
    try:
        for result in results_of_files(run_group, suite.groups, plan, started, on_runs, prepare, lost):
            results.append(result)
            if on_group is not None:
                on_group(result)
    except KeyboardInterrupt:
        pass
    cells = [cell for group in results for cell in group.cells]
    broken = [
        cell.id
        for cell in cells
        if cell.outcome is not Outcome.NOT_RUN
        and cell.colour is not Colour.GREEN
        and any(matches(cell, each) for each in suite.entry)
    ]
    return SuiteReport(
        suite=suite.name,
        title=suite.title,
        edition=suite.edition,
        notes=suite.notes,
        driver=plan.side.word,
        groups=tuple(results),
        seed=plan.seed,
        budget=plan.budget.text,
        command=join(command),
        timed=math.isfinite(plan.budget.seconds),
        entry=tuple(broken),
        not_done=len(suite.groups) - len(results),
        seconds=time.monotonic() - started,
        limit=plan.budget.seconds,
    )


def _lost(group: Group) -> GroupResult:
    """Return the result of a group whose process ended: by its driver, or by the system for want of memory."""
    reason = "the process of this group ended while the driver drove: the driver ended it, or the memory was used up"
    cells = (
        not_run(cell, cell.reason) if cell.reason else cell_result(cell, Outcome.ERROR, reason=reason)
        for cell in group.cells
    )
    return GroupResult(group.name, tuple(cells), group.points, "" if group.file is None else group.file.name)


def _prepare_first(suite: Suite, plan: SuitePlan, prepare: Prepare) -> None:
    """Prepare the scenario of the first group in which the driver fits."""
    for group in suite.groups:
        if group.file is not None:
            with suppress(CortexError):  # the run of the group reports it
                side = _with_speed(plan.side, turns=has_path(group.file))
                prepare(contender(side, group.file).scenario)
                return


def run_group(
    group: Group,
    plan: SuitePlan,
    seconds: float = math.inf,
    on_runs: OnRuns | None = None,
    prepare: Prepare | None = None,
) -> GroupResult:
    """Return the results of the cells of a group, which share `seconds`.

    Raises:
        SuiteError: a cell does not fit the scenario.
    """
    started = time.monotonic()
    result = GroupResult(group.name, (), group.points)
    if group.file is None:
        return replace(result, cells=tuple(not_run(cell, cell.reason) for cell in group.cells))
    result = replace(result, file=group.file.name)
    if reason := _lacking(group, plan.side):
        return replace(result, cells=tuple(not_run(cell, reason) for cell in group.cells))
    try:
        side = contender(_with_speed(plan.side, turns=has_path(group.file)), group.file)
        if prepare is not None:
            prepare(side.scenario)
        done = GroupRuns(group, plan, side, started + seconds, on_runs).finished()
        result = replace(done, file=result.file, digest=side.program.digest)
    except CompileError as error:
        found = tuple(not_run(cell, f"{group.file.name} has errors") for cell in group.cells)
        diagnostics = tuple(error.diagnostics)
        result = replace(result, cells=found, error=error, source=error.source, diagnostics=diagnostics)
    except (ControllerError, NotComparableError) as error:
        reason = error.message.replace(str(group.file), group.file.name)
        found = tuple(not_run(cell, reason) for cell in group.cells)
        result = replace(result, cells=found, refusal=reason)
    return replace(result, seconds=time.monotonic() - started)


def _lacking(group: Group, side: Side) -> str:
    """Return why a driver lacks what the cells of a group need; "" if it has it, or only a run shows that."""
    if group.file is not None and has_path(group.file) and side.kind is SideKind.BEHAVIOUR:
        word = _with_speed(side, turns=True).word
        if EGO_PATH not in word:
            return f"the ego turns here, and `{word}` does not follow `{EGO_PATH}`"
    if not group.needs or (side.kind is SideKind.DRIVER and group.needs == WARNING):
        return ""
    word, reason = LACKING[group.needs]
    return "" if side.kind is SideKind.BEHAVIOUR and re.search(rf"\b{word}\b", side.word) else reason


def _with_speed(side: Side, *, turns: bool) -> Side:
    """Return a side that is a bare name with the speed of the ego as its argument, and its path where that `turns`."""
    row = BUILTINS.get(side.word.strip())
    if side.kind is not SideKind.BEHAVIOUR or row is None:
        return side
    names = [parameter.name for parameter in row.parameters]
    if "behavior" in names:
        return replace(side, word=f"{row.name}({BLIND_TURN if turns else f'FollowLaneBehavior({EGO_SPEED})'})")
    speed = next((name for name in ("target_speed", "speed") if name in names), None)
    if speed is not None and (not turns or "trajectory" in names):
        path = f", trajectory={EGO_PATH}" if turns else ""
        return replace(side, word=f"{row.name}({speed}={EGO_SPEED}{path})")
    return side


def suite_files(suite: Suite) -> Mapping[str, Path]:
    """Return the files of a suite by name."""
    return {path.name: path for path in sorted(suite.folder.iterdir()) if path.is_file()}
