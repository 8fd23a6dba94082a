"""What the user asked for: the command line, checked and typed."""

from collections.abc import Mapping
from dataclasses import field
from enum import Enum
from pathlib import Path

from engine.frozen import frozen


class Mode(Enum):
    """What `cortexc FILE` is to do with the file."""

    RUN = "run"
    SEARCH = "search"
    SAMPLE = "sample"
    CHECK = "check"
    EMIT = "emit"


@frozen
class Request:
    """One `cortexc FILE ...`. An option that was not given is None, so that the file may decide before the default."""

    file: Path
    mode: Mode
    methods: tuple[str, ...] = ()
    """Of a search: names of `engine.search.searchers`, each once."""
    samples: int = 0
    stage: str = ""
    """Of `--emit`."""
    overrides: Mapping[str, str] = field(default_factory=dict)
    """The `-p NAME=VALUE` pairs; values are read by the rules of the language."""
    freeze: tuple[str, ...] | None = None
    """Params to hold fixed; (): those that the file calls the system's."""
    scenario: str | None = None
    """Which of several scenarios to run; None: the file's own choice."""
    generations: int = 30
    population: int = 100
    seed: int | None = None
    """None: what a concrete file pins, else 0."""
    preset: str = "cortex"
    engine: str | None = None
    rollouts: int = 1
    aggregate: str = "mean"
    jobs: int = 1
    dask: str | None = None
    """Address of a scheduler, or `local`."""
    out: Path | None = None
    max_attempts: int | None = None
    time_step: float | None = None
    profile: str = "paper"
    prune: bool = False
    target: float | None = None
    """Of `--sample`: the acceptance that a requirement is to be relaxed for."""
    json: bool = False
    colour: bool | None = None
    """False: never; None: the terminal decides."""
    diagnostics_format: str = "text"
    command_line: tuple[str, ...] = ()
    """As typed, without the program's name; kept in the manifest of a search."""
