"""The command line of `cortexc study`, and the plan that it asks for."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from cortex_dsl.console.command import Parser, add_dask, add_ego, add_jobs, driver_options
from cortex_dsl.console.compiling import compile_request
from cortex_dsl.console.request import (
    GENERATION_LIMIT,
    SEED_LIMIT,
    CompileRequest,
    RunRequest,
    SearchRequest,
    aggregate,
    whole_number,
)
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
METHODS = "random,ga"
RUNS = 30
DEFAULTS = {
    "runs": RUNS,
    "methods": METHODS,
    "generations": 30,
    "population": 100,
    "seed": 0,
    "preset": "cortex",
    "profile": "paper",
    "objective": ["risk"],
    "rollouts": 1,
    "aggregate": "mean",
}
"""The options of a study where they are not given; a study that is gone on with has its own."""
LIMIT = 1_000_000_000


def settle(options: argparse.Namespace) -> None:
    """Give every option that was not given its default.

    Raises:
        UsageError: options that do not go together.
    """
    given = [name for name in (*DEFAULTS, "out") if getattr(options, name) is not None]
    if options.resume is not None and (options.files or given):
        what = f"--{given[0]}" if given else "a file"
        raise UsageError(f"{what} has no effect with --resume: the study goes on as it was begun", "leave it out")
    for name, value in DEFAULTS.items():
        if getattr(options, name) is None:
            setattr(options, name, value)


def add_options(parser: Parser) -> None:
    """All options of a study."""
    add = parser.add_argument
    add("files", metavar="FILES", nargs="*", type=Path, help="scenarios, or a folder of them (the paper's six)")
    add("--runs", metavar="N", type=whole_number(1, 65_536), help=f"runs of each method on each scenario ({RUNS})")
    add("--methods", metavar="LIST", help=f"methods, separated by commas, or `all` ({METHODS})")
    add("--generations", metavar="N", type=whole_number(1, GENERATION_LIMIT), help="generations of each run (30)")
    add("--population", metavar="N", type=whole_number(2, 10**6), help="individuals in each generation (100)")
    add(
        "--seed",
        metavar="N",
        type=whole_number(0, SEED_LIMIT),
        help="seed of the first scenario; each further one has the next number (0)",
    )
    add_jobs(parser, "processes, each with a whole run")
    add_dask(parser, "study")
    add(
        "--preset",
        choices=("cortex", "cortex-literal"),
        metavar="NAME",
        help="preset of the genetic algorithm (cortex)",
    )
    add(
        "--profile",
        choices=("paper", "paper-mm", "literature"),
        metavar="NAME",
        help="thresholds of the risk score (paper)",
    )
    add("--objective", metavar="NAME", action="append", help="goal of the search; may be repeated (risk)")
    add("--rollouts", metavar="K", type=whole_number(1, 10_000), help="scenes for each individual (1)")
    add(
        "--aggregate",
        metavar="HOW",
        type=aggregate,
        help="one score from K: mean, max or a quantile such as q90 (mean)",
    )
    add_ego(parser)
    add("--out", metavar="DIR", type=Path, help="new folder for the study (one under runs/)")
    add("--resume", metavar="DIR", type=Path, help="continue the study in this folder")


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

    methods = tuple(dict.fromkeys(_methods(options.methods)))
    files = _unfolded(options.files) or _the_six(terminal)
    subjects: list[Subject] = []
    for file, name in zip(files, short_names(files), strict=True):
        subject = _subject(file, name, options, terminal)
        if isinstance(subject, Exit):
            return subject
        subjects.append(subject)
    plan = Plan(with_own_seeds(subjects), methods, options.runs, options.profile, tuple(options.objective))
    if plan.individuals * options.rollouts * plan.runs * len(subjects) * len(methods) > LIMIT:
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


def _methods(text: str) -> list[str]:
    """The names of a list with commas."""
    from engine.extras import is_installed
    from engine.search.searchers import UnknownMethodError, canonical, known_searchers

    if text.strip() == "all":
        return [name for name, entry in known_searchers().items() if is_installed(entry.package)]
    try:
        return [canonical(word) for word in text.split(",")]
    except UnknownMethodError as error:
        known = list(known_searchers())
        match = nearest(error.name, known)
        meant = f"; did you mean `{match}`?" if match else ""
        raise UsageError(
            f"--methods: no method is called `{error.name.strip()}`{meant}", f"there are {', '.join(known)}"
        ) from error


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
    """The paper's scenarios, as they lie beside this program; say so."""
    from engine.paper import FILES

    files = [Path(str(resource(f"examples/{name}.scn"))) for name in FILES]
    if not all(file.is_file() for file in files):
        raise UsageError("the six examples are not installed here", "name one or more scenario files")
    here = Path.cwd()
    files = [file.relative_to(here) if file.is_relative_to(here) else file for file in files]
    terminal.note(f"no FILES: the paper's six scenarios, {files[0].parent}/")
    return files


def _run_request(options: argparse.Namespace) -> RunRequest:
    return RunRequest(seed=options.seed, **driver_options(options))


def _subject(file: Path, name: str, options: argparse.Namespace, terminal: Terminal) -> "Subject | Exit":
    request = CompileRequest(file, json=options.json)
    compiled = compile_request(request, terminal)
    if isinstance(compiled, Exit):
        return compiled
    if not len(compiled.program.space):
        raise UsageError(f"`{file}` has no param to search", "give it one: `param SPEED = Range(5, 80) km/h`")
    from cortex_dsl.api.run_folder import origin_of
    from cortex_dsl.console.simulating import open_scenario
    from engine.study.plan import Subject

    sizes = {each: getattr(options, each) for each in ("generations", "population", "preset", "rollouts", "aggregate")}
    scenario = open_scenario(request, _run_request(options), compiled, SearchRequest(**sizes))
    return Subject(name, str(file), scenario.program, scenario.config, origin_of(scenario))
