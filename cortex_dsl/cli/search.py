"""Searches: begun by `cortexc FILE --method NAME,…` (`--ga`, `--random`), gone on with by `cortexc resume RUN`."""

import argparse
import textwrap
from dataclasses import replace

from cortex_dsl.api.resuming import reopened
from cortex_dsl.api.run_folder import SearchOptions, SearchResult, search_and_keep
from cortex_dsl.api.runs import OpenedRun
from cortex_dsl.api.scenario import Scenario
from cortex_dsl.cli.search_output import (
    chosen_workers,
    note_outdated,
    opened_run,
    removed,
    request_of,
    show_found,
    usage_errors,
)
from cortex_dsl.console.command import (
    DASK,
    EGO,
    EXAMPLE_RUN,
    GENERATIONS,
    JOBS,
    METRICS,
    PAPER,
    Command,
    Condition,
    run_of,
)
from cortex_dsl.console.compiling import compile_request
from cortex_dsl.console.kernels import SEARCH, compile_kernels
from cortex_dsl.console.request import CompileRequest, RunRequest, SearchRequest
from cortex_dsl.console.searching import watched
from cortex_dsl.console.simulating import open_scenario, proved_impossible
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from cortex_dsl.spelling import nearest
from engine.extras import installing, is_installed
from engine.search.manifest import changed_versions
from engine.search.objectives import objectives
from engine.search.protocol import Box
from engine.search.searchers import SearcherEntry, UnknownMethodError, build_searcher, canonical, known_searchers, seek
from engine.study.database import is_study


def search(request: CompileRequest, run: RunRequest, task: SearchRequest, terminal: Terminal) -> int:
    """Search by every requested method, and show the results."""
    compiled = compile_request(request, terminal)
    if isinstance(compiled, Exit):
        return compiled
    if not len(compiled.program.space):
        raise UsageError(f"`{request.file}` has no param to search", "give it one: `param SPEED = Range(5, 80) km/h`")
    scenario = open_scenario(request, run, compiled, task)
    with usage_errors():
        aims = objectives(scenario.program, task.objective)
        for method in task.methods:  # report missing packages before anything is made
            seek(build_searcher(method, Box.of(scenario.program.space), scenario.config), method, len(aims))
        compile_kernels(terminal, SEARCH, scenario.program, scenario.config)
        if (impossible := proved_impossible(scenario, request, run, terminal, "search", {"searches": []})) is not None:
            return impossible
        found = _searches(scenario, run, task, terminal)
    return show_found(found, scenario, request, terminal)


def _searches(scenario: Scenario, run: RunRequest, task: SearchRequest, terminal: Terminal) -> list[SearchResult]:
    """Run one search after the other; Ctrl-C ends the present one and omits later ones."""
    done: list[SearchResult] = []
    for method in task.methods:
        try:
            done.append(_search(method, scenario, run, task, terminal))
        except KeyboardInterrupt:
            if not done:
                raise
            break
        if done[-1].campaign.stopped:
            break
    return done


def _search(method: str, scenario: Scenario, run: RunRequest, task: SearchRequest, terminal: Terminal) -> SearchResult:
    """One whole search with its run directory."""
    out = task.out / method if task.out is not None and len(task.methods) > 1 else task.out
    with watched(terminal, method, task.generations) as on_generation:
        options = SearchOptions(
            profile=run.profile,
            objective=task.objective,
            workers=chosen_workers(scenario.config.search.engine, run.jobs, task.dask),
            on_generation=on_generation,
            on_removed=removed(terminal),
            command_line=task.command_line,
            tables=task.tables,
        )
        return search_and_keep(scenario, method, out, options)


# -- the names behind `--method`, and `cortexc --method list`: every way to search, in one line each -------------------

WIDTH = 80


