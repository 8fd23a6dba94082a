"""`cortexc study`: every scenario by every method, many times; stored whole, compared run by run, shown in tables.

`cortexc paper-check` repeats the arithmetic of the paper of that case study.
"""

import argparse
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from cortex_dsl.console.command import (
    AGGREGATE,
    DASK,
    DRIVER,
    GENERATIONS,
    JOBS,
    OBJECTIVE,
    POPULATION,
    PRESET,
    PROFILE,
    REFERENCES,
    ROLLOUTS,
    SEED,
    Command,
    Option,
    excluded_by,
)
from cortex_dsl.console.compiling import compile_request
from cortex_dsl.console.request import CompileRequest, RunRequest, SearchRequest, filled, whole_number
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from cortex_dsl.installation import resource
from cortex_dsl.plain_text import as_argument
from cortex_dsl.spelling import nearest

if TYPE_CHECKING:
    from engine.driving.names import Egos
    from engine.search.evaluations import Evaluations
    from engine.search.workers import Workers
    from engine.study.database import Study, StudyStore
    from engine.study.plan import Plan, Subject
    from engine.study.run_records import RunRecord


# -- the command line and the plan that it asks for --------------------------------------------------------------------


DESCRIPTION = """\
Run every method many times on every scenario, keep every evaluation, and
compare the methods run by run.

  cortexc study                   the paper's case study: its six scenarios,
                                  the genetic algorithm against random search
  cortexc study --as-paper        the same with the preset and the number of
                                  runs of the paper, and with scenarios whose
                                  validity depends on several genes at once
  cortexc study a.scn b.scn --methods random,ga,niching --runs 30
  cortexc study --resume runs/study-6x2x30-001
                                  continue a study that was stopped or killed"""
METHODS = ("random", "ga")
RUNS = 30
LIMIT = 1_000_000_000


def _methods(text: str) -> tuple[str, ...]:
    """Return the names in a list with commas; `all`: every installed method.

    Raises:
        UsageError: a method is not known.
    """
    from engine.extras import is_installed
    from engine.search.searchers import UnknownMethodError, canonical, known_searchers

    if text.strip() == "all":
        return tuple(name for name, entry in known_searchers().items() if is_installed(entry.package))
    try:
        return tuple(dict.fromkeys(canonical(word) for word in text.split(",")))
    except UnknownMethodError as error:
        known = list(known_searchers())
        match = nearest(error.name, known)
        meant = f"; did you mean `{match}`?" if match else ""
        raise UsageError(
            f"--methods: no method is called `{error.name.strip()}`{meant}", f"there are {', '.join(known)}"
        ) from error


CONTINUED = "resume"
"""Option for a study that is continued, which has its own settings."""
OPTIONS = (
    *excluded_by(
        CONTINUED,
        Option("files", "scenarios, or a folder of them (the paper's six)", "FILES", Path, nargs="*", default=()),
        Option("--runs", "runs of each method on each scenario", "N", whole_number(1, 65_536), default=RUNS),
        Option("--methods", "methods, separated by commas, or `all`", "LIST", _methods, default=METHODS),
        replace(GENERATIONS, help="generations of each run"),
        POPULATION,
        Option(
            "--as-paper",
            "the paper's preset, one run, and the files of examples/paper unless others are named",
            default=False,
            implies={"runs": 1, "preset": "cortex-literal"},
        ),
        replace(SEED, help="seed of the first scenario; each further one has the next number", default=0),
    ),
    replace(JOBS, help="processes, each with a whole run; results never depend on it"),
    replace(DASK, help="address of a Dask scheduler; `local` starts one for the study"),
    *excluded_by(CONTINUED, PRESET, PROFILE, OBJECTIVE, REFERENCES, ROLLOUTS, AGGREGATE),
    *DRIVER,
    *excluded_by(CONTINUED, Option("--out", "new folder for the study (one under runs/)", "DIR", Path)),
    Option("--resume", "continue the study in this folder", "DIR", Path),
)


