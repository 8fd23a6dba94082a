"""`cortexc report RUN`: a run or a study as one HTML file, and a run's figures for a paper."""

import argparse
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from cortex_dsl.console.command import Parser, add_common, add_run, command_parser
from cortex_dsl.console.request import whole_number
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from cortex_dsl.console.user_files import reason
from engine.search.store import example_run

if TYPE_CHECKING:
    from cortex_dsl.api.runs import OpenedRun

PAGE = "report.html"
"""The page's name inside the run directory."""
MOST_CASES = 50
DESCRIPTION = """\
Write a run as one HTML file that needs no network: summary, course, where it
fails, and the worst cases, each with a replay. A study: its verdict, box plots,
curves and tests."""


def main(arguments: Sequence[str], terminal: Terminal) -> int:
    options = _parser().parse_args(arguments)
    if options.help:
        terminal.write(_parser().format_help())
        return Exit.FINE
    if options.run is None:
        raise UsageError("which run? name its folder", f"cortexc report {example_run()}")
    if _is_study(options.run):
        return _study(options, terminal)
    from cortex_dsl.cli.search_output import told_run

    run = told_run(options.run, terminal)
    path = options.out or run.folder / PAGE
    write(path, _page(run, options.cases))
    terminal.write(str(path))
    if options.figures is not None:
        from cortex_dsl.report.page.paper_figures import write_figures

        for figure in _figures(options.figures, partial(write_figures, run)):
            terminal.write(str(figure))
    if options.open:
        _open(path, terminal)
    return Exit.FINE


def _is_study(folder: Path) -> bool:
    from engine.study.database import is_study

    return is_study(folder)


def _study(options: argparse.Namespace, terminal: Terminal) -> int:
    """The page of a whole study."""
    from cortex_dsl.report.page.study_page import study_page
    from engine.search.store import StoreError
    from engine.study.database import read_study

    try:
        study = read_study(options.run)
    except StoreError as error:
        raise UsageError(error.message, error.cure) from error
    path = options.out or options.run / PAGE
    write(path, study_page(study))
    terminal.write(str(path))
    if options.figures is not None:
        from cortex_dsl.report.page.paper_figures import write_study_figures

        for figure in _figures(options.figures, partial(write_study_figures, study)):
            terminal.write(str(figure))
    if options.open:
        _open(path, terminal)
    return Exit.FINE


def open_run(folder: Path) -> "OpenedRun":
    """A run, with what may be wrong with it as a slip of the user's.

    Raises:
        UsageError: there is no readable run.
    """
    from cortex_dsl.api import runs
    from engine.search.store import StoreError

    try:
        return runs.open_run(folder)
    except StoreError as error:
        raise UsageError(error.message, error.cure) from error


def write(path: Path, content: str | bytes) -> None:
    """Write a file that the user named.

    Raises:
        UsageError: it cannot be written.
    """
    data = content.encode("utf-8") if isinstance(content, str) else content
    try:
        path.write_bytes(data)
    except OSError as error:
        cure = "name another place with --out FILE.html" if path.name == PAGE else ""
        raise UsageError(f"cannot write `{path}`: {reason(error)}", cure) from None


def _page(run: "OpenedRun", cases: int) -> str:
    from cortex_dsl.cli.search_output import usage_errors
    from cortex_dsl.report.page.run_page import run_page

    with usage_errors():
        return run_page(run, cases)


def _figures(folder: Path, written: Callable[[Path], Sequence[Path]]) -> Sequence[Path]:
    """What a function writes into a folder, which is made where there is none."""
    from engine.extras import MissingExtraError

    try:
        folder.mkdir(parents=True, exist_ok=True)
        return written(folder)
    except MissingExtraError as error:
        raise UsageError(error.message, error.cure) from None
    except OSError as error:
        raise UsageError(f"cannot write into `{folder}`: {reason(error)}") from None


def _open(path: Path, terminal: Terminal) -> None:
    import webbrowser

    if not webbrowser.open(path.resolve().as_uri()):
        terminal.complain("no browser could be started", f"open {path} in one")


def _parser() -> Parser:
    parser = command_parser("report", "RUN|STUDY [--out FILE.html] [--cases N] [options]", DESCRIPTION)
    add_run(parser, f"folder of a run or a study, such as {example_run()}")
    parser.add_argument("--out", type=Path, metavar="FILE", help=f"the page; by default {PAGE} in the run's folder")
    parser.add_argument(
        "--cases", type=whole_number(0, MOST_CASES), default=10, metavar="N", help="cases with a replay (10)"
    )
    parser.add_argument("--figures", type=Path, metavar="DIR", help="figures for papers, as SVG, PNG and PDF, into DIR")
    parser.add_argument("--open", action="store_true", help="show the page in a browser")
    add_common(parser, json=False)
    return parser
