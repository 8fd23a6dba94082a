"""The report of a study: its claims, their certainty, and every run behind them."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from shlex import join

import numpy as np

from cortex_dsl.report.blocks import Code, Facts, Title
from cortex_dsl.report.findings.paper_metrics import METRICS, PaperMetric
from cortex_dsl.report.findings.search_report import method_name
from cortex_dsl.report.findings.study_report import (
    BOXED,
    distinct_simulations,
    generation_values,
    in_layout_of_paper,
    measure_called,
    study_content,
    verdict_line,
)
from cortex_dsl.report.page import markup
from cortex_dsl.report.page.charts import Box, Course, box_chart, line_chart
from cortex_dsl.report.page.markup import Element, Node, element, folded, page, part, top_bar
from cortex_dsl.report.page.render import nodes
from cortex_dsl.report.views.study import paper_view, primary_view, rates_view, studies_view, tests_view
from engine.search.store import without_folders
from engine.strict_json import plain
from engine.study.comparisons import Measure, sample
from engine.study.database import Study
from engine.study.run_records import curve_of, smoothed
from engine.study.verdict import FAMILIES, METHODS, RULE, Findings

LINKS = (
    ("#verdict", "Verdict"),
    ("#primary", "Which method finds more"),
    ("#boxes", "Run by run"),
    ("#curves", "Curves"),
    ("#tests", "Tests"),
    ("#rates", "Random sampling"),
    ("#paper", "Compared with the paper"),
    ("#layout", "In the paper's layout"),
    ("#again", "Reproduce it"),
)


def study_page(study: Study, found: Findings) -> str:
    """Return the page of a study and of its findings, as text."""
    parts = list(_parts(study, found))
    names = {each.attributes.get("id") for each in parts if isinstance(each, Element)} | {"verdict"}
    body = [
        top_bar([(place, name) for place, name in LINKS if place[1:] in names]),
        element("main", _hero(study, found), parts, _footer(study)),
    ]
    data = {"study": plain(study_content(study, found))}
    return page(_title(study), body, data, ("page.js",), "".join(study.seals[-1:]))


def _title(study: Study) -> str:
    plan = study.plan
    others = ", ".join(map(method_name, plan.contenders))
    title = f"{others} against {method_name(plan.baseline)}" if others else method_name(plan.baseline)
    return f"{title[:1].upper()}{title[1:]}"


def _hero(study: Study, found: Findings) -> Element:
    plan, records = study.plan, study.records
    tiles = (
        ("scenarios", f"{len(plan.subjects):,}"),
        ("methods", f"{len(plan.methods):,}"),
        ("runs of each", f"{plan.runs:,}"),
        ("individuals in each run", f"{plan.individuals:,}"),
        ("distinct simulations", f"{distinct_simulations(study):,}"),
    )
    unfinished = f"This study is not finished: so far {len(records):,} runs are." if not study.complete else ""
    return element(
        "header",
        element("p", "Study of search methods", class_="kicker"),
        element("h1", _title(study)),
        element("p", ", ".join(subject.name for subject in plan.subjects), class_="description"),
        element("p", unfinished, class_="note") if unfinished else None,
        element("p", f"{verdict_line(plan, found.comparisons)}.", class_="headline", id="verdict"),
        [element("p", _sentence(text), class_="note") for text in found.verdict],
        folded("How this is decided", _sentence(RULE), _sentence(FAMILIES)),
        nodes(Facts(tiles, tiles=True)),
        class_="hero",
    )


def _sentence(text: str) -> str:
    first, space, others = text.partition(" ")
    name = method_name(first)  # of a sentence about a method
    return f"{name[:1].upper()}{name[1:]}{space}{others}."


def _parts(study: Study, found: Findings) -> Iterator[Node]:
    yield _limits()
    yield from _shown(primary_view(study, found))
    yield _boxes(study, found)
    yield _curves(study)
    yield from _shown(tests_view(found), rates_view(found), _paper(found))
    yield _layout(study, found)
    yield from _shown(_again(study))


def _shown(*views: Title | None) -> Iterator[Node]:
    for view in views:
        yield from nodes(view, 1) if view is not None else []


def _paper(found: Findings) -> Title | None:
    """Return our numbers beside the paper's, with its table of studies below."""
    ours, studies = paper_view(found), studies_view(found)
    return ours and studies and replace(ours, blocks=[*ours.blocks, studies])


