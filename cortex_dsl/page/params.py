"""The section of a run's page on its params: which of them matter for what, and what the search made of them."""

import math
from collections.abc import Iterator, Sequence

from cortex_dsl.page.document import part, table
from cortex_dsl.page.element import Element, Node, element
from cortex_dsl.page.run_charts import strip
from cortex_dsl.page.understanding import share_style
from cortex_dsl.report.failures import varying
from cortex_dsl.report.numbers import fixed, percent
from engine.program import ParamSpace
from engine.search.analysis import Analysis
from engine.search.evaluations import Evaluations
from engine.search.sensitivity import Indices, Sensitivity, Share
from engine.tables import Floats
from engine.vocabulary import GeneKind


def params(space: ParamSpace, analysis: Analysis, evaluations: Evaluations) -> Node:
    """What each param does to the scenario, and what the search made of it."""
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
    note = list(_note(analysis.sensitivity))
    return part("params", "Which params matter", note, table(head, rows, "genes"), _alone(space, outputs))


def _note(found: Sensitivity | None) -> Iterator[str]:
    if found is not None:
        yield (
            "Bars: the share of the variance that is left when every other param is known (the total index of Sobol', "
            f"brackets 95 %), from {found.simulations:,} simulations of their own, drawn as the file says. What is "
            "explained is the mean over chance, that is, over lanes, places and what else a scene draws; the last row "
            "is what chance leaves when every param is known. Risk and collision: given a valid run, which "
            f"{percent(found.valid_share)} of the simulations were. "
        )
    yield (
        "Trend: Spearman's rank correlation with risk among what the search simulated; it also shows what the search "
        "bred for, and is no proof of cause."
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
