"""`cortexc suite NAME --ego DRIVER`: rating and regulation tests as a library, with a verdict for each cell."""

import argparse
import csv
import io
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cortex_dsl.cli.judging import (
    check_output,
    compiling,
    cpu_seconds,
    effort_file,
    judged_exit,
    print_results,
    read_by,
    usage_errors,
)
from cortex_dsl.console.command import DRIVER, EGO, JOBS, SEED, Command, Option, driver_words
from cortex_dsl.console.request import whole_number
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from cortex_dsl.console.user_files import place_files, write_output

if TYPE_CHECKING:
    from cortex_dsl.api.suite_tables import Suite
    from cortex_dsl.report.findings.suite_report import GroupResult, SuiteReport

DESCRIPTION = """\
Run a driver through the cells of a rating or a regulation: for each cell the
nominal verdict, the probability of a failure within the tolerances of the
document, the least deviation at which it fails, and what reference drivers do.
`cortexc suite list` lists the suites."""
EPILOG = """\
DRIVER is python:..., process:..., or a behavior of the language. A bare name
such as EmergencyBrakeBehavior drives at the speed of the cell, which
arguments may call EGO_SPEED.

examples:
  cortexc suite euroncap-2026 --ego EmergencyBrakeBehavior --only 'CCR*'
  cortexc suite un-r152 --ego python:mine:drive --out runs/r152 --junit r152.xml
  cortexc suite euroncap-2026 --copy mine   then: cortexc suite mine --ego ...

exit codes: 4 a cell fails, or the driver fails in it; 2 an unknown suite, a
pattern without a match, no driver, or one that does not fit; 1 a scenario of a
copied suite has errors; 3 no cell can be run; 0 every cell that is run passes"""
LIST = "list"
PAGE, DOCUMENT, TABLE = "report.html", "suite.json", "cells.csv"


def _appended(earlier: tuple[Any, ...] | None, value: Any) -> tuple[Any, ...]:
    return (*(earlier or ()), value)


def _suite(options: argparse.Namespace, terminal: Terminal) -> int:
    from cortex_dsl.api.suite_tables import suite_of

    started = cpu_seconds()
    if options.suite == LIST:
        return _list(options, terminal)
    with usage_errors():
        suite = suite_of(options.suite)
        if options.copy is not None:
            return _copy(suite, options, terminal)
        if options.only:
            suite = suite.only(options.only)
        if options.ego is None:
            raise UsageError(
                "no driver given", "name one, as in `--ego EmergencyBrakeBehavior`, or --ego python:mine:drive"
            )
        report = _run(suite, options, terminal)
        _write(report, options, started)
    _show_end(report, options, terminal)
    return _exit_code(report)


def _list(options: argparse.Namespace, terminal: Terminal) -> Exit:
    from cortex_dsl.api.suite_tables import NEEDS, suite_names, suite_of
    from engine.gates.ratings import VERIFIED

    suites = [suite_of(name) for name in suite_names()]
    rows = [
        {
            "name": suite.name,
            "title": suite.title,
            "edition": suite.edition,
            "cells": len(suite.cells),
            "can_be_run": sum(not cell.reason for cell in suite.cells),
            "need": {
                need: sum(not cell.reason for group in suite.groups if group.needs == need for cell in group.cells)
                for need in NEEDS
            },
            "unverified": sum(cell.status != VERIFIED for cell in suite.cells),
        }
        for suite in suites
    ]
    if options.json:
        terminal.document("suites", {"suites": rows})
        return Exit.FINE
    width = max(len(suite.name) for suite in suites)
    for row in rows:
        terminal.out.print(f"{row['name']:<{width}}  ", style="title", end="")
        terminal.out.print(
            f"{row['title']}: {row['cells']} cells, {row['can_be_run']} of them can be run", soft_wrap=True
        )
        for need, count in row["need"].items():
            if count:
                terminal.out.print(f"{'':<{width}}  {count} of these need {NEEDS[need]}", soft_wrap=True)
        terminal.out.print(f"{'':<{width}}  {row['edition']}", style="quiet", soft_wrap=True)
    return Exit.FINE


def _copy(suite: "Suite", options: argparse.Namespace, terminal: Terminal) -> Exit:
    """Write the files of a suite into a folder, which may not hold others in their place."""
    from cortex_dsl.api.suites import suite_files

    files = {name: path.read_bytes() for name, path in suite_files(suite).items()}
    place_files(options.copy, files, force=False)
    if options.json:
        terminal.document("suite-copy", {"folder": str(options.copy), "files": sorted(files)})
    else:
        terminal.out.print(f"{len(files)} files: {options.copy}", soft_wrap=True)
    return Exit.FINE


