"""Sections of a run's page from its analysis: kinds of failures, grids, responsible actors, effects of params."""

import math
from collections.abc import Iterator, Sequence

from cortex_dsl.report.blocks import Grid as GridBlock
from cortex_dsl.report.findings.analysis_report import (
    AVOIDANCES,
    DRIVER,
    JUDGED,
    condition_text,
    fastest_text,
    fresh_text,
    grid_text,
    lift_text,
    lost_text,
    margin_text,
    struck_text,
    system_lines,
    varying,
)
from cortex_dsl.report.findings.failures import BLAMES, MEANING, kind_text, rest_text
from cortex_dsl.report.findings.readable import ABSENT, counted, fixed, percent, shortened
from cortex_dsl.report.page.markup import Element, Node, element, figure, folded, part, table
from cortex_dsl.report.page.run_charts import bars, strip
from cortex_dsl.report.page.scene_svg import number
from engine.avoidability import Avoidability, Avoidance
from engine.program import ParamSpace
from engine.search.evaluations import Evaluations
from engine.search.insight.analysis import Analysis
from engine.search.insight.sensitivity import Indices, Sensitivity, Share
from engine.tables import Floats
from engine.vocabulary import GeneKind

AVOIDANCE_STYLES = {
    Avoidance.AVOIDABLE: "hit",
    Avoidance.BRAKED_AS_HARD: "warn",
    Avoidance.UNSEEN: "warn",
    Avoidance.LOST: "warn",
    Avoidance.NO_BRAKING_HELPS: "warn",
}
"""Answers that count against the ego stand out."""


# -- kinds of failures -------------------------------------------------------------------------------------------------


KINDS = (
    "One kind: the same other actor, on the same side, with the same relative heading, both at similar speeds, and the "
    f"same verdict of the reference driver. {MEANING[0].upper()}{MEANING[1:]}."
)
HOW = "How this is determined"
SHOWN = 20
"""Kinds that the page shows."""


def kinds(actors: Sequence[str], analysis: Analysis, pictures: Node) -> Node:
    """Return the section on kinds of failures: pictures, and a table that begins with the avoidable kinds."""
    if not (analysis.kinds and analysis.came.judged):
        return None
    most = max(each.count for each in analysis.kinds)
    rows = [
        element(
            "tr",
            element("td", f"{each.count:,}", class_="number"),
            element("td", _bar(each.count / most), class_="bar-cell"),
            element("td", BLAMES[each.kind.blame][0]),
            element("td", kind_text(actors, each.kind), class_="condition"),
        )
        for each in analysis.kinds[:SHOWN]
    ]
    came = analysis.came
    note = [
        figure("failures.avoidable_kinds", came.avoidable_kinds, counted(came.avoidable_kinds, "avoidable kind")),
        ", ",
        figure("failures.kinds", came.kinds, counted(came.kinds, "kind")),
        " in all.",
    ]
    rest = rest_text(analysis.kinds, SHOWN)
    head = ("collisions", "", "", "what happened")
    more = element("p", f"{rest[0].upper()}{rest[1:]}.", class_="note") if rest else None
    definition = element("p", KINDS, class_="note")
    every = element("details", element("summary", "All kinds"), definition, table(head, rows, "kinds"), more)
    return part("kinds", "Kinds of failures", note, pictures, every)


def places(space: ParamSpace, analysis: Analysis) -> Node:
    """Return the section on clusters of failures in the space of params, with their conditions."""
    if not analysis.clusters:
        return None
    rows = [
        element(
            "tr",
            element("td", f"{len(cluster.rows):,}", class_="number"),
            element("td", condition_text(space, cluster), class_="condition"),
            element("td", percent(cluster.coverage, 0) if cluster.conditions else ABSENT, class_="number"),
            element("td", fresh_text(cluster), class_="number"),
            element("td", lift_text(cluster), class_="number quiet"),
        )
        for cluster in analysis.clusters
    ]
    note = f"Failures that lie together in the space of params. {JUDGED[0].upper()}{JUDGED[1:]}."
    head = ("failures", "where", "inside", "failure rate", "lift")
    return part("places", "Where failures lie", note, table(head, rows, "kinds"))


def _bar(share: float) -> Element:
    return element("div", class_="bar hit", style=share_style(share))


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
            grid_chart(GridBlock(grid.name, grid.first, grid.second, grid.runs, grid.failures)),
            class_="panel",
        )
        for grid in shown
    ]
    note = "How the ego and the other actor met at the closest approach: collisions by speed, angle and side."
    return part("met", "How they met", note, element("div", panels, class_="panels"))


CELL, LABEL, FOOT = 26, 74, 18
ROOM = 50
"""Characters that stand below the cells side by side."""


def grid_chart(grid: GridBlock) -> Element:
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


