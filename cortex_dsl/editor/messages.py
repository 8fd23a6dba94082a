"""From the analysis to the types of the language server protocol, including quick fixes."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from lsprotocol import types
from pygls import uris

from cortex_dsl.diagnostics import CompileError, Diagnostic, Severity
from cortex_dsl.editor.analysis import Analysis
from cortex_dsl.editor.completion import Candidate
from cortex_dsl.editor.navigation import Outline, Target, target_of
from cortex_dsl.editor.open_files import OpenFile, Positions
from cortex_dsl.editor.symbols import SymbolKind
from cortex_dsl.semantics.errors.names import UNUSED_BEHAVIOUR, UNUSED_GENE
from cortex_dsl.semantics.names.linking import import_statements
from cortex_dsl.source import Source, Span
from cortex_dsl.spelling import nearest

# -- Operations of an editor on a text: formatting, and applying cures -------------------------------------------------

_MEANT = re.compile(r"did you mean `([^`]+)`\?")
_WRITE = re.compile(r"write `([^`…]+)`")


@dataclass(frozen=True)
class Cure:
    """An edit that solves a diagnostic."""

    title: str
    span: Span
    text: str
    diagnostic: Diagnostic


def cures(source: Source, diagnostics: tuple[Diagnostic, ...], around: Span) -> Iterator[Cure]:
    """Yield the cures of the diagnostics that touch a stretch of text and replace one word by another."""
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
    """Return the word in a stretch of text that resembles the intended one."""
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


# -- Messages of the server --------------------------------------------------------------------------------------------

SOURCE = "cortexc"
SEVERITIES = {
    Severity.ERROR: types.DiagnosticSeverity.Error,
    Severity.WARNING: types.DiagnosticSeverity.Warning,
    Severity.NOTE: types.DiagnosticSeverity.Information,
    Severity.HINT: types.DiagnosticSeverity.Hint,
}
UNUSED = (UNUSED_BEHAVIOUR.code, UNUSED_GENE.code)
ITEM_KINDS = {
    "keyword": types.CompletionItemKind.Keyword,
    "unit": types.CompletionItemKind.Unit,
    "attribute": types.CompletionItemKind.Property,
    "property": types.CompletionItemKind.Property,
    "argument": types.CompletionItemKind.Field,
    "class": types.CompletionItemKind.Class,
    "param": types.CompletionItemKind.Constant,
    "constant": types.CompletionItemKind.Constant,
    "import": types.CompletionItemKind.Module,
    "scenario": types.CompletionItemKind.Module,
    **dict.fromkeys(("function", "distribution", "action", "behavior", "monitor"), types.CompletionItemKind.Function),
}
SYMBOL_KINDS = {
    SymbolKind.PARAM: types.SymbolKind.Constant,
    SymbolKind.VARIABLE: types.SymbolKind.Variable,
    SymbolKind.OBJECT: types.SymbolKind.Object,
    SymbolKind.BEHAVIOR: types.SymbolKind.Function,
    SymbolKind.MONITOR: types.SymbolKind.Function,
    SymbolKind.SCENARIO: types.SymbolKind.Module,
    SymbolKind.CLASS: types.SymbolKind.Class,
    SymbolKind.PROPERTY: types.SymbolKind.Property,
}


def span_range(positions: Positions, span: Span) -> types.Range:
    return types.Range(types.Position(*positions.position(span.start)), types.Position(*positions.position(span.end)))


def location(file: OpenFile, target: Target, encoding: str) -> types.Location:
    """Return a place, in the open file or in one that it imports."""
    uri = file.uri if target.file == file.name else uris.from_fs_path(str(Path(target.file).absolute()))
    return types.Location(uri or file.uri, span_range(Positions(target.text, encoding), target.span))


# -- diagnostics ------------------------------------------------------------------------------------------------------


def diagnostics(file: OpenFile, encoding: str) -> list[types.Diagnostic]:
    """Return all diagnostics of the text, in the words of `--check`."""
    return [_diagnostic(file, each, encoding) for each in file.latest.diagnostics]


def _diagnostic(file: OpenFile, diagnostic: Diagnostic, encoding: str) -> types.Diagnostic:
    target = target_of(file.latest.source, diagnostic.label.span)
    own = target.file == file.latest.source.name
    spans = [(label.span, label.text) for label in diagnostic.secondary]
    if not own:
        spans = [(diagnostic.label.span, diagnostic.label.text or "here"), *spans]
    place = target.span if own else _import_of(file.latest)
    return types.Diagnostic(
        range=span_range(file.positions(encoding), place),
        message=("" if own else f"in {target.file}: ") + message_text(diagnostic),
        severity=SEVERITIES[diagnostic.severity],
        code=diagnostic.code,
        source=SOURCE,
        tags=[types.DiagnosticTag.Unnecessary] if diagnostic.code in UNUSED else None,
        related_information=list(_related(file, spans, encoding)) or None,
    )


def _related(
    file: OpenFile, spans: Iterable[tuple[Span, str]], encoding: str
) -> Iterator[types.DiagnosticRelatedInformation]:
    for span, text in spans:
        target = target_of(file.latest.source, span)
        yield types.DiagnosticRelatedInformation(location(file, target, encoding), text or "here")


def _import_of(analysis: Analysis) -> Span:
    """Return the span of the first import statement."""
    statement = next(import_statements(analysis.module), None) if analysis.module is not None else None
    return statement.span if statement is not None else Span(0, 0)


def message_text(diagnostic: Diagnostic) -> str:
    """Message, reason and cure on lines of their own, and where to read more."""
    head = diagnostic.message + (f" ({diagnostic.label.text})" if diagnostic.label.text else "")
    cure = f"help: {diagnostic.cure}" if diagnostic.cure else ""
    return "\n".join(filter(None, (head, diagnostic.reason, cure, f"more: cortexc explain {diagnostic.code}")))


# -- completion and outline -------------------------------------------------------------------------------------------


def completion_item(candidate: Candidate, place: types.Range) -> types.CompletionItem:
    return types.CompletionItem(
        label=candidate.label,
        kind=ITEM_KINDS.get(candidate.kind, types.CompletionItemKind.Variable),
        detail=candidate.detail or None,
        documentation=markdown(candidate.doc) if candidate.doc else None,
        sort_text=f"{candidate.rank}{candidate.label}",
        text_edit=types.TextEdit(place, candidate.label),
    )


def markdown(text: str) -> types.MarkupContent:
    return types.MarkupContent(types.MarkupKind.Markdown, text)


def document_symbol(each: Outline, positions: Positions) -> types.DocumentSymbol:
    symbol = each.symbol
    whole = Span(min(symbol.whole.start, symbol.span.start), max(symbol.whole.end, symbol.span.end))
    return types.DocumentSymbol(
        name=symbol.name,
        kind=SYMBOL_KINDS[symbol.kind],
        range=span_range(positions, whole),
        selection_range=span_range(positions, symbol.span),
        detail=symbol.form,
        children=[document_symbol(child, positions) for child in each.inside],
    )


def quick_fix(file: OpenFile, cure: Cure, encoding: str) -> types.CodeAction:
    edit = types.TextEdit(span_range(file.positions(encoding), cure.span), cure.text)
    return types.CodeAction(
        cure.title,
        kind=types.CodeActionKind.QuickFix,
        diagnostics=[_diagnostic(file, cure.diagnostic, encoding)],
        edit=types.WorkspaceEdit(changes={file.uri: [edit]}),
        is_preferred=True,
    )
