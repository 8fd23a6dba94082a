"""Sections of a run's page that come from its analysis: kinds of failures, grids, whose fault."""

from collections.abc import Sequence

from cortex_dsl.page.document import figure, part, table
from cortex_dsl.page.drawing import number
from cortex_dsl.page.element import Element, Node, element
from cortex_dsl.page.run_charts import bars
from cortex_dsl.report.failures import (
    AVOIDANCES,
    DRIVER,
    condition_text,
    fastest_text,
    grid_text,
    lost_text,
    margin_text,
    shuffled_text,
    system_lines,
)
from cortex_dsl.report.layout import shortened
from cortex_dsl.report.numbers import counted, fixed, percent
from engine.avoidability import Avoidability, Avoidance
from engine.program import ParamSpace
from engine.search.analysis import Analysis
from engine.search.diversity import Grid

AVOIDANCE_STYLES = {Avoidance.AVOIDABLE: "hit", Avoidance.BRAKED_AS_HARD: "warn", Avoidance.UNSEEN: "warn"}
"""What speaks against the ego stands out."""


# -- kinds of failures -------------------------------------------------------------------------------------------------


KINDS = (
    " differ from all before in at least a third of the params by a tenth of their range. Failures that lie together "
    "are one kind; the condition is what tells it from everything else that was simulated. It is fitted to these very "
    "runs: held out are the shares when it is found from every other run and judged on those between."
)


def kinds(space: ParamSpace, analysis: Analysis) -> Node:
    """Each kind with the condition that sets it apart."""
    if not analysis.clusters:
        return None
    whole = sum(len(cluster.rows) for cluster in analysis.clusters)
    rows = [
        element(
            "tr",
            element("td", f"{len(cluster.rows):,}", class_="number"),
            element("td", _bar(len(cluster.rows) / whole), class_="bar-cell"),
            element("td", condition_text(space, cluster), class_="condition"),
            element("td", percent(cluster.precision, 0), class_="number"),
            element("td", percent(cluster.coverage, 0), class_="number"),
            element("td", percent(cluster.held_out.precision, 0), class_="number quiet"),
            element("td", percent(cluster.held_out.coverage, 0), class_="number quiet"),
        )
        for cluster in analysis.clusters
    ]
    distinct = len(analysis.distinct)
    note = [
        figure("distinct_failures", distinct, counted(distinct, "failure")),
        f"{KINDS}{_shuffled(analysis)}",
    ]
    head = ("failures", "", "where", "collide there", "of the kind", "held out: collide", "of the kind")
    return part("kinds", "Kinds of failures", note, table(head, rows, "kinds"))


def _bar(share: float) -> Element:
    return element("div", class_="bar hit", style=share_style(share))


def _shuffled(analysis: Analysis) -> str:
    """How far the count depends on which failure came first."""
    low, high = analysis.distinct_range
    return f" Counted in other orders, {low:,} to {high:,} differ so." if shuffled_text(analysis) else ""


# -- grids ------------------------------------------------------------------------------------------------------------


def grids(analysis: Analysis) -> Node:
    """How the two met, counted in the cells of the descriptors."""
    shown = [grid for grid in analysis.grids if grid.covered]
    if not shown:
        return None
    panels = [
        element(
            "figure",
            element(
                "figcaption",
                element("b", grid.name),
                element("span", f"{grid_text(grid)} · QD score {fixed(grid.qd_score, 0)}"),
            ),
            grid_chart(grid),
            class_="panel",
        )
        for grid in shown
    ]
    note = "How the ego and the other met at the closest approach: collisions by speeds, by angle, by side."
    return part("met", "How they met", note, element("div", panels, class_="panels"))


CELL, LABEL, FOOT = 26, 74, 18
ROOM = 50
"""Characters that stand below the cells side by side."""


def grid_chart(grid: Grid) -> Element:
    """A row for each cell of the first descriptor that was reached; the shade is the share that collided."""
    used = [i for i in range(len(grid.first)) if grid.runs[i].any()][::-1]
    width = LABEL + 300
    across = 300 / len(grid.second)
    ends = _ends(grid.second, width, CELL * len(used))
    height = CELL * len(used) + FOOT * len({end.attributes["y"] for end in ends})
    cells = [
        _grid_cell(grid, i, j, LABEL + j * across, row * CELL, across)
        for row, i in enumerate(used)
        for j in range(len(grid.second))
        if grid.runs[i, j]
    ]
    labels = [
        element("text", grid.first[i], x=LABEL - 6, y=number(row * CELL + 17), text_anchor="end")
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


def _ends(names: Sequence[str], width: int, top: int) -> list[Element]:
    """The first and the last cell by name, one below the other where they would meet."""
    first, *others = names
    below = FOOT if others and len(first) + len(others[-1]) > ROOM - 4 else 0
    y = top + FOOT - 4
    return [
        element("text", shortened(first, ROOM), x=LABEL, y=y),
        *(element("text", shortened(last, ROOM), x=width, y=y + below, text_anchor="end") for last in others[-1:]),
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
        height=CELL - 1,
        class_="cell hit" if failures else "cell safe",
        style=share_style(failures / runs) if failures else None,
    )


def share_style(share: float) -> str:
    return f"--share:{100.0 * max(0.0, min(1.0, share)):.1f}%"


# -- the reference driver ---------------------------------------------------------------------------------------------


def avoided(analysis: Analysis) -> Node:
    """What the reference driver would have made of the failures."""
    found = analysis.avoided
    if not found.driven:
        return None
    rows = [
        (f"{AVOIDANCES[kind][0]}: {AVOIDANCES[kind][2]}", count, AVOIDANCE_STYLES.get(kind, ""))
        for kind, count in found.by.items()
    ]
    note = (
        f"{counted(found.driven, 'different collision')}, each driven again by the reference driver of {DRIVER}. "
        "An avoidable collision speaks against the ego as it was set; an unavoidable one may speak against the scene. "
        "Shares are of what this search kept: no rates."
    )
    more = [text for text in (lost_text(found), *system_lines(found), fastest_text(analysis)) if text]
    said = [element("p", f"{text[0].upper()}{text[1:]}.", class_="note") for text in more]
    return part("avoidable", "Would a competent driver have avoided it?", note, bars(rows, found.driven), said)


def avoidance_badge(answer: Avoidability | None) -> Node:
    """What is said of one case."""
    if answer is None:
        return None
    name, _, meaning = AVOIDANCES[answer.avoidance]
    margin = margin_text(answer)
    text = f"{name} for a competent driver{f' ({margin})' if margin else ''}"
    return element(
        "span", text, class_=f"badge {AVOIDANCE_STYLES.get(answer.avoidance, '')}".strip(), title=f"{meaning}. {DRIVER}"
    )
