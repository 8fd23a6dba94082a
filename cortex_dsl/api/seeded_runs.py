"""Runs of a file by successive seeds, each of which a command repeats.

Run i of seed S is that of `cortexc FILE --seed N` with N = S * SEEDS + i - 1. A file that leaves nothing to chance has
one run.
"""

from dataclasses import dataclass, replace

import numpy as np

from cortex_dsl.api.limits import MOST_RUNS
from cortex_dsl.api.scenario import NO_SCENE, Scenario
from cortex_dsl.api.scenario_mistakes import failure_of
from cortex_dsl.diagnostics import CompileError
from engine.dependence import leaves_nothing_to_chance
from engine.driving.blocks import Driver
from engine.errors import ControllerError
from engine.outcomes import Outcomes
from engine.scenes import Scenes
from engine.streams import single_keys
from engine.tables import Bools, Ints
from engine.vocabulary import EndReason, Verdict

BLOCK = 256
"""Runs between two looks at a probability, and scenes in one query to a driver by default."""
SEEDS = MOST_RUNS
"""Number of seeds that belong to one seed of a test."""
SEED_LIMIT = (2**63 - 1) // SEEDS - 1
"""Largest seed of a test."""


@dataclass(frozen=True)
class RunBlock:
    """Finished runs in a row."""

    numbers: Ints
    """(n,) Numbers of the runs, from 1."""
    seeds: Ints | None
    scenes: Scenes
    outcomes: Outcomes
    failures: tuple[ControllerError, ...] = ()

    def seed(self, row: int) -> int | None:
        return None if self.seeds is None else int(self.seeds[row])


class SeededRuns:
    """Runs of one file from one seed on."""

    def __init__(self, scenario: Scenario, seed: int, driver: Driver | None, jobs: int) -> None:
        """Raises ControllerError: the driver does not fit the controllers of the file."""
        self.scenario, self.first, self.jobs = scenario, seed * SEEDS, jobs
        self.kept = leaves_nothing_to_chance(scenario.program)
        """True if the file leaves nothing to chance."""
        self.driver = None
        """Driver with an empty history; None if the file has no controller."""
        if driver is not None and scenario.program.controls:
            from engine.driving.controllers import controllers_of

            controllers_of(scenario.program, driver.given)
            self.driver = driver.without_history()

    def seed(self, index: int) -> int | None:
        """Return the seed of the run `index`, counted from 0."""
        return None if self.kept else self.first + index

    def scenes(self, index: int, count: int, *, hopeful: bool) -> Scenes:
        """Draw the scenes of the runs from `index` on, without decisions of a driver."""
        scenario = self.scenario
        if self.kept:
            stream = scenario.program.settings.stream
            bare = replace(scenario, config=replace(scenario.config, driver=None))
            return bare.scene_of_seed(None if stream else 0)
        return draw_scenes(scenario, self.first + np.arange(index, index + count), self.jobs, hopeful=hopeful)

    def block(self, index: int, count: int, *, hopeful: bool) -> RunBlock:
        """Draw and run the scenes from `index` on; `hopeful`: some scene is known to exist.

        Raises:
            ControllerError: the driver fails everywhere.
        """
        config, scenes = self.scenario.config, self.scenes(index, count, hopeful=hopeful)
        numbers = np.arange(index + 1, index + count + 1)
        seeds = None if self.kept else self.first + numbers - 1
        if self.driver is None:
            return RunBlock(numbers, seeds, scenes, self.scenario.simulate(scenes, jobs=self.jobs))
        done = self.driver.drive(self.scenario.program, scenes, config.simulation, config.contact, self.jobs)
        return RunBlock(numbers, seeds, done.scenes, done.outcomes, done.failures)

    def check(self, block: RunBlock) -> None:
        """Check that no run of a block met a mistake of the file.

        Raises:
            CompileError: one did.
        """
        compiled = self.scenario.compiled
        for row in np.flatnonzero(block.outcomes.verdict == Verdict.ERROR)[:1].tolist():
            diagnostic = failure_of(compiled, self.scenario.config.simulation, block.scenes, block.outcomes, row)
            if diagnostic is None:
                raise RuntimeError(f"run {block.numbers[row]} of {compiled.source.name} failed")
            raise CompileError(compiled.source, [diagnostic])


def contacts_of_ego(outcomes: Outcomes) -> Bools:
    """Return (n,) True where the ego touched somebody or a building."""
    return outcomes.collided | (outcomes.end_reason == EndReason.BUILDING)


# -- scenes by their seeds ---------------------------------------------------------------------------------------------


def draw_scenes(scenario: Scenario, seeds: Ints, jobs: int = 1, *, hopeful: bool = False) -> Scenes:
    """Return the scene of `cortexc FILE --seed N` for each of the seeds (n,); it is not valid if no genome allows one.

    If no first genome allows a scene, only the first seed tries further ones, unless `hopeful`: some scene is known to
    exist.
    """
    from engine.feasibility import remembered
    from engine.sampling import draw_genomes, sample

    program, config = scenario.program, scenario.config.simulation
    scenes: Scenes | None = None
    waiting, doubtful = np.arange(len(seeds)), False
    for key in single_keys(program, 0):
        keys = np.repeat(key, len(waiting), axis=0)
        keys[:, 0] = seeds[waiting]
        drawn = sample(program, draw_genomes(program.space, keys), keys, config, jobs)
        failed = np.isin(drawn.verdict, NO_SCENE)
        if scenes is None:
            scenes, doubtful = drawn, bool(failed.all()) and not hopeful
            failed[1:] &= not doubtful
        else:
            _overwrite(scenes, drawn, waiting)
        waiting = waiting[failed]
        if not len(waiting) or (doubtful and remembered(program).infeasible):
            break
    assert scenes is not None
    if doubtful and scenes.verdict[0] not in NO_SCENE and len(seeds) > 1:
        return draw_scenes(scenario, seeds, jobs, hopeful=True)
    return scenes


def _overwrite(scenes: Scenes, drawn: Scenes, rows: Ints) -> None:
    """Write drawn scenes into some rows."""
    for name in Scenes.__dataclass_fields__:
        if name != "actions":
            getattr(scenes, name)[rows] = getattr(drawn, name)
