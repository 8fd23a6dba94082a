"""Result of `cortexc report --audit`: the numbers that an auditor asks for, each with its source or with the reason why
there is none. Data, and the JSON document.

A number on the page is a `Value` whose name is its place below `numbers` in the document.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from hashlib import blake2b
from typing import Any

from cortex_dsl.report.blocks import Value, Words
from cortex_dsl.report.findings.coverage_report import percent
from cortex_dsl.report.findings.readable import counted, duration, fixed, short_names, significant
from engine.gates.exposure import LEVEL, CellCount, exposed_rate, upper_bound
from engine.search.probability.confidence_sequence import sequence_interval
from engine.search.probability.unseen import Unseen

AUDIT_SCHEMA_VERSION = 1
SHOWN = 5
"""Lines of a number on the page at most; the document has all."""
ROOM = 44
"""Characters of a name on the page at most."""


class Topic(StrEnum):
    """Numbers of the page, in its order; the value is the field of the document."""

    FAILURES = "failures"
    EXPOSURE = "exposure"
    PROBABILITY = "probability"
    UNSEEN = "unseen"
    VERDICTS = "verdicts"
    DEVIATION = "deviation"
    COMPARISON = "comparison"
    DYNAMIC = "dynamic"
    STEP = "time_step"
    EFFORT = "effort"


TITLES: Mapping[Topic, tuple[str, str]] = {
    Topic.FAILURES: ("Failures by domain cell", "exact one-sided 95 % bound of each cell (Clopper and Pearson 1934)"),
    Topic.EXPOSURE: (
        "The same under the exposure",
        "weighted cells, bounds that hold together (Bonferroni), effective sample size of Kish (1965)",
    ),
    Topic.PROBABILITY: (
        "Probability of each event",
        "95 % confidence sequence, valid whenever it is read (beta mixture; Ville 1939, Robbins 1970)",
    ),
    Topic.UNSEEN: (
        "Mechanisms not yet seen",
        "estimate of Good (1953); exact 95 % bound from the second half of the draws",
    ),
    Topic.VERDICTS: ("Reference drivers", "whether drivers of a published set avoid what the ego did not"),
    Topic.DEVIATION: (
        "Least deviation to fail",
        "from pass to fail, in units of the tolerance, as far as a search found",
    ),
    Topic.COMPARISON: (
        "Version B against A",
        "same scenes; difference with Tango's 95 % interval (1998), exact McNemar test, Holm over the conditions",
    ),
    Topic.DYNAMIC: ("Dynamic vehicle model", "the worst cases again, with tyres that slip and steps of 5 ms"),
    Topic.STEP: ("Bias of the time step", "documented, not measured here"),
    Topic.EFFORT: ("Effort", "simulations and computing time"),
}
"""Title and method of each number."""

STEP_BIAS = (0.023, 0.053)
"""Share of collisions that steps of 0.05 s show in excess of steps of 0.0025 s, over the two-car examples."""
BIASED_STEP = 0.05
"""[s]"""
ONE_DRIVER = "one driver only; `cortexc compare A B FILE` drives the same scenes with two"
"""Reason why there is no comparison."""
STEP_SOURCE = "benchmarks/README.md, row step_bias"
DOCUMENTED = "python -m benchmarks.step_bias --scenes 20000"


@dataclass(frozen=True)
class Provenance:
    """Origin of a number."""

    command: str
    file: str = ""
    digests: Mapping[str, str] = field(default_factory=dict[str, str])
    """Digests of programs by their files."""
    seed: int | None = None
    version: str = ""
    """Version of cortexc that computed the number."""
    tables: tuple[str, ...] = ()
    """Files from which the number can be computed again."""

    @property
    def digest(self) -> str:
        """Return the digest of the program, or the common one of several: BLAKE2b of all digests in their order."""
        every = list(self.digests.values())
        return every[0] if len(every) == 1 else _common(every) if every else ""


def _common(digests: Sequence[str]) -> str:
    return blake2b("\n".join(digests).encode(), digest_size=16).hexdigest()


@dataclass(frozen=True)
class Finding:
    """One number of the page, or the reason why it is not available."""

    topic: Topic
    source: Provenance | None = None
    values: Mapping[str, Any] = field(default_factory=dict[str, Any])
    lines: tuple[Words, ...] = ()
    reason: str = ""
    """Reason why the number is not available, with the command that gives it; "" if it is."""
    bars: "tuple[Bar, ...]" = ()
    """Interval that is drawn beside each of the first lines."""


@dataclass(frozen=True)
class Bar:
    """An interval of a share, and its estimate."""

    low: float
    point: float
    high: float


@dataclass(frozen=True)
class NotRun:
    """A part that was not run."""

    what: str
    reason: str
    count: int | None = None


@dataclass(frozen=True)
class AuditReport:
    """The page of one search, suite, comparison, coverage or test."""

    kind: str
    id: str
    objective: str
    scenario: str
    inputs: str
    steps: str
    platform: str
    expected: str
    result: str
    findings: tuple[Finding, ...]
    not_run: tuple[NotRun, ...]
    command: str
    """Command that writes the page again."""
    cautions: tuple[str, ...] = ()
    tables: Mapping[str, bytes] = field(default_factory=dict[str, bytes], repr=False)
    """Files beside the page, from which the numbers can be computed again."""
    evidence: Mapping[str, str] = field(default_factory=dict[str, str])
    """SHA-256 of each file from which the numbers can be computed again, by its name."""
    journal: str = ""
    """Last link of the journal of a search."""

    @property
    def sources(self) -> tuple[Provenance, ...]:
        """Return the sources of the available numbers by command, in the order of the page, with all their tables."""
        found: dict[str, Provenance] = {}
        for source in (each.source for each in self.findings if each.source is not None):
            known = found.get(source.command, source)
            tables = dict.fromkeys((*known.tables, *source.tables))
            found[source.command] = replace(known, tables=tuple(tables))
        return tuple(found.values())


def with_prefix(report: AuditReport, stem: str) -> AuditReport:
    """Return the report with names of its own tables that begin with `stem`, so that two sheets fit into a folder."""
    names = {name: f"{stem}-{name}" for name in report.tables}

    def renamed(finding: Finding) -> Finding:
        if finding.source is None:
            return finding
        tables = tuple(names.get(name, name) for name in finding.source.tables)
        return replace(finding, source=replace(finding.source, tables=tables))

    return replace(
        report,
        findings=tuple(map(renamed, report.findings)),
        tables={names[name]: content for name, content in report.tables.items()},
        evidence={names.get(name, name): digest for name, digest in report.evidence.items()},
    )


# -- numbers -----------------------------------------------------------------------------------------------------------


def count_value(topic: Topic, path: str, number: int) -> Value:
    """Return a count of the document."""
    return Value(f"{number:,}", "title", number, f"{topic}.{path}")


def share_value(topic: Topic, path: str, share: float) -> Value:
    """Return a share of the document in percent."""
    return Value(percent(share), "title", share, f"{topic}.{path}")


def number_value(topic: Topic, path: str, number: float, digits: int = 3) -> Value:
    return Value(significant(number, digits), "title", number, f"{topic}.{path}")


def missing(topic: Topic, reason: str) -> Finding:
    return Finding(topic, reason=reason)


@dataclass(frozen=True)
class Cell:
    """Independent draws in one cell."""

    name: str
    draws: int
    failures: int
    lost: int = 0
    """Further draws without a result, which may lie in it."""


def failures_finding(cells: Sequence[Cell], failure: str, source: Provenance, remarks: Sequence[str] = ()) -> Finding:
    """Return the failures of each cell."""
    topic = Topic.FAILURES
    highs = [upper_bound(cell.failures, cell.draws, unknown=cell.lost) for cell in cells]
    values = {
        "failure": failure,
        "level": LEVEL,
        "cells": [
            {"name": cell.name, "draws": cell.draws, "failures": cell.failures, "lost": cell.lost, "high": high}
            for cell, high in zip(cells, highs, strict=True)
        ],
        "remarks": list(remarks),
    }
    bounds = [share_value(topic, f"cells.{number}.high", high) for number, high in enumerate(highs)]
    drawn = [number for number, cell in enumerate(cells) if cell.draws]
    if len(cells) == 1 and drawn:
        lines: list[Words] = [
            [
                *_of(topic, 0, cells[0]),
                " independent draws; at most ",
                bounds[0],
                f"; failure: {failure}",
            ]
        ]
        worst = [0]
    else:
        worst = sorted(drawn, key=lambda number: -highs[number])[:SHOWN]
        names = short_names([cells[number].name for number in worst], ROOM)
        lines = [
            [f"{name}: ", *_of(topic, number, cells[number]), ", at most ", bounds[number]]
            for name, number in zip(names, worst, strict=True)
        ]
        most = "; those with the highest bounds are shown" if len(drawn) > SHOWN else ""
        empty = f"; {len(cells) - len(drawn)} without a draw" if len(drawn) < len(cells) else ""
        lines.append(f"{counted(len(cells), 'cell')}{most}{empty}; failure: {failure}")
    lines += remarks
    if lost := max((cell.lost for cell in cells), default=0):
        lines.append(f"{counted(lost, 'draw')} without a result, taken for failures of every cell")
    return Finding(topic, source, values, tuple(lines), bars=tuple(_bar(cells[n], highs[n]) for n in worst))


def _bar(cell: Cell, high: float) -> Bar:
    return Bar(0.0, cell.failures / cell.draws, high)


def _of(topic: Topic, number: int, cell: Cell) -> list[str | Value]:
    return [
        count_value(topic, f"cells.{number}.failures", cell.failures),
        " of ",
        count_value(topic, f"cells.{number}.draws", cell.draws),
    ]


def exposure_finding(cells: Sequence[Cell], weights: Sequence[float], file: str, source: Provenance) -> Finding:
    """Return the failure rate of cells under weights of the same length."""
    topic = Topic.EXPOSURE
    found = exposed_rate([CellCount(cell.draws, cell.failures, cell.lost) for cell in cells], weights)
    values = {
        "file": file,
        "level": LEVEL,
        "cells": [
            {
                "name": cell.name,
                "draws": cell.draws,
                "failures": cell.failures,
                "lost": cell.lost,
                "weight": weight,
            }
            for cell, weight in zip(cells, weights, strict=True)
        ],
        "rate": found.rate,
        "high": found.high,
        "effective_sample_size": found.effective,
        "weight_without_draws": found.empty,
    }
    bound: list[str | Value] = ["at most ", share_value(topic, "high", found.high)]
    if math.isnan(found.rate):
        lines: tuple[Words, ...] = (
            ["no estimate: ", share_value(topic, "weight_without_draws", found.empty), " of the weight has no draw"],
            [*bound, ", if these cells always fail"],
        )
    else:
        size = number_value(topic, "effective_sample_size", found.effective, 4)
        lines = ([share_value(topic, "rate", found.rate), ", ", *bound, "; effective sample size ", size],)
    return Finding(topic, replace(source, tables=(*source.tables, file)), values, lines)


@dataclass(frozen=True)
class Event:
    """An event in independent draws."""

    name: str
    count: int
    draws: int
    lost: int = 0
    """Further draws without a result."""


def probability_finding(events: Sequence[Event], source: Provenance) -> Finding:
    """Return the probability of each event, the most frequent ones first on the page."""
    topic = Topic.PROBABILITY
    intervals = [sequence_interval(each.count, each.draws, LEVEL, each.lost) for each in events]
    values = {
        "level": LEVEL,
        "events": [
            {
                "name": each.name,
                "count": each.count,
                "draws": each.draws,
                "lost": each.lost,
                "rate": each.count / each.draws if each.draws else math.nan,
                "low": low,
                "high": high,
            }
            for each, (low, high) in zip(events, intervals, strict=True)
        ],
    }
    order = sorted(range(len(events)), key=lambda number: -intervals[number].high)
    names = short_names([events[number].name for number in order[:SHOWN]], ROOM)
    lines: list[Words] = [
        [
            f"{name}: ",
            share_value(topic, f"events.{number}.low", intervals[number].low),
            " to ",
            share_value(topic, f"events.{number}.high", intervals[number].high),
            " (",
            count_value(topic, f"events.{number}.count", events[number].count),
            " of ",
            count_value(topic, f"events.{number}.draws", events[number].draws),
            ")",
        ]
        for name, number in zip(names, order, strict=False)
    ]
    if len(events) > SHOWN:
        lines.append(f"{len(events):,} in all; those with the highest upper ends are shown")
    bars = tuple(
        Bar(intervals[number].low, events[number].count / max(events[number].draws, 1), intervals[number].high)
        for number in order[:SHOWN]
    )
    return Finding(topic, source, values, tuple(lines), bars=bars)


def unseen_finding(unseen: Unseen, draws: int, source: Provenance) -> Finding:
    """Return the probability of kinds of collisions that no draw showed."""
    topic = Topic.UNSEEN
    values = {"level": LEVEL, "draws": draws, **vars(unseen)}
    lines: list[str | Value] = [
        "all other kinds of collisions together: ",
        share_value(topic, "estimate", unseen.estimate),
    ]
    if math.isfinite(unseen.bound):
        lines += [", at most ", share_value(topic, "bound", unseen.bound)]
    else:
        lines.append(", no bound: the number of draws depended on their results")
    seen: list[str | Value] = [
        count_value(topic, "once", unseen.once),
        " of ",
        count_value(topic, "kinds", unseen.kinds),
        " kinds seen came once in ",
        count_value(topic, "draws", draws),
        " draws",
    ]
    return Finding(topic, source, values, (lines, seen))


VERDICTS: Mapping[str, str] = {
    "avoidable": "avoided by all",
    "disputed": "disputed",
    "unavoidable": "avoided by none",
    "no_model": "covered by none",
    "struck": "struck from behind or standing",
    "unknown": "unknown",
}
"""Verdicts of the document, each with its words on the page."""
ALWAYS_SHOWN = ("avoidable", "disputed", "unavoidable")


def verdicts_finding(
    counts: Mapping[str, int], what: str, source: Provenance, names: Sequence[str], adapted: tuple[int, int] | None
) -> Finding:
    """Return the counts of verdicts by `VERDICTS`; `adapted`: collisions that adapted speed avoids, and all of
    which that was tried.
    """
    topic = Topic.VERDICTS
    total = sum(counts.values())
    speed = None if adapted is None else {"avoided": adapted[0], "cases": adapted[1]}
    values = {"references": list(names), "judged": total, **counts, "adapted_speed": speed}
    parts: list[str | Value] = [f"{what}: ", count_value(topic, "judged", total), "; "]
    shown = [name for name in VERDICTS if name in ALWAYS_SHOWN or counts.get(name)]
    for number, name in enumerate(shown):
        parts += [", " if number else "", f"{VERDICTS[name]} ", count_value(topic, name, counts.get(name, 0))]
    lines: list[Words] = [parts, f"drivers: {', '.join(names)}"]
    if adapted is not None:
        lines.append(
            [
                "adapted speed avoids ",
                count_value(topic, "adapted_speed.avoided", adapted[0]),
                " of ",
                count_value(topic, "adapted_speed.cases", adapted[1]),
                " of the worst collisions",
            ]
        )
    return Finding(topic, source, values, tuple(lines))


def dynamic_finding(answers: Mapping[str, int], survives: str, source: Provenance) -> Finding:
    """Return the share of the worst cases that survive; `answers`: their counts, of which `survives` names one."""
    topic = Topic.DYNAMIC
    judged = sum(count for name, count in answers.items() if not name.startswith("not judged"))
    values = {
        "cases": sum(answers.values()),
        "judged": judged,
        "survive": answers.get(survives, 0),
        "share": answers.get(survives, 0) / judged if judged else math.nan,
        "answers": dict(answers),
    }
    first: list[str | Value] = [
        count_value(topic, "survive", values["survive"]),
        " of ",
        count_value(topic, "judged", judged),
        " worst cases survive",
    ]
    if judged:
        first += [": ", share_value(topic, "share", values["share"])]
    others = [f"{count} {name}" for name, count in answers.items() if count and name != survives]
    rest = f"{', '.join(others)}; " if others else ""
    return Finding(topic, source, values, (first, f"{rest}worst cases are no sample, so there is no interval"))


def step_finding(time_step: float | None, version: str) -> Finding:
    """Return the documented bias; `time_step` is that of the runs [s], None if it is not known."""
    topic = Topic.STEP
    low, high = STEP_BIAS
    values = {"low": low, "high": high, "at": BIASED_STEP, "against": 0.0025, "time_step": time_step}
    lines: list[Words] = [
        [
            "",
            share_value(topic, "low", low),
            " to ",
            share_value(topic, "high", high),
            f" more collisions at {BIASED_STEP} s than at 0.0025 s, over the two-car examples",
        ]
    ]
    if time_step is not None and time_step != BIASED_STEP:
        lines.append(f"the step of these runs is {significant(time_step)} s, for which there is no figure")
    return Finding(topic, Provenance(DOCUMENTED, STEP_SOURCE, version=version), values, tuple(lines))


def effort_finding(simulations: int, cpu: float, source: Provenance, *, exact: bool) -> Finding:
    """Return simulations and CPU seconds; not `exact`: the clock times the threads, which is their upper limit."""
    topic = Topic.EFFORT
    values = {"simulations": simulations, "cpu_seconds": cpu, "cpu_seconds_are_a_limit": not exact}
    known = math.isfinite(cpu)
    text = Value(duration(cpu), "title", cpu, f"{topic}.cpu_seconds") if known else "unknown: it was not recorded"
    most = "" if exact or not known else "at most "
    line: list[str | Value] = [
        count_value(topic, "simulations", simulations),
        f" simulations; computing time {most}",
        text,
    ]
    return Finding(topic, source, values, (line,))


def platform_text(machine: str, versions: Mapping[str, str]) -> str:
    """Return a machine and the versions of packages in one line."""
    return ", ".join([machine, *(f"{name} {version}" for name, version in versions.items())])


def deviation_line(topic: Topic, path: str, name: str, size: float) -> Words:
    """Return the least deviation of one cell."""
    return [f"{name}: ", Value(fixed(size, 3), "title", size, f"{topic}.{path}")]


# -- the document ------------------------------------------------------------------------------------------------------

ISO_34505 = (
    "Field names of `case` follow the public abstract of ISO 34505 and were not checked against the text of the "
    "standard."
)


def audit_content(report: AuditReport) -> dict[str, Any]:
    """Return the report as a document; equal commands give equal documents, but for `effort`."""
    return {
        "audit_schema_version": AUDIT_SCHEMA_VERSION,
        "case": {
            "id": report.id,
            "objective": report.objective,
            "scenario": report.scenario,
            "inputs": report.inputs,
            "steps": report.steps,
            "platform": report.platform,
            "expected_result": report.expected,
            "result": report.result,
        },
        "field_names": ISO_34505,
        "kind": report.kind,
        "command": report.command,
        "cautions": list(report.cautions),
        "numbers": {each.topic.value: _finding_content(each) for each in report.findings},
        "not_run": [vars(each) for each in report.not_run],
        "evidence": dict(report.evidence),
    }


def _finding_content(finding: Finding) -> dict[str, Any]:
    title, method = TITLES[finding.topic]
    source = finding.source
    return {
        "title": title,
        "available": not finding.reason,
        "reason": finding.reason or None,
        "method": method,
        "source": None
        if source is None
        else {
            "command": source.command,
            "file": source.file,
            "digest": source.digest or None,
            "digests": dict(source.digests),
            "seed": source.seed,
            "version": source.version,
            "tables": list(source.tables),
        },
        **finding.values,
    }
