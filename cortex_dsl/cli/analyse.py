"""Failures of a scenario as a whole (`cortexc analyse`), and their probability (`cortexc probability`)."""

import argparse
import math
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path

from cortex_dsl.api.runs import OpenedRun
from cortex_dsl.api.scenario import Scenario
from cortex_dsl.cli.search_output import checked_run, opened_run, usage_errors
from cortex_dsl.console.command import (
    DRIVER,
    EGO,
    JOBS,
    PARAM,
    REFERENCES,
    SCENARIO,
    SEED,
    Command,
    Condition,
    Option,
    excluded_by,
    run_of,
)
from cortex_dsl.console.compiling import compile_request
from cortex_dsl.console.kernels import SEARCH, compile_kernels
from cortex_dsl.console.request import CompileRequest, RunRequest, filled, whole_number
from cortex_dsl.console.simulating import open_scenario, proved_impossible
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from cortex_dsl.report.findings.analysis_report import analysis_content
from cortex_dsl.report.terminal.render import rendered
from cortex_dsl.report.views.analysis import analysis_view, probability_view
from engine.search.insight.analysis import BUDGET, Analysis, analyse
from engine.search.probability.estimates import Withheld, content, keep
from engine.search.probability.monte_carlo import CONDITIONS, JOINT, METHODS, PARAMS, RARE, Probability, estimate


def _analyse(options: argparse.Namespace, terminal: Terminal) -> int:
    run = checked_run(options.run, terminal, options.ego, json=options.json)
    compile_kernels(terminal, SEARCH, run.scenario.program, run.scenario.config)
    analysis = _analysis(run, options)
    program = run.scenario.program
    if options.json:
        terminal.document("analysis", {"folder": run.folder, **analysis_content(run.scenario.program.space, analysis)})
    else:
        console = terminal.out
        view = analysis_view(program, analysis)
        console.print(rendered(view, console.width, ascii_only=console.options.ascii_only))
    return Exit.FINE


def _analysis(run: OpenedRun, options: argparse.Namespace) -> Analysis:
    config = run.scenario.config
    config = replace(config, search=replace(config.search, jobs=options.jobs))
    profile = run.record.manifest.profile
    return analyse(run.scenario.program, run.record.evaluations, config, profile, options.budget)


ANALYSE = Command(
    name="analyse",
    usage="RUN [--budget N] [--jobs N] [--json]",
    description="""\
Show the kinds of failures (those that a competent driver would have avoided
come first), where they lie in the space of params, which params matter, and
why collisions are avoidable or not.""",
    options=(
        run_of("analyse"),
        Option(
            "--budget", "simulations to find which params matter; 0: none", "N", whole_number(0, 10**8), default=BUDGET
        ),
        JOBS,
        EGO,
    ),
    function=_analyse,
)


# -- how probable a collision is under the file's own distributions ----------------------------------------------------

SAMPLES = 10_000
PROBABILITY_EPILOG = """\
methods:
  mc          plain Monte Carlo: independent draws
  subset      for rare events: chains of runs that come nearer and nearer to
              contact
  importance  for rare events: draws more often where failures are, and weights
              each run by its probability under the file
subset and importance give a reason instead of an interval if the distance to
contact does not lead to failures.

conditions:
  params      draws the params once, then tries to draw a scene for them in
              max_attempts attempts
  joint       draws the params again in every attempt (mc only); --samples
              then counts valid runs

With a run directory, the scenario and the settings are those of its search,
and the result is kept there for `cortexc report`."""


