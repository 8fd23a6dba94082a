"""The views of `measure`: an imported recording, shown like a run of ours, and every pair of a recording."""

from collections.abc import Iterator, Sequence
from math import isfinite

import numpy as np

from cortex_dsl.report.blocks import (
    Block,
    Column,
    Drawing,
    Facts,
    Note,
    Panel,
    Picture,
    Table,
    Title,
    Value,
    Words,
    actor_style,
)
from cortex_dsl.report.findings.interchange_report import (
    LONGEST_TITLE,
    MeasuredReport,
    one_line,
    recorded_end,
    recorded_story,
)
from cortex_dsl.report.findings.ranking_report import RankedReport, Window, windows
from cortex_dsl.report.findings.readable import counted, fixed
from cortex_dsl.report.findings.story import moment_of
from cortex_dsl.report.views.measures import WRAPS, course, measures_blocks, metrics_table, risk_view
from cortex_dsl.report.views.run import timeline
from engine.interchange.recording import Recording
from engine.tables import Ints

DEFINITIONS = (
    ("TTC", "time until the outlines touch if both keep their velocities at that instant"),
    ("DRAC", "the steady braking that would just avoid contact then"),
    ("MS", "how fast the centres come nearer, at most; D_MS is the distance of the outlines then"),
    ("TTC_MS", "D_MS / MS, no TTC in the sense above"),
)
"""Metrics that other tools give the same names and other definitions."""
OTHERS = "other tools use centres, lanes or the hardest braking instead, and get other numbers"
MOST_REMARKS = 12
NO_KINDS: Ints = np.zeros(0, dtype=np.int32)


def measured_view(report: MeasuredReport) -> Title:
    """Return the view of `cortexc measure`."""
    recording, outcomes, trajectory = report.recording, report.measured.outcomes, report.measured.trajectory
    actors, pair, provenance = report.cast.actors, report.pair, recording.provenance
    moment = moment_of(outcomes, trajectory, pair)
    drawing = Drawing(report.lines, actors, trajectory, moment, pair, NO_KINDS)
    reported = Title("What happened", [timeline(recorded_story(report), actors)], f"as recorded in {report.file}")
    blocks: list[Block] = [
        _headline(report),
        Title("Scene", [Picture([Panel(drawing)])], _size(recording)),
        reported,
        course(trajectory, actors, float(outcomes.end_time[0]), pair, paired=report.paired),
        *_judgement(report),
    ]
    for title, facts in (("It says of itself", provenance.facts), ("Its params", provenance.genome)):
        rows = [(Value(name, "quiet"), one_line(value, 2 * LONGEST_TITLE)) for name, value in facts.items()]
        blocks += [Title(title, [Facts(rows)])] if rows else []
    if report.road is not None:
        blocks.append(Title("Road", [Note(report.road.summary())], report.road.file))
    blocks += _ending(report.remarks, report.written, report.again)
    return Title(one_line(recording.name), blocks, one_line(provenance.title))


def _ending(remarks: Sequence[str], written: Sequence[str], again: str) -> Iterator[Title]:
    """Yield the last parts of the view of a recording."""
    if remarks:
        rest = len(remarks) - MOST_REMARKS
        more = [(Value(f"and {rest:,} more", "quiet"),)] if rest > 0 else []
        table = Table((WRAPS,), [*((remark,) for remark in remarks[:MOST_REMARKS]), *more], header=False)
        yield Title("Taken for granted, or left out", [table])
    if written:
        yield Title("Written", [Note("\n".join(written))])
    yield Title("Again", [Note(again)])


def _headline(report: MeasuredReport) -> Note:
    if not report.paired:
        alone = f"no contact: {report.cast.actors[0]} is alone, there is no other actor to measure against"
        return Note(alone, "warn")
    end, score = float(report.measured.outcomes.end_time[0]), int(report.measured.risk.score[0])
    touched = int(report.measured.outcomes.contact_actors[0, 0]) >= 0
    text = Value(recorded_end(report), "bad") if touched else Value("no contact", "good")
    return Note((text, Value(f"  after {end:.2f} s", "quiet", end), Value(f"  risk {score} of 22", "title", score)))


def _size(recording: Recording) -> str:
    """Return `2 actors, 120 samples over 5.95 s, measured every 0.05 s`."""
    span = fixed(float(recording.time[-1] - recording.time[0]), 2)
    actors, samples = counted(len(recording.actors), "actor"), counted(len(recording), "sample")
    return f"{actors}, {samples} over {span} s, measured every {recording.step:.6g} s"


