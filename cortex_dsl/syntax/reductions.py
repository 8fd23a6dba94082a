"""Lark's parse loop with fewer calls: reductions of a rule to its only child, which change no value, follow a table.

An expression passes a rule for each level of precedence, so nine of ten reductions are such ones. Trees, errors and the
stacks at an error are those of Lark.
"""

from collections.abc import Callable
from typing import Any, cast

from lark import Token, Tree
from lark.grammar import Rule, Terminal
from lark.parse_tree_builder import PropagatePositions
from lark.parsers.lalr_analysis import Shift
from lark.parsers.lalr_interactive_parser import InteractiveParser

Reduction = tuple[int, str, Any]
"""Number of children, symbol, and function of the children; None where the value is that of the only child."""


class Reductions:
    """Tables of one parser, filled as states are met."""

    def __init__(self, run: InteractiveParser) -> None:
        configuration: Any = run.parser_state.parse_conf
        self._states: dict[int, dict[str, tuple[Any, Any]]] = configuration.states
        self._callbacks: dict[Any, Any] = configuration.callbacks
        for rule, function in self._callbacks.items():
            if isinstance(function, PropagatePositions):
                self._callbacks[rule] = _placed(cast("Any", function).node_builder)
        self._actions: dict[int, dict[str, int | Reduction]] = {}
        self._after: dict[tuple[int, int, str], int] = {}
        """State after all reductions to an only child, by the state below, the state and the next token."""

    def exhaust(self, run: InteractiveParser) -> None:
        """Feed all tokens.

        Raises:
            UnexpectedInput: a token or a character does not fit.
        """
        state = run.parser_state
        lexer: Any = run.lexer_thread
        states, values = cast("list[int]", state.state_stack), state.value_stack
        actions, after = self._actions, self._after
        for token in lexer.lex(state):
            kind = token.type
            while True:
                here = states[-1]
                action = (actions.get(here) or self._convert(here)).get(kind)
                if action.__class__ is int:
                    states.append(cast("int", action))
                    values.append(token)
                    break
                if action is None:
                    state.feed_token(token)  # raises the error
                    break
                size, symbol, function = cast("Reduction", action)
                if function is None:
                    key = states[-2], here, kind
                    states[-1] = after.get(key) or self._follow(*key)
                    continue
                children: list[Any] = []
                if size:
                    children = values[-size:]
                    del values[-size:], states[-size:]
                values.append(function(children))
                states.append(self._states[states[-1]][symbol][1])

    def _convert(self, state: int) -> dict[str, int | Reduction]:
        """Return the actions in a state."""
        made = self._actions[state] = {
            kind: self._action(kind, action, argument) for kind, (action, argument) in self._states[state].items()
        }
        return made

    def _action(self, kind: str, action: Any, argument: Any) -> int | Reduction:
        if action is Shift:
            assert kind not in self._callbacks  # no terminal has a function
            return argument
        rule: Rule = argument
        return len(rule.expansion), rule.origin.name, None if _keeps_value(rule) else self._callbacks[rule]

    def _follow(self, below: int, state: int, kind: str) -> int:
        """Return the state after all reductions to an only child before this token."""
        here = state
        while True:
            action = (self._actions.get(here) or self._convert(here)).get(kind)
            if action is None or action.__class__ is int or cast("Reduction", action)[2] is not None:
                self._after[below, state, kind] = here
                return here
            here = self._states[below][cast("Reduction", action)[1]][1]


def _placed(builder: Callable[[list[Any]], Any]) -> Callable[[list[Any]], Any]:
    """Return a function that makes a value of its children, a tree with its place in the text.

    A tree keeps its own place, and has that of its container beside it: brackets that left no node in the tree.
    """

    def function(children: list[Any]) -> Any:
        made = builder(children)
        if made.__class__ is not Tree:
            return made
        start = end = None
        for child in children:
            if child.__class__ is Token:
                start = child.start_pos
                break
            if child is not None and not child.meta.empty:
                start = child.meta.container_start
                break
        if start is None:
            return made
        for child in reversed(children):
            if child.__class__ is Token:
                end = child.end_pos
                break
            if child is not None and not child.meta.empty:
                end = child.meta.container_end
                break
        meta = made.meta
        if meta.empty:
            meta.empty, meta.start_pos, meta.end_pos = False, start, end
        meta.container_start, meta.container_end = start, end
        return made

    return function


def _keeps_value(rule: Rule) -> bool:
    """Return True if a rule has one symbol, whose value it is: a `?rule` without another name."""
    options, (*others, last) = rule.options, rule.expansion or (None,)
    if others or last is None or not options.expand1 or rule.alias:
        return False
    is_left_out = last.is_term and cast("Terminal", last).filter_out
    return not is_left_out and not any(options.empty_indices)
