"""The result of `cortexc suite` as JUnit XML: a group is a `testsuite`, each of its cells a `testcase`.

A group whose scenario has errors, or in which the driver cannot drive, has one testcase with an `error`.
"""

from collections.abc import Iterator
from xml.etree.ElementTree import Element, SubElement

from cortex_dsl.report.findings.suite_report import CellResult, GroupResult, Outcome, SuiteReport
from cortex_dsl.report.gates.junit import RUNS, junit_document, junit_suite, trouble_of, xml_text
from cortex_dsl.version import VERSION

TAGS = {Outcome.FAIL: "failure", Outcome.ERROR: "error", Outcome.NOT_RUN: "skipped"}


def suite_junit_text(report: SuiteReport) -> str:
    """Return the document."""
    suites = [_suite(report, group) for group in report.groups]
    return junit_document(f"cortexc suite {report.suite}", report.seconds, suites)


def _suite(report: SuiteReport, group: GroupResult) -> Element:
    cases = [trouble_of(_named(report, f"{group.name}/{RUNS}"), group.trouble)] if group.trouble else []
    cases = cases or [_case(report, cell) for cell in group.cells]
    return junit_suite(group.name, group.seconds, _properties(report, group), cases)


def _properties(report: SuiteReport, group: GroupResult) -> Iterator[tuple[str, str]]:
    yield "seed", str(report.seed)
    yield "digest", group.digest
    yield "cortexc", VERSION
    yield "budget", report.budget
    yield "edition", report.edition


def _named(report: SuiteReport, name: str) -> Element:
    return Element("testcase", name=xml_text(name), classname=xml_text(report.suite))


def _case(report: SuiteReport, cell: CellResult) -> Element:
    case = _named(report, cell.id)
    if cell.outcome is Outcome.PASS:
        return case
    text = cell.reason or f"{cell.colour}: {cell.event}"
    part = SubElement(case, TAGS[cell.outcome], message=xml_text(text))
    if cell.outcome is not Outcome.NOT_RUN:
        part.set("type", cell.outcome.lower())
        replay = "" if cell.deviation is None else cell.deviation.replay
        part.text = xml_text(f"{text}\nreplay: {replay}" if replay else text)
    return case
