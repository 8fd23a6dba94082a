"""`--freeze`: the params of the system under test are held fixed, so that no search wins by switching brakes off."""

from collections.abc import Mapping
from dataclasses import replace

from cortex_dsl.cli.exits import UsageError
from cortex_dsl.cli.files import read_source
from cortex_dsl.cli.request import Request
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.pipeline import compile_source
from cortex_dsl.spelling import did_you_mean
from engine.program import ParamSpace
from engine.vocabulary import GeneKind


def frozen(request: Request) -> Request:
    """The request with a value for each param to freeze that has none: the middle of its range, or its middle option.

    Raises:
        UsageError: there is no such param, or the file names none.
    """
    if request.freeze is None:
        return request
    try:
        compiled = compile_source(read_source(request.file), request.overrides, scenario=request.scenario)
    except CompileError:
        return request  # the command itself will say why
    space = compiled.program.space
    names = request.freeze or _of_system(space, request)
    return replace(request, overrides={**request.overrides, **_middles(space, names, request.overrides)})


def _of_system(space: ParamSpace, request: Request) -> tuple[str, ...]:
    if not space.system:
        raise UsageError(
            f"`{request.file}` does not say which params belong to the system under test",
            "write `simulation(system=[NAME, …])` in it, or name them here: `--freeze NAME,NAME`",
        )
    return space.system


def _middles(space: ParamSpace, names: tuple[str, ...], given: Mapping[str, str]) -> dict[str, str]:
    values: dict[str, str] = {}
    for name in names:
        if name in space.names:
            values[name] = _middle(space, space.names.index(name))
        elif name not in given and name not in space.system:
            raise UsageError(f"`--freeze {name}`: the file has no such param", did_you_mean(name, space.names))
    return values


def _middle(space: ParamSpace, gene: int) -> str:
    """As `-p` takes it: a bare number is in the param's own unit."""
    middle = float(space.low[gene] + space.high[gene]) / 2.0
    if space.kinds[gene] == GeneKind.CONTINUOUS:
        return repr(middle)
    return space.options[gene][int(middle)] if space.kinds[gene] == GeneKind.INDEX else str(int(middle))
