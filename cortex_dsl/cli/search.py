"""`cortexc FILE --ga`, `--random`, or both: search, keep everything, and say what was found."""

from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cortex_dsl.cli.compiling import compile_request, show
from cortex_dsl.cli.exits import Exit, UsageError
from cortex_dsl.cli.request import Request
from cortex_dsl.cli.simulation import compile_kernels, open_scenario
from cortex_dsl.cli.stuck import never_acts
from cortex_dsl.cli.terminal import Terminal
from cortex_dsl.cli.undefined import undefined_value
from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.report.json_documents import document
from cortex_dsl.report.progress import SearchProgress
from cortex_dsl.report.search_report import SearchReport
from cortex_dsl.report.search_view import comparison_view, failures_line, search_view
from cortex_dsl.runs import origin_of
from cortex_dsl.session import Scenario
from engine.program import Program
from engine.search.campaign import Campaign, Progress
from engine.search.exports import summary, write_exports
from engine.search.journal import Journal
from engine.search.manifest import Manifest, make_manifest
from engine.search.ranking import Case
from engine.search.store import JOURNAL, StoreError, new_directory, numbered_directory, store_errors
from engine.vocabulary import EndReason, Verdict

WORST = "worst"
"""Folder of the concrete scenarios inside a run directory."""


@dataclass(frozen=True)
class Found:
    """One finished search. What went wrong when it was put away must not keep it from being shown."""

    report: SearchReport
    manifest: Manifest
    trouble: StoreError | None = None


def execute(request: Request, terminal: Terminal) -> int:
    compiled = compile_request(request, terminal)
    if isinstance(compiled, Exit):
        return compiled
    program = compiled.program
    if not len(program.space):
        raise UsageError(f"`{request.file}` has no param to search", "give it one: `param SPEED = Range(5, 80) km/h`")
    scenario = open_scenario(request, compiled)
    compile_kernels(scenario, terminal)
    try:
        found = _searches(request, scenario, terminal)
    except StoreError as error:
        raise UsageError(error.message, error.cure) from error
    campaigns = [search.report.campaign for search in found]
    mistake = next((m for campaign in campaigns if (m := _mistake(scenario, campaign)) is not None), None)
    _show(request, program, found, terminal, ours=mistake is None)
    for search in found:
        if search.trouble is not None:
            raise UsageError(search.trouble.message, search.trouble.cure)
    if mistake is not None:
        show(compiled.source, [mistake], replace(request, json=False), terminal)
        return Exit.DIAGNOSTICS
    return _exit_code(campaigns)


def _mistake(scenario: Scenario, campaign: Campaign) -> Diagnostic | None:
    """What to tell of runs that failed over the file itself: a behaviour that never acts, a number that is none."""
    evaluations = campaign.evaluations
    rollouts = evaluations.rollouts
    stuck = np.argwhere(rollouts.end_reason == EndReason.STUCK)
    if len(stuck):
        first = tuple(stuck[0])
        return never_acts(scenario, int(rollouts.end_rule[first]), float(rollouts.end_time[first]))
    failed = np.argwhere(rollouts.verdict == Verdict.ERROR)
    if not len(failed):
        return None
    row, rollout = failed[0]
    return undefined_value(scenario, scenario.scene_of(evaluations.genomes[row], evaluations.keys[row, rollout]))


def _searches(request: Request, scenario: Scenario, terminal: Terminal) -> list[Found]:
    """One search after the other; Ctrl-C ends the one that runs and leaves out those to come."""
    done: list[Found] = []
    for method in request.methods:
        try:
            done.append(_search(method, request, scenario, terminal))
        except KeyboardInterrupt:
            if not done:
                raise
            break
        if done[-1].report.campaign.stopped:
            break
    return done


def _search(method: str, request: Request, scenario: Scenario, terminal: Terminal) -> Found:
    """One whole search with its run directory."""
    program = scenario.program
    folder = _folder(method, request, program)
    manifest = make_manifest(
        program, scenario.config, method, request.profile, str(request.file), request.command_line, origin_of(scenario)
    )
    with closing(Journal.create(folder / JOURNAL, manifest)) as journal:
        with SearchProgress(terminal.err, method, request.generations) as progress:

            def on_generation(done: Progress) -> None:
                journal.write(done)
                best = done.best.score if done.best else float("nan")
                progress.generation_done(done.figures.by_individual, done.simulations, best)

            campaign = scenario.search(
                method, profile=request.profile, preset=request.preset, on_generation=on_generation
            )
        try:
            journal.finish(campaign)
            write_exports(folder, campaign, manifest)
            files = [_write_case(folder, case, scenario, request.file) for case in campaign.worst]
        except StoreError as error:
            return Found(SearchReport(campaign, folder), manifest, error)
    return Found(SearchReport(campaign, folder, files), manifest)


def _folder(method: str, request: Request, program: Program) -> Path:
    if request.out is None:
        return numbered_directory(program.name, method)
    return new_directory(request.out if len(request.methods) == 1 else request.out / method)


def _write_case(folder: Path, case: Case, scenario: Scenario, origin: Path) -> Path:
    """One of the worst as a scenario that runs to the same outcome."""
    remark = f"case {case.rank} of a search in {origin}: risk {case.score}"
    path = folder / WORST / f"{case.rank:02d}.scn"
    files = scenario.concrete_files(scenario.scene(case), remark=remark, name=path.name)
    with store_errors(path):
        path.parent.mkdir(exist_ok=True)
        for name, text in files.items():
            path.with_name(name).write_text(text, encoding="utf-8")
    return path


def _show(request: Request, program: Program, done: Sequence[Found], terminal: Terminal, *, ours: bool) -> None:
    """The report; `ours` says that failed runs are no mistake of the file."""
    reports = [search.report for search in done]
    if request.json:
        terminal.write(_document(request, done))
        return
    console, settings = terminal.out, _settings(request)
    if len(reports) == 1:
        console.print(search_view(program, reports[0], settings, console.width))
    else:
        console.print(comparison_view(program, reports, settings, console.width))
    for report in reports:
        if ours and (line := failures_line(program, report)) is not None:
            terminal.err.print(line)


def _settings(request: Request) -> str:
    """The settings that a reader must know, in one line."""
    parts = [f"{request.generations} x {request.population}", f"seed {request.seed or 0}"]
    if "ga" in request.methods:
        parts.append(f"preset {request.preset}")
    if request.rollouts > 1:
        parts.append(f"{request.aggregate} of {request.rollouts} rollouts")
    return ", ".join([*parts, f"profile {request.profile}", f"{request.engine or 'batch'} engine"])


def _document(request: Request, done: Sequence[Found]) -> str:
    searches = [
        {
            "method": search.report.method,
            "folder": search.report.folder,
            "worst_files": search.report.worst_files,
            **summary(search.report.campaign, search.manifest),
            "figures": search.report.campaign.generations,
        }
        for search in done
    ]
    return document("search", {"file": request.file, "searches": searches})


def _exit_code(campaigns: Sequence[Campaign]) -> Exit:
    if any(campaign.stopped for campaign in campaigns):
        return Exit.INTERRUPTED
    if any(campaign.by_simulation.error_runs for campaign in campaigns):
        return Exit.BUG
    if not any(campaign.by_individual.valid for campaign in campaigns):
        return Exit.NO_SCENE
    return Exit.FINE
