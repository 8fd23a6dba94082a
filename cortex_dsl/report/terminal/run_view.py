"""Details of one run: its events, its course over time, the metrics, the risk, params and choices."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.findings.choices import made_choices
from cortex_dsl.report.findings.readable import KM_H, SpeedUnit, fixed, format_gene, significant
from cortex_dsl.report.findings.run_report import RunReport
from cortex_dsl.report.findings.story import Moment
from cortex_dsl.report.terminal.measures_view import (
    further_pairs,
    measures_view,
    metrics_view,
    objectives_view,
    records_view,
    risk_view,
)
from cortex_dsl.report.terminal.render import rendered
from cortex_dsl.report.terminal.theme import actor_style, columns, left, right, section, sparkline
from cortex_dsl.report.views.run import timeline as timeline_blocks
from cortex_dsl.semantics.names.linking import FixedParam
from engine.program import ParamSpace, Program
from engine.risk import PROFILES
from engine.scenes import Scenes, Trajectory
from engine.vocabulary import GeneKind, State

# -- the story as a table of moments, and the course of speeds and distance as small curves ----------------------------

APART = "apart"


def timeline(moments: Sequence[Moment], actors: Sequence[str]) -> RenderableType:
    """Return one line per moment: time, actor, event."""
    return rendered(timeline_blocks(moments, actors), 80)


def curves(
    trajectory: Trajectory, actors: Sequence[str], end: float, pair: int, width: int, unit: SpeedUnit = KM_H
) -> RenderableType:
    """Speed of each actor, and how far the centres of the deciding pair are apart, up to the end of the scored run."""
    scored = trajectory.time <= end + 1e-9
    room = max(10, min(48, width - max(map(len, (*actors, APART))) - 26))
    rows = [
        _curve(
            Text(actor, actor_style(index)),
            _present(trajectory, index, unit.per_si * trajectory.states[:, index, State.SPEED])[scored],
            unit.name,
            actor_style(index),
            room,
        )
        for index, actor in enumerate(actors)
        if index < len(trajectory.outlines)
    ]
    if len(actors) > 1:
        apart = _present(trajectory, pair + 1, _centre_distance(trajectory, pair + 1))[scored]
        rows.append(_curve(Text(APART), apart, "m", "warn", room))
    axis = Text(f"{0:.1f} s" + f"{end:.1f} s".rjust(max(0, room - 5)), "quiet")
    return Group(columns(left(), left(), right(), rows=[*rows, (Text(""), axis, Text(""))]))


def _curve(
    name: Text, values: NDArray[np.float64], unit: str, style: str, width: int
) -> tuple[RenderableType, RenderableType, RenderableType]:
    finite = values[np.isfinite(values)]
    extent = f"{fixed(float(finite.min()), 1)} .. {fixed(float(finite.max()), 1)} {unit}" if len(finite) else ""
    stretched = np.interp(np.linspace(0, len(values) - 1, width), np.arange(len(values)), values)
    return name, Text(sparkline(stretched.tolist(), width, low=0.0), style), Text(extent, "quiet")


def _present(trajectory: Trajectory, actor: int, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """NaN where the actor has left the scene."""
    return np.where(trajectory.states[:, actor, State.PRESENT] > 0.5, values, np.nan)


def _centre_distance(trajectory: Trajectory, other: int) -> NDArray[np.float64]:
    between = trajectory.states[:, other, : State.HEADING] - trajectory.states[:, 0, : State.HEADING]
    return np.hypot(between[:, 0], between[:, 1])


# -- params as the file writes them: in its own units, options by their names ------------------------------------------

GAUGE = 21
"""Characters of the gauge that shows where in its range a param lies; odd, so that it has a middle."""


def params_view(space: ParamSpace, genome: Sequence[float], held: Sequence[FixedParam] = ()) -> RenderableType:
    """Every param with its value, its unit, and where in its range it lies; those held fixed at the end."""
    rows = []
    for gene, value in enumerate(genome):
        rows.append(
            (
                Text(space.names[gene]),
                Text(format_gene(space, gene, float(value))),
                Text(space.units[gene], "unit"),
                _gauge(space, gene, float(value)),
            )
        )
    rows += [(Text(one.name), Text(one.text), Text(one.unit, "unit"), Text("held", "quiet")) for one in held]
    return columns(left(), right(), left(), left(), rows=rows)


def _gauge(space: ParamSpace, gene: int, value: float) -> Text:
    if space.kinds[gene] == GeneKind.INDEX:
        return Text(f"of {', '.join(space.options[gene])}", "quiet")
    low, high = float(space.low[gene]), float(space.high[gene])
    share = (value - low) / (high - low) if high > low else 0.5
    at = max(0, min(GAUGE - 1, round(share * (GAUGE - 1))))
    return Text.assemble(
        (f"{significant(low):>6} ├" + "─" * at, "quiet"),
        ("●", "bar"),
        ("─" * (GAUGE - 1 - at) + f"┤ {significant(high)}", "quiet"),
    )


# -- the details of a run ----------------------------------------------------------------------------------------------


def run_details(report: RunReport, width: int, *, ascii_only: bool = False) -> RenderableType:
    """Return the details of a run for `--metrics`."""
    program = report.program
    courses = curves(
        report.trajectory, program.actors, float(report.outcomes.end_time[0]), report.pair, width, report.unit
    )
    parts: list[RenderableType] = [
        section("All events", timeline(report.story, program.actors)),
        section("Over time", courses, _curves_note(report)),
    ]
    if report.objective_results:
        parts.append(
            section("All objectives", objectives_view(report.objective_results), "above 0 an expectation is kept")
        )
    if report.records:
        parts.append(section("All records", records_view(report.records, width), "up to contact or the end"))
    parts += _judgement(report, ascii_only=ascii_only) if report.valid else []
    if len(program.space) or report.held:
        parts.append(section("All params", params_view(program.space, report.scenes.genomes[0], report.held)))
    if (choices := choices_view(program, report.scenes)) is not None:
        parts.append(section("Choices", choices))
    return Group(*parts)


def _judgement(report: RunReport, *, ascii_only: bool) -> list[RenderableType]:
    """Return metrics and risk, of the deciding pair if there is one."""
    parts: list[RenderableType] = []
    actors = report.program.actors
    if report.outcomes.min_distance.shape[1]:
        names = f"{actors[0]} and {actors[report.pair + 1]}"
        parts.append(section("Metrics", metrics_view(report.outcomes, 0, report.pair, report.unit), names))
        risk = risk_view(report.score, report.parts, PROFILES[report.profile], ascii_only=ascii_only)
        parts.append(section("Risk", risk, f"profile {report.profile}"))
        parts += further_pairs(report.outcomes, actors, report.pair, report.unit)
    measures = measures_view(report.metrics, actors, report.pair, report.unit)
    return [*parts, section("Other measures", measures, "not part of the risk")]


def choices_view(program: Program, scenes: Scenes) -> RenderableType | None:
    """Return the random finite choices of row 0; None without any."""
    rows = [(Text(name), Text(option)) for name, option in made_choices(program, scenes)]
    return columns(left(), left(wrap=True), rows=rows) if rows else None


def _curves_note(report: RunReport) -> str:
    """Return a note on the pair of the curve: the distance is that of centres, unlike the metrics' outlines."""
    actors = report.program.actors
    if len(actors) < 2:
        return "speed"
    return f"speeds, and the distance between the centres of {actors[0]} and {actors[report.pair + 1]}"
