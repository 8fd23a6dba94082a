"""The page for an auditor: one sheet of A4, on which each number names its source by a letter."""

import math
from collections.abc import Iterator

from cortex_dsl.report.blocks import Words, parts_of
from cortex_dsl.report.blocks import plain as plain_text
from cortex_dsl.report.findings.audit_report import (
    ISO_34505,
    TITLES,
    AuditReport,
    Bar,
    Finding,
    NotRun,
    Provenance,
    audit_content,
)
from cortex_dsl.report.findings.coverage_report import percent
from cortex_dsl.report.findings.readable import shortened
from cortex_dsl.report.page.markup import Element, Node, element, page, prose, style, text
from cortex_dsl.report.page.render import words_of
from cortex_dsl.version import VERSION
from engine.strict_json import plain

LETTERS = "ABCDEFGHIJ"
FIELD, REASON, COMMAND, OBJECTIVE, CAUTION = 180, 150, 260, 110, 220
"""Characters of a field of the case, of a reason, of a command and so on at most; the document has the whole text."""
NOT_RUN = 5
"""Parts that were not run on the page at most; numbers without a value name their reason themselves."""
CAUTIONS = 3
SIZE, ROOM = 7.9, 73.0
"""Size of the type [pt], and lines of it that a sheet has room for; more lines are set in smaller type."""
LIMITS = (
    "Draws are independent and spread as the file states, which is no model of traffic unless an exposure says so. "
    "A result holds for these scenes, this driver and this simulator."
)


def audit_page(report: AuditReport, document: str = "audit.json") -> str:
    """Return the page as text; `document` is the name of its document."""
    parts = _head(report), _numbers(report), _not_run(report), _sources(report, document)
    body = element("main", parts, class_="sheet", style=f"font-size:{_type_size(report):.2f}pt")
    content = {"audit": plain(audit_content(report))}
    return page(f"Audit: {report.objective}", body, content, (), report.journal, style(text("audit.css")))


def _type_size(report: AuditReport) -> float:
    """Return the size of the type in which the contents fit on the sheet [pt].

    Lines are counted from the numbers of characters that fit into each column at `SIZE`; in smaller type more of them
    do, so that the estimate errs to the safe side.
    """
    rows = sum(max(_height(TITLES[each.topic][1], 46) * 0.8 + 1.0, _value_height(each)) for each in report.findings)
    fields = _fields(report)[:-1]
    heights = [_height(shortened(text, FIELD), 42) + 0.4 for _, text in fields]
    case = sum(max(pair) for pair in zip(heights[::2], heights[1::2], strict=True))
    head = 2.2 * _height(shortened(report.objective, OBJECTIVE), 58) + case
    head += _height(shortened(report.result, FIELD), 95) + sum(
        _height(shortened(each, CAUTION), 110) + 0.6 for each in report.cautions[:CAUTIONS]
    )
    left = sum(
        _height(f"{shortened(each.what, 60)}: {shortened(each.reason, REASON)}", 125)
        for each in _parts(report)[:NOT_RUN]
    )
    sources = sum(
        _height(shortened(each.command, COMMAND), 110) + _height(_source_text(each), 115) + 0.3
        for each in report.sources
    )
    lines = rows + 0.8 * len(report.findings) + head + 0.9 * (left + sources + 9.0) + 4.0
    return SIZE * min(1.0, ROOM / lines)


def _height(text: str, room: int) -> int:
    """Return the lines of a text in a column of so many characters."""
    return max(1, math.ceil(len(text) / room))


def _value_height(finding: Finding) -> float:
    if finding.reason:
        return float(_height(f"not available: {shortened(finding.reason, REASON)}", 80))
    bars = len(finding.bars)
    return float(sum(_height(plain_text(line), 55 if n < bars else 80) for n, line in enumerate(finding.lines)))


def _fields(report: AuditReport) -> tuple[tuple[str, str], ...]:
    return (
        ("id", report.id),
        ("scenario", report.scenario),
        ("inputs", report.inputs),
        ("steps", report.steps),
        ("platform", report.platform),
        ("expected result", report.expected),
        ("result", report.result),
    )


def _head(report: AuditReport) -> Element:
    return element(
        "header",
        element("p", element("b", "Audit sheet"), f" of a {report.kind}, by cortexc {VERSION}", class_="kicker"),
        element("h1", shortened(report.objective, OBJECTIVE)),
        [element("p", shortened(each, CAUTION), class_="caution") for each in report.cautions[:CAUTIONS]],
        element(
            "dl",
            [
                element("div", element("dt", name), element("dd", shortened(value, FIELD)))
                for name, value in _fields(report)
            ],
        ),
    )


