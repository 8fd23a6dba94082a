"""`cortexc lsp`: the language server. It holds the open files and answers in the types of the protocol.

The other modules of this folder compute the answers.
"""

import asyncio
import contextlib
import logging
import os
import re
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from lsprotocol import types
from pygls import uris
from pygls.exceptions import JsonRpcInvalidParams
from pygls.lsp.server import LanguageServer

from cortex_dsl.diagnostics import CompileError, Diagnostic, Severity
from cortex_dsl.editor.analysis import Analysis
from cortex_dsl.editor.completion import Candidate, complete
from cortex_dsl.editor.hover import hover, parameters_of
from cortex_dsl.editor.navigation import (
    CannotRenameError,
    Outline,
    Target,
    definition,
    outline,
    references,
    rename,
    target_of,
)
from cortex_dsl.editor.open_files import PAUSE, Buffers, OpenFile, Positions
from cortex_dsl.editor.place import place_of
from cortex_dsl.editor.symbols import SymbolKind
from cortex_dsl.semantics.errors.names import UNUSED_BEHAVIOUR, UNUSED_GENE
from cortex_dsl.semantics.names.linking import import_statements
from cortex_dsl.source import Source, Span
from cortex_dsl.spelling import nearest
from cortex_dsl.version import VERSION

# -- conversion to the protocol ----------------------------------------------------------------------------------------


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


class ScenarioServer(LanguageServer):
    """A server for any number of open scenarios."""

    def __init__(self) -> None:
        super().__init__("cortexc", VERSION, types.TextDocumentSyncKind.Full)
        self.files: dict[str, OpenFile] = {}

    @property
    def encoding(self) -> str:
        """The units in which the client counts columns."""
        return str(getattr(self.workspace.position_encoding, "value", self.workspace.position_encoding))

    def offset(self, file: OpenFile, position: types.Position) -> int:
        return file.positions(self.encoding).offset(position.line, position.character)

    def publish(self, file: OpenFile) -> None:
        """Publish the diagnostics of a file."""
        found = diagnostics(file, self.encoding)
        self.text_document_publish_diagnostics(types.PublishDiagnosticsParams(file.uri, found))

    def check(self, file: OpenFile, pause: float = PAUSE) -> None:
        """Compile a file, and those that import it."""
        texts = {each.files.identity(each.name): each.text for each in self.files.values()}
        for each in self.files.values():
            if each is file or each.imports(file):
                each.files = Buffers(texts=texts)
                each.check(self.publish, pause)

    def file(self, uri: str) -> OpenFile:
        """An open file.

        Raises:
            JsonRpcInvalidParams: it is not open.
        """
        if uri not in self.files:
            raise JsonRpcInvalidParams(f"`{uri}` is not open")
        return self.files[uri]

    def place(self, document: types.TextDocumentIdentifier, position: types.Position) -> tuple[OpenFile, int]:
        file = self.file(document.uri)
        return file, self.offset(file, position)


# -- open files --------------------------------------------------------------------------------------------------------


async def opened(ls: ScenarioServer, params: types.DidOpenTextDocumentParams) -> None:
    document = params.text_document
    name = uris.to_fs_path(document.uri) or PurePosixPath(document.uri).name
    file = ls.files[document.uri] = OpenFile(document.uri, name, document.text)
    ls.check(file, pause=0.0)


async def changed(ls: ScenarioServer, params: types.DidChangeTextDocumentParams) -> None:
    file = ls.file(params.text_document.uri)
    file.change(ls.workspace.get_text_document(file.uri).source)
    ls.check(file)


async def saved(ls: ScenarioServer, params: types.DidSaveTextDocumentParams) -> None:
    """Files that are not open may have changed, too."""
    ls.check(ls.file(params.text_document.uri))


async def closed(ls: ScenarioServer, params: types.DidCloseTextDocumentParams) -> None:
    ls.file(params.text_document.uri).closed = True
    del ls.files[params.text_document.uri]
    ls.text_document_publish_diagnostics(types.PublishDiagnosticsParams(params.text_document.uri, []))


def shut_down(ls: ScenarioServer, *_: object) -> None:
    for file in ls.files.values():
        file.closed = True


# -- questions ---------------------------------------------------------------------------------------------------------


async def hovered(ls: ScenarioServer, params: types.HoverParams) -> types.Hover | None:
    file, offset = ls.place(params.text_document, params.position)
    found = hover(await file.settled(), offset)
    if found is None:
        return None
    return types.Hover(markdown(found.text), span_range(file.positions(ls.encoding), found.span))


async def completed(ls: ScenarioServer, params: types.CompletionParams) -> list[types.CompletionItem]:
    file, offset = ls.place(params.text_document, params.position)
    view = file.view
    by_blank = params.context is not None and params.context.trigger_character == " "
    found = await asyncio.to_thread(complete, view, offset, decided=by_blank)
    at = place_of(view, offset)
    span = Span(at.start if at is not None else offset, offset)
    place = span_range(file.positions(ls.encoding), span)
    return [completion_item(candidate, place) for candidate in found]


async def called(ls: ScenarioServer, params: types.SignatureHelpParams) -> types.SignatureHelp | None:
    file, offset = ls.place(params.text_document, params.position)
    place = place_of(file.view, offset)
    if place is None or place.callee < 0:
        return None
    found = parameters_of(file.view, place.left[place.callee].text, offset)
    return None if found is None else _signature(*found, active=place.argument)


