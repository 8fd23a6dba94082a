"""Inputs of a file, read before evaluation: imported files, `-p NAME=VALUE`, and the params that it holds fixed.

Each imported file is read once, and all texts share one space of offsets. A value of `-p` is an expression of the
language in place of the param's own.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import PurePath
from typing import TypeVar, cast

from cortex_dsl.diagnostics import CompileError, Diagnostic, Label
from cortex_dsl.files import SUFFIXES, Files
from cortex_dsl.semantics.errors.names import (
    BAD_OVERRIDE,
    IMPORT_CYCLE,
    MISSING_IMPORT,
    NAMELESS_IMPORT,
    TOO_MANY_IMPORTS,
    UNKNOWN_OVERRIDE,
    UNREADABLE_IMPORT,
)
from cortex_dsl.semantics.names.tree import everything_in, param_entries, scenic_model, unit_word
from cortex_dsl.source import Source, Span
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes, parse
from cortex_dsl.syntax.literals import UNIT_WORDS
from engine.frozen import frozen

FILE_LIMIT = 100
"""Most files that a scenario may import, directly or not."""

Tree = TypeVar("Tree")


@frozen
class ImportedFile:
    """A file that was read: its spans lie in the space of all files."""

    name: str
    module: nodes.Module


@frozen
class Linked:
    """The source with all that it imports, and the file behind each import statement."""

    source: Source
    files: Mapping[Span, ImportedFile]


NO_FILES: Mapping[Span, ImportedFile] = {}


def link(module: nodes.Module, source: Source, files: Files) -> Linked:
    """Read the imported files of a module, recursively.

    Raises:
        CompileError: with every error found in the imported files.
    """
    if not any(import_statements(module)):
        return Linked(source, NO_FILES)
    linker = _Linker(files, source)
    linker.follow(module, (source.name,))
    if linker.diagnostics:
        raise CompileError(linker.source, sorted(linker.diagnostics, key=lambda each: each.label.span))
    return Linked(linker.source, linker.found)


def import_statements(module: nodes.Module) -> Iterator[nodes.Import | nodes.ImportFrom]:
    return (s for s in module.statements if isinstance(s, nodes.Import | nodes.ImportFrom))


@dataclass
class _Linker:
    files: Files
    source: Source
    found: dict[Span, ImportedFile] = field(default_factory=dict)
    read: dict[str, ImportedFile | None] = field(default_factory=dict)
    """Files by identity; None if a file is unreadable."""
    diagnostics: list[Diagnostic] = field(default_factory=list)

    def follow(self, module: nodes.Module, stack: tuple[str, ...]) -> None:
        """Read everything that a module imports; `stack` holds the names of the files that led here."""
        for statement in import_statements(module):
            if len(self.diagnostics) >= FILE_LIMIT:
                return
            file = self._file(statement, stack, module)
            if file is not None:
                self.found[statement.span] = file

    def _file(
        self, node: nodes.Import | nodes.ImportFrom, stack: tuple[str, ...], module: nodes.Module
    ) -> ImportedFile | None:
        name = self.files.find(stack[-1], _candidates(node))
        if name is None:
            self.diagnostics.append(_missing(node, self._others_there(node, stack), module))
            return None
        identity = self.files.identity(name)
        running = [self.files.identity(each) for each in stack]
        if identity in running:
            cycle = " -> ".join((*stack[running.index(identity) :], name))
            self.diagnostics.append(IMPORT_CYCLE.at(node.path_span, cycle=cycle))
            return None
        if identity not in self.read:
            if len(self.read) == FILE_LIMIT:
                self.diagnostics.append(TOO_MANY_IMPORTS.at(node.path_span, limit=FILE_LIMIT))
                return None
            self.read[identity] = None
            self._read(identity, name, node, stack)
        return self.read[identity]

    def _others_there(self, node: nodes.Import | nodes.ImportFrom, stack: tuple[str, ...]) -> list[str]:
        """Files in the folder that is meant, as the import would name them, without those that led here."""
        running = [self.files.identity(each) for each in stack]
        there = self.files.beside(stack[-1], _candidates(node)[0])
        found = ((path, self.files.find(stack[-1], (path,))) for path in there)
        return [path for path, name in found if name is not None and self.files.identity(name) not in running]

    def _read(self, identity: str, name: str, node: nodes.Import | nodes.ImportFrom, stack: tuple[str, ...]) -> None:
        start = len(self.source.whole) + 1
        try:
            text = self.files.read(name)
            module = parse(text)
        except CompileError as error:
            self.source = self.source.with_import(name, error.source.text)
            self.diagnostics += [_moved(diagnostic, start) for diagnostic in error.diagnostics]
            return
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            self.diagnostics.append(UNREADABLE_IMPORT.at(node.path_span, name=name, reason=reason))
            return
        self.source = self.source.with_import(name, text.text)
        file = self.read[identity] = ImportedFile(name, shifted(module, start))
        self.follow(file.module, (*stack, name))


def _candidates(node: nodes.Import | nodes.ImportFrom) -> list[str]:
    """Paths at which an imported file may lie."""
    if node.quoted:
        return [node.path, *(node.path + suffix for suffix in SUFFIXES if not PurePath(node.path).suffix)]
    return [node.path.replace(".", "/") + suffix for suffix in SUFFIXES]


PYTHON = frozenset({"math", "random", "numpy", "time", "os", "sys", "carla", "scenic", "verifai"})
INSTEAD_OF_PYTHON = (
    "scenarios import no Python: `sqrt`, `sin` and `abs` are built in, and chance is written `Range(low, high)`, "
    "`Normal(mean, deviation)` or `Uniform(a, b)`"
)


CHANCE = {
    "uniform": "Range(low, high)",
    "random": "Range(0, 1)",
    "rand": "Range(0, 1)",
    **dict.fromkeys(("randint", "randrange", "integers"), "DiscreteRange(low, high)"),
    **dict.fromkeys(("gauss", "normal", "normalvariate", "randn"), "Normal(mean, deviation)"),
    "truncnorm": "TruncatedNormal(mean, deviation, low, high)",
    "choice": "Uniform(*items)",
    "choices": "Discrete({a: 2, b: 1})",
    "shuffle": "do shuffle A(), B()",
}
"""Functions of Python's `random` and of `numpy.random`, and what is written instead."""


