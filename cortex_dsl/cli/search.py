"""`cortexc FILE --method NAME,…` (`--ga`, `--random`): search, keep everything, and say what was found."""

from pathlib import Path

from cortex_dsl.api.run_folder import Found, search_and_keep
from cortex_dsl.api.scenario import Scenario
from cortex_dsl.cli.compiling import compile_request
from cortex_dsl.cli.exits import Exit, UsageError
from cortex_dsl.cli.hunting import asked_workers, removed, tell, usage_errors, watched
from cortex_dsl.cli.request import Request
from cortex_dsl.cli.simulation import compile_kernels, open_scenario
from cortex_dsl.cli.terminal import Terminal
from engine.program import Program
from engine.search.protocol import Box
from engine.search.searchers import build_searcher
from engine.search.store import new_directory, numbered_directory


def execute(request: Request, terminal: Terminal) -> int:
    compiled = compile_request(request, terminal)
    if isinstance(compiled, Exit):
        return compiled
    if not len(compiled.program.space):
        raise UsageError(f"`{request.file}` has no param to search", "give it one: `param SPEED = Range(5, 80) km/h`")
    scenario = open_scenario(request, compiled)
    with usage_errors():
        for method in request.methods:  # what is missing is said before anything is made
            build_searcher(method, Box.of(scenario.program.space), scenario.config)
        compile_kernels(scenario, terminal)
        found = _searches(request, scenario, terminal)
    return tell(found, scenario, request, terminal)


def _searches(request: Request, scenario: Scenario, terminal: Terminal) -> list[Found]:
    """One search after the other; Ctrl-C ends the one that runs and leaves out those to come."""
    done: list[Found] = []
    for method in request.methods:
        try:
            done.append(_search(method, request, scenario, terminal))
        except KeyboardInterrupt:
            if not done:
                raise
            break
        if done[-1].campaign.stopped:
            break
    return done


def _search(method: str, request: Request, scenario: Scenario, terminal: Terminal) -> Found:
    """One whole search with its run directory."""
    folder = _folder(method, request, scenario.program)
    with watched(terminal, method, request.generations) as on_generation:
        return search_and_keep(
            scenario,
            method,
            folder,
            profile=request.profile,
            command_line=request.command_line,
            on_generation=on_generation,
            on_removed=removed(terminal),
            workers=asked_workers(request, scenario.config.search.engine),
        )


def _folder(method: str, request: Request, program: Program) -> Path:
    if request.out is None:
        return numbered_directory(program.name, method)
    return new_directory(request.out if len(request.methods) == 1 else request.out / method)
