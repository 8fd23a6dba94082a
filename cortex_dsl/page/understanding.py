"""Sections of a run's page that come from its analysis: kinds of failures, grids, which params matter, whose fault."""

import math
from collections.abc import Iterator, Sequence

from cortex_dsl.page.drawing import number
from cortex_dsl.page.element import Element, Node, element, prose
from cortex_dsl.page.run_charts import bars, strip
from cortex_dsl.page.summary import figure
from cortex_dsl.report.analysis_view import AVOIDANCES, DRIVER, condition_text, lost_text, margin_text
from cortex_dsl.report.numbers import counted, fixed, percent
from engine.avoidability import Avoidability, Avoidance
from engine.program import ParamSpace
from engine.search.analysis import Analysis, Avoided
from engine.search.diversity import Grid
from engine.search.evaluations import Evaluations
from engine.search.sensitivity import CHANCE, GeneIndex, Sensitivity
from engine.tables import Floats
from engine.vocabulary import GeneKind

AVOIDANCE_STYLES = {Avoidance.AVOIDABLE: "hit", Avoidance.BRAKED_AS_HARD: "warn", Avoidance.UNSEEN: "warn"}
"""What speaks against the ego stands out."""


def part(name: str, title: str, note: Node, *content: Node) -> Element:
    """A section of a page."""
    return element(
        "section",
        element("h2", title),
        element("p", prose(note) if isinstance(note, str) else note, class_="note"),
        content,
        id=name,
        class_="part",
    )


def table(head: Sequence[str], rows: Sequence[Element], name: str) -> Element:
    """A table with a head, which scrolls by itself where the screen is narrow."""
    cells = rows[0].children if rows and len(rows[0].children) == len(head) else (None,) * len(head)
    top = element("thead", element("tr", [_head(text, cell) for text, cell in zip(head, cells, strict=True)]))
    return element("div", element("table", top, element("tbody", rows), class_=name), class_="wide", tabindex=0)


def _head(text: str, below: Node) -> Element:
    """Over numbers, to the right like them."""
    numbers = isinstance(below, Element) and "number" in str(below.attributes.get("class_")).split()
    return element("th", text, scope="col", class_="number" if numbers else None)


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
            element("td", element("div", class_="bar hit", style=_share(len(cluster.rows) / whole)), class_="bar-cell"),
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
        KINDS,
    ]
    head = ("failures", "", "where", "collide there", "of the kind", "held out: collide", "of the kind")
    return part("kinds", "Kinds of failures", note, table(head, rows, "kinds"))


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
                element("span", f"{grid.failing} of {grid.cells} cells collide · QD score {fixed(grid.qd_score, 0)}"),
            ),
            grid_chart(grid),
            class_="panel",
        )
        for grid in shown
    ]
    note = "How the ego and the other met at the closest approach: collisions by speeds, by angle, by side."
    return part("met", "How they met", note, element("div", panels, class_="panels"))


CELL, LABEL, FOOT = 26, 74, 18


def grid_chart(grid: Grid) -> Element:
    """A row for each cell of the first descriptor that was reached; the shade is the share that collided."""
    used = [i for i in range(len(grid.first)) if grid.runs[i].any()][::-1]
    width = LABEL + 300
    across = 300 / len(grid.second)
    height = CELL * len(used) + FOOT
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
    ends = [
        element("text", grid.second[0], x=LABEL, y=height - 4),
        element("text", grid.second[-1], x=width, y=height - 4, text_anchor="end") if len(grid.second) > 1 else None,
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
        style=_share(failures / runs) if failures else None,
    )


# -- params -----------------------------------------------------------------------------------------------------------


def params(space: ParamSpace, analysis: Analysis, evaluations: Evaluations) -> Node:
    """What each param does to the scenario, and what the search made of it."""
    if not len(space):
        return None
    hit = evaluations.simulated & evaluations.collided
    most = _most(analysis.sensitivity)
    rows = [
        element(
            "tr",
            element("th", effect.name, _system(analysis, effect.name), scope="row"),
            *_index_cells(analysis.sensitivity, gene, most),
            element("td", _signed(effect.correlation), class_="number"),
            element("td", _strip(space, gene, evaluations.genomes[hit, gene]), class_="strip-cell"),
        )
        for gene, effect in enumerate(analysis.genes)
    ]
    if analysis.sensitivity is not None:
        last = element("th", "chance", element("small", " lanes, places, …", class_="quiet"), scope="row")
        rows.append(
            element("tr", last, *_index_cells(analysis.sensitivity, len(space), most), element("td", colspan=2))
        )
    indices = ("total effect on risk", "[95 %]", "on collision") if analysis.sensitivity else ()
    head = ("param", *indices, "trend in the search", "where collisions lie in its range")
    return part("params", "Which params matter", list(_params_note(analysis)), table(head, rows, "genes"))


def _params_note(analysis: Analysis) -> Iterator[str]:
    if analysis.sensitivity is not None:
        yield (
            f"Total effect: the share of the variance that is lost when all other params are known (Sobol', estimated "
            f"as by Saltelli et al. 2010, from {analysis.sensitivity.simulations:,} simulations of their own, drawn as "
            f"the file says). "
        )
    yield (
        "Trend: Spearman's rank correlation with risk among what the search simulated; it also shows what the search "
        "bred for, and is no proof of cause."
    )


def _most(found: Sensitivity | None) -> float:
    totals = [index.total for index in (found.risk if found else ()) if math.isfinite(index.total)]
    return max(totals, default=0.0)


def _index_cells(found: Sensitivity | None, row: int, most: float) -> Iterator[Element]:
    if found is None:
        return
    risk, collision = found.risk[row], found.collision[row]
    share = risk.total / most if most > 0.0 and math.isfinite(risk.total) else 0.0
    name = "bar quiet-bar" if risk.name == CHANCE else "bar total-bar"
    yield element(
        "td",
        element(
            "div",
            element("i", class_=name, style=_share(share)) if share else None,
            _index(risk),
            class_="bar-and-number",
        ),
    )
    yield element("td", _interval(risk), class_="number quiet")
    yield element("td", _index(collision), class_="number")


def _index(index: GeneIndex) -> str:
    return fixed(index.total, 2)


def _interval(index: GeneIndex) -> str:
    low, high = index.total_interval
    return f"{fixed(low, 2)} to {fixed(high, 2)}" if math.isfinite(low) else ""


def _system(analysis: Analysis, name: str) -> Node:
    return element("small", " of the system", class_="quiet") if name in analysis.system else None


def _strip(space: ParamSpace, gene: int, values: Floats) -> Element:
    low, high = float(space.low[gene]), float(space.high[gene])
    if space.kinds[gene] == GeneKind.INDEX:
        return strip(values, low - 0.5, high + 0.5, len(space.options[gene]))
    return strip(values, low, high)


def _signed(value: float) -> str:
    return "–" if math.isnan(value) else f"{value:+.2f}".replace("-", "\N{MINUS SIGN}")


def _share(share: float) -> str:
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
        "An avoidable collision speaks against the ego; an unavoidable one may speak against the scene. "
        f"{_lost(found)}"
    )
    return part("avoidable", "Would a competent driver have avoided it?", note, bars(rows, found.driven))


def _lost(found: Avoided) -> str:
    text = lost_text(found)
    return f"{text}." if text else ""


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
