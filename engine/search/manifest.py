"""The manifest of a run directory: data to compile and repeat the run, and to reject files of other runs."""

import platform
import sys
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, asdict, dataclass, field, fields, is_dataclass, replace
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from types import MappingProxyType, UnionType
from typing import Any, get_args, get_origin, get_type_hints

from engine.config import Config, ContactConfig, GAConfig, SearchConfig, SimulationConfig
from engine.elementary import library
from engine.errors import Signal
from engine.host import MAX_SAMPLES, samples_of
from engine.program import Program
from engine.references import NAMES
from engine.risk import PROFILES
from engine.sampling import attempt_limit
from engine.search.methods.table import SEARCHERS
from engine.search.protocol import DEFAULT_OBJECTIVES, ObjectiveSpec, function_name
from engine.search.searchers import distribution_of
from engine.search.store import seen_from
from engine.streams import method_number, old_number
from engine.vocabulary import RECORDS

DISTRIBUTIONS = ("cortexc", "numpy", "numba", "pymunk")
"""Packages with versions that may change a result."""
LIBM = "libm"
"""Name of the mathematical library among the versions."""
PYTHON = ".".join(map(str, sys.version_info[:3]))
ALWAYS_THERE = ("generations", "population", "seed", "aggregate")
"""Settings of a search that every manifest has; those that are newer than it have their defaults."""
FIRST_REFERENCES = ("careful",)
"""Reference drivers of a run that is older than their choice."""
MOST_IN_TABLES = 20_000
"""Planned simulations of a search up to which its text tables are written without a request."""
LIMITS: Mapping[str, Mapping[str, tuple[float, float]]] = MappingProxyType(
    {
        "simulation": {
            "time_step": (1e-6, 1e3),
            "max_time": (1e-6, 1e6),
            "max_attempts": (1, 10**9),
            "instruction_budget": (1, 2**31 - 1),
        },
        "contact": {
            "restitution": (0.0, 1.0),
            "friction": (0.0, 1e3),
            "substep": (1e-5, 1e3),
            "aftermath": (0.0, 60.0),
            "collision_slop": (0.0, 1e3),
            "collision_persistence": (0, 10**6),
        },
        "search": {
            "generations": (1, 2**16 - 1),
            "population": (1, 10**6),
            "seed": (0, 2**63 - 1),
            "rollouts": (1, 10**4),
            "jobs": (1, 10**6),
            "run": (0, 2**31 - 1),
            "probes": (0, 10**6),
        },
        "ga": {
            "selection_rate": (0.0, 1.0),
            "crossover_rate": (0.0, 1.0),
            "mutation_rate": (0.0, 1.0),
            "tournament": (1, 10**6),
            "max_redraws": (0, 10**6),
        },
    }
)
"""Limits of the settings of every run; a manifest outside of them was changed from outside."""


@dataclass(frozen=True)
class Parameter:
    """One gene as declared in the file, in file units."""

    name: str
    unit: str
    kind: int
    low: float
    high: float
    options: tuple[str, ...]
    system: bool = False
    """True if the gene belongs to the system under test."""


@dataclass(frozen=True)
class Text:
    """An imported file with its text at the start of the run."""

    name: str
    text: str


DIGEST = "digest"
"""Value of `Link.path` for a map, which no statement imports; `Link.name` is then the digest of its file."""


@dataclass(frozen=True)
class Link:
    """The file to which an import statement refers."""

    importer: str
    """Name of the file with the statement."""
    path: str
    """The first path at which the statement looks for a file."""
    name: str
    """Name of the file that was found."""

    def seen_from(self, folder: Path) -> "Link":
        """Return the same with its files named as seen from a folder."""
        name = self.name if self.path == DIGEST else seen_from(folder, self.name)
        return Link(seen_from(folder, self.importer), self.path, name)


