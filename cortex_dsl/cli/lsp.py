"""`cortexc lsp`: a language server on standard input and output, for editors."""

import argparse

from cortex_dsl.console.command import Command, Option
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


LSP = Command(
    name="lsp",
    usage="",
    description="A language server for .scn files, on standard input and output, for editors to start: see "
    "docs/how-to/editors.md.",
    options=(Option("--stdio", "the only way; editors like to say it"),),
    function=_serve,
    json=False,
    layout=argparse.HelpFormatter,
)
