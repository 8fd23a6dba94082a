"""The command line of `cortexc study`, and the plan that it asks for."""

import argparse
from collections.abc import Sequence
from dataclasses import replace
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
    ROLLOUTS,
    SEED,
    Option,
    excluded_by,
)
from cortex_dsl.console.compiling import compile_request
from cortex_dsl.console.request import CompileRequest, RunRequest, SearchRequest, filled, whole_number
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from cortex_dsl.installation import resource
from cortex_dsl.spelling import nearest

if TYPE_CHECKING:
    from engine.study.plan import Plan, Subject

DESCRIPTION = """\
Run every method many times on every scenario, keep every evaluation, and
compare the methods run by run.

  cortexc study                   the paper's case study: its six scenarios,
                                  the genetic algorithm against random search
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
        replace(SEED, help="seed of the first scenario; each further one has the next number", default=0),
    ),
    replace(JOBS, help="processes, each with a whole run; results never depend on it"),
    replace(DASK, help="address of a Dask scheduler; `local` starts one for the study"),
    *excluded_by(CONTINUED, PRESET, PROFILE, OBJECTIVE, ROLLOUTS, AGGREGATE),
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

    files = _unfolded(options.files) or _the_six(terminal)
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


def _the_six(terminal: Terminal) -> list[Path]:
    """Return the paper's scenarios, which are installed with this program, and print a note."""
    from engine.paper import FILES

    files = [Path(str(resource(f"examples/{name}.scn"))) for name in FILES]
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
