"""The worked example as a text to be edited, and a client that talks to the real server over its standard streams."""

import asyncio
import sys
from collections.abc import Awaitable, Callable, Coroutine, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from lsprotocol import types
from pygls.lsp.client import LanguageClient

LEFT_TURN = Path(__file__).parents[3] / "examples" / "left_turn.scn"
PATIENCE = 300.0
"""Seconds for one answer: the machine may be busy."""


class Client:
    """A server process, and the one file that is open in it at a time."""

    def __init__(self) -> None:
        self.uri, self.version, self.text = "", 0, ""
        self.ls = LanguageClient("tests", "1")
        self.published: asyncio.Queue[types.PublishDiagnosticsParams] = asyncio.Queue()

        @self.ls.feature(types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
        def published(params: types.PublishDiagnosticsParams) -> None:
            if params.uri == self.uri:
                self.published.put_nowait(params)

    def turn_to(self, path: Path) -> None:
        """Speak of this file from here on; what is still said of the one before is not heard."""
        if self.uri:
            self.ls.text_document_did_close(types.DidCloseTextDocumentParams(self.document))
        self.uri, self.version, self.text = path.as_uri(), 0, ""
        while not self.published.empty():
            self.published.get_nowait()

    async def start(self) -> types.InitializeResult:
        await self.ls.start_io(sys.executable, "-m", "cortex_dsl", "lsp", "--stdio")
        general = types.GeneralClientCapabilities(position_encodings=["utf-16"])
        capabilities = types.ClientCapabilities(general=general)
        started = await self.wait(self.ls.initialize_async(types.InitializeParams(capabilities=capabilities)))
        self.ls.initialized(types.InitializedParams())
        return started

    async def wait(self, answer: Awaitable):
        return await asyncio.wait_for(answer, PATIENCE)

    def open(self, text: str) -> None:
        self.text = text
        document = types.TextDocumentItem(self.uri, "scn", self.version, text)
        self.ls.text_document_did_open(types.DidOpenTextDocumentParams(document))

    def change(self, text: str) -> None:
        self.text, self.version = text, self.version + 1
        document = types.VersionedTextDocumentIdentifier(self.version, self.uri)
        changes = [types.TextDocumentContentChangeWholeDocument(text)]
        self.ls.text_document_did_change(types.DidChangeTextDocumentParams(document, changes))

    async def diagnostics(self) -> list[types.Diagnostic]:
        """The next ones that the server sends."""
        return list((await self.wait(self.published.get())).diagnostics)

    @property
    def document(self) -> types.TextDocumentIdentifier:
        return types.TextDocumentIdentifier(self.uri)

    def at(self, marked: str, *, inside: int = 0) -> types.Position:
        """The position of a piece of the text, or of a character in it."""
        offset = self.text.index(marked) + inside
        line = self.text.count("\n", 0, offset)
        return types.Position(line, offset - (self.text.rfind("\n", 0, offset) + 1))

    def end(self) -> types.Position:
        lines = self.text.split("\n")
        return types.Position(len(lines) - 1, len(lines[-1]))

    async def stop(self) -> int:
        await self.wait(self.ls.shutdown_async(None))
        self.ls.exit(None)
        process = self.ls._server
        assert process is not None
        code = await self.wait(process.wait())
        await self.ls.stop()
        return code


Talk = Callable[[Client], Awaitable[None]]


Loop = Callable[[Coroutine[Any, Any, Any]], Any]
"""Run a coroutine, and return what it returns."""


@pytest.fixture(scope="module")
def server() -> Iterator[tuple[Loop, Client]]:
    """One server for all conversations of a module, which must end in order.

    Its event loop has a thread of its own: another fixture may hold one in the thread of the tests.
    """
    runner = asyncio.Runner()
    with ThreadPoolExecutor(1) as thread:

        def run(work: Coroutine[Any, Any, Any]) -> Any:
            return thread.submit(runner.run, work).result()

        async def started() -> Client:
            client = Client()
            await client.start()
            return client

        client = run(started())
        yield run, client
        assert run(client.stop()) == 0
        thread.submit(runner.close).result()


@pytest.fixture
def talk(server: tuple[Loop, Client], tmp_path: Path) -> Callable[[Talk], None]:
    """Hold a conversation about a file of its own."""

    def hold(conversation: Talk) -> None:
        run, client = server

        async def whole() -> None:
            client.turn_to(tmp_path / "own.scn")
            await conversation(client)

        run(whole())

    return hold


@pytest.fixture(scope="session")
def left_turn() -> str:
    return LEFT_TURN.read_text()
