"""What a run directory says about how it came to be: enough to compile and repeat the run, and to refuse what does not
belong.
"""

import platform
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, fields
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from engine.config import Config, ContactConfig, GAConfig, SearchConfig, SimulationConfig
from engine.program import Program
from engine.search.methods.table import SEARCHERS
from engine.search.searchers import distribution_of
from engine.streams import method_number, old_number

DISTRIBUTIONS = ("cortexc", "numpy", "numba", "pymunk")
"""Whose versions may decide a result."""
PYTHON = ".".join(map(str, sys.version_info[:3]))


@dataclass(frozen=True)
class Parameter:
    """One gene as the file declares it, file units."""

    name: str
    unit: str
    kind: int
    low: float
    high: float
    options: tuple[str, ...]
    system: bool = False
    """Whether it belongs to the system under test."""


@dataclass(frozen=True)
class Text:
    """An imported file, as it was."""

    name: str
    text: str


@dataclass(frozen=True)
class Link:
    """Which file an import statement meant."""

    importer: str
    """Name of the file with the statement."""
    path: str
    """The first path at which the statement looks for a file."""
    name: str
    """The file that was found."""


@dataclass(frozen=True)
class Origin:
    """What a compiler needs beside the main text to make the same program again."""

    imports: tuple[Text, ...] = ()
    links: tuple[Link, ...] = ()
    overrides: dict[str, str] = field(default_factory=dict)
    """Params held fixed, as `-p` was given."""
    scenario: str | None = None
    """The one of several that was asked for."""


NO_ORIGIN = Origin()


@dataclass(frozen=True)
class Manifest:
    """Written once, before the first evaluation."""

    name: str
    """Of the scenario."""
    file: str
    """Where it was read from."""
    file_text: str
    file_digest: str
    """SHA-256 of the text."""
    program_digest: str
    method: str
    preset: str
    profile: str
    seed: int
    run: int
    settings: dict[str, Any]
    """Every setting of `engine.config.Config`."""
    versions: dict[str, str]
    platform: str
    command_line: tuple[str, ...]
    parameters: tuple[Parameter, ...]
    requirements: tuple[str, ...]
    """Names, in the order of the counts of each evaluation."""
    rules: tuple[str, ...]
    actors: tuple[str, ...]
    origin: Origin = NO_ORIGIN
    number: int | None = None
    """Of the method in every stream key, where its name makes it (see `engine.streams`); None for a method of
    `Method`, and in a manifest from before names made numbers."""

    @property
    def method_number(self) -> int:
        """Of the method in every stream key."""
        return old_number(self.method) if self.number is None else self.number

    def stored(self) -> dict[str, Any]:
        """What is stored of it; a number that there is none of is left out."""
        values = {each.name: getattr(self, each.name) for each in fields(self)}
        return {name: value for name, value in values.items() if name != "number" or value is not None}

    @property
    def config(self) -> Config:
        """The settings as they were; what is newer than the manifest has its default."""
        return Config(
            simulation=SimulationConfig(**self.settings["simulation"]),
            contact=ContactConfig(**self.settings["contact"]),
            search=SearchConfig(**self.settings["search"]),
            ga=GAConfig(**self.settings["ga"]),
        )


def make_manifest(
    program: Program,
    config: Config,
    method: str,
    profile: str = "paper",
    file: str = "",
    command_line: Sequence[str] = (),
    origin: Origin = NO_ORIGIN,
) -> Manifest:
    """The manifest of a search that is about to start; `method` is a row of `searchers.SEARCHERS`."""
    return Manifest(
        name=program.name,
        file=file,
        file_text=program.source_text,
        file_digest=sha256(program.source_text.encode()).hexdigest(),
        program_digest=program.digest,
        method=method,
        preset=config.ga.preset if method == "ga" else "",
        profile=profile,
        seed=config.search.seed,
        run=config.search.run,
        settings=asdict(config),
        versions={"python": PYTHON, **_versions(method)},
        platform=f"{platform.system()} {platform.machine()}",
        command_line=tuple(command_line),
        parameters=_parameters(program),
        requirements=tuple(requirement.name for requirement in program.requirements),
        rules=tuple(rule.name for rule in program.rules),
        actors=program.actors,
        origin=origin,
        number=method_number(method) if method_number(method) != old_number(method) else None,
    )


def _parameters(program: Program) -> tuple[Parameter, ...]:
    space = program.space
    numbers = space.kinds.tolist(), space.low.tolist(), space.high.tolist()
    rows = zip(space.names, space.units, *numbers, space.options, strict=True)
    return tuple(Parameter(*row, system=row[0] in space.system) for row in rows)


def _versions(method: str) -> dict[str, str]:
    entry, plugin = SEARCHERS.get(method), distribution_of(method)
    versions = dict([plugin] if plugin else ())
    for name in (*DISTRIBUTIONS, *([entry.package] if entry and entry.package else ())):
        try:
            versions[name] = version(name)
        except PackageNotFoundError:
            versions[name] = "unknown"
    return versions


def changed_versions(manifest: Manifest) -> list[str]:
    """What a run was started with and is installed differently now, such as `numba 0.68.1`."""
    now = {"python": PYTHON, **_versions(manifest.method)}
    return [f"{name} {then}" for name, then in manifest.versions.items() if now.get(name) != then]
