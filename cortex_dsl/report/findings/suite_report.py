"""Result of `cortexc suite`: a row for each cell, points for each group. Data, tables and the JSON document only."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING, Any

from engine.display import counted
from engine.gates.ratings import EXTENDED, STANDARD, VERIFIED, Colour, extended_points, standard_points
from engine.references import OUT_OF_RANGE
from engine.vocabulary import Answer

if TYPE_CHECKING:
    from cortex_dsl.diagnostics import CompileError, Diagnostic
    from cortex_dsl.source import Source


class Outcome(StrEnum):
    """Outcome of a cell."""

    PASS = "pass"  # noqa: S105 - no password
    FAIL = "FAIL"
    ERROR = "error"
    """The driver failed."""
    NOT_RUN = "not run"


RUN = (Outcome.PASS, Outcome.FAIL)
"""Outcomes of cells with a verdict."""
ANSWERS = {Answer.AVOIDS: "avoids", Answer.COLLIDES: "collides", Answer.STRUCK: "struck", **OUT_OF_RANGE}


@dataclass(frozen=True)
class Deviation:
    """The least deviation found at which a cell fails."""

    size: float
    """Largest share of a tolerance that it uses; 0: the nominal test fails."""
    params: Mapping[str, float]
    """Deviations by param, in units of the tolerance."""
    colour: Colour
    impact: float
    """Impact speed [km/h]; NaN without contact."""
    event: str
    case: str = ""
    """File of the run below the folder of the results; "" without one."""
    replay: str = ""


@dataclass(frozen=True)
class SearchedRange:
    """Result of a search in ranges of params."""

    runs: int
    failures: int
    ranges: Mapping[str, tuple[float, float]]
    """The largest range of each param in which no failure was found; the whole one if there was none."""
    units: Mapping[str, str]


@dataclass(frozen=True)
class CellResult:
    """A cell with all that is known about it."""

    id: str
    group: str
    range: str
    params: Mapping[str, Any]
    rule: str
    limit: float
    source: str
    status: str
    outcome: Outcome
    reason: str = ""
    """Reason of `not run` or `error`."""
    colour: Colour | None = None
    contact: bool = False
    impact: float = float("nan")
    """Impact speed of the nominal run [km/h]; NaN without contact."""
    event: str = ""
    """End of the nominal run in words."""
    runs: int = 0
    """Runs whose deviations are uniform in the tolerances."""
    failures: int = 0
    low: float = float("nan")
    high: float = float("nan")
    """Interval of the probability of a failure at 95 %, of Clopper and Pearson."""
    deviation: Deviation | None = None
    deviation_runs: int = 0
    """Runs of the search for it."""
    searched: SearchedRange | None = None
    simulations: int = 0
    """All runs of the cell, but those of reference drivers."""
    references: Mapping[str, Mapping[Answer, int]] = field(default_factory=dict)
    """How often each reference driver gave each answer to a collision of an ego that keeps its speed: once, or up to
    once for each run of a search; {} without a collision.
    """

    @property
    def probability(self) -> float:
        return self.failures / self.runs if self.runs else float("nan")

    @property
    def said(self) -> dict[str, str]:
        """Return the answers of each reference driver in words."""
        return answer_texts(self.references)


def answer_texts(references: Mapping[str, Mapping[Answer, int]]) -> dict[str, str]:
    """Return the answers of each reference driver in words."""
    return {name: _said(counts) for name, counts in references.items()}


def _said(counts: Mapping[Answer, int]) -> str:
    """Return the answer to one collision, or the number of collisions that a driver avoids of those in its range."""
    avoided, rest = (counts.get(answer, 0) for answer in (Answer.AVOIDS, Answer.COLLIDES))
    if avoided + rest and sum(counts.values()) > 1:
        return f"avoids {avoided:,} of {avoided + rest:,}"
    return "; ".join(ANSWERS[answer] for answer in counts)


@dataclass(frozen=True)
class GroupResult:
    """Cells of one scenario."""

    name: str
    cells: tuple[CellResult, ...]
    points: Mapping[str, float] = field(default_factory=dict)
    file: str = ""
    digest: str = ""
    runs: int = 0
    seconds: float = 0.0
    refusal: str = ""
    """Reason why the driver cannot drive in the file."""
    error: "CompileError | None" = None
    source: "Source | None" = None
    diagnostics: "tuple[Diagnostic, ...]" = ()
    files: Mapping[str, bytes] = field(default_factory=dict)
    """Kept cases by their places below the folder of the results."""
    repeated: int = 0
    """Cells whose nominal test was driven twice."""
    otherwise: tuple[str, ...] = ()
    """Cells among them that the driver drove otherwise the second time."""

    @property
    def trouble(self) -> str:
        """Return the reason why no cell could be run; "" without one."""
        return self.refusal or ("" if self.error is None else self.error.message)

    def score(self, range_: str) -> float | None:
        """Return the points of a range; a cell that is not run counts as red. None: no cell of it, or no points."""
        found = [cell.colour or Colour.RED for cell in self.cells if cell.range == range_]
        if range_ not in self.points or not found:
            return None
        return (standard_points if range_ == STANDARD else extended_points)(found, self.points[range_])


@dataclass(frozen=True)
class SuiteReport:
    """All groups of a suite."""

    suite: str
    title: str
    edition: str
    notes: tuple[str, ...]
    driver: str
    groups: tuple[GroupResult, ...]
    seed: int
    budget: str
    command: str
    timed: bool = False
    entry: tuple[str, ...] = ()
    """Cells of the entry conditions that are run and not green."""
    not_done: int = 0
    """Groups that did not run because of an interruption."""
    seconds: float = 0.0
    limit: float = float("inf")
    """Budget of time [s]."""

    @property
    def remarks(self) -> tuple[str, ...]:
        """Return remarks on the verdicts: a driver that is not deterministic, an overrun budget."""
        found: list[str] = []
        if names := [name for group in self.groups for name in group.otherwise]:
            tests = counted(sum(group.repeated for group in self.groups), "nominal test")
            shown = ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
            found.append(
                f"the driver is not deterministic: it drives {len(names):,} of {tests} otherwise the second time "
                f"({shown}); a cell fails if one of both does"
            )
        if self.seconds > self.limit:
            found.append(
                f"the suite took {self.seconds:.0f} s, more than --budget {self.budget}: the budget limits the runs "
                "within the tolerances; nominal tests, reference drivers and the first runs of a cell are always made"
            )
        return tuple(found)

    @property
    def cells(self) -> tuple[CellResult, ...]:
        return tuple(cell for group in self.groups for cell in group.cells)

    def count(self, outcome: Outcome) -> int:
        return sum(cell.outcome is outcome for cell in self.cells)

    @property
    def passed(self) -> bool:
        return not (self.has_failure or any(group.trouble for group in self.groups))

    @property
    def has_verdicts(self) -> bool:
        """Return True if a cell was run."""
        return any(cell.outcome is not Outcome.NOT_RUN for cell in self.cells)

    @property
    def has_failure(self) -> bool:
        return any(cell.outcome in (Outcome.FAIL, Outcome.ERROR) for cell in self.cells)

    @property
    def points(self) -> float | None:
        """Points of the groups that are run, 0 if an entry condition is broken; None: the suite has none."""
        scores = [score for group in self.groups for range_ in (STANDARD, EXTENDED) if (score := group.score(range_))]
        if not any(group.points for group in self.groups):
            return None
        return 0.0 if self.entry else sum(scores)

    @property
    def headline(self) -> str:
        counts = [f"{self.count(each)} {each}" for each in Outcome if self.count(each)]
        unverified = sum(cell.status != VERIFIED for cell in self.cells)
        text = f"{counted(len(self.cells), 'cell')}: {', '.join(counts) or 'none'}"
        text += f"; {unverified} of them with unverified values" if unverified else ""
        if self.not_done:
            text += f"; interrupted, {counted(self.not_done, 'group')} not done"
        return text


# -- documents ---------------------------------------------------------------------------------------------------------


def suite_content(report: SuiteReport) -> dict[str, Any]:
    """Return the content of the document."""
    return {
        "suite": report.suite,
        "title": report.title,
        "edition": report.edition,
        "notes": list(report.notes),
        "driver": report.driver,
        "seed": report.seed,
        "budget": report.budget,
        "command": report.command,
        "passed": report.passed,
        "counts": {each.name.lower(): report.count(each) for each in Outcome},
        "points": report.points,
        "broken_entry_conditions": list(report.entry),
        "not_done": report.not_done,
        "remarks": list(report.remarks),
        "groups": [_group_content(group) for group in report.groups],
    }


def _group_content(group: GroupResult) -> dict[str, Any]:
    from cortex_dsl.report.findings.snippet import as_json

    return {
        "name": group.name,
        "file": group.file,
        "digest": group.digest,
        "runs": group.runs,
        "refusal": group.refusal,
        "diagnostics": [] if group.source is None else as_json(group.source, group.diagnostics),
        "points": {range_: group.score(range_) for range_ in group.points},
        "cells": [_cell_content(cell) for cell in group.cells],
    }


def _cell_content(cell: CellResult) -> dict[str, Any]:
    deviation, searched = cell.deviation, cell.searched
    return {
        "id": cell.id,
        "range": cell.range,
        "params": dict(cell.params),
        "rule": cell.rule,
        "limit": cell.limit,
        "source": cell.source,
        "status": cell.status,
        "outcome": cell.outcome.name.lower(),
        "reason": cell.reason,
        "colour": cell.colour,
        "contact": cell.contact,
        "impact_speed": cell.impact,
        "event": cell.event,
        "probability": {
            "runs": cell.runs, "failures": cell.failures, "rate": cell.probability, "low": cell.low, "high": cell.high
        },
        "deviation": None if deviation is None else {
            "size": deviation.size, "params": dict(deviation.params), "colour": deviation.colour,
            "impact_speed": deviation.impact, "event": deviation.event, "case": deviation.case,
            "replay": deviation.replay,
        },
        "deviation_runs": cell.deviation_runs,
        "simulations": cell.simulations,
        "search": None if searched is None else {
            "runs": searched.runs, "failures": searched.failures,
            "without_failure": {name: list(ends) for name, ends in searched.ranges.items()},
            "units": dict(searched.units),
        },
        "references": cell.said,
        "answers": {
            name: {answer.name.lower(): count for answer, count in counts.items()}
            for name, counts in cell.references.items()
        },
    }  # fmt: skip


COLUMNS = (
    "cell", "range", "status", "outcome", "colour", "impact_speed", "rule", "limit", "runs", "failures", "probability",
    "low", "high", "deviation", "case", "reason", "source",
)  # fmt: skip
"""Columns of `cells.csv`, before one for each reference driver."""


def suite_rows(report: SuiteReport) -> Iterator[Sequence[object]]:
    """Yield the lines of `cells.csv`, the head first."""
    names = sorted({name for cell in report.cells for name in cell.references})
    yield (*COLUMNS, *names)
    for cell in report.cells:
        least = cell.deviation
        numbers = (cell.probability, cell.low, cell.high, least.size if least else float("nan"))
        shown = ["" if number != number else number for number in (cell.impact, *numbers)]
        yield (
            cell.id, cell.range, cell.status, cell.outcome.name.lower(), cell.colour or "", shown[0],
            cell.rule, cell.limit, cell.runs, cell.failures, *shown[1:], least.case if least else "",
            cell.reason, cell.source,
            *(cell.said.get(name, "") for name in names),
        )  # fmt: skip
