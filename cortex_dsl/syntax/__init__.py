"""Syntax: text to tree to frozen nodes, and back to text (`unparse`). The first parse loads Lark, not this import."""

from typing import TYPE_CHECKING

from cortex_dsl.diagnostics import CompileError, Diagnostic
from cortex_dsl.source import Source
from cortex_dsl.syntax.errors import MAX_ERRORS, too_many
from cortex_dsl.syntax.nodes import Module

if TYPE_CHECKING:
    from lark import Token, Tree

__all__ = ["parse", "parse_tree"]


def parse(source: Source) -> Module:
    """The syntax tree of a text.

    Raises:
        CompileError: with every syntax error found.
    """
    from cortex_dsl.syntax.builder import build
    from cortex_dsl.syntax.parser import read_tree
    from cortex_dsl.syntax.reading import check_size

    check_size(source.name, len(source.text))
    tree, diagnostics = read_tree(source)
    module, more = build(tree, source) if tree is not None else (None, [])
    _raise_if_any(source, [*diagnostics, *more])
    assert module is not None
    return module


def parse_tree(source: Source) -> "Tree[Token]":
    """Lark's tree of a text, one node per rule of the grammar.

    Raises:
        CompileError: with every error of the grammar.
    """
    from cortex_dsl.syntax.parser import read_tree

    tree, diagnostics = read_tree(source)
    _raise_if_any(source, diagnostics)
    assert tree is not None
    return tree


def _raise_if_any(source: Source, diagnostics: list[Diagnostic]) -> None:
    if diagnostics:
        ordered = list(dict.fromkeys(sorted(diagnostics, key=lambda each: each.label.span)))
        if len(ordered) >= MAX_ERRORS:
            ordered = [*ordered[:MAX_ERRORS], too_many(ordered[MAX_ERRORS - 1])]
        raise CompileError(source, ordered)
