"""Figures for papers as SVG, PNG and PDF, of a run and of a study.

Of a run the course of the metrics, where it failed, and its worst cases; of a study, with a panel for each scenario,
the curves of the five metrics and box plots of the measures.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cortex_dsl.report.findings.analysis_report import HeatMap, heat_maps
from cortex_dsl.report.findings.case_replay import CaseReplay, StoredRun, colour, outline_corners, replay_of_case
from cortex_dsl.report.findings.failures import finds_of
from cortex_dsl.report.findings.framing import Frame, alike
from cortex_dsl.report.findings.paper_metrics import METRICS, PaperMetric
from cortex_dsl.report.findings.search_report import method_name
from cortex_dsl.report.findings.study_report import (
    BOXED,
    generation_values,
    in_layout_of_paper,
    measure_called,
)
from cortex_dsl.report.page.film import ACTORS, ASPHALT, BUILDING, HOT, KERB, PARKED, SIGNALS, STRIPS
from engine.extras import needed
from engine.search.journal_reader import Record
from engine.study.comparisons import Comparison, Measure, compare_all, sample
from engine.study.database import Study
from engine.study.run_records import curve_of, smoothed
from engine.study.verdict import METHODS, findings
from engine.tables import Floats
from engine.vocabulary import State

FORMATS = ("svg", "png", "pdf")
CASES = 3
COLUMN, PAGE = 3.6, 7.2
"""Width of a printed column, and of two columns [inches]."""
STYLE = {
    "font.size": 8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.6,
    "svg.fonttype": "none",
    "svg.hashsalt": "cortexc",
    "savefig.bbox": "tight",
    "savefig.dpi": 200,
}
COOL, QUIET = "#0b6bb0", "#5c6570"


def write_figures(run: StoredRun, folder: Path) -> list[Path]:
    """Write all figures in all formats; their paths.

    Raises:
        MissingExtraError: matplotlib is not installed.
        OSError: a file cannot be written.
    """
    return save_all(_run_figures(run), folder)


def save_all(figures: Iterable[tuple[str, Any]], folder: Path) -> list[Path]:
    """Save each figure by its name, in all formats and in our style, as they come; their paths."""
    matplotlib = needed("matplotlib", "figures need", "report")
    needed("matplotlib.backends.backend_agg", "figures need", "report")
    with matplotlib.rc_context(STYLE):
        return [path for name, figure in figures for path in _save(figure, folder, name)]


def _save(figure: Any, folder: Path, name: str) -> Iterator[Path]:
    for ending in FORMATS:
        path = folder / f"{name}.{ending}"
        dated = {"Date": None} if ending == "svg" else {"CreationDate": None} if ending == "pdf" else None
        figure.savefig(path, metadata=dated)
        yield path


def new_figure(width: float, height: float) -> Any:
    """Return a figure of this size [inches] without pyplot, whose windows would stay open."""
    return needed("matplotlib.figure", "figures need", "report").Figure(figsize=(width, height), layout="constrained")


def _run_figures(run: StoredRun) -> Iterator[tuple[str, Any]]:
    yield "course", _course(run.record)
    for number, found in enumerate(heat_maps(run.record.manifest.parameters, run.record.evaluations), start=1):
        yield f"params-{number}", _heat(found, finds_of(run.record.manifest.objective).many)
    cases = run.first_cases(CASES)
    replays = [replay_of_case(run, case) for case in cases]
    for case, replay, frame in zip(cases, replays, alike([replay.frame for replay in replays]), strict=True):
        yield f"case-{case.rank}", _scene(replay, frame)


def _course(record: Record) -> Any:
    """The five metrics over the generations."""
    figure = new_figure(7.2, 3.6)
    x = np.arange(1, len(record.generations) + 1)
    for axes, metric in zip(figure.subplots(2, 3).flat, METRICS, strict=False):
        y = [getattr(row.by_individual, metric.field) for row in record.generations]
        axes.plot(x, y, color=COOL, linewidth=1.4)
        axes.set_title(metric.name, loc="left", fontweight="bold")
        axes.set_ylabel(metric.unit or "")
        axes.set_ylim(bottom=0)
        axes.set_xlabel("generation")
    figure.axes[5].set_axis_off()
    return figure


def _heat(found: HeatMap, many: str) -> Any:
    """Return the share of collisions, or of results of another objective, in each cell."""
    figure = new_figure(3.4, 2.9)
    axes = figure.subplots()
    share = np.where(found.tried > 0, found.failed / np.maximum(found.tried, 1), np.nan)
    axes.set_facecolor("#e4e4df")  # never tried
    mesh = axes.pcolormesh(found.across.edges, found.up.edges, share.T, cmap="Oranges", vmin=0.0, vmax=1.0)
    axes.set_xlabel(_label(found.across.name, found.across.unit))
    axes.set_ylabel(_label(found.up.name, found.up.unit))
    figure.colorbar(mesh, label=f"share of {many}")
    return figure


def _label(name: str, unit: str) -> str:
    """Matplotlib would read a dollar as mathematics."""
    return (f"{name} [{unit}]" if unit else name).replace("$", r"\$")


def _scene(replay: CaseReplay, frame: Frame) -> Any:
    """Draw the road from above, ways, and all actors at the key moment; the ego's road lies along the picture."""
    states, width = replay.trajectory.states[replay.key_sample], PAGE if frame.is_band else COLUMN
    figure = new_figure(width, width / frame.shape)
    axes = figure.subplots()
    for ring in replay.road.buildings:
        axes.fill(*frame.turned(ring).T, color=BUILDING, linewidth=0)
    for kind, ring in replay.road.strips:
        axes.fill(*frame.turned(ring).T, color=STRIPS[kind], linewidth=0)
    for ring in replay.road.areas:
        axes.fill(*frame.turned(ring).T, color=ASPHALT, linewidth=0)
    for rings, tint in ((replay.road.stripes, KERB), (replay.road.parked, PARKED)):
        for ring in rings:
            axes.fill(*frame.turned(ring).T, color=tint, linewidth=0)
    for line in replay.road.kerbs:
        axes.plot(*frame.turned(line).T, color=KERB, linewidth=0.8)
    for line in (*replay.road.middle_lines, *replay.road.lane_lines):
        axes.plot(*frame.turned(line).T, color=KERB, linewidth=0.5, linestyle=(0, (6, 6)))
    for each in replay.road.signals:
        tint = SIGNALS[each.colour(replay.key_time)]
        axes.plot(*frame.turned(each.line).T, color=tint, linewidth=1.6, solid_capstyle="butt")
    for actor in reversed(range(len(replay.shapes))):
        tint, shape = ACTORS[colour(actor)], replay.shapes[actor]
        axes.plot(*frame.turned(replay.ways[actor]).T, color=tint, linewidth=0.9, linestyle=":")
        if states[actor, State.PRESENT] > 0.5:
            x, y, heading = (float(v) for v in states[actor, [State.X, State.Y, State.HEADING]])
            corners = frame.turned(np.array(outline_corners(x, y, heading, shape.length, shape.width)))
            axes.fill(*corners.T, color=tint, label=_label(shape.name, ""), zorder=3)
    if replay.contact_point:
        (point,) = frame.turned(np.array([replay.contact_point]))
        axes.plot(*point, marker="x", color=HOT, markersize=7, markeredgewidth=1.6, zorder=4)
    axes.set(xlim=(frame.left, frame.left + frame.width), ylim=(frame.bottom, frame.bottom + frame.height), aspect=1)
    axes.set_axis_off()
    _compass(axes, frame)
    axes.legend(frameon=False, fontsize=7, loc="upper left", ncols=4, reverse=True)
    return figure


