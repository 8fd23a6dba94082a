"""Annotations for GitHub: workflow commands that it shows next to a line of a file."""

from collections.abc import Sequence

from cortex_dsl.diagnostics import Diagnostic, Severity
from cortex_dsl.source import Source


def github_annotations(source: Source, diagnostics: Sequence[Diagnostic]) -> list[str]:
    """Return an annotation for each diagnostic."""
    lines = []
    for d in diagnostics:
        start, end = source.position(d.label.span.start), source.position(d.label.span.end)
        level = d.severity.value if d.severity in (Severity.ERROR, Severity.WARNING) else "notice"
        file = as_property(source.file(d.label.span.start).name)
        place = f"file={file},line={start.line},endLine={end.line},col={start.column}"
        if start.line == end.line:
            place += f",endColumn={max(end.column, start.column)}"
        text = ". ".join(part for part in (d.message, d.label.text, d.reason, d.cure) if part)
        lines.append(f"::{level} {place},title={as_property(d.code)}::{as_data(text)}")
    return lines


def as_data(text: str) -> str:
    """Return a text as the message of a workflow command."""
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def as_property(text: str) -> str:
    """Return a text as a property of a workflow command."""
    return as_data(text).replace(":", "%3A").replace(",", "%2C")