@dataclass(frozen=True)
class Origin:
    """Inputs of the compiler, in addition to the main text, that reproduce the program."""

    imports: tuple[Text, ...] = ()
    links: tuple[Link, ...] = ()
    overrides: dict[str, str] = field(default_factory=dict)
    """Params held fixed, as `-p` was given."""
    scenario: str | None = None
    """The requested scenario of a file with several."""

    def seen_from(self, folder: Path) -> "Origin":
        """Return the same with its files named as seen from the folder of a run or a study."""
        imports = tuple(Text(seen_from(folder, file.name), file.text) for file in self.imports)
        return replace(self, imports=imports, links=tuple(link.seen_from(folder) for link in self.links))


NO_ORIGIN = Origin()


@dataclass(frozen=True)
class DrivenBy:
    """Controller that drove in the run. It must be named again to continue; nothing is loaded from a manifest."""

    name: str
    digest: str
    """SHA-256 of the file that defines the controller; "" where there is none."""
    block: int
    """Number of scenes per query of the controller."""
    reproducible: bool = True
    """True if the controller drove a block in the same way when it was given twice."""
    observe: str = RECORDS
    """Observation of the controller, one of `engine.vocabulary.OBSERVABLE`."""


@dataclass(frozen=True)
class Manifest:
    """Description of a run, written once, before the first evaluation."""

    name: str
    """Name of the scenario."""
    file: str
    """Path of the scenario's file."""
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
    """Number of the method in every stream key if it follows from the name (see `engine.streams`); None for a method of
    `Method`, and in a manifest that is older than such numbers.
    """
    objective: tuple[str, ...] = DEFAULT_OBJECTIVES
    """Names of the objectives of the search."""
    objectives: tuple[str, ...] = ()
    """Names of the objectives of the file."""
    driver: DrivenBy | None = None
    tables: bool = False
    """True if the text tables are requested for a search of any size."""

    @property
    def has_tables(self) -> bool:
        """Return True if the text tables belong to the run: they are requested, or its planned size is small."""
        return self.tables or not is_large(self.config.search)

    @property
    def method_number(self) -> int:
        """Return the number of the method in every stream key."""
        return old_number(self.method) if self.number is None else self.number

    @property
    def aims(self) -> int:
        """Return the number of objectives stored per simulation; 0 for the risk alone, which is always stored."""
        return 0 if self.objective == DEFAULT_OBJECTIVES else len(self.objective)

    @property
    def keeps_sought(self) -> bool:
        """Return True if the values of objectives are stored for each simulation."""
        return self.aims + len(self.objectives) > 0

    def stored(self) -> dict[str, Any]:
        """Return the stored fields; a field that older manifests do not have is omitted if it has its usual value."""
        values = {each.name: getattr(self, each.name) for each in fields(self)}
        usual = {"number": None, "objective": DEFAULT_OBJECTIVES, "objectives": (), "driver": None, "tables": False}
        return {name: value for name, value in values.items() if name not in usual or value != usual[name]}

    @property
    def config(self) -> Config:
        """Return the settings of the run."""
        return config_from(self.settings)


def config_from(settings: Mapping[str, Any]) -> Config:
    """Return stored settings; one that is newer than they are has its default.

    A run that is older than the choice of reference drivers was judged by the careful driver.
    """
    searching: dict[str, Any] = dict(settings["search"])
    searching["references"] = tuple(searching.get("references", FIRST_REFERENCES))
    return Config(
        simulation=SimulationConfig(**settings["simulation"]),
        contact=ContactConfig(**settings["contact"]),
        search=SearchConfig(**searching),
        ga=GAConfig(**settings["ga"]),
    )


def is_large(search: SearchConfig) -> bool:
    """Return True for a search whose text tables are written on request only."""
    return search.simulations > MOST_IN_TABLES


