"""What the failures of a scenario are, taken together (`cortexc analyse`), and how probable (`cortexc probability`)."""

import argparse
from dataclasses import replace
from pathlib import Path

from cortex_dsl.api.runs import OpenedRun, open_run
from cortex_dsl.api.scenario import Scenario
from cortex_dsl.cli.search_output import checked_run, usage_errors
from cortex_dsl.console.command import EXAMPLE_RUN, Command, Parser, add_ego, add_jobs, add_run
from cortex_dsl.console.compiling import compile_request
from cortex_dsl.console.request import SEED_LIMIT, CompileRequest, RunRequest, assignment, whole_number
from cortex_dsl.console.simulating import compile_kernels, open_scenario
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from cortex_dsl.report.documents import document
from cortex_dsl.report.findings.analysis_report import analysis_content
from cortex_dsl.report.terminal.analysis_view import analysis_view, probability_view
from engine.search.insight.analysis import BUDGET, Analysis, analyse
from engine.search.probability.estimates import Withheld, content, keep
from engine.search.probability.monte_carlo import CONDITIONS, JOINT, METHODS, PARAMS, RARE, Probability, estimate


def _analyse(options: argparse.Namespace, terminal: Terminal) -> int:
    run = checked_run(options.run, terminal, options.ego)
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
    return document("analysis", {"folder": run.folder, **analysis_content(run.scenario.program.space, analysis)})


def _analyse_options(parser: Parser) -> None:
    add_run(parser)
    parser.add_argument(
        "--budget",
        metavar="N",
        type=whole_number(0, 10**8),
        default=BUDGET,
        help=f"simulations to find which params matter; 0: leave that out ({BUDGET:,})",
    )
    add_jobs(parser)
    add_ego(parser, batch=False)


ANALYSE = Command(
    name="analyse",
    usage="RUN [--budget N] [--jobs N] [--json]",
    description="""\
Kinds of failures, those first that a competent driver would have avoided, where
they lie, which params matter, and why collisions are avoidable or not.""",
    options=_analyse_options,
    function=_analyse,
    needs=("run", "no run given", f"name the folder of one, such as `cortexc analyse {EXAMPLE_RUN}`"),
)


# -- how probable a collision is under the file's own distributions ----------------------------------------------------

SAMPLES = 10_000
PROBABILITY_EPILOG = """\
mc: independent draws. subset: for what is rare; chains of runs that come ever
nearer to contact. importance: for what is rare; draws where failures are, and
weighs each run by how likely the file draws it. Both give a reason instead of
an interval where the distance to contact does not lead to failures.
params: they are drawn once, and a scene for them is sought in max_attempts
attempts. joint: they are drawn again with every attempt, as the requirements
are written (mc only); --samples counts valid runs.
Of a run directory: of the scenario that it searched, with its settings; kept
there for `cortexc report`."""


def _probability(options: argparse.Namespace, terminal: Terminal) -> int:
    if options.of == "":
        raise UsageError("--of names no expectation", "name an `expect` of the file, or leave it out for collisions")
    least = RARE[options.method].least if options.method in RARE else 1
    if options.samples < least:
        raise UsageError(f"--samples is {options.samples}", f"--method {options.method} needs at least {least:,}")
    if options.method in RARE and options.condition == JOINT:
        raise UsageError("--condition joint needs --method mc", "leave --method out")
    if options.file.is_dir():
        return _of_run(options, terminal)
    request = CompileRequest(
        options.file, overrides=dict(options.param or ()), scenario=options.scenario, json=options.json
    )
    compiled = compile_request(request, terminal)
    if isinstance(compiled, Exit):
        return compiled
    scenario = open_scenario(request, RunRequest(seed=options.seed, jobs=options.jobs, ego=options.ego), compiled)
    compile_kernels(scenario, terminal)
    seed = options.seed or 0
    with usage_errors():
        found = estimate(
            scenario.program,
            scenario.config,
            options.method,
            options.samples,
            seed,
            options.condition,
            of=options.of or "",
        )
    return _show(options, scenario, found, terminal)


def _of_run(options: argparse.Namespace, terminal: Terminal) -> int:
    """The same for the scenario that a run searched, kept beside its journal."""
    for name in ("param", "scenario"):
        if getattr(options, name) is not None:
            raise UsageError(f"--{name} has no effect on a run: it was searched as it was", "leave it out")
    with usage_errors():
        run = open_run(options.file, options.ego)
        compile_kernels(run.scenario, terminal)
        config = replace(run.scenario.config, search=replace(run.scenario.config.search, jobs=options.jobs))
        seed = config.search.seed if options.seed is None else options.seed
        program = run.scenario.program
        found = estimate(program, config, options.method, options.samples, seed, options.condition, of=options.of or "")
    code = _show(options, run.scenario, found, terminal)
    with usage_errors():
        path = keep(run.folder, found, run.scenario.program.digest, seed)
    terminal.err.print(f"kept in {path}; `cortexc report` shows it", style="quiet", soft_wrap=True)
    return code


def _show(options: argparse.Namespace, scenario: Scenario, found: Probability, terminal: Terminal) -> int:
    if options.json:
        terminal.write(document("probability", {"file": options.file, **content(found)}))
    else:
        terminal.out.print(probability_view(scenario.program, found))
    return Exit.NO_SCENE if found.withheld == Withheld.INVALID or not found.valid else Exit.FINE


def _probability_options(parser: Parser) -> None:
    parser.add_argument("file", metavar="FILE|RUN", nargs="?", type=Path, help="a scenario, or a run directory")
    parser.add_argument("--method", choices=METHODS, metavar="NAME", default="mc", help="mc, subset or importance (mc)")
    parser.add_argument(
        "--condition", choices=CONDITIONS, metavar="NAME", default=PARAMS, help=f"params or joint, see below ({PARAMS})"
    )
    parser.add_argument("--of", metavar="NAME", help="that an `expect` of the file is broken (a collision)")
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
    add_ego(parser, batch=False)


PROBABILITY = Command(
    name="probability",
    usage="FILE|RUN [--of NAME] [--method NAME] [options]",
    description="The probability of a collision, given a valid scene, when every param is drawn\nas the file says.",
    options=_probability_options,
    function=_probability,
    epilog=PROBABILITY_EPILOG,
    needs=("file", "no file given", "try `cortexc probability examples/left_turn.scn`"),
)
