"""The result of `cortexc suite` as JUnit XML: a group is a `testsuite`, each of its cells a `testcase`.

A group whose scenario has errors, or in which the driver cannot drive, has one testcase with an `error`.
"""

from xml.etree.ElementTree import Element, SubElement, indent, tostring

from cortex_dsl.report.findings.suite_report import CellResult, GroupResult, Outcome, SuiteReport
from cortex_dsl.report.gates.junit import RUNS, xml_text
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
    cases = [_trouble(report, group)] if group.trouble else [_case(report, cell) for cell in group.cells]
    share = f"{group.seconds / max(1, len(cases)):.3f}"
    for case in cases:
        case.set("time", share)
    suite.extend(cases)
    suite.set("tests", str(len(cases)))
    for tag in TAGS.values():
        name = tag if tag == "skipped" else f"{tag}s"
        suite.set(name, str(sum(case.find(tag) is not None for case in cases)))
    return suite


def _named(report: SuiteReport, name: str) -> Element:
    return Element("testcase", name=xml_text(name), classname=xml_text(report.suite))


def _trouble(report: SuiteReport, group: GroupResult) -> Element:
    case = _named(report, f"{group.name}/{RUNS}")
    text = xml_text(group.trouble)
    SubElement(case, "error", type="error", message=text).text = text
    return case


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