def _run(suite: "Suite", options: argparse.Namespace, terminal: Terminal) -> "SuiteReport":
    """Run the cells.

    Raises:
        ArgumentError, ControllerError: the driver names nothing.
    """
    from cortex_dsl.api.contenders import ON_FILES, side_of
    from cortex_dsl.api.limits import budget_of
    from cortex_dsl.api.suite_cells import RUNS, SuitePlan
    from cortex_dsl.api.suites import run_plan
    from cortex_dsl.report.gates.suite_workbook import template_of
    from cortex_dsl.report.terminal.diagnostics_view import print_diagnostics
    from cortex_dsl.report.terminal.gate_view import GateProgress
    from engine.search.store import new_directory

    side = side_of(options.ego, None, options.ego_batch, options.ego_observes, _driver_words(options))
    if side.kind not in ON_FILES:
        raise UsageError(
            f"`{options.ego}` is a {side.kind} and no driver", "name python:..., process:..., or a behavior"
        )
    check_output(options.junit)
    if options.workbook is not None:
        template_of(options.workbook)  # before any cell is run
    if options.out is not None:
        new_directory(options.out)
    plan = SuitePlan(
        side=side,
        budget=options.budget or budget_of(RUNS),
        seed=options.seed or 0,
        jobs=options.jobs,
        folder=options.out,
    )
    if not options.json:
        terminal.out.print(f"{suite.edition}\n", style="quiet", soft_wrap=True)
    with GateProgress(terminal.err, len(suite.groups), "group") as progress:

        def on_group(group: "GroupResult") -> None:
            progress.file_done(group.runs)
            if group.source is not None:
                with progress.paused():
                    print_diagnostics(group.source, group.diagnostics, terminal.err)

        prepare = compiling(progress, terminal)
        return run_plan(suite, plan, on_group, progress.on_runs, prepare, _command(options))


def _driver_words(options: argparse.Namespace) -> list[str]:
    """Return the words of the settings of the driver that are not usual."""
    return driver_words(None, options.ego_batch, options.ego_observes)


def _command(options: argparse.Namespace) -> list[str]:
    """Return the words of the command that gives the same results."""
    words = ["cortexc", "suite", options.suite, "--ego", options.ego, *_driver_words(options)]
    words += [word for pattern in options.only for word in ("--only", pattern)]
    given = {"--budget": options.budget and options.budget.text, "--seed": options.seed or None}
    return [*words, *(word for flag, value in given.items() if value is not None for word in (flag, f"{value}"))]


def _write(report: "SuiteReport", options: argparse.Namespace, started: float) -> None:
    from cortex_dsl.report.documents import document
    from cortex_dsl.report.findings.suite_report import suite_content, suite_rows
    from cortex_dsl.report.gates.suite_junit import suite_junit_text
    from cortex_dsl.report.gates.suite_workbook import filled, template_of
    from cortex_dsl.report.page.suite_page import suite_page

    if options.junit is not None:
        write_output(options.junit, suite_junit_text(report))
    if options.out is None:
        return
    table = io.StringIO()
    csv.writer(table, lineterminator="\n").writerows(suite_rows(report))
    files = {
        PAGE: suite_page(report).encode(),
        DOCUMENT: f"{document('suite', suite_content(report))}\n".encode(),
        TABLE: table.getvalue().encode(),
        **effort_file(started),
    }
    for group in report.groups:
        files |= group.files
    for name, content in files.items():
        path: Path = options.out / name
        place_files(path.parent, {path.name: content}, force=True)
    workbook: Path | None = options.workbook
    if workbook is not None:
        place_files(options.out, {workbook.name: filled(template_of(workbook), report)}, force=True)


def _show_end(report: "SuiteReport", options: argparse.Namespace, terminal: Terminal) -> None:
    from cortex_dsl.report.findings.suite_report import suite_content
    from cortex_dsl.report.views.suite import suite_view

    if options.json:
        content = suite_content(report)
        terminal.diagnostics.extend(each for group in content["groups"] for each in group["diagnostics"])
        terminal.document("suite", content)
        return
    print_results(suite_view(report), options.out, terminal)


def _exit_code(report: "SuiteReport") -> Exit:
    applies = {
        Exit.USAGE: any(group.refusal for group in report.groups),
        Exit.DIAGNOSTICS: any(group.error is not None for group in report.groups),
        Exit.BROKEN_LIMIT: report.has_failure,
        Exit.NO_SCENE: not report.has_verdicts,
    }
    return judged_exit(applies, interrupted=bool(report.not_done))


_MISSING = ("no suite given", "`cortexc suite list` lists them")
SUITE = Command(
    name="suite",
    usage="NAME --ego DRIVER [--only PATTERN] [--out DIR] [options]",
    description=DESCRIPTION,
    options=(
        Option("suite", "name of a suite, a folder with a copy of one, or `list`", "NAME", nargs="?", missing=_MISSING),
        replace(EGO, help="the driver under test", collect=None),
        *(replace(row, needs=()) for row in DRIVER[1:]),
        Option("--only", "cells or groups that match; may be repeated", "PATTERN", default=(), collect=_appended),
        Option("--budget", "runs of each cell, or time for all: 2000, 90s (200)", "N", read_by("budget_of")),
        replace(SEED, type=whole_number(0, 9_000_000_000)),
        replace(JOBS, help="processes; results never depend on it"),
        Option("--out", "new folder: page, JSON, cells.csv, kept cases", "DIR", Path),
        Option("--junit", "write JUnit XML", "FILE", Path),
        Option("--workbook", "fill a template of Euro NCAP's calculator, in --out", "FILE", Path, needs=("out",)),
        Option("--copy", "write the files of the suite into a folder", "FOLDER", Path),
    ),
    function=_suite,
    epilog=EPILOG,
)