def study_plan(options: argparse.Namespace, terminal: Terminal) -> "Plan | Exit":
    """The plan of a new study, or the exit code once a file's errors are shown.

    Raises:
        UsageError: a method that is unknown or cannot be used, a scenario without params, too much to do.
    """
    from cortex_dsl.api.studies import short_names
    from engine.errors import ArgumentError
    from engine.extras import MissingExtraError
    from engine.search.objectives import ObjectiveNameError
    from engine.search.searchers import PluginError, SeveralObjectivesError, UnknownMethodError
    from engine.study.plan import Plan, check, with_own_seeds

    files = _unfolded(options.files) or _the_six(options.as_paper, terminal)
    subjects: list[Subject] = []
    for file, name in zip(files, short_names(files), strict=True):
        subject = _subject(file, name, options, terminal)
        if isinstance(subject, Exit):
            return subject
        subjects.append(subject)
    plan = Plan(with_own_seeds(subjects), options.methods, options.runs, options.profile, options.objective)
    if plan.individuals * options.rollouts * plan.runs * len(subjects) * len(options.methods) > LIMIT:
        raise UsageError(f"the whole study is more than {LIMIT:,} simulations", "lower --runs, or make several studies")
    try:
        check(plan)
    except MissingExtraError as error:
        raise UsageError(f"{error.message}: {error.cure}", "`cortexc study --help` lists every option") from error
    except (ObjectiveNameError, SeveralObjectivesError) as error:
        raise UsageError(error.message, error.cure) from error
    except (ArgumentError, UnknownMethodError, PluginError) as error:
        raise UsageError(error.message, "`cortexc study --help` lists every option") from error
    return plan


def _unfolded(paths: Sequence[Path]) -> list[Path]:
    """The files, each folder as the scenarios in it, by name.

    Raises:
        UsageError: a folder without any.
    """
    files: list[Path] = []
    for path in paths:
        inside = sorted(path.glob("*.scn")) if path.is_dir() else [path]
        if not inside:
            raise UsageError(f"there is no scenario (*.scn) in `{path}`", "name another folder, or files")
        files += inside
    return list(dict.fromkeys(files))


def _the_six(as_paper: bool, terminal: Terminal) -> list[Path]:
    """Return the paper's scenarios, which are installed with this program, and print a note."""
    from engine.paper import FILES, SCENARIOS

    names = [f"paper/{letter}" for letter in SCENARIOS] if as_paper else FILES
    files = [Path(str(resource(f"examples/{name}.scn"))) for name in names]
    if not all(file.is_file() for file in files):
        raise UsageError("the six examples are not installed here", "name one or more scenario files")
    here = Path.cwd()
    files = [file.relative_to(here) if file.is_relative_to(here) else file for file in files]
    terminal.note(f"no FILES: the paper's six scenarios, {files[0].parent}/")
    return files


def _subject(file: Path, name: str, options: argparse.Namespace, terminal: Terminal) -> "Subject | Exit":
    request = CompileRequest(file, json=options.json)
    compiled = compile_request(request, terminal)
    if isinstance(compiled, Exit):
        return compiled
    if not len(compiled.program.space):
        raise UsageError(f"`{file}` has no param to search", "give it one: `param SPEED = Range(5, 80) km/h`")
    from cortex_dsl.api.run_folder import origin_of
    from cortex_dsl.console.simulating import open_scenario, proved_impossible
    from engine.study.plan import Subject

    run = replace(filled(RunRequest, options), jobs=1)
    scenario = open_scenario(request, run, compiled, filled(SearchRequest, options))
    if (impossible := proved_impossible(scenario, request, run, terminal, "study", {"runs": 0})) is not None:
        terminal.note(f"`{file}` cannot be studied, and nothing is begun; correct it, or leave it out", "warn")
        return impossible
    return Subject(name, str(file), scenario.program, scenario.config, origin_of(scenario))


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
    from cortex_dsl.report.terminal.render import rendered
    from cortex_dsl.report.views.study import study_view
    from engine.study.database import read_study
    from engine.study.verdict import findings

    study = read_study(folder)
    found = findings(study.plan, study.records)
    restore_study(study, found)
    note_outdated(folder, terminal, study.seals)
    if not json:
        terminal.out.print(rendered(study_view(study, found), terminal.out.width))
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
    reported = (runs.end_reason == EndReason.STUCK) | ((runs.end_reason == EndReason.BROKEN) & (runs.end_rule >= 0))
    return bool(reported[runs.verdict == Verdict.ERROR].all())


STUDY = Command(
    name="study",
    usage="[FILES] [--runs N] [--methods LIST] [options]",
    description=DESCRIPTION,
    options=OPTIONS,
    function=_study,
)


# -- the arithmetic of the CORTEX-AVD paper, done again ----------------------------------------------------------------


def _check_paper(options: argparse.Namespace, terminal: Terminal) -> Exit:
    from cortex_dsl.report.terminal.render import parts
    from cortex_dsl.report.views.study import claims_view
    from engine.paper import claims

    checked = claims()
    if options.json:
        terminal.document("paper-check", {"claims": checked})
    else:
        terminal.out.print(parts(claims_view(checked, options.all), terminal.out.width))
    return Exit.FINE


PAPER_CHECK = Command(
    name="paper-check",
    usage="[--all] [--json]",
    description="Recompute the figures of the paper from its own numbers, and show those that are wrong.",
    options=(Option("--all", "also show what is correct", default=False),),
    function=_check_paper,
    layout=argparse.HelpFormatter,
)
