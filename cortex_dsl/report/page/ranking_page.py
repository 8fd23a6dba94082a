"""Every pair of a recording on one page: the ranked table, and drawings of its worst windows."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cortex_dsl.report.blocks import Column, Table, Value, Words
from cortex_dsl.report.findings.ranking_report import RankedReport, Window, ranking_content, windows
from cortex_dsl.report.findings.readable import counted, fixed
from cortex_dsl.report.page.markup import Element, Node, element, page, part, top_bar
from cortex_dsl.report.page.render import nodes
from engine.interchange.tables.track import TableTrack, Tracks
from engine.strict_json import plain
from engine.tables import Floats

DRAWN = 12
"""Windows with a drawing."""
SIZE, MARGIN = 260.0, 4.0
"""Size of a drawing [px], and margin around its content [m]."""
MOST_POINTS = 200
COLORS = ("#1f77b4", "#d62728")


def ranking_page(report: RankedReport, tracks: Tracks) -> str:
    """The page as text."""
    shown = list(windows(report.ranked, report.top))
    body = [
        top_bar([("#worst", "Worst"), ("#drawings", "Drawings"), ("#remarks", "Remarks")]),
        element("main", _hero(report), _worst(report, shown), _drawings(report, shown, tracks), _remarks(report)),
    ]
    return page(f"every pair of {report.file}", body, {"ranking": plain(ranking_content(report))}, ("page.js",))


def _hero(report: RankedReport) -> Element:
    found = counted(len(report.ranked), "window")
    line = f"{found} in which two come nearer than {report.near:g} m, judged every {report.ranked.step:.6g} s"
    return element(
        "header",
        element("p", "Every pair of a recording", class_="kicker"),
        element("h1", report.file),
        element("p", f"{counted(len(report.ranked.names), 'actor')}; {line}", class_="headline"),
    )


def _worst(report: RankedReport, shown: Sequence[Window]) -> Element:
    names = "from [s]", "to [s]", "risk", "MD [m]", "at [s]", "TTC [s]", "D_MS [m]", "TTC_MS [s]"
    numbers = (Column(head, numbers=True) for head in names)
    columns = Column(numbers=True), Column("pair"), Column("kinds"), *numbers, Column()
    rows = [_row(window) for window in shown]
    note = f"profile {report.profile}; the {len(shown):,} worst of {len(report.ranked):,}"
    return part("worst", "Worst windows", note, nodes(Table(columns, rows, name="ranking")))


MEASURED = "min_distance_time", "min_ttc", "distance_at_ms", "ttc_at_ms"


def _row(window: Window) -> Sequence[Words]:
    values = {**window.metrics, "begin": window.begin, "end": window.end, "min_ttc": window.ttc}
    begin, end, least, *others = (
        Value(fixed(values[name], 2), "", values[name], name) for name in ("begin", "end", "min_distance", *MEASURED)
    )
    names = str(window.rank), " and ".join(window.actors), ", ".join(window.kinds)
    distance = replace(least, text="contact") if window.contact else least
    after = "after contact with a third actor" if window.after_contact else ""
    risk = Value(str(window.risk), "", float(window.risk), "risk")
    return *names, begin, end, risk, distance, *others, after


# -- drawings ----------------------------------------------------------------------------------------------------------


def _drawings(report: RankedReport, shown: Sequence[Window], tracks: Tracks) -> Element:
    cards = [_card(report, window, tracks) for window in shown[:DRAWN]]
    note = "paths of both in their window, outlines at the closest approach; x to the right, y up"
    return part("drawings", "Drawings", note, element("div", cards, style="display:flex;flex-wrap:wrap;gap:1rem"))


def _card(report: RankedReport, window: Window, tracks: Tracks) -> Element:
    pair = [tracks.tracks[int(actor)] for actor in report.ranked.actors[window.rank - 1]]
    at = window.metrics["min_distance_time"]
    ways = [_way(track, window) for track in pair]
    outlines = [_outline(track, at) for track in pair]
    low, high = _frame(np.concatenate(outlines))
    scale = SIZE / float(high[0] - low[0])
    shapes: list[Node] = []
    for way, outline, color in zip(ways, outlines, COLORS, strict=True):
        shapes.append(
            element("polyline", points=_points(way, low, high, scale), fill="none", stroke=color, stroke_width=1)
        )
        shapes.append(
            element("polygon", points=_points(outline, low, high, scale), fill=color, fill_opacity=0.4, stroke=color)
        )
    drawing = element(
        "svg", shapes, viewBox=f"0 0 {SIZE:g} {SIZE:g}", width=f"{SIZE:g}", height=f"{SIZE:g}", role="img"
    )
    caption = f"{window.rank}. {' and '.join(window.actors)}, {fixed(at, 2)} s, risk {window.risk}"
    return element("figure", drawing, element("figcaption", caption))


def _way(track: TableTrack, window: Window) -> Floats:
    instants = np.linspace(max(window.begin, track.time[0]), min(window.end, track.time[-1]), MOST_POINTS)
    return np.column_stack([np.interp(instants, track.time, track.positions[:, axis]) for axis in (0, 1)])


def _outline(track: TableTrack, at: float) -> Floats:
    """Return the corners (4, 2)."""
    x, y = (float(np.interp(at, track.time, track.positions[:, axis])) for axis in (0, 1))
    heading = float(np.interp(at, track.time, track.heading))
    ahead, left = np.array([np.cos(heading), np.sin(heading)]), np.array([-np.sin(heading), np.cos(heading)])
    corners = [(1, 1), (1, -1), (-1, -1), (-1, 1)]
    return np.array([(x, y) + a * track.length / 2 * ahead + b * track.width / 2 * left for a, b in corners])


def _frame(points: Floats) -> tuple[Floats, Floats]:
    """A square around both outlines, and as much again on each side."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
    half = max(float(np.ptp(points, axis=0).max()), MARGIN)
    return middle - half, middle + half


def _points(points: Floats, low: Floats, high: Floats, scale: float) -> str:
    return " ".join(f"{scale * (x - low[0]):.1f},{scale * (high[1] - y):.1f}" for x, y in points.tolist())


def _remarks(report: RankedReport) -> Node:
    pairs = [
        f"{one} and {other} overlap from the start, and nothing led to it" for one, other in report.ranked.overlapping
    ]
    lines = [element("li", text) for text in (*report.remarks, *pairs)]
    again = element("p", element("code", report.again))
    return part("remarks", "Assumptions and exclusions", "", element("ul", lines), again)
