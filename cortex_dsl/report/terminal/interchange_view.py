"""An imported recording, shown like a run of ours, and the files of an export."""

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from shlex import quote
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.findings.interchange_report import (
    LONGEST_TITLE,
    Exported,
    Finding,
    Gathered,
    MeasuredReport,
    Written,
    one_line,
    recorded_end,
    recorded_story,
    size_text,
)
from cortex_dsl.report.findings.readable import counted, fixed
from cortex_dsl.report.findings.story import moment_of
from cortex_dsl.report.terminal.measures_view import measures_view, metrics_view, risk_view
from cortex_dsl.report.terminal.run_view import curves, timeline
from cortex_dsl.report.terminal.scene_view import scene_view
from cortex_dsl.report.terminal.theme import actor_style, columns, heading, indented, left, right, section
from engine.interchange.recording import Recording
from engine.risk import PROFILES

if TYPE_CHECKING:
    from engine.interchange.contract import ExportOptions


DEFINITIONS = (
    ("TTC", "time until the outlines touch if both keep their velocities at that instant"),
    ("DRAC", "the steady braking that would just avoid contact then"),
    ("MS", "how fast the centres come nearer, at most; D_MS is the distance of the outlines then"),
    ("TTC_MS", "D_MS / MS, no TTC in the sense above"),
)
"""Metrics that other tools give the same names and other definitions."""
OTHERS = "other tools use centres, lanes or the hardest braking instead, and get other numbers"
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
        heading(one_line(report.recording.name), one_line(report.recording.provenance.title)),
        _headline(report),
        section("Scene", drawing, _size(report.recording)),
        section("What happened", timeline(recorded_story(report), actors), f"as recorded in {report.file}"),
        section("Over time", curves(trajectory, actors, end, pair, width), speeds or "speed"),
        *_judgement(report, ascii_only=ascii_only),
    ]
    if facts := report.recording.provenance.facts:
        rows = [(Text(name, "quiet"), Text(one_line(value, 2 * LONGEST_TITLE))) for name, value in facts.items()]
        parts.append(section("It says of itself", columns(left(), left(wrap=True), rows=rows)))
    if genome := report.recording.provenance.genome:
        rows = [(Text(name, "quiet"), Text(one_line(value, 2 * LONGEST_TITLE))) for name, value in genome.items()]
        parts.append(section("Its params", columns(left(), left(wrap=True), rows=rows)))
    if report.road is not None:
        parts.append(section("Road", Text(report.road.summary()), report.road.file))
    return Group(*parts, *ending(report.remarks, report.written, report.again))


def ending(remarks: Sequence[str], written: Sequence[str], again: str) -> Iterator[RenderableType]:
    """Yield the last sections of the report on a recording."""
    if remarks:
        yield section("Taken for granted, or left out", remarks_view(remarks))
    if written:
        yield section("Written", Text("\n").join(map(Text, written)))
    yield section("Again", Text(again))


def _headline(report: MeasuredReport) -> Text:
    touched = int(report.measured.outcomes.contact_actors[0, 0]) >= 0
    end = float(report.measured.outcomes.end_time[0])
    if not report.paired:
        return Text(f"no contact: {report.cast.actors[0]} is alone, there is no other actor to measure against", "warn")
    judged = f"  risk {int(report.measured.risk.score[0])} of 22"
    what = recorded_end(report) if touched else "no contact"
    return Text.assemble((what, "bad" if touched else "good"), (f"  after {end:.2f} s", "quiet"), (judged, "title"))


def _size(recording: Recording) -> str:
    """`2 actors, 120 samples over 5.95 s, measured every 0.05 s`."""
    span = fixed(float(recording.time[-1] - recording.time[0]), 2)
    actors, samples = counted(len(recording.actors), "actor"), counted(len(recording), "sample")
    return f"{actors}, {samples} over {span} s, measured every {recording.step:.6g} s"


def _judgement(report: MeasuredReport, *, ascii_only: bool) -> list[RenderableType]:
    """Return metrics and risk of the deciding pair, and the meanings of their names here."""
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
        section("Other measures", measures, "not part of the risk"),
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


def remarks_view(remarks: Sequence[str]) -> RenderableType:
    """The first of them, and how many more there are."""
    lines = [Text(remark) for remark in remarks[:MOST_REMARKS]]
    if len(remarks) > MOST_REMARKS:
        lines.append(Text(f"and {len(remarks) - MOST_REMARKS:,} more", "quiet"))
    return columns(left(wrap=True), rows=[(line,) for line in lines])


# -- files of an export: sizes, commands to open them, limits of the formats, findings of the check --------------------

MOST_FILES = 40
"""Maximum number of files that are shown of a long list."""