def _compass(axes: Any, frame: Frame) -> None:
    """A north arrow and a bar of a round length, at the lower left."""
    size, north = 0.05 * frame.height, math.radians(frame.north_degrees)
    x, y, reach = frame.left + 2.0 * size, frame.bottom + 2.0 * size, 1.4 * size
    tip, tail = ((x + side * math.sin(north), y + side * math.cos(north)) for side in (reach, -reach))
    arrow = {"arrowstyle": "<|-", "color": KERB, "shrinkB": 0}
    axes.annotate("N", tail, tip, fontsize=7, color=KERB, ha="center", va="center", arrowprops=arrow)
    left, low = x + 2.4 * size, frame.bottom + size
    axes.plot([left, left + frame.bar], [low, low], color=KERB, linewidth=1.2)
    axes.text(left, low + 0.4 * size, f"{frame.bar} m", fontsize=7, color=KERB)


# -- figures of a study ------------------------------------------------------------------------------------------------

ACROSS = 3
"""Maximum number of panels side by side."""
WIDTH, HEIGHT = 2.5, 2.1
"""Width and height of a panel [inches]."""
COLOURS = ("#8a8f98", "#c8501e", "#0b6bb0", "#2f7d4f", "#7a4fa3", "#b58900")
"""Colours: first the baseline, then the contenders."""
SCENARIOS = ("#0072b2", "#d55e00", "#008f68", "#b0508a", "#8a6d00", "#4a4f55")
"""Colours of the scenarios A to F where one plot has them all."""


