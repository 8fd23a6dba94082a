"""The result of `cortexc suite` as JUnit XML: a group is a `testsuite`, each of its cells a `testcase`."""

from xml.etree.ElementTree import Element, SubElement, indent, tostring

from cortex_dsl.report.findings.suite_report import CellResult, GroupResult, Outcome, SuiteReport
from cortex_dsl.report.gates.junit import xml_text
from cortex_dsl.version import VERSION

TAGS = {Outcome.FAIL: "failure", Outcome.ERROR: "error", Outcome.NOT_RUN: "skipped"}


def suite_junit_text(report: SuiteReport) -> str:
    """Return the document."""
    root = Element("testsuites", name=xml_text(f"cortexc suite {report.suite}"), time=f"{report.seconds:.3f}")
    suites = [_suite(report, group) for group in report.groups]
    for name in ("tests", "failures", "errors"):
        root.set(name, str(sum(int(suite.get(name, "0")) for suite in suites)))
    root.extend(suites)
    indent(root)
    return "<?xml version='1.0' encoding='utf-8'?>\n" + tostring(root, encoding="unicode") + "\n"


def _suite(report: SuiteReport, group: GroupResult) -> Element:
    suite = Element("testsuite", name=xml_text(group.name), time=f"{group.seconds:.3f}")
    known = {
        "seed": str(report.seed), "digest": group.digest, "cortexc": VERSION, "budget": report.budget,
        "edition": report.edition,
    }  # fmt: skip
    properties = SubElement(suite, "properties")
    for name, value in known.items():
        SubElement(properties, "property", name=name, value=xml_text(value))
    share = f"{group.seconds / max(1, len(group.cells)):.3f}"
    suite.extend(_case(report, cell, share) for cell in group.cells)
    suite.set("tests", str(len(group.cells)))
    for outcome, tag in TAGS.items():
        name = tag if tag == "skipped" else f"{tag}s"
        suite.set(name, str(sum(cell.outcome is outcome for cell in group.cells)))
    return suite


def _case(report: SuiteReport, cell: CellResult, time: str) -> Element:
    case = Element("testcase", name=xml_text(cell.id), classname=xml_text(report.suite), time=time)
    if cell.outcome is Outcome.PASS:
        return case
    text = cell.reason or f"{cell.colour}: {cell.event}"
    part = SubElement(case, TAGS[cell.outcome], message=xml_text(text))
    if cell.outcome is not Outcome.NOT_RUN:
        part.set("type", cell.outcome.lower())
        part.text = xml_text("" if cell.deviation is None else f"replay: {cell.deviation.replay}")
    return case