def named(text: str) -> tuple[str, ...]:
    """Return the methods of a comma-separated list.

    Raises:
        UsageError: one of them is not known.
    """
    try:
        return tuple(canonical(word) for word in text.split(","))
    except UnknownMethodError as error:
        if error.replacement is not None:
            raise UsageError(f"--method: `{error.name}` was removed", f"use `{error.replacement}`") from None
        names = [name for method, entry in known_searchers().items() for name in (method, entry.alias) if name]
        near = nearest(error.name, names)
        cure = f"did you mean `{near}`?" if near else "`cortexc --method list` lists them all"
        raise UsageError(f"--method: there is no method `{error.name}`", cure) from None


def method_list() -> str:
    """Return a table of methods: names, short names and summaries, and how to install a missing one."""
    entries = known_searchers()
    names = {name: f"{name} ({entry.alias})" if entry.alias else name for name, entry in entries.items()}
    width = max(map(len, names.values()))
    lines = []
    for name, entry in entries.items():
        first, *others = [*(textwrap.wrap(entry.summary, WIDTH - width - 2) or [""]), *_missing(entry)]
        lines += [f"{names[name]:<{width}}  {first}", *(f"{'':<{width}}  {other}" for other in others)]
    return "\n".join(lines)


def _missing(entry: SearcherEntry) -> list[str]:
    if is_installed(entry.package):
        return []
    return ["not installed; to have it:", f"  {installing('search')}"]


# -- `cortexc resume RUN`: go on with a search that was stopped or killed, as if nothing had happened ------------------


def _resume(options: argparse.Namespace, terminal: Terminal) -> int:
    if is_study(options.run):
        from cortex_dsl.cli.study import resume_study, study_workers

        return resume_study(options.run, terminal, study_workers(options), json=options.json, ego=options.ego)
    run = opened_run(options.run, terminal, options.ego, json=options.json)
    with usage_errors():
        manifest, planned = run.record.manifest, run.scenario.config.search
        generations = options.generations or planned.generations
        workers = chosen_workers(planned.engine, options.jobs, options.dask)
        with reopened(run, options.generations) as rest:
            _say(run, generations, terminal)
            compile_kernels(terminal, SEARCH, run.scenario.program, run.scenario.config)
            with watched(terminal, manifest.method, generations, run.record) as on_generation:
                found = rest.carry_out(on_generation=on_generation, on_removed=removed(terminal), workers=workers)
        note_outdated(run.folder, terminal, run.record.links if rest.journal is None else None)
    request = replace(request_of(run, json=options.json), metrics=options.metrics, paper=options.paper)
    return show_found([found], run.scenario, request, terminal)


def _say(run: OpenedRun, generations: int, terminal: Terminal) -> None:
    """Warn on stderr of facts that may surprise the user."""
    done, manifest = len(run.record.generations), run.record.manifest
    if run.record.status == "finished" and generations == run.scenario.config.search.generations:
        terminal.note(f"finished already, all {done} generations; this is its report")
        return
    terminal.note(f"going on after generation {done} of {generations}")
    for name in run.edited:
        terminal.note(f"`{name}` was edited since; the run goes on with the text that it was started with", "warn")
    if changed := changed_versions(manifest):
        what = f"started with {', '.join(changed)}: what follows may differ from what it would have been"
        terminal.note(what, "warn")


_STUDY = Condition("a study, which continues as it was begun", lambda options: is_study(options.run))

RESUME = Command(
    name="resume",
    usage="RUN [--generations N] [--jobs N] [options]",
    description="Continue a search or a study that was stopped with Ctrl-C, or killed.",
    options=(
        replace(run_of("resume"), help="a run directory, or that of a study"),
        replace(GENERATIONS, help="total number of generations (as planned)", default=None, excludes=(_STUDY,)),
        replace(
            JOBS, help="workers: threads of --engine batch, processes of --engine world; results never depend on it"
        ),
        DASK,
        EGO,
        replace(METRICS, excludes=(*METRICS.excludes, _STUDY)),
        replace(PAPER, excludes=(*PAPER.excludes, _STUDY)),
    ),
    function=_resume,
    epilog=f"""\
The search continues with the text and the settings that it was started with,
and its journal becomes the same as without the stop. If the search is finished
already, its report is shown again, unless --generations asks for more.

example:
  cortexc resume {EXAMPLE_RUN}""",
)
