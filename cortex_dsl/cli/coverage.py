"""`cortexc coverage FILE`: a state for each cell of the `domain` lines of a file, with its proof."""

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from cortex_dsl.cli.judging import command_of, cpu_seconds, effort_file, read_by, usage_errors
from cortex_dsl.console.command import DRIVER, JOBS, PARAM, SCENARIO, SEED, Command, Option, driver_words
from cortex_dsl.console.request import CompileRequest, RunRequest, filled, whole_number
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from cortex_dsl.console.user_files import place_files, read_source, write_output

if TYPE_CHECKING:
    from cortex_dsl.api.coverage import CoveragePlan
    from cortex_dsl.api.scenario import Scenario
    from cortex_dsl.interchange.openodd import OddDomains
    from cortex_dsl.report.findings.coverage_report import CoverageReport
    from cortex_dsl.source import Source

DESCRIPTION = """\
Fill the cells of the `domain` lines of a file with independent runs, and say
for each cell of their product whether it is covered, or why it is not."""
EPILOG = """\
states of a cell:
  covered     runs lie in it: failures, interval of their rate, the worst run
  rare        --rare: a directed search reaches it, with its probability
  blocked     scenes exist, but their runs end before the instant of the domain
  untried     no run lies in it, and nothing is proved: bound of its probability
  excluded    every scene breaks a `require`, which is named
  impossible  no value of the file lies in it, by interval arithmetic

exit codes: 4 if --require is not met, 3 without a valid run; others: `test`"""
DOCUMENT, TABLE = "coverage.json", "cells.csv"
"""Files of --out."""


def _coverage(options: argparse.Namespace, terminal: Terminal) -> int:
    from cortex_dsl.api.coverage import check_domains, cover
    from cortex_dsl.console.compiling import compile_request
    from cortex_dsl.console.kernels import SEARCH, compile_kernels
    from cortex_dsl.console.simulating import open_scenario, proved_impossible
    from cortex_dsl.pipeline import compile_module
    from cortex_dsl.report.terminal.coverage_view import CoverageProgress

    request, run, started = filled(CompileRequest, options), filled(RunRequest, options), cpu_seconds()
    compiled = compile_request(request, terminal)
    if isinstance(compiled, Exit):
        return compiled
    scenario, source, odd = open_scenario(request, run, compiled), read_source(options.file), None
    with usage_errors():
        plan = _plan(options)
        if options.domain is not None:
            odd = _read_odd(options, scenario, source)
            source, plan = odd.source, replace(plan, verdict=odd.verdict)
            compiled = compile_module(odd.module, source, scenario.overrides, scenario=scenario.chosen)
            scenario = replace(scenario, compiled=compiled)
        scenario = replace(scenario, config=replace(scenario.config, driver=None))
        check_domains(scenario, plan)
        _check_folder(options.out)
        compile_kernels(terminal, SEARCH, scenario.program, scenario.config)
        impossible = proved_impossible(scenario, request, run, terminal, "coverage", {"cells": []})
        if impossible is not None:
            return impossible
        with CoverageProgress(terminal.err, 1) as progress:
            report = cover(scenario, source, plan, progress.on_step)
        report = replace(report, command=command_of("coverage", options.command_line))
        if odd is not None:
            report = replace(report, remarks=(*report.remarks, *odd.remarks))
    _show(report, options, terminal)
    _write(report, odd, options, terminal, started)
    if not report.draws:
        return Exit.NO_SCENE
    broken = options.require is not None and report.share < options.require
    return Exit.BROKEN_LIMIT if broken else Exit.FINE


def _read_odd(options: argparse.Namespace, scenario: "Scenario", source: "Source") -> "OddDomains":
    from cortex_dsl.interchange.openodd import odd_domains, read_odd

    return odd_domains(read_odd(options.domain), source, scenario.compiled.module, options.domain)


