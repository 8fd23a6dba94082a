"""The files of an export: sizes, commands to open them, limits of the formats, findings of the check."""

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from shlex import quote
from typing import TYPE_CHECKING

from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.findings.interchange_report import (
    Exported,
    Finding,
    Gathered,
    Written,
    size_text,
)
from cortex_dsl.report.findings.readable import counted
from cortex_dsl.report.terminal.theme import columns, heading, indented, left, right, section

if TYPE_CHECKING:
    from engine.interchange.contract import ExportOptions


MOST_FILES = 40
"""Maximum number of files that are shown of a long list."""


def export_view(written: Written, how: "ExportOptions") -> RenderableType:
    """The whole report; `how` the files were written. Print it without cropping: paths and commands are not broken."""
    one = written.cases[0] if len(written.cases) == 1 else None
    title = one.recording.name if one else counted(len(written.cases), "case")
    parts: list[RenderableType] = [heading(title, f"risk {_risk(one)}" if one else "")]
    parts += [Text(), _line(heading(f"{written.folder}{os.sep}", _unchanged(written))), indented(_files(written))]
    parts += [Text(), heading("to open"), *_openings(written)]
    if written.gathered.remarks:
        parts.append(
            section("what these formats leave out or change", _format_remarks(written), note=_version(written, how))
        )
    if written.certificates:
        rows = [(Text(each.file, "title"), Text(each.line)) for each in written.certificates[:MOST_FILES]]
        parts.append(section("played by esmini", columns(left(), left(wrap=True), rows=rows)))
    if written.findings is not None:
        parts.append(_check(written.findings, written.checked))
    return Group(*parts)


def _line(text: Text) -> Text:
    """A text that is copied as a whole, however long."""
    text.no_wrap, text.overflow = True, "ignore"
    return text


def _risk(case: Exported) -> str:
    return case.recording.provenance.facts.get("risk", "")


def _unchanged(written: Written) -> str:
    return "all were there before, the same" if len(written.same) == len(written.gathered.files) else ""


def _version(written: Written, how: "ExportOptions") -> str:
    return f"OpenSCENARIO {how.osc}, {how.mode} mode" if "xosc" in written.gathered.formats.values() else ""


def _files(written: Written) -> RenderableType:
    files = list(written.gathered.files.items())
    rows = [
        (
            Text(name),
            Text(size_text(len(content)), "unit"),
            Text("as it was" if name in written.same else "", "quiet"),
        )
        for name, content in files[:MOST_FILES]
    ]
    if len(files) > MOST_FILES:
        rows.append((Text(f"and {len(files) - MOST_FILES:,} more", "quiet"), Text(), Text()))
    return columns(left(wrap=True), right(), left(), rows=rows)


def _openings(written: Written) -> Iterator[Text]:
    """One line a format, for its first file."""
    first = _first_files(written.gathered)
    width = max(map(len, first), default=0)
    for name, file in first.items():
        command = written.opened[name].format(file=quote(str(written.folder / file)))
        yield _line(Text.assemble(f"  {name:<{width}}  ", command))


def _first_files(gathered: Gathered) -> dict[str, str]:
    """By format, the first of the files that it alone brings, or shares."""
    first: dict[str, str] = {}
    for file, name in gathered.formats.items():
        first.setdefault(name, file)
    return first


def _format_remarks(written: Written) -> RenderableType:
    """Return each remark once, after its format; remarks that differ only in numbers are merged."""
    alike: dict[tuple[str, str], list[tuple[str, Sequence[int]]]] = {}
    for (name, sentence), numbers in sorted(written.gathered.remarks.items(), key=lambda item: item[0][0]):
        key = name, re.sub(r"\d+(\.\d+)?", "#", sentence)
        alike.setdefault(key, []).append((sentence, numbers))
    rows, before = [], ""
    for (name, _), same in alike.items():
        text = Text.assemble(same[0][0], (_of_which(written, [n for _, n in same]), "quiet"))
        rows.append((Text("" if name == before else name, "title"), text))
        before = name
    return columns(left(), left(wrap=True), rows=rows)


def _of_which(written: Written, groups: Sequence[Sequence[int]]) -> str:
    """Which cases a sentence is of, unless it is of all; of several alike it has the numbers of the first."""
    ranks = [str(written.cases[number].rank) for group in groups for number in group]
    if len(groups) > 1:
        return f" (case {ranks[0]}; {counted(len(ranks) - 1, 'other')} likewise)"
    if len(ranks) == len(written.cases):
        return ""
    return f" (case{'' if len(ranks) == 1 else 's'} {', '.join(ranks[:5])}{', …' if len(ranks) > 5 else ''})"


def _check(findings: Sequence[Finding], checked: Mapping[str, str]) -> RenderableType:
    """Return the findings of the check and its scope; no finding proves no more than that scope."""
    rows = [(Text(name, "title"), Text(what, "quiet")) for name, what in checked.items()]
    looked_at = columns(left(), left(wrap=True), rows=rows)
    if not findings:
        return Group(Text(), Text("checked: no finding", "good"), indented(looked_at))
    return section("check", Group(*_findings(findings), Text(), looked_at), note=counted(len(findings), "finding"))


def _findings(findings: Sequence[Finding]) -> Iterator[Text]:
    for finding in findings:
        yield Text.assemble((finding.place, "title"), ": ", (finding.reason, "bad"))
        if finding.cure:
            yield Text(f"  help: {finding.cure}", "quiet")
