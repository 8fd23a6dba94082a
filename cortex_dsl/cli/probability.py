"""`cortexc probability FILE`: how probable a collision is under the file's own distributions."""

import argparse
from collections.abc import Sequence
from dataclasses import replace
from math import isnan
from pathlib import Path

from cortex_dsl.cli.arguments import SEED_LIMIT, assignment, whole_number
from cortex_dsl.cli.common_options import add_common, add_jobs, command_parser
from cortex_dsl.cli.compiling import compile_request
from cortex_dsl.cli.exits import Exit, UsageError
from cortex_dsl.cli.hunting import usage_errors
from cortex_dsl.cli.parser import Parser
from cortex_dsl.cli.request import Mode, Request
from cortex_dsl.cli.simulation import compile_kernels, open_scenario
from cortex_dsl.cli.terminal import Terminal
from cortex_dsl.report.documents import document
from cortex_dsl.report.terminal.analysis_view import probability_view
from cortex_dsl.runs import open_run
from cortex_dsl.session import Scenario
from engine.search.kept_probability import keep
from engine.search.probability import CONDITIONS, JOINT, PARAMS, REPETITIONS, Probability, estimate

SAMPLES = 10_000
EPILOG = """\
mc: independent draws. subset: for what is rare; chains of runs that come ever
nearer to contact.
params: they are drawn once, and a scene for them is sought in max_attempts
attempts. joint: they are drawn anew with every attempt, as the requirements
are written (mc only); --samples counts valid runs.
Of a run directory: of the scenario that it searched, with its settings; kept
there for `cortexc report`."""


def main(arguments: Sequence[str], terminal: Terminal) -> int:
    parser = _parser()
    options = parser.parse_args(arguments)
    if options.help:
        terminal.write(parser.format_help())
        return Exit.FINE
    if options.file is None:
        raise UsageError("no file given", "try `cortexc probability examples/left_turn.scn`")
    if options.method == "subset" and options.samples < 100 * REPETITIONS:
        raise UsageError(f"--samples is {options.samples}", f"subset simulation needs at least {100 * REPETITIONS:,}")
    if options.method == "subset" and options.condition == JOINT:
        raise UsageError("--condition joint needs --method mc", "leave --method out")
    if options.file.is_dir():
        return _of_run(options, terminal)
    request = Request(
        file=options.file,
        mode=Mode.SEARCH,
        overrides=dict(options.param or ()),
        scenario=options.scenario,
        seed=options.seed,
        jobs=options.jobs,
        json=options.json,
    )
    compiled = compile_request(request, terminal)
    if isinstance(compiled, Exit):
        return compiled
    scenario = open_scenario(request, compiled)
    compile_kernels(scenario, terminal)
    found = estimate(
        scenario.program, scenario.config, options.method, options.samples, options.seed or 0, options.condition
    )
    return _tell(options, scenario, found, terminal)


def _of_run(options: argparse.Namespace, terminal: Terminal) -> int:
    """The same for the scenario that a run searched, kept beside its journal."""
    for name in ("param", "scenario"):
        if getattr(options, name) is not None:
            raise UsageError(f"--{name} has no effect on a run: it was searched as it was", "leave it out")
    with usage_errors():
        run = open_run(options.file)
        compile_kernels(run.scenario, terminal)
        config = replace(run.scenario.config, search=replace(run.scenario.config.search, jobs=options.jobs))
        seed = config.search.seed if options.seed is None else options.seed
        found = estimate(run.scenario.program, config, options.method, options.samples, seed, options.condition)
    code = _tell(options, run.scenario, found, terminal)
    with usage_errors():
        path = keep(run.folder, found, run.scenario.program.digest, seed)
    terminal.err.print(f"kept in {path}; `cortexc report` shows it", style="quiet", soft_wrap=True)
    return code


def _tell(options: argparse.Namespace, scenario: Scenario, found: Probability, terminal: Terminal) -> int:
    if options.json:
        terminal.write(document("probability", {"file": options.file, **vars(found)}))
    else:
        terminal.out.print(probability_view(scenario.program, found))
    return Exit.NO_SCENE if isnan(found.value) else Exit.FINE


def _parser() -> Parser:
    parser = command_parser(
        "probability",
        "FILE|RUN [--method NAME] [--condition NAME] [options]",
        "The probability of a collision, given a valid scene, when every param is drawn\nas the file says.",
        EPILOG,
    )
    parser.add_argument("file", metavar="FILE|RUN", nargs="?", type=Path, help="a scenario, or a run directory")
    parser.add_argument("--method", choices=("mc", "subset"), metavar="NAME", default="mc", help="mc or subset (mc)")
    parser.add_argument(
        "--condition", choices=CONDITIONS, metavar="NAME", default=PARAMS, help=f"params or joint, see below ({PARAMS})"
    )
    parser.add_argument(
        "--samples",
        metavar="N",
        type=whole_number(1, 10**8),
        default=SAMPLES,
        help=f"simulations; of subset: a level ({SAMPLES:,})",
    )
    parser.add_argument("-p", "--param", metavar="NAME=VALUE", action="append", type=assignment, help="hold a param")
    parser.add_argument("--scenario", metavar="NAME", help="the scenario to run, where the file has several (Main)")
    parser.add_argument("--seed", metavar="N", type=whole_number(0, SEED_LIMIT), help="root of all randomness (0)")
    add_jobs(parser)
    add_common(parser)
    return parser
