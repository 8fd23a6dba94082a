"""How much more an environment costs than the batch host, a step and a scene, and how much memory a scene takes.

    python -m benchmarks.environment [LANES] [FILE]

The driver is a constant, so that what is measured is the stepping; both run the same scenes on one thread, and come to
the same bits, which is asserted.
"""

import sys
import time
from dataclasses import fields

import numpy as np

import cortex_dsl as cx
from engine import batch
from engine.driving import drive

FILE = "examples/own_driver/crossing.scn"


def main(lanes: int = 4096, file: str = FILE) -> None:
    scenario = cx.load(file)
    scenes = scenario.sample(lanes, seed=1)
    decided = np.tile([0.3, 0.0, 0.0], (lanes, 1))

    def constant(seen: np.ndarray) -> np.ndarray:
        return decided[: len(seen)]

    driven = drive(scenario.program, scenes, constant, scenario.config.simulation, block=lanes)
    begun = time.process_time()
    driven = drive(scenario.program, scenes, constant, scenario.config.simulation, block=lanes)
    stepped = time.process_time() - begun
    batch.simulate(scenario.program, driven.scenes, scenario.config.simulation)
    begun = time.process_time()
    outcomes = batch.simulate(scenario.program, driven.scenes, scenario.config.simulation)
    at_once = time.process_time() - begun
    for field in fields(outcomes):
        ours, theirs = getattr(driven.outcomes, field.name), getattr(outcomes, field.name)
        assert np.array_equal(ours, theirs, equal_nan=ours.dtype.kind == "f"), field.name
    steps = int(outcomes.steps.sum())
    environment = scenario.environment(lanes)
    print(f"{file}, {lanes:,} scenes, {steps:,} steps")
    print(
        f"  stepped {steps / stepped:,.0f} steps a second, batch {steps / at_once:,.0f}: {stepped / at_once:.2f} times"
    )
    print(f"  {environment.nbytes / lanes / 1000:.1f} kB a scene")


if __name__ == "__main__":
    main(*(int(word) if word.isdigit() else word for word in sys.argv[1:]))  # type: ignore[arg-type]
