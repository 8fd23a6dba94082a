"""A study's figures for papers, a panel for each scenario: curves of the five metrics, box plots of the measures."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from cortex_dsl.page.figures import new_figure, save_all
from cortex_dsl.report.findings.study_report import BOXED, measure_called
from cortex_dsl.report.page.run_charts import METRICS, PaperMetric
from cortex_dsl.report.page.summary import method_name
from engine.study.comparisons import Comparison, compare_all, sample
from engine.study.curves import curve_of, smoothed
from engine.study.measures import Measure
from engine.study.reading import Study

ACROSS = 3
"""Panels beside one another, at most."""
WIDTH, HEIGHT = 2.5, 2.1
"""Of a panel [inches]."""
COLOURS = ("#8a8f98", "#c8501e", "#0b6bb0", "#2f7d4f", "#7a4fa3", "#b58900")
"""Of the baseline, then of the contenders."""


def write_study_figures(study: Study, folder: Path) -> list[Path]:
    """Write all figures in all formats; their paths.

    Raises:
        MissingExtra: matplotlib is not installed.
        OSError: a file cannot be written.
    """
    return save_all(_figures(study), folder)


def _figures(study: Study) -> Iterator[tuple[str, Any]]:
    rows = compare_all(study.plan, study.records)
    for metric in METRICS:
        yield f"curves-{metric.name.lower()}", _panels(study, lambda axes, k, m=metric: _curves(axes, study, k, m))
    for name in BOXED:
        measure = measure_called(name)
        stem = f"boxes-{name.lower().replace(' ', '-')}"
        yield stem, _panels(study, lambda axes, k, m=measure: _boxes(axes, study, rows, k, m))


def _panels(study: Study, draw: Callable[[Any, int], None]) -> Any:
    """A figure with a panel for each scenario; the methods are told once, below."""
    count = len(study.plan.subjects)
    across = min(ACROSS, count)
    down = -(-count // across)
    figure = new_figure(WIDTH * max(2, across), HEIGHT * down + 0.3)
    axes = figure.subplots(down, across, squeeze=False).flat
    for number, subject in enumerate(study.plan.subjects):
        axes[number].set_title(_text(subject.name), loc="left", fontweight="bold")
        draw(axes[number], number)
    for unused in axes[count:]:
        unused.set_axis_off()
    handles, labels = axes[0].get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False)
    return figure


def _text(text: str) -> str:
    """Matplotlib would read a dollar as mathematics."""
    return text.replace("$", r"\$")


def _colour(study: Study, method: str) -> str:
    order = (study.plan.baseline, *study.plan.contenders)
    return COLOURS[order.index(method) % len(COLOURS)]


def _curves(axes: Any, study: Study, scenario: int, metric: PaperMetric) -> None:
    """Medians over the runs, smoothed as on the page, with the middle half as a band."""
    for method in (study.plan.baseline, *study.plan.contenders):
        curve = curve_of(study.plan, study.records, scenario, method, metric.field)
        x, colour = np.arange(1, curve.values.shape[1] + 1), _colour(study, method)
        axes.fill_between(x, *curve.band(), color=colour, alpha=0.2, linewidth=0)
        axes.plot(x, np.maximum(smoothed(curve.median), 0.0), color=colour, linewidth=1.3, label=method_name(method))
    axes.set_ylim(bottom=0)
    axes.set_xlabel("generation")
    axes.set_ylabel(f"{metric.name} [{metric.unit}]" if metric.unit else metric.name)


def _boxes(axes: Any, study: Study, rows: tuple[Comparison, ...], scenario: int, measure: Measure) -> None:
    """The runs of each method; stars of Holm's p above those that differ from the baseline."""
    order = (study.plan.baseline, *study.plan.contenders)
    values = [sample(study.records, scenario, method, measure) for method in order]
    drawn = axes.boxplot(values, widths=0.55, patch_artist=True, medianprops={"color": "black"}, flierprops={"ms": 2})
    for box, method in zip(drawn["boxes"], order, strict=True):
        box.set(facecolor=_colour(study, method), alpha=0.6, linewidth=0.6)
    name = study.plan.subjects[scenario].name
    stars = {row.method: row.marks for row in rows if row.scenario == name and row.measure is measure}
    labels = [f"{method_name(method)} {stars.get(method, '')}".strip() for method in order]
    axes.set_xticks(range(1, len(order) + 1), map(_text, labels), rotation=0 if len(order) < 4 else 40)
    axes.set_ylabel(_text(f"{measure.name} [{measure.unit}]" if measure.unit else measure.name))
