"""What a step on the roads of a file costs, beside one on a grid: two cars that follow their lanes.

Medians of rounds in turn, in processor time, so that both are measured within the same second of the same machine.
"""

import statistics
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cortex_dsl import Scenario, compile_text
from engine import batch
from engine.assessment import take
from engine.sampling import sample, uniform_genomes
from engine.scenes import Scenes
from engine.streams import key_rows
from engine.vocabulary import Method

GRID = "map intersection(ways=4, lanes=2)"
CARS = """
ego = new Car on road, with speed 10 m/s, with behavior FollowLaneBehavior(10 m/s)
new Car on road, with speed 10 m/s, with behavior FollowLaneBehavior(10 m/s)
terminate after 20 s
"""
SCENES = 500
ROUNDS = 7


@dataclass(frozen=True)
class Work:
    """Scenes to be run, and the steps that all actors make in them."""

    scenario: Scenario
    scenes: Scenes
    steps: int

    def cost(self) -> float:
        """Of a step of one actor [s]."""
        begun = time.process_time()
        batch.simulate(self.scenario.program, self.scenes, self.scenario.config.simulation)
        return (time.process_time() - begun) / self.steps


def shares(paths: Sequence[Path]) -> tuple[float, Mapping[str, float]]:
    """The cost of a step on the grid [s], and by file how many times that a step on its roads costs."""
    grid, works = _work(GRID), {path.name: _work(f'map opendrive("{path.resolve()}")') for path in paths}
    bases: list[float] = []
    ratios: dict[str, list[float]] = {name: [] for name in works}
    for _ in range(ROUNDS):
        bases.append(grid.cost())
        for name, work in works.items():
            ratios[name].append(work.cost() / bases[-1])
    return statistics.median(bases), {name: statistics.median(each) for name, each in ratios.items()}


def _work(road: str) -> Work:
    scenario = compile_text(f"{road}{CARS}")
    keys = key_rows(1, Method.SAMPLE, 0, 0, range(2 * SCENES))
    config = replace(scenario.config.simulation, max_attempts=1000)
    scenes = sample(scenario.program, uniform_genomes(scenario.program.space, keys), keys, config)
    scenes = take(scenes, np.flatnonzero(scenes.valid)[:SCENES])
    outcomes = batch.simulate(scenario.program, scenes, scenario.config.simulation)
    return Work(scenario, scenes, 2 * int(outcomes.steps.sum()))