def make_manifest(
    program: Program,
    config: Config,
    method: str,
    profile: str = "paper",
    file: str = "",
    command_line: Sequence[str] = (),
    origin: Origin = NO_ORIGIN,
    objective: Sequence[ObjectiveSpec] = DEFAULT_OBJECTIVES,
    reproducible: bool = True,
    tables: bool = False,
) -> Manifest:
    """Return the manifest of a search that is about to start; `method` is a row of `searchers.SEARCHERS`."""
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
        settings=_settings(config),
        versions=versions_of(method),
        platform=machine(),
        command_line=tuple(command_line),
        parameters=_parameters(program),
        requirements=tuple(requirement.name for requirement in program.requirements),
        rules=tuple(rule.name for rule in program.rules),
        actors=program.actors,
        origin=origin,
        number=method_number(method) if method_number(method) != old_number(method) else None,
        objective=tuple(each if isinstance(each, str) else function_name(each) for each in objective),
        objectives=program.judged.names,
        driver=_driven_by(config, reproducible),
        tables=tables,
    )


def _driven_by(config: Config, reproducible: bool) -> DrivenBy | None:
    driver = config.driver
    return None if driver is None else DrivenBy(driver.name, driver.digest, driver.block, reproducible, driver.observe)


def _settings(config: Config) -> dict[str, Any]:
    """Return all settings as JSON has them, except the driver, which has a field of its own."""
    settings = asdict(replace(config, driver=None))
    del settings["driver"]
    settings["search"]["references"] = list(config.search.references)
    return settings


def _parameters(program: Program) -> tuple[Parameter, ...]:
    space = program.space
    numbers = space.kinds.tolist(), space.low.tolist(), space.high.tolist()
    rows = zip(space.names, space.units, *numbers, space.options, strict=True)
    return tuple(Parameter(*row, system=row[0] in space.system) for row in rows)


def machine() -> str:
    """Return the operating system and the kind of processor: `Linux x86_64`."""
    return f"{platform.system()} {platform.machine()}"


def versions_of(method: str = "") -> dict[str, str]:
    """Return the versions of Python and of all packages that may change a result; with those of a search method."""
    entry, plugin = SEARCHERS.get(method), distribution_of(method)
    versions = {"python": PYTHON, LIBM: library(), **dict([plugin] if plugin else ())}
    for name in (*DISTRIBUTIONS, *([entry.package] if entry and entry.package else ())):
        try:
            versions[name] = version(name)
        except PackageNotFoundError:
            versions[name] = "unknown"
    return versions


def changed_versions(manifest: Manifest) -> list[str]:
    """Return names and versions at the start of the run of packages that now have another version: `numba 0.68.1`."""
    now = versions_of(manifest.method)
    return [f"{name} {then}" for name, then in manifest.versions.items() if now.get(name) != then]


# -- read back ---------------------------------------------------------------------------------------------------------


def read_manifest(values: Mapping[str, Any]) -> Manifest:
    """Return the manifest with the fields `values`, as read from JSON.

    Raises:
        ManifestError: a field is missing or of another type, or a setting is outside its limits.
    """
    fitting = {each.name: values[each.name] for each in fields(Manifest) if each.name in values}
    manifest: Manifest = typed(Manifest, fitting, "")
    settings = typed(Config, manifest.settings, "settings")
    for place in (*((table,) for table in LIMITS), *(("search", name) for name in ALWAYS_THERE)):
        if place[0] not in manifest.settings or not set(place[1:]) <= manifest.settings[place[0]].keys():
            raise ManifestError(f"its manifest has no `{'.'.join(('settings', *place))}`")
    for table, limits in LIMITS.items():
        for name, (low, high) in limits.items():
            if not low <= getattr(getattr(settings, table), name) <= high:
                raise ManifestError(f"`settings.{table}.{name}` of its manifest must be from {low:,} to {high:,}")
    _check_words(manifest, settings)
    return manifest


def check_program(manifest: Manifest, program: Program) -> None:
    """Compare a manifest with the program that its text compiles to.

    Raises:
        ManifestError: params or objectives differ, or it has more attempts than the program's random numbers suffice
        for.
    """
    if manifest.objectives != program.judged.names:
        raise ManifestError("`objectives` of its manifest are not those of its scenario")
    if manifest.parameters != _parameters(program):
        raise ManifestError("`parameters` of its manifest are not those of its scenario")
    if manifest.config.simulation.max_attempts > (limit := attempt_limit(program)):
        raise ManifestError(f"`settings.simulation.max_attempts` of its manifest must be at most {limit:,}")