def _width(text: str) -> float:
    """Parse the width of an interval of a probability."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value < 1.0:
        raise argparse.ArgumentTypeError(f"must be a number between 0 and 1, such as 0.01, not `{text}`")
    return value


def _probability(options: argparse.Namespace, terminal: Terminal) -> int:
    if options.of == "":
        raise UsageError("--of has no name", "name an `expect` of the file, or leave it out for collisions")
    least = RARE[options.method].least if options.method in RARE else 1
    if options.samples < least:
        raise UsageError(f"--samples is {options.samples}", f"--method {options.method} needs at least {least:,}")
    if options.method in RARE and options.condition == JOINT:
        raise UsageError("--condition joint needs --method mc", "leave --method out")
    if options.until_width is not None and options.method != "mc":
        raise UsageError("--until-width needs --method mc", "leave --method out")
    if options.file.is_dir():
        return _of_run(options, terminal)
    request, run = filled(CompileRequest, options), filled(RunRequest, options)
    compiled = compile_request(request, terminal)
    if isinstance(compiled, Exit):
        return compiled
    scenario = open_scenario(request, run, compiled)
    compile_kernels(terminal, SEARCH, scenario.program, scenario.config)
    nothing = {"method": options.method, "value": None, "simulations": 0, "valid": 0, "withheld": Withheld.INVALID}
    if (impossible := proved_impossible(scenario, request, run, terminal, "probability", nothing)) is not None:
        return impossible
    seed = options.seed or 0
    with usage_errors(), _measured(options, terminal):
        found = estimate(
            scenario.program,
            scenario.config,
            options.method,
            options.samples,
            seed,
            options.condition,
            of=options.of or "",
            until_width=options.until_width or 0.0,
        )
    return _show(options, scenario, found, terminal)


def _measured(options: argparse.Namespace, terminal: Terminal) -> AbstractContextManager[None]:
    """Show the progress of an estimate; subset simulation needs an unknown number of levels."""
    from cortex_dsl.report.terminal.progress import measured

    return measured(terminal.err, None if options.method == "subset" else options.samples)


def _of_run(options: argparse.Namespace, terminal: Terminal) -> int:
    """Estimate the probability for the scenario of a run, and store it next to its journal."""
    run = opened_run(options.file, terminal, options.ego, json=options.json)
    with usage_errors():
        compile_kernels(terminal, SEARCH, run.scenario.program, run.scenario.config)
        config = replace(run.scenario.config, search=replace(run.scenario.config.search, jobs=options.jobs))
        seed = config.search.seed if options.seed is None else options.seed
        program, of, width = run.scenario.program, options.of or "", options.until_width or 0.0
        with _measured(options, terminal):
            found = estimate(
                program,
                config,
                options.method,
                options.samples,
                seed,
                options.condition,
                of=of,
                until_width=width,
            )
    code = _show(options, run.scenario, found, terminal)
    with usage_errors():
        path = keep(run.folder, found, run.scenario.program.digest, seed)
    terminal.err.print(f"kept in {path}; `cortexc report` shows it", style="quiet", soft_wrap=True)
    return code


def _show(options: argparse.Namespace, scenario: Scenario, found: Probability, terminal: Terminal) -> int:
    if options.json:
        terminal.document(
            "probability", {"file": options.file, "references": scenario.config.search.references, **content(found)}
        )
    else:
        terminal.out.print(rendered(probability_view(scenario.program, found), terminal.out.width))
    return Exit.NO_SCENE if found.withheld == Withheld.INVALID or not found.valid + found.lost else Exit.FINE


OF_RUN = Condition("a run, which keeps the settings of its search", lambda options: options.file.is_dir())


PROBABILITY = Command(
    name="probability",
    usage="FILE|RUN [--of NAME] [--method NAME] [options]",
    description="Estimate the probability of a collision, given a valid scene. Params are drawn\n"
    "from the distributions of the file.",
    options=(
        Option(
            "file",
            "a scenario, or a run directory",
            "FILE|RUN",
            Path,
            nargs="?",
            missing=("no file given", "try `cortexc probability examples/left_turn.scn`"),
        ),
        Option("--method", "mc, subset or importance", "NAME", choices=METHODS, default="mc"),
        Option("--condition", "params or joint, see below", "NAME", choices=CONDITIONS, default=PARAMS),
        Option("--of", "estimate how likely this `expect` of the file fails (a collision)", "NAME"),
        Option("--samples", "simulations; with subset: for each level", "N", whole_number(1, 10**8), default=SAMPLES),
        Option("--until-width", "stop when the interval is this narrow, as 0.01; --samples: at most", "W", _width),
        *excluded_by(OF_RUN, PARAM, SCENARIO),
        SEED,
        JOBS,
        EGO,
        *excluded_by(OF_RUN, REFERENCES, *DRIVER[1:]),
    ),
    function=_probability,
    epilog=PROBABILITY_EPILOG,
)
