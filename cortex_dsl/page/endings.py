"""The last sections of a run's page: how its runs ended, and how to do it all again."""

from shlex import quote

from cortex_dsl.page import commands, run_charts
from cortex_dsl.page.document import part
from cortex_dsl.page.element import Element, element
from cortex_dsl.report.ends import End, ends_of
from cortex_dsl.runs import OpenedRun
from engine.vocabulary import EndReason, Verdict

STREAMS = (
    "seed.method.run.generation.index.rollout: each scene draws from a stream of its own, so results depend neither on "
    "threads nor on order"
)


def ends(run: OpenedRun) -> Element:
    rows, whole = how_runs_ended(run)
    note = "Every distinct simulation, by what became of it."
    return part("ends", "How runs ended", note, run_charts.bars(rows, whole))


def how_runs_ended(run: OpenedRun) -> tuple[list[tuple[str, int, str]], int]:
    """(words, count, style) of each end, most frequent first, and how many there are."""
    rows = [(*_words(end), end.count) for end in ends_of(run.scenario.program, run.record.evaluations)]
    return [(text, count, style) for text, style, count in rows], sum(count for _, _, count in rows)


def _words(end: End) -> tuple[str, str]:
    if end.reason is None:
        return run_charts.VERDICTS[end.verdict], "invalid"
    style = "hit" if end.reason == EndReason.COLLISION else "" if end.verdict == Verdict.VALID else "invalid"
    return end.text, style


def again(run: OpenedRun) -> Element:
    manifest, folder = run.record.manifest, run.folder
    command = commands.again(manifest.command_line) if manifest.command_line else ""
    facts = [
        ("file", manifest.file),
        ("digest of the text", manifest.file_digest),
        ("digest of the program", manifest.program_digest),
        ("seed, run", f"{manifest.seed}, {manifest.run}"),
        ("risk profile", manifest.profile),
        ("versions", ", ".join(f"{name} {version}" for name, version in manifest.versions.items())),
        ("platform", manifest.platform),
        (
            "stream keys",
            STREAMS,
        ),
    ]
    settings = [
        element("tr", element("th", f"{group}.{name}", scope="row"), element("td", str(value)))
        for group, table in manifest.settings.items()
        for name, value in table.items()
    ]
    rows = [element("tr", element("th", name, scope="row"), element("td", value)) for name, value in facts]
    edited = [
        element(
            "p",
            f"{name} says something else today than when this run was started; the text below is that of the run.",
            class_="note",
        )
        for name in run.edited
    ]
    return part(
        "again",
        "Do it again",
        "The same command gives the same journal, row by row.",
        element("pre", command, class_="command") if command else None,
        element("pre", f"cortexc report {quote(str(folder))}", class_="command"),
        edited,
        element("div", element("table", element("tbody", rows), class_="facts"), class_="wide"),
        element(
            "details", element("summary", "Every setting"), element("table", element("tbody", settings), class_="facts")
        ),
        element("details", element("summary", "The scenario"), element("pre", manifest.file_text, class_="source")),
    )
