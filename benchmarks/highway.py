"""How fast are our environments beside highway-env's? `python -m benchmarks.highway [LANES]`

Simulated vehicle-seconds per second of processor time on one thread, in turns: two cars each, equal steps, no picture,
default observations, an action that costs nothing. highway-env is installed once, in an environment of its own.
"""

import subprocess
import sys
import time

import numpy as np

import cortex_dsl as cx
from benchmarks.environment import steps_of
from benchmarks.validation.environments import HERE, python_of, set_up

FILE = "examples/own_driver/crossing.scn"
NAME = "highway"
EVERY = 0.1
"""From one action to the next, as `FILE` has it [s]."""
CARS = 2
SECONDS = 5.0
TURNS = 3


def main(lanes: int = 4096) -> None:
    set_up([NAME], sys.executable, print)
    scenario = cx.load(FILE)
    ours, theirs = [], []
    for _ in range(TURNS):
        ours.append(rate(scenario, lanes))
        theirs.append(rate_of_highway(scenario.config.simulation.time_step))
    mine, its = max(ours), max(theirs)
    print(f"vehicle-seconds a second: {lanes:,} lanes {mine:,.0f}, highway-env {its:,.0f}: {mine / its:,.0f} times")


def rate(scenario: cx.Scenario, lanes: int) -> float:
    """Of an environment in its stride."""
    environment = scenario.environment(lanes)
    environment.reset(seed=1)
    actions = np.tile([0.3, 0.0, 0.0], (lanes, 1))
    steps, begun = 0, time.process_time()
    while (spent := time.process_time() - begun) < SECONDS:
        steps += steps_of(environment, actions)
    return CARS * scenario.config.simulation.time_step * steps / spent


def rate_of_highway(time_step: float) -> float:
    script = HERE / "checkers" / "drive_highway.py"
    command = [str(python_of(NAME)), str(script), str(time_step), str(EVERY), str(SECONDS)]
    return float(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
