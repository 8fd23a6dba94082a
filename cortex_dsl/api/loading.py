"""A scenario from a file or from text."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import NoneType

from cortex_dsl.api import arguments
from cortex_dsl.api.scenario import Scenario
from cortex_dsl.files import DISK, Folder
from cortex_dsl.pipeline import compile_source
from cortex_dsl.source import Source
from cortex_dsl.syntax.reading import read_source
from engine.config import Config, SimulationConfig
from engine.errors import UnreadableFileError
from engine.program import Settings


def load(path: str | Path, config: Config | None = None, scenario: str | None = None, **params: object) -> Scenario:
    """Compile a file. Keywords fix params to constants: `load(path, EGO_SPEED="50 km/h", EGO_BRAKE=0)`.

    `scenario` is the name of the scenario to run if the file has several.

    Raises:
        CompileError: with every mistake in the file.
        UnreadableFileError: the file cannot be read.
    """
    arguments.path_of("path", path, "name a file; `compile_text` takes the text itself")
    try:
        with arguments.drawn_errors():
            source = read_source(path)
    except OSError as error:
        raise UnreadableFileError(path, error) from error
    return _compiled(source, config, scenario, DISK, params)


def compile_text(
    text: str,
    name: str = "<text>",
    config: Config | None = None,
    scenario: str | None = None,
    folder: str | Path | None = None,
    **params: object,
) -> Scenario:
    """Compile a scenario given as text; `name` is its name in messages, `folder` the folder of its imports.

    Raises:
        CompileError: with every mistake in the text.
    """
    arguments.kind("text", text, str, "`load` takes the path of a file")
    files = DISK if folder is None else Folder(arguments.path_of("folder", folder))
    return _compiled(Source(name, text), config, scenario, files, params)


def _compiled(
    source: Source, config: Config | None, scenario: str | None, files: Folder, params: Mapping[str, object]
) -> Scenario:
    config = Config() if config is None else arguments.config_of(config)
    arguments.kind("scenario", scenario, (str, NoneType), arguments.LEFT_OUT)
    overrides = {param: str(value) for param, value in params.items()}
    with arguments.drawn_errors():
        compiled = compile_source(source, overrides, scenario=scenario, files=files)
    compiled = replace(compiled, diagnostics=arguments.in_python(compiled.diagnostics))
    simulation = in_file(config.simulation, compiled.program.settings)
    return Scenario(compiled, replace(config, simulation=simulation), overrides, scenario)


def in_file(config: SimulationConfig, settings: Settings) -> SimulationConfig:
    """Return the config with the settings that the file itself makes."""
    said = {name: getattr(settings, name) for name in ("time_step", "max_time", "max_attempts")}
    return replace(config, **{name: value for name, value in said.items() if value is not None})