def _numbers(report: AuditReport) -> Element:
    letters = {each.command: letter for letter, each in zip(LETTERS, report.sources, strict=False)}
    rows = [_row(each, letters.get(each.source.command, "") if each.source else "") for each in report.findings]
    return element("table", element("tbody", rows), class_="numbers")


def _row(finding: Finding, letter: str) -> Element:
    title, method = TITLES[finding.topic]
    if finding.reason:
        value: Node = element("p", "not available: ", prose(shortened(finding.reason, REASON)), class_="missing")
    else:
        value = list(_lines(finding))
    return element(
        "tr",
        element("th", title, element("small", method), scope="row"),
        element("td", value),
        element("td", letter, class_="letter"),
        id=finding.topic.value,
    )


def _lines(finding: Finding) -> Iterator[Node]:
    """Yield the lines of a number, with intervals on one scale, whose upper end stands beside the first."""
    bars = finding.bars
    high = _scale(max((max(abs(bar.low), abs(bar.high)) for bar in bars), default=0.0))
    low = -high if any(bar.low < 0.0 for bar in bars) else 0.0
    for number, line in enumerate(finding.lines):
        quiet = not any(part.number is not None for part in parts_of(line))
        drawn: list[Node] = []
        if number < len(bars):
            drawn = [_bar(bars[number], low, high), element("small", percent(high) if number == 0 else "")]
        yield element("p", element("span", _words(line)), drawn, class_="line quiet" if quiet else "line")


def _words(line: Words) -> list[Node]:
    """Return the nodes of a line; text between backticks is code."""
    return [words_of(part) if part.number is not None else prose(part.text) for part in parts_of(line)]


def _scale(most: float) -> float:
    """Return the least of 1, 2 or 5 times a power of ten, and of 1, that is not below a share."""
    power = 10.0 ** math.floor(math.log10(max(most, 1e-9)))
    return min(1.0, next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= most * (1.0 - 1e-9)))


def _bar(bar: Bar, low: float, high: float) -> Element:
    """Return an interval with its estimate, and a line at 0 if the scale has both signs."""

    def place(value: float) -> str:
        return f"left:{100.0 * (min(max(value, low), high) - low) / (high - low):.1f}%"

    width = max(100.0 * (bar.high - bar.low) / (high - low), 0.8)
    zero = element("u", style=place(0.0)) if low < 0.0 else None
    interval = element("i", style=f"{place(bar.low)};width:{width:.1f}%")
    return element("span", zero, interval, element("b", style=place(bar.point)), class_="bar")


def _not_run(report: AuditReport) -> Element:
    missing = sum(bool(each.reason) for each in report.findings)
    parts = _parts(report)
    items = [
        element(
            "li",
            element("b", f"{each.count:,} " if each.count is not None else "", shortened(each.what, 60)),
            ": ",
            prose(shortened(each.reason, REASON)),
        )
        for each in parts[:NOT_RUN]
    ]
    if len(parts) > NOT_RUN:
        items.append(element("li", f"and {len(parts) - NOT_RUN} more reasons, in the document"))
    if not parts:
        items.append(element("li", "everything else was run"))
    numbers = f"{missing} of the {len(report.findings)} numbers above are not available, for the reasons there"
    return element("section", element("h2", "Not run"), element("ul", items, element("li", numbers)))


def _parts(report: AuditReport) -> list[NotRun]:
    """Return the parts that were not run and have no row among the numbers."""
    rows = {each.topic.value for each in report.findings if each.reason}
    return [each for each in report.not_run if each.what not in rows]


def _sources(report: AuditReport, document: str) -> Element:
    return element(
        "section",
        element("h2", "Sources"),
        element("p", "The same commands give the same numbers, but for the computing time.", class_="note"),
        element("ol", [_source(*pair) for pair in zip(LETTERS, report.sources, strict=False)]),
        element("p", LIMITS, " ", prose(ISO_34505), class_="note"),
        element("p", "All numbers, digests and reasons: ", element("code", document), class_="note"),
    )


def _source(letter: str, source: Provenance) -> Element:
    return element(
        "li",
        element("b", letter),
        element("div", element("code", shortened(source.command, COMMAND)), element("span", _source_text(source))),
    )


def _source_text(source: Provenance) -> str:
    """Return file, digest, seed, version and tables of a source."""
    common = f", common digest of {len(source.digests)} programs" if len(source.digests) > 1 else ""
    parts = [
        source.file,
        f"program {source.digest}{common}" if source.digest else "",
        f"seed {source.seed}" if source.seed is not None else "",
        f"cortexc {source.version}" if source.version else "",
        f"from {', '.join(source.tables)}" if source.tables else "",
    ]
    return shortened(" · ".join(part for part in parts if part), COMMAND)
