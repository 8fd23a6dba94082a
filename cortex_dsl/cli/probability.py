"""`cortexc probability FILE`: how probable a collision is under the file's own distributions."""

import argparse
from collections.abc import Sequence
from math import isnan
from pathlib import Path

from cortex_dsl.cli.arguments import SEED_LIMIT, assignment, whole_number
from cortex_dsl.cli.compiling import compile_request
from cortex_dsl.cli.exits import Exit, UsageError
from cortex_dsl.cli.parser import Parser, cores
from cortex_dsl.cli.request import Mode, Request
from cortex_dsl.cli.simulation import compile_kernels, open_scenario
from cortex_dsl.cli.terminal import Terminal
from cortex_dsl.report.json_documents import document
from cortex_dsl.report.probability_view import probability_view
from engine.search.probability import REPETITIONS, estimate

SAMPLES = 10_000


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
    request = Request(
        file=options.file,
        mode=Mode.SEARCH,
        overrides=dict(options.param or ()),
        scenario=options.scenario,
        seed=options.seed,
        jobs=options.jobs or cores(),
        json=options.json,
    )
    compiled = compile_request(request, terminal)
    if isinstance(compiled, Exit):
        return compiled
    scenario = open_scenario(request, compiled)
    compile_kernels(scenario, terminal)
    found = estimate(scenario.program, scenario.config, options.method, options.samples, options.seed or 0)
    if options.json:
        terminal.write(document("probability", {"file": options.file, **vars(found)}))
    else:
        terminal.out.print(probability_view(scenario.program, found))
    return Exit.NO_SCENE if isnan(found.value) else Exit.FINE


def _parser() -> Parser:
    parser = Parser(
        prog="cortexc probability",
        usage="cortexc probability FILE [--method mc|subset] [--samples N] [options]",
        description="The probability of a collision, given a valid scene, when every param is drawn as the file says.",
        epilog="mc: independent draws. subset: for what is rare; chains of runs that come ever nearer to contact.",
        allow_abbrev=False,
        add_help=False,
    )
    parser.add_argument("file", metavar="FILE", nargs="?", type=Path, help="a scenario")
    parser.add_argument("--method", choices=("mc", "subset"), metavar="NAME", default="mc", help="mc or subset (mc)")
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
    parser.add_argument(
        "--jobs", metavar="N", type=whole_number(1, 1024), help=f"threads; results never depend on it ({cores()})"
    )
    parser.add_argument("--json", action="store_true", help="one JSON document on stdout, and nothing else there")
    parser.add_argument("--no-colour", "--no-color", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("-h", "--help", action="store_true", help="this page")
    return parser
