"""Shared parts of the commands that search, or show a search.

For a search: the workers, the progress, the report, the document, the exit code. For a run: its journal opened and
checked, and solvable problems raised as usage errors.
"""

import shlex
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from cortex_dsl.api.restoring import outdated
from cortex_dsl.api.run_folder import OnRemoved, SearchResult
from cortex_dsl.api.runs import OpenedRun, check_journal, open_run
from cortex_dsl.api.scenario import Scenario
from cortex_dsl.console.command import driver_words
from cortex_dsl.console.compiling import show, show_compiled
from cortex_dsl.console.request import CompileRequest
from cortex_dsl.console.searching import cases_and_kinds, show_reports
from cortex_dsl.console.simulating import blame_of_search, mistake_of
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from cortex_dsl.plain_text import as_argument
from cortex_dsl.report.findings.cases_found import cases_content
from cortex_dsl.report.findings.readable import ratio
from cortex_dsl.report.findings.search_report import SearchReport
from cortex_dsl.report.findings.tally import blame_content
from engine.driving.names import Egos, as_options, driver_hint
from engine.extras import MissingExtraError
from engine.search.campaign import Campaign
from engine.search.manifest import DrivenBy, changed_versions
from engine.search.objectives import ObjectiveError, ObjectiveNameError
from engine.search.past import ForeignPastError
from engine.search.protocol import DEFAULT_OBJECTIVES
from engine.search.ranking import Case
from engine.search.result_files import summary
from engine.search.searchers import PluginError, SeveralObjectivesError, UnknownMethodError
from engine.search.store import StoreError
from engine.search.workers import Workers, WorkersLostError, workers_for

SOLVABLE = (
    StoreError,
    WorkersLostError,
    MissingExtraError,
    PluginError,
    UnknownMethodError,
    ObjectiveNameError,
    SeveralObjectivesError,
    ObjectiveError,
)


UNPROVED = "unproved: an earlier version wrote this journal, without the digests that tell of every change"


@contextmanager
def usage_errors() -> Iterator[None]:
    """Turn an error that the user can solve into a UsageError."""
    try:
        yield
    except SOLVABLE as error:
        raise UsageError(error.message, error.cure) from error


def removed(terminal: Terminal) -> OnRemoved:
    """Return a callback that warns at once that later results are not stored."""
    return lambda error: terminal.complain(error.message, "what follows is in memory alone; Ctrl-C shows it")


def note_outdated(folder: Path, terminal: Terminal, links: Sequence[str] | None = None) -> None:
    """Name the files that were made before the run or the study went on, with the commands that write them again.

    A folder that was removed meanwhile has none.
    """
    with suppress(StoreError):
        for remark in outdated(folder, links):
            terminal.note(remark)


def chosen_workers(engine: str, jobs: int, dask: str | None) -> Workers:
    """Return the workers for the simulations: threads or processes of this machine, or a cluster."""
    return workers_for(engine, jobs) if dask is None else Workers("dask", jobs, dask)


def show_found(found: Sequence[SearchResult], scenario: Scenario, request: CompileRequest, terminal: Terminal) -> Exit:
    """Show the results, and return the exit code."""
    campaigns = [each.campaign for each in found]
    mistake = next((m for campaign in campaigns if (m := mistake_of(scenario, campaign)) is not None), None)
    if request.json:
        show(scenario.compiled.source, [] if mistake is None else [mistake], request, terminal)
        reports = [_report(each, scenario, ours=mistake is None) for each in found]
        terminal.document("search", _content(request, found, reports))
    else:
        _show(scenario, found, request, terminal, ours=mistake is None)
        for each in found:
            if each.campaign.stopped and each.folder.is_dir():
                terminal.err.print(f"to go on: cortexc resume {shlex.quote(as_argument(each.folder))}", soft_wrap=True)
    for each in found:
        if each.failure is not None:
            raise UsageError(each.failure.message, each.failure.cure)
    if mistake is not None:
        show(scenario.compiled.source, [mistake], replace(request, json=False), terminal)
        return Exit.DIAGNOSTICS
    return _exit_code(campaigns)


def _show(
    scenario: Scenario, found: Sequence[SearchResult], request: CompileRequest, terminal: Terminal, *, ours: bool
) -> None:
    """Show the screen and the requested details; `ours`: failed runs are no mistake of the file."""
    from cortex_dsl.report.terminal.render import parts
    from cortex_dsl.report.views.search import unfinished_note

    reports = [_report(each, scenario, ours=ours) for each in found]
    show_reports(scenario.program, reports, _settings(found), request, terminal)
    program = scenario.program
    for report in reports:
        if ours and (note := unfinished_note(program, report)) is not None:
            terminal.err.print(parts([note], terminal.err.width))


def _report(found: SearchResult, scenario: Scenario, *, ours: bool) -> SearchReport:
    """Return the report of one campaign; a requirement is blamed only if no mistake of the file is (`ours`)."""
    folder = found.folder if found.folder.is_dir() else None
    manifest, campaign = found.manifest, found.campaign
    blame = blame_of_search(scenario.program, campaign, manifest.config.search.seed) if ours else None
    driver = _driver_options(manifest.driver)
    cases, kinds = cases_and_kinds(_driven_as_recorded(scenario, folder), campaign)
    return SearchReport(campaign, folder, found.worst_files, manifest.method, driver, blame, cases, kinds)


def _driven_as_recorded(scenario: Scenario, folder: Path | None) -> Scenario | None:
    """Return the scenario with the stored decisions of its driver, which is not asked again; None if there are none."""
    if scenario.config.driver is None:
        return scenario
    try:
        return None if folder is None else open_run(folder).scenario
    except StoreError:
        return None


