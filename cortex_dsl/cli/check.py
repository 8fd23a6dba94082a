"""`cortexc FILE --check`: compile, say what was found, run nothing."""

from cortex_dsl.cli.compiling import compile_request, diagnostics_document
from cortex_dsl.cli.exits import Exit
from cortex_dsl.cli.request import Request
from cortex_dsl.cli.terminal import Terminal
from cortex_dsl.report.numbers import counted


def execute(request: Request, terminal: Terminal) -> int:
    compiled = compile_request(request, terminal)
    if isinstance(compiled, Exit):
        return compiled
    if request.json:
        terminal.write(diagnostics_document(compiled.source, compiled.diagnostics))
    elif request.diagnostics_format == "text":
        program = compiled.program
        sizes = (
            counted(len(program.space), "param"),
            counted(len(program.actors), "actor"),
            counted(len(program.variants), "variant"),
            counted(sum(r.line > 0 for r in program.requirements), "requirement"),
        )
        terminal.out.print(f"{request.file}: fine ({', '.join(sizes)})", soft_wrap=True)
    return Exit.FINE
