"""Modes that run nothing: `--check` compiles and proves, `--emit STAGE` prints the result of a compiler stage."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from cortex_dsl.console.compiling import compile_request, show, write_diagnostics
from cortex_dsl.console.request import CompileRequest
from cortex_dsl.console.terminal import Exit, Terminal
from cortex_dsl.console.user_files import read_source
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.source import Source

if TYPE_CHECKING:
    from cortex_dsl.pipeline import Compiled
    from engine.feasibility import Feasibility

# Imports that a syntax stage does not need are made where they are used.


def check(request: CompileRequest, terminal: Terminal) -> int:
    """Compile a file, prove its feasibility, and show the results."""
    from cortex_dsl.api.scenario_mistakes import misplaced
    from cortex_dsl.report.findings.impossible import no_scene_at_all
    from cortex_dsl.report.terminal.check_view import feasibility_view
    from engine.feasibility import remembered

    compiled = compile_request(request, terminal)
    if isinstance(compiled, Exit):
        return compiled
    found = remembered(compiled.program)
    mistakes = misplaced(compiled, found.conflict)
    if found.infeasible or mistakes:
        mistakes = mistakes or [no_scene_at_all(compiled.program, compiled.source, found)]
        proved = _proved(compiled, found) if request.json else None
        show(compiled.source, mistakes, request, terminal, failed=True, feasibility=proved)
        return Exit.DIAGNOSTICS
    if request.json:
        write_diagnostics(compiled.source, terminal, _proved(compiled, found))
    elif request.diagnostics_format == "text":
        terminal.out.print(f"{request.file}: fine ({_sizes(compiled)})", soft_wrap=True)
        if (ranges := feasibility_view(compiled.program, found)) is not None:
            terminal.out.print(ranges)
    return Exit.FINE


def _proved(compiled: "Compiled", found: "Feasibility") -> dict[str, Any]:
    """Return the proofs beyond the diagnostics as a document."""
    from cortex_dsl.report.documents import feasibility_content

    return feasibility_content(compiled.program, found)


def _sizes(compiled: "Compiled") -> str:
    """Return the size of a program's contents, in words."""
    from cortex_dsl.report.findings.readable import counted

    program = compiled.program
    sizes = ((program.space, "param"), (program.actors, "actor"), (program.variants, "variant"))
    words = [counted(len(things), noun) for things, noun in sizes]
    return ", ".join([*words, counted(_requirements(compiled), "requirement")])


def _requirements(compiled: "Compiled") -> int:
    """Return the number of written requirements, on scenes and on the run, without those that the compiler adds."""
    from cortex_dsl.semantics.names.tree import everything_in
    from cortex_dsl.syntax import nodes

    modules = (compiled.module, *dict.fromkeys(file.module for file in compiled.imports.values()))
    return sum(isinstance(node, nodes.Require) for module in modules for node in everything_in(module))


# -- the stages --------------------------------------------------------------------------------------------------------


def emit(request: CompileRequest, stage: str, terminal: Terminal) -> int:
    """Print the result of the compiler for a file at a stage."""
    text = (_syntax_stage if stage in _SYNTAX else _later_stage)(request, stage, terminal)
    if isinstance(text, Exit):
        return text
    if request.json:
        terminal.document("stage", {"file": str(request.file), "stage": stage, "text": text})
    else:
        terminal.write(text)
    return Exit.FINE


def _syntax_stage(request: CompileRequest, stage: str, terminal: Terminal) -> str | Exit:
    """A stage that a file reaches even when its names or units are wrong."""
    try:
        return _SYNTAX[stage](read_source(request.file))
    except CompileError as error:
        show(error.source, error.diagnostics, request, terminal, failed=True)
        return Exit.DIAGNOSTICS


def _tree(source: Source) -> str:
    from cortex_dsl.syntax import parse_tree

    return parse_tree(source).pretty()


def _ast(source: Source) -> str:
    from cortex_dsl.report.dump import dump
    from cortex_dsl.syntax import parse

    return dump(parse(source))


_SYNTAX: dict[str, Callable[[Source], str]] = {"tree": _tree, "ast": _ast}


def _later_stage(request: CompileRequest, stage: str, terminal: Terminal) -> str | Exit:
    compiled = compile_request(request, terminal)
    if isinstance(compiled, Exit):
        return compiled
    if stage == "ir":
        from cortex_dsl.semantics.printing import format_ir

        return format_ir(compiled.scenario)
    from cortex_dsl.lowering.program_listing import format_program

    return format_program(compiled.program)
