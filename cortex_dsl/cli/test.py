"""`cortexc test PATHS`: run scenario files and fail if a stated limit is broken, for continuous integration."""

import argparse
import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cortex_dsl.cli.judging import check_output, command_of, compiling, judged_exit, read_by, usage_errors
from cortex_dsl.console.command import DRIVER, JOBS, SEED, Command, Option, driver_words
from cortex_dsl.console.request import whole_number
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from cortex_dsl.console.user_files import write_output

if TYPE_CHECKING:
    from cortex_dsl.api.baseline import Baseline
    from cortex_dsl.api.file_check import GatePlan
    from cortex_dsl.report.findings.gate_report import FileResult, GateReport

DESCRIPTION = """\
Run scenario files and decide whether their limits are kept: each `expect` of a
file, or contacts of the ego if it has none, and the limits given here. A file
that leaves nothing to chance, such as the worst cases of a search, is run once."""
EPILOG = """\
examples:
  cortexc test scenarios --junit results.xml
  cortexc test runs/night/worst --bound "delta_v <= 10 km/h" --allow-collisions
  cortexc test a.scn --max-probability 1% --of "no contact" --budget 5000
  cortexc test scenarios --baseline known.toml --update-baseline

exit codes, the gravest of those that apply:
  70  a bug in cortexc
  2   a wrong command line, a path that cannot be used, or no driver for a file
  1   a file has errors
  4   a limit is broken, or a probability is undecided
  3   a file has no valid scene
  0   all limits are kept"""
SUMMARY_VARIABLE = "GITHUB_STEP_SUMMARY"
"""Variable of the environment with the file to which `--format github` appends."""


def _appended(earlier: tuple[Any, ...] | None, value: Any) -> tuple[Any, ...]:
    return (*(earlier or ()), value)


def _test(options: argparse.Namespace, terminal: Terminal) -> int:
    from cortex_dsl.api.baseline import compared, read_baseline, updated
    from cortex_dsl.api.scenario_files import scenario_files

    with usage_errors():
        files = scenario_files(options.paths, options.exclude)
        for path in (options.junit, options.summary, options.baseline if options.update_baseline else None):
            check_output(path)
        earlier = None
        if options.baseline is not None:
            earlier = read_baseline(options.baseline, may_be_missing=options.update_baseline)
        plan = _plan(options)
        report = _run(files, plan, earlier, options, terminal)
    report = replace(report, strict=options.strict_baseline, command=_command(options))
    if earlier is not None and options.update_baseline:
        new = updated(report, earlier)
        report = compared(replace(report, remarks=()), replace(new, remarks=earlier.remarks))
        _write_baseline(new)
        report = replace(report, remarks=(*report.remarks, f"wrote {options.baseline}"))
    _show_end(report, options, terminal)
    _write_files(report, options)
    return _exit_code(report)


def _command(options: argparse.Namespace) -> str:
    """Return the command that gives the same results, with sorted paths, as their order changes nothing."""
    rest = [word for word in options.command_line if Path(word) not in options.paths]
    return command_of("test", [*sorted(map(str, options.paths)), *rest])


def _plan(options: argparse.Namespace) -> "GatePlan":
    from cortex_dsl.api.file_check import GatePlan
    from cortex_dsl.api.limits import BUDGET, budget_of
    from engine.driving.named import driver_of

    if options.of == "":
        raise UsageError("--of has no name", "name an `expect`, or leave it out for contacts of the ego")
    return GatePlan(
        budget=options.budget or budget_of(BUDGET),
        seed=options.seed or 0,
        allow_collisions=options.allow_collisions,
        bounds=options.bound,
        max_probability=options.max_probability,
        of=options.of,
        undecided_passes=options.undecided == "pass",
        driver=driver_of(options.ego, options.ego_batch, options.ego_observes),
        replay=tuple(driver_words(options.ego, options.ego_batch, options.ego_observes)),
        jobs=options.jobs,
    )


def _run(
    files: Sequence[Any],
    plan: "GatePlan",
    baseline: "Baseline | None",
    options: argparse.Namespace,
    terminal: Terminal,
) -> "GateReport":
    """Run the files and show each when it is done."""
    from cortex_dsl.api.baseline import compared, compared_file, updated
    from cortex_dsl.api.testing import run_plan
    from cortex_dsl.report.findings.gate_report import GateReport
    from cortex_dsl.report.terminal.gate_view import GateProgress

    with GateProgress(terminal.err, len(files)) as progress:

        def on_file(file: "FileResult") -> None:
            progress.file_done(file.runs)
            if baseline is not None:
                now = updated(GateReport((file,)), baseline) if options.update_baseline else baseline
                file = compared_file(file, now)
            if not options.json:
                with progress.paused():
                    _show_file(file, terminal)

        report = run_plan(files, plan, on_file, progress.on_runs, compiling(progress, terminal))
    return report if baseline is None else compared(report, baseline)


# -- output ------------------------------------------------------------------------------------------------------------


