"""Decisions of controllers, stored with a run so that its scenes are driven again without them.

`Recorder` wraps a driver during a search and stores its decisions in every collision. `RecordedActions` replaces the
driver afterwards.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from engine.assessment import take
from engine.batch import simulate
from engine.config import ActorDriver, Config, ContactConfig, SimulationConfig
from engine.control import numbers_decided
from engine.driving.blocks import BLOCK, Driven
from engine.driving.names import driver_hint
from engine.errors import ControllerError
from engine.host import samples_of
from engine.outcomes import Assessment
from engine.program import Program
from engine.sampling import draw_genomes, sample
from engine.scenes import Scenes
from engine.streams import key_rows, scene_in_words
from engine.tables import Floats, Ints
from engine.vocabulary import RECORDS, STORED, Method

DEFAULTS = SimulationConfig()
CONTACT = ContactConfig()
MOST_KEPT = 5_000
"""Maximum number of scenes of a run whose decisions are stored, about 2 kB each."""
MOST_RECENT = 20_000
"""Maximum number of scenes whose decisions are held until the end of their generation."""


def name_of(key: Ints, genome: Floats) -> bytes:
    """Return the identity of a scene: the bytes of its stream key and its genome.

    The key alone is not enough, because several genomes are tried with the same random numbers.
    """
    return key.astype("<i8").tobytes() + genome.astype("<f8").tobytes()


def _is_run(done: Driven, judged: Assessment) -> bool:
    """Return True if a scene that is driven again, row 0, has the results of an assessment."""
    names, pair = ("min_distance", "min_distance_time", "max_closing_speed"), int(judged.pair[0])
    pairs = [(done.outcomes.end_time[0], judged.end_time[0])]
    if pair >= 0:
        pairs += [(getattr(done.outcomes, name)[0, pair], getattr(judged, name)[0]) for name in names]
    return bool(done.scenes.valid[0]) and all(np.array_equal(one, other, equal_nan=True) for one, other in pairs)


class KeptCase(Protocol):
    """Scene of a search and its place among the evaluations."""

    @property
    def key(self) -> tuple[int, ...]: ...
    @property
    def genome(self) -> tuple[float, ...]: ...
    @property
    def row(self) -> int: ...
    @property
    def rollout(self) -> int: ...
    @property
    def lost(self) -> bool: ...


def _name(case: KeptCase) -> bytes:
    return name_of(np.array(case.key), np.array(case.genome))


@dataclass(frozen=True, eq=False)
class RecordedActions:
    """Decisions of a controller in some scenes, as a driver that replaces it."""

    actions: Mapping[bytes, Floats]
    """Decisions (turns, numbers) by `name_of` their scenes."""
    name: str = ""
    """Name of the controller that made the decisions."""
    digest: str = ""
    block: int = BLOCK
    observe: str = RECORDS
    can_drive_new_scenes: bool = False

    def without_history(self) -> "RecordedActions":
        """Return this object: it has no history."""
        return self

    def has(self, key: Ints, genome: Floats) -> bool:
        """Return True if the decisions of a scene are stored."""
        return name_of(key, genome) in self.actions

    def drive(
        self,
        program: Program,
        scenes: Scenes,
        config: SimulationConfig = DEFAULTS,
        contact: ContactConfig = CONTACT,
        jobs: int = 1,
        measures: int = STORED,
    ) -> Driven:
        """Drive scenes whose actions are stored.

        Raises:
            ControllerError: the actions of a valid scene are not stored.
        """
        actions = np.zeros((len(scenes), samples_of(config) + 1, numbers_decided(program.controls)))
        for row in np.flatnonzero(scenes.valid).tolist():
            recorded = self.actions.get(name_of(scenes.keys[row], scenes.genomes[row]))
            if recorded is None or recorded.shape[1:] != actions.shape[2:] or not len(recorded):
                raise ControllerError(f"what `{self.name}` decided in this scene is not kept", driver_hint(self.name))
            actions[row] = recorded[np.minimum(np.arange(actions.shape[1]), len(recorded) - 1)]
        scenes = replace(scenes, actions=actions)
        return Driven(scenes, simulate(program, scenes, config, jobs, contact, measures=measures))


@dataclass(frozen=True, eq=False)
class Recorder:
    """A driver whose decisions in collisions and in the worst cases are stored."""

    driver: ActorDriver
    recorded: dict[bytes, Floats] = field(default_factory=dict)
    """Decisions that `take` has not returned yet."""
    known: set[bytes] = field(default_factory=set)
    """Scenes whose decisions are or were stored."""
    recent: dict[bytes, Floats] = field(default_factory=dict)
    """Decisions in the latest scenes, stored or not."""
    failures: list[str] = field(default_factory=list)
    """Messages of the controller's failures."""

    @property
    def name(self) -> str:
        return self.driver.name

    @property
    def digest(self) -> str:
        return self.driver.digest

    @property
    def block(self) -> int:
        return self.driver.block

    @property
    def observe(self) -> str:
        return self.driver.observe

    @property
    def can_drive_new_scenes(self) -> bool:
        return self.driver.can_drive_new_scenes

    def without_history(self) -> "Recorder":
        """Return a recorder with the same storage, whose driver has an empty history."""
        return replace(self, driver=self.driver.without_history())

    def has(self, key: Ints, genome: Floats) -> bool:
        """Return True if a scene can be driven."""
        return self.driver.has(key, genome)

    def drive(
        self,
        program: Program,
        scenes: Scenes,
        config: SimulationConfig = DEFAULTS,
        contact: ContactConfig = CONTACT,
        jobs: int = 1,
        measures: int = STORED,
    ) -> Driven:
        """Drive all valid scenes, and store the decisions of those that collide."""
        done: Driven = self.driver.drive(program, scenes, config, contact, jobs, measures)
        self.failures.extend(done.remarks)
        for row in np.flatnonzero(done.scenes.valid).tolist():
            key = name_of(scenes.keys[row], scenes.genomes[row])
            self._note(done, row)
            if done.outcomes.collided[row] and len(self.known) < MOST_KEPT:
                self._keep(key)
        self._forget(MOST_RECENT)
        return done

    def record_worst(self, cases: Sequence[KeptCase]) -> None:
        """Store the decisions of these of the latest scenes, whatever their outcome."""
        for case in cases:
            self._keep(_name(case))
        self._forget(MOST_KEPT)

    def _forget(self, most: int) -> None:
        for key in [*self.recent][: max(0, len(self.recent) - most)]:
            del self.recent[key]

    def record_missing(self, program: Program, config: Config, rollouts: Assessment, cases: Sequence[KeptCase]) -> None:
        """Drive those cases of a search's rollouts again whose decisions are no longer known, as later scenes
        displaced them. A driver that fails now, or drives differently, is noted.
        """
        for case in cases:
            if case.lost or _name(case) in self.known:
                continue
            scene = sample(program, np.array([case.genome]), np.array([case.key], dtype=np.int64), config.simulation)
            try:
                done: Driven = self.driver.drive(program, scene, config.simulation, config.contact)
            except ControllerError as error:
                self.failures.append(error.message)
                continue
            self.failures.extend(done.remarks)
            judged = take(rollouts, (np.array([case.row]), np.array([case.rollout])))
            if _is_run(done, judged):
                self._note(done, 0)
                self.record_worst([case])
            elif done.scenes.valid.any():
                self.failures.append(f"`{self.name}` drives otherwise in {scene_in_words(case.key)} than it did")

    def _note(self, done: Driven, row: int) -> None:
        key = name_of(done.scenes.keys[row], done.scenes.genomes[row])
        self.recent.setdefault(key, done.scenes.actions[row, : int(done.outcomes.steps[row]) + 1].copy())

    def _keep(self, key: bytes) -> None:
        if key in self.recent and key not in self.known:
            self.known.add(key)
            self.recorded[key] = self.recent[key]

    def take(self) -> dict[bytes, Floats]:
        """Return the decisions that were stored since the last call, and clear them."""
        taken = dict(self.recorded)
        self.recorded.clear()
        return taken


PROBES = 8
"""Number of scenes that are driven twice to check whether a driver repeats itself."""


def is_reproducible(program: Program, config: Config) -> bool:
    """Return True if the driver decides identically in some scenes that it drives twice. Its decisions may still depend
    on the other scenes of their block.

    Raises:
        ControllerError: it cannot drive.
    """
    driver = config.driver
    if driver is None:
        return True
    drawn = (_probes(program, config, count) for count in (PROBES, 8 * PROBES, 64 * PROBES))
    scenes = next((each for each in drawn if each.valid.any()), None)
    if scenes is None:  # nor does a run have valid scenes
        return True
    chosen = take(scenes, np.flatnonzero(scenes.valid)[:PROBES])
    once, again = (
        driver.without_history().drive(program, chosen, config.simulation, config.contact).scenes for _ in range(2)
    )
    return bool(np.array_equal(once.actions, again.actions) and np.array_equal(once.verdict, again.verdict))


def _probes(program: Program, config: Config, count: int) -> Scenes:
    keys = key_rows(config.search.seed, Method.SAMPLE, 0, 0, range(count))
    return sample(program, draw_genomes(program.space, keys), keys, config.simulation)
