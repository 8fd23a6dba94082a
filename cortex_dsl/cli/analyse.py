"""`cortexc analyse RUN`: what a search's failures are, taken together."""

import argparse
from collections.abc import Sequence
from dataclasses import replace

from cortex_dsl.cli.arguments import whole_number
from cortex_dsl.cli.common_options import add_common, add_jobs, add_run, command_parser
from cortex_dsl.cli.exits import Exit, UsageError
from cortex_dsl.cli.journals import told_run
from cortex_dsl.cli.parser import Parser
from cortex_dsl.cli.simulation import compile_kernels
from cortex_dsl.cli.terminal import Terminal
from cortex_dsl.report.documents import document
from cortex_dsl.report.findings.analysis_report import condition_text
from cortex_dsl.report.terminal.analysis_view import analysis_view
from cortex_dsl.runs import OpenedRun
from engine.search.analysis import BUDGET, Analysis, analyse
from engine.search.store import example_run

DESCRIPTION = """\
Different failures, where they lie, of what kinds they are, which params matter,
and which collisions a competent driver would have avoided."""


def main(arguments: Sequence[str], terminal: Terminal) -> int:
    parser = _parser()
    options = parser.parse_args(arguments)
    if options.help:
        terminal.write(parser.format_help())
        return Exit.FINE
    if options.run is None:
        raise UsageError("no run given", f"name the folder of one, such as `cortexc analyse {example_run()}`")
    run = told_run(options.run, terminal)
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
    config = replace(config, search=replace(config.search, jobs=options.jobs))
    profile = run.record.manifest.profile
    return analyse(run.scenario.program, run.record.evaluations, config, profile, options.budget)


def _document(run: OpenedRun, analysis: Analysis) -> str:
    space = run.scenario.program.space
    kinds = [condition_text(space, cluster) for cluster in analysis.clusters]
    return document("analysis", {"folder": run.folder, "params": space.names, "kinds": kinds, **vars(analysis)})


def _parser() -> Parser:
    parser = command_parser("analyse", "RUN [--budget N] [--jobs N] [--json]", DESCRIPTION)
    add_run(parser)
    parser.add_argument(
        "--budget",
        metavar="N",
        type=whole_number(0, 10**8),
        default=BUDGET,
        help=f"simulations to find which params matter; 0: leave that out ({BUDGET:,})",
    )
    add_jobs(parser)
    add_common(parser)
    return parser
