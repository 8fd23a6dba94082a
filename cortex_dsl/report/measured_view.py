"""A recording from elsewhere, judged and told as a run of ours is."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.layout import columns, heading, left, right, section
from cortex_dsl.report.measures_view import measures_view
from cortex_dsl.report.numbers import counted, fixed
from cortex_dsl.report.risk_view import metrics_view, risk_view
from cortex_dsl.report.road_lines import LONGEST_TITLE, MeasuredReport, _end, shortened, story
from cortex_dsl.report.run_view import moment_of
from cortex_dsl.report.scene_view import scene_view
from cortex_dsl.report.theme import actor_style
from cortex_dsl.report.timeline import curves, timeline
from engine.interchange.recording import Recording
from engine.risk import PROFILES

if TYPE_CHECKING:
    pass

DEFINITIONS = (
    ("TTC", "time until the outlines touch if both keep their velocities at that instant"),
    ("DRAC", "the steady braking that would just avoid contact then"),
    ("MS", "how fast the centres come nearer, at most; D_MS is the distance of the outlines then"),
    ("TTC_MS", "D_MS / MS, no TTC in the sense above"),
)
"""Metrics that other tools give the same names and other definitions."""
OTHERS = "other tools take centres, lanes or the worst braking instead, and come to other numbers"
MOST_REMARKS = 12


def measured_view(report: MeasuredReport, width: int, *, ascii_only: bool = False) -> RenderableType:
    """The whole report, `width` columns wide."""
    measured, actors = report.measured, report.cast.actors
    outcomes, trajectory, pair = measured.outcomes, measured.trajectory, report.pair
    moment = moment_of(outcomes, trajectory, pair)
    drawing = scene_view(report.lines, actors, trajectory, moment, width - 2, ascii_only=ascii_only)
    end = float(outcomes.end_time[0])
    speeds = (
        f"speeds, and the distance between the centres of {actors[0]} and {actors[pair + 1]}" if report.paired else ""
    )
    parts: list[RenderableType] = [
        heading(shortened(report.recording.name), shortened(report.recording.provenance.title)),
        _headline(report),
        section("Scene", drawing, _size(report.recording)),
        section("What happened", timeline(story(report), actors), f"as recorded in {report.file}"),
        section("Over time", curves(trajectory, actors, end, pair, width), speeds or "speed"),
        *_judgement(report, ascii_only=ascii_only),
    ]
    if facts := report.recording.provenance.facts:
        rows = [(Text(name, "quiet"), Text(shortened(value, 2 * LONGEST_TITLE))) for name, value in facts.items()]
        parts.append(section("It says of itself", columns(left(), left(wrap=True), rows=rows)))
    if genome := report.recording.provenance.genome:
        rows = [(Text(name, "quiet"), Text(shortened(value, 2 * LONGEST_TITLE))) for name, value in genome.items()]
        parts.append(section("Its params", columns(left(), left(wrap=True), rows=rows)))
    if report.road is not None:
        parts.append(section("Road", Text(report.road.summary()), report.road.file))
    if report.remarks:
        parts.append(section("Taken for granted, or left out", _remarks(report.remarks)))
    if report.written:
        parts.append(section("Written", Text("\n").join(map(Text, report.written))))
    return Group(*parts, section("Again", Text(report.again)))


def _headline(report: MeasuredReport) -> Text:
    touched = int(report.measured.outcomes.contact_actors[0, 0]) >= 0
    end = float(report.measured.outcomes.end_time[0])
    if not report.paired:
        return Text(f"no contact: {report.cast.actors[0]} is alone, there is nobody to measure against", "warn")
    judged = f"  risk {int(report.measured.risk.score[0])} of 22"
    what = _end(report) if touched else "no contact"
    return Text.assemble((what, "bad" if touched else "good"), (f"  after {end:.2f} s", "quiet"), (judged, "title"))


def _size(recording: Recording) -> str:
    """`2 actors, 120 samples over 5.95 s, measured every 0.05 s`."""
    span = fixed(float(recording.time[-1] - recording.time[0]), 2)
    actors, samples = counted(len(recording.actors), "actor"), counted(len(recording), "sample")
    return f"{actors}, {samples} over {span} s, measured every {recording.step:.6g} s"


def _judgement(report: MeasuredReport, *, ascii_only: bool) -> list[RenderableType]:
    """Metrics and risk of the deciding pair, and what their names mean here."""
    measured, actors = report.measured, report.cast.actors
    measures = measures_view(measured.metrics, actors, report.pair)
    if not report.paired:
        return [section("Measures", measures)] if measured.metrics else []
    parts = measured.risk.parts[0].tolist()
    risk = risk_view(int(measured.risk.score[0]), parts, PROFILES[report.profile], ascii_only=ascii_only)
    names = f"{actors[0]} and {actors[report.pair + 1]}"
    meanings = columns(left(), left(wrap=True), rows=[(Text(name, "title"), Text(text)) for name, text in DEFINITIONS])
    return [
        section("Metrics", metrics_view(measured.outcomes, 0, report.pair), names),
        section("Risk", risk, f"profile {report.profile}"),
        *_other_pairs(report),
        section("Other measures", measures, "beside the risk; ∞: no such danger"),
        section("Definitions", Group(meanings, Text(OTHERS, "quiet"))),
    ]


def _other_pairs(report: MeasuredReport) -> list[RenderableType]:
    """MD, D_MS and TTC_MS of all pairs, where there are several."""
    outcomes, actors = report.measured.outcomes, report.cast.actors
    if len(actors) < 3:
        return []
    nearest = np.argsort(outcomes.min_distance[0], kind="stable")[:MOST_REMARKS].tolist()
    values = (outcomes.min_distance, outcomes.distance_at_ms, outcomes.ttc_at_ms)
    rows = [
        (Text(actors[pair + 1], actor_style(pair + 1)), *(Text(fixed(float(value[0, pair]), 2)) for value in values))
        for pair in nearest
    ]
    table = columns(left(), right("MD m"), right("D_MS m"), right("TTC_MS s"), rows=rows, header=True)
    shown = "" if len(rows) == len(actors) - 1 else f"the nearest {len(rows)} of {len(actors) - 1:,}"
    return [section(f"{actors[0]} and each other", table, shown)]


def _remarks(remarks: Sequence[str]) -> RenderableType:
    lines = [Text(remark) for remark in remarks[:MOST_REMARKS]]
    if len(remarks) > MOST_REMARKS:
        lines.append(Text(f"and {len(remarks) - MOST_REMARKS:,} more", "quiet"))
    return columns(left(wrap=True), rows=[(line,) for line in lines])
