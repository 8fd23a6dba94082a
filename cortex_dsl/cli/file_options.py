"""The command line of `cortexc FILE`: its options in groups, its help, and the request that they make."""

import argparse
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from cortex_dsl.console.command import (
    DRIVER_OPTIONS,
    Parser,
    TwoColumns,
    add_ego,
    add_json,
    cores,
    driver_options,
    flag_of,
)
from cortex_dsl.console.request import (
    GENERATION_LIMIT,
    SEED_LIMIT,
    CompileRequest,
    Mode,
    Request,
    RunRequest,
    SearchRequest,
    aggregate,
    assignment,
    param_names,
    seconds,
    share,
    whole_number,
)
from cortex_dsl.console.terminal import UsageError

DESCRIPTION = """\
cortexc finds the corner cases of a driving scenario that is written as text.

  cortexc FILE             draw one scene, run it, show what happened
  cortexc FILE --ga        search for collisions with a genetic algorithm"""

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
  70   a bug in cortexc: please report it
  130  interrupted with Ctrl-C

New here? docs/tutorial/first-collision.md goes from an empty file to the first
collision. All of the language is in docs/reference/language.md, Python in
docs/reference/python.md; the reports are explained in README.md."""

SEARCH_OPTIONS = ("generations", "population", "preset", "objective", "rollouts", "aggregate", "dask", "out")
RUN_OPTIONS = ("seed", "engine", "jobs", "max_attempts", "time_step", "profile", "prune", "target", *DRIVER_OPTIONS)
"""Options of drawing and running: they mean nothing where a file is only compiled."""
BUDGET_LIMIT = 100_000_000


def build_parser() -> Parser:
    """The parser of `cortexc FILE`; options that were not given stay None."""
    parser = Parser(
        prog="cortexc",
        usage="cortexc FILE [--ga] [--random] [--method NAME] [options]\n"
        "       cortexc FILE [--sample N | --check | --emit STAGE] [options]",
        description=DESCRIPTION + _subcommands(),
        epilog=EXAMPLES,
        formatter_class=TwoColumns,
        allow_abbrev=False,
        add_help=False,
    )
    scenario = parser.add_argument_group("scenario")
    scenario.add_argument(
        "file", metavar="FILE", nargs="?", type=Path, help="a scenario, such as examples/left_turn.scn"
    )
    _add_modes(parser)
    _add_scene_options(parser)
    _add_search_options(parser)
    _add_output_options(parser)
    return parser


def _subcommands() -> str:
    """A line for each command that is called by its name."""
    from cortex_dsl.cli.command_table import SUBCOMMANDS

    calls = {name: f"{name} {command.arguments}".rstrip() for name, command in SUBCOMMANDS.items()}
    return "".join(f"\n  cortexc {calls[name]:<16} {SUBCOMMANDS[name].summary}" for name in calls)


def _add_modes(parser: Parser) -> None:
    group = parser.add_argument_group("what to do with FILE (one run by default)")
    group.add_argument("--ga", action="store_true", help="search with the genetic algorithm")
    group.add_argument("--random", action="store_true", help="search at random; with --ga: both, side by side")
    group.add_argument(
        "--method",
        metavar="NAME",
        help="search by another method, or by several: niching,cmaes; `--method list` lists them all",
    )
    group.add_argument(
        "--sample",
        metavar="N",
        type=whole_number(1, 10**9),
        help="draw N scenes and count what was rejected, and why; with --ego: drive them, and count collisions",
    )
    group.add_argument("--check", action="store_true", help="compile only, and show the diagnostics")
    stages = ("tree", "ast", "ir", "program")
    group.add_argument("--emit", metavar="STAGE", choices=stages, help="print a stage: tree, ast, ir or program")


def _add_scene_options(parser: Parser) -> None:
    group = parser.add_argument_group("scenes and simulation")
    group.add_argument(
        "-p",
        "--param",
        metavar="NAME=VALUE",
        action="append",
        type=assignment,
        help="fix a param; without a unit, VALUE is in that of the file; may be repeated",
    )
    group.add_argument(
        "--freeze",
        metavar="NAMES",
        nargs="?",
        const=(),
        type=param_names,
        help="fix the params of the system under test at the middle of their range, or at the value given by -p",
    )
    group.add_argument("--scenario", metavar="NAME", help="the scenario to run, where the file has several (Main)")
    group.add_argument("--seed", metavar="N", type=whole_number(0, SEED_LIMIT), help="seed of all random numbers (0)")
    group.add_argument(
        "--engine",
        choices=("batch", "world"),
        metavar="NAME",
        help="batch (compiled kernels; default of a search) or world (pymunk, also after an impact; default of a run)",
    )
    add_ego(group)
    group.add_argument(
        "--profile",
        choices=("paper", "paper-mm", "literature"),
        metavar="NAME",
        help="thresholds of the risk score: paper, paper-mm or literature (paper)",
    )
    group.add_argument(
        "--time-step", metavar="S", type=seconds(0.001, 0.5), help="step of the simulation in seconds (0.05)"
    )
    group.add_argument(
        "--max-attempts", metavar="N", type=whole_number(1, 10**8), help="attempts to draw one scene (2000)"
    )
    group.add_argument(
        "--prune",
        action="store_const",
        const=True,
        help="skip attempts that must fail; the distribution of scenes stays the same",
    )
    group.add_argument(
        "--target",
        metavar="P",
        type=share,
        help="with --sample: say which requirement to relax, so that the share P of all attempts is accepted",
    )
    group.add_argument(
        "--jobs",
        metavar="N",
        type=whole_number(1, 1024),
        help=f"workers: threads, processes for searches with --engine world; results never depend on it ({cores()})",
    )


def _add_search_options(parser: Parser) -> None:
    group = parser.add_argument_group("search (with --ga, --random or --method)")
    group.add_argument("--generations", metavar="N", type=whole_number(1, GENERATION_LIMIT), help="generations (30)")
    group.add_argument(
        "--population",
        metavar="N",
        type=whole_number(2, 10**6, "a crossover needs two parents"),
        help="individuals in a generation, each with one value for every param (100)",
    )
    group.add_argument(
        "--preset",
        choices=("cortex", "cortex-literal"),
        metavar="NAME",
        help="how parents are chosen: cortex, by tournament, or cortex-literal, uniformly (cortex)",
    )
    group.add_argument(
        "--objective",
        metavar="NAME",
        action="append",
        help="goal of the search: risk, avoidable, conflict, severity, injury, controller, or an objective of the "
        "file; may be repeated (risk)",
    )
    group.add_argument("--rollouts", metavar="K", type=whole_number(1, 10_000), help="scenes for each individual (1)")
    group.add_argument(
        "--aggregate",
        metavar="HOW",
        type=aggregate,
        help="one score from K: mean, max or a quantile such as q90 (mean)",
    )
    group.add_argument(
        "--dask", metavar="ADDRESS", help="run on a Dask cluster; `local` starts one with --jobs processes"
    )
    group.add_argument("--out", metavar="DIR", type=Path, help="new folder for the results (one under runs/)")


def _add_output_options(parser: Parser) -> None:
    group = parser.add_argument_group("output")
    add_json(group)
    group.add_argument(
        "--format",
        choices=("text", "json", "github"),
        metavar="NAME",
        default="text",
        help="diagnostics as text, json or github annotations",
    )
    group.add_argument("--no-colour", "--no-color", action="store_true", help="plain text; NO_COLOR does the same")
    group.add_argument("-h", "--help", action="store_true", help="this page")
    group.add_argument("--version", action="store_true", help="the version")


def to_request(options: argparse.Namespace, arguments: Sequence[str]) -> Request:
    """The checked command line.

    Raises:
        UsageError: options that do not go together, or no file.
    """
    if options.file is None:
        raise UsageError("no file given", "try `cortexc examples/left_turn.scn`; `cortexc --help` shows more")
    mode, methods = _mode(options), _methods(options)
    _reject_idle_options(options, mode, methods)
    compiling = CompileRequest(
        file=options.file,
        overrides=_overrides(options.param or ()),
        freeze=options.freeze,
        scenario=options.scenario,
        json=options.json,
        diagnostics_format="json" if options.json else options.format,
        hints=mode is Mode.CHECK,
    )
    run = RunRequest(**{"jobs": cores(), **_given(options, RUN_OPTIONS)})
    search = SearchRequest(methods=methods, command_line=tuple(arguments), **_given(options, SEARCH_OPTIONS))
    if search.generations * search.population * search.rollouts > BUDGET_LIMIT:
        raise UsageError(
            f"--generations x --population x --rollouts is more than {BUDGET_LIMIT:,} simulations",
            "lower one of them, or make several runs with different seeds",
        )
    return Request(mode, compiling, run, search, options.sample or 0, options.emit or "")


def _given(options: argparse.Namespace, names: Sequence[str]) -> dict[str, Any]:
    """The options that were given; for the others the request, or the file, has a value."""
    given = {name: value for name in names if (value := getattr(options, name)) is not None}
    return {name: tuple(value) if isinstance(value, list) else value for name, value in given.items()}


def _methods(options: argparse.Namespace) -> tuple[str, ...]:
    """Each method once, in the order of the flags."""
    flags = [method for method in ("ga", "random") if getattr(options, method)]
    if options.method is None:
        return tuple(flags)
    named = import_module("cortex_dsl.cli.search").named(options.method)  # names mean nothing to a file that is read
    return tuple(dict.fromkeys((*flags, *named)))


def _mode(options: argparse.Namespace) -> Mode:
    """The one thing to do; two at once are a slip."""
    asked = {
        Mode.SEARCH: _search_flag(options),
        Mode.SAMPLE: "--sample" if options.sample is not None else "",
        Mode.CHECK: "--check" if options.check else "",
        Mode.EMIT: "--emit" if options.emit is not None else "",
    }
    chosen = [mode for mode, flag in asked.items() if flag]
    if len(chosen) > 1:
        raise UsageError(" and ".join(asked[mode] for mode in chosen) + " ask for different things", "give one of them")
    return chosen[0] if chosen else Mode.RUN


def _search_flag(options: argparse.Namespace) -> str:
    return "--ga" if options.ga else "--random" if options.random else "--method" if options.method else ""


def _reject_idle_options(options: argparse.Namespace, mode: Mode, methods: Sequence[str]) -> None:
    """An option that would do nothing here is said, not ignored."""
    idle = {
        Mode.SEARCH: ("target",),
        Mode.RUN: (*SEARCH_OPTIONS, "jobs"),
        Mode.SAMPLE: (*SEARCH_OPTIONS, "engine", "profile"),
    }
    for name in idle.get(mode, (*SEARCH_OPTIONS, *RUN_OPTIONS)):
        if getattr(options, name) is not None:
            flag = flag_of(name)
            cure = "add --ga, --random or --method NAME to search" if name in SEARCH_OPTIONS else f"leave {flag} out"
            raise UsageError(f"{flag} has no effect {_WITHOUT_EFFECT[mode]}", cure)
    driver_options(options)
    if options.aggregate is not None and options.rollouts is None:
        raise UsageError("--aggregate has no effect with one scene for each individual", "add --rollouts K")
    if options.preset is not None and "ga" not in methods:
        raise UsageError("--preset has no effect without the genetic algorithm", "add --ga")


_WITHOUT_EFFECT = {
    Mode.SEARCH: "on a search",
    Mode.RUN: "on a single run",
    Mode.SAMPLE: "on --sample",
    Mode.CHECK: "on --check, which runs nothing",
    Mode.EMIT: "on --emit, which runs nothing",
}


def _overrides(pairs: Sequence[tuple[str, str]]) -> dict[str, str]:
    overrides = dict(pairs)
    for name in overrides:
        if sum(name == other for other, _ in pairs) > 1:
            raise UsageError(f"-p {name} is given twice", "give every param once")
    return overrides
