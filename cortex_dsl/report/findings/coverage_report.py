"""Result of `cortexc coverage`: a state for each cell, with its proof. Data and the JSON document only."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from itertools import pairwise
from typing import Any

from cortex_dsl.report.findings.readable import significant
from engine.display import counted
from engine.gates.coverage import RULE_OF_THREE
from engine.tables import Floats, Ints

COVERAGE_SCHEMA_VERSION = 1
LEVEL = 0.95
"""Confidence of all intervals."""
INDEPENDENT, TWAY = "independent", "tway"
"""Methods by which scenes are drawn: by successive seeds, or one for each row of a covering array."""


class State(StrEnum):
    """State of a cell."""

    COVERED = "covered"
    """Runs lie in it."""
    RARE = "rare"
    """A directed search reached it, independent draws did not."""
    BLOCKED = "blocked"
    """Scenes exist, but all of their runs ended before the instant of a domain."""
    UNTRIED = "untried"
    """No run lies in it, and nothing is proved."""
    EXCLUDED = "excluded"
    """No scene lies in it, because of requirements."""
    IMPOSSIBLE = "impossible"
    """No scene lies in it, whatever the requirements are."""


REACHED = (State.COVERED, State.RARE)
"""States that count as covered for --require."""
PROVED = (State.EXCLUDED, State.IMPOSSIBLE)
"""States of cells that no scene can have."""


@dataclass(frozen=True)
class DomainInfo:
    """A domain of a file."""

    name: str
    when: str
    text: str
    line: str
    unit: str
    cells: tuple[str, ...]
    ends: tuple[tuple[float, float], ...] = ()
    """Ends of the cells in its unit; () for items that are no numbers."""
    least: float | None = None
    """Least possible value in its unit; None if it is not known."""
    greatest: float | None = None

    @property
    def is_numeric(self) -> bool:
        """Return True if the cells are intervals that follow one another without a gap."""
        meet = all(one[1] == other[0] for one, other in pairwise(self.ends))
        return bool(self.ends) and meet and all(low < high for low, high in self.ends)

    @property
    def range_text(self) -> str:
        """Return bounds of the possible values, as in "0 to 60 km/h"; empty if they are not known."""
        if self.least is None or self.greatest is None:
            return ""
        ends = f"{significant(self.least, 4)} to {significant(self.greatest, 4)} {self.unit}".rstrip()
        return significant(self.least, 4) + f" {self.unit}".rstrip() if self.least == self.greatest else ends


@dataclass(frozen=True)
class DomainTotal:
    """Runs by the cells of one domain."""

    runs: tuple[int, ...]
    """Runs in each cell."""
    below: int = 0
    """Runs with a number below all cells."""
    above: int = 0
    other: int = 0
    """Runs with another value that lies in no cell."""


@dataclass(frozen=True)
class RequirementInfo:
    """A requirement of a proof."""

    name: str
    line: str
    """Line, with the file if it is imported; "" for a built-in requirement."""

    @property
    def text(self) -> str:
        return f"`{self.name}` (line {self.line})" if self.line else self.name


@dataclass(frozen=True)
class Worst:
    """The worst run of a cell."""

    run: int
    seed: int | None
    event: str
    replay: str


@dataclass(frozen=True)
class CellResult:
    """State of one cell, and its proof. Fields without a meaning for the state keep their defaults."""

    domains: tuple[int, ...]
    cells: tuple[int, ...]
    state: State
    runs: int = 0
    """Covered: runs in the cell. Blocked: runs of its scenes."""
    failures: int = 0
    low: float | None = None
    """Interval of the failure rate; None if the runs are no independent draws."""
    high: float | None = None
    worst: Worst | None = None
    requirements: tuple[RequirementInfo, ...] = ()
    """Excluded: a minimal set of requirements that no scene of the cell can meet."""
    culprits: tuple[int, ...] = ()
    """Impossible: domains whose cells exclude each other, or one whose cell lies outside of the possible values."""
    events: tuple[tuple[str, int], ...] = ()
    """Blocked: what ended the runs, and how many, the most frequent first."""
    draws: int = 0
    """Blocked and untried: independent runs in all."""
    sought: int = 0
    """Rare: runs of the directed search."""
    params: tuple[tuple[str, float, str], ...] = ()
    """Rare: name, value and unit of each param of the scene that was found."""
    found: tuple[Floats, Ints] | None = field(default=None, compare=False)
    """Rare: genome (1, d; file units) and key (1, 6) of that scene."""
    case: str = ""
    """Rare: name of the file of that scene; "" if none is written."""
    probability: tuple[float, float, float] | None = None
    """Rare: probability of the cell and its 95 % interval; None if there is none, for the reason in `remark`."""
    remark: str = ""

    @property
    def bound(self) -> float | None:
        """Return the upper bound of the probability of the cell by the rule of three; None without independent runs."""
        return min(1.0, RULE_OF_THREE / self.draws) if self.draws else None


@dataclass(frozen=True)
class CoverageReport:
    """Coverage of one file."""

    path: str
    digest: str
    seed: int
    budget: str
    timed: bool
    """True if the number of runs depends on time."""
    ways: int
    draws: int
    """Runs that count."""
    lost: int
    """Runs that do not count: invalid, aborted by a requirement on the run, or failed by the driver."""
    valueless: int
    """Runs that count and have no number for some domain; they lie in no cell."""
    failure: str
    """Definition of a failure."""
    domains: tuple[DomainInfo, ...]
    cells: tuple[CellResult, ...]
    method: str = INDEPENDENT
    """How the scenes were drawn."""
    lost_by_driver: int = 0
    """Lost runs that the driver failed, which may lie in any cell."""
    joint: bool = False
    """True if all intervals hold together with the confidence `LEVEL` (Bonferroni)."""
    remarks: tuple[str, ...] = ()
    totals: tuple[DomainTotal, ...] = ()
    """Runs by the cells of each domain."""
    verdicts: Mapping[str, int] | None = None
    """Runs by their verdict under an operational design domain; None without one."""
    files: Mapping[str, bytes] = field(default_factory=dict, repr=False)
    """Scenes as files, by their names."""
    command: str = ""
    """Command that gives the same result."""
    seconds: float = 0.0
    counts: Mapping[State, int] = field(init=False)

    def __post_init__(self) -> None:
        found = Counter(cell.state for cell in self.cells)
        object.__setattr__(self, "counts", {state: found[state] for state in State})

    @property
    def possible(self) -> int:
        """Return the number of cells that are not proved empty."""
        return len(self.cells) - sum(self.counts[state] for state in PROVED)

    @property
    def reached(self) -> int:
        return sum(self.counts[state] for state in REACHED)

    @property
    def share(self) -> float:
        """Return the share of the possible cells that are reached; 1 without a possible cell."""
        return self.reached / self.possible if self.possible else 1.0

    @property
    def headline(self) -> str:
        """Return the share of the possible cells that are covered."""
        return f"{self.reached:,} of {counted(self.possible, 'possible cell')} covered ({percent(self.share)})"

    @property
    def multiplicity(self) -> str:
        """Return how the intervals treat that there are many of them."""
        if self.method == TWAY:
            return "scenes of a covering array are no independent draws: there are no rates and no bounds"
        if self.joint:
            return "all intervals hold together at 95 % (Bonferroni over the covered cells)"
        return "each interval holds for its cell alone at 95 %; --joint: all of them together"

    def name_of(self, cell: CellResult) -> str:
        """Return a cell in words: "speed 0 to 10 km/h, light 0.5"."""
        named = (self.domains[domain] for domain in cell.domains)
        return ", ".join(f"{each.name} {each.cells[place]}" for each, place in zip(named, cell.cells, strict=True))

    def reason(self, cell: CellResult) -> str:
        """Return the proof of a cell's state in one sentence."""
        return _REASONS[cell.state](self, cell)


