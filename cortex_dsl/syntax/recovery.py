"""Going on after a syntax error: the rest of the line is skipped and something harmless stands in its place."""

from lark.lexer import LexerState
from lark.parsers.lalr_interactive_parser import InteractiveParser

from cortex_dsl.syntax.later import BLOCKS as LATER_BLOCKS
from cortex_dsl.syntax.layout import Indenter, synthetic

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
"""Heads that belong to what stands above or below them, with or without a block."""
_ANY_HEAD = ("_WHILE", *_CONDITION)


def resume_after(run: InteractiveParser, indenter: Indenter, index: int) -> bool:
    """Bring the parser to the end of line `index`; False if there is no way to go on."""
    if index <= indenter.resumed:
        return False
    layout, line = indenter.layout, indenter.layout.lines[index]
    if line.word in LATER_BLOCKS:
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
    """Forget what was half read, down to where a token of this kind may stand."""
    state = run.parser_state
    states = state.parse_conf.states
    for depth in range(len(state.state_stack), 0, -1):
        if kind in states[state.state_stack[depth - 1]]:
            shorter = run.copy(deepcopy_values=False)
            _shorten(shorter, depth)
            # The table may promise what a later reduction refuses, so ask for the whole truth.
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
