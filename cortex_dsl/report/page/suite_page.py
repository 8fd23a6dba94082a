"""The page of a suite: its verdict, the points, and all cells with their sources."""

from cortex_dsl.report.blocks import Code, Facts, Title
from cortex_dsl.report.findings.suite_report import Outcome, SuiteReport, suite_content
from cortex_dsl.report.page.markup import Element, element, folded, page, prose, top_bar
from cortex_dsl.report.page.render import nodes
from cortex_dsl.report.views.suite import group_view, suite_view
from engine.search.store import without_folders
from engine.strict_json import plain

LIMITS = (
    "A cell that is not run has no verdict and counts as red in the points.",
    "Cells marked (?) have values that were not read in the document.",
    "The probability of a failure is that of deviations that are uniform within the tolerances of the document.",
    "A driver that brakes without a cause passes: tests of false activation are not among the cells that are run.",
    "The least deviation is the least one that a search found; there may be lesser ones.",
    "A result holds for this driver, these scenarios and this simulator; it is no official rating.",
)


def suite_page(report: SuiteReport) -> str:
    """Return the page as text."""
    groups = [element("div", nodes(group_view(group), 1)) for group in report.groups if group.file]
    body = [
        top_bar([("#verdict", "Verdict"), ("#cells", "Cells"), ("#again", "Reproduce it")]),
        element(
            "main",
            _hero(report),
            nodes(suite_view(report, None), 1),
            element("div", groups, id="cells"),
            nodes(_again(report), 1),
            element("footer", "Written by cortexc. This file needs no network and contains all its data."),
        ),
    ]
    return page(
        f"{report.suite}: {without_folders(report.driver)}", body, {"suite": plain(suite_content(report))}, ("page.js",)
    )


def _hero(report: SuiteReport) -> Element:
    tiles = [(str(outcome), f"{report.count(outcome):,}") for outcome in Outcome]
    if report.points is not None:
        tiles.append(("points of these cells", f"{report.points:.3f}"))
    return element(
        "header",
        element("p", report.edition, class_="kicker"),
        element("h1", report.title),
        element("p", "Driver: ", element("code", without_folders(report.driver)), class_="description"),
        [element("p", prose(f"{remark}."), class_="caution") for remark in report.remarks],
        element("p", f"{report.headline}.", class_="headline", id="verdict"),
        folded(
            "What this does not show", element("ul", [element("li", prose(text)) for text in (*LIMITS, *report.notes)])
        ),
        nodes(Facts(tiles, tiles=True)),
        class_="hero",
    )


def _again(report: SuiteReport) -> Title:
    facts = [("seed", str(report.seed)), ("budget", report.budget)]
    facts += [(group.name, f"{group.file}, program {group.digest}") for group in report.groups if group.file]
    note = "The number of runs depends on the machine." if report.timed else "The same command gives the same page."
    return Title("Reproduce it", [Code(report.command), Facts(facts)], note, name="again")
