"""The sheet for an auditor, printed: one page of A4, whatever it is made of."""

import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from cortex_dsl.api.audit import audit_of_run
from cortex_dsl.api.runs import open_run
from cortex_dsl.report.findings.audit_report import (
    AuditReport,
    Cell,
    Event,
    NotRun,
    Provenance,
    failures_finding,
    probability_finding,
)
from cortex_dsl.report.page.audit_page import audit_page
from tests.audited import KINDS, audit

A4 = (595.0, 842.0)
"""[pt]"""


def pages(tab: Any) -> int:
    """Return the number of sheets of a printed page, and check their size."""
    printed = tab.pdf(prefer_css_page_size=True, print_background=True)
    sizes = re.findall(rb"/MediaBox\s*\[\s*0\s+0\s+([\d.]+)\s+([\d.]+)", printed)
    assert {(round(float(width)), round(float(height))) for width, height in sizes} == {A4}
    return len(sizes)


@pytest.mark.parametrize("kind", KINDS)
def test_the_sheet_is_one_page_of_a4(
    kind: str, tmp_path_factory: pytest.TempPathFactory, opened_tab: Callable[..., Any]
) -> None:
    """Nothing overflows, and no text is cut off at the right."""
    folder = tmp_path_factory.mktemp("sheet") / kind
    shutil.copytree(KINDS[kind](tmp_path_factory), folder)
    assert audit(folder) == 0
    tab = opened_tab(folder / "audit.html", width=900, height=1200)
    assert pages(tab) == 1
    assert tab.evaluate("document.querySelector('.sheet').scrollWidth <= document.querySelector('.sheet').clientWidth")


def crowded(report: AuditReport) -> AuditReport:
    """Return a report with as many and as long texts as a page may have."""
    long = "a very long name of a domain and of its cell that goes on and on, 120.5 to 130.5 km/h, "
    source = Provenance(
        "cortexc " + "very-long-name-of-a-scenario.scn --option value " * 20, long, {"a": "0" * 32}, 7, "0.2.0"
    )
    cells = [Cell(f"{long}{number}", 10 + number, number, 3) for number in range(60)]
    events = [Event(f"{long}{number}", number, 300, 2) for number in range(60)]
    many = (failures_finding(cells, "a broken `expect`", source, [long]), probability_finding(events, source))
    return replace(
        report,
        objective=long * 5,
        inputs=long * 20,
        platform=long * 20,
        result=long * 20,
        cautions=(long,) * 9,
        findings=(*many, *report.findings),
        not_run=tuple(NotRun(f"{long}{number}", long * 5, number) for number in range(30)),
    )


def test_many_and_long_texts_stay_on_one_page(
    tmp_path_factory: pytest.TempPathFactory, tmp_path: Path, opened_tab: Callable[..., Any]
) -> None:
    """What has no room is in the document."""
    report = crowded(audit_of_run(open_run(KINDS["search"](tmp_path_factory))))
    (tmp_path / "sheet.html").write_text(audit_page(report), encoding="utf-8")
    assert pages(opened_tab(tmp_path / "sheet.html", width=900, height=1200)) == 1
