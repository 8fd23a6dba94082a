"""The page for an auditor from the document of a suite, a comparison, a coverage or a test. Prints nothing."""

import json
import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path
from shlex import join, split
from typing import Any

from cortex_dsl.api.exposure import Exposure
from cortex_dsl.api.suite_consistency import answers_of, contradictions
from cortex_dsl.plain_text import as_argument
from cortex_dsl.report.blocks import Value
from cortex_dsl.report.documents import EFFORT, SCHEMA_VERSION
from cortex_dsl.report.findings.audit_report import (
    ONE_DRIVER,
    SHOWN,
    AuditReport,
    Bar,
    Cell,
    Event,
    Finding,
    NotRun,
    Provenance,
    Topic,
    count_value,
    deviation_line,
    effort_finding,
    exposure_finding,
    failures_finding,
    missing,
    number_value,
    platform_text,
    probability_finding,
    share_value,
    step_finding,
    verdicts_finding,
)
from cortex_dsl.report.findings.readable import counted
from cortex_dsl.version import VERSION
from engine.config import DEFAULT_REFERENCES
from engine.errors import ArgumentError, UnreadableFileError
from engine.references import joint_verdict
from engine.search.store import without_folders

SUITE, COMPARE, COVERAGE, TEST = "suite", "compare", "coverage", "test"
TABLES = {SUITE: "cells", COMPARE: "pairs", COVERAGE: "cells"}
"""Beginning of the names of the tables that a command writes beside its document."""
NO_MECHANISMS = "runs of a {} have no kinds of collisions; a search by `cortexc FILE --random` counts them"
NO_TOLERANCES = "there are no tolerances; `cortexc suite` finds it for each cell of a suite"
NO_CASES = "`cortexc verify RUN --model dynamic` repeats the worst cases of a search"


@dataclass(frozen=True)
class Document:
    """A document that a command has written, with what lies beside it."""

    path: Path
    kind: str
    content: Mapping[str, Any]
    effort: Mapping[str, Any]
    """Content of `effort.json`; {} without one."""
    tables: tuple[str, ...]
    """Names of the tables beside it."""
    evidence: Mapping[str, str]
    """SHA-256 of the document and of the files beside it, by name."""

    @property
    def version(self) -> str:
        return str(self.content["cortexc"])


def document_in(path: Path) -> Document | None:
    """Return the document of a folder of results, or in a file; None for a folder without one.

    Raises:
        ArgumentError: it is no such document, or that of another schema.
        UnreadableFileError: it cannot be read.
    """
    if path.is_dir():
        found = [path / f"{kind}.json" for kind in TABLES if (path / f"{kind}.json").is_file()]
        if not found:
            return None
        path = found[0]
    content = _json(path)
    kind = str(content.get("schema", "")).removeprefix("cortexc/")
    if kind not in READERS:
        what = f"`{path}` is no document of a suite, a comparison, a coverage or a test"
        raise ArgumentError(
            what, "name the folder of a search, or of `--out`, or the document of `cortexc test --json`"
        )
    if content.get("schema_version") != SCHEMA_VERSION:
        what = (
            f"`{path}` has version {content.get('schema_version')} of its schema, and this is version {SCHEMA_VERSION}"
        )
        raise ArgumentError(what, f"run the command again, or use cortexc {content.get('cortexc')}")
    effort = path.parent / EFFORT
    beside = path.parent.glob(f"{TABLES[kind]}*") if kind in TABLES else ()
    tables = sorted(each.name for each in beside if each.suffix in (".csv", ".parquet"))
    names = [path.name, *tables, *([EFFORT] if effort.is_file() else [])]
    return Document(
        path,
        kind,
        content,
        _json(effort) if effort.is_file() else {},
        tuple(tables),
        {name: sha256((path.parent / name).read_bytes()).hexdigest() for name in names},
    )


