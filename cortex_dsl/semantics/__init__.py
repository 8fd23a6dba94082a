"""Semantics: from the syntax tree to the checked IR. The work is imported by the first call."""

from collections.abc import Mapping

from cortex_dsl import ir
from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.source import Source
from cortex_dsl.syntax import nodes

NO_OVERRIDES: Mapping[str, str] = {}

__all__ = ["elaborate"]


def elaborate(
    module: nodes.Module, source: Source, overrides: Mapping[str, str] = NO_OVERRIDES
) -> tuple[ir.Scenario, tuple[Diagnostic, ...]]:
    """The checked scenario, and the warnings and notes about it. `overrides` are the `-p NAME=VALUE` of the command.

    Raises:
        CompileError: with every error found.
    """
    from cortex_dsl.semantics.elaboration import elaborate as run

    return run(module, source, overrides)
