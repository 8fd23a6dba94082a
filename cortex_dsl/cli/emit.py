"""`cortexc FILE --emit STAGE`: print what the compiler has made of the file at one of its stages."""

from collections.abc import Callable

from cortex_dsl.cli.compiling import compile_request, show
from cortex_dsl.cli.exits import Exit
from cortex_dsl.cli.files import read_source
from cortex_dsl.cli.request import Request
from cortex_dsl.cli.terminal import Terminal
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.source import Source


def execute(request: Request, terminal: Terminal) -> int:
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
        from cortex_dsl.semantics.printing.listing import format_ir

        return format_ir(compiled.scenario)
    from cortex_dsl.lowering.listing import format_program

    return format_program(compiled.program)