def _of_chance(node: nodes.Import | nodes.ImportFrom, module: nodes.Module) -> str:
    """Return the distributions that replace the functions of chance of a file with such an import."""
    used = [each.name for each in node.names] if isinstance(node, nodes.ImportFrom) else []
    used += [each.name for each in everything_in(module) if isinstance(each, nodes.Attribute)]
    found = dict.fromkeys(name for name in used if name in CHANCE)
    return "; ".join(f"for `{name}` write `{CHANCE[name]}`" for name in found if len(found) == 1 or name != "random")


def _missing(node: nodes.Import | nodes.ImportFrom, there: list[str], module: nodes.Module) -> Diagnostic:
    spelled = there if node.quoted else [_dotted(path) for path in there]
    suggestion = did_you_mean(node.path, spelled) or "there is no other scenario file in that folder"
    if not node.quoted and node.path.split(".")[0] in PYTHON:
        suggestion = INSTEAD_OF_PYTHON
        if node.path.split(".")[0] in ("random", "numpy") and (chance := _of_chance(node, module)):
            suggestion = f"scenarios import no Python: {chance}"
    return MISSING_IMPORT.at(
        node.path_span, path=" or ".join(f"`{path}`" for path in _candidates(node)), suggestion=suggestion
    )


def nameless(node: nodes.Import) -> Diagnostic:
    """Return the diagnostic for an import path that is not a valid name."""
    path = f'"{node.path}"' if node.quoted else node.path
    name = re.sub(r"\W", "_", PurePath(node.path).stem) if node.quoted else node.path.rpartition(".")[2]
    return NAMELESS_IMPORT.at(node.path_span, path=node.path, statement=f"import {path}", name=name)


