"""`cortexc measure FILE --all`: every pair of a recording, the worst first."""

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING

from cortex_dsl.console.command import Parser, typed_again
from cortex_dsl.console.request import whole_number
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from cortex_dsl.console.user_files import Asked, place_files
from cortex_dsl.interchange.formats import SCENARIO

if TYPE_CHECKING:
    from cortex_dsl.report.findings.ranking_report import RankedReport
    from engine.interchange.tables.track import Tracks

NEAREST, FARTHEST = 1.0, 1000.0
ASKED = Asked("--table or --page", "--force")
OF_ALL = ("near", "top", "table", "page")
NOT_OF_ALL = ("ego", "to", "window")


def options_of_all(parser: Parser, *, offered: bool) -> None:
    """Add what `--all` takes, to a command that offers it."""
    if not offered:
        parser.set_defaults(all=False, **dict.fromkeys(OF_ALL))
        return
    parser.add_argument(
        "--all", action="store_true", help="judge every pair of actors that comes near each other, the worst first"
    )
    parser.add_argument(
        "--near", type=_meters, metavar="M", help="with --all: the largest distance of a pair to judge (50 m)"
    )
    parser.add_argument(
        "--top", type=whole_number(1, 100_000), metavar="N", help="with --all: number of rows to show (20)"
    )
    parser.add_argument("--table", type=Path, metavar="CSV", help="with --all: write every row into a table")
    parser.add_argument("--page", type=Path, metavar="HTML", help="with --all: write a page with drawings")


def _meters(text: str) -> float:
    try:
        value = float(text.removesuffix("m"))
    except ValueError:
        raise argparse.ArgumentTypeError(f"must be a number of metres, not `{text}`") from None
    if not NEAREST <= value <= FARTHEST:
        raise argparse.ArgumentTypeError(f"must lie between {NEAREST:g} and {FARTHEST:g} m, not {text}")
    return value


def check_options(options: argparse.Namespace) -> None:
    """Raises UsageError where an option has no effect."""
    for name in NOT_OF_ALL if options.all else OF_ALL:
        if getattr(options, name) is not None:
            where = "beside --all, which has no ego" if options.all else "without --all"
            raise UsageError(
                f"--{name} has no effect {where}", f"leave --{name} out" + ("" if options.all else ", or add --all")
            )
    _check_files(options)


def _check_files(options: argparse.Namespace) -> None:
    if options.table is not None and options.table == options.page:
        raise UsageError(f"--table and --page are both `{options.table}`", "name two files")


def rank(options: argparse.Namespace, terminal: Terminal) -> Exit:
    """Read, judge, write what was asked for, show.

    Raises:
        InterchangeError: it cannot be read, or is too much.
        UsageError: a file stands in the way, or cannot be written.
    """
    from cortex_dsl.console.kernels import PAIRS, compile_kernels
    from cortex_dsl.report.findings.ranking_report import RankedReport
    from engine.interchange.every_pair import NEAR, rank_pairs
    from engine.interchange.sources import read_traffic

    tracks = read_traffic(options.file, options.rate, esmini_of(options), dict(options.columns))
    compile_kernels(terminal, PAIRS)
    near = NEAR if options.near is None else options.near
    ranked = rank_pairs(tracks, near=near, step=options.step, profile=options.profile)
    top = 20 if options.top is None else options.top
    written = tuple(str(path) for path in (options.table, options.page) if path is not None)
    again = typed_again("measure", options.words)
    report = RankedReport(str(options.file), ranked, near, options.profile, top, ranked.remarks, again, written)
    _write(report, tracks, options)
    _show(report, options, terminal)
    return Exit.FINE


def esmini_of(options: argparse.Namespace) -> Path | None:
    """The library of esmini for an `.xosc` that has to be played; None where nobody names one.

    Raises:
        UsageError: it is not there, or nothing could be played.
    """
    from engine.interchange.contract import InterchangeError
    from engine.interchange.esmini import VARIABLE, esmini_library

    plays = options.file.suffix.lower() == SCENARIO
    if options.esmini is not None and not plays:
        raise UsageError("--esmini has no effect on a file that is no .xosc", "leave --esmini out")
    if options.esmini is None and not (plays and os.environ.get(VARIABLE)):
        return None
    try:
        return esmini_library(options.esmini)
    except InterchangeError as error:
        raise UsageError(error.message, error.cure) from None


def _write(report: "RankedReport", tracks: "Tracks", options: argparse.Namespace) -> None:
    """Both files, once both are made; what stands in the way of either is said before one is written."""
    files: dict[Path, bytes] = {}
    if options.table is not None:
        from cortex_dsl.report.findings.ranking_report import ranking_csv

        files[options.table] = ranking_csv(report.ranked).encode()
    if options.page is not None:
        from cortex_dsl.report.page.ranking_page import ranking_page

        files[options.page] = ranking_page(report, tracks).encode()
    for path in sorted(files, key=os.path.lexists, reverse=True):
        place_files(path.parent, {path.name: files[path]}, force=options.force, asked=ASKED)


def _show(report: "RankedReport", options: argparse.Namespace, terminal: Terminal) -> None:
    if options.json:
        from cortex_dsl.report.findings.ranking_report import ranking_content

        terminal.document("ranking", ranking_content(report))
    else:
        from cortex_dsl.report.terminal.ranking_view import ranking_view

        terminal.out.print(ranking_view(report))
