"""`cortexc report RUN`: a run or a study as one HTML file, its figures for a paper, or one sheet for an auditor."""

import argparse
import shlex
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from cortex_dsl.api.derived_files import AUDIT, AUDIT_PAGE, PAGE
from cortex_dsl.console.command import EGO, EXAMPLE_RUN, Command, Condition, Option, driver_words, run_of
from cortex_dsl.console.request import whole_number
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from cortex_dsl.console.user_files import check_writable, reason, write_output
from engine.search.store import JOURNAL, StoreError
from engine.study.database import is_study

if TYPE_CHECKING:
    from cortex_dsl.api.runs import OpenedRun
    from cortex_dsl.report.findings.audit_report import AuditReport
    from engine.study.database import Study

MOST_CASES = 50

Figures = Callable[[Path], Sequence[Path]]
"""Writes figures into a folder, and returns their paths."""


def _report(options: argparse.Namespace, terminal: Terminal) -> Exit:
    if options.audit:
        return _audit(options, terminal)
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


# -- the sheet for an auditor ------------------------------------------------------------------------------------------


def _audit(options: argparse.Namespace, terminal: Terminal) -> Exit:
    """Write the sheet, its document, and the tables of its numbers."""
    from cortex_dsl.report.documents import document
    from cortex_dsl.report.findings.audit_report import audit_content, with_prefix
    from cortex_dsl.report.page.audit_page import audit_page
    from engine.checksums import stamp, with_checksum

    folder: Path = options.run if options.run.is_dir() else options.run.parent
    path: Path = options.out or folder / AUDIT_PAGE
    if path.suffix.lower() not in (".html", ".htm"):
        raise UsageError(f"--out `{path}` is no page: its document and tables lie beside it", "name it FILE.html")
    check_writable(path, "name another place with --out FILE.html" if options.out is None else "")
    report = _audit_report(options, terminal)
    name = AUDIT
    if options.out is not None:
        report, name = with_prefix(report, path.stem), f"{path.stem}-{AUDIT}"
    text = document("audit", {**stamp(report.journal), **audit_content(report)})
    files = {path.name: audit_page(report, name).encode(), **report.tables, name: with_checksum(f"{text}\n")}
    evidence = {folder / each for each in report.evidence if each not in report.tables}
    evidence |= {each for each in (options.run, options.exposure) if each is not None}
    _refuse_replacing(evidence, [path.parent / each for each in files])
    for name, content in files.items():
        write_output(path.parent / name, content)
        terminal.write(str(path.parent / name))
    if options.open:
        _open(path, terminal)
    return Exit.FINE


def _refuse_replacing(evidence: Collection[Path], targets: Sequence[Path]) -> None:
    """Raise UsageError if a file of a sheet would replace one from which its numbers come."""
    known = {each.resolve() for each in evidence}
    for target in targets:
        if target.resolve() in known:
            what = f"the sheet would replace `{target}`, from which its numbers come"
            raise UsageError(what, "name another place with --out FILE.html")


def _audit_report(options: argparse.Namespace, terminal: Terminal) -> "AuditReport":
    """Return the sheet of a search, of the results of a command, or of a document.

    Raises:
        UsageError: there is none of these, or the exposure does not fit.
    """
    from cortex_dsl.api.audit import audit_of_run
    from cortex_dsl.api.audit_documents import audit_of_document, document_in
    from cortex_dsl.api.exposure import read_exposure
    from cortex_dsl.cli.judging import usage_errors
    from cortex_dsl.cli.search_output import checked_run
    from cortex_dsl.console.kernels import SEARCH, compile_kernels

    if is_study(options.run):
        raise UsageError(f"`{options.run}` is a study, which compares methods and no driver", "name a search")
    with usage_errors():
        exposure = None if options.exposure is None else read_exposure(options.exposure)
        command = _again(options)
        is_other = options.run.is_file() and options.run.name != JOURNAL
        found = document_in(options.run) if is_other or options.run.is_dir() else None
        if found is not None:
            if options.ego is not None:
                raise UsageError("--ego has no effect on results that are not driven again", "leave it out")
            return audit_of_document(found, exposure, command)
        if options.run.is_dir() and not (options.run / JOURNAL).exists():
            _refuse_other(options.run)
        run = checked_run(options.run, terminal, options.ego)
        compile_kernels(terminal, SEARCH, run.scenario.program, run.scenario.config)
        return audit_of_run(run, exposure, command)


def _refuse_other(folder: Path) -> None:
    """Raise UsageError for a folder that holds neither a search nor results, unless it holds searches."""
    if any(folder.glob(f"*/{JOURNAL}")):
        return  # the reader of runs names them
    what = f"`{folder}` holds no search, and no results of suite, compare or coverage"
    if not any(folder.iterdir()):
        raise UsageError(f"{what}: it is empty", "a command that was killed leaves such a folder: run it again")
    raise UsageError(what, "name the folder of a search, or that of `--out`")


def _again(options: argparse.Namespace) -> str:
    """Return the command that writes the sheet again, without the folders of this computer."""
    from engine.search.store import without_folders

    words = ["cortexc", "report", without_folders(str(options.run)), "--audit"]
    words += [] if options.exposure is None else ["--exposure", without_folders(str(options.exposure))]
    words += [] if options.out is None else ["--out", without_folders(str(options.out))]
    return shlex.join([*words, *driver_words(options.ego, None, None)])


_STUDY = Condition("a study, which always has its tables", lambda options: is_study(options.run))

REPORT = Command(
    name="report",
    usage="RUN|STUDY [--out FILE.html] [--tables] [options]\nRUN|RESULTS --audit [--exposure FILE] [--out FILE.html]",
    description="""\
Write a report of a run as one HTML file that needs no network: summary, course
of the search, where in the space of params it found failures, and the worst
cases, each with a replay. For a study: verdict, box plots, curves and tests.

With --audit, write one sheet of A4 for an auditor, and the same as JSON beside
it: failures by domain cell with exact bounds, probabilities, reference drivers,
what was not run and why. Each number names the command, digest, seed, version
and table from which it comes. RESULTS is the folder of `cortexc suite --out`,
`compare --out` or `coverage --out`, or the document of `cortexc test --json`.""",
    options=(
        replace(
            run_of("report"),
            help=f"folder of a run or a study, such as {EXAMPLE_RUN}",
            missing=("which run? name its folder", f"cortexc report {EXAMPLE_RUN}"),
        ),
        Option("--out", f"the page; by default {PAGE} in the run's folder", "FILE", Path),
        Option("--cases", "cases with a replay", "N", whole_number(0, MOST_CASES), default=10, excludes=("audit",)),
        Option("--figures", "figures for papers, as SVG, PNG and PDF, into DIR", "DIR", Path, excludes=("audit",)),
        Option(
            "--tables", "write the CSV and JSON lines of a large search beside its journal", excludes=(_STUDY, "audit")
        ),
        Option("--audit", f"one sheet for an auditor, {AUDIT_PAGE} and {AUDIT}"),
        Option(
            "--exposure",
            "CSV with a weight for each cell: its coordinates, then `weight`",
            "FILE",
            Path,
            needs=("audit",),
        ),
        EGO,
        Option("--open", "show the page in a browser"),
    ),
    function=_report,
    json=False,
)