def _plan(options: argparse.Namespace) -> "CoveragePlan":
    from cortex_dsl.api.coverage import CoveragePlan
    from engine.driving.named import driver_of

    driver = driver_words(options.ego, options.ego_batch, options.ego_observes)
    words = [*driver]
    words += [word for name, value in (options.overrides or {}).items() for word in ("-p", f"{name}={value}")]
    words += ["--scenario", options.scenario] if options.scenario else []
    return CoveragePlan(
        ways=options.ways,
        budget=options.budget,
        seed=options.seed or 0,
        joint=options.joint,
        rare=options.rare or 0,
        method=options.method,
        driver=driver_of(options.ego, options.ego_batch, options.ego_observes),
        replay=tuple(words),
        driver_words=tuple(driver),
        folder=options.out,
        jobs=options.jobs,
    )


def _check_folder(folder: Path | None) -> None:
    """Check that the folder of --out can be made, before anything runs.

    Raises:
        UsageError: it cannot.
    """
    from cortex_dsl.console.user_files import reason

    if folder is None:
        return
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"cannot write to `{folder}`: {reason(error)}", "name another folder") from None


def _show(report: "CoverageReport", options: argparse.Namespace, terminal: Terminal) -> None:
    from cortex_dsl.report.findings.coverage_report import coverage_content
    from cortex_dsl.report.terminal.coverage_view import coverage_view

    if options.json:
        terminal.document("coverage", coverage_content(report))
    else:
        terminal.out.print(coverage_view(report, options.require))


def _write(
    report: "CoverageReport",
    odd: "OddDomains | None",
    options: argparse.Namespace,
    terminal: Terminal,
    started: float,
) -> None:
    """Write the document, the table of all cells, the coverage for `openodd`, and the CPU time since `started`."""
    import csv
    import io

    from cortex_dsl.interchange.openodd import SUFFIX, coverage_document
    from cortex_dsl.report.documents import document
    from cortex_dsl.report.findings.coverage_report import coverage_content, coverage_rows
    from engine.strict_json import json_text

    if options.out is None:
        return
    table = io.StringIO()
    csv.writer(table, lineterminator="\n").writerows(coverage_rows(report))
    content = {**coverage_content(report), "diagnostics": terminal.diagnostics, "notes": terminal.notes}
    write_output(options.out / DOCUMENT, document("coverage", content))
    write_output(options.out / TABLE, table.getvalue())
    exchange = json_text(coverage_document(report, odd), indent=2)
    write_output(options.out / f"{Path(report.path).stem}{SUFFIX}", f"{exchange}\n")
    place_files(options.out, {**report.files, **effort_file(started)}, force=True)


COVERAGE = Command(
    name="coverage",
    usage="FILE [--ways N] [--budget N] [--require SHARE] [options]",
    description=DESCRIPTION,
    options=(
        Option(
            "file",
            "a scenario with `domain` lines",
            "FILE",
            Path,
            nargs="?",
            missing=("no file given", "name one with `domain` lines, such as `cortexc coverage mine.scn`"),
        ),
        Option("--ways", "domains in each product: 1, 2 or 3 (2)", "N", whole_number(1, 3)),
        Option("--budget", "independent runs, or time: 2000, 90s (2000)", "N", read_by("budget_of")),
        Option(
            "--require",
            "least share of the possible cells, as 95%%",
            "SHARE",
            read_by("probability_of", "--require", "share"),
        ),
        Option(
            "--method",
            "tway: scenes of a covering array in place of independent runs",
            "NAME",
            choices=("independent", "tway"),
            default="independent",
        ),
        Option("--domain", "an OpenODD file, whose attributes replace the domains", "ODD", Path),
        Option("--joint", "intervals that hold together (Bonferroni)", default=False),
        Option("--rare", "search untried cells at the start, by N >= 1000 runs each (0)", "N", whole_number(0, 10**6)),
        Option("--out", "folder for coverage.json, cells.csv and scenes", "DIR", Path),
        replace(SEED, type=whole_number(0, 9_000_000_000)),
        JOBS,
        PARAM,
        SCENARIO,
        *DRIVER,
    ),
    function=_coverage,
    epilog=EPILOG,
)