def write_study_figures(study: Study, folder: Path) -> list[Path]:
    """Write all figures in all formats; their paths.

    Raises:
        MissingExtraError: matplotlib is not installed.
        OSError: a file cannot be written.
    """
    return save_all(_study_figures(study), folder)


def _study_figures(study: Study) -> Iterator[tuple[str, Any]]:
    rows = compare_all(study.plan, study.records)
    for metric in METRICS:
        yield f"curves-{metric.name.lower()}", _panels(study, lambda axes, k, m=metric: _curves(axes, study, k, m))
    for name in BOXED:
        measure = measure_called(name)
        stem = f"boxes-{name.lower().replace(' ', '-')}"
        yield stem, _panels(study, lambda axes, k, m=measure: _boxes(axes, study, rows, k, m))
    if scenarios := in_layout_of_paper(study, findings(study.plan, study.records)):
        yield "paper-curves", _paper_curves(study, scenarios)
        yield "paper-boxes", _paper_boxes(study, scenarios)


def _panels(study: Study, draw: Callable[[Any, int], None]) -> Any:
    """A figure with a panel for each scenario; the methods are named once, below."""
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
    _name_axes(axes, metric)


def _name_axes(axes: Any, metric: PaperMetric) -> None:
    axes.set_ylim(bottom=0)
    axes.set_xlabel("generation")
    axes.set_ylabel(_metric_label(metric))


def _metric_label(metric: PaperMetric) -> str:
    return f"{metric.name} [{metric.unit}]" if metric.unit else metric.name


def _boxes(axes: Any, study: Study, rows: tuple[Comparison, ...], scenario: int, measure: Measure) -> None:
    """The runs of each method; stars of Holm's p above those that differ from the baseline."""
    order = (study.plan.baseline, *study.plan.contenders)
    _draw_boxes(axes, study, {method: sample(study.records, scenario, method, measure) for method in order})
    name = study.plan.subjects[scenario].name
    stars = {row.method: row.marks for row in rows if row.scenario == name and row.measure is measure}
    labels = [f"{method_name(method)} {stars.get(method, '')}".strip() for method in order]
    axes.set_xticks(range(1, len(order) + 1), map(_text, labels), rotation=0 if len(order) < 4 else 40)
    axes.set_ylabel(_text(f"{measure.name} [{measure.unit}]" if measure.unit else measure.name))


def _draw_boxes(axes: Any, study: Study, values: Mapping[str, Floats]) -> None:
    """Draw a box for each method from its values."""
    drawn = axes.boxplot(
        list(values.values()), widths=0.55, patch_artist=True, medianprops={"color": "black"}, flierprops={"ms": 2}
    )
    for box, method in zip(drawn["boxes"], values, strict=True):
        box.set(facecolor=_colour(study, method), alpha=0.6, linewidth=0.6)


# -- the plots of the paper --------------------------------------------------------------------------------------------


def _paper_curves(study: Study, scenarios: Sequence[int]) -> Any:
    """A panel for each metric with a curve for each scenario and method."""
    figure = new_figure(PAGE, 2.0 * HEIGHT + 0.3)
    panels = figure.subplots(2, ACROSS).flat
    for axes, metric in zip(panels, METRICS, strict=False):
        for tint, number in zip(SCENARIOS, scenarios, strict=False):
            for method, dash in zip(METHODS, ("-", "--"), strict=True):
                y = np.maximum(smoothed(curve_of(study.plan, study.records, number, method, metric.field).median), 0.0)
                name = f"{study.plan.subjects[number].name}, {method_name(method)}"
                axes.plot(np.arange(1, len(y) + 1), y, dash, color=tint, linewidth=1.1, label=_text(name))
        _name_axes(axes, metric)
    figure.axes[-1].set_axis_off()
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False)
    return figure


def _paper_boxes(study: Study, scenarios: Sequence[int]) -> Any:
    """Boxes over the values of the generations: a row for each metric, first all scenarios, then one by one."""
    groups = [("all", scenarios), *((study.plan.subjects[number].name, (number,)) for number in scenarios)]
    figure = new_figure(PAGE, 1.5 * len(METRICS))
    for row, metric in zip(figure.subplots(len(METRICS), len(groups), sharey="row"), METRICS, strict=True):
        for axes, (title, numbers) in zip(row, groups, strict=True):
            values = {method: generation_values(study, numbers, method, metric.field) for method in METHODS}
            _draw_boxes(axes, study, values)
            axes.set_xticks((1, 2), METHODS)
            if metric is METRICS[0]:
                axes.set_title(_text(title), loc="left", fontsize=7)
        row[0].set_ylabel(_metric_label(metric))
    return figure
