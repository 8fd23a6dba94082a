"""From the request's file to a program: params held, and everything that the compiler has to say shown on the way."""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from cortex_dsl.console.request import OF_SYSTEM, CompileRequest
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from cortex_dsl.console.user_files import read_source
from cortex_dsl.diagnostics import CompileError, Diagnostic, Severity
from cortex_dsl.source import Source
from cortex_dsl.spelling import did_you_mean

if TYPE_CHECKING:
    from cortex_dsl.pipeline import Compiled
    from engine.program import ParamSpace

MOST_CODES = 5
"""Further codes that a listing names at its end."""


def compile_request(request: CompileRequest, terminal: Terminal) -> "Compiled | Exit":
    """The compiled file, or the exit code once its errors are shown."""
    from cortex_dsl.pipeline import compile_source

    try:
        source = read_source(request.file)
        compiled = compile_source(source, request.overrides, scenario=request.scenario)
    except CompileError as error:
        show(error.source, error.diagnostics, request, terminal, failed=True)
        return Exit.DIAGNOSTICS
    show_compiled(compiled, request, terminal)
    return compiled


def show_compiled(compiled: "Compiled", request: CompileRequest, terminal: Terminal) -> None:
    """Show warnings and notes of a file that compiles, and hints if the request asks for them."""
    shown = [d for d in compiled.diagnostics if request.hints or d.severity is not Severity.HINT]
    show(compiled.source, shown, request, terminal)


def show(
    source: Source,
    diagnostics: Sequence[Diagnostic],
    request: CompileRequest,
    terminal: Terminal,
    *,
    failed: bool = False,
    feasibility: Mapping[str, Any] | None = None,
) -> None:
    """Show diagnostics in the requested form: text on stderr, documents and annotations on stdout.

    With --json they wait for the document of the command, which is written now if the command has `failed`.
    """
    if request.json:
        from cortex_dsl.report.findings.snippet import as_json

        terminal.diagnostics.extend(as_json(source, diagnostics))
        if failed:
            write_diagnostics(source, terminal, feasibility)
    elif request.diagnostics_format == "json":
        from cortex_dsl.report.findings.snippet import as_json

        document = Terminal(diagnostics=[*as_json(source, diagnostics)])
        write_diagnostics(source, document)
        terminal.wrote.extend(document.wrote)
    elif request.diagnostics_format == "github":
        from cortex_dsl.report.github import github_annotations

        for line in github_annotations(source, diagnostics):
            terminal.write(line)
    elif diagnostics:
        from cortex_dsl.report.terminal.diagnostics_view import print_diagnostics

        print_diagnostics(source, diagnostics, terminal.err)
        if terminal.err.is_terminal and (more := _where_to_read_more(diagnostics)):
            terminal.err.print(f"\nfor more: {more}", style="quiet", soft_wrap=True)
        sys.stderr.flush()


def _where_to_read_more(diagnostics: Sequence[Diagnostic]) -> str:
    """The command that explains the first code, and which others it could; nothing for notes and hints alone."""
    grave = (d.code for d in diagnostics if d.severity in (Severity.ERROR, Severity.WARNING))
    first, *others = list(dict.fromkeys(grave)) or [""]
    more = f" (or {', '.join(others[:MOST_CODES])}{', …' if len(others) > MOST_CODES else ''})" if others else ""
    return f"cortexc explain {first}{more}" if first else ""


def write_diagnostics(source: Source, terminal: Terminal, feasibility: Mapping[str, Any] | None = None) -> None:
    """Write the diagnostics of a compilation as the document of --json; `feasibility`: further proofs."""
    errors = sum(each["severity"] == Severity.ERROR.value for each in terminal.diagnostics)
    content = {"file": source.name, "errors": errors}
    terminal.document("diagnostics", content | ({} if feasibility is None else {"feasibility": feasibility}))


# -- `--freeze`: the params of the system under test are held fixed, so that no search wins by switching brakes off ----


def freeze_params(request: CompileRequest, terminal: Terminal) -> CompileRequest:
    """The request with a value for each param to freeze that has none: the middle of its range, or its middle option.

    Raises:
        UsageError: there is no such param, or the file names none.
    """
    if request.freeze is None:
        return request
    from cortex_dsl.pipeline import compile_source

    try:
        compiled = compile_source(read_source(request.file), request.overrides, scenario=request.scenario)
    except CompileError:
        return request  # the command itself reports why
    space = compiled.program.space
    names = space.system if request.freeze == OF_SYSTEM else request.freeze or _of_system(space, request)
    overrides = {**request.overrides, **_middles(space, names, request.overrides)}
    units = dict(zip(space.names, space.units, strict=True))
    if held := [_assigned(name, overrides[name], units.get(name, "")) for name in names if name in overrides]:
        terminal.note(f"held: {', '.join(held)}; `-p` sets others")
    return replace(request, overrides=overrides)


def _assigned(name: str, value: str, unit: str) -> str:
    """Return a param with its value, as `-p` takes it; a bare number has the unit of the param."""
    try:
        number = float(value)
    except ValueError:
        return f"{name}={value}"
    return f"{name}={number:.6g} {unit}".rstrip()


def _of_system(space: "ParamSpace", request: CompileRequest) -> tuple[str, ...]:
    if not space.system:
        raise UsageError(
            f"`{request.file}` does not say which params belong to the system under test",
            "write `simulation(system=[NAME, …])` in it, or name them here: `--freeze NAME,NAME`",
        )
    return space.system


def _middles(space: "ParamSpace", names: tuple[str, ...], given: Mapping[str, str]) -> dict[str, str]:
    values: dict[str, str] = {}
    for name in names:
        if name in space.names:
            values[name] = _middle(space, space.names.index(name))
        elif name not in given and name not in space.system:
            raise UsageError(f"`--freeze {name}`: the file has no such param", did_you_mean(name, space.names))
    return values


def _middle(space: "ParamSpace", gene: int) -> str:
    """As `-p` takes it: a bare number is in the param's own unit."""
    from engine.vocabulary import GeneKind

    middle = float(space.low[gene] + space.high[gene]) / 2.0
    if space.kinds[gene] == GeneKind.CONTINUOUS:
        return repr(middle)
    return space.options[gene][int(middle)] if space.kinds[gene] == GeneKind.INDEX else str(int(middle))
