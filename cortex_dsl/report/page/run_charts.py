"""Charts of one run: the paper's metrics over the generations, heat maps of params, effects of params."""

from collections.abc import Iterator, Sequence

import numpy as np

from cortex_dsl.report.blocks import Grid
from cortex_dsl.report.findings.analysis_report import HeatMap, Sides
from cortex_dsl.report.findings.failures import finds_of
from cortex_dsl.report.findings.paper_metrics import METRICS, PaperMetric, meaning_of
from cortex_dsl.report.findings.readable import percent, shortened, significant
from cortex_dsl.report.findings.search_report import whole_run
from cortex_dsl.report.page.charts import Course, line_chart
from cortex_dsl.report.page.markup import Element, Node, element, figure, prose
from cortex_dsl.report.page.scene_svg import number
from engine.search.evaluations import first_alike
from engine.search.journal_reader import Record
from engine.tables import Floats
from engine.vocabulary import Verdict


def metric_charts(record: Record) -> Iterator[Element]:
    """Yield the course of each metric over the generations, with the middle half of the individuals if available."""
    everyone, _ = whole_run(record)
    objective = record.manifest.objective
    for metric in METRICS:
        total = float(getattr(everyone, metric.field))
        yield element(
            "figure",
            element(
                "figcaption",
                element("b", metric.name),
                element("span", f" {meaning_of(metric, objective)}{f' [{metric.unit}]' if metric.unit else ''}"),
                element("span", figure(f"by_individual.{metric.field}", total, metric.text(total)), class_="total"),
            ),
            line_chart(
                _courses(record, metric),
                f"{metric.name}, {meaning_of(metric, objective)}, generation by generation",
                x_label="generation",
            ),
            class_="panel",
        )
    yield _yield_chart(record)


def _yield_chart(record: Record) -> Element:
    """Return the cumulative number of different collisions, or results of another objective, per generation."""
    evaluations, many = record.evaluations, finds_of(record.manifest.objective).many
    rows = np.flatnonzero(evaluations.simulated & evaluations.found)
    first = np.unique(first_alike(evaluations.genomes[rows]))
    generation = evaluations.places[rows[first], 0]
    found = np.bincount(generation, minlength=len(record.generations)).cumsum().astype(np.float64)
    x = np.arange(1, len(found) + 1, dtype=np.float64)
    total = int(found[-1]) if len(found) else 0
    return element(
        "figure",
        element(
            "figcaption",
            element("b", "Yield"),
            element("span", f" sets of params so far, {many}"),
            element("span", figure("distinct_finds", total, f"{total:,}"), class_="total"),
        ),
        line_chart([Course("found", "first", x, found)], f"sets of params so far, {many}", x_label="generation"),
        class_="panel",
    )


def _courses(record: Record, metric: PaperMetric) -> list[Course]:
    x = np.arange(1, len(record.generations) + 1, dtype=np.float64)
    y = np.array([getattr(row.by_individual, metric.field) for row in record.generations], dtype=np.float64)
    fresh = np.array([getattr(row.by_simulation, metric.field) for row in record.generations], dtype=np.float64)
    low, high = _middle_half(record, metric.field)
    return [
        Course("new simulations only", "second", x, fresh),
        Course("all individuals", "first", x, y, low, high),
    ]


def _middle_half(record: Record, field: str) -> tuple[Floats | None, Floats | None]:
    """Lower and upper quartile in each generation, of the metrics that are means."""
    evaluations = record.evaluations
    counted = evaluations.scored if field == "rl" else evaluations.valid
    values = {"rl": evaluations.fitness, "mdg": evaluations.min_distance, "mdec": evaluations.min_distance}.get(field)
    if values is None:
        return None, None
    chosen = counted & ~evaluations.collided if field == "mdec" else counted
    edges = np.searchsorted(evaluations.places[chosen, 0], np.arange(1, len(record.generations)))
    rows = np.split(values[chosen], edges) if record.generations else []
    quartiles = np.array([np.quantile(row, [0.25, 0.75]) if len(row) else [np.nan, np.nan] for row in rows])
    return quartiles.reshape(-1, 2)[:, 0], quartiles.reshape(-1, 2)[:, 1]