async def defined(ls: ScenarioServer, params: types.DefinitionParams) -> types.Location | None:
    file, offset = ls.place(params.text_document, params.position)
    target = definition(await file.settled(), offset)
    return None if target is None else location(file, target, ls.encoding)


async def used(ls: ScenarioServer, params: types.ReferenceParams) -> list[types.Location]:
    file, offset = ls.place(params.text_document, params.position)
    positions = file.positions(ls.encoding)
    spans = references(await file.settled(), offset)
    return [types.Location(file.uri, span_range(positions, span)) for span in spans]


async def outlined(ls: ScenarioServer, params: types.DocumentSymbolParams) -> list[types.DocumentSymbol]:
    file = ls.file(params.text_document.uri)
    view = await file.settled()
    positions = Positions(view.analysis.source.text, ls.encoding)
    return [document_symbol(each, positions) for each in outline(view)]


def _signature(form: str, arguments: tuple[tuple[str, str], ...], active: int) -> types.SignatureHelp:
    parameters = [types.ParameterInformation(name, text or None) for name, text in arguments]
    signature = types.SignatureInformation(form, parameters=parameters)
    return types.SignatureHelp([signature], 0, min(active, len(parameters) - 1))


# -- edits -------------------------------------------------------------------------------------------------------------


async def laid_out(ls: ScenarioServer, params: types.DocumentFormattingParams) -> list[types.TextEdit] | None:
    file = ls.file(params.text_document.uri)
    text = await asyncio.to_thread(formatted, file.name, file.text)
    if text is None or text == file.text:
        return None
    whole = span_range(file.positions(ls.encoding), Span(0, len(file.text)))
    return [types.TextEdit(whole, text)]


async def renamed(ls: ScenarioServer, params: types.RenameParams) -> types.WorkspaceEdit:
    file, offset = ls.place(params.text_document, params.position)
    try:
        spans = rename(await file.settled(), offset, params.new_name)
    except CannotRenameError as error:
        raise JsonRpcInvalidParams(error.message) from None
    positions = file.positions(ls.encoding)
    edits = [types.TextEdit(span_range(positions, span), params.new_name) for span in spans]
    return types.WorkspaceEdit(changes={file.uri: edits})


async def cured(ls: ScenarioServer, params: types.CodeActionParams) -> list[types.CodeAction]:
    file = ls.file(params.text_document.uri)
    await file.settled()
    if file.latest.source.text != file.text:
        return []
    around = Span(ls.offset(file, params.range.start), ls.offset(file, params.range.end))
    found = cures(file.latest.source, file.latest.diagnostics, around)
    return [quick_fix(file, cure, ls.encoding) for cure in found]


# -- the whole ---------------------------------------------------------------------------------------------------------


FEATURES = (
    (types.TEXT_DOCUMENT_DID_OPEN, None, opened),
    (types.TEXT_DOCUMENT_DID_CHANGE, None, changed),
    (types.TEXT_DOCUMENT_DID_SAVE, None, saved),
    (types.TEXT_DOCUMENT_DID_CLOSE, None, closed),
    (types.SHUTDOWN, None, shut_down),
    (types.TEXT_DOCUMENT_HOVER, None, hovered),
    (types.TEXT_DOCUMENT_COMPLETION, types.CompletionOptions(trigger_characters=[".", " "]), completed),
    (types.TEXT_DOCUMENT_SIGNATURE_HELP, types.SignatureHelpOptions(trigger_characters=["(", ","]), called),
    (types.TEXT_DOCUMENT_DEFINITION, None, defined),
    (types.TEXT_DOCUMENT_REFERENCES, None, used),
    (types.TEXT_DOCUMENT_DOCUMENT_SYMBOL, None, outlined),
    (types.TEXT_DOCUMENT_FORMATTING, None, laid_out),
    (types.TEXT_DOCUMENT_RENAME, None, renamed),
    (types.TEXT_DOCUMENT_CODE_ACTION, types.CodeActionOptions([types.CodeActionKind.QuickFix]), cured),
)
"""The messages that the server answers: each with the options announced to the client, and its handler."""


def build_server() -> ScenarioServer:
    server = ScenarioServer()
    for message, options, answer in FEATURES:
        server.feature(message, options)(answer)
    return server


class OneLine(logging.Formatter):
    """Return the error without its traceback, which means nothing to the user of an editor."""

    def formatException(self, ei: object) -> str:  # noqa: N802 - its name in the base class
        error = ei[1] if isinstance(ei, tuple) else None
        return f"({type(error).__name__}: {error})" if error is not None else ""


def _log_in_lines() -> None:
    handler = logging.StreamHandler()
    handler.setFormatter(OneLine("cortexc lsp: %(message)s"))
    logging.basicConfig(level=logging.ERROR, handlers=[handler])


def serve() -> None:
    """Answer on standard input and output until the client says so or leaves.

    The server closes its output at the end, so it gets a copy; no other print may disturb the protocol.
    """
    _log_in_lines()
    with os.fdopen(os.dup(sys.stdout.fileno()), "wb") as output, contextlib.redirect_stdout(sys.stderr):
        build_server().start_io(stdout=output)
