"""Findings on a recording with every pair assessed: the worst windows, and a table of all windows."""

import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from io import StringIO
from typing import Any

from cortex_dsl.report.findings.interchange_report import LONGEST_NAME, one_line
from engine.interchange.every_pair import RankedWindows
from engine.outcomes import PAIRS
from engine.vocabulary import ActorKind

METRICS = tuple(row for row in PAIRS if row.of_risk)
"""Those that decide the risk: they stand in tables."""


@dataclass(frozen=True)
class RankedReport:
    """Everything there is to say."""

    file: str
    ranked: RankedWindows
    near: float
    profile: str
    top: int
    """How many rows a person is shown."""
    remarks: Sequence[str]
    again: str
    """The command that shows this again."""
    written: Sequence[str] = ()


@dataclass(frozen=True)
class Window:
    """One row of the ranked table, in words and SI numbers."""

    rank: int
    actors: tuple[str, str]
    kinds: tuple[str, str]
    begin: float
    end: float
    contact: bool
    risk: int
    metrics: dict[str, float]
    """Metrics by name, including MD, D_MS, TTC_MS and the time of MD."""
    ttc: float
    ttc_time: float
    after_contact: bool


def windows(ranked: RankedWindows, most: int | None = None) -> Iterator[Window]:
    """The rows from the worst on."""
    for row in range(len(ranked) if most is None else min(most, len(ranked))):
        one, other = (int(actor) for actor in ranked.actors[row])
        yield Window(
            rank=row + 1,
            actors=(one_line(ranked.names[one], LONGEST_NAME), one_line(ranked.names[other], LONGEST_NAME)),
            kinds=(_kind(ranked, one), _kind(ranked, other)),
            begin=float(ranked.begin[row]),
            end=float(ranked.end[row]),
            contact=bool(ranked.outcomes.collided[row]),
            risk=int(ranked.score[row]),
            metrics={
                name: float(getattr(ranked.outcomes, name)[row, 0])
                for name in (*(each.name for each in METRICS), "min_distance_time", "max_closing_speed")
            },
            ttc=float(ranked.ttc[row]),
            ttc_time=float(ranked.ttc_time[row]),
            after_contact=bool(ranked.after_contact[row]),
        )


def _kind(ranked: RankedWindows, actor: int) -> str:
    return ActorKind(int(ranked.kinds[actor])).name.lower()


def ranking_content(report: RankedReport) -> dict[str, Any]:
    """Return the report as the content of a JSON document, SI units."""
    ranked = report.ranked
    return {
        "file": report.file,
        "actors": len(ranked.names),
        "step": ranked.step,
        "near": report.near,
        "profile": report.profile,
        "windows": [vars(window) for window in windows(ranked)],
        "overlapping": ranked.overlapping,
        "remarks": report.remarks,
        "written": report.written,
        "reproduce": report.again,
    }


def ranking_csv(ranked: RankedWindows) -> str:
    """One row a window, the worst first; numbers that do not exist are empty, infinite ones `inf`."""
    out = StringIO()
    writer = csv.writer(out, lineterminator="\n")
    head = ("rank", "one", "other", "one_kind", "other_kind", "begin_s", "end_s", "contact", "risk")
    body: tuple[str, ...] = ()
    for window in windows(ranked):
        if not body:
            body = tuple(window.metrics)
            writer.writerow((*head, *body, "min_ttc", "min_ttc_time", "after_contact"))
        numbers = (*(window.metrics[name] for name in body), window.ttc, window.ttc_time)
        writer.writerow(
            (
                window.rank,
                *window.actors,
                *window.kinds,
                repr(window.begin),
                repr(window.end),
                int(window.contact),
                window.risk,
                *("" if number != number else repr(number) for number in numbers),
                int(window.after_contact),
            )
        )
    return out.getvalue() or ",".join(head) + "\n"
