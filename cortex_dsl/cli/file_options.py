"""The options of `cortexc FILE` as rows, and the request that they make."""

from argparse import Namespace
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from cortex_dsl.console.command import (
    AGGREGATE,
    DRIVER,
    EGO,
    GENERATIONS,
    HELP,
    HELP_ALL,
    JOBS,
    JSON,
    METRICS,
    NO_COLOUR,
    OBJECTIVE,
    PAPER,
    PARAM,
    POPULATION,
    PRESET,
    PROFILE,
    REFERENCES,
    ROLLOUTS,
    SCENARIO,
    SEED,
    Condition,
    Option,
)
from cortex_dsl.console.request import (
    OF_SYSTEM,
    CompileRequest,
    Mode,
    Request,
    RunRequest,
    SearchRequest,
    filled,
    param_names,
    seconds,
    share,
    whole_number,
)
from cortex_dsl.console.terminal import UsageError

DESCRIPTION = """\
cortexc finds failures of a driver in traffic scenarios written as text.

  cortexc FILE             draw one scene, run it, show what happened
  cortexc FILE --search    search for failures of the driver in FILE
  cortexc FILE --search --ego python:MODULE:FUNCTION    of your own driver
"""

EXAMPLES = """\
examples:
  cortexc examples/left_turn.scn                         one run, drawn here
  cortexc examples/left_turn.scn --ga                    3,000 simulations
  cortexc examples/left_turn.scn --ga --random --seed 7  with a random baseline
  cortexc examples/left_turn.scn --method niching        different failures
  cortexc examples/left_turn.scn -p "EGO_SPEED=50 km/h"  one param is fixed
  cortexc examples/left_turn.scn --sample 10000          share of valid scenes
  cortexc examples/left_turn.scn --check                 diagnostics only

exit codes:
  0    fine
  1    the file has errors
  2    a wrong command line, or a path that cannot be read or written
  3    no valid scene
  4    the command ran, and a stated limit was broken (cortexc test)
  70   a bug in cortexc: please report it
  130  interrupted with Ctrl-C

"""

WHERE_TO_READ = """\
New here? docs/tutorial/first-collision.md goes from an empty file to the first
collision, docs/how-to/test-your-own-driver.md to those of your own driver. The
language is in docs/reference/language.md, Python in docs/reference/python.md."""

BUDGET_LIMIT = 100_000_000
"""Maximum number of simulations of a search."""


def _methods(text: str) -> tuple[str, ...]:
    """Return the names of search methods in a list with commas; the word `list` stays as it is."""
    from cortex_dsl.cli.search import named

    return (text,) if text == LIST else named(text)


def _method_list(options: Namespace) -> str:
    from cortex_dsl.cli.search import method_list

    return method_list() if options.methods == (LIST,) else ""


def _version(_options: Namespace) -> str:
    from cortex_dsl.version import VERSION

    return f"cortexc {VERSION}"


def all_methods(options: Namespace) -> tuple[str, ...]:
    """Return each method once, in the order of the rows."""
    flags = [method for method in ("ga", "random") if getattr(options, method)]
    return tuple(dict.fromkeys((*flags, *(options.methods or ()))))


# -- the rows ----------------------------------------------------------------------------------------------------------

LIST = "list"
SEARCHING = Condition("a search", lambda options: options.choice == Mode.SEARCH.value)
SINGLE_RUN = Condition("a single run", lambda options: not options.choice)
SAMPLING = Condition("--sample", lambda options: options.choice == Mode.SAMPLE.value)
CHECKING = Condition("--check, which runs nothing", lambda options: options.choice == Mode.CHECK.value)
EMITTING = Condition("--emit, which runs nothing", lambda options: options.choice == Mode.EMIT.value)
GENETIC = Condition("the genetic algorithm", lambda options: "ga" in all_methods(options), "add --ga")

BEST_FOR_TESTERS = ("failure_kinds",)
"""Method that finds the most kinds of avoidable failures (benchmarks/README.md)."""