def _json(path: Path) -> dict[str, Any]:
    """Return the object in a file.

    Raises:
        ArgumentError, UnreadableFileError: as `document_in`.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UnreadableFileError(path, error) from error
    except ValueError as error:
        cut = "it was cut off or changed: run its command again"
        cure = cut if path.suffix == ".json" else "name the folder of a search, or of `--out`"
        raise ArgumentError(f"`{path}` is no JSON: {error}", cure) from error
    if not isinstance(content, dict):
        raise ArgumentError(f"`{path}` is no document of cortexc", "name a folder of results")
    return content


def audit_of_document(found: Document, exposure: Exposure | None = None, command: str = "") -> AuditReport:
    """Return the page of a document; `command` writes it again.

    Raises:
        ArgumentError: a field is missing or has another type, or the exposure does not fit.
    """
    try:
        weighted = {} if exposure is None else {exposure.name: exposure.digest}
        return replace(READERS[found.kind](found, exposure, command), evidence={**found.evidence, **weighted})
    except ArgumentError:
        raise
    except (KeyError, TypeError, IndexError, AttributeError, ValueError) as error:
        what = f"`{found.path}` is no whole document of `cortexc {found.kind}`: {type(error).__name__} {error}"
        raise ArgumentError(what, "it was changed, or written by another version: run its command again") from error


def _cautions(found: Document, *, interrupted: object, timed: object) -> Iterator[str]:
    if interrupted:
        yield "The command was interrupted: the numbers are those of what was done."
    if timed:
        yield "The number of runs depends on the machine: the same command may give other counts."
    yield from (
        f"{remark[0].upper()}{remark[1:]}." for remark in found.content.get("remarks", []) if found.kind == SUITE
    )
    if found.version != VERSION:
        yield f"The results are those of cortexc {found.version}; this page is by {VERSION}."


def _source(found: Document, command: str, digests: Mapping[str, str], *tables: str) -> Provenance:
    made = without_folders_of(str(found.content.get("command") or f"cortexc {found.kind}"))
    place = Path(without_folders(str(found.path if found.kind == TEST else found.path.parent)))
    made += f" --json > {as_argument(place)}" if found.kind == TEST else f" --out {as_argument(place)}"
    names = [without_folders(name) for name in digests]
    file = names[0] if len(names) == 1 else counted(len(names), "scenario")
    return Provenance(
        command=f"{made}, then {command}",
        file=file,
        digests={without_folders(name): digest for name, digest in digests.items()},
        seed=found.content.get("seed"),
        version=found.version,
        tables=tables or (*found.tables, found.path.name),
    )


def without_folders_of(command: str) -> str:
    """Return a command without the folders of this computer."""
    return join(map(without_folders, split(command)))


def _platform(found: Document) -> str:
    effort = found.effort
    if not effort:
        return f"cortexc {found.version}; machine and packages were not recorded"
    return platform_text(str(effort["platform"]), effort["versions"])


def _effort(found: Document, simulations: int, source: Provenance) -> Finding:
    cpu = float(found.effort.get("cpu_seconds", math.nan))
    tables = (found.path.name, *((EFFORT,) if found.effort else ()))
    return effort_finding(simulations, cpu, replace(source, tables=tables), exact=True)


def _weighted(
    exposure: Exposure | None, columns: Sequence[str], cells: Sequence[tuple[tuple[str, ...], Cell]], source: Provenance
) -> Finding:
    """Return the failure rate under an exposure; `cells` with their coordinates.

    Raises:
        ArgumentError: it does not fit.
    """
    if exposure is None:
        head = ",".join((*columns, "weight"))
        return missing(Topic.EXPOSURE, f"no exposure is given; --exposure FILE has the columns {head}")
    if exposure.columns != tuple(columns):
        what = f"`{exposure.path}`, line 1: expected `{','.join((*columns, 'weight'))}`"
        raise ArgumentError(f"{what}, found `{','.join((*exposure.columns, 'weight'))}`", "name these columns")
    weights = exposure.weights_of([place for place, _ in cells], lambda number: cells[number][1].draws > 0)
    return exposure_finding([cell for _, cell in cells], weights, exposure.name, source)


def _without_exposure(found: Document, exposure: Exposure | None, reason: str) -> Finding:
    """Return the missing number.

    Raises:
        ArgumentError: an exposure is given.
    """
    if exposure is not None:
        raise ArgumentError(f"--exposure weights cells of independent draws, and `{found.path}` has none", reason)
    return missing(Topic.EXPOSURE, reason)


def _with_reasons(findings: Sequence[Finding], more: Sequence[NotRun]) -> tuple[NotRun, ...]:
    return (*more, *(NotRun(each.topic.value, each.reason) for each in findings if each.reason))


def _by_reason(reasons: Sequence[str], what: str) -> list[NotRun]:
    return [NotRun(what, reason, count) for reason, count in Counter(reasons).most_common()]


# -- suites ------------------------------------------------------------------------------------------------------------


def _suite(found: Document, exposure: Exposure | None, command: str) -> AuditReport:
    content = found.content
    for what in contradictions(content):
        raise ArgumentError(f"`{found.path}`, {what}", "it was changed: run `cortexc suite` again")
    groups, driver = content["groups"], without_folders(content["driver"])
    cells = [cell for group in groups for cell in group["cells"]]
    source = _source(found, command, {group["file"]: group["digest"] for group in groups if group["digest"]})
    every = [Cell(cell["id"], cell["probability"]["runs"], cell["probability"]["failures"]) for cell in cells]
    counts = [cell for cell in every if cell.draws]
    nothing = "no cell has runs within tolerances"
    findings = [
        failures_finding(counts, "a test within the tolerances that is red", source)
        if counts
        else missing(Topic.FAILURES, nothing),
        _weighted(exposure, ["cell"], [((cell.name,), cell) for cell in every], source)
        if counts
        else _without_exposure(found, exposure, nothing),
        probability_finding([Event(cell.name, cell.failures, cell.draws) for cell in counts], source)
        if counts
        else missing(Topic.PROBABILITY, nothing),
        missing(Topic.UNSEEN, NO_MECHANISMS.format("suite")),
        _suite_verdicts(cells, source),
        _deviations(cells, source),
        missing(Topic.COMPARISON, ONE_DRIVER),
        missing(Topic.DYNAMIC, NO_CASES),
        step_finding(None, found.version),
        _effort(found, sum(group["runs"] for group in groups), source),
    ]
    rest = [cell for cell in cells if cell["outcome"] in ("not_run", "error")]
    left = _by_reason([cell["reason"] for cell in rest], "cells")
    if content.get("not_done"):
        left.append(NotRun("groups", "the suite was interrupted", content["not_done"]))
    counted_cells = ", ".join(f"{count} {name.replace('_', ' ')}" for name, count in content["counts"].items() if count)
    points = f"; {content['points']:.3f} points" if content["points"] is not None else ""
    return AuditReport(
        kind=SUITE,
        id=f"{content['suite']}/{source.digest[:12]}/{content['seed']}",
        objective=content["title"],
        scenario=f"{content['edition']}; {counted(len(source.digests), 'scenario')}",
        inputs=f"driver {driver}; {counted(len(cells), 'cell')}",
        steps=f"each cell: the nominal test, runs within the tolerances (budget {content['budget']}), a search for the "
        "least deviation, the reference drivers",
        platform=_platform(found),
        expected="every cell keeps its rule: no red, or an impact no faster than its limit",
        result=f"{counted(len(cells), 'cell')}: {counted_cells}{points}",
        findings=tuple(findings),
        not_run=_with_reasons(findings, left),
        command=command,
        cautions=tuple(_cautions(found, interrupted=content.get("not_done"), timed=_is_time(content["budget"]))),
    )


def _is_time(budget: str) -> bool:
    return not budget.replace(",", "").isdigit()


def _verdict(cell: Mapping[str, Any]) -> str:
    """Return the verdict on a cell from the answers of the drivers."""
    return joint_verdict(answers_of(cell)).name.lower()


def _suite_verdicts(cells: Sequence[Mapping[str, Any]], source: Provenance) -> Finding:
    judged = [cell for cell in cells if cell["answers"]]
    if not judged:
        return missing(Topic.VERDICTS, "no cell was judged: an ego that keeps its speed cannot drive in the scenarios")
    said = Counter(_verdict(cell) for cell in judged)
    failed = Counter(_verdict(cell) for cell in judged if cell["outcome"] == "fail")
    names = sorted({name for cell in judged for name in cell["answers"]})
    finding = verdicts_finding(dict(said), "cells, with an ego that keeps its speed", source, names, None)
    line: list[str | Value] = [
        "the driver fails ",
        count_value(Topic.VERDICTS, "failed.judged", failed.total()),
        " of them, of which all drivers avoid ",
        count_value(Topic.VERDICTS, "failed.avoidable", failed["avoidable"]),
    ]
    more = "adapted speed is not measured for cells"
    values = {**finding.values, "failed": {**failed, "avoidable": failed["avoidable"], "judged": failed.total()}}
    return Finding(Topic.VERDICTS, source, values, (*finding.lines, line, more))


def _deviations(cells: Sequence[Mapping[str, Any]], source: Provenance) -> Finding:
    """Return the least deviations of cells that pass in the nominal test."""
    tried = [cell for cell in cells if cell["outcome"] == "pass" and cell["probability"]["runs"]]
    if not tried:
        return missing(Topic.DEVIATION, "no cell passes and has tolerances")
    found = sorted((cell for cell in tried if cell["deviation"]), key=lambda cell: cell["deviation"]["size"])
    values = {
        "passing": len(tried),
        "turned": len(found),
        "cells": [
            {"name": cell["id"], "size": cell["deviation"]["size"], "case": cell["deviation"]["case"]} for cell in found
        ],
    }
    topic = Topic.DEVIATION
    first = [
        count_value(topic, "turned", len(found)),
        " of ",
        count_value(topic, "passing", len(tried)),
        " cells that pass fail within their tolerances",
    ]
    lines = [
        deviation_line(topic, f"cells.{number}.size", cell["id"], cell["deviation"]["size"])
        for number, cell in enumerate(found[: SHOWN - 2])
    ]
    return Finding(topic, source, values, (first, *lines))


# -- comparisons -------------------------------------------------------------------------------------------------------


def _compare(found: Document, exposure: Exposure | None, command: str) -> AuditReport:
    content = found.content
    files = [file for file in content["files"] if file["valid"]]
    digests: dict[str, str] = {}
    for file in content["files"]:
        for side, name in (("a", content["a"]), ("b", content["b"])):
            if file["digests"][side]:
                digests[name if Path(name).suffix == ".scn" else file["path"]] = file["digests"][side]
    source = _source(found, command, digests)
    random = [file for file in files if file["independent"] and not file["kept"]]
    fixed = [file for file in random if file["max_new"] is None]
    cells = [((without_folders(file["path"]),), _cell_of_b(file)) for file in fixed]
    empty = [file for file in content["files"] if not file["valid"] and not file["kept"]]
    weighted = [*cells, *(((without_folders(each["path"]),), _cell_of_b(each)) for each in empty)]
    reason = next((file["no_test"] for file in files if file["no_test"]), "no pair is an independent draw")
    findings = [
        failures_finding([cell for _, cell in cells], "B breaks a condition", source)
        if cells
        else missing(Topic.FAILURES, reason),
        _weighted(exposure, ["file"], weighted, source) if cells else _without_exposure(found, exposure, reason),
        probability_finding(list(_events(random)), source) if random else missing(Topic.PROBABILITY, reason),
        missing(Topic.UNSEEN, NO_MECHANISMS.format("comparison")),
        _contacts(files, source),
        missing(Topic.DEVIATION, NO_TOLERANCES),
        _difference(files, source),
        missing(Topic.DYNAMIC, NO_CASES),
        step_finding(None, found.version),
        _effort(found, 2 * content["pairs"] + sum(2 * _searched(file) for file in files), source),
    ]
    left = [
        NotRun(f"pairs, {each['side']}", each["reason"], each["count"])
        for f in content["files"]
        for each in f["not_run"]
    ]
    left += [NotRun(without_folders(file["path"]), file["trouble"]) for file in content["files"] if file["trouble"]]
    a, b = without_folders(content["a"]), without_folders(content["b"])
    changes = ", ".join(f"{count:,} {name}" for name, count in content["changes"].items())
    return AuditReport(
        kind="comparison",
        id=f"compare/{source.digest[:12]}/{content['seed']}",
        objective=f"{b} (B) against {a} (A), on the same scenes",
        scenario=", ".join(without_folders(file["path"]) for file in content["files"][:3])
        + (f" and {len(content['files']) - 3} more" if len(content["files"]) > 3 else ""),
        inputs=f"{counted(content['pairs'], 'pair')} of scenes, seed {content['seed']}",
        steps="A and B drive each scene; each condition is compared within the pair",
        platform=_platform(found),
        expected="no condition that A keeps is broken by B",
        result=f"failures: {changes}, in {counted(content['pairs'], 'pair')}",
        findings=tuple(findings),
        not_run=_with_reasons(findings, left),
        command=command,
        cautions=(
            *_cautions(found, interrupted=content["interrupted"], timed=content["pairs_depend_on_time"]),
            *([] if content["deterministic"] else ["A driver is not deterministic: it drove a scene otherwise again."]),
        ),
    )


def _searched(file: Mapping[str, Any]) -> int:
    return file["search"]["scenes"] if file["search"] else 0


FAILURES_OF_B = ("new", "moved", "kept")
"""Changes in which B fails."""


def _cell_of_b(file: Mapping[str, Any]) -> Cell:
    failed = sum(change["count"] for change in file["changes"] if change["change"] in FAILURES_OF_B)
    return Cell(without_folders(file["path"]), file["valid"], failed, file["lost_by_b"])


def _events(files: Sequence[Mapping[str, Any]]) -> Iterator[Event]:
    for file in files:
        prefix = f"{without_folders(file['path'])}: " if len(files) > 1 else ""
        for condition in file["conditions"]:
            table = condition["table"]
            both, valid = table["broken_broken"], file["valid"]
            for side, alone in (("A", "broken_kept"), ("B", "kept_broken")):  # a scene that B lost has no pair for A
                yield Event(f"{prefix}{condition['name']}, {side}", both + table[alone], valid, file["lost_by_b"])


def _contacts(files: Sequence[Mapping[str, Any]], source: Provenance) -> Finding:
    """Return the contacts of both sides, and those that all reference drivers avoid."""
    topic = Topic.VERDICTS
    values = {f"{kind}_{side}": 0 for kind in ("contact", "avoidable") for side in "ab"}
    for file in files:
        for condition in file["conditions"]:
            if (kind := condition["kind"]) in ("contact", "avoidable"):
                table = condition["table"]
                values[f"{kind}_a"] += table["broken_kept"] + table["broken_broken"]
                values[f"{kind}_b"] += table["kept_broken"] + table["broken_broken"]
    if not files:
        return missing(topic, "no pair counts")
    lines = [
        [
            f"{side.upper()}: ",
            count_value(topic, f"avoidable_{side}", values[f"avoidable_{side}"]),
            " of ",
            count_value(topic, f"contact_{side}", values[f"contact_{side}"]),
            " contacts are avoided by all reference drivers",
        ]
        for side in "ab"
    ]
    last = f"drivers: {', '.join(DEFAULT_REFERENCES)}; disputed contacts and adapted speed are in no comparison"
    return Finding(topic, source, values, (*lines, last))


def _difference(files: Sequence[Mapping[str, Any]], source: Provenance) -> Finding:
    """Return the differences between A and B, the clearest first."""
    topic = Topic.COMPARISON
    rows = [
        {
            "file": without_folders(file["path"]),
            "name": condition["name"],
            "kind": condition["kind"],
            **condition["table"],
            "difference": condition["difference"],
            "low": condition["interval"][0],
            "high": condition["interval"][1],
            "p": condition["p"],
            "p_holm": condition["p_holm"],
        }
        for file in files
        for condition in file["conditions"]
        if condition["interval"] is not None
    ]
    bounds = [
        {"file": without_folders(file["path"]), "pairs": file["valid"], "high": file["residual_bound"]}
        for file in files
        if file["residual_bound"] is not None
    ]
    if not rows:
        reason = next((file["no_test"] for file in files if file["no_test"]), "no pair counts")
        return missing(topic, f"no paired test: {reason}")
    order = sorted(range(len(rows)), key=lambda number: (rows[number]["p_holm"], number))[: SHOWN - 1]
    several = len({row["file"] for row in rows}) > 1
    lines = []
    for number in order:
        row, place = rows[number], f"conditions.{number}"
        name = f"{row['file']}: {row['name']}" if several else row["name"]
        lines.append(
            [
                f"{name}: ",
                share_value(topic, f"{place}.difference", row["difference"]),
                " (",
                share_value(topic, f"{place}.low", row["low"]),
                " to ",
                share_value(topic, f"{place}.high", row["high"]),
                "), p ",
                number_value(topic, f"{place}.p_holm", row["p_holm"], 2),
            ]
        )
    if len(rows) > len(order):
        lines.append(f"{len(rows)} conditions in all; those with the least p are shown")
    for number, bound in enumerate(bounds[:1]):
        text = [
            "no new failure: probability of one at most ",
            share_value(topic, f"residual.{number}.high", bound["high"]),
        ]
        lines.append(text)
    bars = tuple(Bar(rows[number]["low"], rows[number]["difference"], rows[number]["high"]) for number in order)
    return Finding(topic, source, {"conditions": rows, "residual": bounds}, tuple(lines), bars=bars)


# -- coverage ----------------------------------------------------------------------------------------------------------


def _coverage(found: Document, exposure: Exposure | None, command: str) -> AuditReport:
    content = found.content
    domains = content["domains"]
    source = _source(found, command, {content["path"]: content["digest"]})
    drawn = content["method"] == "independent" and content["draws"]
    if not content["draws"]:
        reason = "no run counts"
    elif drawn:
        reason = "no run lies in a cell"
    else:
        reason = "the scenes are those of a covering array and no independent draws"
    lost = _lost(content)
    cells = [
        (
            tuple(cell["domains"]),
            tuple(domains[d]["cells"][c] for d, c in zip(cell["domains"], cell["cells"], strict=True)),
            cell,
        )
        for cell in content["cells"]
        if cell["state"] not in ("impossible", "excluded")
    ]
    counts = [
        Cell(cell["name"], cell.get("runs", 0), cell.get("failures", 0), lost)
        for *_, cell in cells
        if cell["state"] == "covered"
    ]
    findings = [
        failures_finding(counts, content["failure"], source) if drawn and counts else missing(Topic.FAILURES, reason),
        _exposed_coverage(found, exposure, cells, source) if drawn else _without_exposure(found, exposure, reason),
        missing(Topic.PROBABILITY, "a coverage counts failures by cell; a search by `cortexc FILE --random` gives it"),
        missing(Topic.UNSEEN, NO_MECHANISMS.format("coverage")),
        missing(Topic.VERDICTS, "runs of a coverage are not judged; a search judges its collisions"),
        missing(Topic.DEVIATION, NO_TOLERANCES),
        missing(Topic.COMPARISON, ONE_DRIVER),
        missing(Topic.DYNAMIC, NO_CASES),
        step_finding(None, found.version),
        _effort(found, content["draws"] + content["lost"], source),
    ]
    why = {cell["state"]: cell["reason"] for cell in reversed(content["cells"]) if cell["state"] != "covered"}
    left = [
        NotRun(f"cells: {state}", why[state], count)
        for state, count in content["counts"].items()
        if count and state != "covered"
    ]
    left += (
        [NotRun("runs", "invalid, aborted by a requirement, or failed by the driver", content["lost"])]
        if content["lost"]
        else []
    )
    share = content["share"]
    return AuditReport(
        kind=COVERAGE,
        id=f"coverage/{content['digest'][:12]}/{content['seed']}",
        objective="Coverage of the domains of a scenario",
        scenario=without_folders(content["path"]),
        inputs="; ".join(f"{each['name']}: {counted(len(each['cells']), 'cell')}" for each in domains),
        steps=f"{counted(content['draws'] + content['lost'], 'run')}, seed {content['seed']}, products of "
        f"{counted(content['ways'], 'domain')}",
        platform=_platform(found),
        expected=f"no run fails ({content['failure']})",
        result=f"{content['counts']['covered']} of {content['possible']} possible cells covered"
        + (f" ({100 * share:.1f} %)" if share is not None else ""),
        findings=tuple(findings),
        not_run=_with_reasons(findings, left),
        command=command,
        cautions=tuple(_cautions(found, interrupted=False, timed=content["runs_depend_on_time"])),
    )


def _lost(content: Mapping[str, Any]) -> int:
    """Return the runs that the driver lost; older documents do not tell them from other runs that do not count."""
    return int(content.get("lost_by_driver", content["lost"]))


def _exposed_coverage(
    found: Document,
    exposure: Exposure | None,
    cells: Sequence[tuple[tuple[int, ...], tuple[str, ...], Mapping[str, Any]]],
    source: Provenance,
) -> Finding:
    """Return the failure rate of one product of domains under an exposure.

    Raises:
        ArgumentError: it names another product.
    """
    names = [each["name"] for each in found.content["domains"]]
    products = list(dict.fromkeys(place for place, *_ in cells))
    columns = [tuple(names[domain] for domain in place) for place in products]
    if exposure is None or not columns:
        return _weighted(exposure, columns[0] if columns else ["domain"], [], source)
    wanted = next((place for place, each in zip(products, columns, strict=True) if each == exposure.columns), None)
    if wanted is None:
        there = " or ".join(f"`{','.join((*each, 'weight'))}`" for each in columns[:3])
        what = f"`{exposure.path}`, line 1: found `{','.join((*exposure.columns, 'weight'))}`"
        raise ArgumentError(f"{what}, which is no product of this coverage", f"write {there}")
    chosen: list[tuple[tuple[str, ...], Cell]] = []
    for place, texts, cell in cells:
        if place == wanted:
            runs = cell.get("runs", 0) if cell["state"] == "covered" else 0
            chosen.append((texts, Cell(", ".join(texts), runs, cell.get("failures", 0), _lost(found.content))))
    return _weighted(exposure, exposure.columns, chosen, source)


# -- tests -------------------------------------------------------------------------------------------------------------


def _test(found: Document, exposure: Exposure | None, command: str) -> AuditReport:
    content = found.content
    files = content["files"]
    source = _source(found, command, {file["path"]: file["digest"] for file in files if file["digest"]})
    random = [file for file in files if not file["kept"] and file["valid"]]
    checks = [
        (file, check, f"{without_folders(file['path'])}: {check['name']}" if len(files) > 1 else check["name"])
        for file in random
        for check in file["checks"]
        if check["kind"] in ("expect", "contact", "bound", "probability")
    ]
    fixed = [
        (name, check) for file, check, name in checks if all(each["max_probability"] is None for each in file["checks"])
    ]
    nothing = "no file leaves something to chance: each has one run" if not random else "no file has a check with runs"
    looked = "with --max-probability the number of runs depends on their results"
    findings = [
        failures_finding(
            [Cell(name, check["runs"], check["failures"]) for name, check in fixed], "a broken limit", source
        )
        if fixed
        else missing(Topic.FAILURES, looked if checks else nothing),
        _without_exposure(
            found, exposure, "limits of a test are no cells; `cortexc coverage FILE` counts failures by cell"
        ),
        probability_finding([Event(name, check["failures"], check["runs"]) for _, check, name in checks], source)
        if checks
        else missing(Topic.PROBABILITY, nothing),
        missing(Topic.UNSEEN, NO_MECHANISMS.format("test")),
        missing(Topic.VERDICTS, "runs of a test are not judged; a search judges its collisions"),
        missing(Topic.DEVIATION, NO_TOLERANCES),
        missing(Topic.COMPARISON, ONE_DRIVER),
        missing(Topic.DYNAMIC, NO_CASES),
        step_finding(None, found.version),
        _effort(found, content["runs"], source),
    ]
    left = [NotRun(without_folders(file["path"]), file["trouble"]) for file in files if file["trouble"]]
    left += [NotRun("files", "left out: the test was interrupted", content["not_run"])] if content["not_run"] else []
    invalid = sum(file["runs"] - file["valid"] for file in files)
    left += [NotRun("runs", "they do not count: invalid, or failed by the driver", invalid)] if invalid else []
    counts = ", ".join(f"{count} {name}" for name, count in content["counts"].items() if count)
    return AuditReport(
        kind=TEST,
        id=f"test/{source.digest[:12]}/{content['seed']}",
        objective="Limits of scenario files",
        scenario=source.file,
        inputs=f"budget {content['budget']}, seed {content['seed']}",
        steps="each file is run, and each of its limits is judged in each run",
        platform=_platform(found),
        expected="every limit is kept",
        result=f"{counted(len(files), 'file')}: {counts}",
        findings=tuple(findings),
        not_run=_with_reasons(findings, left),
        command=command,
        cautions=tuple(_cautions(found, interrupted=content["not_run"], timed=content["runs_depend_on_time"])),
    )


Reader = Callable[[Document, Exposure | None, str], AuditReport]
READERS: Mapping[str, Reader] = {SUITE: _suite, COMPARE: _compare, COVERAGE: _coverage, TEST: _test}
