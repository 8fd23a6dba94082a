"""The page of a comparison: its verdict, and for each file the conditions and the failures that differ."""

from cortex_dsl.report.blocks import Code, Facts, Title
from cortex_dsl.report.findings.comparison_report import Change, ComparisonReport, comparison_content
from cortex_dsl.report.findings.readable import counted
from cortex_dsl.report.page.markup import Element, element, folded, page, prose, top_bar
from cortex_dsl.report.page.render import nodes
from cortex_dsl.report.views.comparison import file_view
from engine.search.store import without_folders
from engine.strict_json import plain

SHOWN = 20
"""Kinds of each change."""
LIMITS = (
    "A pair counts if both runs count. Scenes that are invalid for A or B, or over which a driver failed, are not run.",
    "Failures that a search found are no sample: nothing can be estimated from their number.",
    "A result holds for these files, their distributions and this simulator.",
)


def comparison_page(report: ComparisonReport) -> str:
    """Return the page as text."""
    links = [(f"#file-{number}", file.path) for number, file in enumerate(report.files, start=1)]
    sections = [
        element("div", nodes(file_view(file, SHOWN, whole=True), 1), id=f"file-{number}")
        for number, file in enumerate(report.files, start=1)
    ]
    body = [
        top_bar([("#verdict", "Verdict"), *links[:6], ("#again", "Reproduce it")]),
        element("main", _hero(report), sections, nodes(_again(report), 1), _footer()),
    ]
    return page(
        f"{_name(report.a)} against {_name(report.b)}",
        body,
        {"compare": plain(comparison_content(report))},
        ("page.js",),
    )


def _hero(report: ComparisonReport) -> Element:
    tiles = [
        ("pairs", f"{report.pairs:,}"),
        ("files", f"{len(report.files):,}"),
        *((f"{change} failures", f"{report.count(change):,}") for change in Change),
    ]
    return element(
        "header",
        element("p", "Two drivers on the same scenes", class_="kicker"),
        element("h1", "A against B"),
        [
            element("p", prose(f"{text}; there is no paired test."), class_="caution")
            for text in report.not_deterministic
        ],
        element("p", "A: ", element("code", _name(report.a)), class_="description"),
        element("p", "B: ", element("code", _name(report.b)), class_="description"),
        element("p", f"{report.headline}.", class_="headline", id="verdict"),
        folded("What this does not show", element("ul", [element("li", text) for text in LIMITS])),
        nodes(Facts(tiles, tiles=True)),
        class_="hero",
    )


def _name(word: str) -> str:
    """Return the name of a side without the folders of this computer."""
    return without_folders(word)


def _again(report: ComparisonReport) -> Title:
    facts = [("seed", str(report.seed)), ("budget", report.budget), ("files", counted(len(report.files), "file"))]
    facts += [(file.path, f"programs {' and '.join(dict.fromkeys(file.digests))}") for file in report.files]
    note = "The number of pairs depends on the machine." if report.timed else "The same command gives the same page."
    return Title("Reproduce it", [Code(report.command), Facts(facts)], note, name="again")


def _footer() -> Element:
    return element("footer", "Written by cortexc. This file needs no network and contains all its data.")
