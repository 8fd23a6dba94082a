"""One run, told: the drawing, the timeline, the metrics, the risk, what was drawn, and how to see it again."""

import numpy as np
from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.layout import columns, left, section
from cortex_dsl.report.measures_view import measures_view
from cortex_dsl.report.numbers import counted
from cortex_dsl.report.pairs_view import further_pairs
from cortex_dsl.report.params import params_view
from cortex_dsl.report.records_view import records_view
from cortex_dsl.report.risk_view import metrics_view, risk_view
from cortex_dsl.report.run_document import RunReport
from cortex_dsl.report.scene_view import KeyMoment, scene_view
from cortex_dsl.report.story import end_of
from cortex_dsl.report.timeline import curves, timeline
from cortex_dsl.report.titles import title_of
from engine.program import Program
from engine.risk import PROFILES
from engine.scenes import Outcomes, Scenes, Trajectory
from engine.vocabulary import State


def run_view(report: RunReport, width: int, *, ascii_only: bool = False) -> RenderableType:
    """The whole report of `cortexc FILE`, `width` columns wide."""
    program, outcomes = report.program, report.outcomes
    drawing = scene_view(
        report.road, program.actors, report.trajectory, key_moment(report), width - 2, ascii_only=ascii_only
    )
    end = float(outcomes.end_time[0])
    courses = curves(report.trajectory, program.actors, end, report.pair, width, report.unit)
    parts: list[RenderableType] = [
        title_of(program),
        _headline(report),
        section("Scene", drawing, _attempts(report.scenes)),
        section("What happened", timeline(report.story, program.actors), f"simulated by the {report.engine} engine"),
        section("Over time", courses, _curves_note(report)),
    ]
    if report.records:
        parts.append(section("Records", records_view(report.records, width), "up to contact or the end"))
    parts += _judgement(report, ascii_only=ascii_only) if report.valid else []
    if len(program.space) or report.held:
        parts.append(section("Params", params_view(program.space, report.scenes.genomes[0], report.held)))
    if (choices := choices_view(program, int(report.scenes.variant[0]))) is not None:
        parts.append(section("Choices", choices))
    parts.append(section("Again", Text(report.reproduce), "the same run, bit for bit"))
    return Group(*parts)


def _judgement(report: RunReport, *, ascii_only: bool) -> list[RenderableType]:
    """Metrics and risk, of the deciding pair where there is one."""
    parts: list[RenderableType] = []
    actors = report.program.actors
    if report.outcomes.min_distance.shape[1]:
        names = f"{actors[0]} and {actors[report.pair + 1]}"
        parts.append(section("Metrics", metrics_view(report.outcomes, 0, report.pair, report.unit), names))
        risk = risk_view(report.score, report.parts, PROFILES[report.profile], ascii_only=ascii_only)
        parts.append(section("Risk", risk, f"profile {report.profile}"))
        parts += further_pairs(report.outcomes, actors, report.pair, report.unit)
    measures = measures_view(report.metrics, actors, report.pair, report.unit)
    return [*parts, section("Other measures", measures, "beside the risk; ∞: no such danger")]


def choices_view(program: Program, variant: int) -> RenderableType | None:
    """What chance chose among finitely many, e.g. lanes and maneuvers; None where there was nothing to choose."""
    if not 0 <= variant < len(program.variants) or not program.variants[variant].choices:
        return None
    rows = [(Text(c.name), Text(c.option)) for c in program.variants[variant].choices]
    return columns(left(), left(wrap=True), rows=rows)


def key_moment(report: RunReport) -> KeyMoment | None:
    """The moment that the drawing shows."""
    return moment_of(report.outcomes, report.trajectory, report.pair)


def moment_of(outcomes: Outcomes, trajectory: Trajectory, pair: int) -> KeyMoment | None:
    """Contact, else the closest approach of the deciding pair: the mark lies between the two outlines' centres."""
    contact = int(outcomes.contact_actors[0, 0]) >= 0
    if not contact and outcomes.min_distance.shape[1] == 0:
        return None
    time = float(outcomes.end_time[0] if contact else outcomes.min_distance_time[0, pair])
    if not np.isfinite(time):
        return None
    first, second = outcomes.contact_actors[0] if contact else (0, pair + 1)
    sample = int(np.argmin(np.abs(trajectory.time - time)))
    centres = trajectory.states[sample, [int(first), int(second)]][:, [State.X, State.Y]]
    x, y = centres.mean(axis=0)
    return KeyMoment(sample, contact, (float(x), float(y)))


def _headline(report: RunReport) -> Text:
    """What it came to, in one line."""
    end = end_of(report.program, report.outcomes, 0)
    judged = report.valid and report.outcomes.min_distance.shape[1]
    return Text.assemble(
        (end.text, "bad" if end.kind == "contact" else "good" if report.valid else "warn"),
        (f"  after {end.time:.2f} s", "quiet"),
        (f"  risk {report.score} of 22", "title") if judged else "",
    )


def _curves_note(report: RunReport) -> str:
    """Which two are apart, and that it is their centres, unlike the metrics' outlines."""
    actors = report.program.actors
    if len(actors) < 2:
        return "speed"
    return f"speeds, and the distance between the centres of {actors[0]} and {actors[report.pair + 1]}"


def _attempts(scenes: Scenes) -> str:
    return f"found after {counted(int(scenes.attempts[0]), 'attempt')}"
