"""The result of `cortexc test` as annotations, which GitHub shows at the line of each broken `expect`."""

from cortex_dsl.report.findings.gate_report import CURED, Check, FileResult, GateReport, Status
from cortex_dsl.report.github import as_data, as_property, github_annotations


def gate_annotations(report: GateReport) -> list[str]:
    """Return annotations for all errors, broken limits and open decisions; known failures are notices."""
    lines: list[str] = []
    for file in report.files:
        if file.source is not None:
            lines += github_annotations(file.source, file.diagnostics)
        if file.trouble and file.error is None:
            lines.append(f"::error file={as_property(file.path)},title=cortexc test::{as_data(file.trouble)}")
        lines += (_annotation(report, file, check) for check in file.checks if check.status is not Status.PASS)
        if report.strict:
            lines += (_cured(file, check) for check in file.checks if check.cured)
    return lines


def _annotation(report: GateReport, file: FileResult, check: Check) -> str:
    is_open = check.status is Status.UNDECIDED and report.undecided_passes
    level = "notice" if check.status is Status.KNOWN else "warning" if is_open else "error"
    text = [f"{check.status}: {check.text}"]
    text += [check.first.text, check.replay] if check.first is not None else []
    return f"::{level} {_place(file, check)},title={as_property(check.name)}::{as_data(chr(10).join(text))}"


def _cured(file: FileResult, check: Check) -> str:
    return f"::error {_place(file, check)},title={as_property(check.name)}::{CURED}"


def _place(file: FileResult, check: Check) -> str:
    return f"file={as_property(check.place or file.path)},line={max(1, check.line)}"