def percent(share: float) -> str:
    return f"{significant(100.0 * share, 3)} %"


def _covered(_report: CoverageReport, cell: CellResult) -> str:
    failed = f"{cell.failures:,} of {counted(cell.runs, 'run')} failed"
    if cell.low is None or cell.high is None:
        return failed
    return f"{failed}: {percent(cell.low)} to {percent(cell.high)}"


def _impossible(report: CoverageReport, cell: CellResult) -> str:
    parts = [report.domains[domain] for domain in cell.culprits]
    ranges = ", ".join(f"`{each.text}` is {each.range_text}" for each in parts if each.range_text)
    values = " and ".join(f"`{each.text}`" for each in parts)
    never = "never in this cell" if len(parts) == 1 else "never in these cells at once"
    return f"{ranges}, {never}" if ranges else f"{values}: {never}, whatever the file draws"


def _excluded(_report: CoverageReport, cell: CellResult) -> str:
    return f"every scene breaks {' or '.join(each.text for each in cell.requirements)}"


def _blocked(_report: CoverageReport, cell: CellResult) -> str:
    events = ", ".join(f"{text} ({count:,})" for text, count in cell.events)
    ended = "its one run" if cell.runs == 1 else f"all {cell.runs:,} runs of its scenes"
    return f"{ended} ended before the instant: {events}"


