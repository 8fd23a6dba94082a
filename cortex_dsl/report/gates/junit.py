"""The result of `cortexc test` as JUnit XML, as Jenkins reads it (its schema junit-10.xsd).

A file is a `testsuite`, each of its limits a `testcase`. A failure that is known, and an open decision that passes, is
`skipped`; a file with errors has one testcase with an `error`.
"""

from collections.abc import Iterable, Iterator, Sequence
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from cortex_dsl.report.findings.gate_report import CURED, Check, FileResult, GateReport, Status
from cortex_dsl.version import VERSION

RUNS = "runs"
"""Name of the testcase of a file that cannot be run."""
REPLACEMENT = "\ufffd"


def junit_text(report: GateReport) -> str:
    """Return the document."""
    return junit_document("cortexc test", report.seconds, [_suite(report, file) for file in report.files])


def _suite(report: GateReport, file: FileResult) -> Element:
    cases = [trouble_of(_named(file, RUNS), file.trouble)] if file.trouble else []
    cases = cases or [_case(report, file, check) for check in file.checks]
    return junit_suite(file.path, file.seconds, _properties(report, file), cases)


def _properties(report: GateReport, file: FileResult) -> Iterator[tuple[str, str]]:
    yield "seed", "" if file.kept else str(file.seed)
    yield "digest", file.digest
    yield "cortexc", VERSION
    yield "budget", report.budget
    yield "runs", str(file.runs)


def _named(file: FileResult, name: str) -> Element:
    return Element("testcase", name=xml_text(name), classname=xml_text(file.path.removesuffix(".scn")))


def _case(report: GateReport, file: FileResult, check: Check) -> Element:
    case = _named(file, check.name)
    skipped = check.status is Status.KNOWN or (check.status is Status.UNDECIDED and report.undecided_passes)
    if skipped:
        SubElement(case, "skipped", message=xml_text(f"{check.status}: {check.text}"))
    elif check.status in (Status.FAIL, Status.UNDECIDED):
        failure = SubElement(case, "failure", type=check.status.lower(), message=xml_text(check.text))
        failure.text = xml_text(details(check))
    elif check.cured and report.strict:
        SubElement(case, "failure", type="cured", message=CURED)
    return case


def details(check: Check) -> str:
    """Return the first failing run and its command, on lines of their own."""
    if check.first is None:
        return check.text
    return f"{check.first.text}\nreplay: {check.replay}"


# -- parts of every JUnit document -------------------------------------------------------------------------------------


def junit_document(name: str, seconds: float, suites: Sequence[Element]) -> str:
    """Return the document of test suites that took some time [s]."""
    root = Element("testsuites", name=xml_text(name), time=f"{seconds:.3f}")
    for count in ("tests", "failures", "errors"):
        root.set(count, str(sum(int(suite.get(count, "0")) for suite in suites)))
    root.extend(suites)
    indent(root)
    return "<?xml version='1.0' encoding='utf-8'?>\n" + tostring(root, encoding="unicode") + "\n"


def junit_suite(name: str, seconds: float, known: Iterable[tuple[str, str]], cases: Sequence[Element]) -> Element:
    """Return a test suite with its properties and counts; its testcases share its time [s]."""
    suite = Element("testsuite", name=xml_text(name))
    properties = SubElement(suite, "properties")
    for each, value in known:
        SubElement(properties, "property", name=each, value=xml_text(value))
    for case in cases:
        case.set("time", f"{seconds / max(1, len(cases)):.3f}")
    suite.extend(cases)
    suite.set("tests", str(len(cases)))
    for count, tag in {"failures": "failure", "errors": "error", "skipped": "skipped"}.items():
        suite.set(count, str(sum(case.find(tag) is not None for case in cases)))
    suite.set("time", f"{seconds:.3f}")
    return suite


def trouble_of(case: Element, trouble: str) -> Element:
    """Return the testcase of what cannot be run, with its error."""
    SubElement(case, "error", type="error", message=xml_text(trouble)).text = xml_text(trouble)
    return case


def xml_text(text: str) -> str:
    """Return a text in which characters that XML 1.0 forbids are replaced."""
    return "".join(letter if _is_allowed(ord(letter)) else REPLACEMENT for letter in text)


def _is_allowed(code: int) -> bool:
    """Return True for a character of XML 1.0 (production 2: Char)."""
    return code in (0x9, 0xA, 0xD) or 0x20 <= code <= 0xD7FF or 0xE000 <= code <= 0xFFFD or 0x10000 <= code <= 0x10FFFF
