"""Text to tree: Lark's LALR parser, its tables cached between runs, and recovery after an error."""

import sys
import threading
from functools import cache
from hashlib import sha256

from lark import Lark, Token, Tree
from lark import __version__ as lark_version
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken
from lark.lexer import LexerState
from lark.parsers.lalr_interactive_parser import InteractiveParser

from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.installation import resource
from cortex_dsl.source import Source
from cortex_dsl.syntax.errors import MAX_ERRORS
from cortex_dsl.syntax.layout import Indenter, Layout, lay_out, synthetic
from cortex_dsl.syntax.reductions import Reductions
from cortex_dsl.syntax.words import LATER_BLOCKS
from engine.user_cache import cached_file

# -- Recovery after a syntax error: the rest of the line is skipped and replaced by a harmless statement ---------------

_CONDITION = ("CONSTANT", "COLON")
_HEADS = {
    "if": ("_IF", *_CONDITION),
    "elif": ("_ELIF", *_CONDITION),
    "else": ("_ELSE", "COLON"),
    "behavior": ("_BEHAVIOR", "NAME", "LPAR", "RPAR", "COLON"),
    "class": ("_CLASS", "NAME", "COLON"),
    "compose": ("_COMPOSE", "COLON"),
    "monitor": ("_MONITOR", "NAME", "LPAR", "RPAR", "COLON"),
    "scenario": ("_SCENARIO", "NAME", "COLON"),
    "setup": ("_SETUP", "COLON"),
    "except": ("_INTERRUPT_WHEN", *_CONDITION),
    "finally": ("_INTERRUPT_WHEN", *_CONDITION),
    "interrupt": ("_INTERRUPT_WHEN", *_CONDITION),
    "try": ("_TRY", "COLON"),
}
_CONTINUING = frozenset({"elif", "else", "except", "finally", "interrupt", "try"})
"""First words of blocks that belong to the statements above or below them, with or without a block."""
_ANY_HEAD = ("_WHILE", *_CONDITION)


def resume_after(run: InteractiveParser, indenter: Indenter, index: int) -> bool:
    """Bring the parser to the end of line `index`; False if there is no way to go on."""
    if index <= indenter.resumed:
        return False
    layout, line = indenter.layout, indenter.layout.lines[index]
    if line.word in LATER_BLOCKS or line.word == "def":  # functions in classes, above all
        last = layout.block_end(index)
        indenter.levels[index : last + 1] = [indenter.levels[index]] * (last + 1 - index)
        stand_in, index = _stand_in(line.word, has_block=False), last
    else:
        has_block = layout.block_end(index) > index or index in layout.hollow
        stand_in = _stand_in(line.word, has_block)
    for kinds in (stand_in, _ANY_HEAD if stand_in[-1] == "COLON" else ("_PASS",)):
        # `if` may also stand inside an expression, so look for where `while` may stand.
        if _unwind(run, "_WHILE" if kinds[0] == "_IF" else kinds[0]):
            break
    else:
        return False
    for kind in kinds:
        run.feed_token(synthetic(kind, line.start))
    indenter.resumed, indenter.ended = index, index - 1
    _move_to(run.lexer_thread.state, layout.lines[index].stop)
    return True


def _stand_in(word: str, has_block: bool) -> tuple[str, ...]:
    """Kinds of the tokens that replace a line."""
    if has_block:
        return _HEADS.get(word, _ANY_HEAD)
    return (*_HEADS[word], "_PASS") if word in _CONTINUING else ("_PASS",)


def _unwind(run: InteractiveParser, kind: str) -> bool:
    """Remove partially read symbols, down to a state that accepts a token of this kind."""
    state = run.parser_state
    states = state.parse_conf.states
    for depth in range(len(state.state_stack), 0, -1):
        if kind in states[state.state_stack[depth - 1]]:
            shorter = run.copy(deepcopy_values=False)
            _shorten(shorter, depth)
            # The table may promise a token that a later reduction refuses, so query the exact set.
            if kind in shorter.accepts():
                _shorten(run, depth)
                return True
    return False


def _shorten(run: InteractiveParser, depth: int) -> None:
    del run.parser_state.state_stack[depth:]
    del run.parser_state.value_stack[depth - 1 :]


def _move_to(state: LexerState | None, offset: int) -> None:
    assert state is not None
    state.line_ctr.char_pos = offset
    state.last_token = None


# -- Parsing -----------------------------------------------------------------------------------------------------------

_LOCK = threading.Lock()
"""Lock for the post-lexer of the only parser: texts are parsed one at a time."""


def read_tree(source: Source) -> tuple[Tree[Token] | None, list[Diagnostic]]:
    """Return the tree of a text and every error in it; None if a tree cannot be built.

    After errors the tree has `pass` or an empty condition in place of the unreadable text.
    """
    layout = lay_out(source.text)
    diagnostics = list(layout.diagnostics)
    if layout.hopeless or len(diagnostics) >= MAX_ERRORS:
        return None, diagnostics
    with _LOCK:
        tree, diagnostics = _run(source, layout, diagnostics)
    if len(diagnostics) > 1:
        from cortex_dsl.syntax.scenic2 import in_one  # not for texts without an error

        diagnostics = in_one(diagnostics, source)
    return tree, diagnostics


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
            _reductions().exhaust(run)
            return run.feed_eof(), diagnostics
        except UnexpectedInput as error:
            from cortex_dsl.syntax.explain.table import explain  # not for texts without an error

            offset = _offset(error, len(source.text))
            index = layout.line_at(offset)
            if not (layout.lines and layout.lines[index].broken):
                diagnostics.append(explain(source, layout, index, offset, frozenset(run.accepts())))
            if len(diagnostics) >= MAX_ERRORS:
                return None, diagnostics
            if not resume_after(run, indenter, index):
                return None, diagnostics


def _offset(error: UnexpectedInput, end: int) -> int:
    """Return the offset of an error in the text."""
    if isinstance(error, UnexpectedCharacters):
        return error.pos_in_stream or 0
    if isinstance(error, UnexpectedToken) and error.token.type != "$END":
        return error.token.start_pos or 0
    return end


@cache
def _reductions() -> Reductions:
    """Return the tables of the parser's reductions."""
    return Reductions(_parser()[0].parse_interactive(""))


@cache
def _parser() -> tuple[Lark, Indenter]:
    """Return the parser and its post-lexer, from the cache of an earlier run if it exists."""
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
        cache=str(cached_file(f"grammar-{key}.lark", "grammar-*.lark") or "") or False,
    )
    return lark, indenter
