"""Files next to `study.sqlite`, for pandas and for people; a report writes those again that differ.

| file            | one row for each                                                                          |
|-----------------|-------------------------------------------------------------------------------------------|
| runs.csv        | finished run: every figure of the whole run and of its last ten generations               |
| generations.csv | generation of each run: the figures of Figures, and as `simulated_…` by simulation        |
| tests.csv       | measure, contender and scenario: spreads, p, Holm's p, A12 with its interval              |
| summary.json    | (a document) settings, tests, rates of random sampling, the paper's numbers, the verdict  |
"""

import csv
from collections.abc import Iterable, Iterator, Sequence
from io import StringIO
from typing import Any

from engine.paper import STUDIES
from engine.strict_json import json_text
from engine.study.comparisons import Comparison
from engine.study.database import Study
from engine.study.run_records import FIELDS, RunRecord, flat
from engine.study.verdict import Findings, own_totals

RUNS, GENERATIONS, TESTS, SUMMARY = "runs.csv", "generations.csv", "tests.csv", "summary.json"
COURSES = ("", "simulated_")
"""Prefixes of the two halves of a course."""


def study_files(study: Study, findings: Findings) -> dict[str, bytes]:
    """Return all files of the table above by name."""
    names = [subject.name for subject in study.plan.subjects]
    text = json_text(summary(study, findings), indent=2)
    return {
        RUNS: _csv({**_address_row(names, record), **flat(record.figures)} for record in study.records),
        GENERATIONS: _csv(row for record in study.records for row in _generation_rows(names, record)),
        TESTS: _csv(map(test_row, findings.comparisons)),
        SUMMARY: f"{text}\n".encode(),
    }


def summary(study: Study, findings: Findings) -> dict[str, Any]:
    """Return the whole study as one document, without its runs."""
    plan = study.plan
    search = plan.subjects[0].config.search
    return {
        **study.manifest,
        "generations": search.generations,
        "population": search.population,
        "seed": search.seed,
        "presets": {method: preset for method in plan.methods if (preset := plan.preset(method))},
        "scenarios": [
            {"name": s.name, "file": s.file, "program_digest": s.program.digest, "seed": s.config.search.seed}
            for s in plan.subjects
        ],
        "runs_finished": len(study.records),
        "complete": study.complete,
        "verdict": findings.verdict,
        "tests": [test_row(row) for row in findings.comparisons],
        "random_sampling": [_named(row) for row in findings.rates],
        "beside_the_paper": [_named(row) | {"measure": row.measure.name} for row in findings.beside],
        "studies": [_named(row) for row in STUDIES],
        "this_study": own_totals(plan, study.records),
    }


def _named(row: Any) -> dict[str, Any]:
    """Return a dataclass as a dictionary, with named tuples as dictionaries."""
    fields = {name: getattr(row, name) for name in row.__dataclass_fields__ if name != "measure"}
    return {name: value._asdict() if hasattr(value, "_asdict") else value for name, value in fields.items()}


def test_row(row: Comparison) -> dict[str, Any]:
    """Return one comparison as flat columns; `baseline_…` are the baseline's."""
    numbers: dict[str, Any] = {}
    for prefix, spread in (("", row.spread), ("baseline_", row.baseline_spread)):
        numbers |= {
            f"{prefix}runs": spread.runs,
            f"{prefix}missing": spread.missing,
            f"{prefix}median": spread.median,
            f"{prefix}quartile_1": spread.quartiles.low,
            f"{prefix}quartile_3": spread.quartiles.high,
            f"{prefix}mean": spread.mean,
            f"{prefix}sd": spread.deviation,
        }
    return {
        "scenario": row.scenario,
        "measure": row.measure.name,
        "generations": row.measure.counted(row.generations),
        "unit": row.measure.unit,
        "family": row.measure.family,
        "exploratory": int(row.measure.exploratory),
        "larger_is_better": int(row.measure.larger_is_better),
        "method": row.method,
        "baseline": row.baseline,
        **numbers,
        "p": row.p,
        "p_holm": row.p_holm,
        "a12": row.a12,
        "a12_low": row.interval.low,
        "a12_high": row.interval.high,
        "beats": int(row.beats),
        "loses": int(row.loses),
        "words": row.words,
    }


def _address_row(names: Sequence[str], record: RunRecord) -> dict[str, Any]:
    scenario, method, run = record.address
    return {"scenario": names[scenario], "method": method, "run": run}


def _generation_rows(names: Sequence[str], record: RunRecord) -> Iterator[dict[str, Any]]:
    address = _address_row(names, record)
    columns = [f"{prefix}{name}" for prefix in COURSES for name in FIELDS]
    table = record.course.reshape(len(columns), -1).T.tolist()
    for generation, values in enumerate(table):
        yield {**address, "generation": generation, **dict(zip(columns, map(_plain, values), strict=True))}


def _plain(value: float) -> float | int:
    """Return a whole number as int, any other number unchanged."""
    return int(value) if value == value and value == int(value) else value


def _csv(rows: Iterable[dict[str, Any]]) -> bytes:
    """Return rows as CSV; missing numbers are empty, all others read back to the same bits."""
    file = StringIO(newline="")
    writer: csv.DictWriter[str] | None = None
    for row in rows:
        if writer is None:
            writer = csv.DictWriter(file, row, lineterminator="\n")
            writer.writeheader()
        writer.writerow({name: "" if value is None or value != value else value for name, value in row.items()})
    return file.getvalue().encode()