TASK = (
    Option(
        "--search",
        "search for many kinds of avoidable failures",
        choice="search",
        default=False,
        implies={"methods": BEST_FOR_TESTERS, "objective": ("avoidable",), "freeze": OF_SYSTEM},
    ),
    Option("--ga", "search with the genetic algorithm", choice="search", default=False),
    Option(
        "--random",
        "search at random; with --ga: both, side by side",
        choice="search",
        default=False,
        first_page=False,
    ),
    Option(
        "--method",
        "search by another method, or by several: niching,cmaes; `--method list` lists them all",
        "NAME",
        _methods,
        name="methods",
        choice="search",
        answer=_method_list,
    ),
    Option(
        "--sample",
        "draw N scenes and count what was rejected, and why; with --ego: drive them, and count collisions",
        "N",
        whole_number(1, 10**9),
        name="samples",
        choice="sample",
    ),
    Option("--check", "compile only, and show the diagnostics", choice="check"),
    Option(
        "--emit",
        "print a stage: tree, ast, ir or program",
        "STAGE",
        choices=("tree", "ast", "ir", "program"),
        name="stage",
        choice="emit",
        first_page=False,
    ),
)
COMPILING = (
    replace(PARAM, help="fix a param; without a unit, VALUE is in that of the file; may be repeated"),
    Option(
        "--freeze",
        "fix the params of the system under test at the middle of their range, or at the value given by -p",
        "NAMES",
        param_names,
        nargs="?",
        const=(),
        first_page=False,
    ),
    replace(SCENARIO, first_page=False),
)
RUNNING = (
    SEED,
    Option(
        "--engine",
        "batch (compiled kernels; default of a search) or world (pymunk, also after an impact; default of a run)",
        "NAME",
        choices=("batch", "world"),
        excludes=(SAMPLING,),
        first_page=False,
    ),
    *(replace(row, first_page=row is EGO) for row in DRIVER),
    replace(
        PROFILE,
        help="thresholds of the risk score: paper, paper-mm or literature",
        excludes=(SAMPLING,),
        first_page=False,
    ),
    replace(REFERENCES, excludes=(SINGLE_RUN,), first_page=False),
    Option("--time-step", "step of the simulation in seconds (0.05)", "S", seconds(0.001, 0.5), first_page=False),
    Option("--max-attempts", "attempts to draw one scene (2000)", "N", whole_number(1, 10**8), first_page=False),
    Option("--prune", "skip attempts that must fail; the distribution of scenes stays the same", first_page=False),
    Option(
        "--target",
        "with --sample: say which requirement to relax, so that the share P of all attempts is accepted",
        "P",
        share,
        excludes=(SEARCHING,),
        first_page=False,
    ),
    replace(
        JOBS,
        help="workers: threads, processes for searches with --engine world; results never depend on it",
        excludes=(SINGLE_RUN,),
        first_page=False,
    ),
)
SEARCH = (
    GENERATIONS,
    replace(POPULATION, help="individuals in a generation, each with one value for every param"),
    replace(
        PRESET,
        help="how parents are chosen: cortex, by tournament, or cortex-literal, uniformly",
        needs=(GENETIC,),
        first_page=False,
    ),
    replace(
        OBJECTIVE,
        help="goal of the search: risk, avoidable, conflict, severity, injury, controller, or an objective of the "
        "file; may be repeated",
    ),
    replace(ROLLOUTS, first_page=False),
    replace(AGGREGATE, first_page=False),
    Option("--dask", "run on a Dask cluster; `local` starts one with --jobs processes", "ADDRESS", first_page=False),
    Option("--out", "new folder for the results (one under runs/)", "DIR", Path),
    Option(
        "--tables",
        "write CSV and JSON lines beside the journal also for more than 20,000 simulations",
        first_page=False,
    ),
)
OUTPUT = (
    JSON,
    replace(METRICS, excludes=(*METRICS.excludes, SAMPLING, CHECKING, EMITTING)),
    replace(PAPER, excludes=(*PAPER.excludes, SINGLE_RUN, SAMPLING, CHECKING, EMITTING), cure="add --ga to search"),
    Option(
        "--format",
        "diagnostics as text, json or github annotations",
        "NAME",
        choices=("text", "json", "github"),
        name="diagnostics_format",
        first_page=False,
    ),
    replace(NO_COLOUR, help="plain text; NO_COLOR does the same", first_page=False),
    HELP,
    HELP_ALL,
    Option("--version", "the version", answer=_version),
)


def _grouped(group: str, rows: Sequence[Option], excludes: tuple[Condition, ...] = (), cure: str = "") -> list[Option]:
    """Return rows below a heading, with relations that all of them have."""
    return [replace(row, group=group, excludes=(*excludes, *row.excludes), cure=cure) for row in rows]


FILE = Option(
    "file",
    "a scenario, such as examples/left_turn.scn",
    "FILE",
    Path,
    nargs="?",
    first_page=False,
    missing=("no file given", "try `cortexc examples/left_turn.scn`; `cortexc --help` shows more"),
)
SCENES = "scenes and simulation"
OPTIONS = (
    *_grouped("scenario", [FILE]),
    *_grouped("what to do with FILE (one run by default)", TASK),
    *_grouped(SCENES, COMPILING),
    *_grouped(SCENES, RUNNING, (CHECKING, EMITTING)),
    *_grouped(
        "search (with --search, --ga, --random or --method)",
        SEARCH,
        (SINGLE_RUN, SAMPLING, CHECKING, EMITTING),
        "add --search, --ga, --random or --method NAME to search",
    ),
    *_grouped("output", OUTPUT),
)


def to_request(options: Namespace) -> Request:
    """Return the request that checked options make.

    Raises:
        UsageError: a search of too many simulations.
    """
    options.mode = Mode(options.choice or Mode.RUN.value)
    options.methods = all_methods(options)
    options.hints = options.mode is Mode.CHECK
    options.diagnostics_format = "json" if options.json else options.diagnostics_format
    options.compile, options.run = filled(CompileRequest, options), filled(RunRequest, options)
    options.search = search = filled(SearchRequest, options)
    if search.generations * search.population * search.rollouts > BUDGET_LIMIT:
        raise UsageError(
            f"--generations x --population x --rollouts is more than {BUDGET_LIMIT:,} simulations",
            "lower one of them, or make several runs with different seeds",
        )
    return filled(Request, options)
