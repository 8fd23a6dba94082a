"""The result as a table: for the terminal, and as Markdown for the page of the exports."""

from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

from benchmarks.validation.checks import Verdict
from benchmarks.validation.environments import version_of

BEGIN, END = "<!-- validation: begin -->", "<!-- validation: end -->"
SHOWN = 4
"""Findings that are printed of each verdict."""


def show(verdicts: Sequence[Verdict], console: Console) -> None:
    """The table, and under it the first findings of each kind of file."""
    table = Table("checker", "held against it", "asked for", "files", "findings")
    for verdict in verdicts:
        count = sum(map(len, verdict.findings.values()))
        style = "red" if count else "green"
        table.add_row(
            _checker(verdict, brief=True),
            _kind(verdict),
            verdict.check.what,
            str(verdict.files),
            f"[{style}]{count}[/]",
        )
    console.print(table)
    for verdict in verdicts:
        _show_findings(verdict, console)


def _show_findings(verdict: Verdict, console: Console) -> None:
    if not verdict.findings:
        return
    console.print(f"\n{verdict.check.title}, {verdict.kind}: {len(verdict.findings)} files with findings", style="bold")
    for file, found in list(verdict.findings.items())[:SHOWN]:
        console.print(f"  {file}", style="dim", highlight=False)
        for finding in found[:SHOWN]:
            console.print(f"    {finding}", markup=False, highlight=False)


def markdown(verdicts: Sequence[Verdict]) -> str:
    """The same table for a page."""
    lines = ["| checker | held against it | asked for | files | findings |", "|---|---|---|---|---|"]
    for verdict in verdicts:
        count = sum(map(len, verdict.findings.values()))
        what = f"{_checker(verdict)} | {_kind(verdict)} | {verdict.check.what}"
        lines.append(f"| {what} | {verdict.files} | {count} |")
    return "\n".join(lines)


def write(page: Path, text: str) -> None:
    """Put a table between the markers of a page."""
    before, begin, rest = page.read_text(encoding="utf-8").partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end):
        raise ValueError(f"{page} has no markers `{BEGIN}` and `{END}`")
    page.write_text(f"{before}{BEGIN}\n{text}\n{END}{after}", encoding="utf-8")


def _kind(verdict: Verdict) -> str:
    """`replay, 1.0 to 1.3`."""
    versions = verdict.versions
    return f"{verdict.kind}, {versions[0]} to {versions[-1]}" if len(versions) > 1 else verdict.kind


def _checker(verdict: Verdict, brief: bool = False) -> str:
    """`SUMO's netconvert (eclipse-sumo 1.28.0)`, or without the name of the package."""
    title, name = verdict.check.title, verdict.check.checker
    if not name:
        return title
    version = version_of(name)
    return f"{title} {version.split()[-1]}" if brief else f"{title} ({version})"
