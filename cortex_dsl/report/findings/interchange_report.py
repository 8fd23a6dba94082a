"""Findings on an imported recording, on the lines of its road, and on the files of an export."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from cortex_dsl.report.findings.run_report import PARTS, events_content, metrics_content, pairs_content
from cortex_dsl.report.findings.story import Moment, end_of, story_of
from engine.interchange.measuring import Measured
from engine.interchange.recording import Recording
from engine.opendrive.roads import OdrNetwork, OdrRoad
from engine.program import Rule
from engine.road.outline import Outline
from engine.tables import Floats, Ints
from engine.vocabulary import EndReason

if TYPE_CHECKING:
    from engine.errors import InterchangeError
    from engine.interchange.contract import ExportOptions

APART = 2.0
"""Between two points of a line [m]."""
MOST_POINTS = 5_000
"""Maximum number of points of all roads together; larger maps are drawn coarser."""
THROUGH = "-1"
"""The junction of a road that is none's."""


def road_outline(road: OdrNetwork | None) -> Outline:
    """Kerbs and middle lines of all roads between junctions; nothing where there is no road."""
    roads = [] if road is None else [each for each in road.roads.values() if each.junction == THROUGH]
    apart = max(APART, sum(each.length for each in roads) / MOST_POINTS)
    lines = [_lines(each, np.linspace(0.0, each.length, max(2, round(each.length / apart) + 1))) for each in roads]
    return Outline(
        kerbs=tuple(kerb for kerbs, _ in lines for kerb in kerbs),
        middle_lines=tuple(middle for _, middle in lines),
        lane_lines=(),
        stop_lines=(),
        areas=(),
        center_lines=(),
    )


def _lines(road: OdrRoad, distances: Floats) -> tuple[tuple[Floats, Floats], Floats]:
    """The two edges of a road, and its reference line."""
    edges = np.array([_edges(road, s) for s in distances.tolist()]).reshape(-1, 3, 2)
    return (edges[:, 0], edges[:, 1]), edges[:, 2]


def _edges(road: OdrRoad, s: float) -> list[tuple[float, float]]:
    """Right edge, left edge, reference line."""
    shifts = list(_shifts(road, s))
    poses = [road.reference(s).moved(0.0, shift) for shift in (min(shifts), max(shifts), 0.0)]
    return [(pose.x, pose.y) for pose in poses]


def _shifts(road: OdrRoad, s: float) -> Iterator[float]:
    """Yield 0, and the offsets of the edges of each driving lane to the left of the reference line [m]."""
    yield 0.0
    section, center = road.section(s), road.center(0, s)
    for lane, row in section.lanes.items():
        if lane and row.type == "driving":
            yield from (center + edge for edge in section.edges(lane, s))


# -- a recording from elsewhere ----------------------------------------------------------------------------------------

LONGEST_TITLE = 100
LONGEST_NAME = 40
"""Letters; files of other tools may say anything of themselves."""


@dataclass(frozen=True)
class MeasuredReport:
    """Everything there is to say."""

    file: str
    recording: Recording
    measured: Measured
    profile: str
    remarks: Sequence[str]
    road: "OdrNetwork | None"
    lines: Outline
    """Lines of that road."""
    again: str
    """The command that shows this again."""
    written: Sequence[str] = ()
    """Files that it was turned into."""

    @property
    def cast(self) -> "Cast":
        return Cast(tuple(one_line(actor.name, LONGEST_NAME) for actor in self.recording.actors))

    @property
    def pair(self) -> int:
        """The pair (ego, pair + 1) that decides the risk; 0 where there is none."""
        return max(0, int(self.measured.risk.pair[0]))

    @property
    def paired(self) -> bool:
        return len(self.recording.actors) > 1


@dataclass(frozen=True)
class Cast:
    """The actors that take part; a recording has no rules."""

    actors: tuple[str, ...]
    rules: tuple[Rule, ...] = ()

    @property
    def step_lines(self) -> Ints:
        return np.zeros(0, dtype=np.int32)

    def place(self, line: int) -> str:
        return str(line)


def one_line(text: str, most: int = LONGEST_TITLE) -> str:
    """Return a text from another tool's file on one line."""
    line = " ".join("".join(mark if mark.isprintable() else " " for mark in text).split())
    return line if len(line) <= most else line[: most - 1] + "…"


def recorded_story(report: MeasuredReport) -> list[Moment]:
    """Return the events up to contact or to the end of the recording."""
    moments = story_of(report.cast, report.measured.outcomes, report.measured.trajectory, pair=report.pair)
    return [replace(moment, text=recorded_end(report)) if moment.kind == "end" else moment for moment in moments]


def recorded_end(report: MeasuredReport) -> str:
    """Return the reason of the end: a recording has no time limits."""
    if report.measured.outcomes.end_reason[0] not in (EndReason.COLLISION, EndReason.BUILDING):
        return "the recording ends"
    came_in = "; one came in on the other, and nothing led to it" if report.measured.sudden else ""
    return end_of(report.cast, report.measured.outcomes, 0).text + came_in


