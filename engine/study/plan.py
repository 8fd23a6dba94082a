"""The plan of a study: every scenario by every method, many times, with a stream of random numbers for each run.

Run r of a method on a scenario draws from the streams (seed, method, r). Each scenario has a seed of its own
(`with_own_seeds`), so that no two runs of a study share a number: similar scenarios would otherwise be one experiment
counted several times.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

from engine.config import Config
from engine.errors import ArgumentError
from engine.maps import MapFile
from engine.program import Program
from engine.search.manifest import NO_ORIGIN, Manifest, Origin, make_manifest
from engine.search.protocol import DEFAULT_OBJECTIVES, Box
from engine.search.searchers import build_searcher, find_searcher, seek
from engine.search.store import seen_from
from engine.streams import FIELD_BITS

RUNS = 30
"""Minimum number of runs for a statement that a method beats another."""
BASELINE = "random"
MOST_RUNS = 1 << FIELD_BITS.run


class Address(NamedTuple):
    """Identity of a run: row of the plan's scenarios, name of the method, number from 0."""

    scenario: int
    method: str
    run: int


@dataclass(frozen=True)
class Subject:
    """One scenario of a study."""

    name: str
    """Name, unique within the study."""
    file: str
    """Path of the scenario's file."""
    program: Program
    config: Config
    """All settings but the run's number."""
    origin: Origin = NO_ORIGIN
    """Inputs of the compiler in addition to the text."""

    def seen_from(self, folder: Path) -> "Subject":
        """Return the same with all files named as seen from the folder of a study."""
        program, spec = self.program, self.program.road_spec
        if isinstance(spec, MapFile):
            program = replace(program, road_spec=replace(spec, path=seen_from(folder, spec.path)))
        return replace(self, file=seen_from(folder, self.file), program=program, origin=self.origin.seen_from(folder))


@dataclass(frozen=True)
class Task:
    """One run with all data that a worker needs."""

    address: Address
    program: Program
    config: Config
    profile: str
    objective: tuple[str, ...] = DEFAULT_OBJECTIVES


@dataclass(frozen=True)
class Plan:
    """A whole study. Every subject has the same budget."""

    subjects: tuple[Subject, ...]
    methods: tuple[str, ...]
    runs: int = RUNS
    profile: str = "paper"
    objective: tuple[str, ...] = DEFAULT_OBJECTIVES

    @property
    def baseline(self) -> str:
        """Return the method with which all other methods are compared."""
        return BASELINE if BASELINE in self.methods else self.methods[0]

    @property
    def contenders(self) -> tuple[str, ...]:
        return tuple(method for method in self.methods if method != self.baseline)

    @property
    def seeds(self) -> tuple[int, ...]:
        """Return the seed of each scenario."""
        return tuple(subject.config.search.seed for subject in self.subjects)

    @property
    def shares_draws(self) -> bool:
        """Return True if run r of a method has equal random numbers in several scenarios, as in studies of old
        versions.
        """
        return len(set(self.seeds)) < len(self.subjects)

    @property
    def individuals(self) -> int:
        """Return the number of individuals per run."""
        search = self.subjects[0].config.search
        return search.generations * search.population

    def addresses(self) -> Iterator[Address]:
        """Yield every run, ordered by run number, so that a stopped study has about as many runs of each cell."""
        for run in range(self.runs):
            for scenario in range(len(self.subjects)):
                for method in self.methods:
                    yield Address(scenario, method, run)

    def task(self, address: Address) -> Task:
        subject = self.subjects[address.scenario]
        search = replace(subject.config.search, run=address.run, jobs=1, probes=0)
        return Task(address, subject.program, replace(subject.config, search=search), self.profile, self.objective)

    def manifest(self, subject: Subject, method: str) -> Manifest:
        """Return the manifest of a run of this method on this scenario, except for the run's number."""
        program, config, aims = subject.program, subject.config, self.objective
        origin = subject.origin
        return make_manifest(program, config, method, self.profile, subject.file, origin=origin, objective=aims)

    def preset(self, method: str) -> str:
        """Return the preset that a report names after the method; "" if there is none."""
        return find_searcher(method).preset(self.subjects[0].config)


def with_own_seeds(subjects: Sequence[Subject]) -> tuple[Subject, ...]:
    """Return the subjects with consecutive seeds, so that scenario k can be repeated by its own seed."""
    limit = 1 << FIELD_BITS.seed
    return tuple(_with_seed(subject, (subject.config.search.seed + k) % limit) for k, subject in enumerate(subjects))


def _with_seed(subject: Subject, seed: int) -> Subject:
    search = replace(subject.config.search, seed=seed)
    return replace(subject, config=replace(subject.config, search=search))


def check(plan: Plan) -> None:
    """Build each searcher once, and let each driver drive once, to detect errors before the study starts.

    Raises:
        ArgumentError: nothing to do, an unknown or repeated method, an unknown objective, two scenarios of one name,
            too many runs.
        MissingExtraError, PluginError: a method cannot be used.
        ControllerError: a driver does not fit a scenario.
    """
    from engine.search.objectives import objectives

    if not plan.subjects or not plan.methods:
        raise ArgumentError("a study needs a scenario and a method", "name one or more of each")
    for what, names in (("method", plan.methods), ("scenario", [subject.name for subject in plan.subjects])):
        for name in names:
            if list(names).count(name) > 1:
                raise ArgumentError(f"{what}: `{name}` is named twice", "name it once")
    if not 1 <= plan.runs <= MOST_RUNS:
        raise ArgumentError(f"runs: expected 1 to {MOST_RUNS}, got {plan.runs}", "take a number between these")
    for subject in plan.subjects:
        for method in plan.methods:
            searcher = build_searcher(method, Box.of(subject.program.space), subject.config)
            seek(searcher, method, len(objectives(subject.program, plan.objective)))
        _try_driver(subject)


def _try_driver(subject: Subject) -> None:
    driver = subject.config.driver
    if driver is not None and driver.can_drive_new_scenes:
        from engine.driving.decisions import is_reproducible

        is_reproducible(subject.program, subject.config)