def _driver_options(driver: DrivenBy | None) -> str:
    """Return the command-line options that repeat the driver of a worst case; empty without one."""
    if driver is None:
        return ""
    return " ".join([as_options(driver.name), *driver_words(None, driver.block, driver.observe)])


def _settings(found: Sequence[SearchResult]) -> str:
    """The settings that a reader must know, in one line."""
    manifest = found[0].manifest
    search = manifest.config.search
    parts = [f"{search.generations} x {search.population}", f"seed {search.seed}"]
    parts += [f"preset {each.manifest.preset}" for each in found if each.manifest.preset]
    if search.rollouts > 1:
        parts.append(f"{search.aggregate} of {search.rollouts} rollouts")
    parts += [] if manifest.objective == DEFAULT_OBJECTIVES else [f"objective {' and '.join(manifest.objective)}"]
    return ", ".join([*parts, f"profile {manifest.profile}", f"{search.engine} engine"])


def _content(request: CompileRequest, found: Sequence[SearchResult], reports: Sequence[SearchReport]) -> dict[str, Any]:
    searches = [
        {
            "method": each.manifest.method,
            "folder": each.folder,
            "worst_files": each.worst_files,
            **summary(each.campaign, each.manifest),
            "figures": each.campaign.generations,
            "cases": cases_content(report.cases),
            "shares": _shares(each.campaign),
            "blame": report.blame and blame_content(report.blame),
        }
        for each, report in zip(found, reports, strict=True)
    ]
    return {"file": request.file, "searches": searches}


def _shares(campaign: Campaign) -> dict[str, float]:
    """Return failures as shares of the valid simulations, and the pace."""
    came, runs = campaign.failures, campaign.by_simulation.runs
    return {
        "avoidable": ratio(came.avoidable, came.valid),
        "collisions": ratio(came.collisions, came.valid),
        "runs_per_second": ratio(runs, campaign.elapsed),
    }


def _exit_code(campaigns: Sequence[Campaign]) -> Exit:
    if any(campaign.stopped for campaign in campaigns):
        return Exit.INTERRUPTED
    if any(campaign.by_simulation.error_runs for campaign in campaigns):
        return Exit.BUG
    if not any(campaign.by_individual.valid for campaign in campaigns):
        return Exit.NO_SCENE
    return Exit.FINE


# -- runs that commands show: opened, and held against the searcher that their journals name --------------------------


def opened_run(folder: Path, terminal: Terminal, ego: Egos | None = None, *, json: bool = False) -> OpenedRun:
    """Read a run, and show the warnings about its scenario.

    Raises:
        UsageError: there is no readable run.
    """
    with usage_errors():
        run = open_run(folder, ego)
    show_compiled(run.scenario.compiled, request_of(run, json=json), terminal)
    return run


def request_of(run: OpenedRun, *, json: bool = False) -> CompileRequest:
    """Return the request that compiles the scenario of a run."""
    return CompileRequest(Path(run.record.manifest.file), json=json)


def cases_of(run: OpenedRun, folder: Path, rank: int) -> tuple[Case, ...]:
    """Return all cases of a run, the worst first.

    Raises:
        UsageError: there are none, or fewer than `rank`.
    """
    cases = run.every_case()
    if not cases:
        raise UsageError(f"`{folder}` has no case: none of its simulations was valid", "search again")
    if rank > len(cases):
        raise UsageError(f"`{folder}` has no case {rank:,}", f"name one of 1 to {len(cases):,}; 1 is the worst")
    return cases


def checked_run(folder: Path, terminal: Terminal, ego: Egos | None = None, *, json: bool = False) -> OpenedRun:
    """Return a run with a finished generation, as it was written.

    The chain of its journal proves that. Without a chain, its individuals must be those that its method proposes, so
    that a changed result shows only if it changes the next proposals of the method, or the figures of its generation.

    Raises:
        UsageError: there is no readable run, or its journal is not as it was written.
    """
    run = opened_run(folder, terminal, ego, json=json)
    driver = run.scenario.config.driver
    if driver is not None and not driver.can_drive_new_scenes:
        alone = f"simulations whose decisions are stored are run again; new ones need the driver `{driver.name}`"
        terminal.note(f"{alone}: {driver_hint(driver.name)}")
    if not len(run.record.evaluations):
        raise UsageError(f"`{folder}` has no finished generation", "`cortexc resume` goes on with it")
    if not run.record.proved:
        check_past(run, terminal)
    return run


def check_past(run: OpenedRun, terminal: Terminal) -> None:
    """Check that the individuals of a run are those that its method proposes, as `verify` and `resume` promise.

    A chain does not prove that: it tells of changes, not of a journal that another searcher wrote.

    Raises:
        UsageError: they are not.
    """
    if not run.record.proved:
        terminal.note(UNPROVED)
    try:
        check_journal(run)
    except ForeignPastError as error:
        _foreign(run, error, terminal)
    except (MissingExtraError, PluginError, UnknownMethodError):
        method = run.record.manifest.method
        terminal.note(f"not checked: the searcher {method} of this journal is not installed here")


def _foreign(run: OpenedRun, error: ForeignPastError, terminal: Terminal) -> None:
    """Other versions may well search otherwise; the same ones do not, unless a searcher never repeats itself."""
    what = f"generation {error.generation} in the journal of `{run.folder}` is not what {run.record.manifest.method} "
    what += "proposes after the ones before it"
    if changed := changed_versions(run.record.manifest):
        terminal.note(f"{what}; it was started with {', '.join(changed)}", "warn")
        return
    raise UsageError(what, "rows were changed since they were written: restore the file from a copy, or search again")