def _limits() -> Element:
    texts = (
        "Rates of a search method are not probabilities: it samples where it has found danger.",
        "A result holds for these scenarios, this budget and this simulator.",
        "Runs are the observations; simulations within one run are not independent and are not tested.",
        "A larger yield does not mean a larger variety: read the kinds together with the collisions.",
    )
    listed = element("ul", [element("li", text) for text in texts])
    return element("section", folded("What this does not show", listed), class_="part")


# -- the primary outcome, and box plots --------------------------------------------------------------------------------


def _key(study: Study) -> Element:
    swatches = [
        element("span", element("i", class_=f"swatch {_style(study, method)}"), method_name(method))
        for method in study.plan.methods
    ]
    return element("p", swatches, class_="key")


def _style(study: Study, method: str) -> str:
    order = (study.plan.baseline, *study.plan.contenders)
    return f"actor-{(5, 0, 1, 2, 3, 4)[order.index(method) % 6]}"


def _boxes(study: Study, found: Findings) -> Node:
    note = (
        "Each box shows the runs of one method that have the number: median, quartiles, whiskers within 1.5 box "
        f"lengths. Stars: Holm-corrected p of the test against {method_name(study.plan.baseline)} below 0.05, 0.01, "
        "0.001; ▲ better, ▼ worse."
    )
    blocks = [
        [
            element("h3", subject.name, class_="sub"),
            element("div", [_box(study, found, number, name) for name in BOXED], class_="panels"),
        ]
        for number, subject in enumerate(study.plan.subjects)
    ]
    return part("boxes", "Run by run", note, _key(study), _consolidated(study), blocks)


def _box(study: Study, found: Findings, scenario: int, name: str) -> Element:
    plan, measure = study.plan, measure_called(name)
    order = (plan.baseline, *plan.contenders)
    boxes = [Box(m, _style(study, m), sample(study.records, scenario, m, measure)) for m in order]
    title = plan.subjects[scenario].name
    rows = {row.method: row for row in found.comparisons if row.scenario == title and row.measure is measure}
    stars = [(0, order.index(m), rows[m].marks) for m in plan.contenders if m in rows and rows[m].stars]
    return _panel(measure, box_chart(boxes, f"{measure.name}, {title}", stars=stars))


def _consolidated(study: Study) -> Node:
    """All scenarios together, as in the paper's first figure; scenarios differ, so this is shown and not tested."""
    plan = study.plan
    if len(plan.subjects) < 2:
        return None
    panels = []
    for name in BOXED:
        measure = measure_called(name)
        boxes = [
            Box(
                method,
                _style(study, method),
                np.concatenate([sample(study.records, k, method, measure) for k in range(len(plan.subjects))]),
            )
            for method in (plan.baseline, *plan.contenders)
        ]
        panels.append(_panel(measure, box_chart(boxes, f"{measure.name}, all scenarios")))
    title = element("h3", "All scenarios together (not tested: tests are scenario by scenario)", class_="sub")
    return [title, element("div", panels, class_="panels")]


def _panel(measure: Measure | PaperMetric, chart: Element) -> Element:
    unit = f" [{measure.unit}]" if measure.unit else ""
    return element(
        "figure",
        element("figcaption", element("b", measure.name), element("span", f"{measure.meaning}{unit}")),
        chart,
        class_="panel",
    )


# -- curves -----------------------------------------------------------------------------------------------------------


def _curves(study: Study) -> Element:
    note = (
        "Median over the runs, generation by generation, with the middle half as a band; medians are smoothed by a "
        "Savitzky-Golay filter, as in the paper. Elites count in every generation that kept them."
    )
    blocks = [
        [
            element("h3", subject.name, class_="sub"),
            element("div", [_curve(study, number, metric) for metric in METRICS], class_="panels"),
        ]
        for number, subject in enumerate(study.plan.subjects)
    ]
    return part("curves", "Over the generations", note, _key(study), blocks)


