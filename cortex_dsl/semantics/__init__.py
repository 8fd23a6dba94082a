"""Semantics: from the syntax tree to the checked IR. The work is imported by the first call."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from cortex_dsl import ir
from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.source import Source, Span
from cortex_dsl.syntax import nodes

if TYPE_CHECKING:
    from cortex_dsl.files import Files
    from cortex_dsl.semantics.model.context import Observer
    from cortex_dsl.semantics.names.linking import ImportedFile, Linked

NO_OVERRIDES: Mapping[str, str] = {}
NO_FILES: "Mapping[Span, ImportedFile]" = {}

__all__ = ["elaborate", "link"]


def elaborate(
    module: nodes.Module,
    source: Source,
    overrides: Mapping[str, str] = NO_OVERRIDES,
    *,
    imports: "Mapping[Span, ImportedFile]" = NO_FILES,
    scenario: str | None = None,
    observe: "Observer | None" = None,
) -> tuple[ir.Scenario, tuple[Diagnostic, ...]]:
    """The checked scenario, and the warnings and notes about it. `overrides` are the `-p NAME=VALUE` of the command,
    `imports` the file behind each import statement, `scenario` the one to run; `observe` is called with every value
    as it is worked out.

    Raises:
        CompileError: with every error found.
    """
    from cortex_dsl.semantics.elaboration import elaborate as run

    return run(module, source, overrides, imports=imports, scenario=scenario, observe=observe)


def link(module: nodes.Module, source: Source, files: "Files") -> "Linked":
    """Read what a file imports, and what that imports.

    Raises:
        CompileError: with every error found in the imported files.
    """
    from cortex_dsl.semantics.names.linking import link as run

    return run(module, source, files)
