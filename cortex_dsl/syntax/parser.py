"""Text to tree: Lark's LALR parser, its tables cached between runs, and recovery after an error."""

import sys
import threading
from functools import cache
from hashlib import sha256

from lark import Lark, Token, Tree
from lark import __version__ as lark_version
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.resources import resource
from cortex_dsl.source import Source
from cortex_dsl.syntax.layout import Indenter, Layout, lay_out
from cortex_dsl.syntax.limits import MAX_ERRORS
from cortex_dsl.syntax.messages import explain
from cortex_dsl.syntax.recovery import resume_after
from cortex_dsl.syntax.terminals import TerminalLexer
from engine.user_cache import cached_file

_LOCK = threading.Lock()
"""The post-lexer belongs to the one parser, so texts are parsed one at a time."""


def read_tree(source: Source) -> tuple[Tree[Token] | None, list[Diagnostic]]:
    """The tree of a text and every error found in it; None where there is nothing to build a tree from.

    After errors the tree has `pass` or an empty condition in the place of what could not be read.
    """
    layout = lay_out(source.text)
    diagnostics = list(layout.diagnostics)
    if layout.hopeless or len(diagnostics) >= MAX_ERRORS:
        return None, diagnostics
    with _LOCK:
        return _run(source, layout, diagnostics)


def read_tokens(source: Source) -> list[Token]:
    """All tokens of a text that has no errors, those included that its lines and indentation stand for."""
    with _LOCK:
        lark, indenter = _parser()
        indenter.begin(lay_out(source.text), source.text)
        run = lark.parse_interactive(source.text)
        return list(run.iter_parse())


def _run(source: Source, layout: Layout, diagnostics: list[Diagnostic]) -> tuple[Tree[Token] | None, list[Diagnostic]]:
    lark, indenter = _parser()
    indenter.begin(layout, source.text)
    run = lark.parse_interactive(source.text)
    while True:
        try:
            run.exhaust_lexer()
            return run.feed_eof(), diagnostics
        except UnexpectedInput as error:
            offset = _offset(error, len(source.text))
            index = layout.line_at(offset)
            if not (layout.lines and layout.lines[index].broken):
                diagnostics.append(explain(source, layout, index, offset, frozenset(run.accepts())))
            if len(diagnostics) >= MAX_ERRORS:
                return None, diagnostics
            if not resume_after(run, indenter, index):
                return None, diagnostics


def _offset(error: UnexpectedInput, end: int) -> int:
    """Where the error was met, as an offset into the text."""
    if isinstance(error, UnexpectedCharacters):
        return error.pos_in_stream or 0
    if isinstance(error, UnexpectedToken) and error.token.type != "$END":
        return error.token.start_pos or 0
    return end


@cache
def _parser() -> tuple[Lark, Indenter]:
    """The parser and its post-lexer, from the cache of an earlier run if there is one."""
    grammar = resource("grammar/cortex.lark").read_text(encoding="utf-8")
    indenter = Indenter()
    key = sha256("\0".join((grammar, lark_version, sys.version)).encode()).hexdigest()[:24]
    lark = Lark(
        grammar,
        parser="lalr",
        lexer="contextual",
        propagate_positions=True,
        maybe_placeholders=True,
        postlex=indenter,
        _plugins={"ContextualLexer": TerminalLexer},
        cache=str(cached_file(f"grammar-{key}.lark", "grammar-*.lark") or "") or False,
    )
    return lark, indenter