def _judgement(report: MeasuredReport) -> Iterator[Title]:
    """Yield metrics and risk of the deciding pair, and the meanings of their names here."""
    measured, actors = report.measured, report.cast.actors
    measures = measures_blocks(measured.metrics, actors, report.pair)
    if not report.paired:
        yield from [Title("Measures", measures)] if measured.metrics else []
        return
    names = f"{actors[0]} and {actors[report.pair + 1]}"
    meanings = Facts([(Value(name, "title"), text) for name, text in DEFINITIONS])
    yield Title("Metrics", [metrics_table(measured.outcomes, report.pair)], names)
    yield risk_view(int(measured.risk.score[0]), measured.risk.parts[0].tolist(), report.profile)
    yield from _other_pairs(report)
    yield Title("Other measures", measures, "not part of the risk")
    yield Title("Definitions", [meanings, Note(OTHERS, "quiet")])


def _other_pairs(report: MeasuredReport) -> Iterator[Title]:
    """Yield MD, D_MS and TTC_MS of all pairs if there are several."""
    outcomes, actors = report.measured.outcomes, report.cast.actors
    if len(actors) < 3:
        return
    nearest = np.argsort(outcomes.min_distance[0], kind="stable")[:MOST_REMARKS].tolist()
    values = (outcomes.min_distance, outcomes.distance_at_ms, outcomes.ttc_at_ms)
    rows = [
        (Value(actors[pair + 1], actor_style(pair + 1)), *(fixed(float(value[0, pair]), 2) for value in values))
        for pair in nearest
    ]
    columns = Column(), *(Column(head, numbers=True) for head in ("MD m", "D_MS m", "TTC_MS s"))
    shown = "" if len(rows) == len(actors) - 1 else f"the nearest {len(rows)} of {len(actors) - 1:,}"
    yield Title(f"{actors[0]} and each other", [Table(columns, rows)], shown)


# -- every pair of a recording -----------------------------------------------------------------------------------------

MOST_PAIRS = 5
"""Overlapping pairs that are named."""


def ranking_view(report: RankedReport) -> Title:
    """Return the view of `cortexc measure --pairs all`: the worst windows as a table."""
    ranked, shown = report.ranked, windows(report.ranked, report.top)
    actors, found = counted(len(ranked.names), "actor"), counted(len(ranked), "window")
    apart = f"in which two come nearer than {report.near:g} m, judged every {ranked.step:.6g} s"
    blocks: list[Block] = [Note(f"{actors}; {found} {apart}")]
    if len(ranked):
        heads = (("", True), ("pair", False), *((head, True) for head in ("window", "risk", "MD", "at", "TTC")))
        columns = *(Column(head, numbers=numbers) for head, numbers in heads), WRAPS
        blocks.append(Title("Worst", [Table(columns, [_cells(each) for each in shown])], f"profile {report.profile}"))
    if any(window.after_contact for window in shown):
        blocks.append(Note("  * one of the two had touched a third actor before", "quiet"))
    if ranked.overlapping:
        blocks.append(Title("Set aside", [Note(overlapping_text(report))]))
    return Title(one_line(report.file), [*blocks, *_ending(report.remarks, report.written, report.again)], "every pair")


def overlapping_text(report: RankedReport) -> str:
    """Return the pairs that overlap from the start, and possible reasons."""
    pairs = report.ranked.overlapping
    named = ", ".join(f"{one} and {other}" for one, other in pairs[:MOST_PAIRS])
    more = f" and {len(pairs) - MOST_PAIRS:,} more" if len(pairs) > MOST_PAIRS else ""
    verb = "overlaps" if len(pairs) == 1 else "overlap"
    return f"{counted(len(pairs), 'pair')} {verb} from the start, and nothing led to it: {named}{more}"


def _cells(window: Window) -> Sequence[Words]:
    distance, time = window.metrics["min_distance"], window.metrics["min_distance_time"]
    return (
        Value(f"{window.rank}", "quiet"),
        " and ".join(window.actors),
        f"{fixed(window.begin, 2)} to {fixed(window.end, 2)} s",
        Value(f"{window.risk}", "title", window.risk),
        Value("contact", "bad") if window.contact else f"{fixed(distance, 2)} m",
        f"{fixed(time, 2)} s",
        f"{fixed(window.ttc, 2)} s" if isfinite(window.ttc) else "∞",
        Value(", ".join(window.kinds) + (" *" if window.after_contact else ""), "quiet"),
    )
