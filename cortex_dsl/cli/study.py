"""`cortexc study`: every scenario by every method, many times; stored whole, compared run by run, shown in tables.

`cortexc paper-check` repeats the arithmetic of the paper of that case study.
"""

import argparse
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from cortex_dsl.cli.study_options import DESCRIPTION, OPTIONS, study_plan
from cortex_dsl.console.command import Command, Option
from cortex_dsl.console.terminal import Exit, Terminal
from cortex_dsl.plain_text import as_argument

if TYPE_CHECKING:
    from engine.driving.names import Egos
    from engine.search.evaluations import Evaluations
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


def _study(options: argparse.Namespace, terminal: Terminal) -> int:
    if options.resume is not None:
        return resume_study(options.resume, terminal, study_workers(options), json=options.json, ego=options.ego)
    from cortex_dsl.cli.search_output import usage_errors

    with usage_errors():
        return _begin(options, terminal)


def study_workers(options: argparse.Namespace) -> "Workers":
    """Return the workers for the runs: processes of this machine, or a cluster."""
    from engine.search.workers import Workers

    if options.dask is not None:
        return Workers("dask", options.jobs, options.dask)
    return Workers("processes", options.jobs)


def _begin(options: argparse.Namespace, terminal: Terminal) -> int:
    from cortex_dsl.api.studies import facts
    from engine.search.store import hold, new_directory, numbered_directory
    from engine.study.database import StudyStore

    plan = study_plan(options, terminal)
    if isinstance(plan, Exit):
        return plan
    size = f"{len(plan.subjects)}x{len(plan.methods)}x{plan.runs}"
    folder = new_directory(options.out) if options.out is not None else numbered_directory("study", size)
    with hold(folder):
        with closing(StudyStore.create(folder, plan, facts(plan, options.command_line))) as store:
            stopped = _carry_out(plan, (), store, Job(folder, study_workers(options), options.json), terminal)
        return show_study(folder, terminal, json=options.json, stopped=stopped)


def resume_study(
    folder: Path, terminal: Terminal, workers: "Workers", *, json: bool = False, ego: "Egos | None" = None
) -> int:
    """Continue a study that was stopped or killed; show a complete one again.

    Raises:
        UsageError: no readable study, another process writes it, or another version began it.
    """
    from cortex_dsl.api.studies import insist_on_same_engine
    from cortex_dsl.cli.search_output import usage_errors
    from engine.search.store import hold
    from engine.study.database import StudyStore, read_study

    with usage_errors():
        study = read_study(folder).driven_by(ego)
        for name in study.edited:
            terminal.note(f"`{name}` was edited since; the study goes on with what it said", "warn")
        if study.complete:
            return show_study(folder, terminal, json=json)
        insist_on_same_engine(study)
        with hold(folder):
            study = read_study(folder).driven_by(ego)
            with closing(StudyStore.reopen(folder)) as store:
                stopped = _carry_out(study.plan, study.records, store, Job(folder, workers, json), terminal)
            return show_study(folder, terminal, json=json, stopped=stopped)


def _carry_out(plan: "Plan", earlier: "Sequence[RunRecord]", store: "StudyStore", job: Job, terminal: Terminal) -> bool:
    """Do the remaining work; return whether Ctrl-C stopped it."""
    from cortex_dsl.api.studies import carry_out
    from cortex_dsl.console.kernels import SEARCH, compile_kernels
    from cortex_dsl.report.terminal.progress import StudyProgress
    from engine.study.run_records import Finished

    for subject in plan.subjects:
        compile_kernels(terminal, SEARCH, subject.program, subject.config)
    with StudyProgress(terminal.err, plan, job.workers.jobs, earlier, quiet=job.json) as progress:

        def on_run(finished: Finished) -> None:
            store.write(finished)
            progress.run_done(finished.record)

        return carry_out(plan, earlier, on_run, job.workers)


def show_study(folder: Path, terminal: Terminal, *, json: bool = False, stopped: bool = False) -> int:
    """Write the files next to the study, and show its results so far."""
    from cortex_dsl.api.restoring import restore_study
    from cortex_dsl.cli.search_output import note_outdated
    from cortex_dsl.report.terminal.study_view import study_view
    from engine.study.database import read_study
    from engine.study.verdict import findings

    study = read_study(folder)
    found = findings(study.plan, study.records)
    restore_study(study, found)
    note_outdated(folder, terminal)
    if not json:
        terminal.out.print(study_view(study, found, terminal.out.width))
    code = _end_of(study, terminal)
    if stopped:
        terminal.note(f"interrupted; continue with: cortexc study --resume {folder}", "warn")
        code = Exit.INTERRUPTED
    if json:
        from cortex_dsl.report.findings.study_report import study_content

        terminal.document("study", {"folder": folder, **study_content(study, found)})
    return code


def _end_of(study: "Study", terminal: Terminal) -> Exit:
    """Return the exit code: runs may have failed because of their file, or because of an internal error."""
    from engine.search.store import located
    from engine.study.database import read_evaluations

    failed = [record for record in study.records if record.figures.simulations.error_runs]
    if not failed:
        return Exit.FINE
    if not all(_over_the_file(read_evaluations(study, record.address)) for record in failed):
        return Exit.BUG
    for number in sorted({record.address.scenario for record in failed}):
        file = as_argument(Path(located(study.folder, study.plan.subjects[number].file)))
        terminal.note(f"`{file}` has a mistake; `cortexc {file} --random` shows it", "warn")
    return Exit.DIAGNOSTICS


def _over_the_file(evaluations: "Evaluations") -> bool:
    """Return whether every failed run has a behaviour that never acts, or an objective that is no number."""
    from engine.vocabulary import EndReason, Verdict

    runs = evaluations.rollouts
    told = (runs.end_reason == EndReason.STUCK) | ((runs.end_reason == EndReason.BROKEN) & (runs.end_rule >= 0))
    return bool(told[runs.verdict == Verdict.ERROR].all())


STUDY = Command(
    name="study",
    usage="[FILES] [--runs N] [--methods LIST] [options]",
    description=DESCRIPTION,
    options=OPTIONS,
    function=_study,
)


# -- the arithmetic of the CORTEX-AVD paper, done again ----------------------------------------------------------------


def _check_paper(options: argparse.Namespace, terminal: Terminal) -> Exit:
    from cortex_dsl.report.terminal.study_view import paper_view
    from engine.paper import claims

    checked = claims()
    if options.json:
        terminal.document("paper-check", {"claims": checked})
    else:
        terminal.out.print(paper_view(checked, options.all))
    return Exit.FINE


PAPER_CHECK = Command(
    name="paper-check",
    usage="[--all] [--json]",
    description="Recompute the figures of the paper from its own numbers, and show those that are wrong.",
    options=(Option("--all", "also show what is correct", default=False),),
    function=_check_paper,
    layout=argparse.HelpFormatter,
)