def _check_words(manifest: Manifest, config: Config) -> None:
    """Check fields with a few allowed words, and fields that must agree."""
    search, simulation = config.search, config.simulation
    for place, word, words in (
        ("profile", manifest.profile, tuple(PROFILES)),
        ("settings.search.engine", search.engine, ("batch", "world")),
        ("settings.ga.preset", config.ga.preset, ("cortex", "cortex-literal")),
    ):
        if word not in words:
            raise ManifestError(f"`{place}` of its manifest must be one of {', '.join(words)}")
    if not search.references or not set(search.references) <= set(NAMES):
        raise ManifestError(f"`settings.search.references` of its manifest must name some of {', '.join(NAMES)}")
    if not manifest.objective or len(set(manifest.objective)) < len(manifest.objective):
        raise ManifestError("`objective` of its manifest must name objectives, each once")
    if (manifest.seed, manifest.run) != (search.seed, search.run):
        raise ManifestError("`seed` and `run` of its manifest must be those of `settings.search`")
    if manifest.number not in (None, method_number(manifest.method)):
        raise ManifestError("`number` of its manifest must be that of its method")
    if samples_of(simulation) > MAX_SAMPLES:
        raise ManifestError(f"`settings.simulation` of its manifest has more than {MAX_SAMPLES:,} steps")


LARGEST = MappingProxyType({int: 2**63 - 1, float: sys.float_info.max})


class ManifestError(Signal, ValueError):
    """The manifest was changed from outside: its content is not that of `make_manifest`."""


def typed(kind: Any, value: Any, place: str) -> Any:
    """Return a JSON value converted to the type of a field."""
    origin, arguments = get_origin(kind), get_args(kind)
    if is_dataclass(kind):
        return _table(kind, _of(dict, "a table", value, place), place)
    if origin is tuple:
        rows = _of(list, "a list", value, place)
        return tuple(typed(arguments[0], each, f"{place}[{i}]") for i, each in enumerate(rows))
    if origin is dict:
        table = _of(dict, "a table", value, place)
        return {name: typed(arguments[1], each, f"{place}.{name}") for name, each in table.items()}
    if origin is UnionType:
        return None if value is None else typed(arguments[0], value, place)
    if kind is Any:
        return value
    return _scalar(kind, value, place)


def _table(kind: Any, value: dict[str, Any], place: str) -> Any:
    prefix = f"{place}." if place else ""
    needed = {each.name for each in fields(kind) if each.default is MISSING and each.default_factory is MISSING}
    hints = get_type_hints(kind)
    for name in sorted(needed - value.keys()):
        raise ManifestError(f"its manifest has no `{prefix}{name}`")
    for name in sorted(value.keys() - hints.keys()):
        raise ManifestError(f"its manifest has `{prefix}{name}`, which there is not")
    return kind(**{name: typed(hints[name], each, f"{prefix}{name}") for name, each in value.items()})


def _scalar(kind: type, value: Any, place: str) -> Any:
    """Return a text, a truth value or a finite number of at most 64 bits; a whole number is accepted for any number."""
    if kind is str or kind is bool:
        return _of(kind, "a text" if kind is str else "true or false", value, place)
    kinds = int if kind is int else (int, float)
    if isinstance(value, bool) or not isinstance(value, kinds) or not abs(value) <= LARGEST[kind]:
        raise ManifestError(f"`{place}` of its manifest must be a {'whole ' if kind is int else ''}number")
    return value


def _of(kind: type, what: str, value: Any, place: str) -> Any:
    if not isinstance(value, kind):
        raise ManifestError(f"`{place}` of its manifest must be {what}")
    return value
