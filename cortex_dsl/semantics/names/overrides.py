"""`-p NAME=VALUE`: the value is an expression of the language, put in the place of the param's own."""

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import TypeVar, cast

from cortex_dsl.diagnostics import CompileError
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.randomness.genes import unit_word
from cortex_dsl.source import Source, Span
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes, parse

Tree = TypeVar("Tree")


def param_entries(module: nodes.Module) -> dict[str, nodes.ParamEntry]:
    """All params of a file by name."""
    return {
        entry.name: entry
        for statement in module.statements
        if isinstance(statement, nodes.Param)
        for entry in statement.entries
    }


def read_overrides(module: nodes.Module, overrides: Mapping[str, str]) -> dict[str, nodes.Expression]:
    """The values by param name, with the spans of the params that they replace.

    Raises:
        CompileError: for a param that is not there, or a value that is no expression; it speaks of the option's text.
    """
    entries = param_entries(module)
    result: dict[str, nodes.Expression] = {}
    for name, text in overrides.items():
        option = Source("-p", f"{name} = {text}")
        if name not in entries:
            suggestion = did_you_mean(name, entries) or "this file has no params"
            raise CompileError(
                option, [errors.UNKNOWN_OVERRIDE.at(Span(0, len(name)), name=name, suggestion=suggestion)]
            )
        result[name] = moved(_expression(option, name), entries[name].value.span)
    return result


def _expression(option: Source, name: str) -> nodes.Expression:
    statements = parse(option).statements
    if len(statements) != 1 or not isinstance(statements[0], nodes.Assign):
        raise CompileError(option, [errors.BAD_OVERRIDE.at(Span(0, len(option.text)), name=name)])
    return statements[0].value


def moved(tree: Tree, span: Span) -> Tree:
    """The same tree with every span replaced."""
    if isinstance(tree, tuple):
        return cast("Tree", tuple(moved(item, span) for item in tree))
    if not isinstance(tree, nodes.Node):
        return tree
    changed = {
        f.name: span if isinstance(getattr(tree, f.name), Span) else moved(getattr(tree, f.name), span)
        for f in fields(tree)
    }
    return cast("Tree", replace(tree, **changed))


def override_text(entry: nodes.ParamEntry, text: str) -> str:
    """The value as a file must write it: a bare number of the command line is in the param's own unit."""
    unit = unit_word(entry.value)
    value = _expression(Source("-p", f"{entry.name} = {text}"), entry.name)
    if not unit or unit_word(value) is not None or isinstance(value, nodes.String | nodes.Constant):
        return text
    return f"{text} {unit}" if isinstance(value, nodes.Number) else f"({text}) * 1 {unit}"
