"""How many more collisions does the step of 0.05 s show than one of 0.0025 s, and is it the motion or the driver?

    python -m benchmarks.step_bias --scenes 20000 [--jobs N] [--json] [FILES...]

The same random scenes of each file (by default the two-car examples) three times: as runs are made, with a step of
0.05 s; with motion in steps of 0.0025 s and drivers who act every 0.05 s as before; and all at 0.0025 s. The first two
differ by integration and by the straight lines between samples alone (`motion`), the last two by how often a driver
looks and acts (`driver`). Differences are paired: a scene counts where one run collides and the other does not. They
are given as shares of the collisions of the finest run, with the 95 % interval of two paired shares (Fleiss, Levin,
Paik, "Statistical Methods for Rates and Proportions", 3rd ed., section 13.1).
"""

import argparse
import json
import math
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cortex_dsl import Scenario, load
from engine.assessment import take
from engine.batch import simulate
from engine.sampling import sample, uniform_genomes
from engine.scenes import Scenes
from engine.streams import key_rows
from engine.vocabulary import Method

FINE = 0.0025
"""[s]"""
EXAMPLES = sorted((Path(__file__).parent.parent / "examples").glob("*.scn"))
NORMAL_95 = 1.959964


@dataclass(frozen=True)
class Difference:
    """How many more collisions one way of running shows than another, on the same scenes."""

    gained: int
    """Scenes in which only the one collides …"""
    lost: int
    """… and only the other."""
    share: float
    """Of the collisions of the finest run: gained - lost …"""
    low: float
    """… and its 95 % interval."""
    high: float


@dataclass(frozen=True)
class Bias:
    """What a step does to the collisions of one file."""

    file: str
    scenes: int
    collisions: int
    """Of the finest run."""
    motion: Difference
    driver: Difference
    both: Difference


def bias(file: Path, count: int, jobs: int = 1, seed: int = 0) -> Bias:
    """Run `count` valid random scenes of a file at three steps."""
    scenario = load(file)
    scenes, step = valid_scenes(scenario, count, seed), scenario.config.simulation.time_step
    fine = replace(scenario.config.simulation, time_step=FINE)
    usual = simulate(scenario.program, scenes, scenario.config.simulation, jobs).collided
    held = simulate(scenario.program, scenes, fine, jobs, hold=round(step / FINE)).collided
    finest = simulate(scenario.program, scenes, fine, jobs).collided
    total = int(finest.sum())
    return Bias(
        file=file.stem,
        scenes=len(scenes),
        collisions=total,
        motion=difference(usual, held, total),
        driver=difference(held, finest, total),
        both=difference(usual, finest, total),
    )


def difference(one: NDArray[np.bool_], other: NDArray[np.bool_], collisions: int) -> Difference:
    """The paired difference of two sets of runs, as a share of a number of collisions."""
    gained, lost = int((one & ~other).sum()), int((other & ~one).sum())
    error = math.sqrt(max(gained + lost - (gained - lost) ** 2 / len(one), 0.0))
    whole = max(collisions, 1)
    return Difference(
        gained,
        lost,
        (gained - lost) / whole,
        (gained - lost - NORMAL_95 * error) / whole,
        (gained - lost + NORMAL_95 * error) / whole,
    )


def valid_scenes(scenario: Scenario, count: int, seed: int) -> Scenes:
    """Valid scenes of uniformly random genomes."""
    keys = key_rows(seed, Method.SAMPLE, 0, 0, range(2 * count + 50))
    scenes = sample(scenario.program, uniform_genomes(scenario.program.space, keys), keys, scenario.config.simulation)
    return take(scenes, np.flatnonzero(scenes.valid)[:count])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--scenes", type=int, default=20_000)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    found = [bias(file, options.scenes, options.jobs, options.seed) for file in options.files or EXAMPLES]
    if options.json:
        print(json.dumps([asdict(each) for each in found]))
        return
    for each in found:
        print(f"{each.file:26} {each.scenes:6} scenes, {each.collisions:5} collisions at {FINE} s", end="")
        for name in ("motion", "driver", "both"):
            part: Difference = getattr(each, name)
            print(f"; {name} {part.share:+.2%} [{part.low:+.2%}, {part.high:+.2%}]", end="")
        print()


if __name__ == "__main__":
    main()
