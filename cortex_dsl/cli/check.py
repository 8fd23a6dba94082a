"""`cortexc FILE --check`: compile, prove what can be proved, say what was found, run nothing."""

from cortex_dsl.cli.compiling import compile_request, diagnostics_document, show
from cortex_dsl.cli.exits import Exit
from cortex_dsl.cli.infeasible import no_scene_at_all
from cortex_dsl.cli.misplaced import misplaced
from cortex_dsl.cli.request import Request
from cortex_dsl.cli.terminal import Terminal
from cortex_dsl.pipeline import Compiled
from cortex_dsl.report.documents import feasibility_content
from cortex_dsl.report.findings.readable import counted
from cortex_dsl.report.terminal.check_view import feasibility_view
from cortex_dsl.semantics.tree import everything_in
from cortex_dsl.syntax import nodes
from engine.feasibility import remembered


def execute(request: Request, terminal: Terminal) -> int:
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
