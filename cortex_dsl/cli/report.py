"""`cortexc report RUN`: a run or a study as one HTML file, and its figures for a paper."""

import argparse
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from cortex_dsl.api.derived_files import PAGE
from cortex_dsl.console.command import EGO, EXAMPLE_RUN, Command, Condition, Option, run_of
from cortex_dsl.console.request import whole_number
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from cortex_dsl.console.user_files import check_writable, reason, write_output
from engine.search.store import StoreError
from engine.study.database import is_study

if TYPE_CHECKING:
    from cortex_dsl.api.runs import OpenedRun
    from engine.study.database import Study

MOST_CASES = 50

Figures = Callable[[Path], Sequence[Path]]
"""Writes figures into a folder, and returns their paths."""


def _report(options: argparse.Namespace, terminal: Terminal) -> Exit:
    path = options.out or options.run / PAGE
    cure = "name another place with --out FILE.html" if path.name == PAGE else ""
    check_writable(path, cure)
    page, figures = (_study_page if is_study(options.run) else _run_page)(options, terminal)
    write_output(path, page, cure)
    terminal.write(str(path))
    if options.figures is not None:
        for figure in _written(options.figures, figures):
            terminal.write(str(figure))
    if options.open:
        _open(path, terminal)
    return Exit.FINE


def _run_page(options: argparse.Namespace, terminal: Terminal) -> tuple[str, Figures]:
    """Return the page of a run, and the function that draws its figures."""
    from cortex_dsl.api.restoring import restore
    from cortex_dsl.api.runs import reread
    from cortex_dsl.cli.search_output import checked_run, usage_errors
    from cortex_dsl.report.page.run_page import run_page

    run = checked_run(options.run, terminal, options.ego)
    try:
        if names := restore(run, tables=options.tables):
            _note_written(names, "journal", terminal)
            run = reread(run)
    except StoreError as error:  # a page of a run that cannot be written is still a page
        terminal.note(f"{error.message}; {error.cure}")
    with usage_errors():
        return run_page(run, options.cases), partial(_run_figures, run)


def _study_page(options: argparse.Namespace, terminal: Terminal) -> tuple[str, Figures]:
    """Return the page of a study, and the function that draws its figures."""
    from cortex_dsl.api.restoring import restore_study
    from cortex_dsl.cli.search_output import usage_errors
    from cortex_dsl.report.page.study_page import study_page
    from engine.study.database import read_study
    from engine.study.verdict import findings

    with usage_errors():
        study = read_study(options.run)
    found = findings(study.plan, study.records)
    try:
        _note_written(restore_study(study, found), "study", terminal)
    except StoreError as error:
        terminal.note(f"{error.message}; {error.cure}")
    return study_page(study, found), partial(_study_figures, study)


def _note_written(names: Collection[str], source: str, terminal: Terminal) -> None:
    if names:
        terminal.note(f"written again from the {source}: {', '.join(names)}")


def _run_figures(run: "OpenedRun", folder: Path) -> Sequence[Path]:
    from cortex_dsl.report.page.paper_figures import write_figures

    return write_figures(run, folder)


def _study_figures(study: "Study", folder: Path) -> Sequence[Path]:
    from cortex_dsl.report.page.paper_figures import write_study_figures

    return write_study_figures(study, folder)


def _written(folder: Path, figures: Figures) -> Sequence[Path]:
    """The figures in a folder, which is made where there is none."""
    from engine.extras import MissingExtraError

    try:
        folder.mkdir(parents=True, exist_ok=True)
        return figures(folder)
    except MissingExtraError as error:
        raise UsageError(error.message, error.cure) from None
    except OSError as error:
        raise UsageError(f"cannot write into `{folder}`: {reason(error)}") from None


def _open(path: Path, terminal: Terminal) -> None:
    import webbrowser

    if not webbrowser.open(path.resolve().as_uri()):
        terminal.complain("no browser could be started", f"open {path} in one")


_STUDY = Condition("a study, which always has its tables", lambda options: is_study(options.run))

REPORT = Command(
    name="report",
    usage="RUN|STUDY [--out FILE.html] [--tables] [options]",
    description="""\
Write a report of a run as one HTML file that needs no network: summary, course
of the search, where in the space of params it found failures, and the worst
cases, each with a replay. For a study: verdict, box plots, curves and tests.""",
    options=(
        replace(
            run_of("report"),
            help=f"folder of a run or a study, such as {EXAMPLE_RUN}",
            missing=("which run? name its folder", f"cortexc report {EXAMPLE_RUN}"),
        ),
        Option("--out", f"the page; by default {PAGE} in the run's folder", "FILE", Path),
        Option("--cases", "cases with a replay", "N", whole_number(0, MOST_CASES), default=10),
        Option("--figures", "figures for papers, as SVG, PNG and PDF, into DIR", "DIR", Path),
        Option("--tables", "write the CSV and JSON lines of a large search beside its journal", excludes=(_STUDY,)),
        EGO,
        Option("--open", "show the page in a browser"),
    ),
    function=_report,
    json=False,
)