def _show_file(file: "FileResult", terminal: Terminal) -> None:
    from cortex_dsl.report.terminal.diagnostics_view import print_diagnostics
    from cortex_dsl.report.terminal.gate_view import file_view

    terminal.out.print(file_view(file, terminal.out.width))
    if file.source is not None:
        print_diagnostics(file.source, file.diagnostics, terminal.err)


def _show_end(report: "GateReport", options: argparse.Namespace, terminal: Terminal) -> None:
    from cortex_dsl.report.findings.gate_report import gate_content
    from cortex_dsl.report.gates.github import gate_annotations
    from cortex_dsl.report.terminal.gate_view import end_view

    if options.json:
        content = gate_content(report)
        terminal.diagnostics.extend(each for file in content["files"] for each in file["diagnostics"])
        terminal.document("test", content)
        return
    if options.format == "github":
        for line in gate_annotations(report):
            terminal.write(line)
    terminal.out.print(end_view(report))


def _write_files(report: "GateReport", options: argparse.Namespace) -> None:
    from cortex_dsl.report.gates.junit import junit_text
    from cortex_dsl.report.gates.markdown import markdown_text

    if options.junit is not None:
        write_output(options.junit, junit_text(report))
    if options.summary is not None:
        write_output(options.summary, markdown_text(report))
    if options.format == "github" and (name := os.environ.get(SUMMARY_VARIABLE)):
        _append_summary(Path(name), report)


def _append_summary(path: Path, report: "GateReport") -> None:
    """Append the summary to the file of a step, whose size GitHub limits.

    Raises:
        UsageError: the file cannot be written.
    """
    from cortex_dsl.console.user_files import reason
    from cortex_dsl.report.gates.markdown import LARGEST, markdown_text

    try:
        there = path.stat().st_size if path.exists() else 0
        with path.open("a", encoding="utf-8") as file:
            file.write(markdown_text(report, LARGEST - there))
    except OSError as error:
        raise UsageError(f"cannot write `{path}`, which {SUMMARY_VARIABLE} names: {reason(error)}") from None


def _write_baseline(baseline: "Baseline") -> None:
    from cortex_dsl.api.baseline import baseline_text

    write_output(baseline.path, baseline_text(baseline.entries))


def _exit_code(report: "GateReport") -> Exit:
    applies = {
        Exit.USAGE: report.lacks_driver,
        Exit.DIAGNOSTICS: report.has_file_errors,
        Exit.BROKEN_LIMIT: report.has_broken_limit,
        Exit.NO_SCENE: report.lacks_scene,
    }
    return judged_exit(applies, interrupted=bool(report.not_run))


# -- the command -------------------------------------------------------------------------------------------------------

_LIMITS, _OUTPUT = "limits", "output"
TEST = Command(
    name="test",
    usage="PATHS [--budget N] [--bound LIMIT] [options]",
    description=DESCRIPTION,
    options=(
        Option(
            "paths",
            "scenarios, and folders of them",
            "PATHS",
            Path,
            nargs="*",
            missing=("no paths given", "name files or folders, such as `cortexc test scenarios`"),
        ),
        Option("--exclude", "leave out files that match; may be repeated", "GLOB", default=(), collect=_appended),
        Option("--budget", "runs of each file, or time for all: 2000, 90s (200)", "N", read_by("budget_of")),
        replace(SEED, type=whole_number(0, 9_000_000_000)),
        replace(JOBS, help="processes; results never depend on it"),
        *DRIVER,
        Option(
            "--bound",
            'limit of a result, as in "delta_v <= 10 km/h"; may be repeated',
            "LIMIT",
            read_by("bound_of"),
            default=(),
            collect=_appended,
            group=_LIMITS,
        ),
        Option(
            "--max-probability",
            "largest probability of a failure, decided at 95 %% by --budget runs",
            "P",
            read_by("probability_of"),
            group=_LIMITS,
        ),
        Option(
            "--of",
            "the `expect` that --max-probability limits (contact of the ego)",
            "NAME",
            needs=("max_probability",),
            group=_LIMITS,
        ),
        Option(
            "--undecided",
            "outcome if the runs do not decide it: fail or pass",
            "HOW",
            choices=("fail", "pass"),
            default="fail",
            needs=("max_probability",),
            group=_LIMITS,
        ),
        Option("--allow-collisions", "a file without `expect` may have contacts", default=False, group=_LIMITS),
        Option("--baseline", "known failures (TOML), which do not fail", "FILE", Path, group=_LIMITS),
        Option(
            "--strict-baseline",
            "fail if a known failure no longer occurs",
            default=False,
            needs=("baseline",),
            group=_LIMITS,
        ),
        Option(
            "--update-baseline",
            "write the failures of this test to the baseline",
            default=False,
            needs=("baseline",),
            group=_LIMITS,
        ),
        Option("--junit", "write JUnit XML", "FILE", Path, group=_OUTPUT),
        Option("--summary", "write a table in Markdown", "FILE", Path, group=_OUTPUT),
        Option(
            "--format",
            "text, or github: with annotations and a summary of the step",
            "NAME",
            choices=("text", "github"),
            default="text",
            excludes=("json",),
            group=_OUTPUT,
        ),
    ),
    function=_test,
    epilog=EPILOG,
)
