"""The whole compiler as one function: text in, program out, every stage on the way kept for whoever wants to see it."""

from collections.abc import Mapping
from dataclasses import dataclass

from cortex_dsl import ir
from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.lowering import lower
from cortex_dsl.semantics import elaborate
from cortex_dsl.source import Source
from cortex_dsl.syntax import parse
from cortex_dsl.syntax.nodes import Module
from engine.program import Program

NO_OVERRIDES: Mapping[str, str] = {}


@dataclass(frozen=True)
class Compiled:
    """A file at every stage of its compilation, and what was said about it on the way (warnings and notes)."""

    source: Source
    module: Module
    scenario: ir.Scenario
    program: Program
    diagnostics: tuple[Diagnostic, ...]


def compile_source(source: Source, overrides: Mapping[str, str] = NO_OVERRIDES) -> Compiled:
    """Compile a text. `overrides` fixes params to constants, as `-p NAME=VALUE` does.

    Raises:
        CompileError: with every error found.
    """
    module = parse(source)
    scenario, diagnostics = elaborate(module, source, overrides)
    program = lower(scenario)
    return Compiled(source, module, scenario, program, diagnostics)