def _dotted(path: str) -> str:
    return ".".join(PurePath(path).with_suffix("").parts)


# -- one space of offsets ---------------------------------------------------------------------------------------------


def shifted(tree: Tree, by: int) -> Tree:
    """Return the tree, moved by `by` characters."""
    if isinstance(tree, Span):
        return cast("Tree", Span(tree.start + by, tree.end + by))
    if isinstance(tree, tuple):
        return cast("Tree", tuple(shifted(item, by) for item in tree))
    if not isinstance(tree, nodes.Node):
        return tree
    return cast("Tree", replace(tree, **{f.name: shifted(getattr(tree, f.name), by) for f in fields(tree)}))


def _moved(diagnostic: Diagnostic, by: int) -> Diagnostic:
    def label(each: Label) -> Label:
        return Label(shifted(each.span, by), each.text)

    return replace(diagnostic, label=label(diagnostic.label), secondary=tuple(map(label, diagnostic.secondary)))


# -- `-p NAME=VALUE`: the value is an expression of the language, put in the place of the param's own ------------------


def with_outside_params(module: nodes.Module, whole: nodes.Module, overrides: Mapping[str, str]) -> nodes.Module:
    """The main file with a `param` for each name that only the command line gives and that the files read as
    `globalParameters.NAME`: Scenic's scripts expect this, so files with a `model` line may do it.

    Raises:
        CompileError: for a value that is no expression.
    """
    model, known = scenic_model(whole), param_entries(whole)
    outside = [] if model is None else [name for name in overrides if name not in known and name in _params_read(whole)]
    if model is None or not outside:
        return module
    span = model.span
    values = ((name, _expression(Source("-p", f"{name} = {overrides[name]}"), name)) for name in outside)
    entries = (nodes.ParamEntry(name, moved(value, span), span=span, name_span=span) for name, value in values)
    return replace(module, statements=(nodes.Param(tuple(entries), span=span), *module.statements))


def _params_read(module: nodes.Module) -> frozenset[str]:
    reads = (node for node in everything_in(module) if isinstance(node, nodes.Attribute))
    return frozenset(
        node.name for node in reads if isinstance(node.value, nodes.Name) and node.value.id == "globalParameters"
    )


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
            raise CompileError(option, [UNKNOWN_OVERRIDE.at(Span(0, len(name)), name=name, suggestion=suggestion)])
        result[name] = moved(_expression(option, name), entries[name].value.span)
    return result


def _expression(option: Source, name: str) -> nodes.Expression:
    statements = parse(option).statements
    if len(statements) != 1 or not isinstance(statements[0], nodes.Assign):
        raise CompileError(option, [BAD_OVERRIDE.at(Span(0, len(option.text)), name=name)])
    return statements[0].value


def moved(tree: Tree, span: Span) -> Tree:
    """Return the tree with every span replaced."""
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


# -- Params that the command line holds fixed, as the file would write them --------------------------------------------

AMOUNT = re.compile(r"(?P<number>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?) *(?P<unit>\S*)")


@frozen
class FixedParam:
    """One param that is no gene in this run."""

    name: str
    value: float | str
    """Number in the file's own unit, or the text of the command line."""
    unit: str = ""

    @property
    def text(self) -> str:
        """The value without its unit."""
        return self.value if isinstance(self.value, str) else f"{self.value:.10g}"


def held_params(module: nodes.Module, overrides: Mapping[str, str]) -> tuple[FixedParam, ...]:
    """Return the params that `-p` and `--freeze` fix, in the order given."""
    entries = param_entries(module)
    return tuple(
        _held(name, override_text(entries[name], text) if name in entries else text) for name, text in overrides.items()
    )


def _held(name: str, text: str) -> FixedParam:
    amount = AMOUNT.fullmatch(text.strip())
    if amount is None or amount["unit"] not in ("", *UNIT_WORDS):
        return FixedParam(name, text)
    return FixedParam(name, float(amount["number"]), amount["unit"])
