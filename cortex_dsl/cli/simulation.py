"""What commands that draw and simulate share: the settings that apply, and the word about the first compile."""

from dataclasses import replace

from cortex_dsl.cli.exits import UsageError
from cortex_dsl.cli.request import Request
from cortex_dsl.cli.terminal import Terminal
from engine.config import SimulationConfig
from engine.program import Program

STEP_LIMIT = 2_000_000
"""Steps of one run: its states must fit in memory."""


def simulation_config(request: Request, program: Program) -> SimulationConfig:
    """Defaults, overridden by the file, overridden by flags.

    Raises:
        UsageError: a run of more steps than there may be.
    """
    config = SimulationConfig()
    for settings in (program.settings, request):
        given = {
            name: value
            for name in ("time_step", "max_time", "max_attempts")
            if (value := getattr(settings, name, None)) is not None
        }
        config = replace(config, **given)
    if config.max_time / config.time_step > STEP_LIMIT:
        raise UsageError(
            f"{config.max_time:g} s in steps of {config.time_step:g} s are more than {STEP_LIMIT:,} steps",
            "take a longer --time-step, or `terminate after` a shorter time",
        )
    return config


def announce_compilation(terminal: Terminal) -> None:
    """The first command after an installation or update compiles kernels; say so before it seems to hang."""
    from engine.kernels.jit import kernels_are_cached

    if not kernels_are_cached():
        terminal.err.print("compiling kernels (once, some seconds) …", style="quiet")


def again(request: Request, *arguments: str) -> str:
    """The command that does the same again."""
    import shlex

    params = [word for name, value in request.overrides.items() for word in ("-p", f"{name}={value}")]
    return shlex.join(["cortexc", str(request.file), *params, *arguments])
