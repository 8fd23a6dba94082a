"""`cortexc lsp`: a language server on standard input and output, for editors."""

import argparse

from cortex_dsl.console.command import Command, Parser
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from engine.extras import installing


def _serve(_options: argparse.Namespace, _terminal: Terminal) -> Exit:
    try:
        from cortex_dsl.editor.server import serve
    except ModuleNotFoundError as missing:
        if (missing.name or "").split(".")[0] not in ("pygls", "lsprotocol"):
            raise
        raise UsageError("the language server needs pygls, which is not installed", installing("lsp")) from None
    try:
        serve()
    except MemoryError:
        raise UsageError(
            "a message is longer than the memory", "its `Content-Length` is wrong, or the editor has opened a huge file"
        ) from None
    return Exit.FINE


def _options(parser: Parser) -> None:
    parser.add_argument("--stdio", action="store_true", help="the only way; editors like to say it")


LSP = Command(
    name="lsp",
    usage="",
    description="A language server for .scn files, on standard input and output, for editors to start: see "
    "docs/how-to/editors.md.",
    options=_options,
    function=_serve,
    json=False,
    wrapped=True,
)
