"""`cortexc FILE --check`: compile, prove what can be proved, say what was found, run nothing."""

from collections.abc import Callable

from cortex_dsl.console.compiling import compile_request, diagnostics_document, show
from cortex_dsl.console.request import Request
from cortex_dsl.console.scenario_mistakes import misplaced, no_scene_at_all
from cortex_dsl.console.terminal import Exit, Terminal
from cortex_dsl.console.user_files import read_source
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.pipeline import Compiled
from cortex_dsl.report.documents import feasibility_content
from cortex_dsl.report.findings.readable import counted
from cortex_dsl.report.terminal.check_view import feasibility_view
from cortex_dsl.semantics.names.tree import everything_in
from cortex_dsl.source import Source
from cortex_dsl.syntax import nodes
from engine.feasibility import remembered


def check(request: Request, terminal: Terminal) -> int:
    compiled = compile_request(request, terminal)
    if isinstance(compiled, Exit):
        return compiled
    found = remembered(compiled.program)
    mistakes = misplaced(compiled, found.conflict)
    if found.infeasible or mistakes:
        mistakes = mistakes or [no_scene_at_all(compiled.program, compiled.source, found)]
        diagnostics = [*compiled.diagnostics, *mistakes] if request.json else mistakes
        content = feasibility_content(compiled.program, found)
        show(compiled.source, diagnostics, request, terminal, failed=True, feasibility=content)
        return Exit.DIAGNOSTICS
    if request.json:
        content = feasibility_content(compiled.program, found)
        terminal.write(diagnostics_document(compiled.source, compiled.diagnostics, content))
    elif request.diagnostics_format == "text":
        program = compiled.program
        sizes = (
            counted(len(program.space), "param"),
            counted(len(program.actors), "actor"),
            counted(len(program.variants), "variant"),
            counted(_requirements(compiled), "requirement"),
        )
        terminal.out.print(f"{request.file}: fine ({', '.join(sizes)})", soft_wrap=True)
        if (ranges := feasibility_view(program, found)) is not None:
            terminal.out.print(ranges)
    return Exit.FINE


def _requirements(compiled: Compiled) -> int:
    """How many are written: on scenes and on the run, not those that the compiler adds."""
    modules = (compiled.module, *dict.fromkeys(file.module for file in compiled.imports.values()))
    return sum(isinstance(node, nodes.Require) for module in modules for node in everything_in(module))


# -- `cortexc FILE --emit STAGE`: print what the compiler has made of the file at one of its stages --------------------


def emit(request: Request, terminal: Terminal) -> int:
    text = _syntax_stage(request, terminal) if request.stage in _SYNTAX else _later_stage(request, terminal)
    if isinstance(text, Exit):
        return text
    if request.json:
        from cortex_dsl.report.documents import document

        text = document("stage", {"file": str(request.file), "stage": request.stage, "text": text})
    terminal.write(text)
    return Exit.FINE


def _syntax_stage(request: Request, terminal: Terminal) -> str | Exit:
    """A stage that a file reaches even when its names or units are wrong."""
    try:
        return _SYNTAX[request.stage](read_source(request.file))
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


def _later_stage(request: Request, terminal: Terminal) -> str | Exit:
    compiled = compile_request(request, terminal)
    if isinstance(compiled, Exit):
        return compiled
    if request.stage == "ir":
        from cortex_dsl.semantics.printing import format_ir

        return format_ir(compiled.scenario)
    from cortex_dsl.lowering.program_listing import format_program

    return format_program(compiled.program)