SIDE = 300
"""Side of a heat map's square [px]."""
ROOM = (52, 12, 10, 42)
"""Left, right, top and bottom of it."""


def heat_chart(found: HeatMap, verb: str = "collide") -> Element:
    """Each cell's colour is the share of its simulations that failed; an empty cell was never looked at."""
    left, right, top, bottom = ROOM
    width, height = SIDE + left + right, SIDE + top + bottom
    cells = [
        _cell(found, a, b, verb) for a in range(found.across.cells) for b in range(found.up.cells) if found.tried[a, b]
    ]
    return element(
        "svg",
        element("title", f"share that {verb}, by {found.across.name} and {found.up.name}"),
        element("rect", x=left, y=top, width=SIDE, height=SIDE, class_="unseen"),
        cells,
        _ends(found.across, found.up),
        viewBox=f"0 0 {width} {height}",
        class_="chart heat",
        role="img",
        xmlns="http://www.w3.org/2000/svg",
    )


def _cell(found: HeatMap, a: int, b: int, verb: str) -> Element:
    left, _, top, _ = ROOM
    tried, failed = int(found.tried[a, b]), int(found.failed[a, b])
    across, up = SIDE / found.across.cells, SIDE / found.up.cells
    share = failed / tried
    text = f"{_span(found.across, a)}; {_span(found.up, b)}: {failed:,} of {tried:,} {verb}"
    return element(
        "rect",
        element("title", text),
        x=number(left + a * across),
        y=number(top + SIDE - (b + 1) * up),
        width=number(across + 0.2),
        height=number(up + 0.2),
        class_="cell hit" if failed else "cell safe",
        style=f"--share:{number(100 * share, 0)}%" if failed else None,
        data_tried=tried,
        data_failed=failed,
    )


def _span(cut: Sides, cell: int) -> str:
    if cut.labels:
        return f"{cut.name} {cut.labels[cell]}"
    low, high = (significant(float(edge), 3) for edge in cut.edges[cell : cell + 2])
    return f"{cut.name} {low} to {high} {cut.unit}".strip()


def _ends(across: Sides, up: Sides) -> Node:
    left, _, top, _ = ROOM
    bottom, right = top + SIDE, left + SIDE
    return [
        _text(_end(across, 0), left, bottom + 15, "start"),
        _text(_end(across, -1), right, bottom + 15, "end"),
        _text(_name(across), (left + right) / 2, bottom + 32, "middle", "axis-name"),
        _text(_end(up, 0), left - 5, bottom - 2, "end"),
        _text(_end(up, -1), left - 5, top + 10, "end"),
        element(
            "text",
            _name(up),
            transform=f"translate(12 {number(top + SIDE / 2)}) rotate(-90)",
            text_anchor="middle",
            class_="axis-name",
        ),
    ]


def _name(cut: Sides) -> str:
    return f"{cut.name} [{cut.unit}]" if cut.unit else cut.name


def _end(cut: Sides, end: int) -> str:
    return cut.labels[end] if cut.labels else significant(float(cut.edges[end]), 3)


def _text(text: str, x: float, y: float, anchor: str, name: str | None = None) -> Element:
    return element("text", text, x=number(x), y=number(y), text_anchor=anchor, class_=name)


def strip(values: Floats, low: float, high: float, bins: int = 40) -> Element:
    """Draw the distribution of values over a range as a strip of bars."""
    counts, _ = np.histogram(values, bins=bins, range=(low, high if high > low else low + 1.0))
    most = max(1, int(counts.max()))
    bars = [
        element(
            "rect",
            x=k,
            y=number(10 - 10 * count / most),
            width=1,
            height=number(10 * count / most),
        )
        for k, count in enumerate(counts.tolist())
        if count
    ]
    return element(
        "svg",
        element("title", f"{int(counts.sum()):,} values, most of them where the strip is high"),
        element("line", x1=0, y1=10, x2=bins, y2=10, class_="rule base"),
        bars,
        viewBox=f"0 0 {bins} 10.4",
        preserveAspectRatio="none",
        class_="strip",
        role="img",
    )