def measured_content(report: MeasuredReport) -> dict[str, Any]:
    """Return the report as the content of a JSON document, SI units."""
    recording, measured, actors = report.recording, report.measured, report.cast.actors
    outcomes, risk = measured.outcomes, measured.risk
    return {
        "file": report.file,
        "actors": [
            {"name": name, "kind": a.kind, "length": a.length, "width": a.width, "rear_to_center": a.rear_to_center}
            for name, a in zip(actors, recording.actors, strict=True)
        ],
        "samples": len(recording),
        "step": recording.step,
        "end": {"reason": EndReason(int(outcomes.end_reason[0])), "time": outcomes.end_time[0]},
        "collided": outcomes.collided[0],
        "contact": [actors[actor] for actor in outcomes.contact_actors[0].tolist() if actor >= 0],
        "pairs": pairs_content(actors, outcomes),
        "risk": {
            "profile": report.profile,
            "score": risk.score[0] if report.paired else None,
            "parts": dict(zip((name for name, _, _ in PARTS), risk.parts[0].tolist(), strict=True)),
        },
        "events": events_content(actors, recorded_story(report)),
        "metrics": metrics_content(actors, measured.metrics),
        "road": None if report.road is None else {"file": report.road.file, "summary": report.road.summary()},
        "provenance": recording.provenance,
        "remarks": report.remarks,
        "written": report.written,
        "reproduce": report.again,
    }


# -- an export ---------------------------------------------------------------------------------------------------------


class Exported(Protocol):
    """A case that was exported: see `cortex_dsl.interchange.cases`."""

    @property
    def recording(self) -> Recording: ...
    @property
    def rank(self) -> int | None: ...


class Gathered(Protocol):
    """All files of an export with their remarks: see `cortex_dsl.interchange.formats`."""

    @property
    def files(self) -> Mapping[str, bytes]: ...
    @property
    def formats(self) -> Mapping[str, str]: ...
    @property
    def names(self) -> Sequence[Sequence[str]]: ...
    @property
    def remarks(self) -> Mapping[tuple[str, str], Sequence[int]]: ...
    @property
    def refused(self) -> "Mapping[str, InterchangeError]": ...


class Finding(Protocol):
    """One error of a written file: place, reason, and cure."""

    @property
    def place(self) -> str: ...
    @property
    def reason(self) -> str: ...
    @property
    def cure(self) -> str: ...


class Certificate(Protocol):
    """Result of a player for a file: as JSON, and in one line."""

    @property
    def file(self) -> str: ...
    @property
    def content(self) -> Mapping[str, Any]: ...
    @property
    def line(self) -> str: ...
    @property
    def findings(self) -> Sequence[Finding]: ...


@dataclass(frozen=True)
class Written:
    """Everything that the view of an export shows."""

    cases: Sequence[Exported]
    gathered: Gathered
    folder: Path
    same: frozenset[str]
    """Names of files that were there already with the same contents."""
    findings: Sequence[Finding] | None
    """Findings of the check; None: not requested."""
    checked: Mapping[str, str] = field(default_factory=dict)
    """Scope of the check, by format."""
    opened: Mapping[str, str] = field(default_factory=dict)
    """Command that opens a file, by format; `{file}` stands for its path."""
    certificates: Sequence[Certificate] = ()
    """Results of another player for a case's file."""


def size_text(size: int) -> str:
    """`812 B`, `12.3 kB`, `4.5 MB`."""
    if size < 1_000:
        return f"{size} B"
    return f"{size / 1e3:.1f} kB" if size < 1e6 else f"{size / 1e6:.1f} MB"


def export_content(written: Written, how: "ExportOptions") -> dict[str, Any]:
    """All of it as the content of a document."""
    gathered = written.gathered
    return {
        "folder": written.folder,
        **asdict(how),
        "files": [
            {
                "path": written.folder / name,
                "format": gathered.formats[name],
                "bytes": len(data),
                "new": name not in written.same,
            }
            for name, data in gathered.files.items()
        ],
        "cases": [
            {"rank": case.rank, "name": case.recording.name, "files": names, **asdict(case.recording.provenance)}
            for case, names in zip(written.cases, gathered.names, strict=True)
        ],
        "remarks": [
            {"format": name, "remark": sentence, "cases": [written.cases[number].recording.name for number in numbers]}
            for (name, sentence), numbers in gathered.remarks.items()
        ],
        "refused": [
            {"format": name, "message": error.message, "help": error.cure or None}
            for name, error in gathered.refused.items()
        ],
        "certificates": [certificate.content for certificate in written.certificates],
        "checked": written.checked,
        "findings": None if written.findings is None else [_finding_content(each) for each in written.findings],
    }


def _finding_content(finding: Finding) -> dict[str, str]:
    return {"place": finding.place, "reason": finding.reason, "cure": finding.cure}