def _untried(_report: CoverageReport, cell: CellResult) -> str:
    tried = "no scene of the covering array"
    if cell.bound is not None:
        tried = f"none of {counted(cell.draws, 'run')}: probability at most {significant(cell.bound, 2)}"
    return f"{tried}; {cell.remark}" if cell.remark else tried


def _rare(_report: CoverageReport, cell: CellResult) -> str:
    params = ", ".join(f"{name} {significant(value, 6)} {unit}".rstrip() for name, value, unit in cell.params)
    reached = f"reached by a directed search of {cell.sought:,} runs ({params})"
    if cell.probability is None:
        return f"{reached}; no probability: {cell.remark}"
    value, low, high = (significant(each, 3) for each in cell.probability)
    return f"{reached}; probability {value}: {low} to {high}"


_REASONS = {
    State.COVERED: _covered,
    State.RARE: _rare,
    State.BLOCKED: _blocked,
    State.UNTRIED: _untried,
    State.EXCLUDED: _excluded,
    State.IMPOSSIBLE: _impossible,
}


def coverage_content(report: CoverageReport) -> dict[str, Any]:
    """Return the report as a document; only the field `seconds` differs between two equal commands."""
    return {
        "coverage_schema_version": COVERAGE_SCHEMA_VERSION,
        "command": report.command,
        "path": report.path,
        "digest": report.digest,
        "seed": report.seed,
        "method": report.method,
        "budget": report.budget,
        "runs_depend_on_time": report.timed,
        "ways": report.ways,
        "draws": report.draws,
        "lost": report.lost,
        "lost_by_driver": report.lost_by_driver,
        "without_value": report.valueless,
        "failure": report.failure,
        "level": LEVEL,
        "joint": report.joint,
        "counts": {state.value: count for state, count in report.counts.items()},
        "operational_design_domain": report.verdicts and dict(report.verdicts),
        "possible": report.possible,
        "share": report.share,
        "domains": [_domain_content(each) for each in report.domains],
        "cells": [_cell_content(report, each) for each in report.cells],
        "remarks": list(report.remarks),
        "seconds": report.seconds,
    }


def _domain_content(domain: DomainInfo) -> dict[str, Any]:
    return {
        "name": domain.name,
        "instant": domain.when,
        "value": domain.text,
        "line": domain.line,
        "unit": domain.unit,
        "least": domain.least,
        "greatest": domain.greatest,
        "cells": list(domain.cells),
    }


def _cell_content(report: CoverageReport, cell: CellResult) -> dict[str, Any]:
    found: dict[str, Any] = {
        "domains": list(cell.domains),
        "cells": list(cell.cells),
        "name": report.name_of(cell),
        "state": cell.state.value,
        "reason": report.reason(cell),
    }
    if cell.state is State.COVERED:
        found |= {
            "runs": cell.runs,
            "failures": cell.failures,
            "interval": None if cell.low is None else [cell.low, cell.high],
        }
    if cell.worst is not None:
        worst = cell.worst
        found["worst"] = {"run": worst.run, "seed": worst.seed, "event": worst.event, "replay": worst.replay}
    if cell.state is State.IMPOSSIBLE:
        found["culprits"] = list(cell.culprits)
    if cell.state is State.EXCLUDED:
        found["requirements"] = [{"name": each.name, "line": each.line or None} for each in cell.requirements]
    if cell.state is State.BLOCKED:
        found |= {"runs": cell.runs, "events": [{"event": text, "runs": count} for text, count in cell.events]}
    if cell.state is State.RARE:
        known = cell.probability
        found["params"] = {name: {"value": value, "unit": unit} for name, value, unit in cell.params}
        found |= {"simulations": cell.sought, "probability": known and known[0], "interval": known and [*known[1:]]}
    if cell.state in (State.BLOCKED, State.UNTRIED, State.RARE):
        found |= {"draws": cell.draws, "probability_at_most": cell.bound}
    return found


COLUMNS = ("state", "runs", "failures", "low", "high", "replay", "reason")


def coverage_rows(report: CoverageReport) -> Iterator[Sequence[object]]:
    """Yield the table of all cells, its head first: a column for each domain, empty where a cell has none."""
    yield (*(each.name for each in report.domains), *COLUMNS)
    for cell in report.cells:
        named = [""] * len(report.domains)
        for domain, place in zip(cell.domains, cell.cells, strict=True):
            named[domain] = report.domains[domain].cells[place]
        known = (cell.runs, cell.failures, cell.low, cell.high) if cell.state is State.COVERED else (None,) * 4
        numbers = ("" if number is None else number for number in known)
        replay = cell.worst.replay if cell.worst else ""
        yield (*named, cell.state.value, *numbers, replay, report.reason(cell))
