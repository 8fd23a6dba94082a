"""`cortexc analyse RUN`: what a search's failures are, taken together."""

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from cortex_dsl.cli.arguments import whole_number
from cortex_dsl.cli.exits import Exit, UsageError
from cortex_dsl.cli.hunting import usage_errors
from cortex_dsl.cli.parser import Parser, cores
from cortex_dsl.cli.simulation import compile_kernels
from cortex_dsl.cli.terminal import Terminal
from cortex_dsl.report.analysis_view import analysis_view, condition_text
from cortex_dsl.report.json_documents import document
from cortex_dsl.runs import OpenedRun, open_run
from engine.search.analysis import BUDGET, Analysis, analyse


def main(arguments: Sequence[str], terminal: Terminal) -> int:
    parser = _parser()
    options = parser.parse_args(arguments)
    if options.help:
        terminal.write(parser.format_help())
        return Exit.FINE
    if options.run is None:
        raise UsageError("no run given", "name the folder of one, such as `cortexc analyse runs/left_turn-ga-001`")
    with usage_errors():
        run = open_run(options.run)
    if not len(run.record.evaluations):
        raise UsageError(f"`{options.run}` has no finished generation", "`cortexc resume` goes on with it")
    compile_kernels(run.scenario, terminal)
    analysis = _analysis(run, options)
    program = run.scenario.program
    if options.json:
        terminal.write(_document(run, analysis))
    else:
        terminal.out.print(analysis_view(program, analysis, terminal.out.width))
    return Exit.FINE


def _analysis(run: OpenedRun, options: argparse.Namespace) -> Analysis:
    config = run.scenario.config
    config = replace(config, search=replace(config.search, jobs=options.jobs or cores()))
    profile = run.record.manifest.profile
    return analyse(run.scenario.program, run.record.evaluations, config, profile, options.budget)


def _document(run: OpenedRun, analysis: Analysis) -> str:
    space = run.scenario.program.space
    kinds = [condition_text(space, cluster) for cluster in analysis.clusters]
    return document("analysis", {"folder": run.folder, "params": space.names, "kinds": kinds, **vars(analysis)})


def _parser() -> Parser:
    parser = Parser(
        prog="cortexc analyse",
        usage="cortexc analyse RUN [--budget N] [--jobs N] [--json]",
        description="Different failures, where they lie, of what kinds they are, which params matter, and which\n"
        "collisions a competent driver would have avoided.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
        add_help=False,
    )
    parser.add_argument("run", metavar="RUN", nargs="?", type=Path, help="a run directory")
    parser.add_argument(
        "--budget",
        metavar="N",
        type=whole_number(0, 10**8),
        default=BUDGET,
        help=f"simulations to find which params matter; 0: leave that out ({BUDGET:,})",
    )
    parser.add_argument(
        "--jobs", metavar="N", type=whole_number(1, 1024), help=f"threads; results never depend on it ({cores()})"
    )
    parser.add_argument("--json", action="store_true", help="one JSON document on stdout, and nothing else there")
    parser.add_argument("--no-colour", "--no-color", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("-h", "--help", action="store_true", help="this page")
    return parser
