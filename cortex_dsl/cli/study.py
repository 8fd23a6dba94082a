"""`cortexc study`: every scenario by every method, many times; kept whole, compared run by run, told in tables."""

import argparse
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from cortex_dsl.cli.study_options import parse, study_plan
from cortex_dsl.console.terminal import Exit, Terminal, UsageError

if TYPE_CHECKING:
    from engine.search.workers import Workers
    from engine.study.database import Study, StudyStore
    from engine.study.plan import Plan
    from engine.study.run_records import RunRecord


@dataclass(frozen=True)
class Job:
    """A study that is to be carried out, or gone on with."""

    folder: Path
    workers: "Workers"
    json: bool


def main(arguments: Sequence[str], terminal: Terminal) -> int:
    options = parse(arguments)
    if options.help:
        terminal.write(options.page)
        return Exit.FINE
    if options.resume is not None:
        return resume(options.resume, terminal, study_workers(options), json=options.json)
    with _usage_errors():
        return _begin(options, arguments, terminal)


def study_workers(options: argparse.Namespace) -> "Workers":
    """Who does the runs: processes of this machine, or a cluster."""
    from engine.search.workers import Workers

    if options.dask is not None:
        return Workers("dask", options.jobs, options.dask)
    return Workers("processes", options.jobs)


@contextmanager
def _usage_errors() -> Iterator[None]:
    """What the store or the workers say, as a slip that the user can mend."""
    from cortex_dsl.cli.search_output import usage_errors

    with usage_errors():
        yield


def _begin(options: argparse.Namespace, arguments: Sequence[str], terminal: Terminal) -> int:
    from engine.search.store import hold, new_directory, numbered_directory
    from engine.study.database import StudyStore

    plan = study_plan(options, arguments, terminal)
    if isinstance(plan, Exit):
        return plan
    size = f"{len(plan.subjects)}x{len(plan.methods)}x{plan.runs}"
    folder = new_directory(options.out) if options.out is not None else numbered_directory("study", size)
    with hold(folder):
        with closing(StudyStore.create(folder, plan, _facts(plan, arguments))) as store:
            stopped = _carry_out(plan, (), store, Job(folder, study_workers(options), options.json), terminal)
        return tell(folder, terminal, json=options.json, stopped=stopped)


def resume(folder: Path, terminal: Terminal, workers: "Workers", *, json: bool = False) -> int:
    """Go on with a study that was stopped or killed; tell one that is complete again.

    Raises:
        UsageError: no readable study, another process is at it, or it was begun by another version.
    """
    from engine.search.store import hold
    from engine.study.database import StudyStore, read_study

    with _usage_errors():
        study = read_study(folder)
        for name in study.edited:
            terminal.err.print(f"`{name}` was edited since; the study goes on with what it said", style="warn")
        if study.complete:
            return tell(folder, terminal, json=json)
        _insist_on_same_engine(study)
        with hold(folder):
            study = read_study(folder)
            with closing(StudyStore.reopen(folder)) as store:
                stopped = _carry_out(study.plan, study.records, store, Job(folder, workers, json), terminal)
            return tell(folder, terminal, json=json, stopped=stopped)


def _carry_out(plan: "Plan", earlier: "Sequence[RunRecord]", store: "StudyStore", job: Job, terminal: Terminal) -> bool:
    """Do what is left to do; whether Ctrl-C came first."""
    from cortex_dsl.report.terminal.progress import StudyProgress
    from engine.search.workers import open_workers
    from engine.study.execution import perform_all
    from engine.study.run_records import Finished

    _compile_kernels(plan, terminal)
    with StudyProgress(terminal.err, plan, job.workers.jobs, earlier, quiet=job.json) as progress:

        def on_run(finished: Finished) -> None:
            store.write(finished)
            progress.run_done(finished.record)

        try:
            done = [record.address for record in earlier]
            if job.workers.kind == "dask":
                with open_workers(job.workers) as executor:
                    perform_all(plan, on_run, job.workers.jobs, done, executor)
            else:
                perform_all(plan, on_run, job.workers.jobs, done)
        except KeyboardInterrupt:
            return True
    return False


def tell(folder: Path, terminal: Terminal, *, json: bool = False, stopped: bool = False) -> int:
    """Write the files beside the study, and show what it came to so far."""
    from cortex_dsl.report.terminal.study_view import study_view
    from engine.study.database import read_study
    from engine.study.study_files import summary, write_study
    from engine.study.verdict import findings

    study = read_study(folder)
    found = findings(study.plan, study.records)
    write_study(study, found)
    if json:
        from cortex_dsl.report.documents import document

        terminal.write(document("study", {"folder": folder, **summary(study, found)}))
    else:
        terminal.out.print(study_view(study, found, terminal.out.width))
    if stopped:
        terminal.err.print(f"interrupted; go on with: cortexc study --resume {folder}", style="warn", soft_wrap=True)
        return Exit.INTERRUPTED
    failed = sum(record.figures.simulations.error_runs for record in study.records)
    return Exit.BUG if failed else Exit.FINE


def _compile_kernels(plan: "Plan", terminal: Terminal) -> None:
    """Compile now what every worker will need, so that they do not all do it."""
    from cortex_dsl.console.simulating import announce_compilation

    if announce_compilation(terminal):
        from dataclasses import replace

        from engine.study.execution import perform

        task = plan.task(next(plan.addresses()))
        search = replace(task.config.search, generations=1)
        perform(replace(task, config=replace(task.config, search=search)))


def _facts(plan: "Plan", arguments: Sequence[str]) -> dict[str, object]:
    """What a reader may want to know of how a study came to be."""
    from engine.kernels.jit import source_hash

    versions: dict[str, str] = {}
    for method in plan.methods:
        versions |= plan.manifest(plan.subjects[0], method).versions
    return {"command_line": list(arguments), "versions": versions, "engine": source_hash()}


def _insist_on_same_engine(study: "Study") -> None:
    """Runs of two different engines must not be compared as if they were of one."""
    from engine.kernels.jit import source_hash

    if study.manifest.get("engine") != source_hash():
        wrote = study.manifest.get("versions", {}).get("cortexc", "unknown")
        raise UsageError(
            f"the study in `{study.folder}` was begun by another version of the engine",
            f"use the version that began it, cortexc {wrote}, or begin a new study",
        )