def _grid_cell(grid: GridBlock, i: int, j: int, x: float, y: float, across: float) -> Element:
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
    """Return the section on the failures that the reference driver would have avoided."""
    found = analysis.avoided
    if not found.driven:
        return None
    rows = [
        (f"{AVOIDANCES[kind][0]}: {AVOIDANCES[kind][2]}", count, AVOIDANCE_STYLES.get(kind, ""))
        for kind, count in found.by.items()
    ]
    note = (
        f"{counted(found.driven, 'collision')}, each driven again by a reference driver. "
        "An avoidable collision counts against the ego as configured; an unavoidable one may be due to the scene; one "
        "in which the ego was struck from behind, or while it stood, is due to the other actor."
    )
    method = f"The reference driver is that of {DRIVER}. Shares refer to what this search kept; they are not rates."
    more = [
        text for text in (lost_text(found), struck_text(found), *system_lines(found), fastest_text(analysis)) if text
    ]
    said = [element("p", f"{text[0].upper()}{text[1:]}.", class_="note") for text in more]
    title = "Would a competent driver have avoided it?"
    return part("avoidable", title, note, bars(rows, found.driven), said, folded(HOW, method))


def avoidance_badge(answer: Avoidability | None) -> Node:
    """Return the badge for the avoidability of one case."""
    if answer is None:
        return None
    name, _, meaning = AVOIDANCES[answer.avoidance]
    margin = margin_text(answer)
    text = name if answer.struck else f"{name} for a competent driver{f' ({margin})' if margin else ''}"
    return element(
        "span", text, class_=f"badge {AVOIDANCE_STYLES.get(answer.avoidance, '')}".strip(), title=f"{meaning}. {DRIVER}"
    )


# -- effects of params, and their course in the search -----------------------------------------------------------------


def params(space: ParamSpace, analysis: Analysis, evaluations: Evaluations, goal: str) -> Node:
    """Return the section on params: their effect on the scenario and their trend in a search that maximizes `goal`."""
    if not len(space):
        return None
    hit = evaluations.simulated & evaluations.collided
    outputs = varying(analysis.sensitivity) if analysis.sensitivity else []
    rows = [
        element(
            "tr",
            element("th", effect.name, _system(analysis, effect.name), scope="row"),
            *_cells([indices.genes[gene].total for _, indices in outputs], "total-bar"),
            element("td", _signed(effect.correlation), class_="number"),
            element("td", _strip(space, gene, evaluations.genomes[hit, gene]), class_="strip-cell"),
        )
        for gene, effect in enumerate(analysis.genes)
    ]
    if outputs:
        last = element("th", "chance", element("small", " lanes, places, …", class_="quiet"), scope="row")
        left = _cells([indices.chance for _, indices in outputs], "quiet-bar")
        rows.append(element("tr", last, *left, element("td", colspan=2)))
    titles = [f"for {title}" for title, _ in outputs]
    head = ("param", *titles, "trend in the search", "where collisions lie in its range")
    method = folded(HOW, "".join(_note(analysis.sensitivity, goal)))
    return part("params", "Which params matter", None, table(head, rows, "genes"), _alone(space, outputs), method)


def _note(found: Sensitivity | None, goal: str) -> Iterator[str]:
    if found is not None:
        yield (
            "Bars: the share of the variance that remains when every other param is known (the total Sobol' index, "
            f"brackets 95 %), from {found.simulations:,} separate simulations, "
            "drawn from the distributions of the file. The indices are "
            "of the mean over chance, that is, over lanes, places and everything else that a scene draws; the last row "
            "is the variance that remains when every param is known. Risk and collision: given a valid run, which "
            f"{percent(found.valid_share)} of the simulations were. "
        )
    yield (
        f"Trend: Spearman's rank correlation with {goal} among the simulations of the search; it also reflects what "
        "the search selected for, and does not prove a cause."
    )


def _cells(shares: Sequence[Share], bar: str) -> Iterator[Element]:
    for share in shares:
        known = math.isfinite(share.value) and share.value > 0.0
        drawn = element("i", class_=f"bar {bar}", style=share_style(share.value)) if known else None
        yield element(
            "td",
            element("div", drawn, fixed(share.value, 2), class_="bar-and-number"),
            element("small", _interval(share), class_="quiet"),
        )


def _alone(space: ParamSpace, outputs: Sequence[tuple[str, Indices]]) -> Node:
    """The first-order indices, folded away."""
    if not outputs:
        return None
    rows = [
        element(
            "tr",
            element("th", name, scope="row"),
            *(element("td", _with_interval(indices.genes[gene].first)) for _, indices in outputs),
        )
        for gene, name in enumerate(space.names)
    ]
    head = ("param", *(f"for {title}" for title, _ in outputs))
    summary = element("summary", "What each param explains by itself (first-order index)")
    return element("details", summary, table(head, rows, "alone"))


def _with_interval(share: Share) -> Sequence[Node]:
    return fixed(share.value, 2), element("small", f" {_interval(share)}", class_="quiet")


def _interval(share: Share) -> str:
    low, high = share.interval
    return f"[{fixed(low, 2)}, {fixed(high, 2)}]" if math.isfinite(low) else ""


def _system(analysis: Analysis, name: str) -> Node:
    return element("small", " of the system", class_="quiet") if name in analysis.system else None


def _strip(space: ParamSpace, gene: int, values: Floats) -> Element:
    low, high = float(space.low[gene]), float(space.high[gene])
    if space.kinds[gene] == GeneKind.INDEX:
        return strip(values, low - 0.5, high + 0.5, len(space.options[gene]))
    return strip(values, low, high)


def _signed(value: float) -> str:
    return "–" if math.isnan(value) else f"{value:+.2f}".replace("-", "\N{MINUS SIGN}")
