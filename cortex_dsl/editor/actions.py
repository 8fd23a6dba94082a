"""What an editor can do to a text: lay it out, and cure what has a cure."""

import re
from collections.abc import Iterator
from dataclasses import dataclass

from cortex_dsl.diagnostics import CompileError, Diagnostic
from cortex_dsl.source import Source, Span
from cortex_dsl.spelling import nearest

_MEANT = re.compile(r"did you mean `([^`]+)`\?")
_WRITE = re.compile(r"write `([^`…]+)`")


@dataclass(frozen=True)
class Cure:
    """An edit that mends a diagnostic."""

    title: str
    span: Span
    text: str
    diagnostic: Diagnostic


def cures(source: Source, diagnostics: tuple[Diagnostic, ...], around: Span) -> Iterator[Cure]:
    """Cures of the diagnostics that touch a stretch of text, where one word has to be replaced by another."""
    for diagnostic in diagnostics:
        span = diagnostic.label.span
        if span.start > around.end or span.end < around.start or span.end > len(source.text):
            continue
        if meant := _MEANT.search(diagnostic.cure):
            wrong = _misspelt(source, span, meant[1])
            if wrong is not None:
                yield Cure(f"Write `{meant[1]}`", wrong, meant[1], diagnostic)
        elif (write := _WRITE.fullmatch(diagnostic.label.text)) and span.end > span.start:
            yield Cure(f"Write `{write[1]}`", span, write[1], diagnostic)


def _misspelt(source: Source, span: Span, meant: str) -> Span | None:
    """The word of a stretch of text that was meant to be another."""
    text = source.slice(span)
    if text and not re.search(r"[\s=(]", text):
        return span
    for word in re.finditer(r"\w+", text):
        if nearest(word.group(), [meant]) and word.group() != meant:
            return Span(span.start + word.start(), span.start + word.end())
    return None


def formatted(name: str, text: str) -> str | None:
    """The text laid out; None where it cannot be, because it is broken."""
    from cortex_dsl.syntax.formatting import format_source

    try:
        return format_source(Source(name, text))
    except CompileError:
        return None
