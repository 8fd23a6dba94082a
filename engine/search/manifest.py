"""What a run directory says about how it came to be: enough to repeat the run, and to refuse what does not belong."""

import platform
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from engine.config import Config
from engine.program import Program

DISTRIBUTIONS = ("cortexc", "numpy", "numba", "pymunk")
"""Whose versions may decide a result."""


@dataclass(frozen=True)
class Parameter:
    """One gene as the file declares it, file units."""

    name: str
    unit: str
    kind: int
    low: float
    high: float
    options: tuple[str, ...]


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


def make_manifest(
    program: Program,
    config: Config,
    method: str,
    profile: str = "paper",
    file: str = "",
    command_line: Sequence[str] = (),
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
        versions={"python": ".".join(map(str, sys.version_info[:3])), **_versions()},
        platform=f"{platform.system()} {platform.machine()}",
        command_line=tuple(command_line),
        parameters=_parameters(program),
        requirements=tuple(requirement.name for requirement in program.requirements),
        rules=tuple(rule.name for rule in program.rules),
        actors=program.actors,
    )


def _parameters(program: Program) -> tuple[Parameter, ...]:
    space = program.space
    numbers = space.kinds.tolist(), space.low.tolist(), space.high.tolist()
    rows = zip(space.names, space.units, *numbers, space.options, strict=True)
    return tuple(Parameter(*row) for row in rows)


def _versions() -> dict[str, str]:
    versions = {}
    for name in DISTRIBUTIONS:
        try:
            versions[name] = version(name)
        except PackageNotFoundError:
            versions[name] = "unknown"
    return versions
