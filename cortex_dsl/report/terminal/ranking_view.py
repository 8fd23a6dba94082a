"""Every pair of a recording at the terminal: the worst windows as a table."""

from collections.abc import Iterator
from math import isfinite

from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.findings.interchange_report import one_line
from cortex_dsl.report.findings.ranking_report import RankedReport, Window, windows
from cortex_dsl.report.findings.readable import counted, fixed
from cortex_dsl.report.terminal.interchange_view import ending
from cortex_dsl.report.terminal.theme import columns, heading, left, right, section

MOST_PAIRS = 5
"""Overlapping pairs that are named."""


def ranking_view(report: RankedReport) -> RenderableType:
    """The whole report."""
    ranked = report.ranked
    actors, found = counted(len(ranked.names), "actor"), counted(len(ranked), "window")
    parts: list[RenderableType] = [
        heading(one_line(report.file), "every pair"),
        Text(f"{actors}; {found} in which two come nearer than {report.near:g} m, judged every {ranked.step:.6g} s"),
    ]
    if len(ranked):
        parts.append(section("Worst", _table(report), f"profile {report.profile}"))
    if any(window.after_contact for window in windows(ranked, report.top)):
        parts.append(Text("  * one of the two had touched a third actor before", "quiet"))
    if ranked.overlapping:
        parts.append(section("Set aside", Text(overlapping_text(report))))
    return Group(*parts, *ending(report.remarks, report.written, report.again))


def overlapping_text(report: RankedReport) -> str:
    """Return the pairs that overlap from the start, and possible reasons."""
    pairs = report.ranked.overlapping
    named = ", ".join(f"{one} and {other}" for one, other in pairs[:MOST_PAIRS])
    more = f" and {len(pairs) - MOST_PAIRS:,} more" if len(pairs) > MOST_PAIRS else ""
    verb = "overlaps" if len(pairs) == 1 else "overlap"
    return f"{counted(len(pairs), 'pair')} {verb} from the start, and nothing led to it: {named}{more}"


def _table(report: RankedReport) -> RenderableType:
    specification = (
        right(""),
        left("pair"),
        right("window"),
        right("risk"),
        right("MD"),
        right("at"),
        right("TTC"),
        left("", wrap=True),
    )
    rows = [tuple(_cells(window)) for window in windows(report.ranked, report.top)]
    return columns(*specification, rows=rows, header=True)


def _cells(window: Window) -> Iterator[Text]:
    metrics = window.metrics
    yield Text(f"{window.rank}", "quiet")
    yield Text(" and ".join(window.actors))
    yield Text(f"{fixed(window.begin, 2)} to {fixed(window.end, 2)} s")
    yield Text(f"{window.risk}", "title")
    yield Text(
        "contact" if window.contact else f"{fixed(metrics['min_distance'], 2)} m", "bad" if window.contact else ""
    )
    yield Text(f"{fixed(metrics['min_distance_time'], 2)} s")
    yield Text(f"{fixed(window.ttc, 2)} s" if isfinite(window.ttc) else "∞")
    yield Text(", ".join(window.kinds) + (" *" if window.after_contact else ""), "quiet")
