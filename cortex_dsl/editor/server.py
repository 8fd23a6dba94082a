"""`cortexc lsp`: the language server. It holds the open files and answers by the other modules of this folder."""

import asyncio
import contextlib
import logging
import os
import sys
from pathlib import PurePosixPath

from lsprotocol import types
from pygls import uris
from pygls.exceptions import JsonRpcInvalidParams
from pygls.lsp.server import LanguageServer

from cortex_dsl.editor import messages
from cortex_dsl.editor.completion import complete
from cortex_dsl.editor.hover import hover, parameters_of
from cortex_dsl.editor.messages import cures, formatted
from cortex_dsl.editor.navigation import CannotRenameError, definition, outline, references, rename
from cortex_dsl.editor.open_files import PAUSE, Buffers, OpenFile
from cortex_dsl.editor.place import place_of
from cortex_dsl.source import Span
from cortex_dsl.version import VERSION


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
        found = messages.diagnostics(file, self.encoding)
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
    return types.Hover(messages.markdown(found.text), messages.span_range(file.positions(ls.encoding), found.span))


async def completed(ls: ScenarioServer, params: types.CompletionParams) -> list[types.CompletionItem]:
    file, offset = ls.place(params.text_document, params.position)
    view = file.view
    by_blank = params.context is not None and params.context.trigger_character == " "
    found = await asyncio.to_thread(complete, view, offset, decided=by_blank)
    at = place_of(view, offset)
    span = Span(at.start if at is not None else offset, offset)
    place = messages.span_range(file.positions(ls.encoding), span)
    return [messages.completion_item(candidate, place) for candidate in found]


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
    return None if target is None else messages.location(file, target, ls.encoding)


async def used(ls: ScenarioServer, params: types.ReferenceParams) -> list[types.Location]:
    file, offset = ls.place(params.text_document, params.position)
    positions = file.positions(ls.encoding)
    spans = references(await file.settled(), offset)
    return [types.Location(file.uri, messages.span_range(positions, span)) for span in spans]


async def outlined(ls: ScenarioServer, params: types.DocumentSymbolParams) -> list[types.DocumentSymbol]:
    file = ls.file(params.text_document.uri)
    view = await file.settled()
    positions = messages.Positions(view.analysis.source.text, ls.encoding)
    return [messages.document_symbol(each, positions) for each in outline(view)]


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
    whole = messages.span_range(file.positions(ls.encoding), Span(0, len(file.text)))
    return [types.TextEdit(whole, text)]


async def renamed(ls: ScenarioServer, params: types.RenameParams) -> types.WorkspaceEdit:
    file, offset = ls.place(params.text_document, params.position)
    try:
        spans = rename(await file.settled(), offset, params.new_name)
    except CannotRenameError as error:
        raise JsonRpcInvalidParams(error.message) from None
    positions = file.positions(ls.encoding)
    edits = [types.TextEdit(messages.span_range(positions, span), params.new_name) for span in spans]
    return types.WorkspaceEdit(changes={file.uri: edits})


async def cured(ls: ScenarioServer, params: types.CodeActionParams) -> list[types.CodeAction]:
    file = ls.file(params.text_document.uri)
    await file.settled()
    if file.latest.source.text != file.text:
        return []
    around = Span(ls.offset(file, params.range.start), ls.offset(file, params.range.end))
    found = cures(file.latest.source, file.latest.diagnostics, around)
    return [messages.quick_fix(file, cure, ls.encoding) for cure in found]


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
