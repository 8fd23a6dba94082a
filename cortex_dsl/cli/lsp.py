"""`cortexc lsp`: a language server on standard input and output, for editors."""

import argparse
from collections.abc import Sequence

from cortex_dsl.console.command import Parser
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from engine.extras import installing


def main(arguments: Sequence[str], terminal: Terminal) -> int:
    options = _parser().parse_args(arguments)
    if options.help:
        terminal.write(_parser().format_help())
        return Exit.FINE
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


def _parser() -> Parser:
    parser = Parser(
        prog="cortexc lsp",
        usage="cortexc lsp",
        description="A language server for .scn files, on standard input and output, for editors to start: see "
        "docs/how-to/editors.md.",
        allow_abbrev=False,
        add_help=False,
    )
    parser.add_argument("--stdio", action="store_true", help="the only way; editors like to say it")
    parser.add_argument("--no-colour", "--no-color", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("-h", "--help", action="store_true", help="this page")
    return parser
