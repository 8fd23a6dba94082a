"""The tables of a study on its page: the primary outcomes, every test, random sampling, and the comparison with the
paper.
"""

from cortex_dsl.report.findings.readable import counted, fixed, percent, ratio
from cortex_dsl.report.findings.search_report import method_name
from cortex_dsl.report.findings.study_report import differences, p_text, quartiles, value_text, yields_text
from cortex_dsl.report.page.markup import Element, Node, element, figure, part, table
from engine.search.statistics import Interval
from engine.study.comparisons import NAMED_FIRST, Comparison, Spread
from engine.study.database import Study
from engine.study.verdict import Beside, Findings


def primary(study: Study, found: Findings) -> Node:
    """Return the section on outcomes that were named before the study, with a table for each."""
    if not found.comparisons:
        return None
    head = (
        "scenario",
        "method",
        "median",
        "middle half",
        study.plan.baseline,
        "middle half",
        "p, Holm",
        "A12",
        "95 %",
        "",
    )
    tables: list[Node] = []
    for measure in NAMED_FIRST:
        rows = [_primary_row(row) for row in found.comparisons if row.measure is measure]
        name = element("b", f"{measure.name[0].upper()}{measure.name[1:]}")
        tables += [element("p", name, f": {measure.meaning}.", class_="note"), table(head, rows, "tests")]
    note = (
        "Four outcomes named before the study was run, one family of tests: avoidable collisions, which count against "
        "the ego, and their kinds; then the yield, genomes that may differ in a single bit, and its variety."
    )
    work = [element("p", f"{text}.", class_="note") for text in yields_text(study.plan, study.records)]
    return part("primary", "Which method finds more", note, tables, work)


def _primary_row(row: Comparison) -> Element:
    return element(
        "tr",
        element("th", row.scenario, scope="row"),
        element("td", method_name(row.method)),
        element("td", _figure(row, "median", row.spread.median), class_="number"),
        element("td", _quartiles(row.spread, row), class_="number quiet"),
        element("td", value_text(row.baseline_spread.median, row), class_="number"),
        element("td", _quartiles(row.baseline_spread, row), class_="number quiet"),
        element("td", p_text(row.p_holm), " ", element("b", row.marks), class_="number"),
        element("td", fixed(row.a12, 2), class_="number"),
        element("td", _interval(row.interval), class_="number quiet"),
        element("td", row.words, class_="verdict-word"),
    )


def _figure(row: Comparison, field: str, value: float) -> Node:
    name = f"{row.scenario}.{row.method}.{row.measure.name}.{field}"
    return figure(name, value, value_text(value, row))


def _quartiles(spread: Spread, row: Comparison) -> str:
    return " to ".join(quartiles(spread, row))


def _interval(interval: Interval) -> str:
    return f"{fixed(interval.low, 2)} to {fixed(interval.high, 2)}"


def _missing(row: Comparison) -> Node:
    """Return the runs that have no number and rank last."""
    return element("small", f" {row.missing}", class_="quiet") if row.missing else None


def tests(found: Findings) -> Node:
    if not found.comparisons:
        return None
    rows = [
        element(
            "tr",
            element("td", row.scenario),
            element("td", row.title, element("small", f" {row.measure.unit}", class_="quiet")),
            element("td", "exploratory" if row.measure.exploratory else row.measure.family, class_="quiet"),
            element("td", row.method),
            element("td", _figure(row, "median", row.spread.median), class_="number"),
            element("td", value_text(row.baseline_spread.median, row), class_="number"),
            element("td", p_text(row.p), class_="number quiet"),
            element("td", p_text(row.p_holm), " ", element("b", row.marks), class_="number"),
            element("td", fixed(row.a12, 2), class_="number"),
            element("td", _interval(row.interval), class_="number quiet"),
            element("td", row.words, _missing(row)),
        )
        for row in found.comparisons
        if row.measure not in NAMED_FIRST
    ]
    head = (
        "scenario",
        "measure",
        "role",
        "method",
        "median",
        found.comparisons[0].baseline,
        "p",
        "p, Holm",
        "A12",
        "95 %",
        "",
    )
    note = (
        "Two-sided Mann-Whitney tests, Holm's correction in each family; ▲ and A12 above 0.5: the method is better. "
        "Exploratory tests suggest, and show nothing by themselves: picking one of their families afterwards is not "
        "corrected for."
    )
    inner = element("details", element("summary", counted(len(rows), "test")), table(head, rows, "tests"))
    return part("tests", "Every test", note, inner)


def rates(found: Findings) -> Node:
    if not found.rates:
        return None
    rows = [
        element(
            "tr",
            element("th", row.scenario, scope="row"),
            element("td", percent(ratio(row.valid, row.individuals)), class_="number"),
            element("td", _percents(row.valid_rate), class_="number quiet"),
            element("td", percent(ratio(row.collisions, row.valid)), class_="number"),
            element("td", _percents(row.collision_rate), class_="number quiet"),
        )
        for row in found.rates
    ]
    head = ("scenario", "valid", "95 %", "collide, of valid", "95 %")
    note = "Outcomes of uniformly random sets of params: independent draws, Clopper-Pearson intervals."
    return part("rates", "Random sampling", note, table(head, rows, "rates"))


def _percents(interval: Interval) -> str:
    return f"{percent(interval.low)} to {percent(interval.high)}"


def paper(found: Findings) -> Node:
    """Return our numbers next to the paper's, and the paper's table of studies with our row."""
    if not found.beside:
        return None
    beside = [
        element(
            "tr",
            element("th", _named(row) if before is None or before.letter != row.letter else "", scope="row"),
            element("td", row.measure.name, element("small", f" {row.measure.unit}", class_="quiet")),
            *(_cell(value, row.measure.decimals) for value in (row.ga, row.random)),
            _cell(row.ratio, 2),
            *(_cell(value, row.measure.decimals) for value in (row.paper_ga, row.paper_random)),
            _cell(row.paper_ratio, 2),
            element("td", "" if row.same_direction else "opposite", class_="verdict-word"),
            class_="begins" if before is not None and before.letter != row.letter else None,
        )
        for before, row in zip((None, *found.beside), found.beside, strict=False)
    ]
    studies = [element("tr", [element("td", str(value)) for value in vars(row).values()]) for row in found.studies]
    head = ("", "metric", "GA", "random", "ratio", "paper: GA", "paper: random", "paper: ratio", "")
    others = ("study", "test cases", "seconds each", "collisions", "valid", "metrics")
    note = "Medians of our runs and the paper's one run. The simulators differ: compare directions, not sizes."
    return part(
        "paper",
        "Compared with the paper",
        note,
        table(head, beside, "beside"),
        element("ul", [element("li", line) for line in differences(found.beside)], class_="note"),
        element("h3", "Among other studies", class_="sub"),
        table(others, studies, "studies"),
    )


def _named(row: Beside) -> Element:
    """The paper's letter, with the file as its tooltip."""
    return element("abbr", row.letter, title=row.scenario)


def _cell(value: float, decimals: int) -> Element:
    return element("td", fixed(value, decimals), class_="number")
