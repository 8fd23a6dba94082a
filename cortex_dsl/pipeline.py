"""The whole compiler as one function: text in, program out, with every intermediate stage for inspection."""

from collections.abc import Mapping
from dataclasses import field
from typing import TYPE_CHECKING

from cortex_dsl import ir
from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.files import DISK, Files, map_among_others
from cortex_dsl.lowering import lower
from cortex_dsl.semantics.elaboration import elaborate
from cortex_dsl.semantics.names.linking import link
from cortex_dsl.source import Source, Span
from cortex_dsl.syntax import parse
from cortex_dsl.syntax.nodes import Module
from engine.frozen import frozen
from engine.program import Program

if TYPE_CHECKING:
    from cortex_dsl.semantics.model.context import Observer
    from cortex_dsl.semantics.names.linking import ImportedFile

NO_OVERRIDES: Mapping[str, str] = {}


@frozen
class Compiled:
    """A file at every stage of its compilation, with its warnings and notes."""

    source: Source
    module: Module
    scenario: ir.Scenario
    program: Program
    diagnostics: tuple[Diagnostic, ...]
    imports: "Mapping[Span, ImportedFile]" = field(default_factory=dict)
    """The file behind each import statement."""


def compile_source(
    source: Source,
    overrides: Mapping[str, str] = NO_OVERRIDES,
    *,
    scenario: str | None = None,
    files: Files = DISK,
    observe: "Observer | None" = None,
    domains: ir.DomainUse | None = None,
) -> Compiled:
    """Compile a text. `overrides` fixes params to constants, as `-p NAME=VALUE` does.

    `scenario` is the name to run if the file has several, `files` the source of imports; `observe` is called with every
    value during elaboration; `domains` is the effect of `domain` lines, by default none.

    Raises:
        CompileError: with every error found.
    """
    return compile_module(
        parse(source), source, overrides, scenario=scenario, files=files, observe=observe, domains=domains
    )


def compile_module(
    module: Module,
    source: Source,
    overrides: Mapping[str, str] = NO_OVERRIDES,
    *,
    scenario: str | None = None,
    files: Files = DISK,
    observe: "Observer | None" = None,
    domains: ir.DomainUse | None = None,
) -> Compiled:
    """Compile the syntax tree of a text, as `compile_source` does.

    Raises:
        CompileError: with every error found.
    """
    linked = link(module, source, files)
    checked, diagnostics = elaborate(
        module,
        linked.source,
        overrides,
        imports=linked.files,
        scenario=scenario,
        observe=observe,
        domains=domains,
        find_map=lambda path: files.find(source.name, [path]) or map_among_others(path),
    )
    return Compiled(linked.source, module, checked, lower(checked), diagnostics, linked.files)
