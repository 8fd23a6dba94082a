"""Sections of a run's page from its analysis: kinds of failures, grids, responsible actors, effects of params."""

import math
from collections.abc import Iterator, Sequence

from cortex_dsl.report.blocks import Column, Table, Title, Value, Words
from cortex_dsl.report.blocks import Grid as GridBlock
from cortex_dsl.report.findings.analysis_report import (
    AVOIDANCES,
    DRIVER,
    fastest_text,
    grid_text,
    lost_text,
    margin_text,
    struck_text,
    system_lines,
    varying,
)
from cortex_dsl.report.findings.failures import BLAMES, MEANING, verdicts_text
from cortex_dsl.report.findings.judgement import ANSWERS, covering, drivers_text
from cortex_dsl.report.findings.readable import counted, fixed, percent
from cortex_dsl.report.page.markup import Element, Node, element, figure, folded, part, table
from cortex_dsl.report.page.render import nodes
from cortex_dsl.report.page.run_charts import bars, grid_chart, share_style, strip
from cortex_dsl.report.views.analysis import drivers_table, kinds_blocks, places_blocks
from engine.avoidability import Avoidability, Avoidance
from engine.program import ParamSpace
from engine.search.evaluations import Evaluations
from engine.search.insight.analysis import Analysis
from engine.search.insight.sensitivity import Indices, Sensitivity, Share
from engine.tables import Floats
from engine.verdicts import JudgedCollision
from engine.vocabulary import Blame, GeneKind

AVOIDANCE_STYLES = {
    Avoidance.AVOIDABLE: "hit",
    Avoidance.BRAKED_AS_HARD: "warn",
    Avoidance.UNSEEN: "warn",
    Avoidance.LOST: "warn",
    Avoidance.NO_BRAKING_HELPS: "warn",
}
"""Answers that count against the ego stand out."""
VERDICT_STYLES = {"bad": "hit", "warn": "warn"}
"""Classes of the styles of verdicts."""


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
    came = analysis.came
    note = [
        figure("failures.avoidable_kinds", came.avoidable_kinds, counted(came.avoidable_kinds, "avoidable kind")),
        ", ",
        figure("failures.kinds", came.kinds, counted(came.kinds, "kind")),
        " in all.",
    ]
    inner = [node for block in kinds_blocks(actors, analysis, SHOWN) for node in nodes(block)]
    every = folded("All kinds", KINDS, inner)
    return part("kinds", "Kinds of failures", note, pictures, every)


def places(space: ParamSpace, analysis: Analysis) -> Node:
    """Return the section on clusters of failures in the space of params, with their conditions."""
    if not analysis.clusters:
        return None
    inner = [node for block in places_blocks(space, analysis) for node in nodes(block)]
    return part("places", "Where failures lie", "Failures that lie together in the space of params.", inner)


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


# -- the reference driver ---------------------------------------------------------------------------------------------


def avoided(analysis: Analysis) -> Node:
    """Return the section on the failures that the reference drivers would have avoided."""
    found = analysis.avoided
    if not found.driven:
        return None
    rows = [
        (f"{AVOIDANCES[kind][0]}: {AVOIDANCES[kind][2]}", count, AVOIDANCE_STYLES.get(kind, ""))
        for kind, count in found.by.items()
    ]
    note = (
        f"{verdicts_text(analysis.came)}. Avoidable: all reference drivers whose range covers it avoid it; disputed: "
        "some do. An avoidable collision counts against the ego as configured; an unavoidable one may be due to the "
        "scene; one in which the ego was struck from behind, or while it stood, is due to the other actor."
    )
    reasons = element("p", f"The careful driver in {counted(found.driven, 'collision')}:", class_="note")
    method = f"The reference driver is that of {DRIVER}. Shares refer to what this search kept; they are not rates."
    more = [
        text for text in (lost_text(found), struck_text(found), *system_lines(found), fastest_text(analysis)) if text
    ]
    said = [element("p", f"{text[0].upper()}{text[1:]}.", class_="note") for text in more]
    title = "Would a competent driver have avoided it?"
    return part(
        "avoidable",
        title,
        note,
        nodes(drivers_table(found)),
        reasons,
        bars(rows, found.driven),
        said,
        folded(HOW, method),
    )


def verdict_badges(answer: Avoidability | None, judged: JudgedCollision | None) -> Node:
    """Return the badges for the verdict on one case, and for the careful driver's answer."""
    if answer is None:
        return None
    return [_verdict_badge(judged), _careful_badge(answer)]


def _verdict_badge(judged: JudgedCollision | None) -> Node:
    """Return the badge for the verdict of several reference drivers; None where one says all."""
    if (
        judged is None
        or (len(covering(judged)) == 1 and "careful" in covering(judged))
        or judged.verdict == Blame.STRUCK
    ):
        return None
    name, style = BLAMES[judged.verdict]
    by = drivers_text(judged)
    text = f"{name}: avoided by {by}" if by else name
    answers = "; ".join(f"{driver}: {ANSWERS[answer][0]}" for driver, answer in judged.answers.items())
    return element("span", text, class_=f"badge {VERDICT_STYLES.get(style, '')}".strip(), title=answers)


def _careful_badge(answer: Avoidability) -> Node:
    name, _, meaning = AVOIDANCES[answer.avoidance]
    margin = margin_text(answer)
    text = name if answer.struck else f"{name} for the careful driver{f' ({margin})' if margin else ''}"
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
    """Return the first-order indices, folded; None without any."""
    if not outputs:
        return None
    rows = [
        (name, *(_first(indices.genes[gene].first) for _, indices in outputs)) for gene, name in enumerate(space.names)
    ]
    columns = Column("param"), *(Column(f"for {title}") for title, _ in outputs)
    title = "What each param explains by itself (first-order index)"
    return nodes(Title(title, [Table(columns, rows, name="alone")], folded=True))


def _first(share: Share) -> Words:
    return fixed(share.value, 2), Value(f" {_interval(share)}", "quiet")


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