def export_view(written: Written, how: "ExportOptions") -> RenderableType:
    """The whole report; `how` the files were written. Print it without cropping: paths and commands are not broken."""
    one = written.cases[0] if len(written.cases) == 1 else None
    title = one.recording.name if one else counted(len(written.cases), "case")
    parts: list[RenderableType] = [heading(title, f"risk {_risk(one)}" if one else "")]
    parts += [Text(), _line(heading(f"{written.folder}{os.sep}", _unchanged(written))), indented(_files(written))]
    parts += [Text(), heading("to open"), *_openings(written)]
    if written.gathered.remarks:
        parts.append(
            section("what these formats leave out or change", _format_remarks(written), note=_version(written, how))
        )
    if written.certificates:
        rows = [(Text(each.file, "title"), Text(each.line)) for each in written.certificates[:MOST_FILES]]
        parts.append(section("played by esmini", columns(left(), left(wrap=True), rows=rows)))
    if written.findings is not None:
        parts.append(_check(written.findings, written.checked))
    return Group(*parts)


def _line(text: Text) -> Text:
    """A text that is copied as a whole, however long."""
    text.no_wrap, text.overflow = True, "ignore"
    return text


def _risk(case: Exported) -> str:
    return case.recording.provenance.facts.get("risk", "")


def _unchanged(written: Written) -> str:
    return "all were there before, the same" if len(written.same) == len(written.gathered.files) else ""


def _version(written: Written, how: "ExportOptions") -> str:
    return f"OpenSCENARIO {how.osc}, {how.mode} mode" if "xosc" in written.gathered.formats.values() else ""


def _files(written: Written) -> RenderableType:
    files = list(written.gathered.files.items())
    rows = [
        (
            Text(name),
            Text(size_text(len(content)), "unit"),
            Text("as it was" if name in written.same else "", "quiet"),
        )
        for name, content in files[:MOST_FILES]
    ]
    if len(files) > MOST_FILES:
        rows.append((Text(f"and {len(files) - MOST_FILES:,} more", "quiet"), Text(), Text()))
    return columns(left(wrap=True), right(), left(), rows=rows)


def _openings(written: Written) -> Iterator[Text]:
    """One line a format, for its first file."""
    first = _first_files(written.gathered)
    width = max(map(len, first), default=0)
    for name, file in first.items():
        command = written.opened[name].format(file=quote(str(written.folder / file)))
        yield _line(Text.assemble(f"  {name:<{width}}  ", command))


def _first_files(gathered: Gathered) -> dict[str, str]:
    """By format, the first of the files that it alone brings, or shares."""
    first: dict[str, str] = {}
    for file, name in gathered.formats.items():
        first.setdefault(name, file)
    return first


def _format_remarks(written: Written) -> RenderableType:
    """Return each remark once, after its format; remarks that differ only in numbers are merged."""
    alike: dict[tuple[str, str], list[tuple[str, Sequence[int]]]] = {}
    for (name, sentence), numbers in sorted(written.gathered.remarks.items(), key=lambda item: item[0][0]):
        key = name, re.sub(r"\d+(\.\d+)?", "#", sentence)
        alike.setdefault(key, []).append((sentence, numbers))
    rows, before = [], ""
    for (name, _), same in alike.items():
        text = Text.assemble(same[0][0], (_of_which(written, [n for _, n in same]), "quiet"))
        rows.append((Text("" if name == before else name, "title"), text))
        before = name
    return columns(left(), left(wrap=True), rows=rows)


def _of_which(written: Written, groups: Sequence[Sequence[int]]) -> str:
    """Which cases a sentence is of, unless it is of all; of several alike it has the numbers of the first."""
    ranks = [str(written.cases[number].rank) for group in groups for number in group]
    if len(groups) > 1:
        return f" (case {ranks[0]}; {counted(len(ranks) - 1, 'other')} likewise)"
    if len(ranks) == len(written.cases):
        return ""
    return f" (case{'' if len(ranks) == 1 else 's'} {', '.join(ranks[:5])}{', …' if len(ranks) > 5 else ''})"


def _check(findings: Sequence[Finding], checked: Mapping[str, str]) -> RenderableType:
    """Return the findings of the check and its scope; no finding proves no more than that scope."""
    rows = [(Text(name, "title"), Text(what, "quiet")) for name, what in checked.items()]
    looked_at = columns(left(), left(wrap=True), rows=rows)
    if not findings:
        return Group(Text(), Text("checked: no finding", "good"), indented(looked_at))
    return section("check", Group(*_findings(findings), Text(), looked_at), note=counted(len(findings), "finding"))


def _findings(findings: Sequence[Finding]) -> Iterator[Text]:
    for finding in findings:
        yield Text.assemble((finding.place, "title"), ": ", (finding.reason, "bad"))
        if finding.cure:
            yield Text(f"  help: {finding.cure}", "quiet")