VERDICTS = {
    Verdict.VALID: "valid",
    Verdict.INFEASIBLE: "infeasible: shown before any scene was drawn",
    Verdict.EXHAUSTED: "no scene found that meets the requirements",
    Verdict.ABORTED: "a requirement on the run broke",
    Verdict.ERROR: "the engine failed",
}


def bars(rows: Sequence[tuple[str, int, str]], whole: int) -> Element:
    """Counts with their share, as bars: (text, count, style)."""
    return element(
        "table",
        element(
            "tbody",
            [
                element(
                    "tr",
                    element("td", f"{count:,}", class_="number"),
                    element("td", percent(count / whole if whole else float("nan")), class_="number"),
                    element("td", _bar(count / whole if whole else 0.0, name), class_="bar-cell"),
                    element("td", prose(text)),
                )
                for text, count, name in rows
            ],
        ),
        class_="bars",
    )


def _bar(share: float, name: str) -> Element:
    return element("div", class_=f"bar {name}", style=f"--share:{number(100 * share, 1)}%")


# -- counts in the cells of two descriptors ---------------------------------------------------------------------------

GRID_CELL, GRID_LABEL, GRID_FOOT = 26, 74, 18
MOST_NAMES = 50
"""Characters that stand below the cells side by side."""


def grid_chart(grid: Grid) -> Element:
    """A row for each cell of the first descriptor that was reached; the shade is the share that collided."""
    used = [i for i in range(len(grid.first)) if grid.runs[i].any()][::-1]
    width = GRID_LABEL + 300
    across = 300 / len(grid.second)
    ends = _names_below(grid.second, width, GRID_CELL * len(used))
    height = GRID_CELL * len(used) + GRID_FOOT * len({end.attributes["y"] for end in ends})
    cells = [
        _grid_cell(grid, i, j, GRID_LABEL + j * across, row * GRID_CELL, across)
        for row, i in enumerate(used)
        for j in range(len(grid.second))
        if grid.runs[i, j]
    ]
    labels = [
        element("text", grid.first[i], x=GRID_LABEL - 6, y=number(row * GRID_CELL + 17), text_anchor="end")
        for row, i in enumerate(used)
    ]
    return element(
        "svg",
        element("title", grid.name),
        cells,
        labels,
        ends,
        viewBox=f"0 0 {width} {height}",
        class_="chart heat",
        role="img",
        xmlns="http://www.w3.org/2000/svg",
    )


def _names_below(names: Sequence[str], width: int, top: int) -> list[Element]:
    """The first and the last cell by name, one below the other where they would meet."""
    first, *others = names
    below = GRID_FOOT if others and len(first) + len(others[-1]) > MOST_NAMES - 4 else 0
    y = top + GRID_FOOT - 4
    return [
        element("text", shortened(first, MOST_NAMES), x=GRID_LABEL, y=y),
        *(
            element("text", shortened(last, MOST_NAMES), x=width, y=y + below, text_anchor="end")
            for last in others[-1:]
        ),
    ]


def _grid_cell(grid: Grid, i: int, j: int, x: float, y: float, across: float) -> Element:
    runs, failures = int(grid.runs[i, j]), int(grid.failures[i, j])
    text = f"{grid.first[i]}; {grid.second[j]}: {failures:,} of {runs:,} collide"
    return element(
        "rect",
        element("title", text),
        x=number(x),
        y=number(y),
        width=number(across - 1),
        height=GRID_CELL - 1,
        class_="cell hit" if failures else "cell safe",
        style=share_style(failures / runs) if failures else None,
    )


def share_style(share: float) -> str:
    return f"--share:{100.0 * max(0.0, min(1.0, share)):.1f}%"
