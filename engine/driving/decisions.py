"""What controllers decided, kept with a run: its scenes are driven again without them.

`Recorder` stands before a controller while a search goes on, and keeps what it decided in every collision.
`KeptActions` stands in its place afterwards.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from engine.batch import simulate
from engine.config import Config, ContactConfig, Drives, SimulationConfig
from engine.control import numbers_decided
from engine.driving.blocks import BLOCK, Driven
from engine.driving.names import how_again
from engine.errors import ControllerError
from engine.host import samples_of
from engine.program import Program
from engine.sampling import sample
from engine.scenes import Scenes
from engine.search.ranking import Case
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import RECORDS

DEFAULTS = SimulationConfig()
CONTACT = ContactConfig()
MOST_KEPT = 5_000
"""Scenes of which a run keeps what was decided; some 2 kB each."""


def name_of(key: Ints, genome: Floats) -> bytes:
    """What tells a scene from all others: its key decides its random numbers, with which several genomes are tried."""
    return key.astype("<i8").tobytes() + genome.astype("<f8").tobytes()


@dataclass(frozen=True, eq=False)
class KeptActions:
    """What a controller decided in some scenes, in its place: they are driven without it."""

    actions: Mapping[bytes, Floats]
    """(turns, numbers) by `name_of` their scenes."""
    name: str = ""
    """Of the controller that decided …"""
    digest: str = ""
    block: int = BLOCK
    observe: str = RECORDS
    anew: bool = False

    def drive(
        self,
        program: Program,
        scenes: Scenes,
        config: SimulationConfig = DEFAULTS,
        contact: ContactConfig = CONTACT,
        jobs: int = 1,
    ) -> Driven:
        """Drive scenes whose actions are kept.

        Raises:
            ControllerError: those of a valid one are not.
        """
        actions = np.zeros((len(scenes), samples_of(config) + 1, numbers_decided(program.controls)))
        for row in np.flatnonzero(scenes.valid).tolist():
            kept = self.actions.get(name_of(scenes.keys[row], scenes.genomes[row]))
            if kept is None or kept.shape[1:] != actions.shape[2:] or not len(kept):
                raise ControllerError(f"what `{self.name}` decided in this scene is not kept", how_again(self.name))
            actions[row] = kept[np.minimum(np.arange(actions.shape[1]), len(kept) - 1)]
        scenes = replace(scenes, actions=actions)
        return Driven(scenes, simulate(program, scenes, config, jobs, contact))


@dataclass(frozen=True, eq=False)
class Recorder:
    """A driver whose decisions are kept: those of collisions, and of the worst cases."""

    driver: Drives
    kept: dict[bytes, Floats] = field(default_factory=dict)
    """What has not been taken yet."""
    known: set[bytes] = field(default_factory=set)
    """Scenes of which something is, or was, kept."""
    failures: list[str] = field(default_factory=list)
    """Of the controller, in words."""

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
    def anew(self) -> bool:
        return self.driver.anew

    def drive(
        self,
        program: Program,
        scenes: Scenes,
        config: SimulationConfig = DEFAULTS,
        contact: ContactConfig = CONTACT,
        jobs: int = 1,
    ) -> Driven:
        """Drive all valid scenes, and keep what was decided in collisions."""
        done: Driven = self.driver.drive(program, scenes, config, contact, jobs)
        self.failures.extend(done.remarks)
        self._keep(done, done.outcomes.collided & scenes.valid, MOST_KEPT)
        return done

    def keep_worst(self, program: Program, config: SimulationConfig, cases: Sequence[Case]) -> None:
        """Drive cases for the sake of what is decided in them, whatever they came to; not those over which it fails."""
        for case in cases:
            if case.lost or name_of(np.array(case.key), np.array(case.genome)) in self.known:
                continue
            scene = sample(program, np.array([case.genome]), np.array([case.key], dtype=np.int64), config)
            self._keep(self.driver.drive(program, scene, config, CONTACT), scene.valid, MOST_KEPT + len(cases))

    def _keep(self, done: Driven, chosen: Bools, most: int) -> None:
        for row in np.flatnonzero(chosen).tolist():
            key = name_of(done.scenes.keys[row], done.scenes.genomes[row])
            if key not in self.known and len(self.known) < most:
                self.known.add(key)
                self.kept[key] = done.scenes.actions[row, : int(done.outcomes.steps[row]) + 1].copy()

    def take(self) -> dict[bytes, Floats]:
        """Hand out what has been kept since the last time."""
        taken = dict(self.kept)
        self.kept.clear()
        return taken


def is_reproducible(program: Program, draw: Callable[[int], Scenes], config: Config) -> bool:
    """Whether who drives does so alike in a block of scenes that is given twice; `draw` makes driven ones."""
    driver = config.driver
    if driver is None:
        return True
    scenes = draw(driver.block)
    again: Driven = driver.drive(program, scenes, config.simulation, config.contact)
    return bool(np.array_equal(scenes.actions, again.scenes.actions))
