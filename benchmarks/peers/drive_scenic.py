"""Rates of Scenic with its Newtonian simulator on a file: `python drive_scenic.py FILE.scenic STEP SECONDS`.

Prints one JSON object of rates per second of processor time. Runs in an environment of its own and imports nothing of
ours.
"""

# pyright: reportMissingImports=false, reportAttributeAccessIssue=false

import json
import random
import sys
import time

import numpy as np
import scenic

MOST_STEPS = 400


def main(file: str, step: str, seconds: str) -> None:
    """Draw scenes and run them for so long [s], at steps of `step` [s]."""
    random.seed(1)
    np.random.seed(1)
    scenario = scenic.scenarioFromFile(file, mode2D=True)
    simulator = scenario.getSimulator()
    scenes, steps, vehicles, drawing, driving = 0, 0, 0, 0.0, 0.0
    while drawing + driving < float(seconds):
        begun = time.process_time()
        scene, _ = scenario.generate(maxIterations=1_000_000)
        drawn = time.process_time()
        simulation = simulator.simulate(scene, maxSteps=MOST_STEPS, timestep=float(step))
        drawing, driving = drawing + drawn - begun, driving + time.process_time() - drawn
        scenes, steps, vehicles = scenes + 1, steps + simulation.currentTime, len(scene.objects)
    rates = {"scenes": scenes / drawing, "driven": vehicles * steps * float(step) / driving}
    print(json.dumps(rates | {"runs": scenes / (drawing + driving)}))


if __name__ == "__main__":
    main(*sys.argv[1:])
