"""What commands that draw and simulate share: the settings that apply, and the word about the first compile."""

import shlex
from dataclasses import replace

from cortex_dsl.api.scenario import Scenario, in_file
from cortex_dsl.cli.exits import UsageError
from cortex_dsl.cli.request import Request
from cortex_dsl.cli.terminal import Terminal
from cortex_dsl.pipeline import Compiled
from engine.config import Config, GAConfig, SearchConfig, SimulationConfig
from engine.program import Program, Settings


def open_scenario(request: Request, compiled: Compiled) -> Scenario:
    """The compiled file with every setting that applies: defaults, overridden by the file, overridden by flags.

    Raises:
        UsageError: a run of more steps, or a scene of more attempts, than there may be.
    """
    simulation = _simulation_config(request, compiled.program.settings)
    _check_attempts(compiled.program, simulation.max_attempts)
    search = SearchConfig(
        generations=request.generations,
        population=request.population,
        seed=request.seed or 0,
        rollouts=request.rollouts,
        aggregate=request.aggregate,
        jobs=request.jobs,
        engine=request.engine or "batch",
    )
    ga = replace(GAConfig(), preset=request.preset)
    config = Config(simulation=simulation, search=search, ga=ga)
    return Scenario(compiled, config, request.overrides, request.scenario)


def _simulation_config(request: Request, settings: Settings) -> SimulationConfig:
    from engine.runs import MAX_SAMPLES, samples_of

    flags = {"time_step": request.time_step, "max_attempts": request.max_attempts}
    config = in_file(SimulationConfig(), settings)
    config = replace(config, **{name: value for name, value in flags.items() if value is not None}, prune=request.prune)
    if samples_of(config) > MAX_SAMPLES:
        raise UsageError(
            f"{config.max_time:g} s in steps of {config.time_step:g} s are more than {MAX_SAMPLES:,} steps",
            "take a longer --time-step, or `terminate after` a shorter time",
        )
    return config


def _check_attempts(program: Program, attempts: int) -> None:
    """A stream of random numbers is long, but not endless."""
    from engine.sampling import attempt_limit

    if attempts > (limit := attempt_limit(program)):
        raise UsageError(
            f"{attempts:,} attempts at one scene are more than the {limit:,} that its random numbers last for",
            "lower --max-attempts, or `max_attempts` in the file",
        )


def announce_compilation(terminal: Terminal) -> bool:
    """The first command after an installation or update compiles kernels; say so before it seems to hang."""
    from engine.kernels.jit import kernels_are_cached

    if kernels_are_cached():
        return False
    terminal.err.print("compiling kernels (once, about half a minute) …", style="quiet")
    return True


def compile_kernels(scenario: Scenario, terminal: Terminal) -> None:
    """Compile now what a search will need, so that its pace and the time it has left are told without that."""
    if announce_compilation(terminal):
        scenario.simulate(scenario.sample(), scenario.config.search.engine)


def again(request: Request, *arguments: str) -> str:
    """The command that does the same again."""
    params = [word for name, value in request.overrides.items() for word in ("-p", f"{name}={value}")]
    scenario = ["--scenario", request.scenario] if request.scenario else []
    return shlex.join(["cortexc", str(request.file), *scenario, *params, *arguments])
