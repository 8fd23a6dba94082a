"""`cortexc compare A B FILES`: two drivers, versions or searches on equal scenes."""

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from cortex_dsl.cli.judging import (
    compiling,
    cpu_seconds,
    effort_file,
    judged_exit,
    print_results,
    read_by,
    usage_errors,
)
from cortex_dsl.console.command import DRIVER, EGO, JOBS, SEED, Command, Option, driver_words, excluded_by
from cortex_dsl.console.request import SEED_LIMIT, whole_number
from cortex_dsl.console.terminal import Exit, Terminal

if TYPE_CHECKING:
    from cortex_dsl.api.comparing import ComparisonPlan
    from cortex_dsl.report.findings.comparison_report import ComparisonReport, FileComparison

DESCRIPTION = """\
Is B worse than A? Both drive the same scenes. A and B are two drivers on FILES
(python:..., process:..., or a behavior in the place of ExternalBehavior), two
versions of a file with the same params, or the folders of two searches, whose
failures are run again with the other driver."""
EPILOG = """\
exit codes: 0 no new failure; 4 new failures, or with --max-new a probability
above P; 2 A and B cannot be compared; 1 a file has errors; 3 no valid scene"""


def _compare(options: argparse.Namespace, terminal: Terminal) -> int:
    from cortex_dsl.api.comparing import compared_files, run_comparison
    from cortex_dsl.api.comparison_cases import comparison_files, stems
    from cortex_dsl.console.user_files import place_files
    from cortex_dsl.report.terminal.gate_view import GateProgress
    from engine.search.store import new_directory

    started = cpu_seconds()
    with usage_errors():
        plan = _plan(options)
        files = compared_files(plan, options.files)
        if options.out is not None:
            new_directory(options.out)
            plan = replace(plan, stems=stems([file.path for file in files]))
        with GateProgress(terminal.err, len(files)) as progress:

            def on_file(file: "FileComparison") -> None:
                progress.file_done(file.runs)

            prepare = compiling(progress, terminal)
            report = run_comparison(files, plan, on_file, progress.on_runs, prepare)
        if options.out is not None:
            written = {**comparison_files(report, options.table), **effort_file(started)}
            for name, content in written.items():
                path: Path = options.out / name
                place_files(path.parent, {path.name: content}, force=True)
    _show(report, options, terminal)
    return _exit_code(report)


def _plan(options: argparse.Namespace) -> "ComparisonPlan":
    """Return the settings of the comparison.

    Raises:
        ArgumentError, ControllerError: a side names nothing.
    """
    from cortex_dsl.api.comparing import PAIRS, ComparisonPlan
    from cortex_dsl.api.contenders import side_of
    from cortex_dsl.api.limits import budget_of

    batch, observes = options.ego_batch, options.ego_observes
    words = tuple(driver_words(None, batch, observes))
    a, b = (
        side_of(word, ego, batch, observes, words)
        for word, ego in ((options.a, options.ego_a), (options.b, options.ego_b))
    )
    return ComparisonPlan(
        a=a,
        b=b,
        budget=options.budget or budget_of(PAIRS),
        seed=options.seed or 0,
        search=options.search,
        max_new=options.max_new,
        scene=options.scene,
        jobs=options.jobs,
        words=words,
    )


def _show(report: "ComparisonReport", options: argparse.Namespace, terminal: Terminal) -> None:
    from cortex_dsl.report.findings.comparison_report import comparison_content
    from cortex_dsl.report.terminal.diagnostics_view import print_diagnostics
    from cortex_dsl.report.views.comparison import comparison_view

    if options.json:
        content = comparison_content(report)
        terminal.diagnostics.extend(each for file in content["files"] for each in file["diagnostics"])
        terminal.document("compare", content)
        return
    for file in report.files:
        if file.source is not None:
            print_diagnostics(file.source, file.diagnostics, terminal.err)
    print_results(comparison_view(report), options.out, terminal)


def _exit_code(report: "ComparisonReport") -> Exit:
    applies = {
        Exit.USAGE: any(file.refusal for file in report.files),
        Exit.DIAGNOSTICS: any(file.error is not None for file in report.files),
        Exit.BROKEN_LIMIT: report.has_new_failures,
        Exit.NO_SCENE: any(file.no_scene for file in report.files),
    }
    return judged_exit(applies, interrupted=report.interrupted)


# -- the command -------------------------------------------------------------------------------------------------------

_MISSING = ("A and B are missing", "name two drivers and files, as in `cortexc compare A B scenarios`")
_ONE = replace(SEED, flag="--scene", help="drive the scene of one seed only", type=whole_number(0, SEED_LIMIT))
COMPARE = Command(
    name="compare",
    usage="A B [FILES] [--budget N] [--out DIR] [options]",
    description=DESCRIPTION,
    options=(
        Option("a", "a driver, a file, or the folder of a search", "A", nargs="?", missing=_MISSING),
        Option("b", "what is compared with it", "B", nargs="?", missing=_MISSING),
        Option("files", "scenarios and folders of them, for drivers", "FILES", Path, nargs="*"),
        replace(SEED, type=whole_number(0, 9_000_000_000)),
        *excluded_by(
            _ONE.dest,
            Option("--budget", "pairs on each file, or time for all: 2000, 90s (1,000)", "N", read_by("budget_of")),
            Option("--search", "scenes of a search for differences", "N", whole_number(1, 10**7), default=0),
            Option(
                "--max-new",
                "largest probability of a new failure, decided at 95 %% by --budget",
                "P",
                read_by("probability_of", "--max-new"),
            ),
        ),
        _ONE,
        replace(EGO, flag="--ego-a", help="driver of A, for files and searches"),
        replace(EGO, flag="--ego-b", help="driver of B"),
        *(replace(row, needs=()) for row in DRIVER[1:]),
        replace(JOBS, help="processes; results never depend on it"),
        Option("--out", "new folder: page, JSON, pairs, cases in new/ cured/ moved/", "DIR", Path),
        Option(
            "--table",
            "format of the pairs",
            "NAME",
            choices=("csv", "parquet"),
            default="csv",
            needs=("out",),
        ),
    ),
    function=_compare,
    epilog=EPILOG,
)