def _curve(study: Study, scenario: int, metric: PaperMetric) -> Element:
    courses = []
    for method in study.plan.methods:
        curve = curve_of(study.plan, study.records, scenario, method, metric.field)
        low, high = curve.band()
        x = np.arange(1, curve.values.shape[1] + 1, dtype=np.float64)
        courses.append(
            Course(method_name(method), _style(study, method), x, np.maximum(smoothed(curve.median), 0.0), low, high)
        )
    return _panel(metric, line_chart(courses, f"{metric.name} over the generations", x_label="generation"))


# -- the plots of the paper --------------------------------------------------------------------------------------------


def _layout(study: Study, found: Findings) -> Node:
    """Return a plot for each metric with a curve per scenario and method, and boxes over the values of generations."""
    scenarios = in_layout_of_paper(study, found)
    if not scenarios:
        return None
    note = (
        "One curve per scenario and method, medians over the runs, smoothed by a Savitzky-Golay filter. Each box shows "
        "the values of the generations, one value per generation; the first group has those of all scenarios."
    )
    key = [
        *(
            element("span", element("i", class_=f"swatch actor-{place}"), study.plan.subjects[number].name)
            for place, number in enumerate(scenarios)
        ),
        *(
            element("span", element("i", class_=style), method_name(m))
            for m, style in zip(METHODS, STROKES, strict=True)
        ),
    ]
    curves = element("div", [_curves_of_all(study, scenarios, metric) for metric in METRICS], class_="panels")
    groups = [("All scenarios", scenarios), *((study.plan.subjects[number].name, (number,)) for number in scenarios)]
    boxes = [
        [
            element("h3", title, class_="sub"),
            element("div", [_boxes_of_generations(study, numbers, metric) for metric in METRICS], class_="panels"),
        ]
        for title, numbers in groups
    ]
    return part("layout", "In the paper's layout", note, element("p", key, class_="key"), curves, boxes)


STROKES = ("line", "dashes")
"""Samples of the two kinds of curves in the key, in the order of `METHODS`."""


def _curves_of_all(study: Study, scenarios: Sequence[int], metric: PaperMetric) -> Element:
    courses = []
    for place, number in enumerate(scenarios):
        for method, dash in zip(METHODS, ("", " dashed"), strict=True):
            y = np.maximum(smoothed(curve_of(study.plan, study.records, number, method, metric.field).median), 0.0)
            name = f"{study.plan.subjects[number].name}, {method_name(method)}"
            courses.append(Course(name, f"actor-{place}{dash}", np.arange(1.0, len(y) + 1.0), y))
    return _panel(metric, line_chart(courses, f"{metric.name} of all scenarios", x_label="generation"))


def _boxes_of_generations(study: Study, scenarios: Sequence[int], metric: PaperMetric) -> Element:
    boxes = [
        Box(method, _style(study, method), generation_values(study, scenarios, method, metric.field))
        for method in METHODS
    ]
    return _panel(metric, box_chart(boxes, f"{metric.name}, generation by generation"))


# -- the end -----------------------------------------------------------------------------------------------------------


def _again(study: Study) -> Title:
    plan, search, command = study.plan, study.plan.subjects[0].config.search, study.manifest.get("command_line")
    facts = [
        ("seed of each scenario", ", ".join(map(str, plan.seeds))),
        ("generations x population", f"{search.generations} x {search.population}"),
        ("risk profile", plan.profile),
        *((subject.name, f"{subject.file}, program {subject.program.digest}") for subject in plan.subjects),
    ]
    commands = [] if command is None else [markup.command_again(("study", *command))]
    commands.append(join(("cortexc", "report", without_folders(str(study.folder)))))
    note = "The same command gives the same study, run by run."
    return Title("Reproduce it", [*map(Code, commands), Facts(facts)], note, name="again")


def _footer(study: Study) -> Element:
    return element(
        "footer",
        f"Written by cortexc from the study in {without_folders(str(study.folder))}. This file needs no network and "
        "contains all its data.",
    )
